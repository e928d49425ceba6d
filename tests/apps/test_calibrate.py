"""`fascicle calibrate`: from a CSV to a folder, in one fit of a small synthetic record."""

import contextlib
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fascicle as fs
from fascicle import records, units
from fascicle.cli import main
from fascicle.files import provenance


TEN = "kim2021_slenderness_10"
FACTORS = ["youngs_modulus_factor", "collapse_moment_factor", "hinge_stiffness_factor",
           "hinge_stiffness_slope", "transition_rate"]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a synthetic record of the example, d.csv, that names no rest length."""
    folder = tmp_path_factory.mktemp("calibrate")
    muscle = fs.example(TEN)
    P = np.linspace(0, 413.7e3, 5)
    eps = np.linspace(0, float(muscle.free_strain(P[-1])), 24)
    force = np.asarray(muscle.force(P[:, None], eps))
    noise = 0.005 * force.max() * np.random.default_rng(0).normal(size=force.shape)
    record = records.Record.of(P[:, None], eps, force + noise, synthetic=True)
    records.write(record, folder / "d.csv")
    return folder


@pytest.fixture(scope="module")
def ran(folder):
    """What the paper's tuning prints for a user, and for a program; from one start, for speed."""

    def run(*arguments):
        out, err = io.StringIO(), io.StringIO()
        with (
            contextlib.chdir(folder),
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
            pytest.raises(SystemExit) as end,
        ):
            main(["calibrate", *arguments])
        return end.value.code, out.getvalue(), err.getvalue()

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FASCICLE_NO_CACHE", "1")
        patch.setenv("COLUMNS", "100")
        arguments = ("d.csv", "--muscle", TEN, "--fit", "tuning", "--starts", "1")
        text = run(*arguments)
        program = run(*arguments, "--no-profile", "--json")
    return text, program


def test_the_verdict_takes_ten_lines(ran, folder):
    (code, out, err), program = ran
    assert (code, err) == (0, "") and len(out.splitlines()) <= 10
    verdict = json.loads(program[1])["verdict"]
    assert verdict["fit"] == "noise" and 0.004 < verdict["relative_rmse"] < 0.007
    assert set(verdict["undetermined"]) <= set(FACTORS)
    names = {path.name for path in (folder / "calibrated-d").iterdir()}
    assert names == {
        "muscle.toml", "report.html", "curves.csv",
        *(f"{name}.{kind}" for name in ("fit", "profiles", "readings", "residuals")
          for kind in ("png", "svg")),
    }  # fmt: skip


def test_curves_have_units_and_contain_the_fit(ran, folder):
    rows = (folder / "calibrated-d/curves.csv").read_text().splitlines()
    assert rows[0] == "pressure [kPa],strain [-],force [N],low [N],high [N]"
    table = np.genfromtxt(rows[1:], delimiter=",")
    pressure, strain, force, low, high = table[np.all(np.isfinite(table), axis=1)].T
    assert np.all((low < force) & (force < high))
    muscle = fs.load(folder / "calibrated-d/muscle.toml")
    pulls = force > 1.0
    expected = muscle.force(pressure * 1e3, strain)
    np.testing.assert_allclose(force[pulls], np.asarray(expected)[pulls], rtol=2e-3)


def test_the_folder_holds_the_muscle_that_was_fitted(ran, folder):
    _, (code, out, err) = ran
    assert (code, err) == (0, "")
    found, path = json.loads(out), folder / "calibrated-d/muscle.toml"
    muscle = fs.load(path)
    told = provenance(path)
    # the file is rounded far below what is known; the JSON has all digits
    rate = found["parameters"]["transition_rate"]
    off = abs(rate["value"] - float(muscle.tuning.transition_rate))
    assert off <= 0.01 * (rate["high"] - rate["low"])
    assert [one["name"] for one in told["parameter"]] == FACTORS
    assert told["synthetic"] and told["method"] == "tuning"
    assert "Synthetic" in (folder / "calibrated-d/report.html").read_text(encoding="utf-8")


def test_the_fitted_muscle_makes_bundles(ran, fascicle, folder):
    path = str(folder / "calibrated-d/muscle.toml")
    code, out, _ = fascicle("bundle", path, "--units", "1,4", "-p", "200kPa,200kPa", "-s", "0.02",
                            "--json")  # fmt: skip
    assert code == 0
    five = 5 * float(fs.load(path).force(200e3, 0.02))
    assert json.loads(out)["force"][0][0] == pytest.approx(five, rel=1e-9)
    assert fascicle("bundle", path, "--units", "1,x", "-p", "200kPa")[0] == 2


@pytest.mark.slow
def test_the_fitted_muscle_makes_designs(ran, fascicle, folder):
    path = str(folder / "calibrated-d/muscle.toml")
    load = ("--mass", "10kg", "--stroke", "10mm", "--supply", "400kPa")
    code, out, _ = fascicle("design", path, "--units", "1,4", *load, "--json")
    assert code == 0
    assert json.loads(out)["case_force"] == [pytest.approx(98.0665)]


def test_json_has_the_keys_of_its_contract_in_their_order(ran):
    found = json.loads(ran[1][1])
    contract = ["rmse", "relative_rmse", "points", "censored", "status", "parameters"]
    assert list(found)[:6] == contract
    assert (found["points"], found["censored"]) == (5 * 24, 0)
    assert found["status"].startswith("converged")
    assert list(found["parameters"]) == FACTORS
    for one in found["parameters"].values():
        assert list(one) == ["value", "low", "high", "identifiable", "bound"]
        assert one["low"] < one["value"] < one["high"] and isinstance(one["identifiable"], bool)
    # the noise was 0.5 % of the largest force
    assert 0.004 < found["relative_rmse"] < 0.007


def test_json_alone_writes_nothing(ran, folder):
    assert sorted(path.name for path in folder.iterdir()) == ["calibrated-d", "d.csv"]


def test_the_plain_command_finds_the_fit_and_tells_why(fascicle, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    muscle = fs.Muscle(0.2, 11e-3, 2e-3, np.radians(27), "latex")
    P, eps = np.linspace(2.5e5, 6e5, 6), np.linspace(0, 0.08, 8)
    force = np.asarray(muscle.force(P[:, None], eps))
    bow = 6 * np.sin(2 * np.pi * eps / 0.08)  # what no constant follows
    noise = np.random.default_rng(0).normal(size=force.shape)
    record = records.Record.of(P[:, None], eps, force + bow + noise, synthetic=True)
    records.write(record, tmp_path / "d.csv")
    sizes = ("--length", "200mm", "--outer-radius", "10mm", "--wall-thickness", "2mm",
             "--braid-angle", "29deg", "--material", "latex", "--no-profile")  # fmt: skip
    assert fascicle("calibrate", "d.csv", *sizes)[0] == 0
    kept = provenance(tmp_path / "calibrated-d/muscle.toml")
    assert kept["points"] == 48


def test_a_given_zero_is_obeyed(fascicle, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    record = records.load(folder / "d.csv", rest_length=0.127)
    zero = 0.05 * float(record.force.max())
    rest = records.Record.of(np.zeros(6), np.zeros(6), zero + np.linspace(-1, 1, 6))
    shifted = replace(record, force=record.force + zero)
    records.write(records.join([replace(rest, rest_length=0.127), shifted]), "shifted.csv")
    named = ("calibrate", "shifted.csv", "--muscle", TEN, "--fit", "c10", "--starts", "1", "--json")
    gauge = json.loads(fascicle(*named)[1])["gauge"]
    assert gauge["force_zero"] == pytest.approx(zero, rel=0.2)
    assert json.loads(fascicle(*named, "--zero", "force=0N")[1])["gauge"] == {}


def test_laws_are_compared(fascicle, folder, monkeypatch):
    monkeypatch.chdir(folder)
    how = ("--muscle", TEN, "--fit", "c10,c01", "--starts", "1", "--no-profile", "--json")
    code, out, _ = fascicle("calibrate", "d.csv", *how, "--compare")
    found, rows = json.loads(out), json.loads(out)["comparison"]
    assert code == 0 and len({row["label"] for row in rows}) == len(rows) > 3
    (own,) = (row for row in rows if row["rmse"] == pytest.approx(found["rmse"], rel=1e-6))
    assert own["free"] == len(found["parameters"]) == 2


@pytest.mark.slow
def test_the_readmes_calibration_finds_the_angle_that_was_built(fascicle, tmp_path):
    readme = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r"`fascicle ((?:record|calibrate) [^`]*kim2021_figure_6[^`]*)`", readme)
    assert len(lines) == 2
    assert [fascicle(*command.split())[0] for command in lines] == [0, 0]
    assert provenance(tmp_path / "calibrated-data" / "muscle.toml")["synthetic"]
    built = re.search(r"braid angle ([\d.]+) deg", (tmp_path / "data.csv").read_text())[1]
    assert f"is at {float(built):.1f}°" in readme
    (one,) = [x for x in provenance(tmp_path / "calibrated-data" / "muscle.toml")["parameter"]
              if x["name"] == "braid_angle"]  # fmt: skip
    found = [units.parse(one[key], "angle") for key in ("low", "value", "high")]
    assert found[0] < np.radians(float(built)) < found[2]
    assert f"{np.degrees(found[1]):.1f}" == f"{float(built):.1f}"


def test_a_joint_with_a_torque_sensor_is_a_bench(fascicle, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    muscle = fs.Muscle(0.2, 10e-3, 2e-3, np.radians(27), "latex")
    # a synthetic joint: the arm r = 0.02 sin(angle + 5 deg) [m] nearly vanishes at its end
    angle = np.radians(np.arange(0, 91, 3.0))
    arm, noise = 0.02 * np.sin(angle + np.radians(5)), np.random.default_rng(3)
    eps = 0.02 * (np.cos(np.radians(5)) - np.cos(angle + np.radians(5))) / 0.2
    rows = [
        f"{P},{np.degrees(a)},{float(muscle.force(P * 1e3, x)) * r + noise.normal(0, 5e-3)},{r}"
        for P in (0, 100, 200, 300)
        for a, x, r in zip(angle, eps, arm, strict=True)
    ]
    (tmp_path / "knee.csv").write_text(
        "P [kPa],angle [deg],torque [Nm],moment arm [m]\n" + "\n".join(rows)
    )
    code, _, _ = fascicle(
        "calibrate", "knee.csv", "--length", "200mm", "--outer-radius", "10mm",
        "--wall-thickness", "2mm", "--braid-angle", "30deg", "--material", "latex",
        "--zero", "angle=0deg", "--fit", "braid_angle", "--no-profile",
    )  # fmt: skip
    assert code == 0
    told = provenance(tmp_path / "calibrated-knee" / "muscle.toml")
    assert told["points"] == 4 * 31 - 4  # where the arm nearly vanishes
    (one,) = told["parameter"]
    low, high = (units.parse(one[key], "angle") for key in ("low", "high"))
    # three times the half-width of 90 % is five standard deviations
    assert abs(units.parse(one["value"], "angle") - np.radians(27)) < 3 * (high - low) / 2

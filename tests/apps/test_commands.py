import csv
import io
import json
import os
import subprocess
import sys

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose

from fascicle import Joint, records, tables
from fascicle.bundle import recruitment
from fascicle.bundle.energetics import PATHS, efficiency_map
from fascicle.cli.errors import UserError
from fascicle.cli.inputs import read_bundle, read_states
from fascicle.files import catalog, example, example_text, examples, load, save
from fascicle.results.labelled import to_json
from refusing import warns
from reproduction.claims import Claim, Criterion


SIX, TEN = "kim2021_figure_6", "kim2021_slenderness_10"
PAIR, BUNDLE = "kim2021_bundle_1_1", "kim2021_bundle_1_4"
PNG = b"\x89PNG"

# the specification's table: latex's constants with the silicone's modulus
LATEX_WITH_MODULUS = (
    'material = { c10 = "118.4 kPa", c01 = "105.7 kPa", youngs_modulus = "1.78 MPa" }'
)
TABLE = {
    0.0: "0 -1.77 -2.71 -2.07 -1.47 -1.20 -1.09 -1.08 -1.12 -1.19 -1.30 -1.44",
    34.5e3: "16.36 4.56 -1.74 -3.83 -4.91 -2.85 -1.88 -1.45 -1.28 -1.25 -1.31 -1.41",
    137.9e3: "65.37 48.07 34.75 23.67 13.89 4.81 -3.47 -8.18 -11.76 -6.71 -3.84 -2.54",
}


@pytest.fixture
def result(answer):
    """JSON of a command that must succeed."""
    return lambda *arguments: json.loads(answer(*arguments, "--json"))


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


@pytest.mark.filterwarnings("default:.*was fitted to")
@pytest.mark.parametrize("command", ["force", "free-strain", "bundle"])
def test_constants_fitted_to_another_muscle_give_a_warning(fascicle, tmp_path, command):
    with warns("martens2017_20"):
        save(example(SIX).replace(tension="martens2017_20"), tmp_path / "m.toml")
    code, out, err = fascicle(command, "m.toml", "-p", "100kPa")
    assert code == 0 and out and err.count("\n") == 1
    assert err.startswith("warning: `martens2017_20`")


def test_force_gives_the_table_of_the_specification(result, tmp_path):
    text = example_text(SIX).replace('material = "silicone_kim2021"', LATEX_WITH_MODULUS)
    (tmp_path / "spec.toml").write_text(text)
    values = result("force", "spec.toml", "-p", "0kPa,34.5kPa,137.9kPa")
    assert list(values) == [
        "pressure", "strain", "force", "mesh", "bladder", "bending", "region", "free_strain",
        "collapse_strain",
    ]  # fmt: skip
    assert values["pressure"] == list(TABLE)
    assert values["strain"] == [float(f"0.{3 * i:02d}") for i in range(12)]
    # the table is rounded to 0.01 N and to 1e-4
    expected = [[float(x) for x in row.split()] for row in TABLE.values()]
    assert_allclose(values["force"], expected, atol=0.00501)
    assert_allclose(values["free_strain"], [0, 0.0459, 0.1664], atol=5.1e-5)
    assert_allclose(values["collapse_strain"], [0.0674, 0.1173, 0.2427], atol=5.1e-5)
    terms = sum(np.array(values[name]) for name in ("mesh", "bladder", "bending"))
    assert_allclose(terms, values["force"], atol=1e-12)
    # 34.5 kPa: buckled from 0.0459 on, collapsed from 0.1173 on
    assert values["region"][1] == [0, 0, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2]


def test_force_as_csv_and_files_agree_with_json(answer, result, tmp_path):
    command = ["force", SIX, "-p", "0kPa,5psi", "-s", "0:0.3:0.1"]
    values, rows = result(*command), rows_of(answer(*command, "--csv"))
    assert [float(row["force [N]"]) for row in rows] == [x for row in values["force"] for x in row]
    for name in ("x.nc", "x.csv", "x.json"):
        assert f"wrote {name}" in answer(*command, "--out", name)
    assert json.loads((tmp_path / "x.json").read_text()) == values
    assert rows_of((tmp_path / "x.csv").read_text()) == rows
    with xarray.open_dataset(tmp_path / "x.nc") as dataset:
        assert_allclose(dataset["force"], values["force"], rtol=0)
        assert "Kim" in dataset["force"].source
    for name, magic in (("x.png", PNG), ("x.svg", b"<?xml")):
        answer(*command, "--plot", name)
        assert (tmp_path / name).read_bytes().startswith(magic)


STATES = [[344.7e3, 0.0], [344.7e3, 51.7e3], [344.7e3, 103.4e3]]
JOINT = ("recruit", BUNDLE, "-s", "0.1", "--torque", "0.5N*m", "--angle", "3deg", "--moment-arm",
         "20mm", "--supply", "300kPa")  # fmt: skip


def recruited():
    result = recruitment.recruit(example(BUNDLE), [[40.0], [9e3]], [0.12], "60 psi")
    return tables.recruited(result, [40.0, 9e3], [0.12])


def of_joint(stiffness):
    side = example(BUNDLE).replace(supply_pressure=300e3)
    joint = Joint(side, side, "20 mm", "0.1")
    return tables.joint_pressures(joint.pressures("3 deg", [0.5], stiffness))


def efficiencies():
    demands = [20.0, 100.0, 5e3], [0.1]  # 5 kN is out of reach
    return tables.efficiency([efficiency_map(example(PAIR), None, x, *demands) for x in PATHS])


@pytest.mark.parametrize(
    ("command", "table", "exit_code"),
    [
        (
            ("free-strain", SIX, "-p", "34.5kPa,344.7kPa"),
            lambda: tables.muscle_free_strain(example(SIX), [34.5e3, 344.7e3]), 0,
        ),
        (
            ("free-strain", PAIR, "-p", "34.5kPa,137.9kPa", "--no-resistance"),
            lambda: tables.bundle_equilibria(example(PAIR), [[34.5e3, 137.9e3]], False), 0,
        ),
        (
            ("bundle", PAIR, "-p", "344.7kPa,0kPa:103.4kPa:51.7kPa", "-s", "0,0.1"),
            lambda: tables.bundle_force(example(PAIR), STATES, [0.0, 0.1])
            | tables.bundle_equilibria(example(PAIR), STATES), 0,
        ),
        (
            ("free-strain", PAIR),
            lambda: tables.bundle_equilibria(example(PAIR), [[413.7e3, 0.0], [413.7e3] * 2]), 0,
        ),
        (
            ("space", PAIR, "--levels", "0kPa,413.7kPa", "--strain", "0,0.1,0.2,0.24"),
            lambda: tables.space(
                example(PAIR).workspace(levels=[0.0, 413.7e3], strain=[0.0, 0.1, 0.2, 0.24])
            ), 0,
        ),
        (("recruit", BUNDLE, "-s", "0.12", "--supply", "60psi", "-f", "40N,9kN"), recruited, 3),
        ((*JOINT, "--stiffness", "9N*m/rad"), lambda: of_joint(9.0), 0),
        ((*JOINT, "--stiffness", "900N*m/rad"), lambda: of_joint(900.0), 3),
        (("efficiency", PAIR, "--force", "20N,100N,5kN", "--strain", "0.1"), efficiencies, 3),
    ],
)  # fmt: skip
def test_json_is_the_table_of_the_library(fascicle, tmp_path, command, table, exit_code):
    code, out, err = fascicle(*command, "--json")
    assert code == exit_code and err.count("\n") == bool(code)
    values = json.loads(to_json(table()))
    assert json.loads(out) == values
    # files are written with an incomplete result, too
    plot = () if command[0] == "recruit" else ("--plot", "x.png")
    code, out, _ = fascicle(*command, "--out", "x.json", *plot)
    assert code == exit_code and "nan" not in out
    assert json.loads((tmp_path / "x.json").read_text()) == values
    assert not plot or (tmp_path / "x.png").read_bytes().startswith(PNG)


def test_states_of_repeated_options_add_up():
    bundle = read_bundle(PAIR)
    states = read_states(["0kPa:400kPa:0.4kPa,0kPa", "0kPa:400kPa:0.4kPa,100kPa"], bundle)
    assert len(states) == 2 * 1001
    with pytest.raises(UserError):
        read_states(["0kPa:400kPa:0.4kPa,0kPa:400kPa:0.4kPa"], bundle)


def test_record_writes_a_labelled_file_that_reads_back(answer, result, tmp_path):
    line = ("record", TEN, "--out", "d.csv", "-p", "0kPa:200kPa:100kPa", "--samples", "5",
            "--noise", "1%", "--seed", "7")  # fmt: skip
    values = result(*line, "--clip")
    assert values["synthetic"] is True and values["readings"] == 3 * 2 * 5
    assert "synthetic" in (tmp_path / "d.csv").read_text().splitlines()[0]
    record = records.load(tmp_path / "d.csv")
    assert record.synthetic and len(record) == values["readings"]
    assert values["censored"] == record.censored.sum() > 0
    assert values["largest_force"] == record.force.max()
    assert sorted(set(record.pressure)) == [0.0, 100e3, 200e3]
    # the same seed, without the gauge's limit, in place of the existing file
    assert "synthetic" in answer(*line, "--overwrite")
    unclipped = records.load(tmp_path / "d.csv").force
    np.testing.assert_array_equal(np.maximum(unclipped, 0), record.force)


def test_muscles_and_init(answer, result, tmp_path):
    lines = answer("muscles").splitlines()
    assert [line.split()[0] for line in lines] == list(examples())
    assert result("muscles") == examples()
    assert answer("muscles", SIX) == example_text(SIX)
    assert answer("init", "mine.toml").startswith("wrote mine.toml: ")
    assert float(load(tmp_path / "mine.toml").length) == 0.127
    text = (tmp_path / "mine.toml").read_text()
    # the keys in comments are valid too
    comments = [line[2:] for line in text.splitlines() if line.startswith("# ")]
    keys = [line for line in comments if line[:1] == "[" or " = " in line]
    (tmp_path / "all.toml").write_text(text + "\n".join(keys) + "\n")
    assert len(load(tmp_path / "all.toml").motor_units) == 2
    answer("init", "copy.toml", "--from", PAIR)
    assert (tmp_path / "copy.toml").read_text() == example_text(PAIR)


def test_measured_muscles(answer, result):
    assert all(name in answer("muscles", "--measured") for name in catalog)
    values = result("muscles", "--measured")
    assert list(values) == list(catalog)
    entry = values["festo-dmsp-20-300"]
    assert entry["license"] == "CC BY 4.0" and entry["range"]["pressure"] == [35e3, 675e3]
    assert entry["error"]["rmse"] == 9.38 and entry["toml"] == answer("muscles", entry["name"])
    # every command takes one
    force = result("force", entry["name"], "-p", "600kPa", "-s", "0.1")["force"]
    assert_allclose(np.ravel(force), catalog[entry["name"]].muscle.force(600e3, 0.1))


def test_a_file_named_like_an_example_comes_first(fascicle, result, tmp_path):
    (tmp_path / SIX).write_text(example_text(SIX).replace("127 mm", "200 mm"))
    assert result("free-strain", SIX, "-p", "0kPa")["free_strain"] == [0]
    (tmp_path / SIX).write_text("rubbish")
    assert fascicle("free-strain", SIX)[0] == 2


def test_help_and_version(answer, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    out = answer("--help")
    commands = [line.split()[0] for line in out.partition("Commands:\n")[2].splitlines()]
    assert len(commands) == 18  # a line each
    for command in commands:
        assert f"Usage: fascicle {command}" in answer(command, "--help")
    assert answer() == out
    assert answer("--version").startswith("fascicle 0.")


@pytest.mark.parametrize(
    ("text", "completions"),
    [
        ("force kim2021_fig", ["kim2021_figure_6", "kim2021_figure_9"]),
        ("force m", ["mine.toml"]),
        ("force sub/", ["sub/nested.toml"]),
        ("space x --scheme o", ["orderly"]),
        ("free", ["free-strain"]),
        ("force nowhere/x", []),
    ],
)
def test_completion(fascicle, monkeypatch, tmp_path, text, completions):
    (tmp_path / "mine.toml").touch()
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "nested.toml").touch()
    monkeypatch.setenv("_FASCICLE_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", f"fascicle {text}")
    monkeypatch.setenv("COMP_CWORD", str(text.count(" ") + 1))
    _, out, err = fascicle()
    assert (out.split(), err) == (completions, "")


def test_a_process_is_quiet_without_a_cache_folder(tmp_path):
    (tmp_path / "file").write_text("")
    environment = os.environ | {
        "XDG_CACHE_HOME": str(tmp_path / "file"), "FASCICLE_NO_CACHE": "0",
    }  # fmt: skip
    command = [sys.executable, "-m", "fascicle", "free-strain", SIX, "-p", "34.5kPa", "--csv"]
    done = subprocess.run(command, capture_output=True, env=environment, check=True, text=True)
    assert done.stderr == ""
    assert done.stdout.splitlines()[1].startswith("34500.0,0.0634")


@pytest.mark.parametrize("holds", [True, False])
def test_reproduce_lists_claims_and_fails_with_them(fascicle, monkeypatch, tmp_path, holds):
    """The reproduction has tests of its own: a small one takes its place."""

    def run(folder, progress):
        progress(0, 1, "Fig. 6")
        (folder / "report.html").write_text("a report")
        number = Criterion("strain left", 0.0674, "<", 0.1 if holds else 0.05)
        far = Criterion("times", 1.0, ">", 2.0)
        return [
            Claim("a", "Fig. 6", "prediction", "it collapses", "it folds", (number,), "at 0.067"),
            Claim("b", "Sec. 4", "prediction", "it never does", "no", (far,), "it does",
                  explanation="its own sizes"),
        ]  # fmt: skip

    monkeypatch.setattr("reproduction.kim2021.reproduction.run", run, raising=False)
    code, out, err = fascicle("reproduce", "kim2021", "--out", "results")
    assert (code, err) == (0 if holds else 1, "")
    assert ("a (Fig. 6)" in out) is not holds and "b (Sec. 4)" in out
    assert (tmp_path / "results" / "report.html").read_text() == "a report"


@pytest.mark.parametrize(
    ("width", "line", "encoding"),
    [
        (60, f"force {SIX}", "utf-8"),
        (60, "simulate lift_gas", "ascii"),
        (0, f"force {SIX}", "ascii"),  # unknown
        (100, f"efficiency {BUNDLE} --force 20N --path isobaric", "utf-8"),
    ],
)
def test_a_narrow_terminal_gets_narrow_tables(fascicle, monkeypatch, width, line, encoding):
    monkeypatch.setenv("COLUMNS", str(width))
    stream = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(stream, encoding))
    fascicle(*line.split())
    lines = stream.getvalue().decode(encoding).splitlines()
    assert lines and max(map(len, lines)) <= (width or 80)
    assert not any("…" in line or "?" in line for line in lines)


def test_laws_explains_each_law_of_a_name(fascicle):
    code, out, _ = fascicle("laws", "kim2021")
    assert code == 0
    # both laws of this name, one's equation and the other's constant
    assert r"\tag{17}" in out and out.count("braid_share [-]") == 1
    code, out, _ = fascicle("laws", "elastica", "--json")
    assert [entry["kind"] for entry in json.loads(out)] == ["buckling"]
    assert fascicle("laws", "elastik")[0] == 2

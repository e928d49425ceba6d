"""Measured records against every law, on records that are found, left out, or not there."""

import json

import numpy as np
import pytest

import fascicle as fs
from fascicle.records import write
from fascicle.records.record import Record
from reproduction.measurements import measured_records, no_records_message, run


NOMINAL = fs.Muscle(0.2, 10e-3, 2e-3, np.radians(29), fs.MooneyRivlin(5e5, 3e5))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a record that passes for measured, one of a model, and one without a muscle."""
    tmp_path = tmp_path_factory.mktemp("measured")
    true = fs.Muscle(0.2, 11e-3, 2e-3, np.radians(27), fs.MooneyRivlin(4e5, 2e5))
    P, strain = np.linspace(2.5e5, 6e5, 5)[:, None], np.linspace(0.0, 0.08, 6)
    force = np.asarray(true.force(P, strain))
    force = force + 2 * np.random.default_rng(0).normal(size=force.shape)
    for name, synthetic in (("lab", False), ("model", True), ("bare", False)):
        (tmp_path / name).mkdir()
        record = Record.of(P, strain, force, rest_length=0.2, synthetic=synthetic)
        write(record, tmp_path / name / "pull.csv")
        if name != "bare":
            fs.save(NOMINAL, tmp_path / name / "muscle.toml")
    return tmp_path


@pytest.fixture
def records(folder, monkeypatch):
    monkeypatch.setenv("FASCICLE_DATA", str(folder))
    return measured_records()


@pytest.fixture(scope="module")
def made(folder, tmp_path_factory):
    """Where the reproduction wrote, and what it found: every law fitted, once."""
    written = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("FASCICLE_DATA", str(folder))
        return written, run(written, measured_records())


def test_records_are_found_and_what_is_none_says_why(records):
    found = {one.name: one for one in records}
    assert set(found) == {"lab/pull.csv", "model/pull.csv", "bare/pull.csv"}
    assert found["lab/pull.csv"].left_out == "" and len(found["lab/pull.csv"].record) == 30
    assert "synthetic" in found["model/pull.csv"].left_out
    assert "no muscle.toml" in found["bare/pull.csv"].left_out


def test_each_law_stands_with_its_errors_and_what_it_misses(made):
    folder, (one,) = made
    labels = [law.row.label for law in one.laws]
    assert any(label.startswith("Klute-Hannaford: ") for label in labels)
    assert any(label.startswith("ideal: ") for label in labels) and len(set(labels)) == len(labels)
    left = [law.row.relative_left_out_rmse for law in one.laws]
    assert left == sorted(left)
    # the law that made the readings misses nothing visible, the ideal one does
    own = next(law for law in one.laws if law.row.label.startswith("Klute-Hannaford"))
    ideal = next(law for law in one.laws if law.row.label.startswith("ideal"))
    assert own.misses.startswith("nothing visible")
    assert "residuals vary with" in ideal.misses and ideal.row.rmse > 1.5 * own.row.rmse
    assert own.along_pressure[0] <= 0 <= own.along_pressure[1]
    told = json.loads((folder / "measurements.json").read_text())
    assert [law["label"] for law in told["records"][0]["laws"]] == labels
    assert len(told["left_out"]) == 2
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "lab/pull.csv" in page and "&amp;#" not in page  # escaped once


def test_without_records_it_says_what_to_set(monkeypatch, tmp_path):
    monkeypatch.setenv("FASCICLE_DATA", str(tmp_path / "none"))
    assert measured_records() == []
    assert "FASCICLE_DATA" in no_records_message()


def test_biases_are_mean_residuals(made):
    _, (one,) = made
    made, law = one.choice.calibration, one.laws[0]
    assert law.row.rmse > 0
    own = next(x for x in one.laws if x.row.label.endswith(", ".join(made.names)))
    rows = np.nanmean(made.residual, axis=1)
    # fitted twice, from other places: as near as a search ends
    np.testing.assert_allclose(own.along_pressure, [rows.min(), rows.max()], atol=0.05)

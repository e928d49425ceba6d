"""Downloads: the Python runs as it is and makes the same data; pictures and netCDF parse."""

import runpy
import subprocess
import sys
import xml.etree.ElementTree as ET  # of our own pictures
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fascicle as fs
from fascicle import records
from fascicle.explorer.exports import EXPORTS, data, escape_triple_quotes, output_stem
from fascicle.explorer.measured import (
    AUTOMATIC,
    LARGEST_FILE,
    MOST_ROWS,
    TUNING,
    ReadOptions,
    fit_record,
    measured_curves,
    read_headers,
    read_record,
)
from fascicle.explorer.state import view_of


VIEW = view_of(fs.example("kim2021_bundle_1_1"), "kim2021_bundle_1_1")
CSV = b"pressure [kPa],strain [-],force [N]\n" + b"".join(
    b"%d,%g,%g\n" % (P, i / 50, P / 10 * (1 - i / 10)) for P in (100, 200) for i in range(10)
)


@pytest.mark.parametrize("name", list(EXPORTS))
def test_the_python_makes_the_same_data(name, tmp_path, monkeypatch):
    export = EXPORTS[name](VIEW)
    script = tmp_path / "made.py"
    script.write_bytes(export.content("py"))
    monkeypatch.chdir(tmp_path)
    if name == "muscle":  # one as a process, whose beginning takes longer than the rest
        done = subprocess.run([sys.executable, script], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    else:
        runpy.run_path(str(script), run_name="__main__")
    assert (tmp_path / f"{export.stem}.csv").read_bytes() == export.content("csv")
    assert ET.parse(tmp_path / f"{export.stem}.svg").getroot().tag.endswith("svg")  # noqa: S314 ours


@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("muscle", ["force"]),
        ("bundle", ["space"]),
        ("efficiency", ["efficiency", "--path", "isobaric"]),
    ],
)
def test_columns_are_the_command_lines(name, command, capsys):
    """And Python's: both print a table of `fascicle.tables`."""
    from fascicle.cli import main

    file = "kim2021_slenderness_10" if name == "muscle" else "kim2021_bundle_1_1"
    with pytest.raises(SystemExit):
        main([command[0], file, *command[1:], "--csv"])
    theirs = capsys.readouterr().out.splitlines()[0].split(",")
    ours = EXPORTS[name](VIEW).content("csv").decode().splitlines()[0].split(",")
    extra = [one for one in ours if "without_resistance" in one]
    assert ours == [*theirs, *extra] and (len(extra) == 1) == (name == "efficiency")


@pytest.mark.parametrize("names", [(AUTOMATIC,), (TUNING,), ("c10", "outer_radius")], ids=str)
@pytest.mark.parametrize("tuned", [None, fs.example("kim2021_slenderness_10")])
def test_the_python_of_the_data_runs_beside_its_file(tuned, names, tmp_path, monkeypatch):
    (tmp_path / "mine.csv").write_bytes(CSV)
    record = read_record(CSV, "mine.csv", 0.127)
    export = data(VIEW.muscle, record, tuned, "mine.csv", ReadOptions(), names)
    text = export.content("py").decode()
    call = "select_model(record" if names == (AUTOMATIC,) else "fit(record"
    assert (call in text) == (tuned is not None)
    if tuned is not None:  # a fit takes a minute: here its result
        made = SimpleNamespace(muscle=tuned)
        found = SimpleNamespace(calibration=made)
        monkeypatch.setattr("fascicle.calibrate.fitting.fit", lambda *_, **__: made)
        monkeypatch.setattr(
            "fascicle.calibrate.model_selection.select_model", lambda *_, **__: found
        )
    monkeypatch.chdir(tmp_path)
    exec(compile(text, "mine_comparison.py", "exec"), {})  # noqa: S102 what is tested
    made = tmp_path / "mine_comparison.csv"
    assert made.read_bytes() == export.content("csv")
    assert ET.parse(made.with_suffix(".svg")).getroot().tag.endswith("svg")  # noqa: S314 ours


# what a record or a muscle may be called, our own outputs among them
NAMES = ("data.csv", "muscle.csv", "data_comparison.csv", "my data (2).csv", "..csv", ".csv",
         "a.b.csv", 'x"""\n{os}.csv', "../up.csv", "C:\\in\\mine.csv", "ärm.csv",
         "data")  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_script_writes_nothing_that_bears_the_name_of_its_record(name, tmp_path, monkeypatch):
    export = data(VIEW.muscle, read_record(CSV, name, 0.127), None, name, ReadOptions())
    folder = tmp_path / "in"
    folder.mkdir()
    at = folder / Path(name.replace("\n", "")).name  # no folder has a line break in a name
    at.write_bytes(CSV)
    text = (
        export.content("py").decode().replace(f"records.load({name!r}", f"records.load({at.name!r}")
    )
    monkeypatch.chdir(folder)
    exec(compile(text, "script.py", "exec"), {})  # noqa: S102 what is tested
    assert at.read_bytes() == CSV
    made = {one.name for one in folder.iterdir()} - {at.name}
    assert made == {f"{export.stem}.csv", f"{export.stem}.svg"}
    assert not list(tmp_path.glob("*.csv"))
    assert Path(name).stem.lower() != export.stem.lower()


def test_pictures_and_datasets_parse(tmp_path):
    export = EXPORTS["muscle"](VIEW)
    assert ET.fromstring(export.content("svg")).tag.endswith("svg")  # noqa: S314 ours
    assert export.content("png").startswith(b"\x89PNG")
    (tmp_path / "m.nc").write_bytes(export.content("nc"))
    from fascicle.results.labelled import read as read_result

    found = read_result(tmp_path / "m.nc")
    assert found["force"].attrs["units"] == "N"
    assert found["force"].values[0] == pytest.approx(
        np.asarray(VIEW.muscle.force(VIEW.pressure, found["strain"].values)), abs=1e-9
    )


def test_a_files_text_cannot_leave_the_string_it_stands_in():
    nasty = 'a"""\nimport os\n\\"""'
    assert eval(f'"""{escape_triple_quotes(nasty)}"""') == nasty  # noqa: S307 what is tested


def test_readings_are_read_and_lie_beside_curves():
    record = read_record(CSV, "d.csv", 0.127)
    assert len(record) == 20
    assert "rest length not given" in record.notes[-1]
    found = measured_curves(VIEW.muscle, record)
    assert found.pressure == pytest.approx([1e5, 2e5])
    assert found.force[1] == pytest.approx(
        np.asarray(VIEW.muscle.force(2e5, found.strain)), abs=1e-9
    )


@pytest.mark.parametrize(
    ("raw", "limit"),
    [(b"x" * (LARGEST_FILE + 1), LARGEST_FILE), (b"1,2\n" * (MOST_ROWS + 1), MOST_ROWS)],
)
def test_what_is_too_large_is_refused_with_its_limit(raw, limit):
    with pytest.raises(ValueError, match=str(limit)):
        read_record(raw, "d.csv", 0.127)


def test_a_name_is_never_opened():
    with pytest.raises(ValueError, match="passwd"):
        read_record(b"a,b\n1,2\n", "/etc/passwd", 0.127)


WORDLESS = b"A,B,C\n0,10,100\n5,8,100\n10,5,100\n"


def test_columns_and_units_are_given_where_the_file_does_not_say_them():
    assert read_headers(WORDLESS, "w.csv") == ("A", "B", "C")
    with pytest.raises(ValueError, match=r"w\.csv.*fields below, \w+ `[ABC]`"):
        read_record(WORDLESS, "w.csv", 0.127)
    columns = {"displacement": "A", "force": "B", "pressure": "C"}
    said = ReadOptions(False, 0.2, columns, {"displacement": "mm", "force": "N", "pressure": "kPa"})
    record = read_record(WORDLESS, "w.csv", 0.127, said)
    np.testing.assert_allclose(record.strain, [0, 0.025, 0.05])
    np.testing.assert_allclose(record.pressure, 100e3)
    np.testing.assert_allclose(record.force, [10, 8, 5])
    # over the muscle's length, which is said, where nobody gives another
    over = read_record(WORDLESS, "w.csv", 0.1, ReadOptions(False, None, columns, said.units))
    np.testing.assert_allclose(over.strain, [0, 0.05, 0.1])
    assert "taken over the muscle's, 100 mm" in over.notes[-1]


def test_no_table_has_no_headers():
    assert read_headers(b"", "e.csv") == ()


def test_constants_by_name_are_what_is_fitted():
    strain = np.linspace(0, 0.15, 12)
    built = VIEW.muscle.replace(outer_radius=1.03 * VIEW.muscle.outer_radius)
    record = records.Record.of(2e5, strain, np.asarray(built.force(2e5, strain)), synthetic=True)
    made = fit_record(record, VIEW.muscle, lambda _: None, ("outer_radius",))
    (parameter,) = made.calibration.parameters
    assert parameter.name == "outer_radius"
    # without noise the one constant is found; the search stops at a relative step of 1e-8
    assert parameter.value == pytest.approx(float(built.outer_radius), rel=1e-5)
    assert made.candidates == ()


def test_no_output_bears_the_name_of_a_file_that_was_read():
    assert EXPORTS["muscle"](VIEW, ()).stem == "kim2021_bundle_1_1_force"
    for opened in ("mine.toml", "mine_force.toml", "mine_force.csv"):
        stem = output_stem("mine.toml", "force", [opened])
        assert stem.startswith("mine_force") and f"{stem}.csv" != opened

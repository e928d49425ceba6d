"""Downloads: the Python runs as it is and makes the same data; pictures and netCDF parse."""

import subprocess
import sys
import xml.etree.ElementTree as ET  # of our own pictures
from types import SimpleNamespace

import numpy as np
import pytest

import fascicle as fs
from fascicle.explorer.curves.measured import LARGEST_FILE, MOST_ROWS, beside, read
from fascicle.explorer.parts.exports import EXPORTS, data, escaped
from fascicle.explorer.state import view_of


VIEW = view_of(fs.example("kim2021_bundle_1_1"), "kim2021_bundle_1_1")
CSV = b"pressure [kPa],strain [-],force [N]\n" + b"".join(
    b"%d,%g,%g\n" % (P, i / 50, P / 10 * (1 - i / 10)) for P in (100, 200) for i in range(10)
)


@pytest.mark.parametrize("name", list(EXPORTS))
def test_the_python_makes_the_same_data(name, tmp_path):
    export = EXPORTS[name](VIEW)
    script = tmp_path / "made.py"
    script.write_bytes(export.content("py"))
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / f"{name}.csv").read_bytes() == export.content("csv")
    assert ET.parse(tmp_path / f"{name}.svg").getroot().tag.endswith("svg")  # noqa: S314 ours


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


@pytest.mark.parametrize("tuned", [None, fs.example("kim2021_slenderness_10")])
def test_the_python_of_the_data_runs_beside_its_file(tuned, tmp_path, monkeypatch):
    (tmp_path / "mine.csv").write_bytes(CSV)
    record = read(CSV, "mine.csv", 0.127, False)
    export = data(VIEW.muscle, record, tuned, "mine.csv", False)
    text = export.content("py").decode()
    assert ("fit(record" in text) == (tuned is not None)
    if tuned is not None:  # a fit takes a minute: here its result
        made = SimpleNamespace(muscle=tuned)
        monkeypatch.setattr("fascicle.calibrate.fits.fitting.fit", lambda *_, **__: made)
    monkeypatch.chdir(tmp_path)
    exec(compile(text, "data.py", "exec"), {})  # noqa: S102 what is tested
    assert (tmp_path / "data.csv").read_bytes() == export.content("csv")
    assert ET.parse(tmp_path / "data.svg").getroot().tag.endswith("svg")  # noqa: S314 ours


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
    assert eval(f'"""{escaped(nasty)}"""') == nasty  # noqa: S307 what is tested


def test_readings_are_read_and_lie_beside_curves():
    record = read(CSV, "d.csv", 0.127, False)
    assert len(record) == 20
    assert "rest length not given" in record.notes[-1]
    found = beside(VIEW.muscle, record)
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
        read(raw, "d.csv", 0.127, False)


def test_a_name_is_never_opened():
    with pytest.raises(ValueError, match="passwd"):
        read(b"a,b\n1,2\n", "/etc/passwd", 0.127, False)

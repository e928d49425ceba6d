"""Downloads: the Python runs as it is and makes the same data; pictures and netCDF parse."""

import asyncio
import runpy
import subprocess
import sys
import xml.etree.ElementTree as ET  # of our own pictures
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import panel as pn
import pytest

import fascicle as fs
from fascicle.explorer.exports import EXPORTS, data
from fascicle.explorer.measured import AUTOMATIC, TUNING, read_record
from fascicle.explorer.page import Page
from fascicle.explorer.state import TABS, Pin, Session, view_of
from fascicle.results.labelled import read


VIEW = view_of(fs.example("kim2021_bundle_1_1"), "kim2021_bundle_1_1")
CSV = b"pressure [kPa],strain [-],force [N]\n" + b"".join(
    b"%d,%g,%g\n" % (P, i / 50, P / 10 * (1 - i / 10)) for P in (100, 200) for i in range(10)
)


def is_svg(path):
    return ET.parse(path).getroot().tag.endswith("svg")  # noqa: S314 ours


@pytest.mark.parametrize("name", list(EXPORTS))
def test_the_python_makes_the_same_data(name, tmp_path, monkeypatch):
    export = EXPORTS[name](VIEW, ())
    script = tmp_path / "script.py"
    script.write_bytes(export.content("py"))
    monkeypatch.chdir(tmp_path)
    if name == "muscle":  # one as a process, whose beginning takes longer than the rest
        process = subprocess.run([sys.executable, script], capture_output=True, text=True)
        assert process.returncode == 0, process.stderr
    else:
        runpy.run_path(str(script), run_name="__main__")
    assert (tmp_path / f"{export.stem}.csv").read_bytes() == export.content("csv")
    assert is_svg(tmp_path / f"{export.stem}.svg")


@pytest.mark.parametrize("names", [(AUTOMATIC,), (TUNING,), ("c10", "outer_radius")], ids=str)
@pytest.mark.parametrize("tuned", [None, fs.example("kim2021_slenderness_10")])
def test_the_python_of_the_data_runs_beside_its_file(tuned, names, tmp_path, monkeypatch):
    (tmp_path / "mine.csv").write_bytes(CSV)
    record = read_record(CSV, "mine.csv", VIEW.muscle)
    export = data(VIEW.muscle, record, tuned, "mine.csv", {}, names)
    text = export.content("py").decode()
    call = "select_model(record" if names == (AUTOMATIC,) else "fit(record"
    assert (call in text) == (tuned is not None)
    if tuned is not None:  # a fit takes a minute: its result instead
        fit = SimpleNamespace(muscle=tuned)
        selection = SimpleNamespace(calibration=fit)
        monkeypatch.setattr("fascicle.calibrate.fitting.fit", lambda *_, **__: fit)
        monkeypatch.setattr(
            "fascicle.calibrate.model_selection.select_model", lambda *_, **__: selection
        )
    monkeypatch.chdir(tmp_path)
    exec(compile(text, "mine_comparison.py", "exec"), {})  # noqa: S102 what is tested
    assert Path("mine_comparison.csv").read_bytes() == export.content("csv")
    assert is_svg("mine_comparison.svg")


# names of records and muscles, those of outputs among them
NAMES = ("data.csv", "muscle.csv", "data_comparison.csv", "my data (2).csv", "..csv", ".csv",
         "a.b.csv", 'x"""\n{os}.csv', "../up.csv", "C:\\in\\mine.csv", "ärm.csv",
         "data")  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_script_never_writes_to_its_record(name, tmp_path, monkeypatch):
    export = data(VIEW.muscle, read_record(CSV, name, VIEW.muscle), None, name, {})
    folder = tmp_path / "in"
    folder.mkdir()
    path = folder / Path(name.replace("\n", "")).name  # no folder has a line break in a name
    path.write_bytes(CSV)
    text = export.content("py").decode()
    text = text.replace(f"records.load({name!r}", f"records.load({path.name!r}")
    monkeypatch.chdir(folder)
    exec(compile(text, "script.py", "exec"), {})  # noqa: S102 what is tested
    assert path.read_bytes() == CSV
    outputs = {output.name for output in folder.iterdir()} - {path.name}
    assert outputs == {f"{export.stem}.csv", f"{export.stem}.svg"}
    assert not list(tmp_path.glob("*.csv"))
    assert Path(name).stem.lower() != export.stem.lower()


def test_a_files_text_stays_in_its_string(monkeypatch):
    nasty = 'a"""\nimport os\n\\"""'
    monkeypatch.setattr("fascicle.explorer.exports.dumps", lambda _: nasty)
    script = EXPORTS["muscle"](VIEW, ()).script.replace("from fascicle.files", "from this_test")
    texts = []
    module = SimpleNamespace(loads=lambda text: texts.append(text) or VIEW.muscle)
    monkeypatch.setitem(sys.modules, "this_test", module)
    exec(script.partition("\npressure =")[0], {})  # noqa: S102 what is tested
    assert texts == [f"\n{nasty}"]


def test_pictures_and_datasets_parse(tmp_path):
    export = EXPORTS["muscle"](VIEW, ())
    assert ET.fromstring(export.content("svg")).tag.endswith("svg")  # noqa: S314 ours
    assert export.content("png").startswith(b"\x89PNG")
    (tmp_path / "m.nc").write_bytes(export.content("nc"))
    dataset = read(tmp_path / "m.nc")
    assert dataset["force"].attrs["units"] == "N"
    expected = np.asarray(VIEW.muscle.force(VIEW.pressure, dataset["strain"].values))
    assert dataset["force"].values[0] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("tab", TABS)
def test_a_file_that_cannot_be_made_is_told_on_the_page(tab, monkeypatch):
    def fail(*_):
        raise ValueError("no such muscle")

    view = replace(VIEW, tab=tab, pins=(Pin("one", VIEW.muscle, VIEW.pressure),))
    page = Page(Session(view))
    monkeypatch.setattr("fascicle.explorer.exports.Export.content", fail)
    monkeypatch.setattr("fascicle.explorer.time_tab.TimeView._charts_file", fail)
    buttons = page._contents[tab].select(pn.widgets.FileDownload)
    message = page._views[tab].download_message
    (button,) = [button for button in buttons if "PNG" in button.label]
    if tab == "data":
        page._views[tab].open_example()
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(button.callback())
    assert message.pane in page.panel.select(pn.pane.HTML) and message.pane.visible
    assert "no such muscle" in message.text

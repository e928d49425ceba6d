"""`fascicle design` and `fascicle sweep`."""

import json
import re
import tomllib

import numpy as np
import pytest

import fascicle as fs
from fascicle.describe import results


TASK = """format = 1

[task]
force = ["60 N", "150 N", "260 N"]
strain = [0.16, 0.1, 0.06]
weight = [3, 2, 1]
supply_pressure = "413.7 kPa"

[design]
muscle = "kim2021_slenderness_10"
muscles = [4]
length = ["110 mm", "127 mm"]

[objectives]
mean_efficiency = "max"
envelope = "min"
valves = "min"

[limits]
valves = { at_most = 3 }
not_reached = { at_most = "50 %" }
"""


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(TASK)
    return path


def test_a_task_becomes_bundles_and_a_page(fascicle, written, tmp_path):
    code, out, err = fascicle("design", "task.toml", "--also", "reversal_depth")
    assert (code, err) == (0, "")
    assert "14 designs" in out and "Take " in out and "wrote designed-task/report.html" in out
    folder = tmp_path / "designed-task"
    page = (folder / "report.html").read_text(encoding="utf-8")
    # nothing is asked of anyone else
    assert not re.search(r'(src|href)="(?!data:|#)[a-z]+:', page)
    for part in ('<svg class="plot"', "<title>1+", 'data-place="0"', "Recommendation",
                 "Force-strain space", "[[bundle.motor_unit]]"):  # fmt: skip
        assert part in page
    front = results.read(folder / "front.nc")
    assert front.mean_efficiency.attrs["units"] == "1" and front.envelope.attrs["units"] == "m"
    assert np.all(front.valves <= 3) and front.recommended.sum() == 1
    bundle = fs.load(folder / "bundle_1.toml")
    units = "+".join(str(int(unit.count)) for unit in bundle.motor_units)
    assert units == front.composition[0].item()
    every = results.read(folder / "designs.nc")
    assert every.sizes["design"] == 14 and every.front.sum() == front.sizes["design"]


def test_json(fascicle, written, tmp_path):
    code, out, err = fascicle("design", "task.toml", "--json")
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert found["composition"][0] and len(found["valves"]) == len(found["design"])
    assert [path.name for path in tmp_path.iterdir()] == ["task.toml"]


def test_no_design_left_is_explained(fascicle, written):
    limited = TASK.replace('"50 %" }', '0 }\nlargest_force = { at_least = "10 kN" }')
    written.write_text(limited)
    code, out, err = fascicle("design", "task.toml")
    assert (code, err) == (0, "")
    assert "0 within the limits" in out
    assert "largest force: 0 of 14 designs keep it" in out


def test_the_template_is_a_task(fascicle, tmp_path):
    from fascicle.describe.task import load_task

    assert fascicle("init", "--task")[0] == 0
    data = tomllib.loads((tmp_path / "task.toml").read_text())
    assert data["format"] == 1
    file = load_task(tmp_path / "task.toml")
    assert len(file.space) > 500 and len(file.task) == 9
    code, _, err = fascicle("init", "--task")
    assert code == 2 and "--force replaces it" in err


@pytest.mark.parametrize("command", ["design", "sweep"])
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"413.7 kPa"', "413.7", "task.supply_pressure = 413.7"),
        ("[0.16, 0.1, 0.06]", "[0.16, 0.1]", "must be lists of one length, got 3, 2 and 3"),
        ("[0.16, 0.1, 0.06]", "[0.16, 0.1, 0.7]", "`strain` must lie in"),
        ("weight", "wieght", 'unknown key, did you mean "weight"?'),
        ("mean_efficiency", "mean_eficiency", "did you mean 'mean_efficiency'"),
        ('envelope = "min"', 'envelope = "small"', 'envelope = "small": must be "min" or "max"'),
        ("at_most = 3", "at_most = 0", "the space is empty"),
        ("{ at_most = 3 }", '{ atmost = 3 }', "write at_least or at_most"),
        ("{ at_most = 3 }", "{ at_least = 3, at_most = 2 }", "nothing can be both"),
        ("muscles = [4]", "muscles = [31]", "`muscles` must lie in [1, 20], got 31"),
        ("muscles = [4]", 'splits = ["1+x"]', "written like '1+4'"),
        ("slenderness_10", "slenderness_1", "did you mean 'kim2021_slenderness_10'"),
        ("slenderness_10", "bundle_1_4", "is a bundle: name a muscle"),
        ('["110 mm", "127 mm"]', '"110 mm:127 mm"', "write start:stop:step"),
        ('["110 mm", "127 mm"]', '"-1 mm"', "`length` must lie in"),
        ("force =", 'example = "walking_ankle"\nforce =', "an example has its own"),
    ],
)  # fmt: skip
def test_a_wrong_task_is_one_line(fascicle, written, tmp_path, command, old, new, message):
    assert old in TASK
    written.write_text(TASK.replace(old, new, 1))
    code, out, err = fascicle(command, "task.toml")
    assert (code, out) == (2, "")
    assert message in err and err.count("\n") == 1 and "Traceback" not in err
    assert [path.name for path in tmp_path.iterdir()] == ["task.toml"]


def test_a_folder_of_something_else_is_left_alone(fascicle, written, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("kept")
    for command in ("design", "sweep"):
        code, _, err = fascicle(command, "task.toml", "--out", "mine")
        assert code == 2 and err.count("\n") == 1
        assert (tmp_path / "mine" / "thesis.txt").read_text() == "kept"


def test_a_sweep_and_its_front(fascicle, written, tmp_path):
    pytest.importorskip("zarr", reason="needs the extra `sweep`")
    written.write_text(TASK + "\n[sweep]\nblock = 5\n")
    code, out, err = fascicle("sweep", "task.toml", "--workers", "0")
    assert code == 0 and "3 of 3 blocks" in err
    assert "14 designs in 3 blocks" in out and "on the front" in out
    front = results.read(tmp_path / "swept-task" / "front.nc")
    store = results.read(tmp_path / "swept-task" / "designs.zarr")
    assert store.sizes["design"] == 14
    assert float(front.mean_efficiency.max()) == float(
        store.mean_efficiency.where(store.not_reached <= 0.5).max()
    )
    # again, as it is, and with another study
    code, _, err = fascicle("sweep", "task.toml", "--workers", "0")
    assert code == 2 and "--resume goes on with it" in err
    assert fascicle("sweep", "task.toml", "--workers", "0", "--resume")[0] == 0
    written.write_text(TASK + "\n[sweep]\nblock = 4\n")
    code, _, err = fascicle("sweep", "task.toml", "--workers", "0", "--resume")
    assert code == 2 and "another study's results; nothing was changed" in err


def test_no_scheduler_there(fascicle, written):
    pytest.importorskip("distributed", reason="needs the extra `sweep`")
    code, _, err = fascicle("sweep", "task.toml", "--scheduler", "nowhere://x")
    assert code == 2 and err.startswith("error: --scheduler nowhere://x") and err.count("\n") == 1


def test_sizes_in_between(fascicle, written, tmp_path):
    pytest.importorskip("pymoo", reason="needs the extra `design`")
    options = ["--generations", "3", "--population", "8", "--seed", "2", "--json"]
    code, out, err = fascicle("design", "task.toml", *options, "--checkpoint", "kept")
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert all(0.11 <= length <= 0.127 for length in found["length"])
    assert set(found["design"]) == {-1}
    # from the checkpoint, which is at its end
    assert fascicle("design", "task.toml", *options, "--checkpoint", "kept")[1] == out
    code, _, err = fascicle("design", "task.toml", "--checkpoint", "kept")
    assert code == 2 and "only --generations keeps one" in err

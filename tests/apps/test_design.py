"""`fascicle design` and `fascicle sweep`."""

import json
import re

import numpy as np
import pytest
import xarray

import fascicle as fs


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
"""


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(TASK)
    return path


def test_design_writes_bundles_and_a_page(fascicle, written, tmp_path):
    code, out, err = fascicle("design", "task.toml", "--also", "reversal_depth")
    assert (code, err) == (0, "")
    assert out.startswith("Take design ")  # the engineer's view first
    folder = tmp_path / "designed-task"
    page = (folder / "report.html").read_text(encoding="utf-8")
    # nothing is asked of anyone else
    assert not re.search(r'(src|href)="(?!data:|#)[a-z]+:', page)
    front = xarray.load_dataset(folder / "front.nc")
    assert front.mean_efficiency.attrs["units"] == "1" and front.envelope.attrs["units"] == "m"
    assert np.all(front.valves <= 3) and front.recommended.sum() == 1
    assert np.all(front.margin >= 0) and front.case_reached.all()
    bundle = fs.load(folder / "recommended.toml")
    units = "+".join(str(int(unit.count)) for unit in bundle.motor_units)
    assert front.composition[front.recommended.values.argmax()].item() == units
    # the file's bundle gives what the table says
    strain, supply = np.array([0.16, 0.1, 0.06]), np.full(len(bundle.motor_units), 413.7e3)
    np.testing.assert_allclose(bundle.force(supply, strain), front.case_largest_force, rtol=1e-9)
    first = fs.load(folder / "bundle_1.toml")
    units = "+".join(str(int(unit.count)) for unit in first.motor_units)
    assert units == front.composition[0].item()
    all_designs = xarray.load_dataset(folder / "designs.nc")
    assert all_designs.sizes["design"] == 14 and all_designs.front.sum() == front.front.sum()


def test_small_margin_has_a_warning(fascicle, written, tmp_path):
    code, out, _ = fascicle("design", "task.toml", "--json")
    data = json.loads(out)
    assert (code, data["least_margin"], data["notes"]) == (0, 0.2, [])
    assert data["composition"][0] and len(data["valves"]) == len(data["design"])
    assert data["reached"] is True and data["case_reached"] == [True] * 3
    assert data["limits_kept"] is True and sum(data["recommended"]) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["task.toml"]
    share = data["relative_margin"][data["recommended"].index(True)]
    spare = [s / f for s, f in zip(data["case_spare"], data["case_force"], strict=True)]
    assert share == pytest.approx(min(spare), rel=1e-9)
    for margin, count in ((20.0, share < 0.2), (100 * share + 1, True), (100 * share - 1, False)):
        written.write_text(f'{TASK}margin = "{margin:.3f} %"\n')
        code, out, _ = fascicle("design", "task.toml", "--json")
        assert code == 0 and len(json.loads(out)["warnings"]) == count  # one is recommended


def test_design_that_fails_in_draws_is_not_recommended(fascicle, written, tmp_path):
    """The margin as drawn is some 30 %: too little for the error of a muscle that isn't tuned."""
    text = TASK.replace('"260 N"', '"430 N"')
    written.write_text(text)
    code, out, err = fascicle("design", "task.toml")
    assert (code, err) == (3, "")
    first = out.splitlines()[0]
    share = re.search(r'write safety = "(\d+) %"', first)[1]
    assert (tmp_path / "designed-task" / "report.html").exists()
    code, out, _ = fascicle("design", "task.toml", "--json")
    data = json.loads(out)
    assert code == 3 and data["recommended"] is None and data["safety"]["holds"] is False
    assert data["safety"]["probability"] < data["safety"]["least_probability"] == 0.95
    # what the line says is accepted
    written.write_text(text.replace("3 }", f'3 }}\nsafety = "{share} %"'))
    code, out, _ = fascicle("design", "task.toml", "--json")
    data = json.loads(out)
    assert code == 0 and data["safety"]["holds"] is True
    (best,) = [i for i, taken in enumerate(data["recommended"]) if taken]
    assert data["relative_margin_q05"][best] < data["relative_margin"][best]


def test_broken_limits_are_explained(fascicle, written):
    limited = TASK.replace("3 }", '3 }\nlargest_force = { at_least = "10 kN" }')
    written.write_text(limited)
    code, out, err = fascicle("design", "task.toml")
    assert (code, err) == (3, "")
    code, out, _ = fascicle("design", "task.toml", "--json")
    data = json.loads(out)
    assert code == 3 and data["reached"] is True
    assert data["limits_kept"] is False and data["recommended"] is None
    assert len(data["notes"]) == 1


AS_DRAWN = "[scatter]\nenabled = false\n"
# a peak that counts next to nothing, and that no design gives
PEAK = TASK.replace('"260 N"', '"4500 N"').replace("[3, 2, 1]", "[3, 2, 1e-6]")


def test_unreachable_task_has_no_recommendation(fascicle, written, tmp_path):
    written.write_text(PEAK)
    code, out, err = fascicle("design", "task.toml")
    assert (code, err) == (3, "")
    radius = float(re.search(r"\n- radius: ([\d.]+) mm instead of 6\.35 mm", out)[1])
    folder = tmp_path / "designed-task"
    assert {path.name for path in folder.iterdir()} >= {"report.html", "designs.nc"}
    assert not list(folder.glob("*.toml"))
    code, out, _ = fascicle("design", "task.toml", "--json")
    data = json.loads(out)
    assert code == 3 and data["reached"] is False
    assert data["limits_kept"] is True and data["recommended"] is None  # it has no others
    assert data["nearest"]["composition"] == ["4"]
    assert data["nearest"]["case_reached"] == [True, True, False]
    changes = {one["change"]: one["value"] for one in data["would_reach"]}
    assert changes["supply_pressure"] is None and changes["muscles"] > 4
    # what it says would reach it does, as it is printed
    written.write_text(
        PEAK.replace("muscles = [4]", f'muscles = [4]\nradius = "{radius} mm"') + AS_DRAWN
    )
    code, out, _ = fascicle("design", "task.toml", "-o", "wider")
    assert code == 0


def test_a_task_is_written_for_a_load(fascicle, refused, tmp_path):
    """With muscles that lift it; what to take is drawn on one page."""
    from fascicle.files.task import load_task

    assert "--mass and --stroke" in refused("init", "--task", "--mass", "25kg")
    assert fascicle("init", "--task", "--mass", "25kg", "--stroke", "40mm")[0] == 0
    task = load_task(tmp_path / "task.toml").task
    assert task.force == pytest.approx([245.16625], rel=1e-5)
    assert task.stroke == pytest.approx([0.04])
    assert fascicle("design", "task.toml", "--plot", "page.pdf")[0] == 0
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")


SLOW = [
    pytest.param(name, marks=pytest.mark.slow) for name in ("walking_ankle", "sit_to_stand_knee")
]


@pytest.mark.parametrize("example", ["pick_and_place_arm", *SLOW])
def test_template_is_solved(fascicle, tmp_path, example):
    from fascicle.design.exhaustive_search import search
    from fascicle.files.task import load_task

    assert fascicle("init", "--task")[0] == 0
    path = tmp_path / "task.toml"
    file = load_task(path)
    assert len(file.space) > 500 and len(file.task) == 9
    path.write_text(path.read_text().replace('"pick_and_place_arm"', f'"{example}"', 1) + "\n")
    file = load_task(path)
    found = search(file.space, file.task, file.senses, file.limits)
    assert found.recommended is not None
    assert np.all(found.values["margin"][found.front] >= 0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"413.7 kPa"', "413.7", "task.supply_pressure"),
        ("[0.16, 0.1, 0.06]", "[0.16, 0.1]", "3, 2 and 3"),
        ("weight", "wieght", "wieght"),
        ("at_most = 3", "at_most = 0", "valve"),
        ("muscles = [4]", "muscles = [131]", "muscles"),
    ],
)  # fmt: skip
def test_a_wrong_task_is_one_line(refused, written, old, new, message):
    assert old in TASK
    written.write_text(TASK.replace(old, new, 1))
    for command in ("design", "sweep"):
        assert message in refused(command, "task.toml")


def test_a_sweep_and_its_front(fascicle, written, tmp_path):
    zarr = pytest.importorskip("zarr", reason="needs the extra `sweep`")
    written.write_text(TASK + "\n[sweep]\nblock = 5\n")
    code, _, err = fascicle("sweep", "task.toml", "--workers", "0")
    assert code == 0 and err.count("\n") == 4  # 0 to 3 blocks
    front = xarray.load_dataset(tmp_path / "swept-task" / "front.nc")
    array = zarr.open_array(tmp_path / "swept-task" / "designs.zarr", mode="r")
    values = dict(zip(array.attrs["objectives"], array[:].T, strict=True))
    assert len(values["margin"]) == 14
    best = values["mean_efficiency"][values["margin"] >= 0].max()
    assert float(front.mean_efficiency.max()) == pytest.approx(best, rel=1e-9)
    # again, as it is, and with another study
    assert fascicle("sweep", "task.toml", "--workers", "0")[0] == 2
    assert fascicle("sweep", "task.toml", "--workers", "0", "--resume")[0] == 0
    written.write_text(TASK + "\n[sweep]\nblock = 4\n")
    code, _, err = fascicle("sweep", "task.toml", "--workers", "0", "--resume")
    assert code == 2 and err.count("\n") == 1


def test_missing_scheduler_is_one_line(fascicle, written):
    pytest.importorskip("distributed", reason="needs the extra `sweep`")
    code, _, err = fascicle("sweep", "task.toml", "--scheduler", "nowhere://x")
    assert code == 2 and "--scheduler" in err.split() and err.count("\n") == 1
    assert not written.with_name("swept-task").exists()


@pytest.mark.parametrize("line", ["design task.toml --out d", "force kim2021_figure_6 --out f.csv"])
def test_a_result_that_cannot_be_written_is_printed(fascicle, written, monkeypatch, line):
    def fill(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("fascicle.io.atomic.write_folder", fill)
    monkeypatch.setattr("fascicle.io.atomic.open_replacement", fill)
    code, out, err = fascicle(*line.split(), "--json")
    assert (code, json.loads(out) != {}, err.count("\n")) == (2, True, 1)


def test_continuous_sizes(fascicle, written, tmp_path):
    pytest.importorskip("pymoo", reason="needs the extra `design`")
    options = ["--generations", "3", "--population", "8", "--seed", "2", "--json"]
    code, out, err = fascicle("design", "task.toml", *options)
    assert (code, err) == (0, "")
    data = json.loads(out)
    assert all(0.11 <= length <= 0.127 for length in data["length"])
    assert set(data["design"]) == {-1}
    assert min(data["margin"]) >= 0

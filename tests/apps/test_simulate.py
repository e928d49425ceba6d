"""`fascicle simulate`."""

import json
import re
from pathlib import Path

import pytest
import xarray

from fascicle.control import POLICIES
from fascicle.files import example_text


SHORT = (
    example_text("lift_gas")
    .replace('duration = "6 s"', 'duration = "40 ms"')
    .partition('[[schedule]]\ntime = "1 s"')[0]
)


def test_a_table_files_and_a_page(fascicle, tmp_path):
    (tmp_path / "a.toml").write_text(SHORT)
    code, _, err = fascicle(
        "simulate", "a.toml", "-o", "a.nc", "--plot", "a.png", "--report", "a.html",
        "--bode", "bode.pdf",
    )  # fmt: skip
    assert (code, err) == (0, "") and Path("bode.pdf").exists()
    data = xarray.load_dataset(tmp_path / "a.nc")
    assert data.sizes["time"] == 41
    assert "<h1" in (tmp_path / "a.html").read_text()
    assert (tmp_path / "a.png").stat().st_size > 10_000


# across the transition in half a second, then on to more than any policy can
RAMP = (
    (
        example_text("ramp_hand_over")
        .replace('"2 s"', '"0.6 s"')
        .replace('"265 kPa"', '"294 kPa"')
        .replace('"15 N"', '"20 N"')
        .replace('"70 N"', '"90 N"')
    )
    + """
[[demand]]
time = "0.5 s"
force = "44 N"
"""
)
# rows in the order of their times
_, FIRST, LAST, BETWEEN = RAMP.split("[[demand]]")
RAMP = "[[demand]]".join([_, FIRST, BETWEEN, LAST])


def test_a_run_that_is_controlled_says_what_it_was_worth(fascicle):
    code, out, err = fascicle(
        "simulate", "ramp_hand_over", "--json", "-o", "a.nc", "--plot", "a.svg",
        "--report", "a.html", "--bode", "bode.svg",
    )  # fmt: skip
    assert (code, err) == (0, "") and "pressure loop" in Path("bode.svg").read_text()
    found = json.loads(out)
    assert found["control_drawdown"] < 0.1 * found["control_dip"]
    assert (found["control_recruited"], found["control_unreachable"]) == (1, 0)
    assert found["control_first"] is None and found["control_supply_energy"] > 10
    assert len(found["demand"]) == len(found["controlled"]) == len(found["time"])
    data = xarray.load_dataset("a.nc")
    assert data["control_rms"].attrs["units"] == data["demand"].attrs["units"] == "N"
    assert "<svg" in Path("a.svg").read_text() and Path("a.html").exists()


def test_policies_are_compared_and_what_none_can_reach_is_told(fascicle, tmp_path):
    (tmp_path / "a.toml").write_text(RAMP)
    code, out, err = fascicle(
        "simulate", "a.toml", "--compare", "-o", "a.json", "--plot", "a.png", "--report", "a.html"
    )
    assert (code, err) == (0, "")
    found = json.loads((tmp_path / "a.json").read_text())
    assert found["policy"] == list(POLICIES) and all(found["trusted"])
    assert all(name in out for name in POLICIES)
    # what none can reach is the same for all: the muscles' force at the supply's pressure
    many = found["control_unreachable"]
    assert len(set(many)) == 1 and many[0] > 0
    plain, kept = (found["policy"].index(name) for name in ("threshold", "hand_over"))
    assert found["control_drawdown"][kept] < 0.3 * found["control_drawdown"][plain]
    code, out, err = fascicle("simulate", "a.toml", "--policy", "threshold")
    assert (code, err) == (0, "") and "threshold" in out


OTHERS = ("supply_runs_dry", "lift_gas", "lift_oil", "supply_is_pumped", "ramp_1_4", "ramp_1x5",
          "raise_1_1", "raise_1_4", "raise_1x5", "joint_gait", "joint_there_and_back")  # fmt: skip
SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in OTHERS]


@pytest.mark.parametrize("name", ["joint_step", *SLOW])
def test_named_scenarios_close(fascicle, name):
    code, out, err = fascicle("simulate", name, "--json")
    found = json.loads(out)
    assert (code, err) == (0, "") and all(found["closes"])
    assert found["event"] == (["supply_empty"] if name == "supply_runs_dry" else [])
    assert max(found["left_over_share"]) < 1e-5


def test_what_cant_be_trusted_is_said_and_ends_with_1(fascicle, tmp_path):
    # with next to no compliance oil has no unique pressure where a muscle's volume falls with it
    stiff = re.sub("compliance = .*", 'compliance = "1e-16 m^3/Pa"', example_text("lift_oil"))
    stiff = stiff.replace("command = [1, -1]", "command = [1, 0]").replace('"6 s"', '"1 s"')
    (tmp_path / "a.toml").write_text(stiff.partition('[[schedule]]\ntime = "1.5 s"')[0])
    code, out, err = fascicle("simulate", "a.toml", "-o", "a.nc", "--json")
    assert code == 1 and err.startswith("a: ") and err.count("\n") == 1
    codes = {x["code"] for x in json.loads(out)["findings"] if x["severity"] == "error"}
    assert "run.cavitates" in codes
    data = xarray.load_dataset(
        tmp_path / "a.nc"
    )  # written all the same, with what is wrong with it
    assert data.attrs["notes"] and "cavitates" in data["event"].values


def test_init_writes_one_that_runs(fascicle, tmp_path):
    assert fascicle("init", "--scenario")[0] == 0
    assert (tmp_path / "scenario.toml").read_text() == example_text("lift_gas")
    assert fascicle("init", "--scenario", "--from", "joint_step", "j.toml")[0] == 0
    assert (tmp_path / "j.toml").read_text() == example_text("joint_step")
    assert fascicle("init", "--scenario", "--fluid", "oil", "o.toml")[0] == 0
    assert (tmp_path / "o.toml").read_text() == example_text("lift_oil")
    for wrong in (["--scenario", "--fluid", "beer"], ["--fluid", "oil"]):
        assert fascicle("init", *wrong, "w.toml")[0] == 2

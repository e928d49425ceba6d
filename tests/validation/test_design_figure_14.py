"""Fig. 14's conclusion as the result of a search over all splits of five equal muscles."""

import numpy as np
import pytest

import fascicle as fs
from fascicle.bundle.reversal import reversal
from fascicle.design import Designs, Task, compositions, evaluate


UNIT_1 = 344.7e3  # Pa, section 6
# 513 strains and 257 pressures: a free strain is good to 1e-5, a fall to what half a step of
# pressure makes of it where the free strain jumps
RESOLVED = 3e-4


@pytest.fixture(scope="module")
def muscle():
    found = fs.example("kim2021_slenderness_10")
    assert isinstance(found, fs.Muscle)
    return found


@pytest.fixture(scope="module")
def depths(muscle):
    designs = Designs.of(muscle, compositions(5))
    task = Task.of([100.0], [0.1], UNIT_1)
    values = evaluate(designs, task, ["reversal_depth"])["reversal_depth"]
    return dict(zip(designs.labels, values.tolist(), strict=True))


def test_all_sixteen_are_looked_at(depths):
    assert len(depths) == 16


def test_one_and_four_is_the_deepest_of_all(depths):
    others = [depth for label, depth in depths.items() if label != "1+4"]
    assert depths["1+4"] > max(others) + 10 * RESOLVED


def test_five_units_are_the_least_of_those_that_begin_with_one(depths):
    with_one = [depth for label, depth in depths.items() if label.startswith("1")]
    # some tie with it: theirs is the same first transition
    assert depths["1+1+1+1+1"] == min(with_one)


@pytest.mark.parametrize("valves", [2, 3, 4])
def test_with_as_many_valves_those_that_begin_with_several_reverse_less(depths, valves):
    of = {label: depth for label, depth in depths.items() if label.count("+") == valves - 1}
    with_one = [depth for label, depth in of.items() if label.startswith("1")]
    several = [depth for label, depth in of.items() if not label.startswith("1")]
    assert max(several) < min(with_one)


@pytest.mark.parametrize("label", ["1+4", "1+1+1+1+1"])
def test_the_depths_are_those_of_the_bundles(muscle, depths, label):
    units = [fs.MotorUnit(muscle, int(n)) for n in label.split("+")]
    turns = [reversal(fs.Bundle(units, UNIT_1), k).depth for k in range(2, len(units) + 1)]
    assert abs(depths[label] - np.max(turns)) < RESOLVED

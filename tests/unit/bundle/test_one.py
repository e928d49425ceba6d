"""One demand is answered as it is among many."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle.recruitment import recruit
from unlike import LAWS, SUPPLY, random_bundle


def demands(random, bundle, count):
    """Forces and strains: many small forces, some out of reach, some that a state's end gives."""
    units = len(bundle.motor_units)
    strain = random.uniform(-0.02, 0.33, count)
    full = np.abs(bundle.force(np.full(units, SUPPLY), strain))
    size = random.choice([1.0, 0.1, 0.01], count) * np.where(random.random(count) < 0.5, full, 300)
    force = random.uniform(-0.3, 1.1, count) * size
    if any(unit.muscle.tuning.dead_band for unit in bundle.motor_units):
        return force, strain  # within a dead band what an end gives is given all along
    ends = SUPPLY * np.tri(units + 1, units, -1)[random.integers(0, units + 1, count)]
    return np.where(random.random(count) < 0.1, bundle.force(ends, strain), force), strain


def same(one, many, i):
    """The `one` demand's answer and the `i`-th of `many`."""
    assert (one.status, one.count, one.state) == (many.status[i], many.count[i], many.state[i])
    assert (one.unit, one.stable) == (many.unit[i], many.stable[i])
    # what is nearest to a demand out of reach may be a turn, whose place has half of the digits
    close = 1e-9 if one.count else 1e-7
    assert_allclose(one.pressures, many.pressures[i], rtol=0, atol=close * SUPPLY)
    assert_allclose(one.force, many.force[i], rtol=0, atol=1e-9)
    slots = min(one.solutions.state.size, many.solutions.state.shape[1])
    assert one.count <= slots
    told = (x[:slots] for x in one.solutions), (x[i, :slots] for x in many.solutions)
    for mine, other in zip(*told, strict=True):
        assert_allclose(mine, other, rtol=0, atol=1e-9 * SUPPLY)
    for mine, other in zip(one, many, strict=True):
        if not isinstance(mine, tuple):
            assert np.asarray(mine).dtype == other.dtype and np.shape(mine) == other.shape[1:]


@pytest.mark.parametrize(
    ("laws", "resistance", "count"),
    [
        ("plain", True, 60),
        ("tuned", True, 40),
        ("plain", False, 40),
        pytest.param("plain", True, 600, marks=pytest.mark.slow),
        pytest.param("tuned", True, 400, marks=pytest.mark.slow),
        pytest.param("tuned", False, 400, marks=pytest.mark.slow),
    ],
)
def test_one_demand_is_answered_as_among_many(laws, resistance, count):
    random = np.random.default_rng(5)
    bundle = random_bundle(random, 4, **LAWS[laws])
    force, strain = demands(random, bundle, count)
    many = recruit(bundle, force, strain, resistance=resistance)
    assert set(many.status) > {0} or not resistance
    assert (many.count > 1).any() or not resistance or count < 60
    recruit(bundle, force[0], strain[0], resistance=resistance)
    for i in range(count):
        same(recruit(bundle, force[i], strain[i], resistance=resistance), many, i)


def test_muscles_of_unlike_lengths():
    random = np.random.default_rng(6)
    units = random_bundle(random, 3).motor_units
    longer = [
        fs.MotorUnit(unit.muscle.replace(length=length), unit.count)
        for unit, length in zip(units, (0.127, 0.13, 0.136), strict=True)
    ]
    bundle = fs.Bundle(longer, SUPPLY, length=0.13)
    strain = random.uniform(0.0, 0.2, 30)
    force = random.uniform(-0.05, 1.05, 30) * bundle.force(np.full(3, SUPPLY), strain)
    many = recruit(bundle, force, strain)
    for i in range(30):
        same(recruit(bundle, force[i], strain[i]), many, i)


def test_the_nearest_to_the_present_pressures():
    random = np.random.default_rng(7)
    bundle, count = random_bundle(random, 4), 40
    force, strain = demands(random, bundle, count)
    present = SUPPLY * random.random((count, 4))
    many = recruit(bundle, force, strain, prefer="nearest", present=present)
    few = [
        recruit(bundle, F, eps, prefer="nearest", present=now)
        for F, eps, now in zip(force, strain, present, strict=True)
    ]
    for i, one in enumerate(few):
        same(one, many, i)
    chosen = [np.argmax(one.solutions.pressure == one.pressures[one.unit - 1]) for one in few]
    assert max(chosen) > 0


@pytest.mark.parametrize("scheme", ["batch", "free"])
def test_other_schemes(scheme):
    random = np.random.default_rng(8)
    bundle = random_bundle(random, 3)
    force, strain = demands(random, bundle, 30)
    many = recruit(bundle, force, strain, scheme=scheme)
    for i in range(30):
        same(recruit(bundle, force[i], strain[i], scheme=scheme), many, i)


def test_equal_units_in_batches():
    bundle = fs.example("kim2021_bundle_1_4")
    force, strain = demands(np.random.default_rng(9), bundle, 40)
    many = recruit(bundle, force, strain, scheme="batch")
    for i in range(40):
        same(recruit(bundle, force[i], strain[i], scheme="batch"), many, i)

"""The inverse against the bundle's own force, and single demands against many.

`tests/validation/test_inverse.py` compares it with dense sampling.
"""

import copy
import math
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle import force_curves
from fascicle.bundle.recruitment import pressures_of, recruit
from unlike import LAWS, SUPPLY, random_bundle


thin = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")
bundle = fs.Bundle([fs.MotorUnit(thin), fs.MotorUnit(thin, 4)], SUPPLY)


def demands(random, bundle, count):
    """Forces and strains: many small forces, some out of reach, some at the end of a state."""
    units = len(bundle.motor_units)
    strain = random.uniform(-0.02, 0.33, count)
    full = np.abs(bundle.force(np.full(units, SUPPLY), strain))
    size = random.choice([1.0, 0.1, 0.01], count) * np.where(random.random(count) < 0.5, full, 300)
    force = random.uniform(-0.3, 1.1, count) * size
    if any(unit.muscle.tuning.dead_band for unit in bundle.motor_units):
        return force, strain  # within a dead band the force of an end is constant
    ends = SUPPLY * np.tri(units + 1, units, -1)[random.integers(0, units + 1, count)]
    return np.where(random.random(count) < 0.1, bundle.force(ends, strain), force), strain


def assert_same(single, many, i):
    """The result of a `single` demand is the `i`-th of `many`."""
    for name in ("status", "count", "state", "unit", "stable"):
        assert getattr(single, name) == getattr(many, name)[i]
    # the nearest force to a demand out of reach may be an extremum: its level has half the digits
    tolerance = 1e-9 if single.count else 1e-7
    assert_allclose(single.pressures, many.pressures[i], rtol=0, atol=tolerance * SUPPLY)
    assert_allclose(single.force, many.force[i], rtol=0, atol=1e-9)
    slots = min(single.solutions.state.size, many.solutions.state.shape[1])
    assert single.count <= slots
    for x, y in zip(single.solutions, many.solutions, strict=True):
        assert_allclose(x[:slots], y[i, :slots], rtol=0, atol=1e-9 * SUPPLY)
    for x, y in zip(single, many, strict=True):
        if not isinstance(x, tuple):
            assert np.asarray(x).dtype == y.dtype and np.shape(x) == y.shape[1:]


def longer(bundle):
    """The bundle with muscles of unequal length."""
    units = zip(bundle.motor_units, (0.127, 0.13, 0.136), strict=True)
    units = [fs.MotorUnit(unit.muscle.replace(length=length), unit.count) for unit, length in units]
    return fs.Bundle(units, SUPPLY, length=0.13)


@pytest.mark.parametrize(
    ("make", "options", "count"),
    [
        (lambda r: random_bundle(r, 4), {}, 30),
        (lambda r: random_bundle(r, 4, **LAWS["tuned"]), {}, 20),
        (lambda r: random_bundle(r, 4), {"resistance": False}, 20),
        (lambda r: random_bundle(r, 3), {"scheme": "batch"}, 15),
        (lambda r: random_bundle(r, 3), {"scheme": "free"}, 15),
        (lambda _: fs.example("kim2021_bundle_1_4"), {"scheme": "batch"}, 20),
        (lambda r: longer(random_bundle(r, 3)), {}, 15),
        pytest.param(lambda r: random_bundle(r, 4), {}, 600, marks=pytest.mark.slow),
        pytest.param(
            lambda r: random_bundle(r, 4, **LAWS["tuned"]), {}, 400, marks=pytest.mark.slow
        ),
        pytest.param(
            lambda r: random_bundle(r, 4, **LAWS["tuned"]), {"resistance": False}, 400,
            marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_a_single_demand_equals_the_same_demand_in_a_batch(monkeypatch, make, options, count):
    random = np.random.default_rng(5)
    bundle = make(random)
    force, strain = demands(random, bundle, count)
    monkeypatch.setattr(force_curves, "_BATCH", 7 * len(bundle.motor_units))
    many = recruit(bundle, force, strain, **options)
    monkeypatch.undo()
    reached = many.status == 0
    resistance = options.get("resistance", True)
    assert_allclose(bundle.force(many.pressures, strain, resistance), many.force, rtol=0, atol=1e-9)
    assert_allclose(many.force[reached], force[reached], rtol=0, atol=1e-8)
    for i in range(count):
        assert_same(recruit(bundle, force[i], strain[i], **options), many, i)


def test_threads_share_a_bundle():
    """Eight threads on one bundle give what one gives, whatever strains each asks for."""
    random = np.random.default_rng(11)
    made = random_bundle(random, 4)
    asks = []
    for i in range(16):
        strain = random.uniform(0.0, 0.02 + 0.018 * i, 40)
        asks.append((random.uniform(-20, 600, 40), strain))
    alone = [recruit(made, *ask) for ask in asks]
    shared = copy.copy(made)  # without what it remembers
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(lambda ask: recruit(shared, *ask), asks))
    for result, expected in zip(results, alone, strict=True):
        assert np.array_equal(result.status, expected.status)
        assert_allclose(result.pressures, expected.pressures, rtol=0, atol=1e-6 * SUPPLY)


def test_single_demands_select_the_solution_nearest_to_the_present_pressures():
    random = np.random.default_rng(7)
    bundle, count = random_bundle(random, 4), 40
    force, strain = demands(random, bundle, count)
    present = SUPPLY * random.random((count, 4))
    many = recruit(bundle, force, strain, prefer="nearest", present=present)
    slots = []
    for i in range(count):
        single = recruit(bundle, force[i], strain[i], prefer="nearest", present=present[i])
        assert_same(single, many, i)
        throttled = single.pressures[single.unit - 1]
        slots.append(np.argmax(single.solutions.pressure == throttled))
    assert max(slots) > 0


@pytest.mark.parametrize("scheme", ["orderly", "free"])
def test_units_of_unlike_laws(scheme):
    other = fs.Muscle(0.127, 8e-3, 1.6e-3, math.radians(30), "silicone_kim2021", tension="ideal")
    mixed = fs.Bundle([fs.MotorUnit(thin), fs.MotorUnit(other, 2), fs.MotorUnit(thin, 3)], SUPPLY)
    force, strain = np.array([20.0, 150.0, 500.0, 900.0]), 0.1
    result = recruit(mixed, force, strain, scheme=scheme)
    assert result.status.tolist() == [0] * 4
    assert_allclose(mixed.force(result.pressures, strain), force, rtol=0, atol=1e-8)


def test_states_and_shapes():
    force, strain = np.array([[0.0], [40.0], [400.0]]), np.array([0.02, 0.12])
    result = recruit(bundle, force, strain)
    assert result.pressures.shape == (3, 2, 2) and result.state.shape == (3, 2)
    assert result.state[1].tolist() == [1, 1] and result.state[2, 0] == 2
    assert np.all(np.asarray(result.pressures[2, 0])[:1] == SUPPLY)
    count = np.isfinite(np.asarray(result.solutions.pressure)).sum(axis=-1)
    assert count.tolist() == result.count.tolist()
    single = recruit(bundle, 40.0, 0.12)
    assert single.force.shape == () and single.pressures.shape == (2,)
    assert_allclose(single.pressures, result.pressures[1, 1], rtol=1e-12)


def test_forces_at_the_ends_of_states_have_one_solution_each():
    strain = 0.05
    ends = [bundle.force(P, strain) for P in ([0.0, 0.0], [SUPPLY, 0.0], [SUPPLY, SUPPLY])]
    result = recruit(bundle, np.array(ends), strain)
    assert result.status.tolist() == [0, 0, 0]
    assert result.state.tolist() == [1, 1, 2]
    assert result.pressures[1].tolist() == [SUPPLY, 0.0]
    assert result.pressures[2].tolist() == [SUPPLY, SUPPLY]
    assert_allclose(result.force, ends, atol=1e-9, rtol=0)
    # the end of state 1 is the beginning of state 2
    at_supply = np.isclose(result.solutions.pressure[1], SUPPLY).sum()
    at_nothing = (np.asarray(result.solutions.pressure[1]) == 0).sum()
    assert (at_supply, at_nothing) == (1, 0)


@pytest.mark.parametrize("state", [1, 2])
def test_solutions_close_to_the_ends_of_a_state(state):
    """A curve's end that is met is counted as such; a crossing beside it is another thing."""
    level = SUPPLY * np.array([1e-4, 0.003, 0.03, 0.97, 0.997, 0.9999])
    P, strain = pressures_of(state, level, SUPPLY, 2), 0.1
    result = recruit(bundle, bundle.force(P, strain), strain)
    is_own = result.solutions.state == state
    miss = np.where(is_own, np.abs(result.solutions.pressure - level[:, None]), np.inf)
    assert result.status.tolist() == [0] * 6 and np.all(miss.min(axis=1) < 1e-3)


def test_unreachable_demands_get_the_nearest_force():
    strain = np.array([0.05, 0.05])
    result = recruit(bundle, np.array([5000.0, -5000.0]), strain)
    assert result.status.tolist() == [1, 2]
    assert result.count.tolist() == [0, 0]
    assert_allclose(result.force[0], bundle.force([SUPPLY, SUPPLY], 0.05))
    level = np.linspace(0, SUPPLY, 20001)
    least = min(
        float(jnp.min(bundle.force(pressures_of(k, level, SUPPLY, 2), 0.05))) for k in (1, 2)
    )
    # a kink between the grid's points may lie lower, by no more than its step
    assert least - 0.05 < result.force[1] <= least + 1e-9


def test_stability_is_the_sign_of_the_slope_in_strain():
    strain, step = 0.2, 1e-6
    result = recruit(bundle, bundle.force([SUPPLY, 0.0], strain) - 1.0, strain)
    assert result.count > 1
    for level, state, stable in zip(*(x[: result.count] for x in result.solutions), strict=True):
        P = pressures_of(int(state), level, SUPPLY, 2)
        slope = bundle.force(P, strain + step) - bundle.force(P, strain - step)
        assert bool(stable) == bool(slope < 0)


def test_arrays_of_jax_are_numbers_and_traced_ones_are_refused():
    plain, given = recruit(bundle, 60.0, 0.1), recruit(bundle, jnp.asarray(60.0), jnp.asarray(0.1))
    assert_allclose(given.pressures, plain.pressures, rtol=1e-14)
    assert isinstance(given.pressures, np.ndarray)
    with pytest.raises(fs.InvalidInputError) as error:
        jax.jit(lambda force: recruit(bundle, force, 0.1).pressures)(60.0)
    assert error.value.argument == "force"


def test_without_resistance_no_unit_pushes():
    result = recruit(bundle, np.array([-5.0, 30.0]), 0.15, resistance=False)
    assert result.status.tolist() == [2, 0] and result.force[0] == 0
    assert_allclose(bundle.force(result.pressures[1], 0.15, resistance=False), 30.0, atol=1e-9)


def test_narrow_rise_of_steep_fibers_is_found():
    # the free strain of the steep muscle rises from 0.07 to 0.21 between 42 and 48 kPa, in which
    # the force of both rises and falls again
    steep = fs.Muscle(
        0.1564392, 3.085767e-3, 0.5948e-3, 0.2503973,
        fs.MooneyRivlin(39967.6, 101328.3, youngs_modulus=6813941.0, poisson_ratio=0.3480493),
        collapse=fs.collapse.Kim2021Collapse(0.5),
        tuning=fs.Tuning(
            [100e3, 250e3], [0.044067, -0.0335], [0.988485, 0.997714],
            youngs_modulus_factor=0.634518, collapse_moment_factor=1.099047,
            hinge_stiffness_factor=0.739363, hinge_stiffness_slope=1.253058e-5,
            transition_rate=60.43266,
        ),
    )  # fmt: skip
    other = fs.Muscle(
        0.1564392, 4.371344e-3, 0.6856914e-3, 0.5536535,
        fs.MooneyRivlin(28322.17, 30594.65, youngs_modulus=562409.8, poisson_ratio=0.3990455),
        transition_rate=20.1518,
    )  # fmt: skip
    bundle = fs.Bundle([fs.MotorUnit(steep, 4), fs.MotorUnit(other, 2)], 217866.143, "batch")
    strain, pressure = 0.2250951418, np.linspace(0.0, 217866.143, 20001)
    force = np.asarray(bundle.force(np.stack([pressure, pressure], axis=-1), strain))
    inside = (pressure > 43e3) & (pressure < 45e3)
    demand = force[inside].max() - 1e-3
    above = force > demand
    crossings = np.count_nonzero(above[1:] != above[:-1])
    found = bundle.recruit(demand, strain).solutions
    assert np.count_nonzero(found.state == 2) == crossings == 4

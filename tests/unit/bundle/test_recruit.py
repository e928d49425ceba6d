"""The inverse against the bundle's own force, and against a search that doesn't know it."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle import inverse
from fascicle.bundle.recruitment import pressures_of, recruit
from unlike import SUPPLY, random_bundle


FINE = 4001
thin = fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")
bundle = fs.Bundle([fs.MotorUnit(thin), fs.MotorUnit(thin, 4)], SUPPLY)


def three(seed: int, scheme: str) -> fs.Bundle:
    """Unlike motor units."""
    return random_bundle(np.random.default_rng(seed), rates=(25.0, 100.0), scheme=scheme)


def demands(seed: int, one: fs.Bundle, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Forces and strains, half of them among the small forces where states overlap."""
    random = np.random.default_rng(seed)
    strain = random.uniform(-0.02, 0.3, count)
    full = np.abs(np.asarray(one.force(np.full(3, SUPPLY), strain)))
    force = random.uniform(-0.1, 1.1, count) * np.where(
        np.arange(count) % 2, full, 0.1 * full.max()
    )
    return force, strain


def by_brute_force(one: fs.Bundle, force: np.ndarray, strain: np.ndarray):
    """Demand, state and level [Pa] around each change of sign on a fine grid, and how far the
    forces of all its points are from the demand at least [N].
    """
    level = np.linspace(0, SUPPLY, FINE)
    crossings, nearest = [], np.full(force.size, np.inf)
    for state in range(1, len(one.motor_units) + 1):
        P = pressures_of(state, level, SUPPLY, len(one.motor_units), one.scheme)
        over = np.asarray(one.force(P, strain[:, None])) - force[:, None]
        n, i = np.nonzero(over[:, :-1] * over[:, 1:] < 0)
        crossings += [(*x, state) for x in zip(n.tolist(), level[i], level[i + 1], strict=True)]
        nearest = np.minimum(nearest, np.abs(over).min(axis=1))
    return crossings, nearest


def check(seed: int, scheme: str, count: int, part: int = 0) -> int:
    """Demands that brute force can reach [-], all of which the inverse must have found."""
    one = three(seed, scheme)
    force, strain = demands(100 * seed + part, one, count)
    found = recruit(one, force, strain)
    assert_allclose(one.force(found.pressures, strain), found.force, atol=1e-9, rtol=0)
    reached = np.asarray(found.status) == 0
    assert_allclose(np.asarray(found.force)[reached], force[reached], atol=1e-9, rtol=0)
    crossings, nearest = by_brute_force(one, force, strain)
    pressure, state = (np.asarray(x) for x in (found.solutions.pressure, found.solutions.state))
    assert np.all(np.asarray(found.count) <= pressure.shape[1])
    for n, low, high, k in crossings:
        near = (pressure[n] > low - 1e-3) & (pressure[n] < high + 1e-3) & (state[n] == k)
        assert near.any(), (seed, scheme, force[n], strain[n], k, low, high, pressure[n], state[n])
    assert reached[[n for n, *_ in crossings]].all()
    # and none that isn't: each goes forward to the demand
    for k in (1, 2, 3):
        n, slot = np.nonzero(state == k)
        P = pressures_of(k, pressure[n, slot], SUPPLY, 3, scheme)
        assert_allclose(one.force(P, strain[n]), force[n], atol=1e-9, rtol=0)
    # what isn't reached is answered with the nearest there is, and never worse than the grid
    apart = np.abs(np.asarray(found.force) - force)
    assert np.all(apart <= nearest + 1e-9)
    above = np.asarray(found.force) < force
    assert_allclose(found.status, np.where(reached, 0, np.where(above, 1, 2)))
    return len(crossings)


@pytest.mark.parametrize(
    ("scheme", "count"),
    [
        ("orderly", 12),
        ("batch", 12),
        pytest.param("orderly", 100, marks=pytest.mark.slow),
        pytest.param("batch", 100, marks=pytest.mark.slow),
    ],
)
def test_none_is_missed(scheme, count):
    assert check(0, scheme, count) > count / 2


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["orderly", "batch"])
@pytest.mark.parametrize("seed", range(1, 21))
def test_none_is_missed_by_twenty_random_bundles(seed, scheme):
    # 100 at a time: the fine grid takes the memory
    assert sum(check(seed, scheme, 100, part) for part in range(5)) > 200


@pytest.mark.parametrize("scheme", ["orderly", pytest.param("batch", marks=pytest.mark.slow)])
def test_many_are_answered_as_few_are(monkeypatch, scheme):
    one = three(3, scheme)
    force, strain = demands(4, one, 60)
    few = recruit(one, force, strain)
    monkeypatch.setattr(inverse, "FEW_CELLS", 0)  # cells are selected by a table
    monkeypatch.setattr(inverse, "BATCH", 7)
    many = recruit(one, force, strain)
    for x, y in zip(jax.tree.leaves(few), jax.tree.leaves(many), strict=True):
        # where the nearest force is a turn's, its level is known to the root of rounding
        assert_allclose(x, y, rtol=1e-12, atol=1e-6 * SUPPLY)
    assert_allclose(few.force, many.force, rtol=0, atol=1e-9)
    assert_allclose(few.solutions.pressure, many.solutions.pressure, rtol=0, atol=1e-9 * SUPPLY)


@pytest.mark.parametrize("scheme", ["orderly", "free"])
def test_units_of_unlike_laws(scheme):
    """Their muscles are in rows apart, each by its own law."""
    other = fs.Muscle.from_dimensions(
        0.127, 8e-3, 1.6e-3, math.radians(30), "silicone_kim2021", tension="ideal"
    )
    mixed = fs.Bundle([fs.MotorUnit(thin), fs.MotorUnit(other, 2), fs.MotorUnit(thin, 3)], SUPPLY)
    force, strain = np.array([20.0, 150.0, 500.0, 900.0]), 0.1
    found = recruit(mixed, force, strain, scheme=scheme)
    assert found.status.tolist() == [0] * 4
    assert_allclose(mixed.force(found.pressures, strain), force, rtol=0, atol=1e-8)


def test_states_and_shapes():
    force, strain = np.array([[0.0], [40.0], [400.0]]), np.array([0.02, 0.12])
    found = recruit(bundle, force, strain)
    assert found.pressures.shape == (3, 2, 2)
    assert found.state.shape == found.status.shape == found.count.shape == (3, 2)
    assert found.solutions.pressure.shape[:2] == (3, 2)
    assert found.state[1].tolist() == [1, 1] and found.state[2, 0] == 2
    assert np.all(np.asarray(found.pressures[2, 0])[:1] == SUPPLY)
    count = np.isfinite(np.asarray(found.solutions.pressure)).sum(axis=-1)
    assert count.tolist() == found.count.tolist()
    one = recruit(bundle, 40.0, 0.12)
    assert one.force.shape == () and one.pressures.shape == (2,)
    assert_allclose(one.pressures, found.pressures[1, 1], rtol=1e-12)


def test_exact_ends_are_found_and_counted_once():
    strain = 0.05
    ends = [bundle.force(P, strain) for P in ([0.0, 0.0], [SUPPLY, 0.0], [SUPPLY, SUPPLY])]
    found = recruit(bundle, np.array(ends), strain)
    assert found.status.tolist() == [0, 0, 0]
    assert found.state.tolist() == [1, 1, 2]
    assert found.pressures[1].tolist() == [SUPPLY, 0.0]
    assert found.pressures[2].tolist() == [SUPPLY, SUPPLY]
    assert_allclose(found.force, ends, atol=1e-9, rtol=0)
    # the end of state 1 is the beginning of state 2
    at_supply = np.isclose(found.solutions.pressure[1], SUPPLY).sum()
    at_nothing = (np.asarray(found.solutions.pressure[1]) == 0).sum()
    assert (at_supply, at_nothing) == (1, 0)


@pytest.mark.parametrize("state", [1, 2])
def test_levels_close_to_a_states_ends_are_found(state):
    """A curve's end that is met is counted as such; a crossing beside it is another thing."""
    level = SUPPLY * np.array([1e-4, 0.003, 0.03, 0.97, 0.997, 0.9999])
    P, strain = pressures_of(state, level, SUPPLY, 2), 0.1
    found = recruit(bundle, bundle.force(P, strain), strain)
    there = found.solutions.state == state
    away = np.where(there, np.abs(found.solutions.pressure - level[:, None]), np.inf)
    assert found.status.tolist() == [0] * 6 and np.all(away.min(axis=1) < 1e-3)


def test_out_of_reach_is_answered_with_the_nearest():
    strain = np.array([0.05, 0.05])
    found = recruit(bundle, np.array([5000.0, -5000.0]), strain)
    assert found.status.tolist() == [1, 2]
    assert found.count.tolist() == [0, 0]
    assert_allclose(found.force[0], bundle.force([SUPPLY, SUPPLY], 0.05))
    level = np.linspace(0, SUPPLY, 20001)
    least = min(
        float(jnp.min(bundle.force(pressures_of(k, level, SUPPLY, 2), 0.05))) for k in (1, 2)
    )
    # a kink between the grid's points may lie lower, by no more than its step
    assert least - 0.05 < found.force[1] <= least + 1e-9


def overlapping() -> tuple[float, float]:
    """A demand that several pressures meet."""
    strain = 0.2
    low = float(bundle.force([SUPPLY, 0.0], strain))
    return low - 1.0, strain


def test_the_nearest_to_the_present_state_is_taken():
    force, strain = overlapping()
    every = recruit(bundle, force, strain)
    assert every.count > 1
    for slot in range(int(every.count)):
        k, level = int(every.solutions.state[slot]), every.solutions.pressure[slot]
        present = pressures_of(k, level, SUPPLY, 2)
        found = recruit(bundle, force, strain, prefer="nearest", present=present)
        assert_allclose(found.pressures, present, atol=1e-3)
    assert int(every.state) == int(every.solutions.state[0])


def test_stability_is_the_sign_of_the_slope_in_strain():
    force, strain = overlapping()
    found = recruit(bundle, force, strain)
    for slot in range(int(found.count)):
        P = pressures_of(
            int(found.solutions.state[slot]), found.solutions.pressure[slot], SUPPLY, 2
        )
        step = 1e-6
        slope = bundle.force(P, strain + step) - bundle.force(P, strain - step)
        assert bool(found.solutions.stable[slot]) == bool(slope < 0)


# they are one derivative, transposed: each mode compiles for long
@pytest.mark.parametrize("mode", [pytest.param("forward", marks=pytest.mark.slow), "reverse"])
def test_derivatives_are_those_of_finite_differences(mode):
    def pressures(force, strain, radius):
        muscle = fs.Muscle.from_dimensions(
            0.127, radius, 1.6e-3, math.radians(33), "silicone_kim2021"
        )
        one = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)], SUPPLY)
        found = recruit(one, force, strain)
        return found.pressures[1], found.force

    at, steps = (150.0, 0.08, 6.35e-3), (1e-3, 1e-7, 1e-8)
    if mode == "forward":
        slopes, of_force = jax.jit(jax.jacfwd(pressures, argnums=(0, 1, 2)))(*at)
    else:
        # compiled in parts: as one program it takes twice as long
        (value, _), back = jax.vjp(pressures, *at)
        assert 0 < value < SUPPLY
        slopes, of_force = back((1.0, 0.0)), back((0.0, 1.0))
    for i, step in enumerate(steps):
        # NumPy's, which needs no compiler
        moved = [pressures(*(x + s * (j == i) for j, x in enumerate(at))) for s in (step, -step)]
        expected = (moved[0][0] - moved[1][0]) / (2 * step)
        assert_allclose(slopes[i], expected, rtol=1e-5)
    # a force that is reached is the demanded one
    assert_allclose(of_force, [1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.slow
def test_vmap_is_the_batch():
    force, strain = np.array([20.0, 60.0]), np.array([0.05, 0.12])
    batch = recruit(bundle, force, strain)
    mapped = jax.vmap(lambda f, e: recruit(bundle, f, e))(force, strain)
    assert_allclose(mapped.pressures, batch.pressures, rtol=1e-12)
    assert mapped.state.tolist() == batch.state.tolist()


def test_without_resistance_nothing_pushes():
    found = recruit(bundle, np.array([-5.0, 30.0]), 0.15, resistance=False)
    assert found.status.tolist() == [2, 0] and found.force[0] == 0
    assert_allclose(bundle.force(found.pressures[1], 0.15, resistance=False), 30.0, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((np.nan, 0.1), {}, "`force` must lie in"),
        ((10.0, 0.7), {}, "`strain` must lie in"),
        ((10.0, 0.1, -1.0), {}, "`supply_pressure` must lie in"),
        ((10.0, 0.1), {"scheme": "ordrly"}, "`scheme` 'ordrly' is unknown: did you mean"),
        ((10.0, 0.1), {"prefer": "cheap"}, "`prefer` 'cheap' is unknown"),
        ((10.0, 0.1), {"prefer": "nearest"}, "`present` must be given in Pa"),
        ((10.0, 0.1), {"prefer": "nearest", "present": [1e5]}, "one pressure for each of the 2"),
    ],
)
def test_refuses_what_can_not_be(arguments, options, message):
    with pytest.raises(ValueError, match=message):
        recruit(bundle, *arguments, **options)


def test_refuses_a_bundle_without_a_supply():
    with pytest.raises(ValueError, match="`supply_pressure` must be given"):
        recruit(fs.Bundle(bundle.motor_units), 10.0, 0.1)

"""Feedforward by tables: there and back, against `recruit`, under jit, differentiated."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle import control


SUPPLY = 413.7e3
STRAINS = np.array([-0.08, -0.01, 0.0, 0.03, 0.045, 0.1, 0.15, 0.2, 0.24, 0.25])


@pytest.fixture(scope="module")
def branches(five):
    return control.Branches.of(five)


def test_pressure_inverts_force(branches):
    eps = STRAINS[:, None, None] + np.zeros(2)
    none = np.zeros_like(eps)
    empty, full = branches.force(none, eps), branches.force(none + SUPPLY, eps)
    force = empty + (full - empty) * np.linspace(1e-3, 1 - 1e-3, 57)[:, None]
    P = branches.pressure(force, eps)
    # Newton's method on the table that the force is from: to rounding
    assert_allclose(branches.force(P, eps), force, rtol=0, atol=1e-8)
    assert np.all(branches.onset(eps) <= P) and np.all(P <= SUPPLY)
    assert np.all(np.diff(P, axis=1) > 0)


def test_onsets_are_those_of_the_law(branches, five):
    strain = np.array([0.03, 0.06, 0.1, 0.15, 0.2, 0.24])
    result = branches.onset(strain[:, None] + np.zeros(2))[:, 0]
    right = control.transition(five, strain).onset_pressure
    # the table's force is off by up to 0.01 N near the kinks, of some 1e-4 N/Pa and more
    assert_allclose(result, right, rtol=1e-3, atol=1)
    assert_array_equal(branches.onset(np.full((1, 2), -0.05)), 0.0)
    assert_array_equal(branches.onset(np.full((1, 2), 0.3)), SUPPLY)


def test_pressures_equal_those_of_recruit(branches, five):
    for strain in (0.05, 0.15, 0.2):
        both = five.force([SUPPLY, SUPPLY], strain)
        one = control.transition(five, strain).largest_force
        demand = np.r_[np.linspace(0.3, 0.95, 5) * one, np.linspace(1.05 * one, 0.95 * both, 5)]
        right = fs.recruitment.recruit(five, demand, strain)
        empty, full = (
            np.asarray(branches.force(np.full(2, P), np.full(2, strain))) for P in (0.0, SUPPLY)
        )
        first = demand - 4 * empty[1]
        second = (demand - full[0]) / 4
        result = branches.pressure(np.stack([first, second], axis=-1), np.full(2, strain))
        throttled = np.where(right.unit == 1, result[:, 0], result[:, 1])
        others = np.where(right.unit == 1, right.pressures[:, 0], right.pressures[:, 1])
        # a table off by 0.02 N in all, of some 1e-4 N/Pa
        assert_allclose(throttled, others, rtol=0, atol=300)


def test_unreachable_forces_have_the_nearest_pressure(branches):
    eps = np.array([[0.1, 0.1], [0.3, 0.3]])
    empty, full = branches.force(0 * eps, eps), branches.force(0 * eps + SUPPLY, eps)
    less, more = branches.pressure(empty - 1, eps), branches.pressure(full + 1, eps)
    assert_array_equal(less, 0.0)
    assert_array_equal(more, [[SUPPLY] * 2, [0.0] * 2])
    # nothing that is asked makes no number
    far = branches.pressure(np.array([-1e9, 0.0, 1e9])[:, None] + np.zeros(2), np.full(2, 0.59))
    assert np.all(np.isfinite(far))


def test_numpy_and_jax_agree_and_gradients_are_those_of_the_law(branches):
    force, eps = jnp.array([20.0, 15.0]), jnp.array([0.15, 0.15])
    result = jax.jit(lambda b, f, e: b.pressure(f, e))(branches, force, eps)
    plain = branches.pressure(np.asarray(force), np.asarray(eps))
    assert_allclose(result, plain, rtol=1e-9)
    assert isinstance(plain, np.ndarray)
    # slopes are finite also where nothing can be reached
    unreachable = [[f, f, e, e] for f in (-1e3, 0.0, 1e3) for e in (-0.08, 0.0, 0.1, 0.3)]
    cases = jnp.array([[*force, *eps], *unreachable])
    slopes = jax.jit(jax.vmap(jax.grad(lambda x: jnp.sum(branches.pressure(x[:2], x[2:])))))(cases)
    assert np.all(np.isfinite(slopes))
    at = branches.muscles.at(plain, np.asarray(eps))
    assert_allclose(slopes[0, :2], 1 / at.force_by_pressure, rtol=1e-6)


def test_different_muscles_have_branches_of_their_own(muscle):
    wide = muscle.replace(outer_radius=8e-3, wall_thickness=1.4e-3)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(wide), fs.MotorUnit(muscle)], SUPPLY)
    result = control.Branches.of(bundle, shape=(81, 101))
    P = np.array([2e5, 3e5, 2e5])
    eps = np.full(3, 0.15)
    assert_allclose(result.pressure(result.force(P, eps), eps), P, rtol=1e-9)
    assert result.onset(eps)[0] == result.onset(eps)[2] != result.onset(eps)[1]

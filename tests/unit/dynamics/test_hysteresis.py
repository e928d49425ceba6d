"""Friction that remembers: closed loops, ways in parts, energies, and what it refuses."""

from itertools import pairwise

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.dynamics import Coulomb, Dahl, MaxwellSlip
from fascicle.muscle.hysteresis import Motion


K, F, X = 4e3, 3.0, 2e-3  # of a muscle's braid, about
AREAS = {
    "slip": (MaxwellSlip(K, F), 4 * F * (X - F / K)),
    "dahl": (Dahl(K, F), 4 * F * (X - F / K * np.tanh(K * X / F))),
}


def walked(law, places, pressures=0.0):
    """Force after each of the places, stored energy there, and energy lost on each way to it."""
    P = np.broadcast_to(pressures, np.shape(places))
    kept = np.zeros(law.count)
    force, stored, lost = [np.zeros(())], [np.zeros(())], []
    for k in range(1, len(places)):
        way = np.float64(places[k] - places[k - 1])
        slid = law.advance(kept, Motion(way, np.float64(0), (P[k - 1], P[k]), np.float64(0)))
        kept = slid.spring_forces
        force.append(slid.force)
        stored.append(law.stored(kept))
        lost.append(slid.loss)
    return np.array(force), np.array(stored), np.array(lost)


def between(corners, steps):
    """Places on the way from corner to corner, so many steps each."""
    ways = (np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(corners))
    return np.concatenate([corners[:1], *ways])


@pytest.fixture(params=AREAS)
def law(request):
    return AREAS[request.param]


def test_loss_of_a_closed_loop_equals_the_closed_form(law):
    friction, area = law
    once = np.concatenate([np.linspace(X, -X, 401), np.linspace(-X, X, 401)[1:]])
    # Dahl's spring settles by exp(−4 k X/f) = 2e-5 a loop, so that the last of four is closed
    places = np.concatenate([np.linspace(0, X, 201), *4 * [once[1:]]])
    force, stored, lost = walked(friction, places)
    assert_allclose(np.sum(lost[-800:]), area, rtol=1e-12)
    # the same from the force itself, by the trapezoids between places
    loop = np.trapezoid(force[-801:], places[-801:])
    assert_allclose(loop, area, rtol=1e-4)
    assert_allclose(stored[-1], stored[-801], rtol=1e-9)


def test_a_displacement_in_steps_equals_the_whole(law):
    friction, _ = law
    corners = np.array([0.0, X, -X, 0.3 * X, -0.1 * X])
    parts = between(corners, 50)
    whole, in_parts = walked(friction, corners), walked(friction, parts)
    assert_allclose(in_parts[0][::50], whole[0], atol=1e-12 * F)
    assert_allclose(in_parts[1][::50], whole[1], atol=1e-12 * F * X)
    assert_allclose(in_parts[2].reshape(4, 50).sum(axis=1), whole[2], atol=1e-12 * F * X)


@pytest.mark.parametrize("pressures", [0.0, "swings"])
def test_no_path_creates_energy(law, pressures):
    rng = np.random.default_rng(3)
    places = np.cumsum(rng.normal(size=400)) * 3e-4
    P = 0.0 if pressures == 0.0 else rng.uniform(0, 4e5, 400)
    friction = law[0].__class__(K, F, 1e-5)
    force, stored, lost = walked(friction, places, P)
    # a rounding of k Δx/k
    assert np.all(lost >= -1e-15)
    assert np.all(stored >= 0)
    assert np.all(np.abs(force) <= F + 1e-5 * 4e5)


def test_work_is_lost_or_stored(law):
    rng = np.random.default_rng(4)
    friction = law[0]
    corners = np.concatenate([[0.0], rng.uniform(-X, X, 6)])
    places = between(corners, 2000)
    force, stored, lost = walked(friction, places)
    work = np.trapezoid(force, places)
    # trapezoids of 2000 steps a way miss the springs' kinks by 1e-6 of f X each
    assert_allclose(work, stored[-1] + lost.sum(), atol=1e-5 * F * X)


def test_springs_are_parallel():
    both = MaxwellSlip([4e3, 9e3], [3.0, 1.0])
    places = np.array([0, 2e-3, -1e-3, 5e-4])
    each = [walked(MaxwellSlip(k, f), places) for k, f in ((4e3, 3.0), (9e3, 1.0))]
    for got, first, second in zip(walked(both, places), *each, strict=True):
        assert_allclose(got, first + second, rtol=1e-14)


def test_slip_rises_with_pressure():
    places = np.array([0.0, 1.0])
    for friction in (MaxwellSlip(K, F, 1e-5), Dahl(K, F, 1e-5)):
        for P in (0.0, 2e5):
            assert_allclose(walked(friction, places, P)[0][-1], F + 1e-5 * P, rtol=1e-14)
        # no less than at none where a chamber sucks
        assert_allclose(walked(friction, places, -3e4)[0][-1], F, rtol=1e-14)


def test_width_of_coulomb_friction_is_a_pressure():
    friction, by_pressure = Coulomb(1e4), np.array([2e-4, -2e-4])
    fast = np.array([1.0, 1.0])
    motion = Motion(0 * fast, fast, (fast, fast), by_pressure)
    slid = friction.advance(np.zeros((2, 0)), motion)
    # against the motion, whichever way the force goes with pressure
    assert_allclose(slid.force, 1e4 * 2e-4, rtol=1e-14)
    assert_allclose(friction.lost_power(motion._replace(velocity=-fast)), 2.0, rtol=1e-14)
    at_v0 = friction.advance(np.zeros((2, 0)), motion._replace(velocity=1e-3 * fast))
    assert_allclose(at_v0.force / slid.force, np.tanh(1), rtol=1e-14)


@pytest.mark.parametrize("friction", [law for law, _ in AREAS.values()])
def test_gradients_are_finite_at_rest(friction):
    def force(way):
        none = 0.0 * way
        return friction.advance(np.zeros(1), Motion(way, none, (none, none), none)).force

    # at rest a spring is bent by k
    assert_allclose(jax.grad(force)(0.0), K, rtol=1e-12)

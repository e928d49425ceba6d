import math

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.tension import Kothera2009


L0, R0, T0, ANGLE, E = 0.127, 6.35e-3, 1.6e-3, math.radians(33), 1.78e6


def muscle(law, wall=T0):
    return fs.Muscle(L0, R0, wall, ANGLE, "silicone_kim2021", tension=law)


def sizes(eps, wall=T0):
    """Turns, fiber length, and length, radius and wall at a strain, from the geometry alone."""
    B, N = L0 / math.cos(ANGLE), L0 * math.tan(ANGLE) / (2 * math.pi * R0)
    L = L0 * (1 - eps)
    R = np.sqrt(B**2 - L**2) / (2 * math.pi * N)
    V = math.pi * (R0**2 - (R0 - wall) ** 2) * L0
    return N, B, L, R, R - np.sqrt(R**2 - V / (math.pi * L)), V


def test_it_is_the_published_balance_of_forces():
    P, eps = np.array([[0.0], [50e3], [400e3]]), np.linspace(-0.05, 0.3, 8)
    N, B, L, R, t, V = sizes(eps)
    gaylord = P * (3 * L**2 - B**2) / (4 * math.pi * N**2)
    thick = P * (V / L - t * L**2 / (2 * math.pi * R * N**2))
    axial = E * V * (1 / L0 - 1 / L)
    hoop = -E * (R / R0 - 1) * t * L**2 / (2 * math.pi * R * N**2)
    mesh, wall = Kothera2009().components(muscle("ideal").bladder, P, eps)
    assert_allclose(mesh, gaylord + thick, rtol=1e-11, atol=1e-9)  # of 100 N
    assert_allclose(wall, axial + hoop, rtol=1e-11, atol=1e-11)
    mesh, same = Kothera2009("ideal").components(muscle("ideal").bladder, P, eps)
    assert_allclose(mesh, gaylord, rtol=1e-11, atol=1e-9)
    assert np.array_equal(same, wall)


def test_a_thin_wall_has_the_published_hoop_term():
    # t r L is then constant, so −(r/r0 − 1) t L is t L − t0 L0, up to the order t/r that was left
    eps = np.linspace(0.02, 0.3, 8)
    errors = []
    for wall in (0.02 * R0, 0.01 * R0):
        N, _, L, R, t, V = sizes(eps, wall)
        published = E * L / (2 * math.pi * R * N**2) * (t * L - wall * L0)
        axial = E * V * (1 / L0 - 1 / L)
        _, found = Kothera2009().components(muscle("ideal", wall).bladder, 0.0, eps)
        errors.append(np.max(np.abs((found - axial) / published - 1)))
    assert errors[0] < 0.05
    assert_allclose(errors[1] / errors[0], 0.5, atol=0.02)  # of first order


@pytest.mark.parametrize("law", [Kothera2009(), Kothera2009("ideal")])
def test_the_wall_resists_either_way_and_free_strain_rises(law):
    made = muscle(law)
    eps = np.linspace(-0.19, 0.6, 80)
    wall = np.asarray(law.components(made.bladder, 0.0, eps)[1])
    assert np.all(wall[eps < 0] > 0) and np.all(wall[eps > 0] < 0)
    assert np.all(np.diff(wall[eps > -0.1]) < 0)  # softening only where the bore is closing
    free = np.asarray(made.free_strain(np.concatenate([[0.0], np.geomspace(1, 1e6, 20)])))
    assert free[0] == 0 and np.all(np.diff(free) > 0)


def test_pressure_on_the_bore_pulls_less_at_rest():
    # (1 − τ)(2 cot²α + τ − 1) of π r0² P, against 2 cot²α − 1
    tau, c = T0 / R0, 1 / math.tan(ANGLE) ** 2
    expected = math.pi * R0**2 * 1e5 * (1 - tau) * (2 * c + tau - 1)
    assert_allclose(muscle("kothera2009").blocked_force(1e5), expected, rtol=1e-13)
    ideal = math.pi * R0**2 * 1e5 * (2 * c - 1)
    assert_allclose(muscle(Kothera2009("ideal")).blocked_force(1e5), ideal, rtol=1e-13)


def test_without_a_bore_pressure_has_nothing_to_push():
    # the wall fills the braid where r² λ = A/π
    thick = muscle("kothera2009", 0.9 * R0)
    eps = np.array([-0.15, -0.1])
    assert np.array_equal(thick.response(3e5, eps).mesh, [0, 0])
    slopes = jax.jit(jax.vmap(jax.grad(thick.force, (0, 1)), (None, 0)))(3e5, eps)
    assert np.all(np.isfinite(slopes)) and np.all(np.asarray(slopes[1]) < 0)

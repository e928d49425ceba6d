import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.tension import (
    Ideal,
    KluteHannaford,
    Kothera2009,
    Meller2014,
    TonduLopez,
)


ANGLE = np.radians(33)
SIZES = (0.127, 6.35e-3, 1.6e-3, ANGLE)
muscle = fs.Muscle(*SIZES, material="silicone_kim2021")
ideal = fs.Muscle(*SIZES, tension="ideal")


def no_offset(pressure):
    return jnp.zeros_like(pressure)


def test_no_pressure_no_free_strain():
    assert muscle.free_strain(0.0) == 0
    # near rest F ≈ F_b'(0) ε + P A_m: the slope at P = 0 is finite and of the ratio's size
    slope = jax.jit(jax.grad(muscle.free_strain))(0.0)
    mesh = np.pi * 6.35e-3**2 * (3 / np.tan(ANGLE) ** 2 - 1 / np.sin(ANGLE) ** 2)
    wall = -jax.grad(muscle.bladder.force)(0.0)
    assert_allclose(slope, mesh / wall, rtol=1e-12)


def test_ideal_free_strain_is_that_of_the_braid():
    P = np.array([0.0, 1.0, 1e6])
    assert_allclose(ideal.free_strain(P), 1 - 1 / (np.sqrt(3) * np.cos(ANGLE)), rtol=1e-14)
    assert_allclose(ideal.response(1e5, 0.1).bladder, 0, atol=0)
    assert_allclose(ideal.force(1e5, 0.1), ideal.braid.mesh_force(1e5, 0.1), rtol=1e-15)


LAWS = [
    KluteHannaford(), Ideal(), TonduLopez(1.2, 0.3), Meller2014(1.15, 0.9), Kothera2009(),
    Kothera2009("ideal"),
]  # fmt: skip
every = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)


@every
def test_offset_moves_the_free_strain(law):
    P, c1 = jnp.array([5e4, 2e5]), lambda P: 2e-5 * P
    found = law.free_strain(muscle.bladder, P, c1)
    mesh, wall = law.components(muscle.bladder, P, found)
    assert_allclose(mesh + wall, c1(P), rtol=1e-11)
    assert np.all(np.asarray(found) < law.free_strain(muscle.bladder, P, no_offset))


def test_ideal_offset_has_its_limit_without_pressure():
    def offset(P):
        return 2e-5 * P

    without = Ideal().free_strain(muscle.bladder, 0.0, offset)
    # C1/P is constant here, so the free strain is the same at every pressure
    assert_allclose(without, Ideal().free_strain(muscle.bladder, 1e5, offset), rtol=1e-14)
    slope = jax.grad(lambda P: Ideal().free_strain(muscle.bladder, P, offset))(0.0)
    assert np.isfinite(slope)


@pytest.mark.parametrize("of", [muscle, *(fs.Muscle(*SIZES, tension=law) for law in LAWS)])
def test_free_strain_has_a_gradient_in_every_parameter(of):
    slopes = eqx.filter_jit(eqx.filter_grad(lambda m: m.free_strain(1e5)))(of)
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(slopes))
    step = 1e-6  # central differences of a smooth root: good to 1e-9 or so
    moved = [eqx.tree_at(lambda m: m.braid_angle, of, ANGLE + s) for s in (step, -step)]
    measured = (moved[0].free_strain(1e5) - moved[1].free_strain(1e5)) / (2 * step)
    assert_allclose(slopes.braid_angle, measured, rtol=1e-7)


def test_derivative_of_a_free_strain_at_the_end_of_its_search():
    muscle = fs.Muscle(0.066, 2.5e-3, 0.39e-3, 0.628, tension="martens2017")
    free, angle, step = muscle.free_strain(3e5), float(muscle.braid_angle), 1e-6
    assert muscle.law.tension.force(3e5, free) > 0.1  # it still pulls where the mesh does not
    slope = jax.jit(jax.grad(lambda muscle: muscle.free_strain(3e5)))(muscle).braid_angle
    ends = [muscle.replace(braid_angle=angle + s * step).free_strain(3e5) for s in (1, -1)]
    assert_allclose(slope, (ends[0] - ends[1]) / (2 * step), rtol=1e-6)

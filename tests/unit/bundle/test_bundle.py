import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from refusing import refuses


LAST = (math.radians(33), "silicone_kim2021")
FULL = 344.7e3
muscle = fs.Muscle(0.127, 6.35e-3, 1.6e-3, *LAST)
thick = fs.Muscle(0.127, 9e-3, 2.25e-3, *LAST)
bent = fs.Muscle(0.127, 6.35e-3, 1.6e-3, *LAST, buckling="elastica")
unlike = fs.Bundle([fs.MotorUnit(muscle, 2), fs.MotorUnit(bent, 1), fs.MotorUnit(thick, 3)])
pair = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)])


def test_force_is_the_sum_over_its_muscles():
    P, eps = np.array([300e3, 20e3, 100e3]), np.array([0.0, 0.1, 0.2, 0.35])
    parts = 2 * muscle.force(P[0], eps) + bent.force(P[1], eps) + 3 * thick.force(P[2], eps)
    # the same float64 sums, in another order
    assert_allclose(unlike.force(P, eps), parts, rtol=1e-12)
    assert_allclose(unlike.unit_forces(P, eps)[..., 2], 3 * thick.force(P[2], eps), rtol=1e-12)


@pytest.mark.parametrize("shape", [(), (3,), (2, 3)])
def test_pressures_and_strain_broadcast(shape):
    P = jnp.broadcast_to(jnp.array([FULL, 50e3]), (*shape, 2))
    force = jax.jit(pair.force)(P, 0.1)
    assert force.shape == shape and force.dtype == jnp.float64
    assert_allclose(force, pair.force([FULL, 50e3], 0.1), rtol=1e-14)


def test_compiled_equilibria_are_complete():
    """As many as there may be are listed for all bundles together, not only one for each."""
    factors = {"youngs_modulus_factor": 1.25, "collapse_moment_factor": 1.1}
    hinge = {"hinge_stiffness_factor": 1.25, "hinge_stiffness_slope": 0.87e-5}
    tuning = fs.Tuning(**factors, **hinge, transition_rate=100.0)
    stout = muscle.replace(length=0.102, tuning=tuning)
    bundle = fs.Bundle([fs.MotorUnit(stout), fs.MotorUnit(stout, 4)])
    P = np.tile([[FULL, 66e3], [FULL, 69e3], [FULL, 72e3], [FULL, 75e3]], (2, 1))
    result, plain = jax.jit(bundle.equilibria)(jnp.asarray(P)), bundle.equilibria(P)
    assert plain.count.sum() > len(P) + 5  # with room for fewer, some would be lost
    assert result.count.tolist() == plain.count.tolist()
    assert_allclose(result.strain, plain.strain, rtol=0, atol=1e-12)


def test_strains_without_a_load_are_the_equilibria():
    P = np.array([[FULL, 69e3], [100e3, 100e3], [FULL, FULL]])
    held, free = pair.strain_at(0.0, P), pair.equilibria(P)
    assert list(held.count) == list(free.count)
    assert_allclose(held.strain, free.strain, rtol=0, atol=1e-12)


def test_strain_under_a_load_differentiates_by_load_and_pressure():
    P, F, step = np.array([FULL, 69e3]), 20.0, 1e-3
    by_load = jax.jit(jax.grad(lambda F: pair.strain_at(F, P).strain[0]))(F)
    differences = np.diff(pair.strain_at(np.array([F - step, F + step]), P).strain[:, 0])
    assert_allclose(by_load, differences[0] / (2 * step), rtol=1e-6)  # a third derivative's share


def test_replace_checks_new_arguments_and_keeps_the_others():
    batch = pair.replace(scheme="batch", supply_pressure=FULL)
    assert (batch.scheme, batch.supply_pressure) == ("batch", FULL) and pair.scheme == "orderly"
    assert batch.motor_units == pair.motor_units
    units = [fs.MotorUnit(muscle.replace(length=0.131)), fs.MotorUnit(muscle, 2)]
    assert fs.Bundle(units, length=0.127).replace(scheme="batch").plate_distance == 0.127
    thin = muscle.replace(wall_thickness=1e-3, buckling="elastica")
    assert thin == fs.Muscle(0.127, 6.35e-3, 1e-3, *LAST, buckling="elastica")
    assert muscle.replace() == muscle
    with refuses("wall_thickness"):
        muscle.replace(wall_thickness=7e-3)
    with refuses("argument"):
        muscle.replace(wall_thicknes=1e-3)


@pytest.mark.slow
def test_derivatives_are_the_same_with_and_without_jit():
    P = jnp.array([FULL, 69e3])
    first = jax.grad(lambda P: pair.equilibria(P).strain[0])
    assert_allclose(first(P), jax.jit(first)(P), rtol=1e-9)
    assert_allclose(first(P), jax.grad(pair.free_strain)(P), rtol=1e-9)


def test_without_resistance_the_strongest_unit_sets_the_free_strain():
    P = np.array([[FULL, 0.0], [10e3, FULL]])
    assert_allclose(pair.free_strain(P, resistance=False), muscle.free_strain(FULL), rtol=1e-12)
    alone = pair.equilibria(P, resistance=False)
    assert_allclose(alone.strain[:, 0], muscle.free_strain(FULL), rtol=1e-12)
    assert np.all(alone.count == 1)


def test_free_strain_differentiates_implicitly():
    @eqx.filter_jit
    def slopes(P):
        """By the bundle's sizes and by its pressures, in one program."""
        return eqx.filter_grad(lambda x: x[0].free_strain(x[1]))((pair, P))

    by_size, by_pressure = slopes(jnp.array([FULL, 40e3]))
    step = 1.0  # Pa: central differences lose half the digits of a 1e-13 root
    low, high = pair.free_strain(np.array([[FULL, 40e3 - step], [FULL, 40e3 + step]]))
    assert_allclose(by_pressure[1], (high - low) / (2 * step), rtol=1e-4)
    leaves = jax.tree.leaves(eqx.filter(by_size, eqx.is_inexact_array))
    assert leaves and all(np.all(np.isfinite(leaf)) for leaf in leaves)
    # together equal units go as one muscle does
    free_alone = jax.jit(jax.grad(muscle.free_strain))(FULL)
    assert_allclose(slopes(jnp.array([FULL, FULL]))[1].sum(), free_alone, rtol=1e-9)


def test_bundles_are_equal_by_their_values():
    """Whether made anew, used before, or of JAX's numbers; not where one thing differs."""

    def made(count=2, supply=4e5, scheme="orderly", length=None):
        units = [fs.MotorUnit(fs.example("kim2021_figure_6"), n) for n in (1, count)]
        return fs.Bundle(units, supply, scheme, length)

    one, other = made(), made()
    one.free_strain([4e5, 0.0])
    assert (one == other) is True and (one != other) is False
    assert one == jax.tree.map(jnp.asarray, other) and one.motor_units[0] == other.motor_units[0]
    others = [made(3), made(supply=3e5), made(supply=None), made(scheme="batch"), made(length=0.13)]
    for unlike in (*others, fs.Bundle(one.motor_units[:1], 4e5), one.motor_units[0], "x"):
        assert (one == unlike) is False and (one != unlike) is True

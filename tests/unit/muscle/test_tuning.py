import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from refusing import warns


SIZES = (0.127, 6.35e-3, 1.6e-3, math.radians(33))
TABLE = {"pressures": [1e5, 3e5], "c1": [2.0, 4.0], "c2": [0.9, 1.1]}
# the last row holds beyond the table, which is told
beyond = pytest.mark.filterwarnings("ignore:the tuning was measured up to")
plain = fs.Muscle(*SIZES)
tuned = fs.Muscle(*SIZES, tuning=fs.Tuning(**TABLE))


@beyond
def test_left_out_it_is_the_identity():
    P, eps = np.array([[0.0], [5e4], [1e6]]), np.linspace(-0.1, 0.6, 15)
    identity = fs.Muscle(*SIZES, tuning=fs.Tuning())
    assert_allclose(identity.force(P, eps), plain.force(P, eps), rtol=0, atol=0)
    # a table of ones and zeros is one too, up to the order of the sums
    ones = fs.Muscle(*SIZES, tuning=fs.Tuning([1e5], [0.0], [1.0]))
    assert_allclose(ones.force(P, eps), plain.force(P, eps), rtol=1e-12)


def test_tables_are_linear_from_rest_and_flat_beyond():
    tuning = fs.Tuning(**TABLE)
    P = np.array([0.0, 5e4, 1e5, 2e5, 3e5, 1e6])
    assert_allclose(tuning.c1_at(P), [0, 1, 2, 3, 4, 4], rtol=1e-15)
    assert_allclose(tuning.c2_at(P), [1, 0.95, 0.9, 1, 1.1, 1.1], rtol=1e-15)
    written = fs.Tuning([0.0, 1e5], [0.0, 2.0], [1.0, 0.9])  # the row at zero may be written
    assert_allclose(written.c1_at(P[:3]), [0, 1, 2], rtol=1e-15)


def test_it_restores_what_was_measured():
    # (34) and (35) from a free strain and a blocked force that were "measured"
    P, free, blocked = 1e5, 0.11, 30.0
    c1 = float(plain.force(P, free))
    c2 = blocked / (float(plain.blocked_force(P)) - c1)
    fitted = fs.Muscle(*SIZES, tuning=fs.Tuning([P], [c1], [c2]))
    assert_allclose(fitted.free_strain(P), free, rtol=1e-12)
    assert_allclose(fitted.blocked_force(P), blocked, rtol=1e-13)


def test_without_a_dead_band_the_effective_pressure_is_the_pressure():
    P = jnp.array([0.0, 1e-300, 34.5e3, 1e6])
    assert np.array_equal(fs.Tuning().effective_pressure(P), P)
    # 1 at P = 0 too, where `maximum` would halve it
    slope = jax.vmap(jax.grad(fs.Tuning().effective_pressure))(P)
    assert_allclose(slope, 1, rtol=0)
    mesh = math.pi * 6.35e-3**2 * (3 / math.tan(SIZES[3]) ** 2 - 1 / math.sin(SIZES[3]) ** 2)
    assert_allclose(jax.jit(jax.grad(plain.force))(0.0, 0.0), mesh, rtol=1e-14)


@beyond
def test_a_dead_band_delays_the_tension_and_its_tables():
    P_d, P = 40e3, np.array([[0.0], [2e4], [40e3], [140e3], [340e3], [1e6]])
    late = fs.Muscle(*SIZES, tuning=fs.Tuning(**TABLE, dead_band=P_d))
    P_e = np.maximum(P - P_d, 0)
    assert_allclose(late.free_strain(P), tuned.free_strain(P_e), rtol=0, atol=0)
    assert_allclose(late.blocked_force(P), tuned.blocked_force(P_e), rtol=0, atol=0)
    eps = np.linspace(-0.1, 0.0, 5)  # the tension law's alone at every pressure
    assert_allclose(late.force(P, eps), tuned.force(P_e, eps), rtol=0, atol=0)
    # the bladder holds the whole pressure
    assert_allclose(late.collapse_moment(P), tuned.collapse_moment(P), rtol=0, atol=0)


def test_the_kink_where_the_gap_closes():
    P_d = 40e3

    def force(P, P_d):
        muscle = fs.Muscle(*SIZES, tuning=fs.Tuning(dead_band=P_d))
        return muscle.force(P, 0.0)

    by = jax.jit(jax.vmap(jax.value_and_grad(force, (0, 1)), (0, None)))
    values, (by_P, by_P_d) = by(jnp.array([0.0, P_d - 1e-6, P_d, P_d + 1e-6]), P_d)
    mesh = math.pi * 6.35e-3**2 * (3 / math.tan(SIZES[3]) ** 2 - 1 / math.sin(SIZES[3]) ** 2)
    assert_allclose(values, [0, 0, 0, mesh * 1e-6], atol=1e-12)
    assert_allclose(by_P, [0, 0, mesh, mesh], rtol=1e-12)
    assert_allclose(by_P_d, -by_P, rtol=0)


def test_gradient_in_every_entry():
    everything = fs.Tuning(**TABLE, hinge_stiffness_slope=1e-7, transition_rate=50.0, dead_band=1e4)
    muscle = fs.Muscle(*SIZES, tuning=everything)
    P, eps = jnp.array([0.0, 1e5, 2e5, 1e6]), jnp.array([0.3, 0.05, 0.3, 0.6])
    slopes = jax.jit(jax.vmap(jax.grad(fs.Muscle.force), (None, 0, 0)))(muscle, P, eps)
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(slopes.tuning))


def test_tables_may_be_differentiated_into():
    def force(c1):
        tuning = fs.Tuning(jnp.array([1e5]), c1, jnp.array([1.0]))
        return fs.Muscle(*SIZES, tuning=tuning).force(1e5, 0.05)

    assert_allclose(jax.jit(jax.grad(force))(jnp.array([2.0])), [-1.0], rtol=1e-13)


def test_a_pressure_past_the_table_warns():
    tuning = fs.Tuning([1e5, 2e5], [0.1, 0.2], [1.0, 1.1], dead_band=1e4)
    muscle = fs.Muscle(*SIZES, tuning=tuning)
    muscle.force(2.1e5, 0.05)  # the table is in effective pressures
    for pressure in (2.2e5, jnp.asarray([1e5, 2.2e5])):
        with warns("220 kPa"):
            muscle.force(pressure, 0.05)
    jax.jit(lambda P: muscle.force(P, 0.05))(9e5)

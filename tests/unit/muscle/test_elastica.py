import math
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.buckling import Elastica


L0 = 0.127
SIZES = (L0, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")
never = fs.muscle.collapse.Kim2021Collapse(factor=1e3)  # so that buckling is seen on its own
muscle = fs.Muscle(*SIZES, buckling="elastica", collapse=never)
law = Elastica()
P = 34.5e3
with np.errstate(all="ignore"):  # of branches that aren't taken
    column = muscle.law.at(P).column
    onset = float(law.onset(column))


def state_of(law, column, eps):
    push, (deflection, moment) = law.push(column, eps), law.bow(column, eps)
    return SimpleNamespace(**push._asdict(), deflection=deflection, moment=moment)


def buckled(eps):
    with np.errstate(all="ignore"):
        return state_of(law, column, eps)


def test_straight_until_the_first_onset():
    EI, L_fs = column.bending_stiffness, column.free_length
    held = -column.pull(onset).force * L0 * (1 - onset) * L_fs
    assert_allclose(held, 4 * math.pi**2 * EI, rtol=1e-12)
    below = np.linspace(float(column.free_strain), onset, 9)
    state = buckled(below)
    assert np.all(state.straight)
    assert_allclose(state.arc_strain, below, rtol=1e-15)
    assert np.all(np.asarray(state.bending) == 0) and np.all(np.asarray(state.moment) == 0)
    response = muscle.response(P, np.append(below, onset * 1.001))
    assert np.array_equal(response.region, [0] + 8 * [3] + [1])


def test_next_to_the_onset():
    near = onset + np.array([0, 1, 2, 4, 1e2, 1e4, 1e6, 1e8]) * np.spacing(onset)
    state = buckled(near)
    assert np.all(np.isfinite(state.moment)) and np.all(np.isfinite(state.deflection))
    total = np.asarray(state.mesh + state.bladder + state.bending)
    assert_allclose(total, total[0], rtol=1e-6)  # 2e8 ulp are 2e-8 of strain, of slopes of 1e2 N
    slopes = jax.jit(jax.vmap(jax.grad(lambda e: buckled(e).mesh + buckled(e).bending)))
    assert np.all(np.isfinite(slopes(jnp.asarray(near))))


def test_first_strain_at_a_moment():
    target = np.asarray(buckled(np.array([0.1, 0.2, 0.5])).moment)
    assert_allclose(law.strain_at_moment(column, target), [0.1, 0.2, 0.5], rtol=1e-11)
    assert law.strain_at_moment(column, 0.0) == pytest.approx(onset, rel=1e-14)
    ends_meet = 8 * math.sqrt(0.8261147659879693) * float(mpmath.ellipk(0.8261147659879693))
    most = ends_meet * float(column.bending_stiffness / column.free_length)
    assert np.isposinf(law.strain_at_moment(column, 1.0001 * most))


def test_shape_keeps_its_arc():
    strains = np.array([0.09, 0.2, 0.6])
    n = 4001
    line, state = law.shape(column, strains, n), buckled(strains)
    z, y = np.asarray(line.z), np.asarray(line.y)
    arc = L0 * (1 - np.asarray(state.arc_strain))
    steps = np.hypot(np.diff(z), np.diff(y))
    # a chord of a circle is short of its arc by (κh)²/24, here 1e-7 at most
    assert_allclose(steps, np.broadcast_to(arc[:, None] / (n - 1), steps.shape), rtol=1e-6)
    assert_allclose(steps.sum(axis=1), arc, rtol=1e-6)
    assert_allclose(z[:, -1], L0 * (1 - strains), rtol=1e-12)
    assert_allclose(y[:, [0, -1]], 0, atol=1e-16)
    assert_allclose(-y.min(axis=1), state.deflection, rtol=1e-12)


def test_curvature_of_the_shape_is_the_moment():
    strain, n = 0.3, 4001
    line, state = law.shape(column, strain, n), buckled(strain)
    angle = np.unwrap(np.arctan2(np.diff(line.y), np.diff(line.z)))
    arc = L0 * (1 - float(state.arc_strain))
    curvature = np.abs(np.diff(angle)) / (arc / (n - 1))
    # curvature counts on the length at free strain: κ ℓ/L_fs
    counted = curvature * arc / float(column.free_length)
    assert_allclose(counted.max() * column.bending_stiffness, state.moment, rtol=1e-5)
    # clamped: half a step's turn at most
    assert abs(angle[0]) < 2 * math.pi / n and abs(angle[-1]) < 2 * math.pi / n


def test_straight_shape_is_straight():
    with np.errstate(all="ignore"):
        line = law.shape(column, np.array([onset * 0.999]), 11)
    assert np.all(line.y == 0)
    assert_allclose(line.z[0], L0 * (1 - onset * 0.999) * np.linspace(0, 1, 11), atol=1e-16)


def test_a_slender_muscle_has_one_equilibrium():
    with np.errstate(all="ignore"):
        assert not np.any(law.several(column, np.linspace(0.0, 0.6, 61)))


def test_without_any_compression_it_stays_straight():
    # the mesh alone, without pressure: no force at all, at any strain
    idle = fs.Muscle(*SIZES, tension="ideal", buckling="elastica")
    response = idle.response(0.0, 0.5)
    assert response.force == 0 and response.region == 3
    assert np.isposinf(idle.collapse_strain(0.0))
    assert all(np.isfinite(jax.jit(jax.grad(idle.force, (0, 1)))(0.0, 0.5)))

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS


SIZES = (0.127, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")
P, BETA = 34.5e3, 25.0
LAWS = [("kim2021", "derived"), ("kim2021", "printed"), ("elastica", "consistent")]
# which takes ten times as long as the others
OF_LAWS = [*LAWS[:2], pytest.param(LAWS[2], marks=pytest.mark.slow)]
muscles = {laws: fs.Muscle(*SIZES, buckling=laws[0], post_collapse=laws[1]) for laws in LAWS}


def strains_after(muscle):
    return np.linspace(float(muscle.collapse_strain(P)) + 1e-6, 0.6, 12)


@pytest.mark.parametrize("laws", OF_LAWS)
def test_transition_after_collapse(laws):
    """(26), with the force at collapse from the law before it."""
    muscle = muscles[laws]
    eps = strains_after(muscle)
    eps_c = float(muscle.collapse_strain(P))
    at = muscle.response(P, np.full(12, eps_c))
    column = muscle.law.at(jnp.asarray(P)).column
    M_h = math.pi / 4 * 1.78e6 * 6.35e-3 * 1.6e-3**2
    x = (eps - column.free_strain) * column.rest_length
    F_c = np.asarray(POST_COLLAPSE_LAWS[laws[1]]().push(column, M_h, x)[0])
    decay = np.exp(-BETA * (eps - eps_c))
    now = muscle.response(P, eps)
    assert_allclose(now.force, -F_c + (np.asarray(at.force) + F_c) * decay, rtol=1e-10)
    assert_allclose(now.mesh, np.asarray(at.mesh) * decay, rtol=1e-10)
    assert_allclose(now.bladder, np.asarray(at.bladder) * decay, rtol=1e-10)
    assert np.all(np.asarray(now.region) == 2) and np.all(np.asarray(at.region) == 1)


@pytest.mark.parametrize("laws", OF_LAWS)
def test_kinks_are_where_the_slope_jumps(laws):
    muscle = muscles[laws]
    free, onset, collapse = muscle.law.at(jnp.asarray(P)).kinks
    # compiled apart, so equal but for rounding
    assert_allclose(
        [free, collapse], [muscle.free_strain(P), muscle.collapse_strain(P)], rtol=1e-13
    )
    assert free <= onset < collapse
    # `elastica` goes on along T at its free strain
    places = jnp.asarray(np.add.outer([-1e-9, 0.0, 1e-9], [onset, collapse]).ravel())
    slope = jax.jit(jax.vmap(jax.grad(lambda e: muscle.force(P, e))))
    below, at, above = np.reshape(slope(places), (3, 2))
    assert np.all(np.abs(above - below) > 1)  # newtons per unit strain
    # one-sided derivatives hold at the kinks themselves, from below
    assert_allclose(at[1], below[1], rtol=1e-5)


def test_moment_and_deflection_by_region():
    muscle = muscles[LAWS[0]]
    eps_c = float(muscle.collapse_strain(P))
    eps = np.array([-0.05, 0.0, 0.05, eps_c, eps_c + 1e-9, 0.5])
    moment, top = np.asarray(muscle.moment(P, eps)), np.asarray(muscle.deflection(P, eps))
    M_h = math.pi / 4 * 1.78e6 * 6.35e-3 * 1.6e-3**2
    # at collapse the moment is M_collapse, after it the hinge's
    assert_allclose(moment, [0, 0, 0, muscle.collapse_moment(P), M_h, M_h], rtol=1e-10)
    assert np.all(top[:3] == 0) and np.all(top[3:] > 0)


def test_shape_by_region():
    muscle = muscles[LAWS[0]]
    eps = np.array([-0.05, 0.05, 0.1, 0.5])  # pulled twice, bowed, hinged
    line = muscle.shape(P, eps, 51)
    z, y = np.asarray(line.z), np.asarray(line.y)
    assert_allclose(z[:, -1], 0.127 * (1 - eps), rtol=1e-13)
    assert np.all(y[:2] == 0)
    assert_allclose(-y.min(axis=1), muscle.deflection(P, eps), atol=1e-15)
    assert muscle.shape(np.full((2, 1), P), eps, 51).y.shape == (2, 4, 51)

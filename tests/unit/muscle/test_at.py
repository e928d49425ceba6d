"""A muscle at a pressure answers as the muscle does there, solved for once."""

import math
import pickle

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from refusing import warns


SIZES = (0.127, 6.35e-3, 1.6e-3, math.radians(33))
TUNING = fs.Tuning([1e5, 3e5], [0.5, 1.0], [0.9, 0.95], dead_band=1e4, transition_rate=60.0)
CHOICES = {
    "the paper's": {},
    "elastica": {"buckling": "elastica"},
    "tuned": {"tuning": TUNING, "collapse": "wood1958"},
}
P, STRAIN = 137.9e3, np.linspace(-0.05, 0.4, 19)
ASKED = ("force", "stiffness", "response", "deflection", "moment", "shape")
several = pytest.mark.parametrize("laws", CHOICES.values(), ids=CHOICES)


def made(laws):
    return fs.Muscle(*SIZES, "silicone_kim2021", **laws)


@several
@pytest.mark.parametrize("pressure", [0.0, P, np.array([[0.0], [34.5e3], [2.9e5]])])
def test_it_is_the_muscle_there(laws, pressure):
    muscle = made(laws)
    at = muscle.at(pressure)
    for name in ASKED:
        there, whole = getattr(at, name)(STRAIN), getattr(muscle, name)(pressure, STRAIN)
        for one, other in zip(jax.tree.leaves(there), jax.tree.leaves(whole), strict=True):
            assert isinstance(one, np.ndarray)
            assert_array_equal(one, other)
    assert_array_equal(at.free_strain, muscle.free_strain(pressure))
    assert_array_equal(at.collapse_strain, muscle.collapse_strain(pressure))
    # in tension up to the onset, and straight: no moment before it
    assert np.all(at.onset >= at.free_strain)
    assert_array_equal(at.moment(np.minimum(at.onset, 0.6)), 0.0 * at.onset)


def test_the_paper_s_law_buckles_at_its_free_strain_and_the_elastica_later():
    assert made({}).at(P).onset == made({}).free_strain(P)
    later = made({"buckling": "elastica"}).at(P)
    assert later.onset > later.free_strain


def test_numbers_give_numbers_and_jax_gives_jax():
    muscle = made({})
    assert isinstance(muscle.at(P).force(0.1), np.float64)
    assert isinstance(muscle.at(P).free_strain, np.float64)
    at = muscle.at(jnp.asarray(P))
    assert isinstance(at.force(0.1), jax.Array) and isinstance(at.free_strain, jax.Array)
    assert isinstance(muscle.at(P).force(jnp.asarray(0.1)), jax.Array)
    # a compiler orders sums otherwise
    assert float(at.force(0.1)) == pytest.approx(muscle.force(P, 0.1), rel=1e-13)


def test_it_is_compiled_batched_and_differentiated():
    muscle = made({})

    @jax.jit
    @jax.vmap
    def force(pressure):
        at = muscle.at(pressure)
        return at.force(0.1), at.free_strain

    pressures = np.array([5e4, P, 3e5])
    forces, free = force(pressures)
    assert_allclose(forces, muscle.force(pressures, 0.1), rtol=1e-12)
    assert_allclose(free, muscle.free_strain(pressures), rtol=1e-12)
    slope = jax.jit(jax.grad(lambda pressure: muscle.at(pressure).force(0.25)))(P)
    wanted = jax.jit(jax.grad(lambda pressure: muscle.force(pressure, 0.25)))(P)
    assert_allclose(slope, wanted, rtol=1e-10)
    of_radius = jax.jit(jax.grad(lambda m: m.at(P).force(0.25)))(muscle).outer_radius
    assert_allclose(
        of_radius, jax.jit(jax.grad(lambda m: m.force(P, 0.25)))(muscle).outer_radius, rtol=1e-10
    )


def test_what_is_off_the_domain_is_refused():
    muscle = made({})
    for argument, call in (
        ("pressure", lambda: muscle.at(2e6)),
        ("strain", lambda: muscle.at(P).force(0.7)),
        ("strain", lambda: muscle.at(P).shape(np.array([0.1, np.nan]))),
    ):
        with pytest.raises(fs.InvalidInputError) as error:
            call()
        assert error.value.argument == argument
    with warns("500 kPa"):
        made({"tuning": TUNING}).at(5e5)


def test_it_is_a_value():
    muscle = made({})
    assert muscle.at(P) == muscle.at(P)
    assert muscle.at(P) != muscle.at(P + 1)
    assert pickle.loads(pickle.dumps(muscle.at(P))) == muscle.at(P)  # noqa: S301 our own

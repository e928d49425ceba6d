"""A bundle of rows of muscles is a row of bundles: each answers as it does alone."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import fascicle as fs


MUSCLE = fs.example("kim2021_slenderness_10")
ANGLES = np.radians([[33.5], [35.0], [36.2]])
LENGTHS = np.array([[0.125], [0.127], [0.1285]])
P = np.array([[0.0, 200e3], [150e3, 80e3], [300e3, 300e3], [344e3, 0.0]])
MANY = np.random.default_rng(3).uniform(0.0, 400e3, (7000, 2))  # more than are computed at once


def angled(i):
    return MUSCLE.replace(braid_angle=ANGLES[i])


def sized(i):
    return MUSCLE.replace(braid_angle=ANGLES[i], length=LENGTHS[i])


def plain(_):
    return MUSCLE


BUNDLES = {
    "angles": lambda i: [fs.MotorUnit(angled(i)), fs.MotorUnit(angled(i), 2)],
    "one of two": lambda i: [fs.MotorUnit(angled(i), 2), fs.MotorUnit(plain(i))],
    "lengths": lambda i: [fs.MotorUnit(sized(i)), fs.MotorUnit(plain(i), 3)],
    "one for both": lambda i: [fs.MotorUnit(angled(i))] * 2,
}
QUESTIONS = {
    "force": lambda bundle: bundle.force(P, 0.12),
    "many forces": lambda bundle: bundle.force(MANY, 0.12),
    "unit forces": lambda bundle: bundle.unit_forces(P, 0.2),
    "free strain": lambda bundle: bundle.free_strain(P),
    "many free strains": lambda bundle: bundle.free_strain(MANY),
    "free strain of the straight": lambda bundle: bundle.free_strain(P, resistance=False),
    "equilibria": lambda bundle: tuple(bundle.equilibria(P)),
    "load": lambda bundle: tuple(bundle.strain_at([5.0, 60.0, 100.0, 20.0], P)),
}


def row_of(name):
    """A row of three bundles, and the three."""
    make = BUNDLES[name]
    units = [make(slice(None)), *(make((i, 0)) for i in range(3))]
    row, *alone = [fs.Bundle(some, length=MUSCLE.length) for some in units]
    return row, alone


def cases(slow):
    """Bundles with questions; `make slow` asks those that are `slow` of more than one bundle."""
    for name in BUNDLES:
        for question in QUESTIONS:
            late = name != "lengths" and question in slow
            yield pytest.param(name, question, marks=[pytest.mark.slow] if late else [])


@pytest.mark.parametrize(("name", "question"), [*cases(slow=("many forces", "many free strains"))])
def test_a_batch_equals_its_single_bundles(name, question):
    row, alone = row_of(name)
    ask = QUESTIONS[question]
    result, expected = ask(row), [ask(one) for one in alone]
    for ours, *theirs in zip(*map(jax.tree.leaves, (result, *expected)), strict=True):
        # many forces of one bundle are compiled, of a row of them not: rounding of some 100 N
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-10)


def test_a_batch_of_muscles_is_no_list_of_units():
    """Two angles and two units: the second row is not the second unit."""
    pair = MUSCLE.replace(braid_angle=ANGLES[:2, 0])
    row = fs.Bundle([fs.MotorUnit(pair)] * 2)
    for i in range(2):
        one = fs.Bundle([fs.MotorUnit(angled((i, 0)))] * 2)
        assert row.force(P[:2], 0.1)[i] == one.force(P[i], 0.1)


def test_counts_may_be_a_batch():
    counts = np.array([1, 2, 5])
    row = fs.Bundle([fs.MotorUnit(MUSCLE, counts), fs.MotorUnit(MUSCLE, 2)])
    alone = [fs.Bundle([fs.MotorUnit(MUSCLE, n), fs.MotorUnit(MUSCLE, 2)]) for n in counts]
    pressures = P[1]
    expected = [one.free_strain(pressures) for one in alone]
    np.testing.assert_array_equal(row.free_strain(pressures), expected)


@pytest.mark.parametrize(
    "name", ["angles", *(pytest.param(x, marks=pytest.mark.slow) for x in [*BUNDLES][1:])]
)
def test_derivatives_equal_those_of_single_bundles(name):
    row, (_, _, last) = row_of(name)
    pressures = jnp.asarray(P[1])
    slopes = jax.jit(jax.jacfwd(row.free_strain))(pressures)
    expected = jax.jit(jax.jacfwd(last.free_strain))(pressures)
    np.testing.assert_allclose(slopes[2, 0], expected, rtol=1e-12, atol=0)


@pytest.mark.slow  # half a minute to compile
def test_a_compiled_batch_is_the_same():
    row, _ = row_of("lengths")
    result = jax.jit(lambda bundle, pressures: bundle.free_strain(pressures))(row, P)
    # both searches end where two Newton steps leave nothing but rounding
    np.testing.assert_allclose(result, row.free_strain(P), rtol=0, atol=1e-14)

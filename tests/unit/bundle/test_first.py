"""A bundle's first zero against all of its zeros, which are looked for in another way."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle.bundle import pressurized
from fascicle.bundle.first import first
from unlike import SUPPLY, random_bundle


def random_pressures(random: np.random.Generator, count: int, units: int) -> np.ndarray:
    """Some of them at no pressure, some at the supply's, many low ones."""
    P = random.uniform(0, SUPPLY, (count, units))
    P[random.random(P.shape) < 0.2] = 0.0
    P[random.random(P.shape) < 0.1] = SUPPLY
    P[: count // 6] *= 0.1
    return P


@pytest.mark.parametrize("buckling", ["kim2021", "elastica"])
@pytest.mark.parametrize("units", [2, 5])
def test_none_lies_before_the_first(units, buckling):
    random = np.random.default_rng(units)
    several = 0
    for _ in range(3 if buckling == "elastica" else 4):
        bundle = random_bundle(random, units, most=5, buckling=buckling)
        P = random_pressures(random, 150, units)
        every = bundle.equilibria(P)
        several += np.sum(every.count > 1)
        assert_allclose(bundle.free_strain(P), every.strain[:, 0], rtol=0, atol=1e-12)
    assert several >= 10


def test_what_is_proved_spares_the_search():
    random = np.random.default_rng(1)
    bundle = random_bundle(random, 6, most=5)
    with np.errstate(all="ignore"):
        found = first(pressurized(bundle, random.uniform(0, SUPPLY, (300, 1, 6))))
    assert np.mean(found.sure) > 0.8


def test_a_bundle_of_elasticas_begins_at_its_first_equilibrium():
    random = np.random.default_rng(3)
    bent = random_bundle(random, 2, most=5, buckling="elastica")
    P = random_pressures(random, 200, 2)
    assert_allclose(bent.free_strain(P), bent.equilibria(P).strain[:, 0])


@pytest.mark.parametrize("P", [[0.0, 0.0], [0.0, SUPPLY], [1.0, SUPPLY], [2e5, 2e5]])
def test_equal_units_at_any_pressures(P):
    muscle = fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(33))
    pair = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)])
    free = pair.free_strain(P)
    assert_allclose(free, pair.equilibria(P).strain[0], rtol=0, atol=1e-13)
    assert_allclose(pair.force(P, free), 0, atol=1e-9)


def test_no_pressures_have_no_zeros():
    muscle = fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(33))
    assert fs.Bundle([fs.MotorUnit(muscle)]).free_strain(np.zeros((0, 1))).shape == (0,)

"""Equilibria of a bundle, all of them found in one search."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from unlike import SUPPLY, random_bundle


@pytest.mark.parametrize("buckling", ["kim2021", "elastica"])
def test_the_free_strain_is_the_first_equilibrium(buckling):
    random = np.random.default_rng(3)
    bundle = random_bundle(random, 2, most=5, buckling=buckling)
    P = random.uniform(0, SUPPLY, (200, 2)) * random.choice([0.0, 0.1, 1.0], (200, 2))
    result = bundle.equilibria(P)
    assert np.any(result.count > 1)
    assert_allclose(bundle.free_strain(P), result.strain[:, 0], rtol=0, atol=1e-12)


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

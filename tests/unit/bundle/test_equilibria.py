"""Equilibria of a bundle, all of them found in one search."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle import bundle as bundles
from fascicle.bundle import equilibria
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
    muscle = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33))
    pair = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)])
    free = pair.free_strain(P)
    assert_allclose(free, pair.equilibria(P).strain[0], rtol=0, atol=1e-13)
    assert_allclose(pair.force(P, free), 0, atol=1e-9)


def test_no_pressures_have_no_zeros():
    muscle = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33))
    assert fs.Bundle([fs.MotorUnit(muscle)]).free_strain(np.zeros((0, 1))).shape == (0,)


STEEP = fs.Muscle("127 mm", "6.35 mm", "1.6 mm", "38 deg")
WIDE = fs.Muscle(0.2, 8e-3, 1.6e-3, math.radians(38))
SOFT = fs.Muscle("138.46 mm", "6.45 mm", "1.441 mm", 0.51836, buckling="elastica")


@pytest.mark.parametrize(
    ("units", "load", "pressures", "strains"),
    [
        ([fs.MotorUnit(STEEP)], 20.0, [200e3], [0.10111]),
        ([fs.MotorUnit(WIDE), fs.MotorUnit(WIDE, 4)], 40.0, [3e5, 0.0], [0.13074]),
        ([fs.MotorUnit(SOFT)], -1.0, [0.0], [0.00148, 0.0995, 0.36247]),
    ],
)
def test_strains_that_hold_a_load(units, load, pressures, strains):
    """Straight fibers, where a force rounds to anything, are no equilibrium and hide none."""
    result = fs.Bundle(units).strain_at(load, pressures)
    assert_allclose(result.strain[: result.count], strains, rtol=0, atol=1e-5)


def test_no_equilibrium_is_cut(monkeypatch):
    bundle, loads = fs.Bundle([fs.MotorUnit(SOFT)]), [[20.0], [-1.0], [1.0]]
    whole = bundle.strain_at(loads, [0.0])
    monkeypatch.setattr(equilibria, "usual_count", lambda units: units)
    monkeypatch.setattr(equilibria, "_BATCH", 1)
    result = bundle.strain_at(loads, [0.0])
    assert result.count.max() == 3 and np.array_equal(result.count, whole.count)
    assert_allclose(result.strain, whole.strain, rtol=0, atol=1e-14)
    assert np.array_equal(result.stable, whole.stable)


def test_arrays_of_jax_have_room_for_the_usual_number(monkeypatch):
    bundle = fs.Bundle([fs.MotorUnit(SOFT)])
    whole = bundle.strain_at(-1.0, [0.0])
    for module in (equilibria, bundles):
        monkeypatch.setattr(module, "usual_count", lambda units: units)
    result = jax.jit(bundle.strain_at)(-1.0, jnp.zeros(1))
    assert result.count == 3 and result.strain.shape == (1,)
    assert_allclose(result.strain, whole.strain[:1], rtol=0, atol=1e-12)

"""A braid that stretches, against the oracle's search for the least energy."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle_elastic import Tube

import fascicle as fs
from fascicle.muscle.tension import ElasticBraid


def drawn(seed):
    """A random muscle, the oracle's twin, and a pressure and strain that its fibers bear."""
    rng = np.random.default_rng(seed)
    r = rng.uniform(3e-3, 15e-3)
    wall, length = r * rng.uniform(0.1, 0.35), r * rng.uniform(6, 30)
    angle, k = math.radians(rng.uniform(20, 42)), 10 ** rng.uniform(7.4, 10)
    c10, c01 = rng.uniform(60e3, 200e3), rng.uniform(20e3, 160e3)
    law = ElasticBraid(k)
    muscle = fs.Muscle(length, r, wall, angle, fs.MooneyRivlin(c10, c01), tension=law)
    pressure = rng.uniform(0, min(1e6, 0.8 * law.highest_pressure(muscle.bladder)))
    strain = rng.uniform(0.4 * (1 - 1 / math.cos(angle)), 0.5)
    return muscle, Tube(length, r, wall, angle, c10, c01, k * math.pi * r**2), pressure, strain


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore:`elastic_braid` is valid up to")
@pytest.mark.parametrize("seed", range(40))
def test_the_least_energy_gives_stretch_radius_and_force(seed):
    muscle, tube, P, eps = drawn(seed)
    law, bladder = muscle.tension, muscle.bladder
    u = law.fiber_strain(bladder, P, eps)
    # the oracle finds where an energy is flat: to the root of rounding
    assert_allclose(u, tube.stretch(P, eps) - 1, atol=1e-7)
    assert_allclose(law.radius(bladder, P, eps), tube.radius_at(eps, 1 + u), rtol=1e-12)
    assert_allclose(law.potential(bladder, P, eps), tube.potential(P, eps, 1 + u), rtol=1e-9)
    # a sixth-order difference over 2e-3, of an energy known to 1e-16: 1e-10 of the bore's push
    size = math.pi * tube.radius**2 * P + 1
    assert abs(muscle.law.tension.force(P, eps) - tube.force(P, eps)) < 1e-9 * size

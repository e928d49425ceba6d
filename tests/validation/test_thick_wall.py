"""What the theory page says of a thick wall: by how much the bladder resists more through it."""

import math

import numpy as np
import oracle_muscle
import pytest
from oracle_muscle import SILICONE, Muscle, bladder, free_strain, mesh
from scipy.optimize import brentq


SIX = Muscle(material=SILICONE)  # t0/r0 of 0.25
X, W = np.polynomial.legendre.leggauss(40)


def energy(muscle, strain):
    """Energy of the wall over L0 [J/m], each layer with its own stretch, integrated."""
    r0, ri = muscle.outer_radius, muscle.outer_radius - muscle.wall_thickness
    stretch = 1 - strain
    R = ri + (r0 - ri) * (1 + X) / 2
    # a layer keeps its volume between itself and the outer surface, which follows the braid
    r = np.sqrt(oracle_muscle.radius(muscle, strain) ** 2 - (r0**2 - R**2) / stretch)
    squares = np.array([stretch + 0 * R, r / R, R / (r * stretch)]) ** 2
    c10, c01 = muscle.material.c10, muscle.material.c01
    density = c10 * (squares.sum(axis=0) - 3) + c01 * ((1 / squares).sum(axis=0) - 3)
    return float(np.sum(W * density * 2 * math.pi * R) * (r0 - ri) / 2)


def force(muscle, strain, step=1e-6):
    return -(energy(muscle, strain + step) - energy(muscle, strain - step)) / (2 * step)


@pytest.mark.parametrize(("strain", "ratio"), [(0.02, 1.57), (0.2, 1.16)])
def test_the_wall_resists_more_where_every_layer_counts(strain, ratio):
    thick, thin = force(SIX, strain), bladder(SIX, 0.0, strain)
    assert thick / thin == pytest.approx(ratio, abs=0.005)


def test_free_strain_is_less():
    thick = brentq(lambda e: mesh(SIX, 34.5e3, e) + force(SIX, e), 1e-4, 0.3)
    assert thick == pytest.approx(0.040, abs=5e-4)
    assert free_strain(SIX, 34.5e3) == pytest.approx(0.063, abs=5e-4)

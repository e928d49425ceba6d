"""The volume that goes with the force, and a table of it, against the oracle."""

import dataclasses
import math

import numpy as np
import oracle_energy as oracle
import oracle_muscle
import pytest
from from_oracle import library_muscle
from numpy.testing import assert_allclose

import fascicle as fs


SIX = oracle_muscle.Muscle(material=oracle_muscle.SILICONE)
STOUT = oracle_muscle.Muscle(
    length=0.102, wall_thickness=1.2e-3, braid_angle=math.radians(28), post_collapse="consistent"
)
POINTS = [(0.0, 0.25), (0.0, 0.1), (34.5e3, 0.03), (34.5e3, 0.15), (137.9e3, 0.22), (2e5, 0.3),
          (5e4, 0.4), (3e5, -0.05)]  # fmt: skip


@pytest.mark.parametrize("muscle", [SIX, STOUT], ids=["figure 6", "stout"])
def test_conjugate_volumes(muscle):
    pressures, strains = np.array(POINTS).T
    expected = [oracle.conjugate_volume(muscle, *point) for point in POINTS]
    # the oracle's differences are right to some 1e-9
    assert_allclose(
        library_muscle(muscle).conjugate_volume(pressures, strains), expected, rtol=1e-8
    )


def test_elastica_s_volume_is_its_arc_s_and_what_bending_gives_back():
    # Π* of (E1) at fixed strain: V* = V(ε_a) − ∂U_b/∂P, and U_b ∝ 1/L_fs(P) alone
    muscle = library_muscle(dataclasses.replace(SIX, buckling="elastica"))
    muscle = muscle.replace(tuning=fs.Tuning(collapse_moment_factor=1e6))
    P, eps = np.array([0.0, 2e4, 1e5, 2e5]), np.array([0.2, 0.15, 0.25, 0.3])
    at = muscle.law.at(P)
    arc = muscle.law.buckling.push(at.column, eps).arc_strain
    h = 1.0
    free = [muscle.free_strain(np.maximum(P + d, 0)) for d in (-h, h)]
    growth = (free[1] - free[0]) / np.where(P > 0, 2 * h, h)

    def bending(eps):
        # the force is the tension's and the bending's slope; what bending stores, by quadrature
        x, w = np.polynomial.legendre.leggauss(60)
        low = at.onset
        nodes = (low + eps) / 2 + (eps - low) / 2 * x[:, None]
        pushed = -np.sum(w[:, None] * muscle.force(P, nodes), axis=0) * (eps - low) / 2
        bladder = muscle.bladder.energy(arc) - muscle.bladder.energy(low)
        swept = P * (muscle.volume(arc) - muscle.volume(low))
        return pushed * muscle.length - bladder + swept

    expected = muscle.volume(arc) - bending(eps) * growth / (1 - at.column.free_strain)
    # differences of the free strain are right to 1e-6 of its growth
    assert_allclose(muscle.conjugate_volume(P, eps), expected, rtol=1e-5)


def test_a_cycle_of_the_oracle_s_volume_closes_and_of_the_straight_one_doesn_t():
    force = lambda P, e: SIX.length * oracle.oracle_force.force(SIX, P, e)  # noqa: E731
    corners = (0.0, 5e4, 0.0, 0.2)
    fluid, ends = oracle.cycle(lambda _, e: oracle_muscle.volume(SIX, e), force, corners, points=60)
    # kinks within the rectangle: of Gauss's rule with 60 points some 1e-3
    assert ends == pytest.approx(0.108, abs=0.001) and fluid == pytest.approx(0.388, abs=0.001)

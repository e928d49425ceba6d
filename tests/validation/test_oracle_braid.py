"""The braid's share of a muscle's bending stiffness, against an oracle of fibers."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle_braid import (
    bent_volume,
    stiffness,
    stiffness_of_any_section,
    stiffness_without_slip,
)

import fascicle as fs
from fascicle.muscle.buckling import Elastica, Kim2021


FIGURE_6 = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33), fs.materials.SILICONE_KIM2021)


def held(muscle, pressure):
    """What the braid adds to a column's bending stiffness [N m2]."""
    stiff = muscle.law.at(pressure).column.bending_stiffness
    bare = muscle.replace(buckling="kim2021").law.at(pressure).column.bending_stiffness
    return stiff - bare


@pytest.mark.parametrize("law", [Kim2021, Elastica])
def test_the_numbers_asked_for(law):
    muscle = FIGURE_6.replace(buckling=law(1.0))
    pressure = np.array([34.5e3, 68.9e3, 137.9e3])
    # given to four digits, at pressures given to three or four
    assert_allclose(held(muscle, pressure), [2.471e-3, 4.298e-3, 7.352e-3], rtol=1e-3)


def test_it_is_what_fibers_of_fixed_length_hold():
    rng = np.random.default_rng(18)
    for _ in range(50):
        radius, angle = rng.uniform(3e-3, 15e-3), np.radians(rng.uniform(20, 42))
        muscle = fs.Muscle(0.2, radius, 0.2 * radius, angle, buckling=Elastica(0.7))
        P = rng.uniform(1e3, 1e6)
        free = float(muscle.free_strain(P))
        r, alpha = float(muscle.radius(free)), float(muscle.braid.angle_at(free))
        # the oracle's step leaves its square
        assert_allclose(held(muscle, P), 0.7 * stiffness(P, r, alpha), rtol=1e-6)


def test_virtual_work_without_slip_says_five_sixths_at_the_neutral_angle():
    """There no axial force is left, and what is held doesn't depend on which line keeps its
    length: (B1) leaves out that fibers along a bent axis also press on it sideways.
    """
    P, r, neutral = 1e5, 6.35e-3, math.atan(math.sqrt(2))
    assert_allclose(bent_volume(r, neutral, 0.0), math.pi * r**2, rtol=1e-12)
    ratio = stiffness_without_slip(P, r, neutral) / stiffness(P, r, neutral)
    # the trapezoid rule is even around the section: what is left is of sixth order in the step
    assert_allclose(ratio, 5 / 6, rtol=1e-5)


def test_nor_does_a_section_of_any_shape_hold_less():
    P, r, neutral = 1e5, 6.35e-3, math.atan(math.sqrt(2))
    ratio = stiffness_of_any_section(P, r, neutral) / stiffness(P, r, neutral)
    # bends of 0.05 and 0.1 leave some 1e-4, as do 200 steps
    assert_allclose(ratio, 5 / 6, rtol=1e-3)


def test_a_dead_band_keeps_pressure_from_the_braid():
    band = FIGURE_6.replace(buckling=Kim2021(1.0), tuning=fs.Tuning(dead_band=50e3))
    assert held(band, 40e3) == 0
    assert held(band, 90e3) > 0


@pytest.mark.parametrize("law", [Kim2021, Elastica])
def test_a_share_of_zero_is_the_law_without_it_and_more_is_stiffer(law):
    strain = np.linspace(0.0, 0.35, 71)[:, None]
    pressure = np.array([0.0, 34.5e3, 68.9e3, 137.9e3])
    forces = [
        FIGURE_6.replace(buckling=law(share), tuning=fs.Tuning(collapse_moment_factor=1e3)).force(
            pressure, strain
        )
        for share in (0.0, 0.5, 1.0)
    ]
    by_name = FIGURE_6.replace(
        buckling=law.name, tuning=fs.Tuning(collapse_moment_factor=1e3)
    ).force(pressure, strain)
    assert np.array_equal(forces[0], by_name)
    assert np.array_equal(forces[0][:, 0], forces[2][:, 0])  # nothing without pressure
    for more, less in ((2, 1), (1, 0)):
        # the elastica bows later, too: as long as both are straight they push alike
        assert np.all(forces[more] <= forces[less])
        assert np.all((forces[more] < forces[less]).any(axis=0)[1:])

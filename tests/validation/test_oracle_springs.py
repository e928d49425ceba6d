"""Readings of the paper's springs against an oracle that solves (13) to (16) as they stand."""

import dataclasses

import numpy as np
import oracle_springs
import pytest
from from_oracle import library_muscle
from numpy.testing import assert_allclose
from oracle_muscle import SILICONE, Muscle
from oracle_random import random_cases

from fascicle.muscle.buckling.kim2021 import Kim2021
from reproduction.kim2021.springs import LinkedSprings, ResolvedSprings, StiffSprings


SIX = Muscle(material=SILICONE)
READINGS = [
    (Kim2021, {}),
    (ResolvedSprings, {"statics": "resolved"}),
    (LinkedSprings, {"closure": "links"}),
    (StiffSprings, {"stiffness": 2.0}),
]


@pytest.mark.parametrize(("law", "reading"), READINGS)
def test_forces_deflections_and_moments_are_the_oracles(law, reading):
    bent = 0
    for case in random_cases(11, 16):
        # no collapse, so that the springs are seen
        plain = dataclasses.replace(case.muscle, collapse="kim2021", collapse_factor=1e6)
        muscle = library_muscle(plain).replace(buckling=law())
        free = float(muscle.free_strain(case.pressure))
        for strain in case.strains:
            if strain <= free + 1e-6:
                continue
            force, y, moment = oracle_springs.state(plain, case.pressure, strain, **reading)
            assert_allclose(muscle.force(case.pressure, strain), force, rtol=1e-8, atol=1e-8)
            # a deflection is the root of a small difference
            assert_allclose(muscle.deflection(case.pressure, strain), y, rtol=1e-5, atol=1e-8)
            assert_allclose(muscle.moment(case.pressure, strain), moment, rtol=1e-5, atol=1e-8)
            bent += y > 0
    assert bent > 20


# strain [-] and force [N] of the collapse at 0, 34.5 and 137.9 kPa
COLLAPSES = {
    "paper": ({}, [(0.0674, -2.91), (0.1326, -5.18), (0.2645, -11.80)]),
    "resolved": ({"statics": "resolved"}, [(0.0935, -5.70), (0.1640, -10.72), (0.3187, -30.35)]),
    "links": ({"closure": "links"}, [(0.0602, -2.89), (0.1253, -5.11), (0.2572, -11.53)]),
}


@pytest.mark.parametrize("name", COLLAPSES)
@pytest.mark.parametrize("row", range(3))
def test_where_figure_6s_muscle_collapses(name, row):
    reading, rows = COLLAPSES[name]
    strain, force = oracle_springs.collapse(SIX, (0.0, 34.5e3, 137.9e3)[row], **reading)
    assert strain == pytest.approx(rows[row][0], abs=0.501e-4)
    assert force == pytest.approx(rows[row][1], abs=0.501e-2)


@pytest.mark.parametrize(("law", "reading"), READINGS)
def test_the_laws_collapse_there_too(law, reading):
    muscle = library_muscle(SIX).replace(buckling=law())
    for pressure in (0.0, 34.5e3, 137.9e3):
        strain, force = oracle_springs.collapse(SIX, pressure, **reading)
        assert float(muscle.collapse_strain(pressure)) == pytest.approx(strain, rel=1e-9)
        assert float(muscle.force(pressure, strain)) == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize("law", [ResolvedSprings, LinkedSprings, StiffSprings])
def test_slopes_are_those_of_the_force(law):
    muscle = library_muscle(SIX).replace(buckling=law())
    strain, step = np.array([0.02, 0.05, 0.06]), 1e-6
    slope = muscle.law.at(0.0).force_and_slope(strain)[1]
    ends = [np.asarray(muscle.force(0.0, strain + side * step)) for side in (1, -1)]
    assert_allclose(slope, (ends[0] - ends[1]) / (2 * step), rtol=1e-5)


def test_projected_springs_yield_at_once_and_resolved_ones_from_eulers_load_on():
    """Without pressure, 0.001 past the free strain: a straight column would not bow there."""
    projected, resolved = (
        oracle_springs.state(SIX, 0.0, 0.001, statics=statics)
        for statics in ("projected", "resolved")
    )
    assert projected[1] > 0 and resolved[1] == 0

"""The paper's shape with its springs in series, against an oracle that bisects."""

import dataclasses

import numpy as np
import oracle_muscle
import oracle_series
from from_oracle import library_muscle
from numpy.testing import assert_allclose
from oracle_random import random_cases

import fascicle as fs
from reproduction.kim2021.series import SpringsInSeries


def test_forces_deflections_and_moments_are_the_oracles():
    bowed = 0
    for case in random_cases(5, 24):
        muscle = library_muscle(case.muscle).replace(
            buckling=SpringsInSeries(),
            collapse="kim2021",
            tuning=fs.Tuning(collapse_moment_factor=1e6),
        )
        free = float(muscle.free_strain(case.pressure))
        for strain in case.strains:
            if strain <= free + 1e-6:
                continue
            force, arc, y, moment = oracle_series.state(case.muscle, case.pressure, strain)
            found = muscle.response(case.pressure, strain)
            assert_allclose(found.force, force, rtol=1e-9, atol=1e-9)
            # deflections are roots of what is bisected to 1e-15
            assert_allclose(muscle.deflection(case.pressure, strain), y, rtol=1e-6, atol=1e-9)
            assert_allclose(muscle.moment(case.pressure, strain), moment, rtol=1e-6, atol=1e-9)
            bowed += arc < strain
    assert bowed > 40


def test_a_stubby_one_bows_and_is_straight_again():
    case = oracle_muscle.Muscle(0.0578, 0.01094, 0.00129, np.radians(24.61), oracle_muscle.LATEX)
    muscle = library_muscle(case).replace(
        buckling=SpringsInSeries(), tuning=fs.Tuning(collapse_moment_factor=1e6)
    )
    strains = np.linspace(0.05, 0.6, 56)
    every = [oracle_series.state(case, 0.0, strain) for strain in strains]
    assert_allclose(muscle.force(0.0, strains), [one[0] for one in every], rtol=1e-9)
    fine = np.linspace(0.08, 0.1, 401)
    bent = muscle.deflection(0.0, fine) > 0
    assert np.any(bent) and not (bent[0] or bent[-1])
    # a bound on the slope, 1 kN for each of strain: it doesn't jump where it is straight again
    assert np.max(np.abs(np.diff(muscle.force(0.0, fine)))) < 1e3 * (fine[1] - fine[0])


def test_it_collapses_where_its_moment_arrives():
    seen = 0
    for case in random_cases(6, 20):
        muscle = library_muscle(dataclasses.replace(case.muscle)).replace(
            buckling=SpringsInSeries(), collapse="wood1958"
        )
        limit = float(muscle.collapse_moment(case.pressure))
        strain = float(muscle.collapse_strain(case.pressure))
        moments = [
            oracle_series.state(case.muscle, case.pressure, e)[3]
            for e in np.linspace(float(muscle.free_strain(case.pressure)) + 1e-6, 0.6, 200)
        ]
        if not strain < 0.6:
            assert max(moments) < limit * (1 + 1e-6)
            continue
        seen += 1
        assert_allclose(
            oracle_series.state(case.muscle, case.pressure, strain)[3], limit, rtol=1e-7
        )
    assert seen > 3

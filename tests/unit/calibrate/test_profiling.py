from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.calibrate.intervals import profiles
from fascicle.calibrate.least_squares import NORMAL


@pytest.fixture(scope="module")
def made(straight):
    return straight()


@pytest.fixture(scope="module")
def found(made):
    return profiles(made)


def test_a_quadratic_problems_interval_is_walds(made, found):
    deviation = np.sqrt(np.diag(made.covariance))
    for i, one in enumerate(found):
        # 7 digits: the others are held to 1e-8 of a coordinate, 1e-6 of its deviation
        ends = np.exp(made.coordinates[i] + NORMAL * deviation[i] * np.array([-1, 1]))
        # values are exponentials: between places the crossing is linear in the value, which
        # over 0.6 deviations of 0.05 curves by (0.6 * 0.05)²/8
        assert_allclose([one.low, one.high], ends, atol=np.exp(made.coordinates[i]) * 2e-4)
        assert one.name == made.names[i]


def test_its_rise_is_the_square_of_the_step(made, found):
    steps = np.linspace(-1.8, 1.8, 7)  # as far as the critical rise
    for i, one in enumerate(found):
        deviation = np.sqrt(made.covariance[i, i])
        z, prior = made.coordinates[i], float(made.problem.deviation[i])
        # the posterior rises by the square; what its own prior adds is not the data's
        own = ((z + steps * deviation) ** 2 - z**2) / prior**2
        assert_allclose(one.rise, steps**2 - own, atol=1e-5)
        assert_allclose(np.log(one.value), made.coordinates[i] + steps * deviation, rtol=1e-6)


def test_only_the_variance_that_the_problem_knows_counts(made, found):
    # half of the variance comes from readings, and residuals follow one another
    C, diagnosis = made.covariance, replace(made.diagnosis, inflation=2.0)
    minimum = made.minimum._replace(covariance=3 * C, from_curves=2 * C)
    wider = replace(made, minimum=minimum, diagnosis=diagnosis)
    for before, after in zip(found, profiles(wider), strict=True):
        # steps are twice as long, and again rise by their square in deviations, but for the
        # prior's part, under 0.01 here, which goes with the step and not with the variance
        assert_allclose(after.rise, before.rise, atol=0.01)
        assert np.log(after.high / after.low) > 1.95 * np.log(before.high / before.low)

"""Curves and factors as one vector: against least squares written once more."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import least_squares

import fascicle as fs
from fascicle.calibrate import fit, tuning
from fascicle.calibrate.least_squares import starts_around
from fascicle.calibrate.parameters import FACTORS, put
from fascicle.calibrate.readings import SmoothCurves
from fascicle.muscle.tuning import Tuning
from fascicle.records import VirtualDynamometer
from fascicle.records.record import Record


TRUE = fs.example("kim2021_slenderness_10")
DRAWN = fs.Muscle.from_dimensions(
    TRUE.length, TRUE.outer_radius, TRUE.wall_thickness, TRUE.braid_angle, material=TRUE.material
)
MACHINE = VirtualDynamometer(
    pressures=[0.0, 82.7e3, 165.5e3, 248.2e3, 344.7e3], samples=60, both_ways=False
)


@pytest.fixture(scope="module")
def tuned():
    return fit(MACHINE.record(TRUE, seed=1), DRAWN)


def force_of(vector, data):
    """The muscle's force with factors and curves of a vector, by the public muscle alone."""
    z, curves = vector[:5], vector[5:]
    P = np.asarray(data.pressure)[:, 0]
    c1, c2 = SmoothCurves(DRAWN, P, P.max()).corrections(curves)
    muscle = put(FACTORS, DRAWN, z)
    old = muscle.tuning
    some = P > 0
    tuning = Tuning(
        P[some], c1[some], c2[some], youngs_modulus_factor=old.youngs_modulus_factor,
        collapse_moment_factor=old.collapse_moment_factor,
        hinge_stiffness_factor=old.hinge_stiffness_factor,
        hinge_stiffness_slope=old.hinge_stiffness_slope, transition_rate=old.transition_rate,
    )  # fmt: skip
    return np.asarray(muscle.replace(tuning=tuning).force(data.pressure, data.strain))


@pytest.mark.slow
def test_the_minimum_is_scipys(tuned):
    data, noise = tuned.grid, float(tuned.problem.noise)
    at = np.concatenate([tuned.coordinates, tuned.readings.coefficients])
    blocked = 10 * np.max(np.abs(tuned.readings.blocked_force[tuned.readings.valid]))
    center = np.concatenate([np.asarray(tuned.problem.center), [1.0, 0, 0, 0, 0, 0]])
    spread = np.concatenate(
        [np.asarray(tuned.problem.deviation), [3.0, 0.3, 0.3, 0.3, blocked, blocked]]
    )

    def residuals(share):
        vector = at + share * scale
        missed = (np.asarray(data.force) - force_of(vector, data)) / noise
        return np.concatenate([missed.reshape(-1), (vector - center) / spread])

    scale = np.concatenate([
        np.sqrt(np.diag(tuned.covariance)), np.sqrt(np.diag(tuned.readings.covariance))
    ])  # fmt: skip
    found = least_squares(residuals, np.zeros(11), diff_step=1e-4, xtol=1e-10, ftol=1e-12)
    # differences over 1e-4 of a deviation, at kinks: a twentieth of a deviation
    assert_allclose(found.x, 0, atol=0.05)
    assert found.cost > 0.5 * np.sum(residuals(np.zeros(11)) ** 2) - 1e-3


def test_starts_and_seed_are_those_of_the_joint_search_too(tuned, monkeypatch):
    seen = []

    def spy(center, count, seed=0, covariance=None):
        seen.append((count, seed))
        return starts_around(center, count, seed, covariance)

    monkeypatch.setattr(tuning, "starts_around", spy)
    fit(tuned.record, tuned.start, starts=2, seed=7)
    assert seen == [(2, 7)]


def test_every_reading_has_a_say(tuned):
    # the noise is that of all readings: 300 of 0.5 % of the largest force know it to 4 %
    scale = 0.005 * np.abs(tuned.record.force).max()
    assert_allclose(float(tuned.problem.noise) / scale, 1, atol=0.13)
    mean, covariance = tuned.readings.pulling
    # what resists adds to what is known of the curves, and moves them by no more than they are
    # unsure
    more = np.diag(covariance) - np.diag(tuned.readings.covariance)
    assert np.all(more > -1e-9 * np.diag(covariance))
    away = (tuned.readings.coefficients - mean) / np.sqrt(np.diag(covariance))
    assert np.max(np.abs(away)) < 4


@pytest.mark.parametrize("quotient", [(0.94, 0.1, 0.0, 0.0), (0.9, 0.3, -0.18, 0.0)])
def test_no_order_is_chosen(quotient):
    # a synthetic truth whose free strain is the law's times a polynomial of this order
    rows = np.linspace(2e4, 344.7e3, 300)
    line = [0.0, float(TRUE.blocked_force(344.7e3))]
    c1, c2 = SmoothCurves(DRAWN, rows, 344.7e3).corrections(np.array([*quotient, *line]))
    truth = DRAWN.replace(tuning=Tuning(rows, c1, c2, collapse_moment_factor=0.75))
    made = fit(MACHINE.record(truth, seed=2), DRAWN)
    share = np.array([0.25, 0.5, 0.75, 1.0])
    powers = share[:, None] ** np.arange(4)
    found, C = made.readings.coefficients[:4], made.readings.covariance[:4, :4]
    away = powers @ (found - np.array(quotient))
    spread = np.sqrt(np.einsum("li,ij,lj->l", powers, C, powers))
    assert np.all(np.abs(away) < 4 * spread) and np.all(spread < 0.02)


def test_where_the_law_misses_the_pull_readings_stay_as_read():
    P, eps = np.linspace(1e5, 4e5, 5)[:, None], np.linspace(0, 0.3, 30)
    force = np.asarray(DRAWN.force(P, eps)) + 20 * np.sin(14 * eps)  # no law's
    noise = 0.2 * np.random.default_rng(0).normal(size=force.shape)
    made = fit(Record.of(P, eps, force + noise, rest_length=0.127), DRAWN)
    assert made.readings.pulling is None

"""Intervals from simulated records: what is simulated, what is done of it, and what it is worth."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.calibrate import bootstrap, fit
from fascicle.calibrate.intervals import simulate_grid
from fascicle.records import VirtualDynamometer
from fascicle.records.record import Record


TRUE = fs.example("kim2021_slenderness_10")
DRAWN = fs.Muscle.from_dimensions(
    TRUE.length, TRUE.outer_radius, TRUE.wall_thickness, TRUE.braid_angle, material=TRUE.material
)
NAMES = ["braid_angle", "outer_radius"]
P, STRAIN = np.array([50e3, 100e3, 150e3, 200e3, 300e3])[:, None], np.linspace(0, 0.32, 12)


@pytest.fixture(scope="module")
def tuned():
    machine = VirtualDynamometer(
        pressures=[0.0, 82.7e3, 165.5e3, 248.2e3, 344.7e3], samples=60, both_ways=False
    )
    return fit(machine.record(TRUE, seed=1), DRAWN)


@pytest.fixture(scope="module")
def constants():
    nominal = DRAWN.replace(outer_radius=6e-3, braid_angle=np.radians(30))
    force = np.asarray(DRAWN.force(P, STRAIN))
    force = force + np.random.default_rng(0).normal(size=force.shape)
    record = Record.of(P, STRAIN, np.maximum(force, 0), force <= 0, rest_length=0.127)
    return fit(record, nominal, NAMES, whole=False)


def test_records_are_simulated_as_they_were_measured(constants):
    data, rng = constants.grid, np.random.default_rng(1)
    made = [simulate_grid(constants, rng) for _ in range(400)]
    there = np.asarray(data.count) > 0
    forces = np.array([one.force for one in made])
    clipped = np.array([one.censored for one in made])
    mu, noise = constants.force, float(constants.problem.noise)
    # clipped where the gauge would have clipped, and zero there
    assert np.all(forces[clipped] == 0) and np.all(forces[:, there] >= 0)
    sure = there & (mu > 5 * noise)
    assert not clipped[:, sure].any() and clipped[:, there & (mu < -5 * noise)].all()
    # 400 draws know a mean to 5 %, a deviation to 3.5 % of it; five of these
    away = (forces - mu)[:, sure] / noise
    assert_allclose(away.mean(axis=0), 0, atol=0.25)
    assert_allclose(away.std(axis=0), 1, atol=0.18)


def test_the_models_own_error_is_drawn_with_the_noise(constants):
    shape = constants.grid.count.shape[:2]
    wrong = replace(
        constants,
        diagnosis=replace(constants.diagnosis, discrepancy=np.full((*shape, 1), 15.0)),
    )
    there = np.asarray(constants.grid.count) > 0
    sure = there & (constants.force > 60)  # never clipped
    assert sure.sum() >= 3
    rng = np.random.default_rng(2)
    off = [(simulate_grid(wrong, rng).force - constants.force)[sure] for _ in range(50)]
    # one number for all readings of a record, another for the next
    assert np.max(np.ptp(off, axis=1)) < 10 and np.std(np.mean(off, axis=1)) > 8


def test_intervals_of_a_nearly_linear_problem_are_the_quick_ones(constants):
    made = bootstrap(constants, 99, seed=3)
    boots = made.bootstrapped
    assert boots.failed == 0 and boots.coordinates.shape == (99, 2)
    for quick, one in zip(constants.parameters, made.parameters, strict=True):
        assert one.value == quick.value and one.low < one.value < one.high
        # ends by the 5th of 99 are known to 15 % of a half width; three of these
        assert_allclose((one.high - one.low) / (quick.high - quick.low), 1, atol=0.35)
    assert "99 draws" in made.intervals and "linear" in constants.intervals
    assert made.muscle is constants.muscle


def test_ends_are_the_errors_of_the_draws_turned_about(constants):
    made = bootstrap(constants, 19, seed=4)
    error = np.sort(made.bootstrapped.coordinates - constants.coordinates, axis=0)
    radius = made.parameters[1]
    # of 19 the first and the last; the radius keeps clear of its wall by the exponential
    wall = float(constants.muscle.wall_thickness)
    low, high = constants.coordinates[1] - error[[-1, 0], 1]
    assert_allclose([radius.low, radius.high], wall + np.exp([low, high]), rtol=1e-9)
    again = bootstrap(constants, 19, seed=4)
    assert_array_equal(again.bootstrapped.low, made.bootstrapped.low)
    assert np.any(bootstrap(constants, 19, seed=5).bootstrapped.low != made.bootstrapped.low)


def test_a_constant_that_may_be_zero_lies_where_its_draws_do():
    # synthetic: a dead band of 1 kPa, which noise of 6 N hides, among pressures from 50 kPa on
    force = np.asarray(DRAWN.force(P - 1e3, STRAIN))
    force = force + 6 * np.random.default_rng(4).normal(size=force.shape)
    record = Record.of(P, STRAIN, np.maximum(force, 0), force <= 0, rest_length=0.127)
    made = bootstrap(fit(record, DRAWN, ["outer_radius", "dead_band"], whole=False), 49, seed=1)
    radius, band = made.parameters
    values = np.sort(made.bootstrapped.values[:, 1])
    assert np.std(made.bootstrapped.coordinates[:, 1]) > 1 and made.diagnosis.inflation == 1
    # of 49 the 2nd or 3rd from either end
    assert values[1] <= band.low <= values[3] and values[-4] <= band.high <= values[-2]
    assert radius.identifiable and not band.identifiable
    # turned round the upper end would be elsewhere
    assert not values[-4] <= band.value**2 / values[2] <= values[-2]


@pytest.mark.slow
def test_a_tuning_is_read_and_fitted_anew(tuned):
    assert tuned.readings.pulling is not None  # curves and factors were one vector
    made = bootstrap(tuned, 19, seed=6)
    assert np.all(np.std(made.bootstrapped.coordinates, axis=0) > 0)
    spread = np.std(made.bootstrapped.coordinates, axis=0) / np.sqrt(np.diag(tuned.covariance))
    # 19 draws know a deviation to 17 %; three of these
    assert np.all((spread > 0.5) & (spread < 1.6))


def test_what_cant_be_is_refused(constants):
    with pytest.raises(ValueError, match="`draws` must be at least 19"):
        bootstrap(constants, 10)
    robust = replace(constants, problem=replace(constants.problem, loss="cauchy"))
    with pytest.raises(ValueError, match="`loss` must be linear for a bootstrap"):
        bootstrap(robust, 19)

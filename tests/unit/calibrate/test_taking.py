"""Small readings among clipped ones: what a gauge's noise reads where a muscle doesn't pull."""

import numpy as np
from numpy.testing import assert_array_equal

from fascicle.calibrate.data.taking import TELLING, pulling_of, taken
from fascicle.calibrate.fits.resisting import FACTOR_NAMES
from fascicle.records.record import Record


STRAIN = np.linspace(0.0, 0.18, 10)
PULL = [100.0, 80.0, 60.0, 40.0, 20.0]  # N, the first five readings of a pressure


def seen(*rows, pressures=(1e5, 2e5, 3e5)):
    """Which readings of each pressure count as clipped, of forces that are clipped where zero."""
    force = np.array(rows)
    P = np.array(pressures[: len(rows)])[:, None] + 0 * force
    record = Record.of(P, STRAIN + 0 * force, force, force == 0, rest_length=0.2)
    of = pulling_of(taken(record))
    new = of.record.censored & ~record.censored
    assert of.slack == np.sum(new)
    assert np.all(of.record.force[of.record.censored] == 0)
    assert_array_equal(of.record.force[~of.record.censored], record.force[~of.record.censored])
    return new.reshape(force.shape)


def places(row):
    return np.flatnonzero(row).tolist()


def test_as_many_readings_must_push_as_what_resists_has_factors():
    assert len(FACTOR_NAMES) == TELLING


def test_beyond_the_end_of_the_pull_they_are_noise_and_before_it_as_small_ones_too():
    # 2 N lies among clipped ones: noise; 1.5 N just before the first of these is no more
    (row,) = seen([*PULL, 1.5, 0, 2.0, 0, 0])
    assert places(row) == [5, 7]


def test_what_is_larger_than_that_noise_still_pulls():
    (row,) = seen([*PULL, 3.0, 0, 2.0, 0, 0])
    assert places(row) == [7]


def test_a_large_force_among_clipped_ones_is_no_noise():
    # more than a tenth of the pressure's largest: an outlier for the fit to show
    (row,) = seen([*PULL, 0, 0, 30.0, 0, 0])
    assert places(row) == []


def test_without_any_of_them_the_last_small_pull_stays():
    (row,) = seen([*PULL, 1.5, 0, 0, 0, 0])
    assert places(row) == []


def test_each_pressure_is_by_itself():
    pulls = [120.0, 100.0, 80.0, 60.0, 40.0, 20.0, 10.0, 5.0, 2.0, 1.0]
    noisy = [*PULL, 1.5, 0, 2.0, 0, 0]
    rows = seen(noisy, pulls)
    # where nothing is clipped the smallest forces pull
    assert [places(row) for row in rows] == [[5, 7], []]


def test_without_pressure_a_muscle_does_not_pull_at_all():
    idle = [0, 1.0, 0, 1.2, 0.5, 0, 0, 0, 0, 0]
    pulls = [120.0, 100.0, 80.0, 60.0, 40.0, 20.0, 10.0, 5.0, 2.0, 1.0]
    rows = seen(idle, pulls, pressures=(0.0, 3e5))
    assert [places(row) for row in rows] == [[1, 3, 4], []]

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle.calibrate.data import (
    MAX_READINGS,
    assign_levels,
    fit_table,
    pulling_only,
    select_fit_data,
)
from fascicle.records.record import Record


STEPS = 34.5e3 * np.arange(13)


def test_a_transducers_scatter_is_one_level():
    # 200 Pa is 0.05 % of the highest pressure, a good transducer; ten times finer than a gap
    rng = np.random.default_rng(0)
    nominal = rng.permutation(np.repeat(STEPS, 50))
    levels = assign_levels(nominal + rng.normal(scale=200, size=nominal.size))
    assert_array_equal(levels, np.round(nominal / 34.5e3))


def test_levels_are_numbered_from_the_lowest_and_no_pressure_is_one():
    assert_array_equal(assign_levels(np.array([2e5, 0.0, 1e5, 0.0])), [2, 0, 1, 0])
    assert_array_equal(assign_levels(np.zeros(3)), [0, 0, 0])
    # a transducer's zero may lie below zero
    assert_array_equal(assign_levels(np.array([-50.0, 1e5, 30.0])), [0, 1, 0])


def test_a_swept_pressure_is_cut_in_fine_steps():
    P = np.linspace(0, 4e5, 1001)
    levels = assign_levels(P)
    assert_array_equal(np.diff(levels) >= 0, True)
    assert_array_equal(np.unique(levels), np.arange(levels.max() + 1))
    widths = [np.ptp(P[levels == level]) for level in range(levels.max() + 1)]
    # 0.5 % of the highest pressure, and the rounding of the cut
    assert max(widths) <= 0.005 * 4e5 * (1 + 1e-12)
    assert levels.max() >= 199


def test_short_rows_hold_the_readings_as_they_were():
    record = Record.of([1e5, 2e5, 1e5, 1e5], [0.1, 0.2, 0.0, 0.2], [5.0, 6.0, 7.0, 0.0],
                       [False, False, False, True])  # fmt: skip
    made = fit_table(record).grid
    assert_array_equal(made.pressure, [[1e5], [2e5]])
    assert_array_equal(made.strain, [[0.1, 0.0, 0.2], [0.2, 0.0, 0.0]])
    assert_array_equal(made.force, [[5.0, 7.0, 0.0], [6.0, 0.0, 0.0]])
    assert_array_equal(made.count, [[1, 1, 1], [1, 0, 0]])
    assert_array_equal(made.censored, [[False, False, True], [False, False, False]])
    # neither a clipped reading nor a filled-up place is a force that was measured
    assert_array_equal(made.measured, [[True, True, False], [True, False, False]])


@pytest.mark.parametrize("n", [MAX_READINGS, MAX_READINGS + 1, 5000])
def test_averaging_keeps_counts_and_means(n):
    rng = np.random.default_rng(n)
    strain = rng.uniform(0, 0.3, n)
    force = 100 * (0.3 - strain) + rng.normal(size=n)
    clipped = force < 2
    made = fit_table(Record.of(1e5 + rng.normal(scale=10, size=n), strain, force, clipped)).grid
    assert made.count.shape[0] == 1
    assert made.count.shape[1] <= MAX_READINGS
    assert (made.count.shape[1] < n) == (n > MAX_READINGS)
    for mask, of in ((clipped, made.censored), (~clipped, made.measured)):
        count = np.where(np.asarray(of), np.asarray(made.count), 0.0)
        assert count.sum() == mask.sum()
        # sums of n terms in another order: n eps at the worst
        assert_allclose((count * made.force).sum(), force[mask].sum(), rtol=1e-11)
        assert_allclose((count * made.strain).sum(), strain[mask].sum(), rtol=1e-11)


def test_clipped_readings_are_never_averaged_with_others():
    n = 2000
    strain = np.repeat(np.linspace(0, 0.3, n // 2), 2)
    clipped = np.tile([False, True], n // 2)  # one of each at the same strain
    made = fit_table(Record.of(1e5, strain, np.where(clipped, 0.0, 7.0), clipped)).grid
    count, force = np.asarray(made.count)[0], np.asarray(made.force)[0]
    kinds = np.asarray(made.censored)[0][count > 0]
    assert kinds.sum() == (~kinds).sum() > 0
    assert_array_equal(force[count > 0], np.where(kinds, 0.0, 7.0))


def test_branches_are_never_averaged_with_each_other():
    n = 3000
    strain = np.r_[np.linspace(0, 0.3, n), np.linspace(0.3, 0, n)]
    branch = np.repeat([1, -1], n)
    made = fit_table(Record.of(1e5, strain, 10.0 * branch, branch=branch))
    used = np.asarray(made.grid.count) > 0
    # a loop of 20 N is still one: no mean lies between its branches
    assert_array_equal(np.asarray(made.grid.force)[used], 10.0 * made.branch[used])
    assert (made.averaged, made.means) == (2 * n, MAX_READINGS)
    # where each reading went
    force = np.asarray(made.grid.force)[made.level, made.column]
    assert_array_equal(force, 10.0 * branch)
    middle = np.asarray(made.grid.strain)[made.level, made.column]
    assert_allclose(middle, strain, atol=0.3 / (MAX_READINGS // 2))


STRAIN = np.linspace(0.0, 0.18, 10)
PULL = [100.0, 80.0, 60.0, 40.0, 20.0]  # N, the first five readings of a pressure


def seen(*rows, pressures):
    """Which readings of each pressure count as clipped, of forces that are clipped where zero."""
    force = np.array(rows)
    P = np.array(pressures)[:, None] + 0 * force
    record = Record.of(P, STRAIN + 0 * force, force, force == 0, rest_length=0.2)
    of = pulling_only(select_fit_data(record))
    new = of.record.censored & ~record.censored
    assert of.noise_clipped == np.sum(new)
    assert np.all(of.record.force[of.record.censored] == 0)
    assert_array_equal(of.record.force[~of.record.censored], record.force[~of.record.censored])
    return new.reshape(force.shape)


PULLS = [120.0, 100.0, 80.0, 60.0, 40.0, 20.0, 10.0, 5.0, 2.0, 1.0]


@pytest.mark.parametrize(
    ("rows", "pressures", "noise"),
    [
        # 2 N lies among clipped ones: noise; 1.5 N just before the first of these is no more
        ([[*PULL, 1.5, 0, 2.0, 0, 0]], [1e5], [[5, 7]]),
        # what is larger than that noise still pulls
        ([[*PULL, 3.0, 0, 2.0, 0, 0]], [1e5], [[7]]),
        # more than a tenth of the pressure's largest: an outlier for the fit to show
        ([[*PULL, 0, 0, 30.0, 0, 0]], [1e5], [[]]),
        # none among clipped ones: the last small pull stays
        ([[*PULL, 1.5, 0, 0, 0, 0]], [1e5], [[]]),
        # each pressure by itself: where nothing is clipped the smallest forces pull
        ([[*PULL, 1.5, 0, 2.0, 0, 0], PULLS], [1e5, 2e5], [[5, 7], []]),
        # without pressure a muscle does not pull
        ([[0, 1.0, 0, 1.2, 0.5, 0, 0, 0, 0, 0], PULLS], [0.0, 3e5], [[1, 3, 4], []]),
    ],
)
def test_small_forces_past_the_pull_are_noise(rows, pressures, noise):
    assert [np.flatnonzero(row).tolist() for row in seen(*rows, pressures=pressures)] == noise


def test_readings_that_do_not_pull_are_not_said_to_be_clipped():
    force = np.array([PULLS, [*PULLS[:-1], -2.0]])
    P = np.array([[1e5], [2e5]]) + 0 * force
    data = select_fit_data(Record.of(P, STRAIN + 0 * force, force, rest_length=0.2))
    for _ in range(2):  # again for data that only pull
        data = pulling_only(data)
        assert (data.pushes_clipped, data.clipped, data.counts()["clipped"]) == (1, 0, 0)
        assert data.record.censored.sum() == 1

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle.calibrate.data.grid import LONGEST, gathered, grid, level_of, trimmed
from fascicle.records.record import Record


STEPS = 34.5e3 * np.arange(13)


def test_a_transducers_scatter_is_one_level():
    # 200 Pa is 0.05 % of the highest pressure, a good transducer; ten times finer than a gap
    rng = np.random.default_rng(0)
    nominal = rng.permutation(np.repeat(STEPS, 50))
    levels = level_of(nominal + rng.normal(scale=200, size=nominal.size))
    assert_array_equal(levels, np.round(nominal / 34.5e3))


def test_levels_are_numbered_from_the_lowest_and_no_pressure_is_one():
    assert_array_equal(level_of(np.array([2e5, 0.0, 1e5, 0.0])), [2, 0, 1, 0])
    assert_array_equal(level_of(np.zeros(3)), [0, 0, 0])
    # a transducer's zero may lie below zero
    assert_array_equal(level_of(np.array([-50.0, 1e5, 30.0])), [0, 1, 0])


def test_a_swept_pressure_is_cut_in_fine_steps():
    P = np.linspace(0, 4e5, 1001)
    levels = level_of(P)
    assert_array_equal(np.diff(levels) >= 0, True)
    assert_array_equal(np.unique(levels), np.arange(levels.max() + 1))
    widths = [np.ptp(P[levels == level]) for level in range(levels.max() + 1)]
    # 0.5 % of the highest pressure, and the rounding of the cut
    assert max(widths) <= 0.005 * 4e5 * (1 + 1e-12)
    assert levels.max() >= 199


def test_a_sweep_beside_steps_leaves_the_steps_alone():
    P = np.concatenate([np.repeat([1e5, 2e5], 5), np.linspace(3e5, 4e5, 101)])
    levels = level_of(P)
    assert_array_equal(levels[:10], np.repeat([0, 1], 5))
    assert np.unique(levels[10:]).size >= 50


def test_short_rows_hold_the_readings_as_they_were():
    record = Record.of([1e5, 2e5, 1e5, 1e5], [0.1, 0.2, 0.0, 0.2], [5.0, 6.0, 7.0, 0.0],
                       [False, False, False, True])  # fmt: skip
    made = trimmed(grid(record))
    assert_array_equal(made.pressure, [[1e5], [2e5]])
    assert_array_equal(made.strain, [[0.1, 0.0, 0.2], [0.2, 0.0, 0.0]])
    assert_array_equal(made.force, [[5.0, 7.0, 0.0], [6.0, 0.0, 0.0]])
    assert_array_equal(made.count, [[1, 1, 1], [1, 0, 0]])
    assert_array_equal(made.censored, [[False, False, True], [False, False, False]])
    # neither a clipped reading nor a filled-up place is a force that was measured
    assert_array_equal(made.uncensored, [[True, True, False], [True, False, False]])


@pytest.mark.parametrize("n", [LONGEST, LONGEST + 1, 5000])
def test_averaging_keeps_counts_and_means(n):
    rng = np.random.default_rng(n)
    strain = rng.uniform(0, 0.3, n)
    force = 100 * (0.3 - strain) + rng.normal(size=n)
    clipped = force < 2
    made = trimmed(grid(Record.of(1e5 + rng.normal(scale=10, size=n), strain, force, clipped)))
    assert made.count.shape[0] == 1
    assert made.count.shape[1] <= LONGEST
    assert (made.count.shape[1] < n) == (n > LONGEST)
    for mask, of in ((clipped, made.censored), (~clipped, made.uncensored)):
        count = np.where(np.asarray(of), np.asarray(made.count), 0.0)
        assert count.sum() == mask.sum()
        # sums of n terms in another order: n eps at the worst
        assert_allclose((count * made.force).sum(), force[mask].sum(), rtol=1e-11)
        assert_allclose((count * made.strain).sum(), strain[mask].sum(), rtol=1e-11)


def test_clipped_readings_are_never_averaged_with_others():
    n = 2000
    strain = np.repeat(np.linspace(0, 0.3, n // 2), 2)
    clipped = np.tile([False, True], n // 2)  # one of each at the same strain
    made = grid(Record.of(1e5, strain, np.where(clipped, 0.0, 7.0), clipped))
    count, force = np.asarray(made.count)[0], np.asarray(made.force)[0]
    kinds = np.asarray(made.censored)[0][count > 0]
    assert kinds.sum() == (~kinds).sum() > 0
    assert_array_equal(force[count > 0], np.where(kinds, 0.0, 7.0))


def test_averages_stay_in_their_step_of_strain():
    n, longest = 3000, 20
    strain = np.linspace(0, 0.3, n)
    made = trimmed(grid(Record.of(1e5, strain, strain), longest))
    assert made.count.shape == (1, longest)
    # the middles of twenty even steps
    step = 0.3 / longest
    assert_allclose(made.strain[0], step * (np.arange(20) + 0.5), atol=0.3 / n)
    assert_allclose(made.force, made.strain, rtol=1e-13)


def test_a_long_stay_at_one_strain_is_one_average():
    made = trimmed(grid(Record.of(1e5, np.full(500, 0.1), np.full(500, 3.0))))
    assert_array_equal(made.count, [[500]])
    assert_allclose(made.strain, [[0.1]], rtol=1e-14)


def test_branches_are_never_averaged_with_each_other():
    n = 3000
    strain = np.r_[np.linspace(0, 0.3, n), np.linspace(0.3, 0, n)]
    branch = np.repeat([1, -1], n)
    made = gathered(Record.of(1e5, strain, 10.0 * branch, branch=branch))
    used = np.asarray(made.data.count) > 0
    # a loop of 20 N is still one: no mean lies between its branches
    assert_array_equal(np.asarray(made.data.force)[used], 10.0 * made.branch[used])
    assert (made.averaged, made.means) == (2 * n, LONGEST)
    # where each reading went
    force = np.asarray(made.data.force)[made.level, made.place]
    assert_array_equal(force, 10.0 * branch)
    middle = np.asarray(made.data.strain)[made.level, made.place]
    assert_allclose(middle, strain, atol=0.3 / (LONGEST // 2))


def test_records_of_nearly_the_same_size_make_tables_of_one_shape():
    shapes = {
        np.shape(
            grid(Record.of(1e5 * np.arange(levels)[:, None], np.linspace(0, 0.2, n), 1.0)).count
        )
        for levels, n in ((5, 6), (8, 8), (7, 3))
    }
    assert shapes == {(8, 8)}
    made = grid(Record.of(1e5 * np.arange(9)[:, None], np.linspace(0, 0.2, 13), 1.0))
    assert made.count.shape == (12, 16)
    assert np.asarray(made.count).sum() == 9 * 13
    # what fills up is no reading, at a pressure that can be
    assert not np.any(made.uncensored[9:]) and not np.any(made.uncensored[:, 13:])
    assert_array_equal(made.pressure[9:], 8e5)

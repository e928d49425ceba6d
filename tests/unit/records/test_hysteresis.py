import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle.core.errors import InvalidInputError
from fascicle.records import Record, averaged, join, loop_of


WIDTH = 6.0  # N, between the branches


def loops(points=120, noise=0.0, seed=0, timed=True):
    """Half-way force 1e-3 P (1 − 4 ε), less on the way there."""
    rng = np.random.default_rng(seed)
    one = np.concatenate([np.linspace(0, 0.2, points), np.linspace(0.2, 0, points)])
    pressure = np.repeat([1e5, 2e5, 3e5], one.size)
    strain = np.tile(one, 3)
    way = np.tile(np.repeat([1, -1], points), 3)
    force = 1e-3 * pressure * (1 - 4 * strain) - way * WIDTH / 2
    force = force + noise * rng.normal(size=force.size)
    time = np.arange(force.size) * 0.01 if timed else None
    return Record.of(pressure, strain, force, time=time, synthetic=True, rest_length=0.3)


def test_the_half_way_curve_and_the_width():
    record = loops()
    before = record.force.copy()
    half = averaged(record, points=20)
    assert len(half.record) == 3 * 20
    expected = 1e-3 * half.record.pressure * (1 - 4 * half.record.strain)
    assert_allclose(half.record.force, expected, rtol=0, atol=1e-11)
    assert_allclose(half.width, WIDTH, rtol=0, atol=1e-11)
    assert_array_equal(np.unique(half.record.pressure), [1e5, 2e5, 3e5])
    # what it was made of stays, and what it is stays known
    assert_array_equal(record.force, before)
    assert (half.record.synthetic, half.record.rest_length, half.record.time) == (True, 0.3, None)
    assert half.record.findings[-1].data == {"loops": 3, "levels": 3}


def test_noise_is_averaged_in_cells():
    half = averaged(loops(points=2000, noise=1.0), points=20)
    expected = 1e-3 * half.record.pressure * (1 - 4 * half.record.strain)
    # 50 to 100 readings in a cell, two branches: 1 N/√100, five of these; a half cell at the
    # ends is off by a quarter of a cell, 0.2/19/4 · 1200 N
    ends = np.isin(half.record.strain, [0, 0.2])
    error = np.abs(half.record.force - expected)
    assert np.max(error[1:-1]) < 5 * 0.1 + 0.2 / 19 / 4 * 1200
    assert np.sqrt(np.mean(error[~ends] ** 2)) < 2 * 0.1
    assert np.mean(half.width) == pytest.approx(WIDTH, abs=5 * 2**0.5 / 6000**0.5)


def test_equal_strains_need_no_grid():
    strains = [0.0, 0.07, 0.1, 0.15]
    branch, clipped = np.repeat([1, -1], 4), np.arange(8) == 3
    half = averaged(Record.of(1e5, strains * 2, [8, 6, 4, 2, 10, 8, 6, 4], clipped, branch))
    assert_array_equal(half.record.strain, strains)
    assert_array_equal(half.record.force, [9, 7, 5, 3])
    assert_array_equal(half.width, 2)
    # of one clipped branch the mean is
    assert_array_equal(half.record.censored, [False, False, False, True])


def test_one_branch_is_kept_as_it_is():
    loop = loops(points=30)
    record = loop.only(np.arange(len(loop)) < 90)  # the second loop never comes back
    half = averaged(record, points=30)
    single = half.record.only(half.record.pressure == 2e5)
    assert_array_equal(single.force, record.force[60:90])
    assert np.isnan(half.width[half.record.pressure == 2e5]).all()
    assert half.record.findings[-1].data == {"loops": 1, "levels": 2}


def test_branches_of_two_files_are_no_loop():
    P, strain = np.array([1e5, 3e5])[:, None], np.linspace(0, 0.2, 40)
    one_way = [Record.of(P, strain, 100 - 300 * strain - b, branch=b) for b in (1, -1)]
    both_ways = Record.of(P, np.tile(strain, 2), 9.0 + np.zeros(80), branch=np.repeat([1, -1], 40))
    assert loop_of(join(one_way)) is None
    assert loop_of(join([*one_way, both_ways])).pressure.size == 2


def test_what_it_refuses():
    t = np.linspace(0, 1, 300)
    for record, points in ((loops(), 1), (Record.of(4e5 * t, 0.2 * t, t), 50)):
        with pytest.raises(InvalidInputError) as error:
            averaged(record, points=points)
        assert error.value.argument == ("points" if points == 1 else "record")


def test_widths_are_those_that_were_put_in():
    P, strain = np.array([1e5, 3e5])[:, None], np.linspace(0, 0.2, 101)
    F, half = P * 1e-3 * (1 - strain / 0.3), np.array([3.0, 9.0])[:, None]
    both, branch = np.concatenate([F - half, F + half], axis=1), np.repeat([1, -1], strain.size)
    loop = loop_of(Record.of(P, np.tile(strain, 2), both, branch=branch))
    assert_allclose(loop.pressure, [1e5, 3e5])
    assert_allclose(loop.width, [6, 18], rtol=1e-9)
    assert_allclose(loop.share, 0.06, rtol=1e-9)
    assert_allclose(loop.half, np.sqrt((9 + 81) / 2), rtol=1e-9)
    assert loop_of(Record.of(1e5, strain, 100 * (1 - strain), branch=1)) is None  # one way


@pytest.mark.parametrize("way", [1, -1])
def test_loops_at_held_lengths_have_a_width_whichever_branch_is_stronger(way):
    pressure = np.tile([*np.linspace(0, 4e5, 60), *np.linspace(4e5, 0, 60)], 2)
    strain = np.repeat([0.0, 0.1], 120)
    branch = np.tile(np.repeat([1, -1], 60), 2)
    force = 1e-3 * pressure * (1 - 4 * strain) - way * branch * WIDTH / 2
    record = Record.of(pressure, strain, force, time=np.arange(240.0), rest_length=0.3)
    assert_allclose(averaged(record).width, WIDTH)
    assert_allclose(loop_of(record).width, WIDTH)

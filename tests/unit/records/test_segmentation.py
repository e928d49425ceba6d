import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fascicle.records import Record, runs


PRESSURES = np.arange(1, 13) * 34.5e3
STRAINS = np.concatenate([np.linspace(0, 0.25, 150), np.linspace(0.25, 0, 150)])
NOISE = 0.01  # of full scale


def sampled(held=PRESSURES, swept=STRAINS, ramp=20, noise=0.0, seed=0):
    """Setpoints held while the other is swept both ways, with ramps in between."""
    rng = np.random.default_rng(seed)
    level, free, number = [], [], []
    for i, setpoint in enumerate(held):
        start = held[i - 1] if i else 0.0
        level += [np.linspace(start, setpoint, ramp + 2)[1:-1], np.full(swept.size, setpoint)]
        # the carriage moves on during the ramp, so that nothing is held
        free += [0.5 * np.max(swept) * np.sin(np.linspace(0, np.pi, ramp)), swept]
        number += [np.full(ramp, -1), np.full(swept.size, i)]
    level, free, number = map(np.concatenate, (level, free, number))
    level = level + noise * np.max(level) * rng.normal(size=level.size)
    free = free + noise * np.ptp(free) * rng.normal(size=free.size)
    return level, free, number


def record_of(pressure, strain, timed=True, **more):
    time = np.arange(pressure.size) / 100.0 if timed else None
    return Record.of(pressure, strain, 100.0 - 200 * strain, time=time, **more)


def check_partition(found, record):
    points = np.concatenate([run.points for run in found])
    assert_array_equal(np.sort(points), np.arange(len(record)))
    assert [run.points[0] for run in found] == sorted(run.points[0] for run in found)


@pytest.mark.parametrize("noise", [0.0, 0.001, NOISE])
@pytest.mark.parametrize("seed", range(3))
def test_sampled_sweeps_at_held_pressures(noise, seed):
    pressure, strain, number = sampled(noise=noise, seed=seed)
    record = record_of(pressure, strain)
    found = runs(record)
    check_partition(found, record)
    sweeps = [run for run in found if run.kind == "pressure"]
    assert {run.kind for run in found} == {"pressure", "mixed"}
    assert [run.branch for run in sweeps] == [1, -1] * len(PRESSURES)
    for i, run in enumerate(sweeps):
        # the median of 150 readings is off by noise·1.25/√150; four of those
        assert abs(run.level - PRESSURES[i // 2]) <= 4 * 0.1 * noise * PRESSURES[-1] + 1e-6
        own = number[run.points] == i // 2
        # ends of ramps lie within the noise of the level they lead to
        assert np.count_nonzero(~own) <= 12
        assert np.count_nonzero(own) >= 150 - 12


def test_sampled_pressure_sweeps_at_held_lengths():
    lengths = np.linspace(0.02, 0.22, 6)
    swept = np.concatenate([np.linspace(0, 400e3, 120), np.linspace(400e3, 0, 120)])
    strain, pressure, _ = sampled(lengths, swept, noise=0.0)
    record = record_of(pressure, strain)
    found = runs(record)
    check_partition(found, record)
    sweeps = [run for run in found if run.kind == "strain"]
    assert [run.branch for run in sweeps] == [1, -1] * 6
    np.testing.assert_allclose([run.level for run in sweeps], np.repeat(lengths, 2))


def test_nothing_held_is_all_mixed():
    t = np.linspace(0, 1, 500)
    found = runs(record_of(4e5 * t, 0.2 * t))
    assert [run.kind for run in found] == ["mixed"]
    assert np.isnan(found[0].level)
    assert runs(Record.of([], [], [])) == ()


def table(pressures, strains):
    pressure, strain = (x.ravel() for x in np.meshgrid(pressures, strains, indexing="ij"))
    return pressure, strain


def test_a_sorted_table_has_levels_and_no_directions():
    # spaced as unevenly as measured tables are
    pressures = np.array([35e3, 65e3, 85e3, 135e3, 146.25e3, 157.5e3, 675e3])
    pressure, strain = table(pressures, [0.01, 0.06, 0.11, 0.17, 0.21, 0.26])
    found = runs(record_of(pressure, strain, timed=False))
    assert_array_equal([run.level for run in found], pressures)
    assert {run.kind for run in found} == {"pressure"}
    assert {run.branch for run in found} == {0}
    assert all(run.points.size == 6 for run in found)
    # with times the rows are a history
    assert {run.branch for run in runs(record_of(pressure, strain))} == {1}


@pytest.mark.parametrize("seed", range(3))
def test_a_shuffled_table_has_the_same_levels(seed):
    pressure, strain = table(np.arange(1, 8) * 5e4, np.linspace(0, 0.2, 9))
    order = np.random.default_rng(seed).permutation(pressure.size)
    found = runs(record_of(pressure[order], strain[order], timed=False))
    assert sorted(run.level for run in found) == list(np.arange(1, 8) * 5e4)
    for run in found:
        assert run.points.size == 9
        assert np.all(pressure[order][run.points] == run.level)


def test_a_table_by_length_is_read_by_length():
    strain, pressure = table([0.05, 0.1, 0.15], np.arange(1, 8) * 5e4)
    record = record_of(pressure, strain, timed=False)
    assert [(run.kind, run.level) for run in runs(record)] == [
        ("strain", 0.05), ("strain", 0.1), ("strain", 0.15)
    ]  # fmt: skip


def test_branches_told_by_the_record_are_kept():
    pressure, strain = table([1e5, 2e5], [0.0, 0.05, 0.1, 0.15] * 2)
    branch = np.tile(np.repeat([1, -1], 4), 2)
    found = runs(record_of(pressure, strain, timed=False, branch=branch))
    assert [(run.level, run.branch) for run in found] == [(1e5, 1), (1e5, -1), (2e5, 1), (2e5, -1)]
    order = np.random.default_rng(1).permutation(branch.size)
    shuffled = record_of(pressure[order], strain[order], timed=False, branch=branch[order])
    found = runs(shuffled)
    assert len(found) == 4
    for run in found:
        assert np.all(branch[order][run.points] == run.branch)
        assert run.points.size == 4


def test_an_untimed_loop_has_directions():
    strains = [0, 0.05, 0.1, 0.15, 0.1, 0.05, 0]
    pressure, strain = table([1e5, 2e5], strains)
    found = runs(record_of(pressure, strain, timed=False))
    assert [(run.branch, run.points.size) for run in found] == [(1, 4), (-1, 3)] * 2


def test_the_same_level_again_is_another_run():
    pressure, strain, _ = sampled(np.array([1e5, 2e5, 1e5]))
    sweeps = [run for run in runs(record_of(pressure, strain)) if run.kind == "pressure"]
    assert [run.level for run in sweeps] == [1e5, 1e5, 2e5, 2e5, 1e5, 1e5]


def test_masses_of_a_set_are_loads_though_each_was_at_the_same_pressures():
    pressures = [1e5, 2e5, 3e5, 4e5, 3e5, 2e5, 1e5]
    force, pressure = (x.ravel() for x in np.meshgrid([5.0, 20.0, 50.0], pressures, indexing="ij"))
    record = Record.of(pressure, pressure * 6e-7 - force * 1e-3, force)
    assert [(run.kind, run.branch) for run in runs(record)] == [("force", 1), ("force", -1)] * 3


def test_one_held_length_with_a_rulers_noise_has_two_branches():
    rng = np.random.default_rng(1)
    P = np.append(np.linspace(0, 4e5, 41), np.linspace(4e5, 0, 41)[1:])
    strain = rng.normal(0, 1e-4, P.size)
    found = runs(Record.of(P, strain, P / 1e3, time=np.arange(P.size) * 0.1))
    assert [(run.kind, run.branch) for run in found] == [("strain", 1), ("strain", -1)]
    assert [run.points.size for run in found] == [41, 40]


@pytest.mark.parametrize("noise", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("points", [400, 4000])
@pytest.mark.parametrize("load", [0.0, 25.0])
def test_cycles_of_pressure_under_one_load_have_two_branches_each(load, points, noise):
    """Also without a load, where the load cell reads its noise alone."""
    rng = np.random.default_rng(points)
    phase = np.linspace(0, 4, points)
    pressure = 4e5 * (1 - 2 * np.abs(phase % 1 - 0.5))
    strain = 0.25 * pressure / 4e5 + rng.normal(0, 3e-4, points)
    pressure = np.maximum(pressure + rng.normal(0, 600, points), 0)
    force = load + noise * rng.normal(size=points) * (0.3 if load else 1.0)
    found = runs(Record.of(pressure, strain, force, time=10 * phase))
    assert [(run.kind, run.branch) for run in found] == [("force", 1), ("force", -1)] * 4

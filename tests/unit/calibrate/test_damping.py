"""Damping by speed, found again in records of sweeps whose damping is known."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.calibrate.damping import fit_damping
from fascicle.records import Record, join


L = 0.25  # m
LEVELS = np.array([1e5, 2.2e5, 3.4e5, 5e5])  # Pa
SLOW, FAST = 4e-3, 40e-3  # m/s
DRY = 3.0  # N, friction whatever the speed


def coefficient(truth, P):
    """B(P) of one direction [N·s/m]; `truth`: at no pressure, and its rise [SI]."""
    return max(truth[0] + truth[1] * P, 0.0)


def sweeps(truth, speeds=(SLOW, FAST), levels=LEVELS, noise=0.0, seed=0, readings=60):
    """A synthetic record in time, and the error of a static law that misses its curvature: there
    and back at each level and speed; `truth`: of either direction.
    """
    rng, rows, clock = np.random.default_rng(seed), [], 0.0
    for speed in speeds:
        for P in levels:
            for direction in (1, -1):
                strain = np.linspace(0.0, 0.2, readings)[::direction]
                v = direction * speed
                drag = direction * DRY + coefficient(truth[direction], P) * v
                misfit = 8.0 * np.sin(20 * strain) + P / 1e5
                force = 1e-3 * P * (1 - 3 * strain) - drag + misfit
                for k in range(readings):
                    clock += 0.2 / (readings - 1) * L / speed
                    rows.append((P, strain[k], force[k], clock, misfit[k] - drag))
    P, strain, force, time, error = np.array(rows).T
    scatter = noise * rng.normal(size=P.size)
    record = Record.of(P, strain, force + scatter, time=time, rest_length=L, synthetic=True)
    return record, error + scatter


def random_truth(rng):
    """Damping that rises with pressure while shortening, and either way while lengthening."""
    return {
        1: (rng.uniform(5, 60), rng.uniform(0, 2e-4)),
        -1: (rng.uniform(20, 60), rng.uniform(-3e-5, 2e-4)),
    }


def directions(damping):
    return {1: damping.shortening, -1: damping.lengthening}


@pytest.mark.parametrize("seed", range(8))
def test_known_damping_is_found_again(seed):
    truth = random_truth(np.random.default_rng(seed))
    record, errors = sweeps(truth)
    damping = fit_damping(record, errors, L)
    for side, direction in directions(damping).items():
        # without noise what remains is the rounding of the strains' steps
        assert_allclose(direction.coefficients, truth[side], rtol=1e-6, atol=1e-9)
        assert direction.pressures == len(LEVELS)
    for P in LEVELS:
        for side in (1, -1):
            force = damping.law.force(side * FAST, P)
            assert_allclose(force, side * FAST * coefficient(truth[side], P), rtol=1e-6)


def test_standard_errors_are_those_of_the_noise():
    squares = []
    for seed in range(40):
        truth = random_truth(np.random.default_rng(seed))
        record, errors = sweeps(truth, noise=0.4, seed=seed)
        for side, direction in directions(fit_damping(record, errors, L)).items():
            miss = direction.coefficients - truth[side]
            squares.append(miss @ np.linalg.solve(direction.covariance, miss))
    # of two constants: chi-square of 160 degrees of freedom, four deviations of √320
    assert_allclose(sum(squares), 160, atol=4 * np.sqrt(320))


def test_noise_of_the_ruler_hardly_matters():
    truth = {1: (40.0, 1e-4), -1: (30.0, 1e-4)}
    record, errors = sweeps(truth, noise=0.2, readings=200)
    strain = record.strain + 2e-4 * np.random.default_rng(1).normal(size=len(record))
    read = Record.of(record.pressure, strain, record.force, time=record.time, rest_length=L)
    damping = fit_damping(read, errors, L)
    for side, direction in directions(damping).items():
        # speeds over a tenth of the stroke are off by 0.1 %
        value, error = direction.at(3e5)
        assert abs(value - coefficient(truth[side], 3e5)) < 0.01 * value + 4 * error


@pytest.mark.parametrize("speeds", [(SLOW,), (SLOW, 1.05 * SLOW)])
def test_speeds_that_hardly_differ_leave_it_unknown(speeds):
    truth = {1: (40.0, 1e-4), -1: (30.0, 1e-4)}
    damping = fit_damping(*sweeps(truth, speeds, noise=0.1), L)
    assert damping.shortening is None and damping.lengthening is None and damping.law is None
    assert damping.unknown == ["shortening", "lengthening"]
    assert_allclose(damping.speeds, (speeds[0], speeds[-1]), rtol=1e-6)


def test_without_times_it_is_unknown():
    record, errors = sweeps({1: (40.0, 0.0), -1: (40.0, 0.0)})
    untimed = Record.of(record.pressure, record.strain, record.force, rest_length=L)
    damping = fit_damping(untimed, errors, L)
    assert len(damping.unknown) == 2 and np.isnan(damping.speeds).all()


def test_one_direction_may_be_known_alone():
    truth = {1: (40.0, 1e-4), -1: (30.0, 1e-4)}
    record, errors = sweeps(truth)
    # the fast way back is left out
    back = np.gradient(record.strain) < 0
    used = ~(back & (np.arange(len(record)) >= len(record) // 2))
    damping = fit_damping(record.only(used), errors[used], L)
    assert damping.unknown == ["lengthening"]
    assert_allclose(damping.shortening.coefficients, truth[1], rtol=1e-6)
    assert damping.law.force(-FAST, 1e5) == 0 < damping.law.force(FAST, 1e5)


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_is_no_damping(seed):
    nothing = {1: (0.0, 0.0), -1: (0.0, 0.0)}
    damping = fit_damping(*sweeps(nothing, noise=0.5, seed=seed), L)
    assert damping.law is None and damping.unknown == []


def test_one_pressure_gives_a_constant():
    truth = {1: (40.0, 1e-4), -1: (30.0, 1e-4)}
    damping = fit_damping(*sweeps(truth, levels=LEVELS[:1]), L)
    for side, direction in directions(damping).items():
        expected = [coefficient(truth[side], LEVELS[0]), 0.0]
        assert_allclose(direction.coefficients, expected, rtol=1e-6)
        assert direction.pressures == 1


def test_a_file_for_each_speed_is_as_good_as_one():
    truth = {1: (40.0, 1e-4), -1: (30.0, 1e-4)}
    parts = [sweeps(truth, (speed,)) for speed in (SLOW, FAST)]
    record = join([part for part, _ in parts])
    damping = fit_damping(record, np.concatenate([errors for _, errors in parts]), L)
    for side, direction in directions(damping).items():
        assert_allclose(direction.coefficients, truth[side], rtol=1e-6)


def test_its_force_leaves_the_friction_that_no_speed_changes():
    truth = {1: (40.0, 1e-4), -1: (30.0, 1e-4)}
    record, errors = sweeps(truth)
    damping = fit_damping(record, errors, L)
    side = np.sign(np.gradient(record.strain))
    drag = damping.law.force(damping.velocity, record.pressure)
    rest = errors + drag - 8.0 * np.sin(20 * record.strain) - record.pressure / 1e5
    assert_allclose(rest, -DRY * side, atol=1e-5)

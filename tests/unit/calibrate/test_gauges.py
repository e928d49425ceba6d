"""Errors of the gauges in a fit, and faults of a record's channels; all records are synthetic."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate import Gauge, Prior, fit
from fascicle.calibrate.data import select_fit_data
from fascicle.calibrate.findings import calibration_findings
from fascicle.calibrate.fitting import FitOptions, set_up_problem
from fascicle.calibrate.gauges import PERFECT, channel_faults, drift_confounders, read_vented
from fascicle.calibrate.model_selection import possible_gauge_errors, select_model
from fascicle.calibrate.parameters import GAUGE_UNITS
from fascicle.core.module import with_fields
from fascicle.files.calibration_files import calibrated_text, provenance_of
from fascicle.records import VirtualDynamometer
from fascicle.records.record import Record, Source, join
from gauge_bench import MUSCLE, TRUE, TRUTH, bench_record


NAMES = ["c10", "c01", "force_zero", "force_gain", "force_drift", "pressure_zero"]


def test_a_corrected_reading_is_the_readings_inverse():
    gauge = Gauge(8.0, 1.03, 0.01, 1.5e3, 1e-3, start=10.0)
    record = Record.of(
        [2e5, 2e5], [0.0, 0.1], [100.0, 50.0], time=np.array([10.0, 30.0]), rest_length=0.2
    )
    read = replace(
        record, pressure=record.pressure + 1.5e3, strain=record.strain + 1e-3 / 0.2,
        force=1.03 * record.force + 8.0 + 0.01 * np.array([0.0, 20.0]),
    )  # fmt: skip
    corrected = gauge.correct(read)
    for name in ("pressure", "strain", "force"):
        assert_allclose(getattr(corrected, name), getattr(record, name), rtol=1e-12, atol=1e-12)


def test_readings_without_pressure_tell_the_zeros():
    gauge, zeros, _ = read_vented(bench_record(seed=1), MUSCLE)
    for name in ("force_zero", "force_drift", "pressure_zero"):
        error = getattr(gauge, name) - getattr(TRUTH, name)
        assert abs(error) < 4 * zeros[name][1]
    assert read_vented(bench_record(PERFECT, loop=0.0, seed=1), MUSCLE)[0] == PERFECT


def test_readings_of_a_prior_are_not_fitted_as_well():
    data = select_fit_data(bench_record(seed=1), MUSCLE)
    problem, _ = set_up_problem(data, MUSCLE, ["c10", "force_zero"], {}, FitOptions())
    at_rest = problem.weight[data.level[data.at_rest], data.column[data.at_rest]]
    assert at_rest.size and not np.any(at_rest) and np.mean(problem.weight[data.grid.used]) > 0.8
    deviation = GAUGE_UNITS["force_zero"] * problem.deviation[-1]
    assert_allclose(deviation, data.zeros["force_zero"][1])


@pytest.mark.parametrize("factor", [0.6, 1.2])
@pytest.mark.parametrize("samples", [50, 400])
@pytest.mark.parametrize("seeds", [1, pytest.param(5, marks=pytest.mark.slow)])
def test_a_column_that_folds_earlier_is_no_zero(samples, factor, seeds):
    # of many readings even a small misfit would be clear; without a zero none may be named
    example = fs.example("kim2021_slenderness_10")
    true = example.replace(tuning=with_fields(example.tuning, collapse_moment_factor=factor))
    nominal = true.replace(tuning=None)
    machine = VirtualDynamometer(pressures=(0.0, 2e5, 4e5), samples=samples)
    for seed in range(seeds):
        record = machine.record(true, seed=seed)
        assert not select_fit_data(record, nominal).gauge.faults
        zero = 0.03 * float(np.max(record.force))
        shifted = replace(record, force=record.force + zero)
        found = select_fit_data(shifted, nominal).gauge.faults
        assert found["force_zero"] == pytest.approx(zero, rel=0.3)
        # a zero that was given is not read again
        given = replace(shifted, zeroed=("force",))
        assert not select_fit_data(given, nominal).gauge.faults


@pytest.mark.parametrize("interval", [0.1, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_passive_force_of_later_lengths_is_no_drift(seed, interval):
    # isometric: the pressure rises and falls at one length after the other
    cycle = np.append(np.linspace(0, 4e5, 41), np.linspace(4e5, 0, 41))
    P, strain = np.tile(cycle, 4), np.repeat([0.0, 0.05, 0.1, 0.15], cycle.size)
    noise = np.random.default_rng(seed).normal(0, 1, P.size)
    force = np.asarray(MUSCLE.force(P, strain)) - 120 * strain + noise
    time = interval * np.arange(P.size)
    record = Record.of(P, strain, force, time=time, rest_length=0.2, synthetic=True)
    assert read_vented(record, MUSCLE)[0] == PERFECT


def test_a_zero_counts_next_to_the_rest_length():
    # synthetic: 90 vented readings over 2 % of strain
    strain = np.concatenate([np.linspace(0, 0.02, 45), np.linspace(0.02, 0, 45), np.zeros(2)])
    P = np.append(np.zeros(90), [3e5, 3e5])
    force = np.asarray(MUSCLE.force(P, strain)) + 4.0
    found = []
    for seed in range(10):
        noise = np.random.default_rng(seed).normal(0, 1.0, P.size)
        record = Record.of(P, strain, force + noise, rest_length=0.2, synthetic=True)
        found.append(read_vented(record, MUSCLE)[0].force_zero)
    assert all(zero > 0 for zero in found)
    # a straight muscle would push by 1 N more at the mean of the first strains
    assert max(abs(zero - 4.0) for zero in found) < 2.0


@pytest.mark.parametrize("zero", [0.0, 2.0])
def test_the_whole_model_shows_a_zero_that_rest_readings_do_not(zero):
    true = fs.example("kim2021_slenderness_10")
    nominal = true.replace(tuning=None)
    record = VirtualDynamometer(pressures=(0.0, 1e5, 2e5, 3e5, 4e5), samples=40).record(true)
    record = replace(record, force=record.force + zero)
    assert not select_fit_data(record, nominal).gauge.faults
    chosen = select_model(record, nominal, starts=1).calibration
    estimates = {estimate.name: estimate for estimate in chosen.parameters}
    assert ("force_zero" in estimates) == bool(zero)
    if zero:
        assert estimates["force_zero"].low < zero < estimates["force_zero"].high
    moment = estimates["collapse_moment_factor"]
    assert moment.low < float(true.tuning.collapse_moment_factor) < moment.high


@pytest.fixture(scope="module")
def fitted():
    return fit(bench_record(seed=2), MUSCLE, NAMES, whole=False)


def test_a_fit_separates_the_gauges_from_the_rubber(fitted):
    estimates = {estimate.name: estimate for estimate in fitted.parameters}
    for name in NAMES[2:]:
        estimate, truth = estimates[name], getattr(TRUTH, name)
        assert abs(estimate.value - truth) < 1.2 * (estimate.high - estimate.low)
        assert getattr(fitted.gauge, name) == pytest.approx(estimate.value)
    assert all(estimate.identifiable for estimate in estimates.values())
    # the loop isn't in the estimate of the noise, and is in the error of the muscle in use
    assert fitted.diagnosis.noise < 0.6 and fitted.rmse > 5
    # the record is the corrected one, and the gauge takes the file's readings to it
    corrected = fitted.gauge.correct(bench_record(seed=2))
    assert_allclose(corrected.force, fitted.record.force, rtol=1e-9, atol=1e-9)
    codes = [finding.code for finding in calibration_findings(fitted)]
    assert {f"gauge.{name}" for name in NAMES[2:]} <= set(codes)


def test_files_keep_the_gauge_beside_the_muscle(fitted):
    text = calibrated_text(fitted, "2026-01-01")
    assert "force_zero" not in text.split("[calibration]")[0]
    assert provenance_of(fitted, "2026-01-01")["gauge"].keys() == fitted.gauge.faults.keys()


def test_a_scale_of_the_load_cell_is_known_beside_a_given_radius_only():
    scale, P, strain = 1.03, np.array([1e5, 4e5]), np.array([0.02, 0.2])
    sizes = {
        name: np.sqrt(scale) * getattr(TRUE, name) for name in ("outer_radius", "wall_thickness")
    }
    assert_allclose(TRUE.replace(**sizes).force(P, strain), scale * TRUE.force(P, strain))
    record = bench_record(Gauge(force_gain=scale), loop=0.0, floor=5.0, seed=2)
    for size, unknown in (("outer_radius", True), ("braid_angle", False)):
        fitted = fit(record, MUSCLE, ["c10", "c01", size], whole=False)
        assert ("force_gain" in fitted.diagnosis.confounded) is unknown
    fitted = fit(record, MUSCLE, ["c10", "c01", "braid_angle", "force_gain"], whole=False)
    estimate = next(e for e in fitted.parameters if e.name == "force_gain")
    assert estimate.identifiable and estimate.low < scale < estimate.high


@pytest.mark.parametrize(("name", "value"), [("force_gain", 1.0), ("force_drift", -0.7)])
def test_a_prior_holds_an_error_of_a_gauge(name, value):
    held = fit(bench_record(seed=2), MUSCLE, NAMES, {name: Prior(value, 1e-6)}, whole=False)
    assert getattr(held.gauge, name) == pytest.approx(value, abs=1e-5)


RNG = np.random.default_rng(0)
SWEEP = 100 * np.concatenate([np.linspace(0, 1, 100), np.linspace(1, 0, 100)]) ** 1.1


def _record(force, pressure=None):
    time = 0.5 * np.arange(force.size)
    pressure = 1e3 * SWEEP + RNG.normal(0, 20, force.size) if pressure is None else pressure
    return Record.of(pressure, np.zeros(force.size), force, time=time, rest_length=0.2)


NOISY = SWEEP + RNG.normal(0, 0.1, SWEEP.size)
SATURATED = np.minimum(1e3 * SWEEP + RNG.normal(0, 20, SWEEP.size), 90e3)


def test_faults_of_channels_are_found():
    for force, pressure, kinds, value in (
        (np.maximum(SWEEP - 10, -3.7), None, [("floor", "force")], -3.7),
        (np.maximum(SWEEP, 8.0), None, [("floor", "force")], 8.0),
        (np.minimum(SWEEP, 80.0), None, [("ceiling", "force")], 80.0),
        (NOISY, SATURATED, [("saturation", "pressure")], 90e3),
        (NOISY, None, [], None),
    ):
        faults = channel_faults(_record(force, pressure))
        assert [(fault.kind, fault.channel) for fault in faults] == kinds
        assert all(fault.value == pytest.approx(value) for fault in faults)


def turning_bench(seed=0, zero=5.0, pressure_zero=2e3):
    """Synthetic sweeps both ways, whose friction builds up over 0.8 % of strain after a turn."""
    rng = np.random.default_rng(seed)
    one_way = np.linspace(0, 0.2, 120)
    strain = np.tile(np.append(one_way, one_way[::-1]), 4)
    P, branch = np.repeat([1e5, 2e5, 3e5, 4e5], 240), np.tile(np.repeat([1, -1], 120), 4)
    pull = np.asarray(MUSCLE.force(P, strain))
    since_turn = np.where(branch > 0, strain, 0.2 - strain)
    friction = branch * (1.5 + 0.04 * pull) * np.clip(2 * since_turn / 0.008 - 1, -1, 1)
    force = pull - friction + zero + 0.5 * rng.normal(size=P.size)
    pressure = P + pressure_zero + 600 * rng.normal(size=P.size)
    time = 0.1 * np.arange(P.size)
    return Record.of(pressure, strain, force, branch=branch, time=time, rest_length=0.2)


def test_zeros_are_found_beside_a_loop_that_builds_up_after_turns():
    record = turning_bench()
    data = select_fit_data(record, MUSCLE)
    # the five readings of each build-up, and twice its distance but for the fit's error
    near = np.abs(np.diff(record.branch, prepend=-1)) > 0
    assert data.turning[near].all() and 8 * 5 <= data.turning.sum() <= 8 * 12
    fitted = fit(record, MUSCLE, ["c10", "c01", "force_zero", "pressure_zero"], whole=False)
    estimates = {estimate.name: estimate for estimate in fitted.parameters}
    assert fitted.diagnosis.noise < 0.6
    for name, truth in (("force_zero", 5.0), ("pressure_zero", 2e3)):
        assert estimates[name].low < truth < estimates[name].high
    assert abs(estimates["force_zero"].value - 5.0) < 1.0


@pytest.mark.parametrize("tension", ["klute_hannaford", "tondu_lopez"])
def test_a_zero_is_one_number_where_the_law_errs(tension):
    # isometric, with friction of 1 N and 3 % that slides within 20 kPa
    cycle = np.concatenate([np.zeros(20), np.linspace(0, 4e5, 41), np.linspace(4e5, 0, 41)])
    P, strain = np.tile(cycle, 4), np.repeat([0.0, 0.05, 0.1, 0.15], cycle.size)
    side = np.clip(np.tile(np.cumsum(np.sign(np.diff(cycle, prepend=0))), 4), -1, 1)
    side = np.where(np.tile(np.arange(cycle.size) > 60, 4), -1, side)
    pull = np.asarray(TRUE.force(P, strain))
    noise = np.random.default_rng(1).normal(0, [[0.5], [400]], (2, P.size))
    force = pull + side * (1 + 0.03 * np.abs(pull)) + 5.0 + noise[0]
    time = 0.2 * np.arange(P.size)
    record = Record.of(P + 2e3 + noise[1], strain, force, time=time, rest_length=0.2)
    muscle = MUSCLE.replace(tension=tension)
    fitted = fit(record, muscle, ["braid_angle", "force_zero", "pressure_zero"], whole=False)
    for name, truth in (("force_zero", 5.0), ("pressure_zero", 2e3)):
        estimate = next(e for e in fitted.parameters if e.name == name)
        assert getattr(fitted.gauge, name) == pytest.approx(estimate.value)
        assert estimate.low < truth < estimate.high
    assert_allclose(fitted.gauge.correct(record).force, fitted.record.force)
    # friction and noise: what vented readings say of the zero is no better than half a loop
    assert 0.3 < fitted.fit_data.zeros["force_zero"][1] < 2


def drifting_record(clock, sources):
    """Sweeps both ways at four pressures in two halves, the second after an hour on one clock, or
    with a clock of its own; whole sweeps in each half, or one direction in each (`"branch"`).
    """
    halves = []
    for half in range(2):
        rows, time = [], 3600.0 * half * (clock != "own")
        for P in (1e5, 2e5, 3e5, 4e5):
            for way in (1, -1) if clock != "branch" else (1, 1) if half == 0 else (-1, -1):
                strain = np.linspace(0.0, 0.2, 25)[::way]
                pull = np.asarray(MUSCLE.law.tension.force(P, strain)) - 2.0 * way + half / 10
                rows += zip([P] * 25, strain, pull, time + np.arange(25.0), [way] * 25, strict=True)
                time += 30.0
        P, strain, force, time, branch = np.array(rows).T
        source = (Source(f"{half if sources == 2 else 0}.csv", "0" * 64),)
        halves.append(
            Record.of(P, strain, force, branch=branch, time=time, rest_length=0.2, sources=source)
        )
    if sources == 2:
        return join(halves)
    return replace(join(halves), sources=halves[0].sources, file=None)


@pytest.mark.parametrize(("clock", "sources", "confounders"), [
    ("one", 1, []), ("one", 2, ["file"]), ("branch", 1, ["branch"]),
    ("branch", 2, ["branch", "file"]), ("own", 2, []),
])  # fmt: skip
def test_a_drift_needs_a_time_that_no_branch_or_file_has_alone(clock, sources, confounders):
    record = drifting_record(clock, sources)
    data = select_fit_data(record, MUSCLE)
    assert drift_confounders(data.record) == confounders
    is_candidate = "force_drift" in possible_gauge_errors(data)
    assert is_candidate == (clock == "one" and sources == 1)
    if sources == 2 and clock != "one":  # both confounders, and none
        fitted = fit(record, MUSCLE, ["c10"], whole=False)
        codes = {finding.code: finding.data for finding in calibration_findings(fitted)}
        assert codes.get("coverage.drift_confounded", {}).get("confounders", []) == confounders

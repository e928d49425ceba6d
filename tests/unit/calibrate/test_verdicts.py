"""A calibration's verdicts follow from its own figures: intervals, choice, sweeps, loops."""

import math
from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.calibrate.calibration import Estimate, Profile
from fascicle.calibrate.data import select_fit_data
from fascicle.calibrate.findings import judge
from fascicle.calibrate.fitting import fit
from fascicle.calibrate.intervals import with_profiles
from fascicle.calibrate.model_selection import select_model
from fascicle.records.record import DOWN, UP, Record
from fascicle.records.segmentation import runs
from fascicle.report.calibration_words import interval_texts


MUSCLE = fs.Muscle(0.2, 9.5e-3, 1.5e-3, math.radians(26))


def record(P, strain, force, branch=None):
    """A synthetic record in time, of a muscle of 0.2 m."""
    branch = np.zeros(P.size) if branch is None else branch
    time = np.arange(P.size) * 0.5
    return Record.of(P, strain, force, branch=branch, time=time, rest_length=0.2)


def sweeps(levels, stroke, points=45, noise=0.0, loop=0.0, muscle=MUSCLE, seed=0):
    """A synthetic record in time: both ways at each level [Pa], to a stroke of strain [-]."""
    rng = np.random.default_rng(seed)
    P, strain, branch = [], [], []
    for level, end in zip(levels, stroke, strict=True):
        P += [level] * (2 * points)
        strain += [*np.linspace(0, end, points), *np.linspace(end, 0, points)]
        branch += [UP] * points + [DOWN] * points
    P, strain, branch = np.array(P), np.array(strain), np.array(branch)
    force = np.asarray(muscle.force(P, strain)) - loop * branch + noise * rng.normal(size=P.size)
    return record(P, strain, force, branch)


def test_a_short_sweep_at_zero_pressure_is_fitted():
    made = sweeps([0.0, 1e5, 2e5, 3e5, 4e5], [0.01, 0.1, 0.15, 0.2, 0.2])
    unsigned = record(made.pressure, made.strain, made.force)
    assert select_fit_data(unsigned).left_out == {}
    assert {run.kind for run in runs(unsigned)} == {"pressure"}


def test_readings_between_levels_are_still_ramps():
    made = sweeps([1e5, 2e5], [0.2, 0.2])
    ramp = np.linspace(1e5, 2e5, 12)[1:-1]
    parts = [(made.pressure, ramp), (made.strain, 0 * ramp), (made.force, 0 * ramp)]
    joined = record(*(np.concatenate([of[:90], between, of[90:]]) for of, between in parts))
    assert select_fit_data(joined).left_out == {"on ramps between sweeps": 10}


def test_a_muscle_as_given_has_a_calibration_without_constants():
    record = sweeps([1e5, 2e5, 3e5, 4e5], [0.1, 0.1, 0.15, 0.2], points=12, noise=0.3)
    choice = select_model(record, MUSCLE)
    assert [one.constants for one in choice.candidates if one.chosen] == [0]
    assert choice.calibration.parameters == ()
    assert choice.calibration.muscle == MUSCLE


@pytest.mark.parametrize(
    ("value", "low", "high"),
    [(36.08, 36.076, 36.084), (36.08, 36.0799996, 36.0800004), (0.25, -0.05, 0.55),
     (1.004, 0.6, 1.0045), (9.996, 9.9958, 15.0), (36.08, 36.08, 36.08)],
)  # fmt: skip
def test_a_printed_interval_contains_its_value(value, low, high):
    estimate = Estimate("x", "number", "", value, low, high, value, 1.0, True)
    text, interval = interval_texts(estimate)
    ends = [float(end) for end in interval.split(" to ")]
    assert ends[0] <= float(text) <= ends[1]
    assert ends[0] < ends[1] or low == high


@pytest.fixture(scope="module")
def rubber():
    """A fit of the rubber to a muscle of thin rubber, which tells its limit alone."""
    soft = MUSCLE.replace(material=fs.MooneyRivlin(2e3, 2e3))
    record = sweeps([0.0, 1e5, 2e5, 4e5], [0.01, 0.1, 0.15, 0.2], noise=3.0, muscle=soft, seed=2)
    made = fit(record, MUSCLE, ("c10", "c01", "braid_angle"), whole=False)
    return made, with_profiles(made)


def test_the_better_of_two_intervals_is_printed_and_the_sentence_follows(rubber, found):
    quick, better = rubber
    for before, after in zip(quick.parameters, better.parameters, strict=True):
        assert after.low <= after.value <= after.high
        if not before.identifiable:
            assert after.high <= before.high
        if after.bound:
            limits = {e["name"]: e["bound"] for e in found(better)["constants.limited"]["limits"]}
            assert limits[after.name] == after.bound
            verdict = judge(better)
            assert after.name in verdict.limits and after.name not in verdict.undetermined
    assert any(one.bound == "upper" for one in better.parameters)


def test_the_half_way_error_is_measured_not_subtracted():
    record = sweeps([1e5, 2e5, 4e5], [0.1, 0.15, 0.2], noise=0.5, loop=5.0)
    made = fit(record, MUSCLE, ("c10", "c01"), whole=False)
    # the loop is symmetric about the law: half of it is in the error, none in the mean of both
    assert made.rmse == pytest.approx(5.0, rel=0.1)
    assert made.half_way_rmse == pytest.approx(0.5 / math.sqrt(2), rel=0.3)


@pytest.mark.parametrize(
    ("noise", "loop", "bow", "expected"),
    [(0.5, 0.0, 0.0, "noise"), (0.5, 3.0, 0.0, "well"), (0.5, 0.0, 30.0, "roughly"),
     (0.5, 0.0, 90.0, "poorly")],
)  # fmt: skip
def test_the_verdict_follows_from_the_size_of_the_error_and_its_pattern(noise, loop, bow, expected):
    data = sweeps([1e5, 2e5, 4e5], [0.1, 0.15, 0.2], noise=noise, loop=loop)
    data = replace(data, force=data.force + bow * np.sin(60 * data.strain))
    fitted = fit(data, MUSCLE, ("c10", "c01"), whole=False)
    verdict = judge(fitted)
    assert verdict.fit == expected
    assert math.isnan(verdict.resisting_rmse) and math.isnan(verdict.left_out_rmse)
    assert verdict.pulling_rmse == pytest.approx(verdict.rmse)


@pytest.mark.parametrize(("noise", "expected"), [(0.03, "roughly"), (0.15, "poorly")])
def test_large_errors_without_a_pattern_are_no_good_fit(noise, expected, found):
    clean = sweeps([1e5, 2e5, 4e5], [0.1, 0.15, 0.2])
    data = sweeps([1e5, 2e5, 4e5], [0.1, 0.15, 0.2], noise=noise * float(np.max(clean.force)))
    fitted = fit(data, MUSCLE, ("c10", "c01"), whole=False)
    verdict = judge(fitted)
    assert fitted.diagnosis.is_white_noise
    assert verdict.fit == expected
    assert found(fitted)["fit.noisy"] == {"relative_rmse": verdict.relative_rmse}


@pytest.mark.parametrize(("noise", "expected"), [(0.5, "other sizes"), (40.0, "roughly")])
def test_sizes_that_are_not_the_muscles_are_named(noise, expected, found):
    built = MUSCLE.replace(outer_radius=13e-3)
    data = sweeps([1e5, 2e5, 4e5], [0.1, 0.15, 0.2], noise=noise, muscle=built)
    fitted = fit(data, MUSCLE, ("outer_radius",), whole=False)
    assert (0.02 < fitted.relative_rmse < 0.05) == (noise > 1)
    assert judge(fitted).fit == expected
    size = found(fitted)["use.other_size"]
    assert (size["constant"], size["nominal"]) == ("outer_radius", MUSCLE.outer_radius)


@pytest.mark.parametrize(("ratio", "expected"), [(1.0, False), (1.5, True)])
def test_a_record_whose_strains_refer_to_another_length(ratio, expected, found):
    data = sweeps([1e5, 2e5, 4e5], [0.1, 0.15, 0.2], noise=0.5)
    length = ratio * float(MUSCLE.length)
    data = replace(data, strain=data.strain / ratio, rest_length=length)
    fitted = fit(data, MUSCLE, ("c10", "c01"), whole=False)
    assert fitted.relative_rmse < 0.02
    assert found(fitted).get("use.other_length", {}).get("reference") == (
        length if expected else None
    )


def test_a_few_readings_at_one_pressure_are_no_verdict(found):
    data = sweeps([1.08e5], [0.05], points=3, noise=0.1)
    fitted = fit(data, MUSCLE, ("braid_angle", "outer_radius", "dead_band"), whole=False)
    verdict = judge(fitted)
    assert verdict.fit == "untested"
    assert found(fitted)["coverage.one_pressure"]["pressure"] == pytest.approx(1.08e5)


def test_causes_that_the_data_can_not_distinguish_are_all_named():
    # synthetic: an ideal muscle with a dead band, and rubber that pushes in proportion to strain
    ideal = fs.Muscle(0.2, 8e-3, 1e-3, math.radians(25), "latex", tension="ideal")
    P, strain = np.repeat([1e5, 2e5, 3e5, 4e5], 60), np.tile(np.linspace(0, 0.24, 60), 4)
    noise = np.random.default_rng(7).normal(0, 1, P.size)
    force = np.asarray(ideal.force(P - 15e3, strain)) - 120 * strain + noise
    model = ideal.replace(tension="klute_hannaford")
    fitted = fit(record(P, strain, force), model, ("c10", "c01", "dead_band"), whole=False)
    assert {"load_cell_zero", "rubber"} <= {cause.code for cause in fitted.diagnosis.causes}


def test_one_cycle_of_friction_is_not_taken_for_a_drift_alone():
    # synthetic: isometric, the pressure rises and falls once; a loose ruler hides the branches
    rng = np.random.default_rng(1)
    P = np.append(np.linspace(0, 4e5, 41), np.linspace(4e5, 0, 41)[1:])
    strain, friction = rng.normal(0, 3e-3, P.size), np.where(np.arange(P.size) < 41, -3.0, 3.0)
    force = np.asarray(MUSCLE.force(P, strain)) + friction * (P > 0) + rng.normal(size=P.size)
    fitted = fit(record(P, strain, force), MUSCLE, ("outer_radius",), whole=False)
    assert not np.any(fitted.fit_data.branch)
    assert fitted.diagnosis.causes[0].code == "drift_or_friction"


def test_a_limit_beyond_the_prior_is_unknown():
    data = sweeps([1e5, 2e5, 4e5], [0.1, 0.15, 0.2], noise=0.5)
    fitted = fit(data, MUSCLE, ("c10", "youngs_modulus_factor"), whole=False)
    value, rise = np.array([1.0, 2.0]), np.array([0.0, 3.0])
    for high, bound in ((5e10, ""), (40.0, "upper")):
        profile = Profile("youngs_modulus_factor", value, rise, -np.inf, high)
        factor = replace(fitted, profiles=(profile,)).parameters[0]
        assert factor.name == "youngs_modulus_factor"
        assert factor.bound == bound
        assert factor.high < 1e3


def test_many_readings_of_one_least_number_are_clipped_there():
    made = sweeps([0.0, 5e4, 1e5, 2e5], [0.05, 0.3, 0.35, 0.4], noise=0.3)
    floor = float(np.quantile(made.force, 0.2))
    assert floor < 0
    data = record(made.pressure, made.strain, np.maximum(made.force, floor), made.branch)
    of = select_fit_data(data)
    assert of.clipped == np.sum(made.force <= floor) > 20
    fitted = fit(data, MUSCLE, ("c10", "c01", "youngs_modulus_factor"))
    # a clipped reading asks the law to be no higher: it is no force of exactly -8.74 N
    assert fitted.rmse == pytest.approx(0.3, rel=0.15)


def test_a_coarse_load_cell_has_no_floor():
    made = sweeps([0.0, 5e4, 1e5, 2e5], [0.05, 0.3, 0.35, 0.4], noise=0.3)
    coarse = record(made.pressure, made.strain, np.round(made.force), made.branch)
    assert select_fit_data(coarse).clipped == 0


@pytest.mark.parametrize(
    ("truth", "model"),
    [("elastica", "kim2021"), pytest.param("kim2021", "elastica", marks=pytest.mark.slow)],
)
def test_another_law_past_the_free_strain_is_no_error_of_a_gauge(truth, model):
    slender = fs.example("kim2021_figure_6")
    gauge = fs.records.VirtualDynamometer(noise=0.003, samples=20)
    data = gauge.record(slender.replace(buckling=truth), seed=1)
    free = ("youngs_modulus_factor", "collapse_moment_factor")
    made = fit(data, slender.replace(buckling=model), free)
    assert [cause.code for cause in made.diagnosis.causes] == ["resisting_law"]
    # the factors belong to a law that the data contradict
    assert made.doubtful == free == judge(made).undetermined
    right = fit(data, slender.replace(buckling=truth), free)
    assert not right.diagnosis.resisting_law_in_doubt
    assert all(estimate.identifiable for estimate in right.parameters)

"""Model selection on synthetic records of known muscles."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate import fit, select_model
from fascicle.calibrate.model_selection import Candidate, candidate_sets, select
from fascicle.core.module import with_fields
from fascicle.records.record import Record


TRUE = fs.Muscle(0.2, 11e-3, 2e-3, np.radians(27), fs.MooneyRivlin(4e5, 2e5))
NOMINAL = fs.Muscle(0.2, 10e-3, 2e-3, np.radians(29), fs.MooneyRivlin(5e5, 3e5))
SLACK = with_fields(TRUE, tuning=with_fields(TRUE.tuning, dead_band=5e4))
FOUR = ["c10", "c01", "braid_angle", "outer_radius"]
P, STRAIN = np.linspace(2.5e5, 6e5, 7)[:, None], np.linspace(0.0, 0.08, 8)


def record(muscle=TRUE, sigma=2.0, error=0.0, seed=0, strain=STRAIN):
    force = np.asarray(muscle.force(P, strain)) + error
    noise = sigma * np.random.default_rng(seed).normal(size=force.shape)
    return Record.of(P, strain, force + noise, rest_length=0.2)


def looped(half, sigma, strain=STRAIN):
    """A record of both branches, `half` [N] of the loop's width to either side."""
    up = record(error=-half, sigma=sigma, strain=strain)
    down = record(error=half, sigma=sigma, strain=strain[::-1], seed=1)
    columns = [np.concatenate([getattr(r, name) for r in (up, down)])
               for name in ("pressure", "strain", "force")]  # fmt: skip
    return Record.of(*columns, branch=np.repeat([1, -1], len(up)), rest_length=0.2)


def estimate(selection, name):
    return next(e for e in selection.calibration.parameters if e.name == name)


@pytest.fixture(scope="module")
def selection():
    return select_model(record(), NOMINAL)


def test_constants_that_differ_are_selected(selection):
    assert set(selection.calibration.names) == set(FOUR)
    assert_allclose(estimate(selection, "outer_radius").value, 11e-3, rtol=0.05)
    # the error is the noise, 2 N, also at pressures that were left out
    (chosen,) = (candidate for candidate in selection.candidates if candidate.chosen)
    assert 1.5 < chosen.rmse < 2.2 and 1.5 < chosen.left_out_rmse < 2.6
    fitted = fit(record(), NOMINAL, selection.calibration.names, whole=False)
    assert_allclose(selection.calibration.rmse, fitted.rmse, rtol=1e-4)


@pytest.mark.slow
def test_a_dead_band_is_found():
    selection = select_model(record(SLACK), NOMINAL)
    band = estimate(selection, "dead_band")
    assert band.low < 5e4 < band.high


def test_a_missing_dead_band_is_the_likely_cause():
    fitted = fit(record(SLACK, sigma=1.0), NOMINAL, FOUR, whole=False)
    diagnosis = fitted.diagnosis
    assert not diagnosis.is_white_noise
    assert diagnosis.causes[0].constant == "dead_band"


@pytest.mark.slow
def test_a_passive_part_of_the_length_is_found():
    # synthetic: 30 mm of the 200 mm lie in the fittings
    force = np.asarray(TRUE.replace(length=0.17).force(P, STRAIN * 0.2 / 0.17))
    noise = np.random.default_rng(2).normal(size=force.shape)
    data = Record.of(P, STRAIN, force + noise, force < 0, rest_length=0.2)
    selection = select_model(data, NOMINAL)
    length = estimate(selection, "active_length")
    assert length.low < 0.17 < length.high


@pytest.mark.slow
def test_an_active_length_above_the_length_is_excluded(found):
    # synthetic: a muscle of 200 mm that is declared as 160 mm long
    data = record(sigma=1.0)
    data = Record.of(data.pressure, data.strain * 0.2 / 0.16, data.force, rest_length=0.16)
    selection = select_model(data, NOMINAL.replace(length=0.16))
    assert "active_length" not in selection.calibration.names
    # fitted by name it is reported
    fitted = fit(data, NOMINAL.replace(length=0.16), [*FOUR, "active_length"], whole=False)
    assert found(fitted)["use.other_size"]["constant"] == "active_length"


@pytest.fixture
def compliant():
    """A record of a muscle with compliant ends, and their compliance [m/N]."""
    # synthetic: (E8) solved by bisection, not by the library; in m/N, of both ends
    compliance, length = 2e-5, 0.2
    low, high = STRAIN + 0 * P, STRAIN + 0 * P + 0.2
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = middle < STRAIN + compliance * np.asarray(TRUE.force(P, middle)) / length
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    force = np.asarray(TRUE.force(P, low))
    force = force + np.random.default_rng(3).normal(size=force.shape)
    return Record.of(P, STRAIN, force, force < 0, rest_length=0.2), compliance


def test_compliant_ends_are_the_likely_cause(compliant):
    rigid = fit(compliant[0], NOMINAL, FOUR, whole=False)
    assert rigid.diagnosis.causes[0].code == "compliance"


@pytest.mark.slow
def test_compliant_ends_are_found(compliant):
    data, compliance = compliant
    selection = select_model(data, NOMINAL)
    assert set(selection.calibration.names) == {*FOUR, "end_compliance"}
    ends = estimate(selection, "end_compliance")
    assert ends.low < compliance < ends.high
    assert selection.calibration.muscle.ends.name == "compliant"
    assert selection.calibration.diagnosis.is_white_noise


@pytest.mark.slow
def test_friction_is_the_cause_and_frees_no_constant():
    data = looped(0.04 * np.asarray(TRUE.force(P, 0.0)), sigma=0.5)
    selection = select_model(data, NOMINAL)
    assert not {"dead_band", "active_length"} & set(selection.calibration.names)
    assert selection.calibration.diagnosis.causes[0].code == "friction"


def test_half_of_a_loop_is_in_the_error():
    half = 0.03 * np.asarray(TRUE.force(P, 0.0))
    data = looped(half, sigma=2.0, strain=np.linspace(0.0, 0.08, 200))
    fitted = select_model(data, NOMINAL).calibration
    counts = fitted.fit_data.counts()
    assert counts["read"] == fitted.points == len(data)
    assert fitted.fit_data.pulls and counts["averaged"] > counts["means"] > 0
    assert_allclose(fitted.loop.share, 0.06, rtol=0.05)
    assert_allclose(fitted.loop.half, np.sqrt(np.mean(half**2)), rtol=0.02)
    # averaging in steps of strain does not hide it
    assert fitted.rmse > 0.98 * fitted.loop.half
    assert any(trend.along == "branch" for trend in fitted.diagnosis.significant)


def trial(constants, errors, rmse=1.0):
    size = float(np.sqrt(np.mean(errors**2)))
    return Candidate(("",), "constants", constants, rmse, size, 0.1, size, left_out_errors=errors)


@pytest.mark.parametrize(("rmse", "constants"), [(1.03, 2), (1.5, 5)])
def test_a_better_prediction_needs_a_better_fit(rmse, constants):
    # of 66 readings, those of the last pressure are predicted better with more constants
    errors = np.random.default_rng(0).normal(size=66)
    worse = np.where(np.arange(66) < 60, errors, 2.5 * np.sign(errors))
    best = select([trial(2, worse, rmse), trial(5, errors)], 0.0, "linear")
    # Fisher's 95 % of 3 and 61 degrees of freedom is 2.76: up to 1.066 times the error
    assert best.constants == constants


def test_a_record_too_short_for_cross_validation_or_without_a_possible_fit_is_refused():
    rules = set()
    for refused in (trial(2, np.array([np.nan])), replace(trial(2, np.ones(9)), violation="bound")):
        with pytest.raises(fs.InvalidInputError) as error:
            select([refused], 0.0, "linear")
        assert error.value.argument == "record"
        rules.add(error.value.rule)
    assert len(rules) == 2


def test_candidates_without_some_predictions_are_not_compared():
    # two pressures of three strains: without a stretch of strain no tuning can be read
    pressure, strain = np.array([[1e5], [2e5]]), np.array([0.0, 0.1, 0.2])
    data = Record.of(pressure, strain, [[200.0, 100.0, 0.0], [400.0, 220.0, 60.0]])
    muscle = fs.Muscle(0.3, 12e-3, 2e-3, np.radians(25))
    candidates = select_model(data, muscle).candidates
    (tuning,) = (candidate for candidate in candidates if candidate.method == "tuning")
    assert np.isfinite(tuning.rmse) and np.isnan(tuning.left_out_rmse) and not tuning.chosen


def test_at_one_pressure_strains_are_left_out(found):
    strain = np.linspace(0.0, 0.12, 18)
    noise = 8.0 * np.random.default_rng(2).normal(size=strain.size)
    data = Record.of(6e5, strain, np.asarray(TRUE.force(6e5, strain)) + noise, rest_length=0.2)
    selection = select_model(data, NOMINAL)
    assert found(selection.calibration)["coverage.one_pressure"] == {"pressure": 6e5}


def test_a_rubber_that_was_not_given_is_always_free():
    free = [names for names in candidate_sets(fs.example("kim2021_figure_6")) if names]
    assert free and all({"c10", "c01"} <= set(names) for names in free)
    given = candidate_sets(fs.example("kim2021_figure_6"), rubber_given=True)
    assert len(given) == len(free) + 3  # the sizes, with a dead band, and nothing

"""What is found without being told what to fit: synthetic records of known muscles."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate import fit, select_model
from fascicle.calibrate.calibration import Candidate, Trial
from fascicle.calibrate.messages import fit_data_lines, selection_reasons
from fascicle.calibrate.model_selection import select, stepwise_selection
from fascicle.core.module import with_fields
from fascicle.records.record import Record


TRUE = fs.Muscle.from_dimensions(0.2, 11e-3, 2e-3, np.radians(27), fs.MooneyRivlin(4e5, 2e5))
NOMINAL = fs.Muscle.from_dimensions(0.2, 10e-3, 2e-3, np.radians(29), fs.MooneyRivlin(5e5, 3e5))
P, STRAIN = np.linspace(2.5e5, 6e5, 7)[:, None], np.linspace(0.0, 0.08, 8)


def record(muscle=TRUE, sigma=2.0, error=0.0, seed=0, strain=STRAIN):
    force = np.asarray(muscle.force(P, strain)) + error
    noise = sigma * np.random.default_rng(seed).normal(size=force.shape)
    return Record.of(P, strain, force + noise, rest_length=0.2)


@pytest.fixture(scope="module")
def choice():
    return select_model(record(), NOMINAL)


def test_the_constants_that_differ_are_found(choice):
    assert set(choice.calibration.names) == {"c10", "c01", "braid_angle", "outer_radius"}
    found = {one.name: one.value for one in choice.calibration.parameters}
    assert_allclose(found["outer_radius"], 11e-3, rtol=0.05)
    # as good as the noise, 2 N, at pressures that were left out too
    taken = next(one for one in choice.candidates if one.chosen)
    assert 1.5 < taken.rmse < 2.2 and 1.5 < taken.left_out_rmse < 2.6


def test_all_that_was_tried_is_told(choice):
    labels = [one.label for one in choice.candidates]
    assert labels[:2] == ["the muscle as given", "the paper's tuning"]
    assert sum(one.chosen for one in choice.candidates) == 1
    assert any("dead_band" in one.names for one in choice.candidates)
    assert choice.reasons[0].startswith("Selected: c10, c01, braid_angle, outer_radius (4 numbers)")
    assert any(line.startswith("Adding a dead band does not pay") for line in choice.reasons)
    assert any(line.startswith("The paper's tuning") for line in choice.reasons)


def test_what_is_found_is_what_a_fit_of_it_finds(choice):
    alone = fit(record(), NOMINAL, choice.calibration.names, whole=False)
    assert_allclose(choice.calibration.rmse, alone.rmse, rtol=1e-4)


@pytest.mark.slow
def test_a_dead_band_is_found_where_there_is_one():
    found = select_model(record(slack()), NOMINAL)
    assert "dead_band" in found.calibration.names
    band = next(one for one in found.calibration.parameters if one.name == "dead_band")
    assert band.low < 5e4 < band.high
    assert any(line.startswith("Adding a dead band reduces") for line in found.reasons)


def slack(band=5e4):
    """A synthetic muscle with a dead band."""
    return with_fields(TRUE, tuning=with_fields(TRUE.tuning, dead_band=band))


FOUR = ["c10", "c01", "braid_angle", "outer_radius"]


def test_constants_without_a_dead_band_say_that_it_is_one():
    made = fit(record(slack(), sigma=1.0), NOMINAL, FOUR, whole=False)
    assert not made.diagnosis.is_white_noise
    assert "dead band" in made.diagnosis.causes[0].name
    told = "\n".join(made.warnings)
    assert "What to do: free dead_band." in told
    # what is told of the residuals at rest is what they are
    pressure, missed = np.array(made.diagnosis.least_strain).T
    assert_allclose(pressure, P[:, 0], rtol=1e-12)
    assert_allclose(missed, (made.grid.force - made.force)[: P.size, 0], rtol=1e-9)
    low, high = sorted((np.argmin(missed), np.argmax(missed)))
    said = f"from {missed[low]:+.3g} N at {P[low, 0] / 1e3:.4g} kPa to {missed[high]:+.3g} N"
    assert np.ptp(missed) > 4 and said in told


@pytest.mark.slow
def test_a_length_that_does_not_work_is_found():
    # synthetic: 30 mm of the 200 mm lie in the fittings
    working = TRUE.replace(length=0.17)
    force = np.asarray(working.force(P, STRAIN * 0.2 / 0.17))
    noise = np.random.default_rng(2).normal(size=force.shape)
    found = select_model(Record.of(P, STRAIN, force + noise, force < 0, rest_length=0.2), NOMINAL)
    assert "active_length" in found.calibration.names
    length = next(one for one in found.calibration.parameters if one.name == "active_length")
    assert length.low < 0.17 < length.high
    assert any(line.startswith("Adding another active length reduces") for line in found.reasons)


@pytest.mark.slow
def test_no_more_of_a_muscle_works_than_there_is():
    # synthetic: of a muscle of 200 mm, said to be 160 mm long: 200 mm would explain it
    made = record(strain=STRAIN, sigma=1.0)
    told = Record.of(made.pressure, made.strain * 0.2 / 0.16, made.force, rest_length=0.16)
    found = select_model(told, NOMINAL.replace(length=0.16))
    assert "active_length" not in found.calibration.names
    lines = [line for line in found.reasons if line.startswith("Excluded: ")]
    assert lines and all("in a muscle of 160 mm is impossible." in line for line in lines)
    # those err less, so that the best of the others is only called the best of what can be
    assert not any("candidates has a smaller" in line for line in found.reasons)
    # fitted by name, or with something known of it, it is said
    by_name = fit(told, NOMINAL.replace(length=0.16), [*FOUR, "active_length"], whole=False)
    assert any(line.startswith("active_length is ") for line in by_name.warnings)


def test_ends_that_give_are_found_and_named():
    # synthetic: (E8) solved by halving, not by the library; a meter per newton of both ends
    compliance, length = 2e-5, 0.2
    low, high = STRAIN + 0 * P, STRAIN + 0 * P + 0.2
    for _ in range(60):
        middle = 0.5 * (low + high)
        pulled = middle < STRAIN + compliance * np.asarray(TRUE.force(P, middle)) / length
        low, high = np.where(pulled, middle, low), np.where(pulled, high, middle)
    force = np.asarray(TRUE.force(P, low))
    force = force + np.random.default_rng(3).normal(size=force.shape)
    made = Record.of(P, STRAIN, force, force < 0, rest_length=0.2)
    # without them the cause is named
    rigid = fit(made, NOMINAL, FOUR, whole=False)
    assert rigid.diagnosis.causes[0].remedy == "free end_compliance"
    found = select_model(made, NOMINAL)
    assert set(found.calibration.names) == {*FOUR, "end_compliance"}
    ends = next(one for one in found.calibration.parameters if one.name == "end_compliance")
    assert ends.low < compliance < ends.high
    assert (
        found.calibration.muscle.ends.name == "compliant"
        and found.calibration.diagnosis.is_white_noise
    )
    assert any(line.startswith("Adding end compliance reduces") for line in found.reasons)


def test_ends_that_hold_stay_rigid(choice):
    assert choice.calibration.muscle.ends.name == "rigid"
    assert any("end_compliance" in one.names for one in choice.candidates)


@pytest.mark.slow
def test_friction_is_told_and_freed_by_no_constant():
    half = 0.04 * np.asarray(TRUE.force(P, 0.0))
    up, down = record(error=-half, sigma=0.5), record(error=half, sigma=0.5, seed=1)
    both = Record.of(
        np.concatenate([up.pressure, down.pressure]), np.concatenate([up.strain, down.strain]),
        np.concatenate([up.force, down.force]), branch=np.repeat([1, -1], len(up)), rest_length=0.2,
    )  # fmt: skip
    found = select_model(both, NOMINAL)
    assert not {"dead_band", "active_length"} & set(found.calibration.names)
    assert found.calibration.diagnosis.causes[0].name == "friction: a hysteresis loop"


def test_constants_are_taken_while_they_are_worth_it_and_given_back():
    # what is free costs its number, b and c together win what neither wins alone, a is a burden
    worth = {("b", "c"): -10.0}
    seen = []

    def cost(names):
        return len(names) + sum(x for pair, x in worth.items() if set(pair) <= set(names))

    def tried(names):
        if set(names) not in [set(one) for one in seen]:
            seen.append(names)

    tried(("base",))
    stepwise_selection(lambda: min(seen, key=cost), ["a", "b", "c"], (), tried)
    assert set(min(seen, key=cost)) == {"base", "b", "c"}
    # one that is always free is never taken away
    seen.clear()
    tried(("base", "a"))
    stepwise_selection(lambda: min(seen, key=cost), ["a", "b", "c"], ("a",), tried)
    assert all("a" in names for names in seen)


def test_a_trend_is_told_with_its_cause():
    bow = 12 * np.sin(2 * np.pi * STRAIN / 0.08)
    made = select_model(record(error=bow), NOMINAL).calibration
    assert made.diagnosis.significant[0].along == "strain"
    assert made.diagnosis.causes and np.max(made.wider) > 1.3
    told = "\n".join(made.warnings)
    assert "Residuals follow strain" in told and "Likely cause: " in told


def test_a_loop_is_part_of_the_error_that_is_claimed():
    strain = np.linspace(0.0, 0.08, 300)
    half = 0.03 * np.asarray(TRUE.force(P, 0.0))
    up, down = record(error=-half, strain=strain), record(error=half, strain=strain[::-1], seed=1)
    both = Record.of(
        np.concatenate([up.pressure, down.pressure]), np.concatenate([up.strain, down.strain]),
        np.concatenate([up.force, down.force]), branch=np.repeat([1, -1], len(up)), rest_length=0.2,
    )  # fmt: skip
    made = select_model(both, NOMINAL).calibration
    counts = made.fit_data.counts()
    assert counts["read"] == made.points == 2 * len(up)
    assert made.fit_data.pulls and counts["averaged"] > counts["means"] > 0
    assert f"{2 * len(up)} readings read, none left out" in fit_data_lines(made.fit_data)[0]
    assert_allclose(made.loop.share, 0.06, rtol=0.05)
    assert_allclose(made.loop.half, np.sqrt(np.mean(half**2)), rtol=0.02)
    # averages did not make it vanish
    assert made.rmse > 0.98 * made.loop.half
    assert any(one.along == "branch" for one in made.diagnosis.significant)


def trial(label, constants, unseen):
    left = float(np.sqrt(np.mean(unseen**2)))
    return Trial(Candidate(label, (label,), "constants", constants, 1.0, left, 0.1, left), unseen)


def test_what_the_data_dont_ask_for_is_not_taken():
    errors = np.random.default_rng(0).normal(size=200)
    few, more = trial("few", 2, errors), trial("more", 5, 0.995 * errors)
    assert select([few, more], 0.0, "linear") is few
    assert "no larger than chance or 2 %" in selection_reasons([few, more], few)[1]
    assert select([few, trial("more", 5, 0.7 * errors)], 0.0, "linear") is not few


def test_a_constant_must_be_worth_more_than_a_reading_s_share():
    errors = np.random.default_rng(0).normal(size=30)
    # as a constant at its bound: the same errors but for what its search left, all one way
    few, more = trial("few", 5, errors), trial("more", 6, (1 - 1e-4) * errors)
    assert select([few, more], 10.0, "linear") is few  # noise that takes all of the 2 %


def test_what_has_no_answer_for_some_readings_is_not_compared():
    # two pressures of three strains: without a stretch of strain no tuning can be read
    pressure, strain = np.array([[1e5], [2e5]]), np.array([0.0, 0.1, 0.2])
    record = Record.of(pressure, strain, [[200.0, 100.0, 0.0], [400.0, 220.0, 60.0]])
    muscle = fs.Muscle.from_dimensions(0.3, 12e-3, 2e-3, np.radians(25))
    found = select_model(record, muscle)
    tuning = next(one for one in found.candidates if one.method == "tuning")
    assert np.isfinite(tuning.rmse) and np.isnan(tuning.left_out_rmse)
    assert any(one.chosen and one.method == "constants" for one in found.candidates)


def test_one_pressure_is_judged_by_strains_and_says_so():
    strain = np.linspace(0.0, 0.12, 18)
    noise = 8.0 * np.random.default_rng(2).normal(size=strain.size)
    one = Record.of(6e5, strain, np.asarray(TRUE.force(6e5, strain)) + noise, rest_length=0.2)
    found = select_model(one, NOMINAL)
    assert "stretch-of-strain" in found.reasons[-1]
    warned = " ".join(found.calibration.warnings)
    assert "Data at one pressure only (600 kPa)" in warned
    assert "could not be read" not in warned


@pytest.mark.slow
def test_few_readings_that_push_are_not_what_resists():
    strain = np.linspace(0.0, 0.08, 12)
    P = np.linspace(3e5, 6e5, 5)[:, None]
    force = np.array(TRUE.force(P, strain))
    force[0, -1] = -3.0  # a gauge's noise, once, where the muscle hardly pulls
    found = select_model(Record.of(P, strain, force, rest_length=0.2), NOMINAL)
    assert found.calibration.fit_data.pulls and found.calibration.fit_data.pushes == 1
    assert {one.readings for one in found.candidates} == {"pulling"}
    assert any(
        "too few to fit what resists" in line for line in fit_data_lines(found.calibration.fit_data)
    )


def test_a_record_too_short_to_leave_out_says_so():
    with pytest.raises(ValueError, match="too short to leave readings out"):
        select([trial("none", 2, np.array([np.nan]))], 0.0, "linear")

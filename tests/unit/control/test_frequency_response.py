"""Sines in one batch are the runs that they'd be one by one, with oil; power units by hand."""

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import control, dynamics
from fascicle.core.errors import InvalidInputError
from fascicle.dynamics.step_size import estimate_substeps


SUPPLY = 413.7e3


@pytest.fixture(scope="module")
def scenario():
    return fs.example("sine_1_4")


A, F, MEAN, TIME = [2e-3, 9e-3], [2.0, 4.0], 12.7e-3, 0.5


@pytest.fixture(scope="module")
def result(scenario):
    controlled = scenario.control.controller
    return control.frequency_response(scenario.plant, controlled, MEAN, A, F, scenario.start, TIME)


# a sample: tests/unit/dynamics/test_batches.py holds a batch to its runs
@pytest.mark.slow
def test_a_batch_equals_single_runs(scenario, result):
    # the last of them by itself, its reference made anew: one second in which it grows
    now = 1e-3 * np.arange(1500)
    grown = np.where(now < 1, 3 * now**2 - 2 * now**3, 1.0)
    wanted = MEAN + A[1] * grown * np.sin(2 * np.pi * F[1] * (now - 1))
    # by itself a liquid takes more substeps: here as many as in the batch
    plant, few = scenario.plant, estimate_substeps(scenario.plant, 1e-3).substeps
    controller = scenario.control.controller
    one = dynamics.simulate(plant, controller, wanted, start=scenario.start, substeps=few)
    late = np.asarray(one.outputs.position)[1001:] - wanted[1000:]
    # sums in another order, run on for 1500 steps
    error = np.sqrt(np.mean(late**2)) / (A[1] / np.sqrt(2))
    assert_allclose(result.error[1, 1], error, rtol=1e-6)
    drawn = np.maximum(one.outputs.drawn, 0).sum(-1)[1000:1500]
    assert_allclose(result.supply_flow[1, 1], drawn, rtol=0, atol=1e-6 * drawn.max())
    pull = np.asarray(one.outputs.forces).sum(-1)  # plates move as the load does
    power = np.maximum(pull * one.outputs.velocity, 0)[1000:1500]
    assert_allclose(result.work[1, 1], power.sum() * 1e-3 / 2, rtol=1e-6)


def test_larger_amplitudes_draw_more_and_compile_nothing(scenario, result, caplog):
    assert result.error.shape == (2, 2) and result.is_valid.all()
    assert np.all(result.reachable_share[0] == 1)
    # oil of one muscle suffices for the small one, five are filled for the large one
    assert result.supply_flow[1, 0].sum() > 3 * result.supply_flow[0, 0].sum()
    plant, controller = scenario.plant, scenario.control.controller
    with jax.log_compiles(), caplog.at_level("WARNING"):
        other = control.frequency_response(
            plant, controller, MEAN, [1e-3, 5e-3], F, scenario.start, TIME
        )
    assert not [record for record in caplog.records if "ompil" in record.getMessage()]
    assert np.all(other.supply_flow.sum(-1) < result.supply_flow.sum(-1))


def test_power_units_equal_a_hand_calculation():
    # of 2 Hz, 1 s: two periods that draw 850 g/s for a tenth of a second each, 0.1 L a period
    drawn = np.zeros((1, 1, 1000))
    drawn[..., :100] = drawn[..., 500:600] = 0.85
    top = np.where(drawn > 0, 100e3, 0.0)
    one = np.ones((1, 1))
    result = control.FrequencyResponse(
        np.array([5e-3]), np.array([2.0]), 0 * one, one, one, drawn, top, 1e-3, 1.0, one
    )
    work = control.shaft_work(result, 400e3, 850.0, 0.5, band=100e3, margin=50e3)
    assert_allclose(work["relief"], 400e3 * 1e-3 / 0.5 / 2)
    assert_allclose(work["accumulator"], 450e3 * 1e-4 / 0.5)
    assert_allclose(work["sensing"], 150e3 * 1e-4 / 0.5)
    assert tuple(work) == control.POWER_UNITS
    # never more than the supply's
    near = control.shaft_work(
        result._replace(highest_pressure=top + 290e3 * (top > 0)), 400e3, 850.0, 0.5
    )
    assert_allclose(near["sensing"], 400e3 * 1e-4 / 0.5)


@pytest.mark.parametrize(
    ("edits", "argument"),
    [
        ({"frequencies": [0.7]}, "frequencies"),
        ({"frequencies": [-2.0]}, "frequencies"),
        ({"amplitudes": [0.0]}, "amplitudes"),
        ({"time": 0.0}, "time"),
    ],
)
def test_invalid_input_is_refused(scenario, edits, argument):
    plant, controller = scenario.plant, scenario.control.controller
    given = {"amplitudes": [1e-3], "frequencies": [2.0], "time": 0.5} | edits
    with pytest.raises(InvalidInputError) as error:
        control.frequency_response(plant, controller, 12.7e-3, start=scenario.start, **given)
    assert error.value.argument == argument


def test_a_controller_of_force_is_refused(scenario):
    force = control.cascade(scenario.plant, "orderly", "force")
    with pytest.raises(ValueError, match="must be one of position"):
        control.frequency_response(
            scenario.plant, force, 12.7e-3, [1e-3], [2.0], scenario.start, 0.5
        )
    result = control.FrequencyResponse(*np.ones(7), *np.ones(3))
    with pytest.raises(ValueError, match=r"`efficiency` must lie in \(0, 1\]"):
        control.shaft_work(result, SUPPLY, 850.0, 1.2)

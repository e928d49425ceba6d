"""Delay and lag from step responses, and margins against a frequency sweep."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import control, dynamics, fluid
from fascicle.core.errors import InvalidInputError


DT = 1e-3


def response(delay, lag, fill, noise=0.0):
    """A synthetic step at 0.1 s, integrated in small steps: no closed form."""
    fine, time = 1e-5, np.arange(0, 1.0, DT)
    spool = pressure = 0.0
    rows = []
    for k in range(round(1.0 / fine)):
        command = 1.0 if k * fine >= 0.1 + delay else 0.0
        rows.append(pressure)
        spool += fine * (command - spool) / lag
        pressure += fine * (300e3 * spool - pressure) / fill
    measured = 50e3 + np.array(rows)[:: round(DT / fine)]
    measured += noise * np.random.default_rng(0).standard_normal(len(time))
    return time, np.where(time >= 0.1 - 1e-9, 1.0, 0.0), measured


@pytest.mark.parametrize(("delay", "lag"), [(0.02, 0.005), (0.004, 0.02)])
def test_delay_and_lag_of_a_synthetic_response_are_found(delay, lag):
    found = control.identify(*response(delay, lag, 0.2))
    # a sample is 1 ms
    assert_allclose([found.delay, found.lag], [delay, lag], atol=1e-3)
    assert_allclose(found.fill_time, 0.2, rtol=0.01)
    noisy = control.identify(*response(delay, lag, 0.2, 2e3))
    assert abs(noisy.lateness - delay - lag) < 3e-3 and 1.5e3 < noisy.error < 2.5e3


def test_a_plants_valve_is_identified(pair):
    plant = dynamics.Plant(
        pair, dynamics.PrescribedMotion(0.05 * 0.127), fluid.ConstantSupply(413.7e3),
        fluid.Isothermal(), fluid.SonicValve(1e-9, 0.3), spool=fluid.Servovalve(20e-3),
    )  # fmt: skip
    commands = np.zeros((400, 2))
    commands[50:, 0] = 0.2
    start = dynamics.equilibrium_state(plant, [150e3, 0.0])
    run = dynamics.simulate(plant, commands, dt=DT, start=start)
    pressure = np.asarray(run.outputs.pressures)[:-1, 0]
    late = np.concatenate([np.full(10, pressure[0]), pressure[:-10]])  # measured 10 ms late
    found = control.identify(DT * np.arange(400), commands[:, 0], late)
    # the flow falls as the chamber fills, which (K7) knows roughly: a quarter too late at most
    assert 30e-3 - 1e-3 < found.lateness < 1.25 * 30e-3


def test_margins_are_those_of_a_frequency_sweep(pair):
    tau, lag, delay = 0.05, 0.02, 0.01
    w = np.geomspace(1e-1, 1e3, 400_001)
    loop = np.exp(-1j * w * delay) / (1j * tau * w * (1 + 1j * lag * w))
    phase = np.unwrap(np.angle(loop))
    margins = control.loop_margins(tau, lag, delay)
    one, turn = np.argmin(np.abs(np.abs(loop) - 1)), np.argmin(np.abs(phase + np.pi))
    assert_allclose(margins.phase, np.pi + phase[one], rtol=1e-3)
    assert_allclose(margins.gain, 1 / np.abs(loop[turn]), rtol=1e-3)
    # (K3a): 61° where a delay alone is late, no gain margin's end without one
    assert_allclose(np.degrees(control.loop_margins(2.0, 0.0, 1.0).phase), 61.35, atol=0.01)
    assert control.loop_margins(1.0, 0.5, 0.0).gain == np.inf


def test_records_without_one_step_are_refused():
    time = DT * np.arange(50)
    with pytest.raises(ValueError, match="one step"):
        control.identify(time, np.zeros(50), np.zeros(50))
    with pytest.raises(ValueError, match="samples after the step"):
        control.identify(time, np.where(np.arange(50) > 45, 1.0, 0.0), np.zeros(50))
    with pytest.raises(ValueError, match="pressure"):
        control.identify(time, np.where(np.arange(50) > 4, 1.0, 0.0), np.zeros(49))


@pytest.mark.parametrize("noise", [0.0, 2e3])
def test_a_pressure_that_does_not_follow_the_step_is_refused(noise):
    time = DT * np.arange(500)
    pressure = 1e5 + noise * np.random.default_rng(2).standard_normal(500)
    with pytest.raises(InvalidInputError) as error:
        control.identify(time, np.where(time >= 0.1, 1.0, 0.0), pressure)
    assert error.value.argument == "pressure"

"""Delay and lag from step responses, and margins against a frequency sweep."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import control, dynamics, fluid
from fascicle.core.errors import InvalidInputError
from fascicle.core.module import with_fields


DT, SUPPLY = 1e-3, 413.7e3


def response(muscle, strain, begin, command, delay, lag, conductance):
    """A step at 0.1 s of an isothermal chamber with 1 mL of hose, by Euler's method: no plant."""
    room, RT, fine = 101_325.0, 287.0528 * 293.15, 1e-5
    grid = np.linspace(0.0, SUPPLY, 2001)
    contents = (grid + room) * (muscle.conjugate_volume(grid, strain) + 1e-6) / RT
    mass, spool, rows = np.interp(begin, grid, contents), 0.0, []
    for k in range(100_000):
        pressure = np.interp(mass, contents, grid)
        rows.append(pressure)
        high, low = (SUPPLY, pressure) if command > 0 else (pressure, 0.0)
        y = max(((low + room) / (high + room) - 0.3) / 0.7, 0.0)
        flow = conductance * 1.185 * (high + room) * np.sqrt(max(1 - y**2, 0.0))
        mass += fine * spool * flow
        spool += fine * ((command if k * fine >= 0.1 + delay else 0.0) - spool) / lag
    time = np.arange(0, 1.0, DT)
    return time, np.where(time >= 0.1 - 1e-9, command, 0.0), np.array(rows)[:: round(DT / fine)]


@pytest.mark.parametrize(
    ("begin", "command", "delay", "lag"),
    [(0.0, 0.7, 0.02, 0.005), (120e3, 1.0, 0.004, 0.02), (300e3, -0.5, 0.01, 0.01)],
)
def test_delay_and_lag_of_a_chamber_are_found(plant_of, pair, muscle, begin, command, delay, lag):
    # the plant's valve is twice as large, and its spool another
    plant = with_fields(plant_of(pair, 0.1), chamber=fluid.Isothermal(dead_volume=1e-6))
    time, commands, pressure = response(muscle, 0.1, begin, command, delay, lag, 5e-10)
    generator = np.random.default_rng(1)
    for noise in (0.0, 500.0):
        noisy = pressure + noise * generator.standard_normal(len(time))
        found = control.identify(time, commands, noisy, plant, 2)
        for value, error, true in (
            (found.delay, found.delay_error, delay),
            (found.lag, found.lag_error, lag),
        ):
            assert abs(value - true) < min(0.1 * (delay + lag), 3 * error)
    noisy = pressure + 2e4 * generator.standard_normal(len(time))
    with pytest.raises(InvalidInputError) as error:
        control.identify(time, commands, noisy, plant, 2)
    assert error.value.argument == "pressure"


@pytest.fixture(scope="module")
def step(plant_of, pair):
    """Steps of a plant's valve with a lag of 15 ms, measured late by 15 ms, whose gas warms and
    cools; its step is compiled once.
    """
    plant = plant_of(pair, 0.05, spool=fluid.Servovalve(15e-3))
    plant = with_fields(plant, chamber=fluid.AdiabaticWall(conductance=0.2))

    def record(pressure, command):
        commands = np.zeros((2050, 2))
        commands[50:, 0] = command
        start = dynamics.equilibrium_state(plant, [pressure, 0.0])
        run = dynamics.simulate(plant, commands, dt=DT, start=start, substeps=2)
        pressures = np.asarray(run.outputs.pressures)[:-1, 0]
        return plant, commands[:, 0], np.r_[np.full(15, pressures[0]), pressures[:-15]]

    return record


@pytest.mark.parametrize(
    ("begin", "command"), [(100e3, 1.0), (150e3, 0.3), (0.0, 1.0), (300e3, -1.0)]
)
def test_a_plants_valve_is_identified(step, begin, command):
    plant, commands, pressure = step(begin, command)
    generator = np.random.default_rng(1)
    for noise in (0.0, 500.0):
        noisy = pressure + noise * generator.standard_normal(len(pressure))
        for samples in (250, 2050):
            record = commands[:samples], noisy[:samples]
            found = control.identify(DT * np.arange(samples), *record, plant)
            assert max(abs(found.delay - 15e-3), abs(found.lag - 15e-3)) < 0.1 * 30e-3
            assert max(found.delay_error, found.lag_error) < 1.5e-3


@pytest.mark.parametrize("command", [0.1, 0.3, 0.6, 1.0, -0.3])
def test_a_valve_behind_a_hose_is_identified(plant_of, pair, command):
    plant = plant_of(pair, 0.1, spool=fluid.Servovalve(8e-3, dead_time=10e-3))
    line = fluid.Line(length=3.0, diameter=4e-3)
    valve = fluid.SonicValve(C=[2e-9, 6e-9], b=0.3, line=line)
    chamber = fluid.AdiabaticWall(conductance=0.2, dead_volume=4e-5)
    plant = with_fields(plant, chamber=chamber, valve=valve, exhaust_valve=valve)
    commands = np.zeros((600, 2))
    commands[100:, 0] = command
    start = dynamics.equilibrium_state(plant, [100e3 if command > 0 else 300e3, 0.0])
    run = dynamics.simulate(plant, commands, dt=DT, start=start, substeps=2)
    rows = commands[:, 0], np.asarray(run.outputs.pressures)[:-1, 0]
    found = control.identify(DT * np.arange(600), *rows, plant)
    assert_allclose([found.delay, found.lag], [10e-3, 8e-3], atol=0.5e-3)
    # at 100 Hz, errors can't be within a tenth of 18 ms
    with pytest.raises(InvalidInputError) as error:
        control.identify(DT * np.arange(0, 600, 10), *(row[::10] for row in rows), plant)
    assert error.value.argument == "pressure"


def test_margins_are_those_of_a_frequency_sweep(plant_of, pair):
    tau, lag, delay = 0.05, 0.02, 0.01
    w = np.geomspace(1e-1, 1e3, 400_001)
    loop = np.exp(-1j * w * delay) / (1j * tau * w * (1 + 1j * lag * w))
    phase = np.unwrap(np.angle(loop))
    margins = control.loop_margins(tau, lag, delay)
    one, turn = np.argmin(np.abs(np.abs(loop) - 1)), np.argmin(np.abs(phase + np.pi))
    assert_allclose(margins.phase, np.pi + phase[one], rtol=1e-3)
    assert_allclose(margins.gain, 1 / np.abs(loop[turn]), rtol=1e-3)
    # a controller's own loop has its margins
    plant, gains = plant_of(pair, spool=fluid.Servovalve(lag)), control.Gains(pressure_time=tau)
    controller = control.cascade(plant, "threshold", gains=gains, delay=0.009)
    assert_allclose(controller.loop_response(w / (2 * np.pi)), loop)
    # (K3a): 61° where a delay alone is late, no gain margin's end without one
    assert_allclose(np.degrees(control.loop_margins(2.0, 0.0, 1.0).phase), 61.35, atol=0.01)
    assert control.loop_margins(1.0, 0.5, 0.0).gain == np.inf


def test_pulses_delay_a_loop(plant_of, pair):
    # half a period, as in any loop that is sampled, and the time in which a pulse ends
    spool = fluid.Solenoid(20e-3, opening_delay=3e-3, closing_delay=2e-3, dead_time=10e-3)
    controller = control.cascade(plant_of(pair, spool=spool), "threshold", delay=10e-3)
    late = 10e-3 + DT + 10e-3 + 2e-3
    assert_allclose(controller.gains.pressure_time, 2 * late)
    assert_allclose(controller.margins, control.loop_margins(2 * late, 0.0, late))
    fast = control.Gains(pressure_time=22e-3)
    with pytest.warns(UserWarning, match="pressure_time"):
        fast = control.cascade(controller.plant, "threshold", gains=fast, delay=10e-3)
    assert [finding.code for finding in fast.findings] == ["control.pressure_time_short"]


def test_records_without_one_step_from_zero_are_refused(plant_of, pair):
    time, plant = DT * np.arange(50), plant_of(pair)
    on = 1.0 * (np.arange(50) > 4)
    for command, pressure, unit, argument in (
        (0.0 * on, 0.0 * on, 1, "command"),
        (1.0 - on, 0.0 * on, 1, "command"),
        (1.0 * (np.arange(50) > 45), 0.0 * on, 1, "time"),
        (on, np.zeros(49), 1, "pressure"),
        (on, 0.0 * on, 3, "unit"),
        (-on, 0.0 * on, 1, "pressure"),  # nothing to vent
        (on, SUPPLY + on, 1, "pressure"),
    ):
        with pytest.raises(InvalidInputError) as error:
            control.identify(time, command, pressure, plant, unit)
        assert error.value.argument == argument


@pytest.mark.parametrize("noise", [0.0, 2e3])
def test_a_pressure_that_does_not_follow_the_step_is_refused(plant_of, pair, noise):
    time = DT * np.arange(500)
    pressure = 1e5 + noise * np.random.default_rng(2).standard_normal(500)
    with pytest.raises(InvalidInputError) as error:
        control.identify(time, np.where(time >= 0.1, 1.0, 0.0), pressure, plant_of(pair))
    assert error.value.argument == "pressure"

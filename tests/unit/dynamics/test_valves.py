"""Valves that come late, and valves that pulse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import dynamics, fluid
from fascicle.control import cascade


def test_a_dead_time_shifts_commands(bundle, air):
    load = dynamics.HangingMass(12.0, damping=300.0)
    prompt, late = (
        dynamics.Plant(bundle, load, spool=fluid.Direct(dead_time=x), **air) for x in (0.0, 0.015)
    )
    start = dynamics.equilibrium_state(prompt, 1.5e5)
    commands = np.repeat([[1.0, 0.0], [-0.5, 1.0]], 30, axis=0)
    shifted = np.concatenate([np.zeros((15, 2)), commands])[:60]
    given, run = (
        dynamics.simulate(plant, rows, start=start, substeps=4)
        for plant, rows in ((prompt, shifted), (late, commands))
    )
    for name in ("position", "pressures", "supply", "drawn"):
        x, y = (getattr(one.outputs, name) for one in (given, run))
        assert_allclose(x[:-1], y[:-1], rtol=1e-12, atol=1e-14)
    assert_allclose(run.commands[:60], commands)
    schedule = dynamics.Schedule([0.0, 0.03], [[1.0, 0.0], [-0.5, 1.0]])
    exact = dynamics.integrate(late, schedule, [0.0, 0.02, 0.05], start)
    assert_allclose(run.outputs.pressures[[20, 50]], exact.outputs.pressures[1:], rtol=1e-6)


def test_pulses_hold_the_demanded_force_and_close_the_balances():
    scenario = fs.example("ramp_pulses")
    run = scenario.run()
    assert dynamics.audit(scenario.plant, run).closes and not scenario.findings
    force = np.sum(run.outputs.forces, axis=1)[1:]
    miss = np.abs(force - scenario.control.reference)
    assert np.median(miss) < 1.0  # N, of 80: the ripple of pulses
    with pytest.raises(fs.InvalidInputError) as error:
        scenario.plant.linearize(scenario.start)
    assert error.value.argument == "spool"


def test_an_undeclared_dead_time_is_named():
    scenario = fs.example("ramp_1_4")
    plant = scenario.plant
    spool = fluid.Direct(dead_time=0.015)
    parts = ("load", "supply", "chamber", "valve")
    late = dynamics.Plant(plant.bundles[0], **{x: getattr(plant, x) for x in parts}, spool=spool)
    options = {"policy": "threshold", "of": "force"}
    assert not cascade(late, **options, delay=0.015).findings
    (finding,) = cascade(late, **options).findings
    assert finding.code == "control.dead_time_undeclared" and finding.data["dead_time"] == 0.015

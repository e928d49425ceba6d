"""What `crossing` promises of a fast ramp a policy holds, and a loop is as fast as its valves,
measurements and samples let it.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import control, dynamics, fluid
from fascicle.control import Gains
from refusing import warns


STRAIN, DT = 0.2, 1e-3
HELD = 0.1  # of the dip, a tenth: what docs and benchmarks call held


@pytest.fixture(scope="module")
def ramp(pair):
    """From 0.1 to 3 times what the first unit holds."""
    first = float(control.transition(pair, STRAIN).largest_force)

    def ramp(duration):
        return np.linspace(0.1, 3.0, round(duration / DT)) * first

    return ramp


def dip(plant, demand, policy="hand_over", **options):
    """Drawdown of a run over the dip [-]."""
    bundle = plant.bundles[0]
    empty = float(bundle.motor_units[1].muscle.force(0.0, STRAIN))
    force = np.array([demand[0] - empty, 0.0])
    pressure = control.Branches.of(bundle).pressure(force, np.full(2, STRAIN))[0]
    controller = control.cascade(plant, policy, **options)
    start = dynamics.equilibrium_state(plant, [float(pressure), 0.0])
    run = dynamics.simulate(plant, controller, demand, start=start, substeps=2)
    worth = control.control_metrics(controller, run, demand)
    return worth.drawdown / worth.dip


@pytest.mark.parametrize(
    ("conductance", "duration"),
    [
        (1e-9, 0.7),
        (1e-9, 1.0),
        pytest.param(5e-10, 2.0, marks=pytest.mark.slow),
        pytest.param(2e-9, 0.35, marks=pytest.mark.slow),
        pytest.param(1e-9, 0.6, marks=pytest.mark.slow),
        pytest.param(5e-10, 1.2, marks=pytest.mark.slow),
    ],
)
def test_a_predicted_hand_over_has_no_dip(plant_of, pair, ramp, conductance, duration):
    plant, demand = plant_of(pair, conductance=conductance), ramp(duration)
    assert control.crossings_on_reference(plant, demand, DT, "force")[0].exists
    assert dip(plant, demand) < HELD


def test_a_ramp_too_fast_for_the_valves_is_late_but_does_not_dip(plant_of, pair, ramp):
    plant, demand = plant_of(pair), ramp(0.35)
    assert not control.crossings_on_reference(plant, demand, DT, "force")[0].is_resolved
    assert dip(plant, demand, "threshold") > HELD > dip(plant, demand)


@pytest.mark.parametrize(
    ("valve", "delay"),
    [
        (20e-3, 0.0),
        pytest.param(None, 10e-3, marks=pytest.mark.slow),
        *(pytest.param(5e-3, d, marks=pytest.mark.slow) for d in (0.0, 5e-3)),
    ],
)
def test_pressures_settle_as_fast_as_the_delays_allow(plant_of, pair, ramp, valve, delay):
    plant = plant_of(pair, spool=None if valve is None else fluid.Servovalve(valve))
    controller = control.cascade(plant, "hand_over", delay=delay)
    late = (valve or 0.0) + delay + DT
    assert_allclose(controller.gains.pressure_time, 2 * late, rtol=1e-12)
    assert controller.findings == ()
    assert dip(plant, ramp(4.0), delay=delay) < HELD


def test_a_loop_faster_than_its_valves_warns(plant_of, pair):
    plant = plant_of(pair, spool=fluid.Servovalve(20e-3))
    with warns("pressure_time"):
        hasty = control.cascade(plant, "hand_over", gains=Gains(pressure_time=3e-3))
    (finding,) = hasty.findings
    assert finding.code == "control.pressure_time_short" and finding.data["pressure_time"] == 3e-3
    slow = control.cascade(plant, "hand_over", gains=Gains(pressure_time=30e-3))
    assert slow.findings == () and slow.gains.pressure_time == 30e-3

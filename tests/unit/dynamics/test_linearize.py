"""Linear models against differences of runs."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

import fascicle as fs
from fascicle import dynamics, fluid
from fascicle.dynamics.chamber_pressure import muscle_volumes


NAMES = "position velocity spool_1 spool_2 pressure_1 pressure_2 mass_1 mass_2"
STEPS = np.array([1e-7, 1e-5, 1e-5, 1e-5, 1.0, 1.0, 1e-10, 1e-10])  # small beside each state


@pytest.fixture(scope="module")
def servo(bundle, air):
    load = dynamics.HangingMass(12.0, damping=300.0)
    return dynamics.Plant(bundle, load, spool=fluid.Servovalve(0.01), **air)


def test_a_model_agrees_with_differences_of_runs(servo, bundle, air):
    start = dynamics.equilibrium_state(servo, [3e5, 1e5])
    outputs = ("position", "velocity", "pressure", "strain", "force")
    model = servo.linearize(start, ("command", "force"), outputs)
    assert [name.replace(" ", "_") for name in model.states] == NAMES.split()
    assert model.inputs == {"command 1": "-", "command 2": "-", "force": "N"}
    assert model.outputs["pressure 2"] == "Pa" and model.states["mass 1"] == "kg"
    assert_allclose(model.B[1], [0, 0, 1 / 12.0])
    assert_allclose(model.rate, 0.0, atol=1e-6)
    # x' = A x + B u with x = X exp(s t)
    s = 2j * np.pi * 3.0
    states = np.linalg.inv(s * np.eye(8) - model.A) @ model.B
    response = model.C @ states + model.D
    assert_allclose(model.frequency_response([1.0, 3.0])[1], response)
    spool = fluid.Servovalve(0.01, dead_time=6e-3)
    late = dynamics.Plant(bundle, servo.load, spool=spool, **air)
    late_model = late.linearize(start, ("command", "force"), outputs)
    assert_allclose(late_model.delays, [6e-3, 6e-3, 0.0])
    turn = [np.exp(-s * 6e-3), np.exp(-s * 6e-3), 1.0]
    assert_allclose(late_model.frequency_response(3.0)[0], response * turn)
    gas, duration = servo.chamber, 0.02

    def run(x):
        """Outputs at the end of a run from the states `x`, all valves commanded shut."""
        q, v, spool, P, mass = x[0], x[1], x[2:4], x[4:6], x[6:8]
        V = muscle_volumes(servo, servo.strains(q), P)[1].volume + gas.dead_volume
        energy = (P + gas.room_pressure) * V / (gas.gas.heat_capacity_ratio - 1)
        chambers = np.stack([mass, energy], axis=-1)
        begin = dynamics.State(np.float64(q), np.float64(v), spool, chambers, P, start.supply)
        commands = np.zeros((round(duration / 1e-3), 2))
        out = dynamics.simulate(servo, commands, start=begin, substeps=8).outputs
        rows = (out.position, out.velocity, out.pressures, out.strains, out.forces)
        return np.concatenate([np.ravel(x[-1]) for x in rows])

    x_0 = np.concatenate(
        [[start.position, 0.0], start.spool, start.pressures, start.chambers[:, 0]]
    )
    expected = model.C @ expm(model.A * duration)
    for k, step in enumerate(STEPS):
        change = step * (np.arange(8) == k)
        slope = (run(x_0 + change) - run(x_0 - change)) / (2 * step)
        # over what the output changes by any state, each by its step
        size = np.max(np.abs(expected) * STEPS, axis=1) / step
        assert_allclose(slope / size, expected[:, k] / size, rtol=0, atol=1e-6)


def test_a_prescribed_motion_has_no_state_and_a_spool_without_lag_none(bundle, air):
    plant = dynamics.Plant(bundle, dynamics.PrescribedMotion(0.01), **air)
    state = dynamics.equilibrium_state(plant, 1e5)
    model = plant.linearize(state, outputs=["force"], command=0.5)
    assert list(model.states) == ["pressure 1", "pressure 2", "mass 1", "mass 2"]
    assert np.all(np.diag(model.B) > 0) and np.all(model.D == 0)
    for inputs in (["comand"], "command", ["force"]):
        with pytest.raises(fs.InvalidInputError) as error:
            plant.linearize(state, inputs)
        assert error.value.argument == "inputs"


def test_a_joint_swings_at_the_frequency_of_its_springs_of_gas():
    # a theory apart: ideal muscles, F = -P dV/dL, on a pulley, each shut with its mass of gas
    arm, inertia, room, spare, length, radius, angle = 0.03, 2e-3, 101325.0, 5e-6, 0.2, 8e-3, 0.45
    contraction, bias, wall = 0.02, 2e5, 1e-4
    rubber = np.pi * (radius**2 - (radius - wall) ** 2) * length

    def volume(x):
        """Of the gas in a cylinder of the braid, shortened by x [m³]."""
        inside = 1 - (1 - x / length) ** 2 * np.cos(angle) ** 2
        return np.pi * radius**2 / np.sin(angle) ** 2 * inside * (length - x) - rubber

    def torque(q):
        """Of both, with (P + room) (V + spare) constant [N·m]."""
        total = 0.0
        for sign in (1, -1):
            x, h = contraction + sign * arm * q, 1e-6
            absolute = (bias + room) * (volume(contraction) + spare) / (volume(x) + spare)
            total += sign * arm * (absolute - room) * (volume(x + h) - volume(x - h)) / (2 * h)
        return total

    stiffness = -(torque(1e-4) - torque(-1e-4)) / 2e-4
    muscle = fs.Muscle(length, radius, wall, angle, tension="ideal")
    load = dynamics.AntagonisticJoint(inertia, arm, contraction=contraction)
    parts = (
        fluid.ConstantSupply(5e5),
        fluid.Isothermal(dead_volume=spare),
        fluid.SonicValve(1e-9, 0.3),
    )
    plant = dynamics.Plant([fs.Bundle([fs.MotorUnit(muscle)])] * 2, load, *parts, law="exact")
    model = plant.linearize(dynamics.equilibrium_state(plant, bias))
    swing = np.max(np.abs(np.linalg.eigvals(model.A).imag))
    # the theory's slope by differences over 1e-4 rad
    assert_allclose(swing, np.sqrt(stiffness / inertia), rtol=1e-6)

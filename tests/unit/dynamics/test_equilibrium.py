"""Plants at rest: nothing jerks, and what can't rest or doesn't go together is refused."""

import equinox as eqx
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import dynamics, fluid
from fascicle.core.errors import InvalidInputError
from fascicle.dynamics.equilibrium import equilibrium_state
from fascicle.dynamics.motion import FrictionMemory, evaluate_plant, time_derivative
from fascicle.dynamics.outputs import observe
from refusing import refuses


def _at(plant, state, command):
    memory = FrictionMemory(np.zeros((plant.units, 0)), state.position, state.pressures)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        now = evaluate_plant(plant, np.float64(0.0), state, command, memory)
        return time_derivative(plant, state, now, command), observe(plant, state, memory, now)


@pytest.mark.parametrize("pressures", [1.5e5, [1e5, 3e5], [4.1e5, 0.0]])
def test_a_state_at_rest_stays_at_rest_with_shut_valves(lift, pressures):
    state = equilibrium_state(lift, pressures)
    moving, seen = _at(lift, state, np.zeros(2))
    # of gravity: what rounding of the balance of forces leaves
    assert abs(moving.velocity) < 1e-9 * 9.8
    assert moving.position == 0
    assert_allclose(seen.pressures, np.broadcast_to(pressures, 2), rtol=1e-12, atol=1e-6)
    assert_allclose(moving.pressures, 0, atol=1e-3)
    assert_allclose(moving.chambers, 0, atol=1e-12)
    assert_allclose(seen.temperatures, 293.15, rtol=1e-12)


def test_the_bundle_holds_the_load_at_rest(lift, bundle):
    state = equilibrium_state(lift, [1e5, 2e5])
    eps = float(lift.strains(state.position)[0])
    weight = float(lift.load.mass * lift.load.gravity)
    # the table's error of force
    off = 5 * lift.muscles.table.errors[2]
    assert_allclose(bundle.force([1e5, 2e5], eps), weight, rtol=0, atol=off)


def test_a_given_position_is_the_start(lift):
    state = equilibrium_state(lift, 1.5e5, position=0.005)
    assert state.position == 0.005 and state.velocity == 0
    moving, _ = _at(lift, state, np.zeros(2))
    assert moving.velocity > 0  # there it pulls more than the load weighs


def test_a_prescribed_motion_gives_its_start(bundle, air):
    load = dynamics.PrescribedMotion(0.01, 0.005, 2.0)
    plant = dynamics.Plant(bundle, load, **air)
    state = equilibrium_state(plant, 1e5)
    assert state.position == 0.01
    assert_allclose(state.velocity, 2 * np.pi * 2.0 * 0.005, rtol=1e-12)
    with pytest.raises(InvalidInputError) as error:
        equilibrium_state(plant, 1e5, position=0.02)
    assert error.value.argument == "position"


@pytest.mark.slow
def test_a_free_swing_equals_the_closed_form(muscle):
    # ideal muscles without pressure pull nothing: spring, damper, and the air that is pushed about
    mesh, V_0, n = muscle.replace(tension="ideal"), 1e-3, 2
    load = dynamics.InertiaSpringDamper(3.0, 4e3, 12.0)
    plant = dynamics.Plant(
        fs.Bundle([fs.MotorUnit(mesh, n)]), load, fluid.ConstantSupply(4e5),
        fluid.AdiabaticWall(dead_volume=V_0), fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip
    A = 1e-5  # so small that all is linear to 1e-3 of it
    steps = 400
    run = dynamics.simulate(
        plant, np.zeros((steps, 1)), start=equilibrium_state(plant, 0.0, position=A)
    )
    V = V_0 + n * float(mesh.volume(0.0))
    swept = n * float(mesh.force(1e5, 0.0)) / 1e5  # dV/dx = F/P of the ideal mesh
    of_air = 1.4 * 101325 * swept**2 / V
    k = 4e3 + of_air
    assert of_air > 0.01 * k
    decay = 12.0 / (2 * 3.0)
    omega = np.sqrt(k / 3.0 - decay**2)
    t = run.time
    shape = np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    middle = of_air / k * A  # the air is at the room's pressure where it begins
    swing = middle + (A - middle) * shape
    assert_allclose(run.outputs.position, swing, rtol=0, atol=1e-3 * A)


@pytest.mark.parametrize(
    ("argument", "value"),
    [("pressures", [1e5]), ("pressures", -1.0), ("pressures", np.nan), ("command", [1.5, 0]),
     ("position", np.nan), ("position", lambda plant: plant.stroke[0] - 1e-6),
     ("position", lambda plant: plant.stroke[1] + 1e-6)],
)  # fmt: skip
def test_invalid_input_is_refused(lift, argument, value):
    with pytest.raises(InvalidInputError) as error:
        equilibrium_state(lift, **{argument: value(lift) if callable(value) else value})
    assert error.value.argument == argument


@pytest.mark.parametrize(("mass", "side"), [(500.0, "weak"), (1e-3, "strong")])
def test_a_load_without_equilibrium_is_refused(lift, mass, side):
    plant = eqx.tree_at(lambda p: p.load.mass, lift, np.float64(mass))
    if side == "strong":  # a spring that pushes
        load = dynamics.InertiaSpringDamper(1.0, force_outside=-1e4)
        plant = eqx.tree_at(lambda p: p.load, lift, load)
    with refuses("load") as error:
        equilibrium_state(plant, 1e5)
    assert side in str(error.value)


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"law": "tabel"}, "law"),
        ({"load": dynamics.AntagonisticJoint(0.01, 0.02)}, "bundle"),
        ({"chamber": fluid.LiquidChamber()}, "valve"),
        ({"chamber": fluid.LiquidChamber(), "valve": fluid.Orifice(1e-6)}, "compliance"),
        ({"load": 5.0}, "load"),
        ({"chamber": fluid.AIR}, "chamber"),
    ],
)
def test_incompatible_components_are_refused(bundle, air, changes, argument):
    components = {"bundle": bundle, "load": dynamics.HangingMass(12.0), **air} | changes
    with pytest.raises(InvalidInputError) as error:
        dynamics.Plant(**components)
    assert error.value.argument == argument

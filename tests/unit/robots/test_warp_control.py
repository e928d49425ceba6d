"""The control callback of MuJoCo Warp: the same steps as MuJoCo, on arrays and where Warp is."""

import sys
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

from fascicle import fluid


mujoco = pytest.importorskip("mujoco", reason="the extra robots isn't here")
from fascicle.robots import WarpControl  # noqa: E402 needs what was just looked for


SUPPLY = 413.7e3
HELD = np.array([2e5, 1.5e5])
COMMANDS = np.array([[0.5, -0.5], [0.0, 0.0], [-0.2, 0.3]])
CHAMBERS = {
    "supply": fluid.ConstantSupply(SUPPLY), "valve": fluid.SonicValve(1e-9, 0.3),
    "chamber": fluid.Isothermal(dead_volume=2e-6),
}  # fmt: skip


def test_worlds_advance_as_the_drive_does(elbow):
    model, data, drive = elbow(cord={"stiffness": 3e4, "slack": True}, **CHAMBERS)
    control = WarpControl(drive, model, data, 3, HELD)
    control.commands = jnp.asarray(COMMANDS)
    fluids = [drive.start(model, data, HELD) for _ in COMMANDS]
    for k in range(5):
        lengths = drive.rest_lengths - 0.01 - 0.002 * np.array([[k, -k], [0, k], [1, 1]])
        pulls = control.advance(lengths)
        for i, command in enumerate(COMMANDS):
            fluids[i], pull = drive.act(fluids[i], lengths[i], command, model.opt.timestep)
            # rounding, and the search for the cord's stretch
            np.testing.assert_allclose(pulls[i], pull, rtol=1e-8, atol=1e-6)
    np.testing.assert_allclose(control.fluid.drawn, [x.drawn for x in fluids], rtol=1e-8)


def test_the_callback_sets_the_controls_of_its_actuators_alone(elbow, monkeypatch):
    """With arrays of JAX in the place of Warp's."""
    model, data, drive = elbow(**CHAMBERS)
    copied = {}
    warp = SimpleNamespace(
        to_jax=lambda x: x, from_jax=lambda x: x, copy=lambda to, x: copied.update({id(to): x})
    )
    monkeypatch.setitem(sys.modules, "warp", warp)
    control = WarpControl(drive, model, data, 2, HELD)
    lengths = jnp.asarray(np.tile(drive.rest_lengths - 0.01, (2, 1)), jnp.float32)
    worlds = SimpleNamespace(
        actuator_length=jnp.pad(lengths, ((0, 0), (0, 1))), ctrl=jnp.full((2, 3), 7, jnp.float32)
    )
    control(None, worlds)
    controls = copied[id(worlds.ctrl)]
    assert controls.dtype == jnp.float32 and (controls[:, 2] == 7).all()
    expected = drive.pull(np.asarray(control.fluid.pressures[0]), drive.rest_lengths - 0.01)
    np.testing.assert_allclose(controls[:, :2], np.tile(expected, (2, 1)), rtol=1e-5)  # 32 bits


def test_a_runge_kutta_step_with_valves_is_refused(elbow):
    model, data, drive = elbow(integrator="RK4", **CHAMBERS)
    with pytest.raises(ValueError, match="must not be RK4 with valves"):
        WarpControl(drive, model, data, 1)
    model, data, drive = elbow(integrator="RK4")
    WarpControl(drive, model, data, 1)


@pytest.mark.slow
def test_mujoco_warp_equals_mujoco(elbow):
    engine = pytest.importorskip("mujoco_warp", reason="mujoco-warp isn't here")
    model, data, drive = elbow(**CHAMBERS)
    control = WarpControl(drive, model, data, 2, HELD)
    there, worlds = engine.put_model(model), engine.put_data(model, data, nworld=2)
    there.callback.control = control
    held = drive.start(model, data, HELD)
    for _ in range(100):
        engine.step(there, worlds)
        held = drive.step(model, data, held, np.zeros(2))
    # Warp computes with 32 bits
    np.testing.assert_allclose(worlds.qpos.numpy()[:, 0], data.qpos[0], atol=1e-5)

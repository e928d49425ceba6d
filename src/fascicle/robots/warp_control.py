"""Bundles in MuJoCo Warp and in Newton: the pulls of all worlds, as a control callback.

MuJoCo Warp calls `Model.callback.control(model, data)` in each step, after the tendons' lengths of
this step are known and before forces are computed: the order that `Drive.step` has. Newton's
`SolverMuJoCo` steps MuJoCo Warp with its `mjw_model` and `mjw_data`, so that the same callback
serves it.

Arrays pass between Warp and JAX without a copy, on one device. A step with JAX inside can't be
captured as a CUDA graph.

**Source:** documentation of MuJoCo Warp 3.17, `Callback`.
"""

import importlib
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Numbers, Values
from .drive import Drive, Fluid
from .optional_imports import mujoco


class WarpControl:
    """Control callback of MuJoCo Warp for the bundles of a `drive`.

    `commands`: of the valves [-], or pressures [Pa], a row for each world; set them before a step.
    `fluid`: of all worlds after the last step [SI], with an axis of worlds ahead.
    """

    def __init__(self, drive: Drive, model: Any, data: Any, worlds: int, pressures: Values = 0.0):
        """**Arguments:**

        - `drive`: of the compiled `model`.
        - `model`, `data`: MuJoCo's, with the pose in which all worlds begin.
        - `worlds`: number of worlds [-].
        - `pressures`: initial ones of all units, or of each [Pa].

        **Raises:** `InvalidInputError` for a Runge-Kutta step of a drive with valves, whose fluid
        would flow at each stage.
        """
        if drive.valved and model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
            rule = "must not be RK4 with valves: their fluid would flow at each of its stages"
            raise InvalidInputError(
                "model.opt.integrator", rule, None, "take Euler or implicitfast"
            )
        self.drive, self.step_size = drive, float(model.opt.timestep)
        fluid = drive.start(model, data, pressures)
        self.fluid: Fluid = jax.tree.map(
            lambda x: jnp.broadcast_to(jnp.asarray(x), (worlds, *np.shape(x))), fluid
        )
        count = drive.plant.commands if drive.valved else drive.units
        self.commands: Numbers = jnp.zeros((worlds, count))
        self._act = jax.jit(jax.vmap(drive.act, in_axes=(0, 0, 0, None)))

    def advance(self, lengths: Numbers) -> Numbers:
        """Advance the fluid of all worlds by a step.

        **Arguments:**

        - `lengths`: of the bundles' tendons of this step [m], rows of worlds.

        **Returns:** pulls [N], rows of worlds.
        """
        lengths = jnp.asarray(lengths, self.fluid.pressures.dtype)
        self.fluid, pull = self._act(self.fluid, lengths, self.commands, self.step_size)
        return pull

    def __call__(self, model: Any, data: Any) -> None:
        """Set the controls of Warp's `data` for its step; `model` doesn't count."""
        del model
        warp, indices = importlib.import_module("warp"), np.array(self.drive.actuators)
        pull = self.advance(warp.to_jax(data.actuator_length)[:, indices])
        controls = warp.to_jax(data.ctrl)
        controls = controls.at[:, indices].set(pull.astype(controls.dtype))
        warp.copy(data.ctrl, warp.from_jax(controls))

"""Environments in one process: all step together in MJX, with the tables of their muscles.

`gymnasium.make_vec(name, num_envs=…)` returns one of these. Environment `i` of a reset with a seed
has the targets of a single one with that seed plus `i`. After an episode's end the next step
resets, whatever its action, as Gymnasium's own vector environments do.
"""

from collections.abc import Iterable
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ..core.errors import InvalidInputError
from .drive import Fluid
from .environments import (
    FRAMES,
    START,
    AntagonisticJoint,
    Environment,
    HangingMass,
    Plan,
    check_action,
    task_observation,
)
from .optional_imports import mjx, mujoco


class VectorEnvironment(VectorEnv):
    """Many environments of one kind, compiled together.

    Observations, rewards and what is measured are those of the single environment, with an axis of
    environments ahead.
    """

    metadata: ClassVar[dict[str, Any]] = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        kind: type[Environment],
        num_envs: int,
        max_episode_steps: int = 200,
        render_mode: str | None = None,
    ):
        """**Arguments:**

        - `kind`: class of the single environment.
        - `num_envs`: their number [-].
        - `max_episode_steps`: of 10 ms, after which an episode is truncated.
        - `render_mode`: must be `None`.

        **Raises:** `InvalidInputError` for fewer than one of them, and a mode.
        """
        if render_mode is not None:
            raise InvalidInputError("render_mode", "must be None", render_mode, "draw a single one")
        if num_envs < 1:
            raise InvalidInputError("num_envs", "must be at least 1", num_envs)
        self.num_envs, self.limit, self.task = num_envs, max_episode_steps, kind.task
        self.model, self.drive = plan = Plan.of(kind.task)
        self.single_observation_space, self.single_action_space = plan.spaces
        self.observation_space, self.action_space = (
            batch_space(space, num_envs) for space in plan.spaces
        )
        data = mujoco.MjData(self.model)
        fluid = self.drive.start(self.model, data, START)
        engine = mjx()
        physics = engine.put_data(self.model, data)
        # on MJX's device from the start: a state that moves there later compiles the step again
        single = jax.device_put((physics, fluid), physics.qpos.device)
        self._first = jax.tree.map(lambda x: jnp.broadcast_to(x, (num_envs, *x.shape)), single)
        self._engine_model = engine.put_model(self.model)
        self._step = jax.jit(self._advance)
        self._state = self._first
        self._generators = [np_random(None)[0] for _ in range(num_envs)]
        self.targets, self._steps = np.zeros(num_envs), np.zeros(num_envs, int)
        self._over = np.zeros(num_envs, bool)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode of each: `seed`s of the targets, or the first one of them.

        **Returns:** observations, and what is measured [SI].
        """
        del options
        if seed is not None:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else seed
            self._generators = [np_random(number)[0] for number in seeds]
        self._state = self._first
        self._draw_targets(range(self.num_envs))
        self._steps[:] = 0
        self._over[:] = False
        return self._results()

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One step of 10 ms of each with valves open by `actions` [-], rows of environments.

        **Returns:** observations, rewards, whether a muscle left its table, whether the time is up,
        and what is measured [SI].

        **Raises:** `InvalidInputError` for actions that aren't finite.
        """
        commands = check_action(actions, self.action_space.shape or ())
        fresh = self._over.copy()
        self._draw_targets(np.flatnonzero(fresh))
        self._state, position, inside = self._step(self._state, commands, fresh)
        self._steps += 1
        self._steps[fresh] = 0
        error = np.abs(np.asarray(position) - self.targets) / self.task.reach
        terminated = ~np.asarray(inside)
        truncated = (self._steps >= self.limit) & ~terminated
        self._over = terminated | truncated
        observations, info = self._results()
        return observations, np.where(fresh, 0.0, -error), terminated, truncated, info

    def _draw_targets(self, indices: Iterable[int]) -> None:
        """Draw targets of the environments with these `indices`."""
        for i in indices:
            self.targets[i] = self._generators[i].uniform(self.task.low, self.task.high)

    def _advance(self, state: tuple, commands: jax.Array, fresh: jax.Array) -> tuple:
        """State after a step, positions [SI], and whether all are in their tables."""

        def single(data: Any, fluid: Fluid, command: jax.Array) -> tuple:
            def frame(carry: tuple, _: None) -> tuple:
                data, fluid = carry
                return self.drive.step_mjx(self._engine_model, data, fluid, command), None

            return jax.lax.scan(frame, (data, fluid), length=FRAMES)[0]

        data, fluid = state
        after = jax.vmap(single)(data, fluid, commands)

        def choose(first: jax.Array, x: jax.Array) -> jax.Array:
            return jnp.where(fresh.reshape((-1,) + (1,) * (x.ndim - 1)), first, x)

        data, fluid = after = jax.tree.map(choose, self._first, after)
        return after, data.qpos[:, 0], fluid.inside

    def _results(self) -> tuple[np.ndarray, dict[str, Any]]:
        """Observations [-] and what is measured [SI]."""
        data, fluid = self._state
        position, speed, pressures, forces, air = (
            np.asarray(x)
            for x in (
                data.qpos[:, 0],
                data.qvel[:, 0],
                fluid.pressures,
                data.actuator_force,
                fluid.consumption,
            )
        )
        info = {
            "position": position,
            "target": self.targets.copy(),
            "pressures": pressures,
            "forces": -forces[:, list(self.drive.actuators)],
            "air": air,
        }
        return task_observation(self.task, position, speed, self.targets, pressures), info


def antagonistic_joints(num_envs: int = 1, **options: Any) -> VectorEnvironment:
    """As many `AntagonisticJoint`s in one process; `options` of a `VectorEnvironment`."""
    return VectorEnvironment(AntagonisticJoint, num_envs, **options)


def hanging_masses(num_envs: int = 1, **options: Any) -> VectorEnvironment:
    """As many `HangingMass`es in one process; `options` of a `VectorEnvironment`."""
    return VectorEnvironment(HangingMass, num_envs, **options)

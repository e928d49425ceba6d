"""Many robots in one process: a vector environment of Gymnasium for any model of MuJoCo.

All step together in MJX, with the tables of their muscles. What an episode begins with, what is
observed and what is rewarded are functions of arrays, which the caller writes. After an episode's
end the next step resets, whatever its action, as Gymnasium's own vector environments do.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ..core.errors import InvalidInputError
from ..core.types import Marks, Numbers, PyTree, Values
from ..core.validation import check_whole_number
from .attach import check_model
from .drive import Drive, Fluid, with_types
from .environments import (
    FRAMES,
    START,
    AntagonisticJoint,
    Environment,
    Episode,
    HangingMass,
    box,
    check_action,
)
from .optional_imports import Data, Model, mjx, mujoco


class VectorEnvironment(VectorEnv):
    """Environments of one model with fascicle's muscles on its tendons, compiled together.

    Actions are the muscles' commands: of valves, from -1 to 1 [-], or without valves pressures in
    shares of the highest, from 0 to 1 [-]. An episode ends where a muscle leaves its table, and is
    cut after `max_episode_steps`.
    """

    metadata: ClassVar[dict] = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        model: Model,
        drives: Drive | Sequence[Drive],
        num_envs: int,
        begin: Callable[[np.random.Generator], tuple[Numbers, Numbers, Numbers]],
        observe: Callable[[Episode], Numbers],
        reward: Callable[[Episode, Numbers], Numbers],
        measure: Callable[[Episode], dict] | None = None,
        pressures: Values = 0.0,
        frames: int = 1,
        max_episode_steps: int = 1000,
        observation_space: Box | None = None,
    ):
        """**Arguments:**

        - `model`: MuJoCo's compiled `MjModel`.
        - `drives`: one for all environments; or several of the same structure, with other muscles,
          of which environment `i` has the one at `i` modulo their number.
        - `num_envs`: number of environments [-].
        - `begin`: function of a random generator of NumPy: returns `qpos`, `qvel` [SI] and the goal
          of an episode, any arrays.
        - `observe`: of an `Episode`, traced by JAX: the observation, a row of numbers.
        - `reward`: likewise, of an `Episode` and the action: a number.
        - `measure`: likewise, of an `Episode`: arrays by name for `info`; or none.
        - `pressures`: of all units, or of each, as an episode begins [Pa].
        - `frames`: MuJoCo's steps in one of the environment [-].
        - `max_episode_steps`: after which an episode is truncated [-].
        - `observation_space`: of one environment; left out, a box without limits.

        **Raises:** `InvalidInputError` for numbers below one, and drives that differ in structure.
        """
        self.num_envs = check_whole_number(num_envs, "num_envs", 1)
        self.limit = check_whole_number(max_episode_steps, "max_episode_steps", 1)
        self._frames = check_whole_number(frames, "frames", 1)
        self._begin_episode, self._observe, self._reward = begin, observe, reward
        self._measure = measure or (lambda *_: {})
        check_model(model, "model", ("MjModel",))
        drives = [drives] if isinstance(drives, Drive) else list(drives)
        structures = {str(jax.tree.structure(drive)) for drive in drives}
        if len(structures) != 1 or not isinstance(drives[0], Drive):
            rule = "must be a Drive, or several of the same structure"
            text = (
                f"{len(structures)} structures of {', '.join({type(x).__name__ for x in drives})}"
            )
            raise InvalidInputError("drives", rule, None, shown=text)
        self.model, self._valved, units = model, drives[0].valved, drives[0].units
        self._highest = min(drive.highest_pressure for drive in drives)
        self._pressures = drives[0].start(model, mujoco.MjData(model), pressures).pressures
        self._engine = mjx()
        self._blank = self._engine.put_data(model, mujoco.MjData(model))
        self._physics = self._engine.put_model(model)
        # tables of other muscles are stacked; those of equal ones are shared
        axes, shared = (0, None) if len(drives) > 1 else (None, drives[0])
        chosen = [drives[i % len(drives)] for i in range(self.num_envs)]
        stacked = shared or jax.tree.map(lambda *leaves: np.stack(leaves), *chosen)
        # on MJX's device from the start: a state that moves there later compiles the step again
        self._drives = jax.device_put(stacked, self._blank.qpos.device)
        self._start = jax.jit(jax.vmap(self._start_one, in_axes=(axes, 0, 0)))
        self._step = jax.jit(jax.vmap(self._step_one, in_axes=(axes, 0, 0, 0, 0, 0)))
        self._view = jax.jit(jax.vmap(self._view_one))
        self._generators = [np_random(None)[0] for _ in range(self.num_envs)]
        self._steps = np.zeros(self.num_envs, int)
        self._over = np.ones(self.num_envs, bool)
        self._episodes: list[tuple] = [()] * self.num_envs
        self._state: PyTree = None
        self._begin(self._over)
        width = self._results()[0].shape[1]
        self.single_action_space = box(-1.0 if self._valved else 0.0, 1.0, units)
        self.single_observation_space = observation_space or box(-np.inf, np.inf, width)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict | None = None,
    ) -> tuple[np.ndarray, dict]:
        """Start an episode of each: `seed`s of the generators, or the first one of them. Returns
        observations, and what is measured [SI].
        """
        if seed is not None:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else seed
            self._generators = [np_random(number)[0] for number in seeds]
        self._over[:] = True
        self._begin(self._over)
        self._over[:] = False
        return self._results()

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict]:
        """One step of each with `actions` [-], rows of environments, which must be finite.

        **Returns:** observations, rewards, whether a muscle left its table, whether the time is up,
        and what is measured [SI].
        """
        actions = check_action(actions, self.action_space.shape or ())
        fresh = self._over.copy()
        if fresh.any():
            self._begin(fresh)
        state = *self._state, self._goals
        self._state, rewards, inside = self._step(self._drives, *state, actions, fresh)
        self._steps += ~fresh
        terminated = ~np.asarray(inside)
        truncated = (self._steps >= self.limit) & ~terminated
        self._over = terminated | truncated
        observations, info = self._results()
        return observations, np.asarray(rewards), terminated, truncated, info

    def _begin(self, fresh: np.ndarray) -> None:
        """Begin episodes of the environments in the mask `fresh`, at first of all."""
        self._steps[fresh] = 0
        for i in np.flatnonzero(fresh):
            self._episodes[i] = self._begin_episode(self._generators[i])
        shapes = [np.shape(x) for x in self._episodes[0]]
        needed = [self._blank.qpos.shape, self._blank.qvel.shape]
        if len(shapes) != 3 or shapes[:2] != needed:
            rule = f"must return qpos {needed[0]}, qvel {needed[1]} and a goal"
            raise InvalidInputError("begin", rule, None, shown=f"the shapes {shapes}")
        qpos, qvel, self._goals = jax.tree.map(lambda *leaves: np.stack(leaves), *self._episodes)
        first_state = self._start(self._drives, qpos, qvel)

        def choose(first: jax.Array, x: jax.Array) -> jax.Array:
            return jnp.where(fresh.reshape((-1,) + (1,) * (x.ndim - 1)), first, x)

        self._state = jax.tree.map(choose, first_state, self._state or first_state)

    def _start_one(self, drive: Drive, qpos: Numbers, qvel: Numbers) -> tuple[Data, Fluid]:
        """Data and fluid of one environment as an episode begins."""
        data = self._blank.replace(qpos=qpos, qvel=qvel)
        data = with_types(self._engine.forward(self._physics, data), self._blank)
        return data, drive.fluid_at(data.actuator_length, self._pressures)

    def _step_one(
        self, drive: Drive, data: Data, fluid: Fluid, goal: Numbers, action: Numbers, fresh: Marks
    ) -> tuple[Numbers, Numbers, Numbers]:
        """State, reward, and whether all muscles are in their tables, after a step of one; a
        `fresh` one stays as it is.
        """
        command = action if self._valved else action * self._highest

        def frame(carry: tuple[Data, Fluid], _: None) -> tuple:
            """Advance data and fluid by one step of MuJoCo."""
            return drive.step_mjx(self._physics, carry[0], carry[1], command), None

        after = jax.lax.scan(frame, (data, fluid), length=self._frames)[0]
        data, fluid = jax.tree.map(lambda x, y: jnp.where(fresh, x, y), (data, fluid), after)
        value = _check_axes("reward", self._reward(Episode(data, fluid, goal), action), 0)
        return (data, fluid), jnp.where(fresh, 0.0, value), fluid.inside

    def _view_one(self, data: Data, fluid: Fluid, goal: Numbers) -> tuple[Numbers, dict]:
        """Observation and measurements of one environment."""
        episode = Episode(data, fluid, goal)
        row = _check_axes("observe", self._observe(episode), 1)
        return row.astype(jnp.float32), self._measure(episode)

    def _results(self) -> tuple[np.ndarray, dict]:
        """Observations [-] and what is measured [SI]."""
        return jax.tree.map(np.asarray, self._view(*self._state, self._goals))


def _check_axes(function: str, value: Numbers, axes: int) -> jax.Array:
    """The `value` of a caller's `function` [any unit], refused with more or fewer `axes`."""
    array = jnp.asarray(value)
    if array.ndim != axes:
        rule = f"must return {'a row of numbers' if axes else 'a number'}"
        raise InvalidInputError(function, rule, None, shown=f"the shape {array.shape}")
    return array


def _vector_of(
    kind: type[Environment],
    num_envs: int = 1,
    max_episode_steps: int = 200,
    render_mode: str | None = None,
) -> VectorEnvironment:
    """Environments of a single one's `kind`, with the same targets, observations and rewards."""
    if render_mode is not None:
        raise InvalidInputError("render_mode", "must be None", render_mode, "draw a single one")
    task = kind.task
    model, drive = task.compile()
    functions = (task.begin, task.observe, task.reward, task.measure)
    options = (START, FRAMES, max_episode_steps, box(-1.0, 1.0, 3 + drive.units))
    return VectorEnvironment(model, drive, num_envs, *functions, *options)


antagonistic_joints = partial(_vector_of, AntagonisticJoint)
hanging_masses = partial(_vector_of, HangingMass)

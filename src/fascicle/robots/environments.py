"""Two environments of Gymnasium: a joint between two muscles, and a mass that hangs on a bundle.

Actions open valves; observations and actions lie in [-1, 1]. The reward of a step of 10 ms is the
negative error, so that 0 is best. A target is constant in an episode of 2 s. The muscles are those
of Fig. 6 of the paper; valves and loads are made up.

Many at once step in one process with `gymnasium.make_vec(name, num_envs=…)`, which is fastest: see
`vector_environment`. Environments in forked processes, as those of
`make_vec(…, vectorization_mode="async")`, compute with NumPy, slower than one alone; with
`vector_kwargs={"context": "spawn"}` they compile.

**Source:** of the muscles, Kim, Mazzoleni and Bryant (2021); Towers et al. (2024) for Gymnasium.
"""

import importlib
import os
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import gymnasium
import jax
import numpy as np
from gymnasium.spaces import Box

from ..bundle import Bundle, MotorUnit
from ..core.array_namespace import absolute, array_namespace
from ..core.errors import InvalidInputError
from ..core.types import Numbers
from ..core.validation import check_choice
from ..fluid import ConstantSupply, Isothermal, SonicValve
from ..muscle import Muscle
from . import forked
from .attach import attach
from .drive import Drive, Fluid
from .optional_imports import Data, Model, mujoco


SUPPLY = 413.7e3  # Pa
START = 0.3 * SUPPLY  # Pa, of all units when an episode begins
FRAMES = 10  # MuJoCo's steps of 1 ms in one of the environment
_STEP = 0.01  # s, of the environment
_OPENING = 4.0  # of the baseline's valve for a pressure error of half the supply
_SCENE = """<visual><headlight ambient="0.5 0.5 0.5"/></visual><asset>
<texture type="skybox" builtin="flat" rgb1="1 1 1" width="8" height="48"/></asset><worldbody>
<light pos="0.5 -1 1" dir="-0.4 0.8 -0.8"/>
<camera name="side" pos="0 -0.9 {z}" xyaxes="1 0 0 0 0 1"/>
"""
# a pendulum with two tendons, and a mass on one
_JOINT = f"""<mujoco><compiler angle="radian"/>
<option timestep="0.001"><flag contact="disable"/></option>{_SCENE.format(z=-0.15)}
<body><joint name="moved" type="hinge" axis="0 -1 0" range="-1.2 1.2" limited="true"
 damping="0.05"/><geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.5"/></body>
</worldbody><tendon><fixed name="flexor"><joint joint="moved" coef="-0.02"/></fixed>
<fixed name="extensor"><joint joint="moved" coef="0.02"/></fixed></tendon></mujoco>"""
_MASS = f"""<mujoco>
<option timestep="0.001"><flag contact="disable"/></option>{_SCENE.format(z=0.02)}
<body><joint name="moved" type="slide" axis="0 0 1" range="-0.008 0.04" limited="true"
 damping="20"/><geom size="0.05" mass="5"/></body></worldbody>
<tendon><fixed name="cord"><joint joint="moved" coef="-1"/></fixed></tendon></mujoco>"""


class Episode(NamedTuple):
    """State of an environment: `data` of MuJoCo or MJX, the `fluid` of its muscles, its `goal`."""

    data: Data
    fluid: Fluid
    goal: Numbers


class EnvironmentTask(NamedTuple):
    """Task of an environment: a `model`, the initial `contraction` of its tendons [m], `counts` of
    muscles in each motor unit of every bundle, the coordinate's `middle` and `reach`, the `speed`
    that is observed as 1, and targets between `low` and `high` [SI].
    """

    model: str
    contraction: float
    counts: tuple[int, ...]
    middle: float
    reach: float
    speed: float
    low: float
    high: float

    def compile(self) -> tuple[Model, Drive]:
        """MuJoCo's model, and its drive."""
        spec = mujoco.MjSpec.from_string(self.model)
        muscle = Muscle(0.127, 6.35e-3, 1.6e-3, np.deg2rad(33.0), "silicone_kim2021")
        bundle = Bundle([MotorUnit(muscle, count) for count in self.counts], SUPPLY)
        attached = [attach(spec, tendon.name, bundle, self.contraction) for tendon in spec.tendons]
        model = spec.compile()
        parts = ConstantSupply(SUPPLY), Isothermal(dead_volume=2e-6), SonicValve(5e-10, 0.3)
        return model, Drive.of(model, attached, *parts, shape=(65, 81))

    def begin(self, generator: np.random.Generator) -> tuple[Numbers, Numbers, Numbers]:
        """Position, speed and target of an episode [SI]."""
        return np.zeros(1), np.zeros(1), np.float64(generator.uniform(self.low, self.high))

    def observe(self, episode: Episode) -> Numbers:
        """Position, speed, target and units' pressures of an `episode`, scaled to [-1, 1]."""
        data, fluid, target = episode
        xp = array_namespace(data.qpos, fluid.pressures)
        ways = [(x - self.middle) / self.reach for x in (data.qpos[0], target)]
        scalars = xp.stack([ways[0], data.qvel[0] / self.speed, ways[1]])
        return xp.clip(xp.concatenate([scalars, 2 * fluid.pressures / SUPPLY - 1]), -1.0, 1.0)

    def reward(self, episode: Episode, _: Numbers) -> Numbers:
        """Negative scaled error of the position of an `episode` [-]."""
        return -absolute(episode.data.qpos[0] - episode.goal) / self.reach

    def measure(self, episode: Episode) -> dict[str, Numbers]:
        """What is measured in an `episode` [SI], by name."""
        data, fluid, target = episode
        measured = {"position": data.qpos[0], "target": target, "pressures": fluid.pressures}
        return measured | {"forces": -data.actuator_force, "air": fluid.consumption}


def box(low: float, high: float, count: int) -> Box:
    """Space of so many numbers from `low` to `high` [-]."""
    return Box(low, high, (count,), np.float32)


def check_action(action: Numbers, shape: tuple[int, ...]) -> np.ndarray:
    """An `action` [-] as floats, limited to [-1, 1]; refused where it isn't finite or of another
    `shape`.
    """
    values = np.asarray(action, float)
    if values.shape != shape or not np.isfinite(values).all():
        rule, bad = f"must be finite numbers of the shape {shape}", values[~np.isfinite(values)]
        text = f"{bad[0]}" if bad.size else f"the shape {values.shape}"
        raise InvalidInputError("action", rule, None, shown=text)
    return np.clip(values, -1.0, 1.0)


class Environment(gymnasium.Env):
    """A load on bundles with valves.

    An observation is the coordinate, its rate, the target, and each unit's pressure, all scaled to
    [-1, 1]. With each comes what is measured: `position` and `target` [SI], `pressures` of the
    units [Pa], `forces` of the bundles, which pull [N], and the `air` drawn in the episode [kg].
    """

    metadata: ClassVar[dict] = {
        "render_modes": ["rgb_array", "human"],
        "render_fps": 100,
    }
    task: ClassVar[EnvironmentTask]
    _view: Any = None  # MuJoCo's viewer or renderer, once it is used

    def __init__(self, render_mode: str | None = None):
        """`render_mode`: "rgb_array" for `render`, "human" for MuJoCo's viewer; or `None`."""
        if render_mode is not None:
            check_choice(render_mode, self.metadata["render_modes"], "render_mode")
        self.render_mode = render_mode
        self.model, self.drive = self.task.compile()
        self.observation_space = box(-1.0, 1.0, 3 + self.drive.units)
        self.action_space = box(-1.0, 1.0, self.drive.units)
        self.data = mujoco.MjData(self.model)
        self.target: Numbers = self.task.middle
        self.fluid = self.drive.start(self.model, self.data)

    @cached_property
    def _act(self) -> Callable:
        # compiled code would wait for ever for JAX's threads, which a forked process lacks
        return self.drive.act if forked() else jax.jit(self.drive.act)

    def __getstate__(self) -> dict:  # without what another process makes anew
        return {name: value for name, value in vars(self).items() if name not in {"_act", "_view"}}

    def reset(
        self, *, seed: int | None = None, options: dict | None = None
    ) -> tuple[np.ndarray, dict]:
        """Start an episode: `seed` of the target; `options` don't count. Returns the observation,
        and what is measured [SI].
        """
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:], self.target = self.task.begin(self.np_random)
        self.fluid = self.drive.start(self.model, self.data, START)
        return self._results()[:2]

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        """One step of 10 ms with valves open by a finite `action` [-]: observation, reward, true if
        a muscle left its table, which ends the episode, false for a time limit, which is a
        wrapper's, and what is measured [SI].
        """
        command = check_action(action, self.action_space.shape or ())
        for _ in range(FRAMES):
            self.fluid = self.drive.step(self.model, self.data, self.fluid, command, self._act)
        observation, info, reward = self._results()
        return observation, reward, not bool(self.fluid.inside), False, info

    def _results(self) -> tuple[np.ndarray, dict, float]:
        """Observation [-], what is measured [SI], and reward [-]; draws the window of "human"."""
        if self.render_mode == "human":
            self.render()
        fluid = Fluid(*(np.asarray(x)[()] for x in self.fluid))  # NumPy's, also of a compiled step
        now, task = Episode(self.data, fluid, self.target), self.task
        row = task.observe(now).astype(np.float32)
        return row, task.measure(now), float(task.reward(now, None))

    def render(self) -> Any:
        """Draw the scene: an image of 480 × 640 by "rgb_array", MuJoCo's viewer by "human"."""
        if self.render_mode is None:
            return None
        if self._view is None:
            self._view = self._open_view()
        if self.render_mode == "human":
            self._view.user_scn.ngeom = 0
            self._draw_target(self._view.user_scn)
            return self._view.sync()
        self._view.update_scene(self.data, camera="side")
        self._draw_target(self._view.scene)
        return self._view.render()

    def _draw_target(self, scene: Any) -> None:
        """Add the body at its target to a `scene`, in green."""
        goal = mujoco.MjData(self.model)
        goal.qpos[0] = self.target
        mujoco.mj_kinematics(self.model, goal)
        kind, size = self.model.geom_type[0], self.model.geom_size[0]
        color = np.array([0.1, 0.6, 0.2, 0.4], np.float32)
        geom = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(geom, kind, size, goal.geom_xpos[0], goal.geom_xmat[0], color)
        scene.ngeom += 1

    def _open_view(self) -> Any:
        """MuJoCo's renderer or viewer, by the mode."""
        if self.render_mode == "human":
            if sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ):
                # MuJoCo's viewer would end the process
                raise RuntimeError("render_mode 'human' needs a display: there is none.")
            viewer = importlib.import_module("mujoco.viewer")
            return viewer.launch_passive(self.model, self.data)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of GLFW without a display: the error says it
                return mujoco.Renderer(self.model, height=480, width=640)
        except (mujoco.FatalError, RuntimeError, ImportError, AttributeError) as error:
            remedy = f"set MUJOCO_GL=egl (or osmesa) before MuJoCo is imported ({error})"
            raise RuntimeError(f"render_mode 'rgb_array' needs OpenGL: {remedy}.") from error

    def close(self) -> None:
        """Close the window."""
        if self._view is not None:
            self._view.close()
            self._view = None


class AntagonisticJoint(Environment):
    """A forearm of 0.5 kg that two muscles turn against each other: to an angle [rad]."""

    task = EnvironmentTask(_JOINT, 0.0127, (1,), 0.0, 1.2, 10.0, -0.6, 0.6)


class HangingMass(Environment):
    """A mass of 5 kg on a bundle of one and four muscles: to a height [m]."""

    task = EnvironmentTask(_MASS, 0.0, (1, 4), 0.016, 0.024, 0.5, 0.005, 0.025)


@dataclass
class Proportional:
    """Baseline policy: a PI controller of the position with damping sets pressures for the valves.

    `proportional`, `integral` [1/s] and `damping`: of the scaled error and speed, to pressures in
    halves of the supply's; `signs`: of each unit [-]; `total`: the integral [-].
    """

    proportional: float
    integral: float
    damping: float
    signs: tuple[float, ...]
    total: float = 0.0

    def begin(self) -> None:
        """Reset the integral."""
        self.total = 0.0

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """Action for an `observation` [-]; the integral stops while its target is out of range."""
        error, speed = float(observation[2] - observation[0]), float(observation[1])
        target = self.proportional * error + self.total - self.damping * speed
        if abs(target) < 1.0:
            self.total += self.integral * _STEP * error
        pressures = np.clip(np.array(self.signs) * target, -1.0, 1.0)
        return np.clip(_OPENING * (pressures - observation[3:]), -1.0, 1.0).astype(np.float32)


BASELINES = {  # tuned by hand: what a learned policy should beat
    "fascicle/AntagonisticJoint-v0": Proportional(0.2, 12.0, 0.6, (1.0, -1.0)),
    "fascicle/HangingMass-v0": Proportional(0.2, 12.0, 0.07, (1.0, 1.0)),
}


def score(environment: Any, policy: Any, seeds: range) -> float:
    """Mean reward of a step [-] in episodes of an `environment`, one for each of the `seeds`, with
    a `policy` from observations to actions, whose `begin` is called before each episode.
    """
    rewards = []
    for seed in seeds:
        observation, _ = environment.reset(seed=seed)
        getattr(policy, "begin", lambda: None)()
        done = False
        while not done:
            observation, reward, terminated, truncated, _ = environment.step(policy(observation))
            rewards.append(reward)
            done = terminated or truncated
    return float(np.mean(rewards))

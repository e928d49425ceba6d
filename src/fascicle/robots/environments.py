"""Two environments of Gymnasium: a joint between two muscles, and a mass that hangs on a bundle.

Actions open valves; observations and actions lie in [-1, 1]. The reward of a step of 10 ms is the
negative error, so that 0 is best. A target is constant in an episode of 2 s. The muscles are those
of Fig. 6 of the paper; valves and loads are made up.

Environments in forked processes, as those of `make_vec(…, vectorization_mode="async")`, compute
with NumPy, half as fast; with `vector_kwargs={"context": "spawn"}` they compile.

**Source:** of the muscles, Kim, Mazzoleni and Bryant (2021); Towers et al. (2024) for Gymnasium.
"""

from typing import Any, ClassVar, NamedTuple

import gymnasium
import jax
import numpy as np
from gymnasium.spaces import Box

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..fluid import ConstantSupply, Isothermal, SonicValve
from ..muscle import Muscle
from . import forked
from .attach import attach
from .drive import Drive
from .optional_imports import mujoco


SUPPLY = 413.7e3  # Pa
_FRAMES = 10  # MuJoCo's steps of 1 ms in one of the environment
_STEP = 0.01  # s, of the environment
# a pendulum with two tendons, and a mass on one
_JOINT = """<mujoco><compiler angle="radian"/>
<option timestep="0.001"><flag contact="disable"/></option>
<worldbody><body><joint name="moved" type="hinge" axis="0 -1 0" range="-1.2 1.2" limited="true"
 damping="0.05"/><geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.5"/></body>
</worldbody><tendon><fixed name="flexor"><joint joint="moved" coef="-0.02"/></fixed>
<fixed name="extensor"><joint joint="moved" coef="0.02"/></fixed></tendon></mujoco>"""
_MASS = """<mujoco><option timestep="0.001"><flag contact="disable"/></option>
<worldbody><body><joint name="moved" type="slide" axis="0 0 1" range="-0.008 0.04" limited="true"
 damping="20"/><geom size="0.05" mass="5"/></body></worldbody>
<tendon><fixed name="cord"><joint joint="moved" coef="-1"/></fixed></tendon></mujoco>"""


class Task(NamedTuple):
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


class Environment(gymnasium.Env):
    """A load on bundles with valves.

    An observation is the coordinate, its rate, the target, and each unit's pressure, all scaled to
    [-1, 1].
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": [], "render_fps": 100}
    task: ClassVar[Task]

    def __init__(self, render_mode: str | None = None):
        """`render_mode` must be `None`."""
        if render_mode is not None:
            raise InvalidInputError(
                "render_mode", "must be None", render_mode, "MuJoCo's viewer draws it"
            )
        self.render_mode = None
        spec = mujoco.MjSpec.from_string(self.task.model)
        muscle = Muscle(0.127, 6.35e-3, 1.6e-3, np.deg2rad(33.0), "silicone_kim2021")
        bundle = Bundle([MotorUnit(muscle, count) for count in self.task.counts], SUPPLY)
        attached = [
            attach(spec, tendon.name, bundle, self.task.contraction) for tendon in spec.tendons
        ]
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.drive = Drive.of(
            self.model, attached, ConstantSupply(SUPPLY), Isothermal(dead_volume=2e-6),
            SonicValve(5e-10, 0.3), shape=(65, 81),
        )  # fmt: skip
        # compiled code would wait for ever for JAX's threads, which a forked process lacks
        self._act = self.drive.act if forked() else jax.jit(self.drive.act)
        units = self.drive.units
        self.action_space = Box(-1.0, 1.0, (units,), np.float32)
        self.observation_space = Box(-1.0, 1.0, (3 + units,), np.float32)
        self.target = self.task.middle
        self.fluid = self.drive.start(self.model, self.data)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode: `seed` of the target; `options` don't count.

        **Returns:** the observation, and position and target [SI].
        """
        super().reset(seed=seed)
        del options
        mujoco.mj_resetData(self.model, self.data)
        self.target = float(self.np_random.uniform(self.task.low, self.task.high))
        self.fluid = self.drive.start(self.model, self.data, 0.3 * SUPPLY)
        return self._observation(), self._info()

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """One step of 10 ms with valves open by an `action` [-].

        **Returns:** observation, reward, true if a muscle left its table, which ends the episode,
        false for a time limit, which is a wrapper's, and position and target [SI].
        """
        command = np.clip(np.asarray(action, float), -1.0, 1.0)
        terminated = False
        try:
            for _ in range(_FRAMES):
                self.fluid = self.drive.step(self.model, self.data, self.fluid, command, self._act)
        except InvalidInputError:
            terminated = True
        error = abs(float(self.data.qpos[0]) - self.target) / self.task.reach
        return self._observation(), -error, terminated, False, self._info()

    def _observation(self) -> np.ndarray:
        """Position, speed, target and units' pressures, each scaled to [-1, 1]."""
        task = self.task
        position, speed = float(self.data.qpos[0]), float(self.data.qvel[0])
        observation = [(position - task.middle) / task.reach, speed / task.speed,
                (self.target - task.middle) / task.reach,
                *(2 * np.asarray(self.fluid.pressures) / SUPPLY - 1)]  # fmt: skip
        return np.clip(observation, -1.0, 1.0).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        return {"position": float(self.data.qpos[0]), "target": self.target}


class AntagonisticJoint(Environment):
    """A forearm of 0.5 kg that two muscles turn against each other: to an angle [rad]."""

    task = Task(_JOINT, 0.0127, (1,), 0.0, 1.2, 10.0, -0.6, 0.6)


class HangingMass(Environment):
    """A mass of 5 kg on a bundle of one and four muscles: to a height [m]."""

    task = Task(_MASS, 0.0, (1, 4), 0.016, 0.024, 0.5, 0.005, 0.025)


class Proportional:
    """Baseline policy: a PI controller of the position with damping sets pressures for the valves.

    `proportional`, `integral` [1/s] and `damping`: of the scaled error and speed, to pressures in
    halves of the supply's about a `bias` [-]; `signs`: of each unit [-]; `valve`: opening for a
    pressure error of half the supply [-].
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        damping: float,
        signs: tuple[float, ...],
        bias: float = 0.0,
        valve: float = 4.0,
    ):
        """Arguments are described by the class."""
        self.gains = proportional, integral, damping
        self.signs = np.array(signs)
        self.bias, self.valve = bias, valve
        self.total = 0.0

    def begin(self) -> None:
        """Reset the integral."""
        self.total = 0.0

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """Action for an `observation` [-]; the integral stops while its target is out of range."""
        k_p, k_i, k_d = self.gains
        error = float(observation[2] - observation[0])
        target = k_p * error + self.total - k_d * float(observation[1])
        if abs(target) < 1.0:
            self.total += k_i * _STEP * error
        pressures = np.clip(self.bias + self.signs * target, -1.0, 1.0)
        return np.clip(self.valve * (pressures - observation[3:]), -1.0, 1.0).astype(np.float32)


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

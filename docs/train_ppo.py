"""Train a policy of the joint between two muscles by PPO of Stable-Baselines3, against the PI.

Environments step together in one process. The score is that of `fascicle.robots.environments`, on
20 episodes that were not used in training.

pip install stable-baselines3
python docs/train_ppo.py docs/_static/ppo.json
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv

from fascicle.robots.environments import BASELINES, score


NAME = "fascicle/AntagonisticJoint-v0"
ENVIRONMENTS, STEPS, TOTAL = 64, 50, 960_000
EPISODES = range(1000, 1020)


class VectorAdapter(VecEnv):
    """A vector of Gymnasium's as one of Stable-Baselines3, which begins anew in the same step."""

    def __init__(self, vector: Any):
        self.vector = vector
        super().__init__(
            vector.num_envs, vector.single_observation_space, vector.single_action_space
        )

    def reset(self) -> np.ndarray:
        return self.vector.reset(seed=0)[0]

    def step_async(self, actions: np.ndarray) -> None:
        self.actions = actions

    def step_wait(self) -> tuple:
        observations, rewards, terminated, truncated, _ = self.vector.step(self.actions)
        done = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in done]
        if done.any():  # all at once: no muscle leaves its table here
            for i in np.flatnonzero(done):
                infos[i] = {
                    "terminal_observation": observations[i],
                    "TimeLimit.truncated": truncated[i],
                }
            observations = self.vector.step(self.actions)[0]
        return observations, rewards, done, infos

    def close(self) -> None:
        self.vector.close()

    def get_attr(self, name: str, indices: Any = None) -> list:  # noqa: ARG002 its interface
        return [getattr(self.vector, name, None)] * self.num_envs

    def set_attr(self, name: str, value: Any, indices: Any = None) -> None:  # noqa: ARG002
        setattr(self.vector, name, value)

    def env_method(self, name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list:  # noqa: ARG002
        return [getattr(self.vector, name)(*args, **kwargs)]

    def env_is_wrapped(self, kind: Any, indices: Any = None) -> list[bool]:  # noqa: ARG002
        return [False] * self.num_envs


def main(path: Path) -> None:
    vector = VectorAdapter(gymnasium.make_vec(NAME, num_envs=ENVIRONMENTS))
    vector.reset()
    vector.vector.step(np.zeros((ENVIRONMENTS, 2), np.float32))  # compiles
    model = PPO(
        "MlpPolicy", vector, n_steps=STEPS, batch_size=800, n_epochs=8, gamma=0.97, gae_lambda=0.95,
        learning_rate=lambda remaining: 1e-3 * remaining, seed=0, device="cpu",
        policy_kwargs={"log_std_init": -0.7},
    )  # fmt: skip
    start = time.perf_counter()
    model.learn(TOTAL)
    seconds = time.perf_counter() - start
    environment = gymnasium.make(NAME)
    rows = [
        [score(environment, policy, range(seed, seed + 1)) for seed in EPISODES]
        for policy in (
            lambda observation: model.predict(observation, deterministic=True)[0],
            BASELINES[NAME],
        )
    ]
    learned, baseline = np.array(rows)
    result = {
        "seconds": round(seconds),
        "steps": int(model.num_timesteps),
        "learned": float(learned.mean()),
        "baseline": float(baseline.mean()),
        "better": int(np.sum(learned > baseline)),
        "episodes": len(EPISODES),
    }
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    sys.stdout.write(json.dumps(result) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""Train a policy of the joint between two muscles by CMA-ES of the library `cma`, against the PI.

A network of 5 inputs, 6 hidden units and 1 output opens one valve; mirrored, it opens the other.
All candidates of a generation move at once, each to the same 20 targets. The score is that of
`fascicle.robots.environments`, on 20 episodes that were not used in training.

pip install cma
python docs/train_cma.py 1 docs/_static/cma_1.json
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import cma
import gymnasium
import numpy as np

from fascicle.robots.environments import BASELINES, score


NAME = "fascicle/AntagonisticJoint-v0"
HIDDEN, CANDIDATES, GENERATIONS, STEPS = 6, 24, 80, 200
TRAINING, EPISODES = range(20), range(1000, 1020)
_WEIGHTS = 7 * HIDDEN + 1
_MIRROR = np.array([-1.0, -1.0, -1.0, 1.0, 1.0])  # of angle, rate and target


def act(weights: np.ndarray, observations: np.ndarray) -> np.ndarray:
    """Openings of both valves [-]: one network, or one for each observation."""
    inner = weights[..., : 5 * HIDDEN].reshape((*weights.shape[:-1], 5, HIDDEN))
    bias, outer = weights[..., 5 * HIDDEN : 6 * HIDDEN], weights[..., 6 * HIDDEN : 7 * HIDDEN]

    def valve(x: np.ndarray) -> np.ndarray:
        hidden = np.tanh((x[..., None, :] @ inner)[..., 0, :] + bias)
        return np.sum(hidden * outer, axis=-1) + weights[..., -1]

    x = observations.astype(float)
    openings = [valve(x), valve(_MIRROR * x[..., [0, 1, 2, 4, 3]])]
    return np.clip(np.stack(openings, axis=-1), -1.0, 1.0).astype(np.float32)


def generation_scores(many: Any, candidates: np.ndarray) -> np.ndarray:
    """Mean reward of each of the `candidates` over the training's targets [-]."""
    weights = np.repeat(candidates, len(TRAINING), axis=0)
    observations, _ = many.reset(seed=[*TRAINING] * len(candidates))
    total = np.zeros(len(weights))
    for _ in range(STEPS):
        observations, rewards, terminated, _, _ = many.step(act(weights, observations))
        total += np.where(terminated, -1.0, rewards)
    return total.reshape(len(candidates), -1).mean(axis=1) / STEPS


def main(seed: int, path: Path) -> None:
    many = gymnasium.make_vec(NAME, num_envs=CANDIDATES * len(TRAINING))
    search = cma.CMAEvolutionStrategy(
        np.zeros(_WEIGHTS), 0.5, {"popsize": CANDIDATES, "seed": seed, "verbose": -9}
    )
    start, cpu = time.perf_counter(), time.process_time()
    for _ in range(GENERATIONS):
        candidates = search.ask()
        search.tell(candidates, -generation_scores(many, np.array(candidates)))
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    weights, environment = search.mean, gymnasium.make(NAME)
    policies = (lambda observation: act(weights, observation)), BASELINES[NAME]
    learned, baseline = np.array(
        [[score(environment, p, range(i, i + 1)) for i in EPISODES] for p in policies]
    )
    result = {
        "seconds": round(seconds),
        "cpu_seconds": round(cpu),
        "steps": GENERATIONS * many.num_envs * STEPS,
        "learned": float(learned.mean()),
        "baseline": float(baseline.mean()),
        "better": int(np.sum(learned > baseline)),
        "episodes": len(EPISODES),
        "policy": weights.tolist(),
    }
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    sys.stdout.write(json.dumps(result) + "\n")


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))

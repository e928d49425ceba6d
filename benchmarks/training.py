"""Learning to move the joint between two muscles, by the cross-entropy method, against a PI.

A linear policy, the same for both valves but mirrored, of the error, the rate, both pressures and
a constant: five numbers, from nothing. Nine generations of 14, each with the same three episodes of
2 s, the best quarter kept; seeded. What is scored are 20 episodes of other seeds: the mean error of
all steps, in shares of the joint's reach, taken off.

    python benchmarks/training.py           # also writes docs/_static/training.json
"""

import json
import time
from pathlib import Path

import gymnasium
import numpy as np
from timing import Measured, Row, run

from fascicle.robots.environments import BASELINES, score


NAME = "fascicle/AntagonisticJoint-v0"
KEPT = Path(__file__).parents[1] / "docs" / "_static" / "training.json"
EPISODES = range(1000, 1020)


def policy(numbers: np.ndarray):
    def act(seen: np.ndarray) -> np.ndarray:
        angle, rate, target, *own = (float(x) for x in seen)
        error = target - angle
        flexor = numbers @ [error, rate, own[0], own[1], 1.0]
        extensor = numbers @ [-error, -rate, own[1], own[0], 1.0]
        return np.clip([flexor, extensor], -1.0, 1.0).astype(np.float32)

    return act


def trained(environment: gymnasium.Env, generations: int, many: int, seed: int = 0):
    rng = np.random.default_rng(seed)
    mean, spread, told = np.zeros(5), np.ones(5), []
    for _ in range(generations):
        tried = mean + spread * rng.normal(size=(many, 5))
        scores = np.array([score(environment, policy(one), range(3)) for one in tried])
        best = tried[np.argsort(scores)[-max(2, many // 4) :]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
        told.append(float(scores.max()))
    return mean, told


def rows(small: bool = False) -> list[Row]:
    environment = gymnasium.make(NAME)
    generations, many, episodes = (1, 2, range(2)) if small else (9, 14, EPISODES)
    begun = time.perf_counter()
    numbers, told = trained(environment, generations, many)
    took = time.perf_counter() - begun
    found = {
        "learned": score(environment, policy(numbers), episodes),
        "baseline": score(environment, BASELINES[NAME], episodes),
        "still": score(environment, lambda _: np.zeros(2, np.float32), episodes),
        "seconds": took,
        "generations": told,
        "policy": numbers.tolist(),
    }
    if not small:
        KEPT.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    share = found["learned"] / found["baseline"]
    limit = f"errors of {-found['learned']:.3f} and {-found['baseline']:.3f} of the reach"
    return [
        Row("a learned policy's mean error", Measured(share, share, share), "×", "the PI's",
            1.0, "≤", limit),
        Row("learning it", Measured(took, took, took), "s", limit="one core, seeded"),
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)

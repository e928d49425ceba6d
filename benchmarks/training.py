"""Learning to move the joint between two muscles, by the cross-entropy method, against a PI.

A linear policy of what is seen, twelve numbers, from nothing: 12 generations of 24, each with two
episodes of 2 s, the best quarter kept; seeded. What is scored are 20 episodes of other seeds: the
mean error of all steps, in shares of the joint's reach, taken off.

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
    gain = numbers.reshape(2, 6)
    return lambda seen: np.clip(gain @ np.append(seen, 1.0), -1.0, 1.0).astype(np.float32)


def trained(environment: gymnasium.Env, generations: int, many: int, seed: int = 0):
    rng = np.random.default_rng(seed)
    mean, spread, told = np.zeros(12), np.ones(12), []
    for k in range(generations):
        tried = mean + spread * rng.normal(size=(many, 12))
        seeds = range(2 * k, 2 * k + 2)
        scores = np.array([score(environment, policy(one), seeds) for one in tried])
        best = tried[np.argsort(scores)[-max(2, many // 4) :]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
        told.append(float(scores.max()))
    return mean, told


def rows(small: bool = False) -> list[Row]:
    environment = gymnasium.make(NAME)
    generations, many, episodes = (1, 2, range(2)) if small else (12, 24, EPISODES)
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

"""Training of the joint between two muscles, by the cross-entropy method, compared with a PI.

A linear policy, the same for both valves but mirrored, of the error, the rate, both pressures and
a constant: five numbers. Nine generations of 14 policies, each with the same three episodes of 2 s;
the best quarter shapes the next generation. Seeded. The score is the mean error of 20 episodes of
other seeds, as a share of the joint's range.

    python benchmarks/training.py           # also writes docs/_static/training.json
"""

import json
import time
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np
from timing import Quartiles, Row, run

from fascicle.robots.environments import BASELINES, score


NAME = "fascicle/AntagonisticJoint-v0"
RESULTS = Path(__file__).parents[1] / "docs" / "_static" / "training.json"


def make_policy(weights: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Linear policy from observations to both valves' commands."""

    def act(observation: np.ndarray) -> np.ndarray:
        angle, rate, target, flexor, extensor, *_ = map(float, observation)
        error = target - angle
        commands = (weights @ [error, rate, flexor, extensor, 1.0],
                    weights @ [-error, -rate, extensor, flexor, 1.0])  # fmt: skip
        return np.clip(commands, -1.0, 1.0).astype(np.float32)

    return act


def train(
    environment: gymnasium.Env, generations: int, policies: int, seed: int = 0
) -> tuple[np.ndarray, list[float]]:
    """Weights of the policy, and the best score of each generation."""
    rng = np.random.default_rng(seed)
    mean, spread, best_scores = np.zeros(5), np.ones(5), []
    for _ in range(generations):
        weights = mean + spread * rng.normal(size=(policies, 5))
        scores = np.array([score(environment, make_policy(w), range(3)) for w in weights])
        best = weights[np.argsort(scores)[-max(2, policies // 4) :]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
        best_scores.append(float(scores.max()))
    return mean, best_scores


def rows(small: bool = False) -> list[Row]:
    """Mean error, and the time of training."""
    environment = gymnasium.make(NAME)
    generations, policies, episodes = (1, 2, range(2)) if small else (9, 14, range(1000, 1020))
    begin = time.perf_counter()
    weights, best_scores = train(environment, generations, policies)
    seconds = time.perf_counter() - begin
    learned = score(environment, make_policy(weights), episodes)
    baseline = score(environment, BASELINES[NAME], episodes)
    if not small:
        closed = score(environment, lambda _: np.zeros(2, np.float32), episodes)
        results = {
            "learned": learned, "baseline": baseline, "still": closed, "seconds": seconds,
            "generations": best_scores, "policy": weights.tolist(),
        }  # fmt: skip
        RESULTS.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    note = f"errors of {-learned:.3f} and {-baseline:.3f} of the range"
    return [
        Row("a learned policy's mean error", Quartiles.of([learned / baseline]), "×", "the PI's",
            at_most=1, note=note),
        Row("its training", Quartiles.of([seconds]), "s", note="one core, seeded"),
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)

"""Evaluation of designs for a task of 100 points: (design, task point) pairs a second.

Compositions of one muscle share its forces: 65,536 splits of twelve muscles, mean efficiency and
points not reached; the muscle's table is computed in every call. Unlike designs have four units
with muscles of their own.

    python benchmarks/design_evaluation.py
"""

import numpy as np
from cases import LENGTH, MAX_PRESSURE, make_muscle
from timing import Row, run, take_turns

from fascicle.design import Designs, Task, compositions, evaluate


OBJECTIVES = ("mean_efficiency", "not_reached")


def make_task(points: int) -> Task:
    """Random forces and strains."""
    random = np.random.default_rng(5)
    strain = random.uniform(0.01, 0.2, points)
    force = random.uniform(0.0, 2000.0, points) * (1 - strain / 0.25)
    return Task.of(force, strain, MAX_PRESSURE)


def unlike_designs(count: int, units: int = 4) -> Designs:
    """Designs whose units have different muscles."""
    random = np.random.default_rng(6)
    radius = random.uniform(4e-3, 8e-3, (count, units))
    return Designs(
        {"muscle": make_muscle()},
        np.zeros(count, int),
        random.integers(1, 5, (count, units)),
        np.full(count, LENGTH),
        radius,
        random.uniform(0.15, 0.3, (count, units)) * radius,
        np.radians(random.uniform(25.0, 38.0, (count, units))),
    )


def rows(small: bool = False) -> list[Row]:
    """Rates."""
    points, splits, unlike, parts = (10, 32, 8, 5) if small else (100, 65_536, 1024, 12)
    task, muscle = make_task(points), make_muscle()
    all_splits = compositions(parts)
    chosen = np.random.default_rng(7).integers(0, len(all_splits), splits)
    designs = {
        "compositions of one muscle": (Designs.of(muscle, all_splits[chosen]), 10),
        "unlike designs, 4 units": (unlike_designs(unlike), 0.1),
    }
    calls = {name: lambda d=d: evaluate(d, task, OBJECTIVES) for name, (d, _) in designs.items()}
    times = take_turns(calls, rounds=3 if small else 9, budget=60.0)
    return [
        Row(f"{name}: pairs", times.rate(name, count * points / 1e6), "million/s", at_least=goal)
        for (name, (_, goal)), count in zip(designs.items(), (splits, unlike), strict=True)
    ]


if __name__ == "__main__":
    run(rows, __doc__)

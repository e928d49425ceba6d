"""Designs judged for a task of 100 points: (design, task point) pairs a second.

Compositions of one muscle share its forces: 65 536 of the splits of twelve muscles, mean efficiency
and points not reached; the muscle's table is made anew in every call. Unlike designs have four
units with muscles of their own, on 33 throttled pressures each where none of these pulls. The force
law's own rate is that of the field of `force_field.py`, and the last rows are ratios to it.

    python benchmarks/designing.py
"""

import jax.numpy as jnp
import numpy as np
from cases import LARGEST_PRESSURE, LENGTH, done, field, muscle
from timing import Measured, Row, interleaved, run

from fascicle.design import Designs, Task, compositions, evaluate


NAMES = ("mean_efficiency", "not_reached")
ALIKE, UNLIKE = "compositions of one muscle", "unlike designs, 4 units"


def task(points: int) -> Task:
    random = np.random.default_rng(5)
    strain = random.uniform(0.01, 0.2, points)
    force = random.uniform(0.0, 2000.0, points) * (1 - strain / 0.25)
    return Task.of(force, strain, LARGEST_PRESSURE)


def unlike(count: int, units: int = 4) -> Designs:
    random = np.random.default_rng(6)
    radius = random.uniform(4e-3, 8e-3, (count, units))
    return Designs(
        {"muscle": muscle()},
        np.zeros(count, int),
        random.integers(1, 5, (count, units)),
        np.full(count, LENGTH),
        radius,
        random.uniform(0.15, 0.3, (count, units)) * radius,
        np.radians(random.uniform(25.0, 38.0, (count, units))),
    )


def rows(small: bool = False) -> list[Row]:
    points, alike, others, shape = (
        (10, 32, 8, (20, 30)) if small else (100, 65_536, 1024, (1000, 10_000))
    )
    demanded = task(points)
    every = compositions(5 if small else 12)
    chosen = np.random.default_rng(7).integers(0, len(every), alike)
    compositions_of_one = Designs.of(muscle(), every[chosen])
    unlike_ones = unlike(others)
    force, at = muscle().compile(), field(*shape)
    times = interleaved(
        {
            "law": lambda: done(jnp.asarray(force(*at))),
            "alike": lambda: evaluate(compositions_of_one, demanded, NAMES),
            "unlike": lambda: evaluate(unlike_ones, demanded, NAMES),
        },
        repeats=3 if small else 9,
        budget=60.0,
    )
    pairs = {"alike": alike * points, "unlike": others * points}
    law = shape[0] * shape[1]

    def rate(name: str) -> Measured:
        return Measured.of(pairs[name] / times.seconds[name] / 1e6)

    return [
        Row(f"{ALIKE}: pairs", rate("alike"), "million/s", "", 10.0),
        Row(f"{UNLIKE}: pairs", rate("unlike"), "million/s", "", 0.1),
        Row(f"{ALIKE}: pairs", times.ratio("law", "alike", pairs["alike"] / law), "×",
            "the force law's own rate"),
        Row(f"{UNLIKE}: pairs", times.ratio("law", "unlike", pairs["unlike"] / law), "×",
            "the force law's own rate", limit="4 forces and 4 pulls a pair"),
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)

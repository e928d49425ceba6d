"""The inverse: which pressures of which recruitment state give a force at a strain.

`fs.recruitment.recruit` for a bundle of 4 unlike motor units, demands that the bundle reaches and
some that it doesn't: 1e5 at once; one from Python, of whose calls one in a hundred takes longer
than what is told; and 64 at once, for each.

    python benchmarks/inverse.py
"""

import time

import jax
import numpy as np
from cases import LARGEST_PRESSURE, unlike_bundle
from timing import Measured, Row, interleaved, run

import fascicle as fs


UNITS = 4


def rows(small: bool = False) -> list[Row]:
    units, count, batch, calls = (2, 20, 4, 5) if small else (UNITS, 100_000, 64, 300)
    bundle = unlike_bundle(units)
    random = np.random.default_rng(4)
    strain = random.uniform(0.0, 0.25, count)
    largest = np.asarray(bundle.force(np.full(units, LARGEST_PRESSURE), strain))
    force = random.uniform(-0.02, 1.02, count) * largest

    def recruit(force: object, strain: object) -> object:
        return jax.block_until_ready(
            fs.recruitment.recruit(bundle, force, strain, LARGEST_PRESSURE).pressures
        )

    few = slice(0, batch)
    times = interleaved(
        {
            "all": lambda: recruit(force, strain),
            "batch": lambda: recruit(force[few], strain[few]),
        },
        repeats=3 if small else 15,
        budget=30.0,
    )
    points = list(zip(force[:calls].tolist(), strain[:calls].tolist(), strict=True))
    recruit(*points[0])
    slow = []
    for _ in range(1 if small else 3):
        spent = []
        for point in points:
            start = time.perf_counter()
            recruit(*point)
            spent.append(time.perf_counter() - start)
        slow.append(1e3 * float(np.percentile(spent, 99)))
    alone = f"{batch} at once take {times.median('batch') * 1e3:.2g} ms: steps, not numbers"
    name = f"inverse, bundle of {units} unlike units"
    return [
        Row(f"{name}: {count:,} demands", times.each("all"), "s", "", 8.0, "≤"),
        Row(f"{name}: one demand, p99", Measured.of(slow), "ms", "", 8.0, "≤", alone),
        Row(f"{name}: {batch} at once, each", times.each("batch", 1e6 / batch), "µs", "", 100, "≤"),
    ]


if __name__ == "__main__":
    run(rows, __doc__)

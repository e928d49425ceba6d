"""Bundles with NumPy: CPU time of recruitment and of efficiency maps.

`fs.recruitment.recruit` for 4 unlike motor units, at demands of which some exceed what the bundle
holds: one from Python, of which the 99th percentile counts, 64 at once, and 100,000 at once.
Efficiency maps of 81 forces × 121 strains, from bundle to arrays.

    python benchmarks/bundles.py
"""

import time

import numpy as np
from cases import MAX_PRESSURE, make_muscle, unlike_bundle
from timing import Quartiles, Row, run, take_turns

import fascicle as fs


def recruitment_rows(small: bool) -> list[Row]:
    """Pressures for demands."""
    units, count, batch, single = (2, 20, 4, 5) if small else (4, 100_000, 64, 300)
    bundle = unlike_bundle(units)
    random = np.random.default_rng(4)
    strain = random.uniform(0.0, 0.25, count)
    max_force = np.asarray(bundle.force(np.full(units, MAX_PRESSURE), strain))
    force = random.uniform(-0.02, 1.02, count) * max_force

    def recruit(index: int | slice) -> object:
        return fs.recruitment.recruit(bundle, force[index], strain[index], MAX_PRESSURE).pressures

    times = take_turns(
        {"batch": lambda: recruit(slice(batch)), "all": lambda: recruit(slice(None))},
        rounds=3 if small else 9,
        budget=30.0,
        clock=time.process_time,
    )
    percentiles = []
    for _ in range(1 if small else 3):
        seconds = []
        for i in range(single):
            begin = time.process_time()
            recruit(i)
            seconds.append(time.process_time() - begin)
        percentiles.append(1e3 * float(np.percentile(seconds, 99)))
    name = f"`recruit`, {units} unlike units"
    each = times.of("batch", 1e6 / batch)
    return [
        Row(f"{name}: one demand, 99th percentile", Quartiles.of(percentiles), "ms", at_most=8),
        Row(f"{name}: {batch} demands at once, each", each, "µs", at_most=100),
        Row(f"{name}: {count:,} demands", times.of("all"), "s", at_most=8),
    ]


def map_rows(small: bool) -> list[Row]:
    """Efficiency maps of equal units, as in the paper's Fig. 10, and of unlike ones."""
    units, shape = (2, (5, 7)) if small else (6, (81, 121))
    equal = fs.Bundle([fs.MotorUnit(make_muscle())] * units, supply_pressure=MAX_PRESSURE)
    strain = np.linspace(0.0, 0.3, shape[1] + 1)[1:]
    calls = {}
    for name, bundle in {"equal": equal, "unlike": unlike_bundle(units)}.items():
        max_force = float(bundle.force(np.full(units, MAX_PRESSURE), 0.0))
        force = np.linspace(0.0, max_force, shape[0])
        calls[name] = lambda bundle=bundle, force=force: fs.energetics.efficiency_map(
            bundle, force=force, strain=strain
        )
    times = take_turns(calls, clock=time.process_time)
    return [
        Row(f"efficiency map, {shape[0]} × {shape[1]} points, {units} {name} units",
            times.of(name, 1e3), "ms", at_most=50 if name == "equal" else None)
        for name in calls
    ]  # fmt: skip


def rows(small: bool = False) -> list[Row]:
    """Recruitment and efficiency maps."""
    return [*recruitment_rows(small), *map_rows(small)]


if __name__ == "__main__":
    run(rows, __doc__)

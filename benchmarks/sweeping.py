"""A sweep on one and two workers: its rate, and the parts of a block's time.

A study of unlike designs is swept by this process alone, then by one and by two Dask workers, each
after a first sweep that compiles. A block's time is that of computing it, of writing its chunks,
and the rest: sending it, receiving its report and noting it. Blocks of one design each are nearly
all overhead, and show what one block costs the process that sends them.

    python benchmarks/sweeping.py --json docs/_static/sweep.json
"""

import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from cases import MAX_PRESSURE, make_muscle
from timing import parse_options

from fascicle.design import Space, Task
from fascicle.design.cluster import local_client
from fascicle.design.sweep import BlockResult, Study, sweep


def make_study(block: int, lengths: int) -> Study:
    """A study in blocks of some designs."""
    space = Space(
        {"muscle": make_muscle()}, (4,), length=tuple(np.linspace(0.1, 0.16, lengths).tolist()),
        unit_factors=(1.0, 1.3), most_units=3,
    )  # fmt: skip
    strain = np.random.default_rng(5).uniform(0.01, 0.2, 100)
    task = Task.of(800 * (1 - strain / 0.25), strain, MAX_PRESSURE)
    return Study.of(space, task, {"mean_efficiency": "max", "not_reached": "min"}, block=block)


def time_sweep(study: Study, folder: Path, client: Any) -> dict[str, float]:
    """Duration [s] and rate of a sweep, and means over its blocks [s]."""
    blocks: list[BlockResult] = []

    def watch(progress: Any) -> None:
        if progress.last is not None:
            blocks.append(progress.last)

    begin = time.perf_counter()
    sweep(study, folder, client, watch=watch)
    seconds = time.perf_counter() - begin
    return {
        "designs": len(study.space),
        "blocks": study.blocks,
        "seconds": seconds,
        "rate": len(study.space) / seconds,
        "computing": float(np.mean([block.computing for block in blocks])),
        "writing": float(np.mean([block.writing for block in blocks])),
        "memory": max(block.memory for block in blocks),
        "workers": len({block.process for block in blocks}),
    }


def measure(small: bool) -> dict[str, Any]:
    """Figures of each sweep."""
    large = make_study(8 if small else 512, 4 if small else 200)
    tiny = make_study(1, 2 if small else 12)
    results: dict[str, Any] = {
        "points": len(large.task),
        "objectives": len(large.names),
        "load": os.getloadavg()[0],  # other programs take the second worker's core
    }

    def measure_client(name: str, client: Any) -> None:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            time_sweep(large, root / "first", client)  # compiles
            time_sweep(tiny, root / "first_tiny", client)
            results[name] = time_sweep(large, root / "large", client)
            results[f"{name}_tiny"] = time_sweep(tiny, root / "tiny", client)

    measure_client("alone", None)
    for workers in (1, 2):
        with local_client(workers) as client:
            measure_client(f"workers_{workers}", client)
    return results


if __name__ == "__main__":
    options = parse_options(__doc__)
    text = json.dumps(measure(options.small), indent=1)
    print(text)
    if options.json is not None:
        options.json.write_text(text + "\n")

"""A sweep on one and two workers: its rate, and where each block's time goes.

A study of unlike designs is swept by this process alone, then by one and by two Dask workers, each
after a first sweep that compiled. A block's time is that of computing it, of writing its chunks,
and the rest: what handing it out, fetching its report and noting it took. Then blocks of one
design each, which are nearly all overhead: what one block costs whoever hands them out.

    python benchmarks/sweeping.py --json docs/_static/sweep.json
"""

import argparse
import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from cases import LARGEST_PRESSURE, muscle

from fascicle.design import Space, Task
from fascicle.design.cluster import local_client
from fascicle.design.sweep import BlockResult, Study, sweep


def study(block: int, lengths: int, units: int = 3) -> Study:
    space = Space(
        {"muscle": muscle()}, (4,), length=tuple(np.linspace(0.1, 0.16, lengths).tolist()),
        unit_factors=(1.0, 1.3), most_units=units,
    )  # fmt: skip
    random = np.random.default_rng(5)
    strain = random.uniform(0.01, 0.2, 100)
    task = Task.of(800 * (1 - strain / 0.25), strain, LARGEST_PRESSURE)
    return Study.of(space, task, {"mean_efficiency": "max", "not_reached": "min"}, block=block)


def swept(given: Study, folder: Path, client: Any) -> dict[str, float]:
    """Means over the blocks of one sweep, in seconds."""
    blocks: list[BlockResult] = []

    def watch(now: Any) -> None:
        if now.last is not None:
            blocks.append(now.last)

    start = time.perf_counter()
    sweep(given, folder, client, watch=watch)
    total = time.perf_counter() - start
    return {
        "designs": len(given.space),
        "blocks": given.blocks,
        "seconds": total,
        "rate": len(given.space) / total,
        "computing": float(np.mean([one.computing for one in blocks])),
        "writing": float(np.mean([one.writing for one in blocks])),
        "memory": max(one.memory for one in blocks),
        "workers": len({one.process for one in blocks}),
    }


def measure(small: bool) -> dict[str, Any]:
    lengths = 4 if small else 200
    large, tiny = study(8 if small else 512, lengths), study(1, 2 if small else 12)
    found: dict[str, Any] = {
        "points": len(large.task),
        "objectives": len(large.names),
        "load": os.getloadavg()[0],  # what else runs takes the second worker's core
    }

    def both(name: str, client: Any) -> None:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            swept(large, root / "first", client)  # compiles
            swept(tiny, root / "tiny_first", client)
            found[name] = swept(large, root / "large", client)
            found[f"{name}_tiny"] = swept(tiny, root / "tiny", client)

    both("alone", None)
    for workers in (1, 2):
        with local_client(workers) as client:
            both(f"workers_{workers}", client)
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true", help="does it run? its times mean nothing")
    parser.add_argument("--json", type=Path, default=None, help="file for the figures")
    given = parser.parse_args()
    text = json.dumps(measure(given.small), indent=1)
    print(text)
    if given.json is not None:
        given.json.write_text(text + "\n")

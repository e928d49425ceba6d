"""What a process keeps: memory after many distinct lengths, and after many unlike bundles.

A process of its own asks one muscle for its force at 3000 distinct lengths of array, and 200
bundles that are all unlike for a free strain. What its resident memory has grown by since it
answered first is told.

    python benchmarks/growing.py
"""

import subprocess
import sys

from timing import Measured, Row, run


CODE = """
import math, sys
from pathlib import Path
import numpy as np
import fascicle as fs
lengths, bundles = map(int, sys.argv[1:])
def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096
muscle = fs.example("kim2021_figure_6")
muscle.force(1e5, 0.1)
begun = resident()
for n in range(1, lengths + 1):
    muscle.force(1e5, np.linspace(0, 0.3, n))
rng = np.random.default_rng(1)
for _ in range(bundles):
    units = [fs.MotorUnit(fs.Muscle.from_dimensions(
        0.127, rng.uniform(5e-3, 9e-3), 1.2e-3, math.radians(rng.uniform(22, 36))))
        for _ in range(rng.integers(2, 6))]
    fs.Bundle(units).free_strain(rng.uniform(0, 4e5, len(units)))
print(resident() - begun)
"""
REACH = 300.0  # MB


def rows(small: bool = False) -> list[Row]:
    """Growth of the resident memory."""
    lengths, bundles = (30, 3) if small else (3000, 200)
    ran = subprocess.run(  # noqa: S603 this package's own code
        [sys.executable, "-c", CODE, str(lengths), str(bundles)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    grown = Measured.of([max(int(ran.stdout), 1) / 1e6])
    name = f"memory kept after {lengths} lengths of array and {bundles} unlike bundles"
    return [Row(name, grown, "MB", "", REACH, "≤")]


if __name__ == "__main__":
    run(rows, __doc__)

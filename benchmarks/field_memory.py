"""The most memory that the force field takes, against its output.

A process of its own compiles the field, forgets its peak so far, evaluates once, and tells by
how much its resident memory grew at most, as the kernel counted it. Beside it what the
compiler says it will need: output and temporaries.

    python benchmarks/field_memory.py
"""

import subprocess
import sys
from pathlib import Path
from typing import Any

from timing import Measured, Row, run


SHAPE = (1000, 10_000)


def resident(line: str) -> int:
    """Resident memory [B] now, `VmRSS`, or at most, `VmHWM`."""
    for text in Path("/proc/self/status").read_text().splitlines():
        if text.startswith(line):
            return int(text.split()[1]) * 1024
    raise SystemExit(f"this system does not tell {line}")


def child(pressures: int, strains: int) -> None:
    """Print growth and what the compiler says, both in units of the output."""
    import jax
    from cases import done, field, muscle

    points = field(pressures, strains)
    force = jax.jit(muscle().compile()).lower(*points).compile()
    foretold: Any = force.memory_analysis()
    Path("/proc/self/clear_refs").write_text("5")  # forgets the peak
    before = resident("VmRSS")
    result = done(force(*points))
    growth = resident("VmHWM") - before
    said = foretold.output_size_in_bytes + foretold.temp_size_in_bytes
    print(growth / result.nbytes, said / result.nbytes)


def rows(small: bool = False) -> list[Row]:
    repeats, shape = (1, (100, 1000)) if small else (3, SHAPE)
    grown, said = [], []
    for _ in range(repeats):
        ran = subprocess.run(  # noqa: S603 this file itself
            [sys.executable, __file__, "--child", *map(str, shape)],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        growth, foretold = map(float, ran.stdout.split())
        grown.append(growth)
        said.append(foretold)
    return [
        Row(
            f"peak memory of the field, {shape[0]:,} × {shape[1]:,}",
            Measured.of(grown),
            "×",
            f"its output, {8 * shape[0] * shape[1] / 1e6:.0f} MB",
            3.0,
            "≤",
            f"the compiler's own count of output and temporaries: {said[0]:.2f}",
        )
    ]


if __name__ == "__main__":
    if "--child" in sys.argv:
        child(*map(int, sys.argv[2:]))
    else:
        run(rows, __doc__)

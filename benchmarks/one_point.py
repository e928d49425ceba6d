"""One point from Python: what a call costs, whatever it computes.

`muscle.force(P, eps)` with its checks, and the function that `muscle.compile()` gives, each
with two Python floats, until the result is there. Beside them the least that JAX takes: a
compiled `x + y` of two floats.

    python benchmarks/one_point.py
"""

from typing import Any

import jax
from cases import done, muscle
from timing import Row, interleaved, run


POINT = (200e3, 0.1)
IN_PYTHON = "checks and dispatch in Python: the compiled call is the next row"


def rows(small: bool = False) -> list[Row]:
    one, least = muscle(), jax.jit(lambda x, y: x + y)
    force: Any = one.compile()
    times = interleaved(
        {
            "least": lambda: done(least(*POINT)),
            "eager": lambda: done(one.force(*POINT)),
            "compiled": lambda: done(force(*POINT)),
        },
        repeats=5 if small else 200,
        least=0.0 if small else 2e-3,
    )
    # calls of compiled kernels, loops' bodies counted once
    steps = sum("fusion(" in line for line in force.lower(*POINT).compile().as_text().splitlines())
    many = f"{steps} kernels one after another, for one number"
    floor = f"x + y of two floats takes {times.median('least') * 1e6:.3g} µs"
    return [
        Row(
            "one point, `muscle.force`", times.each("eager", 1e6), "µs", floor, 80.0, "≤", IN_PYTHON
        ),
        Row(
            "one point, `muscle.compile()`",
            times.each("compiled", 1e6),
            "µs",
            floor,
            15.0,
            "≤",
            many,
        ),
    ]


if __name__ == "__main__":
    run(rows, __doc__)

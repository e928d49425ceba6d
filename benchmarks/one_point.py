"""One point from Python: what a call costs, whatever it computes.

`muscle.force(P, eps)` with its checks, and the function that `muscle.compile()` gives, each
with two Python floats, until the result is there; it has been asked often, so that its law is
spelled out. Beside them the law on NumPy's numbers, by which the first points are answered, without
a check, and the least that JAX takes: a compiled `x + y` of two floats.

    python benchmarks/one_point.py
"""

from typing import Any

import jax
import numpy as np
from cases import done, muscle
from timing import Row, interleaved, run

import fascicle as fs


POINT = (200e3, 0.1)
IN_PYTHON = "checks in Python, and two searches"


def at_numbers(muscle: fs.Muscle, pressure: Any, strain: Any) -> Any:
    with np.errstate(all="ignore"):  # of branches that aren't taken
        return muscle.law.at(pressure).force(strain)


def rows(small: bool = False) -> list[Row]:
    one, least = muscle(), jax.jit(lambda x, y: x + y)
    numbers = tuple(map(np.float64, POINT))
    for _ in range(100):
        one.force(*POINT)
    force: Any = one.compile()
    times = interleaved(
        {
            "least": lambda: done(least(*POINT)),
            "eager": lambda: one.force(*POINT),
            "numpy": lambda: at_numbers(one, *numbers),
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
        Row("one point, the law on NumPy's numbers", times.each("numpy", 1e6), "µs"),
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

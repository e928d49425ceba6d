"""Force at one point: CPU time of a call from Python.

`muscle.force` with NumPy, and the functions of `muscle.compile`, each with two Python floats, until
the result is there. Floors: `x + y` of two floats as a compiled function of JAX, and as a call of
NumPy.

    python benchmarks/one_point.py
"""

import time

import jax
import numpy as np
from cases import make_muscle, wait
from timing import Row, run, take_turns

from fascicle.export.point_function import compile_muscle_force


POINT = (200e3, 0.1)  # Pa, -


def rows(small: bool = False) -> list[Row]:
    """CPU microseconds of a call."""
    muscle, x = make_muscle(), np.float64(1.0)
    casadi, compiled = muscle.compile(backend="casadi"), muscle.compile(backend="jax")
    force = compile_muscle_force(muscle)
    count = len(force.with_gradient(*POINT)[1])
    add = jax.jit(lambda x, y: x + y)
    times = take_turns(
        {
            "x + y, NumPy": lambda: np.add(x, x),
            "x + y, JAX": lambda: wait(add(*POINT)),
            "numpy": lambda: muscle.force(*POINT),
            "casadi": lambda: casadi(*POINT),
            "gradient": lambda: force.with_gradient(*POINT),
            "jax": lambda: wait(compiled(*POINT)),
        },
        rounds=5 if small else 200,
        loops=2 if small else 20,
        clock=time.process_time,
    )
    numpy, jit = (f"x + y, {times.median(f'x + y, {library}') * 1e6:.2g} µs"
                  for library in ("NumPy", "JAX"))  # fmt: skip
    gradient = f"one point, force and its {count} derivatives, CasADi"
    compile_jax = 'one point, `muscle.compile(backend="jax")`'
    compile_casadi = 'one point, `muscle.compile(backend="casadi")`'
    return [
        Row("one point, `muscle.force`, NumPy", times.of("numpy", 1e6), "µs", numpy, at_most=500),
        Row(compile_casadi, times.of("casadi", 1e6), "µs", at_most=30),
        Row(gradient, times.of("gradient", 1e6), "µs", at_most=60),
        Row(compile_jax, times.of("jax", 1e6), "µs", jit),
    ]


if __name__ == "__main__":
    run(rows, __doc__)

"""The force field against the cost of only moving its numbers through memory.

`muscle.compile()` over 1000 pressures × 10 000 strains, all regions of the law within; beside
it `x + 1` and `exp` over as many float64 values. A ratio of 1 is the speed of memory. Each
call writes into new memory, the floors' too, as results of JAX do; what that costs is told by
NumPy's `x + 1` into memory that it already has.

    python benchmarks/force_field.py
"""

import jax.numpy as jnp
import numpy as np
from cases import done, exponential, field, muscle, stream
from timing import Row, interleaved, run


def rows(small: bool = False) -> list[Row]:
    shape = (20, 30) if small else (1000, 10_000)
    force, points = muscle().compile(), field(*shape)
    as_many = jnp.broadcast_to(points[1], shape) + 0.0
    values, kept = np.array(as_many), np.zeros(shape)
    times = interleaved(
        {
            "in place": lambda: np.add(values, 1, out=kept),
            "x + 1": lambda: done(stream(as_many)),
            "exp": lambda: done(exponential(as_many)),
            "field": lambda: done(force(*points)),
        }
    )
    name = f"force field, {shape[0]:,} pressures × {shape[1]:,} strains"
    rate = shape[0] * shape[1] / times.median("field") / 1e6
    passes = times.median("field") / times.median("x + 1")
    limit = f"{rate:.0f} million points/s, as long as {passes:.1f} passes of x + 1"
    return [
        Row(name, times.ratio("x + 1", "field"), "×", "rate of x + 1", 0.6, limit=limit),
        Row(name, times.ratio("exp", "field"), "×", "rate of exp"),
        Row(
            "the floor x + 1 itself",
            times.ratio("in place", "x + 1"),
            "×",
            "rate of NumPy's x + 1, one core, into memory it has",
        ),
    ]


if __name__ == "__main__":
    run(rows, __doc__)

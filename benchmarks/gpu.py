"""A GPU, if one is at hand: the field against streaming there, and a million muscles.

The field is that of `force_field.py`. The million different muscles have 1000 strains each at one
pressure of their own, in blocks of 100 000 muscles; their rate is held against the field's.
Without a GPU the rows say so. Run on the machine that has one, the rows are kept beside this
file, and the table takes them from there:

    python benchmarks/gpu.py --json benchmarks/gpu.json
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from cases import LARGEST_STRAIN, done, field, muscle, scattered, stream, unlike_muscles
from timing import Row, interleaved, run


FIELD, MUSCLES = "GPU: force field", "GPU: different muscles × 1000 points"


def rows(small: bool = False) -> list[Row]:
    device = jax.devices()[0]
    if device.platform != "gpu":
        missing = "no GPU in this run"
        return [
            Row(FIELD, None, "×", "rate of x + 1 there", 0.2, limit=missing),
            Row(MUSCLES, None, "×", "the field's rate there", 0.5, limit=missing),
        ]
    shape, count, block, strains = (
        ((20, 30), 20, 10, 30) if small else ((1000, 10_000), 1_000_000, 100_000, 1000)
    )
    known, points = muscle().compile(), field(*shape)
    as_many = jnp.broadcast_to(points[1], shape) + 0.0
    many = unlike_muscles(count)
    pressure = scattered(count)[0][:, None]
    along = jnp.linspace(0.0, LARGEST_STRAIN, strains)
    force = eqx.filter_jit(lambda muscle, P, eps: muscle.force(P, eps))

    def part(i: int) -> tuple[Any, Any]:
        # sizes are columns; what the muscles share is a single number
        return jax.tree.map(
            lambda leaf: leaf[i : i + block] if jnp.shape(leaf)[:1] == (count,) else leaf,
            (many, pressure),
        )

    parts = [part(i) for i in range(0, count, block)]
    times = interleaved(
        {
            "x + 1": lambda: done(stream(as_many)),
            "field": lambda: done(known(*points)),
            "muscles": lambda: [done(force(*one, along)) for one in parts],
        }
    )
    where = f"on {device.device_kind}"
    rate = shape[0] * shape[1] / times.median("field") / 1e9
    more = count * strains / (shape[0] * shape[1])
    return [
        Row(
            f"{FIELD}, {shape[0]:,} × {shape[1]:,}",
            times.ratio("x + 1", "field"),
            "×",
            f"rate of x + 1, {where}",
            0.2,
            limit=f"{rate:.3g} thousand million points/s",
        ),
        Row(
            f"{MUSCLES}, {count:,} of them",
            times.ratio("field", "muscles", more),
            "×",
            f"the field's rate, {where}",
            0.5,
        ),
    ]


if __name__ == "__main__":
    run(rows, __doc__)

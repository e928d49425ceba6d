"""A GPU: the field against `x + 1` there, and a million different muscles.

The field is that of `jax_arrays.py`. The million muscles have 1000 strains each at one pressure of
their own, in blocks of 100,000 muscles; their rate is compared with the field's.

    python benchmarks/gpu.py
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from cases import (
    MAX_STRAIN,
    add_one,
    different_muscles,
    field,
    make_muscle,
    scattered_points,
    wait,
)
from timing import Row, run, take_turns


FIELD, MUSCLES = "GPU: field", "GPU: different muscles × 1000 points"


def rows(small: bool = False) -> list[Row]:
    """Ratios of rates; without a GPU nothing is measured."""
    device = jax.devices()[0]
    if device.platform != "gpu":
        return [Row(name, None, "×", note="it needs a GPU") for name in (FIELD, MUSCLES)]
    shape, count, block, strains = (
        ((20, 30), 20, 10, 30) if small else ((1000, 10_000), 1_000_000, 100_000, 1000)
    )
    constant, points = jax.jit(make_muscle().force), tuple(map(jnp.asarray, field(*shape)))
    numbers, strain = jnp.zeros(shape), jnp.linspace(0.0, MAX_STRAIN, strains)
    columns = different_muscles(count), jnp.asarray(scattered_points(count)[0][:, None])
    force = eqx.filter_jit(lambda muscle, P, eps: muscle.force(P, eps))

    def rows_from(start: int) -> tuple[Any, Any]:
        # sizes are columns; what the muscles share is a single number
        return jax.tree.map(
            lambda x: x[start : start + block] if jnp.shape(x)[:1] == (count,) else x, columns
        )

    blocks = [rows_from(start) for start in range(0, count, block)]
    times = take_turns(
        {
            "x + 1": lambda: wait(add_one(numbers)),
            "field": lambda: wait(constant(*points)),
            "muscles": lambda: [wait(force(*columns, strain)) for columns in blocks],
        }
    )
    device_name, size = f"on {device.device_kind}", shape[0] * shape[1]
    note = f"{size / times.median('field') / 1e9:.3g} thousand million points/s"
    many = times.ratio("field", "muscles", count * strains / size)
    return [
        Row(f"{FIELD}, {shape[0]:,} × {shape[1]:,}", times.ratio("x + 1", "field"), "×",
            f"rate of x + 1, {device_name}", at_least=0.2, note=note),
        Row(f"{MUSCLES}, {count:,} of them", many, "×", f"the field's rate, {device_name}",
            at_least=0.5),
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)

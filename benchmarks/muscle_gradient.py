"""The gradient by every parameter of the muscle, against the value alone.

`eqx.filter_value_and_grad` of the sum of all forces by the muscle: sizes, material, law
constants and tuning at once, one number each. Both sides take the muscle as an argument, as a
fit does, so that a new muscle compiles nothing.

    python benchmarks/muscle_gradient.py
"""

import equinox as eqx
import jax
from cases import field, muscle, scattered
from timing import Row, interleaved, run

import fascicle as fs


def total(muscle: fs.Muscle, pressure: jax.Array, strain: jax.Array) -> jax.Array:
    return muscle.force(pressure, strain).sum()


def rows(small: bool = False) -> list[Row]:
    count, shape = 500 if small else 200_000, (200, 1000)
    value, gradient = eqx.filter_jit(total), eqx.filter_jit(eqx.filter_value_and_grad(total))
    one = muscle()
    parameters = len(jax.tree.leaves(eqx.filter(one, eqx.is_inexact_array)))
    cases = {f"{count:,} scattered points": scattered(count)}
    if not small:
        cases[f"a field of {shape[0]} × {shape[1]}"] = field(*shape)
    made = []
    for name, points in cases.items():
        times = interleaved(
            {
                "value": lambda points=points: jax.block_until_ready(value(one, *points)),
                "gradient": lambda points=points: jax.block_until_ready(gradient(one, *points)),
            }
        )
        question = f"gradient by the muscle's {parameters} parameters, {name}"
        made.append(
            Row(question, times.ratio("gradient", "value"), "×", "the value alone", 6.0, "≤")
        )
    return made


if __name__ == "__main__":
    run(rows, __doc__)

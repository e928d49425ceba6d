"""Value and both derivatives, by pressure and by strain, against the value alone.

Scattered points. Three ways that a user of JAX knows give the same three arrays:

- `jax.vmap(jax.value_and_grad(force, argnums=(0, 1)))`;
- `jax.vjp(force, P, eps)` pulled back from ones, since the law acts point by point;
- `jax.jvp(force, ...)` twice, along pressure and along strain, whose value is one.

They must agree; the cheapest counts, the others are told beside it.

    python benchmarks/point_derivatives.py
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from cases import muscle, scattered
from timing import Row, interleaved, run


def ways(force: Any) -> dict[str, Any]:
    """Functions of pressure and strain that give the force and its two slopes."""

    def pulled(P: jax.Array, eps: jax.Array) -> Any:
        value, back = jax.vjp(force, P, eps)
        return value, back(jnp.ones_like(value))

    def pushed(P: jax.Array, eps: jax.Array) -> Any:
        one, none = jnp.ones_like(P), jnp.zeros_like(P)
        value, by_pressure = jax.jvp(force, (P, eps), (one, none))
        _, by_strain = jax.jvp(force, (P, eps), (none, one))
        return value, (by_pressure, by_strain)

    return {
        "vmap(value_and_grad)": jax.jit(jax.vmap(jax.value_and_grad(force, argnums=(0, 1)))),
        "vjp": jax.jit(pulled),
        "jvp twice": jax.jit(pushed),
    }


def rows(small: bool = False) -> list[Row]:
    count = 500 if small else 200_000
    force, points = muscle().compile(), scattered(count)
    known = ways(force)
    first, *others = (jax.tree.leaves(way(*points)) for way in known.values())
    for other in others:
        for one, two in zip(first, other, strict=True):
            np.testing.assert_allclose(one, two, rtol=1e-7, atol=1e-7 * float(jnp.abs(one).max()))
    calls = {"value": lambda: jax.block_until_ready(force(*points))}
    for name, way in known.items():
        calls[name] = lambda way=way: jax.block_until_ready(way(*points))
    times = interleaved(calls)
    cheapest = min(known, key=times.median)
    made = []
    for name in sorted(known, key=times.median):
        question = f"value and both derivatives of {count:,} scattered points, by {name}"
        reach = 4.0 if name == cheapest else None
        made.append(Row(question, times.ratio(name, "value"), "×", "the value alone", reach, "≤"))
    return made


if __name__ == "__main__":
    run(rows, __doc__)

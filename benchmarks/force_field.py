"""The force field against the cost of only moving its numbers through memory.

`muscle.force`, as `muscle.compile()` gives it, is timed beside `x + 1` over as many float64
values, in the same process and the same run, all compiled and warm. The ratio says how many
plain passes over memory one evaluation of the laws costs, on this machine. Two cases: a field,
pressures along one axis and strains along the other, whose free and collapse strains are solved
for once for each pressure; and a cloud, where every point has a pressure of its own.
"""

import math
import statistics
import time
from collections.abc import Callable

import jax
import jax.numpy as jnp

import fascicle as fs


SIDE = 500
REPEATS = 5


def seconds(function: Callable[..., jax.Array], *arguments: jax.Array) -> float:
    """Median time [s] of a warm call."""
    function(*arguments).block_until_ready()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        function(*arguments).block_until_ready()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main() -> None:
    """Print times, rates and ratios."""
    muscle = fs.Muscle.from_dimensions(
        length=0.127, outer_radius=6.35e-3, wall_thickness=1.6e-3, braid_angle=math.radians(33)
    )
    pressure, strain = jnp.linspace(0.0, 4e5, SIDE)[:, None], jnp.linspace(0.0, 0.4, SIDE)
    everywhere = jnp.broadcast_arrays(pressure, strain)
    force = muscle.compile()
    stream = seconds(jax.jit(lambda x: x + 1), everywhere[1])
    print(f"{SIDE}² points on {jax.devices()[0].device_kind}, median of {REPEATS} warm calls")
    print(f"x + 1  {stream * 1e3:10.3f} ms")
    for name, arguments in (("field", (pressure, strain)), ("cloud", everywhere)):
        taken = seconds(force, *arguments)
        rate = SIDE**2 / taken / 1e6
        print(f"{name}  {taken * 1e3:10.3f} ms  {rate:8.3f} million/s  ratio {taken / stream:.0f}")


if __name__ == "__main__":
    main()

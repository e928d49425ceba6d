"""The force field against the cost of only moving its numbers through memory.

`muscle.force` over a grid of pressures and strains is timed beside `x + 1` over as many
float64 values, in the same process and the same run, both compiled and warm. The ratio says
how many plain passes over memory one evaluation of the laws costs, on this machine.
"""

import math
import statistics
import time
from collections.abc import Callable

import jax
import jax.numpy as jnp

import fascicle as fs


POINTS = 1_000_000
REPEATS = 7


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
    """Print both times, the rate and the ratio."""
    muscle = fs.Muscle.from_dimensions(
        length=0.127, outer_radius=6.35e-3, wall_thickness=1.6e-3, braid_angle=math.radians(33)
    )
    side = math.isqrt(POINTS)
    pressure, strain = jnp.meshgrid(
        jnp.linspace(0.0, 4e5, side), jnp.linspace(0.0, 0.4, side), indexing="ij"
    )
    force = seconds(jax.jit(muscle.force), pressure, strain)
    stream = seconds(jax.jit(lambda x: x + 1), strain)
    device = jax.devices()[0].device_kind
    print(f"{strain.size} points on {device}, median of {REPEATS} warm calls")
    print(f"muscle.force  {force * 1e3:9.2f} ms  {strain.size / force / 1e6:7.2f} million points/s")
    print(f"x + 1         {stream * 1e3:9.2f} ms")
    print(f"ratio         {force / stream:9.1f}")


if __name__ == "__main__":
    main()

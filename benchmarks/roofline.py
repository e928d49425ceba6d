"""Where the laws stand under this machine's roof.

A compiled function can't be faster than memory brings its numbers, nor than the cores multiply
and add. Both are measured here by chains of polynomials of rising length, from one operation a
number to thousands: over 1e7 float64, into new memory as every result goes, and over 1e5, which
stay in cache. The best bandwidth of the former and the best rate of all are the roof. Under it
the force field, scattered points and their derivatives, at the flops that the compiler counts
(`cost_analysis`) and the bytes that must move, arguments and results. A division, a square root
or an exponential counts as one flop though each costs many, and the body of a loop as run once,
so that a law with a loop in it (open marks) does more than is counted. What it moves beside, in
temporaries, is told.

    python benchmarks/roofline.py            # and draws docs/_static/roofline.png
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from cases import done, field, muscle, scattered, stream
from matplotlib.figure import Figure
from point_derivatives import ways
from timing import Measured, Row, interleaved, options, save, short

from fascicle.plot.theme import (
    BLACK,
    BLUE,
    DOUBLE,
    GRAY,
    GREEN,
    VERMILION,
    new_figure,
    styled,
    to_bytes,
)


PICTURE = Path(__file__).parents[1] / "docs" / "_static" / "roofline.png"
CHAINS, LENGTHS = 8, (1, 2, 4, 8, 16, 32, 64, 128)  # side by side, so that none waits for itself
MARKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"))


@dataclass(frozen=True)
class Point:
    """A function under the roof: flops of one call, bytes it must move, and the time [s] it took.

    `moved`: how many bytes it moves by the compiler's count, temporaries too.
    """

    name: str
    flops: float
    bytes: float
    seconds: Measured
    moved: float
    loops: bool = False

    @property
    def intensity(self) -> float:
        """Flops for each byte."""
        return self.flops / self.bytes

    @property
    def rate(self) -> float:
        """Flops in a second."""
        return self.flops / self.seconds.value


@dataclass(frozen=True)
class Roof:
    """What was measured: chains in memory and in cache span the roof, laws stand under it."""

    chains: tuple[Point, ...]
    cached: tuple[Point, ...]
    laws: tuple[Point, ...]

    @property
    def widest(self) -> Point:
        return max(self.chains, key=lambda one: one.bytes / one.seconds.value)

    @property
    def peak(self) -> Point:
        return max((*self.chains, *self.cached), key=lambda one: one.rate)

    @property
    def bandwidth(self) -> float:
        """Bytes in a second."""
        return self.widest.bytes / self.widest.seconds.value

    @property
    def edge(self) -> float:
        """Intensity [flop/B] from which on arithmetic is what takes time."""
        return self.peak.rate / self.bandwidth

    def at(self, intensity: float) -> float:
        """The most flops a second at `intensity` [flop/B]."""
        return min(intensity * self.bandwidth, self.peak.rate)


def polynomials(length: int) -> Callable[[jax.Array], jax.Array]:
    """Horner's rule, `length` multiply-adds in each of the chains, summed."""

    def total(x: jax.Array) -> jax.Array:
        y = [x] * CHAINS
        for _ in range(length):
            y = [y[j] * x + 0.1 * (j + 1) for j in range(CHAINS)]
        return sum(y[1:], y[0])

    return jax.jit(total)


def measure(small: bool) -> Roof:
    count, shape = (500, (20, 30)) if small else (10**6, (1000, 10_000))
    sizes = {"memory": 10_000 if small else 10**7, "cache": 1000 if small else 10**5}
    lengths = LENGTHS[:2] if small else LENGTHS
    chains: dict[str, tuple[int, int]] = {}  # flops and bytes
    calls: dict[str, Callable[[], Any]] = {}
    for where, numbers in sizes.items():
        x = jnp.linspace(0.0, 0.5, numbers)
        functions: dict[int, tuple[str, Callable]] = {}
        if where == "memory":  # in cache the call itself would be what is measured
            functions[1] = (f"x + 1 in {where}", stream)
        for length in lengths:
            flops = 2 * CHAINS * length + CHAINS - 1
            functions[flops] = (
                f"{length} × {CHAINS} multiply-adds in {where}",
                polynomials(length),
            )
        for flops, (name, function) in functions.items():
            chains[name] = (flops * numbers, 16 * numbers)
            calls[name] = lambda function=function, x=x: done(function(x))
    force, points = muscle().compile(), scattered(count)
    slopes = ways(force)["jvp twice"]
    known = {
        f"force field, {shape[0]:,} × {shape[1]:,}": (jax.jit(force), field(*shape)),
        f"{count:,} scattered points": (jax.jit(force), points),
        "the same with both derivatives": (slopes, points),
    }
    compiled = {name: f.lower(*where).compile() for name, (f, where) in known.items()}
    for name, (_, where) in known.items():
        one = compiled[name]
        calls[name] = lambda one=one, where=where: jax.block_until_ready(one(*where))
    times = interleaved(calls, budget=40.0)
    spans = {
        where: tuple(
            Point(name, flops, size, times.each(name), size)
            for name, (flops, size) in chains.items()
            if name.endswith(where)
        )
        for where in sizes
    }
    laws = []
    for name, one in compiled.items():
        counted = one.cost_analysis()
        work = counted["flops"] + counted.get("transcendentals", 0.0)
        needs = one.memory_analysis()
        must = needs.argument_size_in_bytes + needs.output_size_in_bytes
        loops, moved = " while(" in one.as_text(), counted["bytes accessed"]
        laws.append(Point(name, work, must, times.each(name), moved, loops))
    return Roof(spans["memory"], spans["cache"], tuple(laws))


def table(roof: Roof) -> list[Row]:
    wide, peak = roof.widest, roof.peak
    made = [
        Row(f"roof: memory, by {wide.name}", _per(wide.bytes / 1e9, wide.seconds), "GB/s"),
        Row(
            f"roof: multiply-adds, by {peak.name}", _per(peak.flops / 1e9, peak.seconds), "Gflop/s"
        ),
    ]
    for law in roof.laws:
        top = roof.at(law.intensity)
        bound = "memory" if law.intensity < roof.edge else "multiply-adds"
        counted = f"{'at least ' if law.loops else ''}{short(law.intensity)} flop/B"
        limit = f"{counted}, under the roof of {bound}; moves {short(law.moved / law.bytes)} times"
        limit += " the bytes it must, by the compiler's count"
        share = _per(law.flops / top, law.seconds)
        made.append(Row(f"share of the roof, {law.name}", share, "×", "the roof", limit=limit))
    return made


def _per(amount: float, seconds: Measured) -> Measured:
    """`amount` in a second, whose quartiles change places."""
    return Measured(amount / seconds.value, amount / seconds.high, amount / seconds.low)


@styled
def draw(roof: Roof) -> Figure:
    figure, grid = new_figure(1, 1, 0.72 * DOUBLE, 0.42 * DOUBLE)
    axes = grid[0, 0]
    everyone = (*roof.chains, *roof.laws)
    low = 0.6 * min(one.intensity for one in everyone)
    high = 1.8 * max(one.intensity for one in everyone)
    ends = [low, roof.edge, high]
    axes.plot(ends, [roof.at(i) / 1e9 for i in ends], color=BLACK, label="the roof, as measured")
    for mark, where, series in (("o", "memory", roof.chains), ("x", "cache", roof.cached)):
        axes.plot(
            [one.intensity for one in series],
            [one.rate / 1e9 for one in series],
            mark,
            color=GRAY,
            markersize=3,
            label=f"polynomials of rising length, in {where}",
        )
    for law, (color, mark) in zip(roof.laws, MARKS, strict=True):
        face = "white" if law.loops else color
        name = f"{law.name} (loops counted once)" if law.loops else law.name
        axes.plot(
            law.intensity, law.rate / 1e9, mark, color=color, markerfacecolor=face, label=name
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("Arithmetic intensity [flop/B]")
    axes.set_ylabel("Rate [Gflop/s]")
    axes.legend(loc="lower right")
    return figure


def rows(small: bool = False) -> list[Row]:
    return table(measure(small))


def main() -> None:
    """Print the rows, and draw the figure unless small."""
    given = options(__doc__)
    roof = measure(given.small)
    save(table(roof), given.json)
    if not given.small:
        PICTURE.write_bytes(to_bytes(draw(roof), "png"))
        print(PICTURE)


if __name__ == "__main__":
    main()

"""Arrays under JAX: rates of fields and scattered points, their derivatives, and memory.

A field is a column of pressures against a row of strains; free and collapse strain are solved once
for each pressure. Scattered points have a pressure each. Every call writes into new memory, the
floor `x + 1` over as many numbers, too. The code before the core was rebuilt on NumPy (version 0.1)
had fixed ratios to that floor, measured in turns with today's code on one core; rates are compared
with these.

    python benchmarks/jax_arrays.py
"""

import subprocess
import sys
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from cases import (
    add_one,
    different_muscles,
    exponential,
    field,
    make_muscle,
    scattered_points,
    wait,
)
from timing import Quartiles, Row, run, take_turns

import fascicle as fs
import fascicle.jax


FORMER_FIELD, FORMER_SCATTERED = 0.35, 0.08  # of the rate of x + 1, with version 0.1
SHAPE, POINTS = (1000, 10_000), 1_000_000


def compare(ratio: Quartiles, former: float) -> Quartiles:
    """A `ratio` of rates relative to a `former` one."""
    return Quartiles(*(x / former for x in (ratio.median, ratio.low, ratio.high)))


def point_rows(small: bool) -> list[Row]:
    """Rates of a field and of scattered points."""
    shape, count = ((20, 30), 500) if small else (SHAPE, POINTS)
    force = jax.jit(make_muscle().force)
    grid, points = (tuple(map(jnp.asarray, x)) for x in (field(*shape), scattered_points(count)))
    numbers = jnp.zeros(shape)
    times = take_turns(
        {
            "x + 1": lambda: wait(add_one(numbers)),
            "exp": lambda: wait(exponential(numbers)),
            "field": lambda: wait(force(*grid)),
            "scattered": lambda: wait(force(*points)),
        }
    )
    size = shape[0] * shape[1]

    named = f"JAX: field, {shape[0]:,} pressures × {shape[1]:,} strains"
    scattered = f"JAX: {count:,} scattered points"
    field_ratio = times.ratio("x + 1", "field")
    scattered_ratio = times.ratio("x + 1", "scattered", count / size)
    former = "{} of the rate of x + 1, as before the rebuild"
    field_note, scattered_note = (
        f"{times.rate(name, number / 1e6).median:.3g} million points/s"
        for name, number in (("field", size), ("scattered", count))
    )
    return [
        Row(named, compare(field_ratio, FORMER_FIELD), "×", former.format(FORMER_FIELD),
            at_least=0.6, note=field_note),
        Row(named, field_ratio, "×", "rate of x + 1", at_least=0.6),
        Row(named, times.ratio("exp", "field"), "×", "rate of exp"),
        Row(scattered, compare(scattered_ratio, FORMER_SCATTERED), "×",
            former.format(FORMER_SCATTERED), at_least=0.6, note=scattered_note),
        Row(scattered, times.ratio("field", "scattered", count / size), "×", "the field's rate",
            at_least=1 / 3, note="each point solves for its free and collapse strain"),
    ]  # fmt: skip


def point_derivatives(force: Any) -> dict[str, Any]:
    """Functions of pressure and strain that give the force and both slopes, by ways of JAX."""

    def reverse(P: jax.Array, eps: jax.Array) -> Any:
        value, pullback = jax.vjp(force, P, eps)
        return value, pullback(jnp.ones_like(value))

    def forward(P: jax.Array, eps: jax.Array) -> Any:
        ones, zeros = jnp.ones_like(P), jnp.zeros_like(P)
        value, by_pressure = jax.jvp(force, (P, eps), (ones, zeros))
        _, by_strain = jax.jvp(force, (P, eps), (zeros, ones))
        return value, (by_pressure, by_strain)

    return {
        "jvp twice": jax.jit(forward),
        "vjp": jax.jit(reverse),
        "vmap(value_and_grad)": jax.jit(jax.vmap(jax.value_and_grad(force, argnums=(0, 1)))),
    }


def point_derivative_rows(small: bool) -> list[Row]:
    """Derivatives by pressure and strain; the fastest way has the goal."""
    count = 500 if small else 200_000
    force = jax.jit(make_muscle().force)
    points = tuple(map(jnp.asarray, scattered_points(count)))
    ways = point_derivatives(force)
    if small:  # each compiles for seconds
        del ways["vmap(value_and_grad)"]
    first, *others = (jax.tree.leaves(way(*points)) for way in ways.values())
    for other in others:
        for x, y in zip(first, other, strict=True):  # rounding: roots end within 1e-12
            np.testing.assert_allclose(x, y, rtol=1e-7, atol=1e-7 * float(jnp.abs(x).max()))
    calls = {name: lambda way=way: wait(way(*points)) for name, way in ways.items()}
    times = take_turns({"value": lambda: wait(force(*points)), **calls})
    fastest = min(ways, key=times.median)
    return [
        Row(f"JAX: force and both slopes of {count:,} scattered points, {name}",
            times.ratio(name, "value"), "×", "the force alone",
            at_most=4 if name == fastest else None)
        for name in ways
    ]  # fmt: skip


def total_force(muscle: fs.Muscle, pressure: jax.Array, strain: jax.Array) -> jax.Array:
    """Sum of all forces [N]."""
    return muscle.force(pressure, strain).sum()


def muscle_rows(small: bool) -> list[Row]:
    """Gradients by a muscle's parameters, and many muscles at once."""
    count, shape = 500 if small else 200_000, (200, 1000)
    value, gradient = (
        eqx.filter_jit(total_force),
        eqx.filter_jit(eqx.filter_value_and_grad(total_force)),
    )
    muscle = make_muscle()
    parameters = len(jax.tree.leaves(eqx.filter(muscle, eqx.is_inexact_array_like)))
    rows, cases = [], {f"{count:,} scattered points": scattered_points(count)}
    if not small:
        cases[f"a field of {shape[0]} × {shape[1]}"] = field(*shape)
    for name, points in cases.items():
        arrays = tuple(map(jnp.asarray, points))
        times = take_turns(
            {
                "value": lambda arrays=arrays: wait(value(muscle, *arrays)),
                "gradient": lambda arrays=arrays: wait(gradient(muscle, *arrays)),
            }
        )
        named = f"JAX: gradient by the muscle's {parameters} parameters, {name}"
        ratio = times.ratio("gradient", "value")
        rows.append(Row(named, ratio, "×", "the sum of forces alone", at_most=6))
    count, each = (10, 20) if small else (10_000, 100)
    points = tuple(map(jnp.asarray, scattered_points(count, each)))
    muscles, constant = different_muscles(count), jax.jit(muscle.force)
    force = eqx.filter_jit(lambda muscle, P, eps: muscle.force(P, eps))
    times = take_turns(
        {
            "many": lambda: wait(force(muscles, *points)),
            "single": lambda: wait(force(muscle, *points)),
            "compiled": lambda: wait(constant(*points)),
        }
    )
    named = f"JAX: {count:,} different muscles × {each} points"
    floor = f"rate of one muscle × {count * each:,}"
    return [
        *rows,
        Row(named, times.ratio("compiled", "many"), "×", f"{floor}, compiled", at_least=0.5),
        Row(named, times.ratio("single", "many"), "×", f"{floor}, the same function"),
    ]


def resident(entry: str) -> int:
    """Resident memory [B] of this process: now, `VmRSS`, or at most, `VmHWM`."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(entry))


def print_memory(pressures: int, strains: int) -> None:
    """Print the peak of memory that the field takes, as a multiple of its output."""
    points = tuple(map(jnp.asarray, field(pressures, strains)))
    force: Any = jax.jit(make_muscle().force).lower(*points).compile()
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak
    before = resident("VmRSS")
    result = wait(force(*points))
    print((resident("VmHWM") - before) / result.nbytes)


def memory_row(small: bool) -> Row:
    """Peak of memory, in processes of their own."""
    shape = (100, 1000) if small else SHAPE
    command = [sys.executable, __file__, "--memory", *map(str, shape)]
    outputs = [
        subprocess.run(command, capture_output=True, text=True, check=True).stdout  # noqa: S603 this file
        for _ in range(1 if small else 3)
    ]
    name = f"JAX: peak memory of the field, {shape[0]:,} × {shape[1]:,}"
    floor = f"its output, {8 * shape[0] * shape[1] / 1e6:.3g} MB"
    return Row(name, Quartiles.of(map(float, outputs)), "×", floor, at_most=3)


def rows(small: bool = False) -> list[Row]:
    """Rates, derivatives and memory."""
    return [
        *point_rows(small),
        *point_derivative_rows(small),
        *muscle_rows(small),
        memory_row(small),
    ]


if __name__ == "__main__":
    if "--memory" in sys.argv:
        print_memory(*map(int, sys.argv[2:]))
    else:
        run(rows, __doc__)

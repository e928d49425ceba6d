"""A bundle in time: 1 + 4 muscles on gas, lifting a mass for 10 s in steps of 1 ms, by the table.

How much faster than the bundle itself one run is, 256 at once, and how many times the cost alone a
tracking cost's gradient by two gains takes, reverse. The floor of the first row is the same number
of Runge-Kutta stages of a pendulum, in the same kind of loop: what the loop itself costs.

    python benchmarks/in_time.py
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from timing import Measured, Row, interleaved, run

import fascicle as fs
from fascicle import dynamics, fluid


DT, SUBSTEPS = 1e-3, 2


def plant() -> dynamics.Plant:
    muscle = fs.example("kim2021_figure_6")
    bundle = fs.Bundle([fs.MotorUnit(muscle, 1), fs.MotorUnit(muscle, 4)])
    return dynamics.Plant(
        bundle,
        dynamics.HangingMass(mass=5.0, damping=50.0),
        fluid.ConstantSupply(413.7e3),
        fluid.AdiabaticWall(conductance=0.5, dead_volume=np.array([2e-6, 8e-6])),
        fluid.SonicValve(1e-9, 0.3),
    )


class Proportional(eqx.Module):
    """Both valves by the position's error."""

    gain: jax.Array
    damping: jax.Array

    @property
    def memory(self) -> tuple:
        return ()

    def __call__(
        self, memory: tuple, seen: dynamics.Measurement, wanted: jax.Array
    ) -> tuple[tuple, jax.Array]:
        u = jnp.tanh(self.gain * (wanted - seen.position) - self.damping * seen.velocity)
        return memory, jnp.stack([u, u])


def rows(small: bool = False) -> list[Row]:
    seconds, batch = (0.2, 4) if small else (10.0, 256)
    moved = plant()
    begin = dynamics.equilibrium_state(moved)
    schedule = dynamics.Schedule([0, 1, 4, 6], [[1, 0], [1, 1], [-1, 0], [-1, -1]])
    steps = round(seconds / DT)
    commands = schedule.at(DT * np.arange(steps))
    some = jnp.broadcast_to(
        jnp.asarray(commands[: max(1, steps // 10)]), (batch, max(1, steps // 10), 2)
    )
    wanted = 0.01 + 0.005 * np.sin(np.arange(max(1, steps // 10)) * DT)

    @jax.jit
    def many(commands: jax.Array) -> jax.Array:
        def one(rows: jax.Array) -> jax.Array:
            return dynamics.simulate(
                moved, rows, dt=DT, start=begin, substeps=SUBSTEPS
            ).outputs.position

        return jax.vmap(one)(commands)

    def cost(gains: jax.Array) -> jax.Array:
        act = Proportional(gains[0], gains[1])
        seen = dynamics.simulate(moved, act, wanted, dt=DT, start=begin, substeps=SUBSTEPS).outputs
        return jnp.mean((seen.position[1:] - wanted) ** 2)

    value, slope = jax.jit(cost), jax.jit(jax.value_and_grad(cost))
    gains = jnp.array([300.0, 5.0])

    @jax.jit
    def pendulum(x: jax.Array) -> jax.Array:
        def stage(y: jax.Array, _: None) -> tuple[jax.Array, None]:
            return y + 1e-4 * jnp.stack([y[1], -jnp.sin(y[0])]), None

        return lax.scan(stage, x, None, length=4 * SUBSTEPS * steps)[0]

    times = interleaved(
        {
            "floor": lambda: pendulum(jnp.ones(2)).block_until_ready(),
            "one": lambda: dynamics.simulate(
                moved, schedule, dt=DT, duration=seconds, start=begin, substeps=SUBSTEPS
            ),
            "many": lambda: jax.block_until_ready(many(some)),
            "cost": lambda: jax.block_until_ready(value(gains)),
            "slope": lambda: jax.block_until_ready(slope(gains)),
        },
        repeats=3 if small else 7,
        budget=120.0,
    )

    def rate(name: str, bundles: int, span: float) -> Measured:
        return Measured.of(bundles * span / times.seconds[name])

    return [
        Row("10 s of 1 + 4 muscles on gas: a run", times.each("one"), "s", "", 0.1, "≤"),
        Row("a run", times.ratio("one", "floor"), "×", "the loop itself, of a pendulum"),
        Row(f"{batch} at once", rate("many", batch, len(wanted) * DT), "bundle s/s", "", 400.0),
        Row(f"a tracking cost of {len(wanted) * DT:g} s, compiled", times.each("cost"), "s"),
        Row("a tracking cost's gradient by two gains, reverse", times.ratio("slope", "cost"), "×",
            "the cost alone", 15.0, "≤"),
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)

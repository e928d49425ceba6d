"""Simulations: 1 + 4 muscles on gas lift a mass for 10 s, in steps of 1 ms.

One run, 256 of 1 s at once by `vmap`, and the gradient of a tracking cost by two gains, reverse.
All are CPU seconds. The first run, with compilation, is in `first_call.py`.

    python benchmarks/simulation.py
"""

import time
from functools import cache

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from timing import Row, run, take_turns

import fascicle as fs
from fascicle import dynamics, fluid


DT, SUBSTEPS = 1e-3, 2
SCHEDULE = dynamics.Schedule([0, 1, 4, 6], [[1, 0], [1, 1], [-1, 0], [-1, -1]])


@cache
def make_plant() -> dynamics.Plant:
    """1 + 4 muscles with a hanging mass, on gas that exchanges heat with the walls."""
    muscle = fs.example("kim2021_figure_6")
    return dynamics.Plant(
        fs.Bundle([fs.MotorUnit(muscle, 1), fs.MotorUnit(muscle, 4)]),
        dynamics.HangingMass(mass=5.0, damping=50.0),
        fluid.ConstantSupply(413.7e3),
        fluid.AdiabaticWall(conductance=0.5, dead_volume=np.array([2e-6, 8e-6])),
        fluid.SonicValve(1e-9, 0.3),
    )


def simulate_gas(seconds: float) -> dynamics.Trajectory:
    """A run of some seconds from equilibrium."""
    plant = make_plant()
    start = dynamics.equilibrium_state(plant)
    return dynamics.simulate(
        plant, SCHEDULE, dt=DT, duration=seconds, start=start, substeps=SUBSTEPS
    )


class Proportional(eqx.Module):
    """Controller that opens both valves in proportion to the error of the position."""

    gain: jax.Array
    damping: jax.Array

    @property
    def memory(self) -> tuple:
        """No memory."""
        return ()

    def __call__(
        self, memory: tuple, measured: dynamics.Measurement, target: jax.Array
    ) -> tuple[tuple, jax.Array]:
        """Commands of the valves [-]."""
        error = target - measured.position
        u = jnp.tanh(self.gain * error - self.damping * measured.velocity)
        return memory, jnp.stack([u, u])


def rows(small: bool = False) -> list[Row]:
    """CPU seconds of runs."""
    seconds, batch = (0.2, 4) if small else (10.0, 256)
    plant, steps = make_plant(), round(seconds / DT)
    start = dynamics.equilibrium_state(plant)
    span = DT * (steps // 10)  # of each of many runs
    time_points = DT * np.arange(steps // 10)
    commands = jnp.broadcast_to(SCHEDULE.at(time_points), (batch, len(time_points), 2))
    target = 0.01 + 0.005 * np.sin(np.arange(len(time_points)) * DT)

    @jax.jit
    @jax.vmap
    def simulate_batch(commands: jax.Array) -> jax.Array:
        outcome = dynamics.simulate(plant, commands, dt=DT, start=start, substeps=SUBSTEPS)
        return outcome.outputs.position

    def cost(gains: jax.Array) -> jax.Array:
        controller = Proportional(gains[0], gains[1])
        outcome = dynamics.simulate(
            plant, controller, target, dt=DT, start=start, substeps=SUBSTEPS
        )
        return jnp.mean((outcome.outputs.position[1:] - target) ** 2)

    value, gradient = jax.jit(cost), jax.jit(jax.value_and_grad(cost))
    gains = jnp.array([300.0, 5.0])
    times = take_turns(
        {
            "run": lambda: simulate_gas(seconds),
            "batch": lambda: jax.block_until_ready(simulate_batch(commands)),
            "cost": lambda: jax.block_until_ready(value(gains)),
            "gradient": lambda: jax.block_until_ready(gradient(gains)),
        },
        rounds=3 if small else 7,
        budget=120.0,
        clock=time.process_time,
    )
    name = f"{seconds:g} s of 1 + 4 muscles on gas, again"
    return [
        Row(f"{name}, CPU", times.of("run"), "s", at_most=0.1),
        Row(f"{batch} runs at once", times.rate("batch", batch * span), "bundle s/CPU s",
            at_least=400),
        Row(f"a tracking cost of {span:g} s, compiled, CPU", times.of("cost"), "s"),
        Row("its gradient by two gains, reverse", times.ratio("gradient", "cost"), "×",
            "the cost alone", at_most=15),
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)

"""Muscles in MuJoCo and MJX: steps a second of joints between two muscles, with table and chambers.

64 joints at once in MJX, compiled, a step each of 1 ms counted 64 times; and one joint in MuJoCo,
with the pull by NumPy and compiled. The floor of MJX is the same model with forces that are held.
Environments of Gymnasium are 1024 in one process, and joint steps a second of all cores' CPU time.

    python benchmarks/robots.py
"""

import time
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from timing import Measured, Row, interleaved, run

from fascicle.robots.environments import FRAMES, AntagonisticJoint
from fascicle.robots.optional_imports import mjx


JOINTS = 64
ENVIRONMENTS = 1024
NAME = "fascicle/AntagonisticJoint-v0"


def environment_rate(small: bool) -> Measured:
    """Joint steps of 1 ms a CPU second of a vector of environments, observations and all."""
    many = gymnasium.make_vec(NAME, num_envs=4 if small else ENVIRONMENTS)
    actions = many.action_space.sample()
    many.reset(seed=1)
    many.step(actions)  # compiles
    rates = []
    for _ in range(3 if small else 9):
        begun = time.process_time()
        for _ in range(5):
            many.step(actions)
        rates.append(5 * FRAMES * many.num_envs / (time.process_time() - begun))
    return Measured.of(rates)


def rows(small: bool = False) -> list[Row]:
    steps = 10 if small else 1000
    joint = AntagonisticJoint()
    joint.reset(seed=1)
    engine, drive = mjx(), joint.drive
    model = engine.put_model(joint.model)
    data = engine.put_data(joint.model, joint.data)
    many = jax.tree.map(lambda x: jnp.broadcast_to(x, (JOINTS, *jnp.shape(x))), (data, joint.fluid))
    commands = jnp.asarray(0.5 * np.sin(np.arange(steps)[:, None] / 50 + np.array([0.0, 2.0])))

    def driven(carry: tuple, command: jax.Array) -> tuple[tuple, jax.Array]:
        now = jax.vmap(lambda d, f: drive.step_mjx(model, d, f, command))(*carry)
        return now, now[0].qpos

    def held(carry: tuple, command: jax.Array) -> tuple[tuple, jax.Array]:
        def one(d: Any) -> Any:
            after = engine.step(model, d.replace(ctrl=command))
            return jax.tree.map(lambda new, old: jnp.asarray(new, old.dtype), after, d)

        now = jax.vmap(one)(carry[0])
        return (now, carry[1]), now.qpos

    def compiled(step: Any) -> Any:
        scan = jax.jit(lambda carry: jax.lax.scan(step, carry, commands)[1])
        return lambda: scan(many).block_until_ready()

    few = 10 if small else 200
    act = jax.jit(drive.act)

    def alone(by: Any) -> None:
        joint.reset(seed=1)
        fluid = joint.fluid
        for _ in range(few):
            fluid = drive.step(joint.model, joint.data, fluid, np.zeros(2), by)

    times = interleaved(
        {
            "driven": compiled(driven),
            "held": compiled(held),
            "numpy": lambda: alone(None),
            "compiled": lambda: alone(act),
        },
        repeats=3 if small else 9,
    )

    def rate(name: str, count: int) -> Measured:
        return Measured.of(count / times.seconds[name])

    floor = f"with held forces {JOINTS * steps / times.median('held'):.3g}"
    return [
        Row("joint steps a second, 64 in MJX", rate("driven", JOINTS * steps), "1/s", floor, 2e5),
        Row("joint steps a CPU second, 1024 environments", environment_rate(small), "1/s", "", 1e5),
        Row("steps a second, one in MuJoCo, NumPy", rate("numpy", few), "1/s"),
        Row("steps a second, one in MuJoCo, compiled", rate("compiled", few), "1/s"),
    ]


if __name__ == "__main__":
    run(rows, __doc__)

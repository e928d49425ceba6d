"""Muscles in MuJoCo and MJX: steps of 1 ms a second of joints between two muscles.

64 joints at once in MJX, compiled; the floor is the same model with constant forces. One joint in
MuJoCo, its muscles by NumPy and compiled. 1024 environments of Gymnasium in one process, in joint
steps a CPU second.

    python benchmarks/robots.py
"""

import time
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from timing import Row, Times, run, take_turns

from fascicle.robots.environments import FRAMES, AntagonisticJoint
from fascicle.robots.optional_imports import mjx


JOINTS, ENVIRONMENTS = 64, 1024
NAME = "fascicle/AntagonisticJoint-v0"


def environment_times(small: bool) -> tuple[Times, int]:
    """CPU times of steps of a vector of environments, and the joint steps of each."""
    environments = gymnasium.make_vec(NAME, num_envs=4 if small else ENVIRONMENTS)
    actions = environments.action_space.sample()
    environments.reset(seed=1)
    times = take_turns(
        {"step": lambda: environments.step(actions)},
        rounds=3 if small else 9,
        loops=5,
        clock=time.process_time,
    )
    return times, FRAMES * environments.num_envs


def rows(small: bool = False) -> list[Row]:
    """Rates of steps."""
    steps, single_steps = (10, 10) if small else (1000, 200)
    joint = AntagonisticJoint()
    joint.reset(seed=1)
    engine, drive = mjx(), joint.drive
    model, data = engine.put_model(joint.model), engine.put_data(joint.model, joint.data)
    batch = jax.tree.map(
        lambda x: jnp.broadcast_to(x, (JOINTS, *jnp.shape(x))), (data, joint.fluid)
    )
    commands = jnp.asarray(0.5 * np.sin(np.arange(steps)[:, None] / 50 + np.array([0.0, 2.0])))

    def muscle_step(carry: tuple, command: jax.Array) -> tuple[tuple, jax.Array]:
        state = jax.vmap(lambda d, f: drive.step_mjx(model, d, f, command))(*carry)
        return state, state[0].qpos

    def constant_step(carry: tuple, command: jax.Array) -> tuple[tuple, jax.Array]:
        def step(d: Any) -> Any:
            after = engine.step(model, d.replace(ctrl=command))
            return jax.tree.map(lambda new, old: jnp.asarray(new, old.dtype), after, d)

        state = jax.vmap(step)(carry[0])
        return (state, carry[1]), state.qpos

    def compile_steps(step: Any) -> Any:
        scan = jax.jit(lambda carry: jax.lax.scan(step, carry, commands)[1])
        return lambda: scan(batch).block_until_ready()

    act = jax.jit(drive.act)

    def step_mujoco(compiled: Any) -> None:
        joint.reset(seed=1)
        state = joint.fluid
        for _ in range(single_steps):
            state = drive.step(joint.model, joint.data, state, np.zeros(2), compiled)

    times = take_turns(
        {
            "muscles": compile_steps(muscle_step),
            "constant": compile_steps(constant_step),
            "numpy": lambda: step_mujoco(None),
            "compiled": lambda: step_mujoco(act),
        },
        rounds=3 if small else 9,
    )
    floor = f"constant forces, {JOINTS * steps / times.median('constant'):,.0f} 1/s"
    environments, joint_steps = environment_times(small)
    return [
        Row(f"MJX: {JOINTS} joints, joint steps", times.rate("muscles", JOINTS * steps), "1/s",
            floor, at_least=2e5),
        Row(f"Gymnasium: {ENVIRONMENTS} environments, joint steps",
            environments.rate("step", joint_steps), "1/CPU s", at_least=1e5),
        Row("MuJoCo: one joint, NumPy, steps", times.rate("numpy", single_steps), "1/s"),
        Row("MuJoCo: one joint, compiled, steps", times.rate("compiled", single_steps), "1/s"),
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)

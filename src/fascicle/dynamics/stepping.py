r"""Fixed steps of the classic Runge-Kutta method, with constant inputs.

A controller acts once a step of $\Delta t$; its commands are constant until it acts again, so that
no stage of a step sees the next command. Pressures are integrated by (T4) and corrected at the end
of each substep; of chambers the conserved states (T6) are integrated.

**Source:** Kutta (1901).
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..core.types import Batch, BoolBatch, Numbers
from .chamber_pressure import solve_pressures
from .conservative_update import conserved_state, project_chambers
from .energy_ledger import LEDGER, ledger_rates
from .motion import FrictionMemory, evaluate_plant, time_derivative, update_friction
from .plant import Plant, State


_NEWTON = 2  # from integrated pressures, two steps leave 1e-12
_TIMES, _WEIGHTS = np.array([0.0, 0.5, 0.5, 1.0]), np.array([1, 2, 2, 1]) / 6  # of stages
_FRICTION = np.array([name == "friction" for name in LEDGER], float)
_BY_PARTS = np.array([[name == entry for name in LEDGER] for entry in
                      ("fluid_work", "mismatch", "displaced")], float)  # fmt: skip


class IntegratorState(NamedTuple):
    """Progress of a run: its `state` [SI], friction's `anchor` [SI], the entries of its energy
    `ledger` [J or kg], and whether a chamber `folded`.
    """

    state: State
    anchor: FrictionMemory
    ledger: Numbers
    folded: BoolBatch


def substep(
    plant: Plant, time: Batch, progress: IntegratorState, command: Numbers, h: Batch
) -> IntegratorState:
    """Advance the `progress` [SI] of a `plant` from `time` [s] by a substep of `h` [s], under a
    `command` [-].
    """
    state, anchor, ledger, folded = progress

    def stage(carry: tuple, weights: Numbers) -> tuple[tuple, tuple]:
        slope, total, growth = carry
        delay, weight = weights
        stage_state = add_scaled(state, slope, delay * h)
        evaluation = evaluate_plant(plant, time + delay * h, stage_state, command, anchor)
        slope = time_derivative(plant, stage_state, evaluation, command)
        growth = growth + weight * h * ledger_rates(plant, stage_state, evaluation)
        total = add_scaled(total, slope._replace(chambers=evaluation.conserved_rates), weight)
        return (slope, total, growth), (evaluation.fluid.volume, evaluation.fluid.is_folded)

    # a loop, as four copies of the stage would take four times as long to compile
    zeros = jax.tree.map(lambda x: 0.0 * x, state)
    stages = np.stack([_TIMES, _WEIGHTS], axis=1)
    (_, total, growth), (volumes, folds) = lax.scan(stage, (zeros, zeros, 0.0 * ledger), stages)
    initial = conserved_state(plant.chamber, state.chambers, state.pressures, volumes[0])
    after = add_scaled(state._replace(chambers=initial), total, h)
    q, _ = plant.load.motion_at(time + h, after.position, after.velocity)
    end = project_chambers(
        plant, after.chambers, plant.strains(q[..., None]), after.pressures, _NEWTON
    )
    after = after._replace(
        chambers=end.chambers,
        pressures=end.pressures,
        supply=plant.supply.update_switch(after.supply),
    )
    ledger = ledger + growth + jnp.stack([end.work, end.mismatch, end.work]) @ _BY_PARTS
    folded |= jnp.any(folds)
    if plant.hysteresis is None:
        return IntegratorState(after, anchor, ledger, folded)
    anchor, loss = update_friction(plant, anchor, q, after.pressures)
    return IntegratorState(after, anchor, ledger + loss * _FRICTION, folded)


def add_scaled(state: State, rate: State, h: Batch) -> State:
    """A `state` [SI] after `h` [s] at a `rate` [SI]."""
    return jax.tree.map(lambda x, slope: x + h * slope, state, rate)


def project_pressures(plant: Plant, time: Batch, state: State, steps: int) -> State:
    """A `state` [SI] at `time` [s] with the pressures of its chambers, in `steps` of Newton's
    method.
    """
    q, _ = plant.load.motion_at(time, state.position, state.velocity)
    eps = plant.strains(q[..., None])
    return state._replace(
        pressures=solve_pressures(plant, state.chambers, eps, state.pressures, steps)
    )

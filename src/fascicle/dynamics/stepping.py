r"""Fixed steps of the classic Runge-Kutta method, with inputs held.

A controller acts once a step of $\Delta t$; what it commands is held until it acts again, so that
no stage of a step sees the next command. Pressures are integrated with all the rest, by (T4), and
set right at the end of each substep; of chambers what they hold is, by (T6).

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
from .plant import Plant
from .state import State


_NEWTON = 2  # from where the rates led: two steps leave 1e-12 of a pressure
# stages of the method: how far along each is, and what it weighs
_ALONG, _WEIGHTS = np.array([0.0, 0.5, 0.5, 1.0]), np.array([1, 2, 2, 1]) / 6
_FRICTION = np.array([name == "friction" for name in LEDGER], float)
_BY_PARTS = np.array([[name == one for name in LEDGER] for one in
                      ("fluid_work", "mismatch", "displaced")], float)  # fmt: skip


class IntegratorState(NamedTuple):
    """How far a run has come: a `state` [SI], friction's `anchor` [SI], each number of the
    `account` up to then [J or kg], and whether a chamber `folded` on the way [-].
    """

    state: State
    anchor: FrictionMemory
    account: Numbers
    folded: BoolBatch


def substep(
    plant: Plant, time: Batch, course: IntegratorState, command: Numbers, h: Batch
) -> IntegratorState:
    """One substep of `h` [s] of a `plant` [-] from `time` [s] of its `course` [SI], under a
    `command` [-].
    """
    state, anchor, account, folded = course

    def stage(carry: tuple, weights: Numbers) -> tuple[tuple, tuple]:
        slope, total, grown = carry
        along, weight = weights
        at = add_scaled(state, slope, along * h)
        evaluation = evaluate_plant(plant, time + along * h, at, command, anchor)
        slope = time_derivative(plant, at, evaluation, command)
        grown = grown + weight * h * ledger_rates(plant, at, evaluation)
        added = slope._replace(chambers=evaluation.conserved_rates)
        return (slope, add_scaled(total, added, weight), grown), (
            evaluation.fluid.volume,
            evaluation.fluid.is_folded,
        )

    # a loop, as four copies of the stage would take four times as long to compile
    zeros = jax.tree.map(lambda x: 0.0 * x, state)
    stages = np.stack([_ALONG, _WEIGHTS], axis=1)
    (_, total, grown), (volumes, folds) = lax.scan(stage, (zeros, zeros, 0.0 * account), stages)
    initial = conserved_state(plant.chamber, state.chambers, state.pressures, volumes[0])
    after = add_scaled(state._replace(chambers=initial), total, h)
    q, _ = plant.load.placed(time + h, after.position, after.velocity)
    end = project_chambers(
        plant, after.chambers, plant.strains(q[..., None]), after.pressures, _NEWTON
    )
    after = after._replace(
        chambers=end.chambers, pressures=end.pressures, supply=plant.supply.switched(after.supply)
    )
    account = account + grown + jnp.stack([end.work, end.mismatch, end.work]) @ _BY_PARTS
    folded |= jnp.any(folds)
    if plant.hysteresis is None:
        return IntegratorState(after, anchor, account, folded)
    anchor, lost = update_friction(plant, anchor, q, after.pressures)
    return IntegratorState(after, anchor, account + lost * _FRICTION, folded)


def add_scaled(state: State, rate: State, h: Batch) -> State:
    """A `state` [SI] after `h` [s] at a `rate` [SI]."""
    return jax.tree.map(lambda x, slope: x + h * slope, state, rate)


def project_pressures(plant: Plant, time: Batch, state: State, steps: int) -> State:
    """A `state` [SI] at `time` [s] whose pressures go with its chambers, in so many `steps` [-] of
    Newton's method.
    """
    q, _ = plant.load.placed(time, state.position, state.velocity)
    eps = plant.strains(q[..., None])
    return state._replace(
        pressures=solve_pressures(plant, state.chambers, eps, state.pressures, steps)
    )

"""Integrating a plant with adaptive steps, open loop: the reference that fixed steps are held to.

Tsitouras' method of order 5 stops at each time at which a command changes, so that no step sees
two of them, and looks none up in a stage. Implicit methods are 6 to 60 times slower here at equal
error, in oil too: half of their steps fail at kinks.

**Source:** Tsitouras (2011), by diffrax (Kidger, 2021).
"""

import math
from itertools import pairwise
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.module import to_numpy
from ..core.types import Batch, Numbers, Values
from ..core.validation import check_positive
from .energy_ledger import LEDGER, ledger_rates, pressure_volume_term
from .equilibrium import equilibrium_state
from .motion import FrictionMemory, evaluate_plant, time_derivative
from .outputs import PlantOutputs, observe
from .plant import Plant
from .schedule import Schedule
from .simulate import Trajectory
from .state import State
from .stepping import project_pressures


_MOST_STEPS = 1_000_000
_NEWTON = 4  # of a step's stages some are far from where the rates led


def integrate(
    plant: Plant,
    schedule: Schedule,
    times: Values,
    start: State | None = None,
    tolerance: float = 1e-8,
) -> Trajectory:
    """A run of adaptive steps under a schedule.

    **Arguments:**

    - `plant`: what moves [-], without a hysteresis that remembers and a pump that is switched.
    - `schedule`: its commands [-].
    - `times`: at which it is seen [s], rising, the first at 0.
    - `start`: the state it begins with [SI]; left out, at `rest` without pressure.
    - `tolerance`: relative, of each number of the state [-]; absolute, of its size.

    **Returns:** a `Trajectory` [SI], of no substeps.

    **Raises:** `ValueError` for times that don't rise, what `simulate` alone can, commands that
    don't fit, what `rest` refuses, and a run that the method gives up.
    """
    if plant.hysteresis is not None and plant.hysteresis.count:
        kind = type(plant.hysteresis).__name__
        remedy = "use `simulate`, or Coulomb's friction"
        raise InvalidInputError("hysteresis", "must remember nothing here", kind, remedy)
    if getattr(plant.supply, "band", None) is not None:
        raise InvalidInputError(
            "supply", "must switch nothing here", "a band", "use `simulate`", shown=""
        )
    plant.checked(schedule.commands)
    t = np.asarray(times, float)
    if t.ndim != 1 or t.size < 2 or t[0] != 0 or np.any(np.diff(t) <= 0):
        raise InvalidInputError("times", "must begin at 0 s and rise", t.shape, shown="other ones")
    tolerance = float(check_positive(tolerance, "tolerance", "-"))
    begin = equilibrium_state(plant) if start is None else start
    size = _scales(plant, begin)
    row = _row(begin, np.zeros(len(LEDGER)))
    row_blocks = [row[None]]
    # each command by itself: a stage can't see the next one
    edges = [*schedule.times[schedule.times < t[-1]], t[-1]]
    seen_at = [np.zeros(1)]
    legs = [(low, high, t[(t > low) & (t <= high)]) for low, high in pairwise(edges)]
    most_points = 1 + max(len(inside) for _, _, inside in legs)
    for low, high, inside in legs:
        output_times = np.unique(np.append(inside, high))
        # as many moments in each leg, so that one compilation serves all
        extra = np.linspace(low, output_times[0], most_points - len(output_times) + 2)[1:-1]
        output_times = np.append(extra, output_times)
        command = schedule.at(low)
        result, rows = _leg(
            plant,
            jnp.asarray(row),
            jnp.asarray(command),
            low,
            jnp.asarray(output_times),
            tolerance,
            jnp.asarray(size),
        )
        if not bool(result):
            raise InvalidInputError(
                "tolerance", f"can't be held: the method gave up between {low:g} and {high:g} s",
                tolerance, "loosen it, or take `simulate`", shown="",
            )  # fmt: skip
        rows = np.asarray(rows)
        row = rows[-1]
        row_blocks.append(rows[np.isin(output_times, inside)])
        seen_at.append(inside)
    solution_rows, moments = np.concatenate(row_blocks), np.concatenate(seen_at)
    commands = schedule.at(moments)
    observed = _look(plant, jnp.asarray(moments), jnp.asarray(solution_rows), jnp.asarray(commands))
    outputs, account, states = to_numpy(observed)
    end = State(*(x[-1] for x in states))
    return Trajectory(moments, outputs, commands, account, 0, None, end)


@jax.jit
def _leg(
    plant: Plant,
    row: Numbers,
    command: Numbers,
    low: Batch,
    output_times: Numbers,
    tolerance: Batch,
    size: Numbers,
) -> tuple[Any, Numbers]:
    import diffrax

    def field(t: Batch, y: Numbers, _: Any) -> Numbers:
        state, _ = _split_row(plant, y)
        state = project_pressures(plant, t, state, _NEWTON)
        evaluation = evaluate_plant(plant, t, state, command, _no_friction_memory(plant, state))
        return _row(
            time_derivative(plant, state, evaluation, command),
            ledger_rates(plant, state, evaluation),
        )

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field), diffrax.Tsit5(), low, output_times[-1], None, row,
        saveat=diffrax.SaveAt(ts=output_times),
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance * size),
        max_steps=_MOST_STEPS, throw=False,
    )  # fmt: skip
    return solution.result == diffrax.RESULTS.successful, solution.ys


@jax.jit
def _look(
    plant: Plant, times: Numbers, rows: Numbers, commands: Numbers
) -> tuple[PlantOutputs, Numbers, State]:
    def one(t: Batch, row: Numbers, c: Numbers) -> tuple[PlantOutputs, Numbers, Numbers, State]:
        state, account = _split_row(plant, row)
        state = project_pressures(plant, t, state, _NEWTON)
        anchor = _no_friction_memory(plant, state)
        evaluation = evaluate_plant(plant, t, state, c, anchor)
        return (
            observe(plant, state, anchor, evaluation),
            account,
            pressure_volume_term(plant, evaluation),
            state,
        )

    outputs, account, extra, states = jax.vmap(one)(times, rows, commands)
    return outputs, account + extra - extra[0], states


def _row(state: State, account: Numbers) -> Numbers:
    """All numbers of a `state` [SI] and an `account` [SI] in one row."""
    xp = array_namespace(*state)
    return xp.concatenate([*(xp.ravel(x) for x in state), account])


def _split_row(plant: Plant, row: Numbers) -> tuple[State, Numbers]:
    """A state and an account of a `row` [SI]."""
    units = plant.units
    shapes = State((), (), (plant.spool.states(units),), (units, plant.chamber.count), (units,),
                   (plant.supply.count,))  # fmt: skip
    ends = np.cumsum([math.prod(shape) for shape in shapes])
    *parts, account = jnp.split(row, ends)
    return State(*(x.reshape(shape) for x, shape in zip(parts, shapes, strict=True))), account


def _no_friction_memory(plant: Plant, state: State) -> FrictionMemory:
    """Friction that remembers nothing."""
    return FrictionMemory(jnp.zeros((plant.units, 0)), state.position, state.pressures)


def _scales(plant: Plant, state: State) -> Numbers:
    """Of each number of a `state` [SI], to which its absolute tolerance is a share."""
    low, high = plant.stroke
    top = np.full(plant.units, plant.supply_pressure)
    full = plant.charged(top, 0.0)
    swept = np.asarray(plant.muscles.at(top, plant.strains(0.0)).volume)
    energy = max(float(np.sum(top * plant.counts * swept)), 1e-12)
    account = np.full(len(LEDGER), energy)
    account[LEDGER.index("mass")] = np.sum(full[..., 0])
    stroke = np.float64(high - low)
    sizes = State(
        stroke, stroke, np.ones(plant.spool.states(plant.units)), full, top,
        np.maximum(np.abs(state.supply), 1e-12),
    )  # fmt: skip
    return _row(sizes, account)

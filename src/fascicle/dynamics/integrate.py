"""Integrating a plant with adaptive steps, open loop: the reference for fixed steps.

Tsitouras' method of order 5 stops at each time at which a command changes, so that no step sees
two commands. Implicit methods are 6 to 60 times slower here at equal error, in oil too: half of
their steps fail at kinks.

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
from .motion import FrictionMemory, State, evaluate_plant, time_derivative
from .outputs import PlantOutputs, observe
from .plant import Plant
from .schedule import Schedule
from .simulate import Trajectory, project_pressures


_MAX_STEPS = 1_000_000  # some minutes: more than a user waits for
_NEWTON = 4  # at some stages of a step the integrated pressures are far off


def integrate(
    plant: Plant,
    schedule: Schedule,
    times: Values,
    start: State | None = None,
    tolerance: float = 1e-8,
) -> Trajectory:
    """Integrate a plant under a schedule of commands by adaptive steps.

    **Arguments:**

    - `plant`: the plant, without a hysteresis with memory and a switched pump.
    - `schedule`: its commands.
    - `times`: of the outputs [s], rising, the first at 0.
    - `start`: the state at the start [SI]; by default, at rest without pressure.
    - `tolerance`: relative, of each number of the state [-]; absolute, of its size.

    **Returns:** a `Trajectory` [SI], of no substeps.

    **Raises:** `ValueError` for times that don't rise, a plant for `simulate` alone, commands that
    don't fit, what `equilibrium_state` refuses, and a tolerance that the method can't meet.
    """
    if plant.hysteresis is not None and plant.hysteresis.count:
        kind = type(plant.hysteresis).__name__
        remedy = "use `simulate`, or Coulomb's friction"
        raise InvalidInputError("hysteresis", "must have no memory here", kind, remedy)
    pump = getattr(plant.supply, "pump", None)
    if pump is not None and np.isfinite(pump.switch_off):
        rule = "must have no switched pump here"
        raise InvalidInputError("supply", rule, pump.switch_off, "use `simulate`", shown="")
    plant.check_commands(schedule.commands)
    t = np.asarray(times, float)
    if t.ndim != 1 or t.size < 2 or t[0] != 0 or np.any(np.diff(t) <= 0):
        raise InvalidInputError("times", "must begin at 0 s and rise", t.shape, shown="others")
    tolerance = float(check_positive(tolerance, "tolerance", "-"))
    begin = equilibrium_state(plant) if start is None else start
    size = _scales(plant, begin)
    row = _pack_row(begin, np.zeros(len(LEDGER)))
    row_blocks = [row[None]]
    # a leg for each command: no stage sees the next one
    acting = schedule.delayed(plant.spool.dead_time)
    edges = [*acting.times[acting.times < t[-1]], t[-1]]
    time_blocks = [np.zeros(1)]
    legs = [(low, high, t[(t > low) & (t <= high)]) for low, high in pairwise(edges)]
    max_points = 1 + max(len(inside) for _, _, inside in legs)
    for low, high, inside in legs:
        output_times = np.unique(np.append(inside, high))
        # as many times in each leg, so that one compilation serves all
        extra = np.linspace(low, output_times[0], max_points - len(output_times) + 2)[1:-1]
        output_times = np.append(extra, output_times)
        command = acting.at(low)
        arrays = (jnp.asarray(x) for x in (row, command, output_times, size))
        success, rows = _integrate_command(plant, low, tolerance, *arrays)
        if not bool(success):
            raise InvalidInputError(
                "tolerance",
                f"can't be met: the method gave up between {low:g} and {high:g} s",
                tolerance,
                "loosen it, or use `simulate`",
                shown="",
            )
        rows = np.asarray(rows)
        row = rows[-1]
        row_blocks.append(
            rows[len(extra) :][: len(inside)]
        )  # without `high`, if nobody asks for it
        time_blocks.append(inside)
    solution_rows, times = np.concatenate(row_blocks), np.concatenate(time_blocks)
    commands = schedule.at(times)
    arrays = (jnp.asarray(x) for x in (times, solution_rows, acting.at(times)))
    outputs, ledger, states = to_numpy(_observe_rows(plant, *arrays))
    end = State(*(x[-1] for x in states))
    return Trajectory(times, outputs, commands, ledger, 0, None, end)


@jax.jit
def _integrate_command(
    plant: Plant,
    low: Batch,
    tolerance: Batch,
    row: Numbers,
    command: Numbers,
    times: Numbers,
    scales: Numbers,
) -> tuple[Any, Numbers]:
    """Integrate under one `command` from `low` [s] on: true if the end was reached, and rows at
    `times` [s]. `scales` of a row's numbers set their absolute tolerances.
    """
    import diffrax

    def field(t: Batch, y: Numbers, _: Any) -> Numbers:
        state, _ = _unpack_row(plant, y)
        state = project_pressures(plant, t, state, _NEWTON)
        evaluation = evaluate_plant(plant, t, state, command, _springless_memory(plant, state))
        rates = time_derivative(plant, state, evaluation, command)
        return _pack_row(rates, ledger_rates(plant, state, evaluation))

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Tsit5(),
        low,
        times[-1],
        None,
        row,
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance * scales),
        max_steps=_MAX_STEPS,
        throw=False,
    )
    return solution.result == diffrax.RESULTS.successful, solution.ys


@jax.jit
def _observe_rows(
    plant: Plant, times: Numbers, rows: Numbers, commands: Numbers
) -> tuple[PlantOutputs, Numbers, State]:
    """Outputs, the ledger with its $P V$ terms since the first row, and states at `times` [s]."""

    def observe_row(t: Batch, row: Numbers, c: Numbers) -> tuple:
        state, ledger = _unpack_row(plant, row)
        state = project_pressures(plant, t, state, _NEWTON)
        friction_memory = _springless_memory(plant, state)
        evaluation = evaluate_plant(plant, t, state, c, friction_memory)
        outputs = observe(plant, state, friction_memory, evaluation)
        return outputs, ledger, pressure_volume_term(plant, evaluation), state

    outputs, ledger, pv_terms, states = jax.vmap(observe_row)(times, rows, commands)
    return outputs, ledger + pv_terms - pv_terms[0], states


def _pack_row(state: State, ledger: Numbers) -> Numbers:
    """Row with all numbers of a `state` [SI] and a `ledger` [SI]."""
    xp = array_namespace(*state)
    return xp.concatenate([*(xp.ravel(x) for x in state), ledger])


def _unpack_row(plant: Plant, row: Numbers) -> tuple[State, Numbers]:
    """State and ledger of a `row` [SI]."""
    units = plant.units
    shapes = State(
        (),
        (),
        (plant.spool.state_count(units),),
        (units, plant.chamber.count),
        (units,),
        (plant.supply.count,),
    )
    ends = np.cumsum([math.prod(shape) for shape in shapes])
    *parts, ledger = jnp.split(row, ends)
    return State(*(x.reshape(shape) for x, shape in zip(parts, shapes, strict=True))), ledger


def _springless_memory(plant: Plant, state: State) -> FrictionMemory:
    """Friction memory of a law without springs, such as Coulomb's: no spring forces [N]."""
    return FrictionMemory(jnp.zeros((plant.units, 0)), state.position, state.pressures)


def _scales(plant: Plant, state: State) -> Numbers:
    """Typical size of each number of a `state` [SI], for its absolute tolerance."""
    low, high = plant.stroke
    top = np.full(plant.units, plant.supply_pressure)
    full = plant.chambers_at(top, 0.0)
    swept = np.asarray(plant.muscles.at(top, plant.strains(0.0)).volume)
    energy = max(float(np.sum(top * plant.counts * swept)), 1e-12)  # J, never zero
    ledger = np.full(len(LEDGER), energy)
    ledger[LEDGER.index("mass")] = np.sum(full[..., 0])
    stroke = np.float64(high - low)
    sizes = State(
        stroke,
        stroke,
        np.ones(plant.spool.state_count(plant.units)),
        full,
        top,
        np.maximum(np.abs(state.supply), 1e-12),  # never zero: no step would meet it
    )
    return _pack_row(sizes, ledger)

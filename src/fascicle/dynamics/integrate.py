"""Integrating a plant with adaptive steps, open loop: the reference for fixed steps.

Tsitouras' method of order 5 stops at each time at which a command changes, so that no step sees
two commands. Implicit methods are 6 to 60 times slower here at equal error, in oil too: half of
their steps fail at kinks.

**Source:** Tsitouras (2011), by diffrax (Kidger, 2021).
"""

import math
from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np

from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.module import to_numpy
from ..core.types import Batch, BoolBatch, Numbers, Values
from ..core.validation import check_positive
from .equilibrium import equilibrium_state
from .motion import PlantEvaluation, State, evaluate_plant, relaxed_friction, time_derivative
from .outputs import LEDGER, PlantOutputs, ledger_rates, observe, pressure_volume_term
from .plant import Plant
from .simulate import Schedule, Trajectory, project_pressures


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

    **Returns:** a `Trajectory` [SI]. **Raises:** `ValueError` for times that don't rise, a plant or
    commands that don't fit, what `equilibrium_state` refuses, and a tolerance that can't be met.
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
    tolerances = tolerance, tolerance * jnp.asarray(_scales(plant, begin))
    row = _pack_row(begin, np.zeros(len(LEDGER)))
    row_blocks = [row[None]]
    # a leg for each command: no stage sees the next one
    acting = schedule.delayed(plant.spool.dead_time)
    edges = [*acting.times[acting.times < t[-1]], t[-1]]
    legs = [(low, high, t[(t > low) & (t <= high)]) for low, high in pairwise(edges)]
    max_points = 1 + max(len(inside) for _, _, inside in legs)
    for low, high, inside in legs:
        leg_times = np.unique(np.append(inside, high))
        # as many times in each leg, so that one compilation serves all
        extra = np.linspace(low, leg_times[0], max_points - len(leg_times) + 2)[1:-1]
        leg_times = jnp.append(extra, leg_times)
        command = jnp.asarray(acting.at(low))
        success, rows = _integrate_leg(plant, low, tolerances, row, command, leg_times)
        if not bool(success):
            rule = f"can't be met: the method gave up between {low:g} and {high:g} s"
            remedy = "loosen it, or use `simulate`"
            raise InvalidInputError("tolerance", rule, tolerance, remedy, shown="")
        rows = np.asarray(rows)
        row = rows[-1]
        # without `high`, if nobody asks for it
        row_blocks.append(rows[len(extra) :][: len(inside)])
    arrays = (jnp.asarray(x) for x in (t, np.concatenate(row_blocks), acting.at(t)))
    outputs, ledger, states = to_numpy(_observe_rows(plant, *arrays))
    end = State(*(x[-1] for x in states))
    return Trajectory(t, outputs, schedule.at(t), ledger, 0, None, end)


@jax.jit
def _integrate_leg(
    plant: Plant, low: Batch, tolerances: tuple, row: Numbers, command: Numbers, times: Numbers
) -> tuple[BoolBatch, Numbers]:
    """Integrate under one `command` from `low` [s] on, with a relative and absolute `tolerances`:
    true if the end was reached, and rows at `times` [s].
    """
    import diffrax

    def field(t: Batch, y: Numbers, _: None) -> Numbers:
        state, _, evaluation = _evaluate_row(plant, t, y, command)
        rates = time_derivative(plant, state, evaluation, command)
        return _pack_row(rates, ledger_rates(plant, state, evaluation))

    problem = diffrax.ODETerm(field), diffrax.Tsit5(), low, times[-1], None, row
    options = {"saveat": diffrax.SaveAt(ts=times), "max_steps": _MAX_STEPS, "throw": False}
    steps = diffrax.PIDController(*tolerances)
    solution = diffrax.diffeqsolve(*problem, stepsize_controller=steps, **options)
    return solution.result == diffrax.RESULTS.successful, solution.ys


@jax.jit
def _observe_rows(
    plant: Plant, times: Numbers, rows: Numbers, commands: Numbers
) -> tuple[PlantOutputs, Numbers, State]:
    """Outputs, the ledger with its $P V$ terms since the first row, and states at `times` [s]."""

    def observe_row(t: Batch, row: Numbers, command: Numbers) -> tuple:
        state, ledger, evaluation = _evaluate_row(plant, t, row, command)
        outputs = observe(plant, state, relaxed_friction(plant, state), evaluation)
        return outputs, ledger, pressure_volume_term(plant, evaluation), state

    outputs, ledger, pv_terms, states = jax.vmap(observe_row)(times, rows, commands)
    return outputs, ledger + pv_terms - pv_terms[0], states


def _evaluate_row(
    plant: Plant, time: Batch, row: Numbers, command: Numbers
) -> tuple[State, Numbers, PlantEvaluation]:
    """State, ledger and evaluation [SI] of a `row`; its friction has no memory."""
    units, spool, supply = plant.units, plant.spool, plant.supply
    chambers = (units, plant.chamber.count)
    shapes = ((), (), (spool.state_count(units),), chambers, (units,), (supply.count,))
    ends = np.cumsum([math.prod(shape) for shape in shapes])
    *parts, ledger = jnp.split(row, ends)
    state = State(*(x.reshape(shape) for x, shape in zip(parts, shapes, strict=True)))
    state = project_pressures(plant, time, state, _NEWTON)
    evaluation = evaluate_plant(plant, time, state, command, relaxed_friction(plant, state))
    return state, ledger, evaluation


def _pack_row(state: State, ledger: Numbers) -> Numbers:
    """Row with all numbers of a `state` [SI] and a `ledger` [SI]."""
    xp = array_namespace(*state)
    return xp.concatenate([*(xp.ravel(x) for x in state), ledger])


def _scales(plant: Plant, state: State) -> Numbers:
    """Typical size of each number of a `state` [SI], for its absolute tolerance."""
    low, high = plant.stroke
    top = np.full(plant.units, plant.supply_pressure)
    full = plant.chambers_at(top, 0.0)
    swept = np.asarray(plant.muscles.at(top, plant.strains(0.0)).volume)
    energy = max(float(np.sum(top * plant.counts * swept)), 1e-12)  # J, never zero
    ledger = np.full(len(LEDGER), energy)
    ledger[LEDGER.index("mass")] = np.sum(full[..., 0])
    stroke, spool = np.float64(high - low), np.ones(plant.spool.state_count(plant.units))
    supply = np.maximum(np.abs(state.supply), 1e-12)  # never zero: no step would meet it
    return _pack_row(State(stroke, stroke, spool, full, top, supply), ledger)

r"""Simulating a plant with its controller, in fixed steps of the classic Runge-Kutta method.

A controller acts once a step of $\Delta t$; its commands are constant until it acts again, so that
no stage of a step sees the next command. Pressures are integrated by (T4) and corrected at the end
of each substep; of chambers the conserved states (T6) are integrated. A step has as many equal
substeps as the stiffest part needs: the method is stable while $h |\lambda| \le 2.78$, and is used
up to 2.

The whole run is one compiled loop, so that it can be batched and differentiated by numbers of the
plant and the controller. Numbers are its arguments: plants of one structure, with equally long
runs, are compiled once. `integrate` is its reference.

**Source:** Kutta (1901).
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..core.errors import InvalidInputError
from ..core.module import to_numpy, with_fields
from ..core.types import Batch, BoolBatch, Numbers, PyTree, Values, Whole
from ..core.validation import check_finite, check_positive, is_concrete
from ..fluid import validate_commands
from .chamber_pressure import (
    ChamberEvaluation,
    conserved_state,
    evaluate_chambers,
    project_chambers,
    solve_pressures,
)
from .equilibrium import equilibrium_state
from .motion import (
    FrictionMemory,
    State,
    evaluate_plant,
    relaxed_friction,
    time_derivative,
    update_friction,
)
from .outputs import LEDGER, STATUS, PlantOutputs, ledger_rates, observe, pressure_volume_term
from .plant import Plant


# leaves of a controller that are arguments of the compiled run; functions and texts are fixed
_NUMBERS = (jax.Array, np.ndarray, np.generic, float, int)
_NEWTON_START = 8  # pressures of a user's `start` may be a rough guess
_NEWTON = 2  # from integrated pressures, two steps leave 1e-12
_NODES, _WEIGHTS = np.array([0.0, 0.5, 0.5, 1.0]), np.array([1, 2, 2, 1]) / 6  # of stages
# entries of the ledger that a substep adds to: friction's loss, and works taken by parts
_FRICTION = np.array([name == "friction" for name in LEDGER], float)
_BY_PARTS = np.array(
    [[name == entry for name in LEDGER] for entry in ("fluid_work", "mismatch", "displaced")], float
)
MAX_SUBSTEPS = 64  # more cost more than a smaller `dt`
# a volume of oil changes most about P = 0, where a table has a line every few pascals and a bend at
# zero: passed within a substep, it leaves an error of work, as the substep squared. In 80 random
# cycles, two substeps left up to 3e-3 of it, sixteen 5e-5, and in two of them more than 1e-5
_LIQUID = 16
_GAS = 2  # with one, crossing the cells of a table leaves 1e-5 of the work; with two 1e-6
_STABLE = 2.0  # largest h|λ|; the method's own limit is 2.78


class Measurement(NamedTuple):
    """Input of a controller: `time` [s]; `position` and `velocity` of the load [SI]; `pressures`
    of the units [Pa]; `force` of all muscles on the load [N or N·m]; `supply_pressure` [Pa].
    """

    time: Batch
    position: Batch
    velocity: Batch
    pressures: Numbers
    force: Batch
    supply_pressure: Batch


# takes its memory, at first its attribute `memory`, a measurement [SI] and the present reference,
# and returns the next memory and commands [-]
Controller = Callable[[PyTree, Measurement, Numbers], tuple[PyTree, Numbers]]


class Schedule:
    """Schedule of valve commands, each constant until the next of its times.

    `times` [s], rising, the first at 0; `commands` [-] in [-1, 1], one row for each of them, one
    column for each motor unit. `ValueError` for others.
    """

    def __init__(self, times: Values, commands: Values):
        self.times = np.atleast_1d(check_finite(times, "times", "s"))
        if self.times[0] != 0:
            raise InvalidInputError("times", "must begin at 0 s", float(self.times[0]))
        if np.any(falls := np.diff(self.times) <= 0):
            before, after = self.times[np.argmax(falls) :][:2]
            text = f"{after:g} s after {before:g} s"
            raise InvalidInputError("times", "must rise", after, shown=text)
        rows = np.asarray(validate_commands(commands, "commands"))
        self.commands = rows[:, None] if rows.ndim == 1 else np.atleast_2d(rows)
        if (count := len(self.commands)) != len(self.times):
            raise InvalidInputError("commands", "must have one row for each time", count)

    def delayed(self, dead_time: float) -> "Schedule":
        """Schedule whose commands come a `dead_time` [s] later, with all valves shut before."""
        if dead_time == 0:
            return self
        times = np.concatenate([[0.0], self.times + dead_time])
        return Schedule(times, np.concatenate([0.0 * self.commands[:1], self.commands]))

    def at(self, time: Values) -> Numbers:
        """Commands [-] in force at each `time` [s]; a column for each motor unit."""
        # 1e-9 s: a step that misses a time by rounding has its command
        index = np.searchsorted(self.times, np.asarray(time) + 1e-9, side="right") - 1
        return self.commands[np.maximum(index, 0)]


class StepSizeEstimate(NamedTuple):
    """Substeps that a plant needs: its fastest `rate` [1/s], the `part` that has it, the `substeps`
    to take in a step, at most 64, and `stiff`: true if it needs more.
    """

    rate: float
    part: str
    substeps: int
    stiff: bool


class Trajectory(NamedTuple):
    """Results of a simulated run, times on the first axis.

    `outputs`: the `PlantOutputs` at each `time` [s]; `commands` from then on [-]; `ledger`:
    energies up to then [J], by the names of `LEDGER`; `substeps` in each step [-]; `step_size`: the
    estimate that chose them, or none; `end`: the state [SI] from which another run can go on, with
    friction relaxed.
    """

    time: Numbers
    outputs: PlantOutputs
    commands: Numbers
    ledger: Numbers
    substeps: int
    step_size: StepSizeEstimate | None
    end: State


def simulate(
    plant: Plant,
    controller: Controller | Schedule | Values,
    reference: Values = None,
    dt: float = 1e-3,
    duration: float | None = None,
    start: State | None = None,
    substeps: int | None = None,
) -> Trajectory:
    """Simulate a plant by fixed steps, with constant commands in each.

    **Arguments:**

    - `plant`: the plant.
    - `controller`: acts at the beginning of each step: a function of its memory, at first its
      attribute `memory`, a `Measurement` and the reference, which returns its next memory and the
      commands; or a `Schedule`; or the commands themselves [-], one row for each step.
    - `reference`: for the controller, one row for each step [-], of any unit.
    - `dt`: a step [s].
    - `duration`: of the run [s], with a `Schedule`; by default, as many steps as there are rows.
    - `start`: the state at the start [SI]; by default, at rest without pressure.
    - `substeps`: of each step; by default those of `estimate_substeps`, as many as the stiffest
      part needs, at most 64, and of a liquid at least 16, so that its energies balance.

    **Returns:** a `Trajectory` [SI]: one time more than there are steps. **Raises:** `ValueError`
    for an invalid `dt` or `duration`, rows that don't fit, and what `equilibrium_state` refuses.
    """
    dt = float(check_positive(dt, "dt", "s", "such as 0.001"))
    begin = equilibrium_state(plant) if start is None else start
    step_size = None
    if substeps is None:
        step_size = estimate_substeps(plant, dt)
        substeps = step_size.substeps
    elif substeps != int(substeps) or not substeps >= 1:
        raise InvalidInputError("substeps", "must be a whole number of at least 1", substeps)
    act, memory, inputs = _prepare_controller(plant, controller, reference, dt, duration)
    leaves, kind = jax.tree.flatten(act)
    constants = tuple(None if isinstance(x, _NUMBERS) else x for x in leaves)
    fixed = kind, constants, round(plant.spool.dead_time / dt)
    numbers = [x if isinstance(x, _NUMBERS) else None for x in leaves]
    # a run needs tables, not bundles, whose schemes and lengths of fits would be compiled anew
    arguments = with_fields(plant, bundles=()), numbers, memory, inputs, begin, np.float64(dt)
    if is_concrete(arguments):
        rows = to_numpy(_run_any_substeps(*arguments, np.int64(substeps), fixed))
    else:
        rows = _run_fixed_substeps(*arguments, int(substeps), fixed)
    outputs, ledger = rows.outputs, rows.ledger
    if step_size is not None and step_size.stiff:
        outputs = outputs._replace(status=outputs.status | (1 << STATUS.index("stiff")))
    end = jax.tree.map(lambda x: x[-1], rows.state)
    times = dt * np.arange(len(inputs) + 1)
    return Trajectory(times, outputs, rows.commands, ledger, int(substeps), step_size, end)


def _prepare_controller(
    plant: Plant,
    controller: PyTree,
    reference: Values,
    dt: float,
    duration: float | None,
) -> tuple[Callable, PyTree, Numbers]:
    """Controller, its first memory, and its input at each step: the reference, or commands."""
    act, memory, name = _follow_reference, (), "commands"
    if callable(controller):
        act, memory, name = controller, getattr(controller, "memory", ()), "reference"
        rows = jnp.asarray(() if reference is None else reference)
    elif isinstance(controller, Schedule):
        end = controller.times[-1] + dt
        if duration is not None:
            end = check_positive(duration, "duration", "s")
        rows = controller.at(dt * np.arange(max(1, round(float(end) / dt))))
    else:
        rows = validate_commands(controller, "commands")
        rows = rows[:, None] if rows.ndim == 1 else rows
    if not len(rows):
        raise InvalidInputError(name, "must have a row for each step", 0, shown="none")
    return act, memory, rows if name == "reference" else plant.check_commands(rows)


def _follow_reference(memory: PyTree, _: Measurement, reference: Numbers) -> tuple[PyTree, Numbers]:
    """Controller that measures nothing, with the commands as its reference."""
    return memory, reference


class _Progress(NamedTuple):
    """State of the plant and its friction [SI]; sums of the `ledger` [kg or J]; true if a chamber
    `folded` since the last row.
    """

    state: State
    friction_memory: FrictionMemory
    ledger: Numbers
    folded: BoolBatch


class _Rows(NamedTuple):
    """Rows of a run, one for each time; without its description, a `Trajectory`."""

    outputs: PlantOutputs
    commands: Numbers
    ledger: Numbers
    state: State


def _run(
    plant: Plant,
    numbers: list[Values],
    memory: PyTree,
    inputs: Numbers,
    begin: State,
    dt: Batch,
    substeps: Whole,
    fixed: tuple[PyTree, tuple, int],
) -> _Rows:
    """Rows of a run of a plant from the state `begin` [SI] by a step for each row of `inputs`.

    `numbers` are the controller's; `fixed`: its structure, its constants, and the steps by which
    the valves' dead time delays a command.
    """
    kind, constants, late = fixed
    leaves = [x if y is None else y for x, y in zip(numbers, constants, strict=True)]
    act = jax.tree.unflatten(kind, leaves)
    state = State(*(jnp.asarray(x, float) for x in begin))
    state = project_pressures(plant, 0.0, state, _NEWTON_START)
    h = dt / substeps
    closed = jnp.zeros(plant.units)  # commands that shut all valves
    pending = jnp.zeros((late, plant.units))  # commands that haven't reached the valves

    # a derivative computes a step again, which takes less memory than storing it
    @partial(jax.checkpoint, prevent_cse=False)
    def step(carry: tuple, row: tuple) -> tuple[tuple, _Rows]:
        """Measure, act, delay the command, and integrate the substeps."""
        progress, memory, command, pending = carry
        time, reference, is_last = row
        state, friction_memory = progress.state, progress.friction_memory
        # no command is known yet: what is measured doesn't depend on it
        evaluation = evaluate_plant(plant, time, state, closed, friction_memory)
        motion, force = evaluation[:2], evaluation.pull  # the muscles' force without friction
        supply = plant.supply.pressure_at(state.supply)
        measurement = Measurement(time, *motion, state.pressures, force, supply)
        memory, action = act(memory, measurement, reference)
        command = jnp.where(is_last, command, action)  # the last command holds at the end, too
        pending = jnp.concatenate([pending, command[None]])
        acting, pending = pending[0], pending[1:]
        evaluation = evaluate_plant(plant, time, state, acting, friction_memory)
        outputs = observe(plant, state, friction_memory, evaluation)
        folded = progress.folded * (1 << STATUS.index("folded"))
        outputs = outputs._replace(status=outputs.status | folded)
        ledger = progress.ledger + pressure_volume_term(plant, evaluation)
        beginning = _Rows(outputs, command, ledger, state)

        progress = progress._replace(folded=jnp.zeros_like(progress.folded))
        progress = lax.fori_loop(
            0, substeps, lambda i, x: _substep(plant, time + i * h, x, acting, h), progress
        )
        return (progress, memory, command, pending), beginning

    friction_memory = relaxed_friction(plant, state)
    progress = _Progress(state, friction_memory, jnp.zeros(len(LEDGER)), jnp.zeros((), bool))
    # one row more for the end, whose step is dropped
    steps = len(inputs)
    times, is_last = dt * jnp.arange(steps + 1), jnp.arange(steps + 1) == steps
    inputs = jnp.concatenate([inputs, inputs[-1:]])
    rows: _Rows
    _, rows = lax.scan(step, (progress, memory, closed, pending), (times, inputs, is_last))
    return rows._replace(ledger=rows.ledger - rows.ledger[0])


# a loop of any number of substeps has no derivative in reverse: there the number is compiled in
_run_any_substeps = jax.jit(_run, static_argnames="fixed")
_run_fixed_substeps = jax.jit(_run, static_argnames=("substeps", "fixed"))


def _substep(
    plant: Plant, time: Batch, progress: _Progress, command: Numbers, h: Batch
) -> _Progress:
    """Advance the `progress` [SI] from `time` [s] by a substep `h` [s], under a `command` [-]."""
    state, friction_memory, ledger, folded = progress

    def stage(carry: tuple, weights: Numbers) -> tuple[tuple, tuple]:
        """Slope of a Runge-Kutta stage, and weighted sums of slopes and of the ledger's rates so
        far; volumes [m³] and folds of its chambers.
        """
        slope, total, growth = carry
        node, weight = weights
        stage_state = _add_scaled(state, slope, node * h)
        evaluation = evaluate_plant(plant, time + node * h, stage_state, command, friction_memory)
        slope = time_derivative(plant, stage_state, evaluation, command)
        growth = growth + weight * h * ledger_rates(plant, stage_state, evaluation)
        total = _add_scaled(total, slope._replace(chambers=evaluation.conserved_rates), weight)
        return (slope, total, growth), (evaluation.fluid.volume, evaluation.fluid.is_folded)

    # a loop, as four copies of the stage would take four times as long to compile
    zeros = jax.tree.map(lambda x: 0.0 * x, state)
    stages = np.stack([_NODES, _WEIGHTS], axis=1)
    (_, total, growth), (volumes, folds) = lax.scan(stage, (zeros, zeros, 0.0 * ledger), stages)
    # from here to the projection, `chambers` holds k of (T6)
    initial = conserved_state(plant.chamber, state.chambers, state.pressures, volumes[0])
    after = _add_scaled(state._replace(chambers=initial), total, h)
    q, _ = plant.load.motion_at(time + h, after.position, after.velocity)
    eps = plant.strains(q[..., None])
    end = project_chambers(plant, after.chambers, eps, after.pressures, _NEWTON)
    supply = plant.supply.update_switch(after.supply)
    after = after._replace(chambers=end.chambers, pressures=end.pressures, supply=supply)
    ledger = ledger + growth + jnp.stack([end.work, end.mismatch, end.work]) @ _BY_PARTS
    folded |= jnp.any(folds)
    if plant.hysteresis is None:
        return _Progress(after, friction_memory, ledger, folded)
    friction_memory, loss = update_friction(plant, friction_memory, q, after.pressures)
    return _Progress(after, friction_memory, ledger + loss * _FRICTION, folded)


def _add_scaled(state: State, rate: State, h: Batch) -> State:
    """Add `h` [s] times a `rate` [SI] to a `state` [SI]."""
    return jax.tree.map(lambda x, slope: x + h * slope, state, rate)


def project_pressures(plant: Plant, time: Batch, state: State, steps: int) -> State:
    """A `state` [SI] at `time` [s] with its chambers' pressures, in `steps` of Newton's method."""
    q, _ = plant.load.motion_at(time, state.position, state.velocity)
    eps = plant.strains(q[..., None])
    pressures = solve_pressures(plant, state.chambers, eps, state.pressures, steps)
    return state._replace(pressures=pressures)


def estimate_substeps(plant: Plant, dt: float) -> StepSizeEstimate:
    """Estimate the substeps that a step of `dt` [s] of a `plant` needs."""
    with np.errstate(all="ignore"):  # of branches that aren't taken
        rates = _chamber_rates(plant) | _load_rates(plant)
    part = max(rates, key=lambda name: rates[name])
    need = max(_LIQUID if plant.liquid else _GAS, math.ceil(dt * rates[part] / _STABLE))
    return StepSizeEstimate(rates[part], part, min(need, MAX_SUBSTEPS), need > MAX_SUBSTEPS)


def _chamber_rates(plant: Plant) -> dict[str, float]:
    """Fastest decay of a chamber's pressure through open valves, and of a spool [1/s], by name."""
    top, chamber = plant.supply_pressure, plant.chamber
    # flow is steepest where pressures are nearly equal
    guess = top * np.logspace(-6, 0, 61)
    P = np.concatenate([[0.0], guess, (top - guess)[:-1]])[:, None, None]
    room, T_a = chamber.room_pressure, chamber.room_temperature
    T_s = plant.supply.temperature_at(plant.supply.initial_state())
    c_p = 0.0 if plant.liquid else chamber.gas.c_p
    s, fluid = _rest_evaluations(plant, P, position_count=7)
    rate, no_flow = (chamber.rates(s, P, m, m * c_p * T_a, 0.0) for m in (1.0, 0.0))
    rise = fluid.pressure_rate(rate - no_flow, np.zeros(1))  # of pressure with mass [Pa/kg]
    step = 1e-4 * np.maximum(P, 1e-6 * top)  # small beside each pressure, and never zero
    p_low, p_high, p_top = P + room - step, P + room + step, top + room
    flow, vent = plant.valve.flow, plant.exhaust_valve.flow
    filling = np.abs(flow(p_top, p_high, T_s, T_a) - flow(p_top, p_low, T_s, T_a))
    venting = np.abs(vent(p_high, room, T_a, T_a) - vent(p_low, room, T_a, T_a))
    rates = np.maximum(filling, venting) / (2 * step) * rise
    rates = {"a chamber and its valve": np.max(np.where(fluid.pressure_slope > 0, rates, 0.0))}
    if (time_constant := getattr(plant.spool, "time_constant", None)) is not None:
        rates["a spool"] = np.max(1 / np.asarray(time_constant))
    return {name: float(rate) for name, rate in rates.items()}


def _load_rates(plant: Plant) -> dict[str, float]:
    """Fastest swing of a load on its muscles with valves shut, and on its stop, and fastest decay
    by its dampers [1/s].
    """
    load, n, L, g = plant.load, plant.counts, plant.lengths, plant.gains
    if load.prescribed:
        return {}
    M = float(load.inertia)
    P = np.linspace(0.0, plant.supply_pressure, 31)[:, None, None]
    s, fluid = _rest_evaluations(plant, P, position_count=41)
    muscles, rise = fluid.muscles, fluid.pressure_rate(np.zeros_like(s), np.ones(1))
    spring = -n * L * g**2 * (muscles.force_by_strain + muscles.force_by_pressure * rise)
    stiffness = np.abs(np.sum(spring, axis=-1, keepdims=True))
    stiff = float(np.nanmax(np.where(fluid.pressure_slope > 0, stiffness, 0.0)))
    if plant.hysteresis is not None and hasattr(plant.hysteresis, "stiffness"):
        stiff += float(np.sum(n * (L * g) ** 2) * np.sum(np.asarray(plant.hysteresis.stiffness)))
    damping = float(load.damping)
    if plant.damping is not None:  # linear in pressure: it is largest at an end of its range
        ends = np.array([0.0, plant.supply_pressure])[:, None]
        ways = [plant.damping.coefficient(np.float64(way), ends) for way in (1, -1)]
        damping += float(np.sum(n * (L * g) ** 2 * np.max(ways, axis=(0, 1))))
    rates = {
        "the load on its muscles": math.sqrt((stiff + float(load.stiffness)) / M),
        "dampers of load and muscles": damping / M,
    }
    if load.stop:
        rates["the stop"] = math.sqrt(float(load.stop.stiffness) / M) + float(load.stop.damping) / M
    return rates


def _rest_evaluations(
    plant: Plant, pressures: Numbers, position_count: int
) -> tuple[Numbers, ChamberEvaluation]:
    """States of chambers [SI] at rest, and their evaluation, at `pressures` [Pa] and
    `position_count` even positions along the stroke.
    """
    q = np.linspace(*plant.stroke, position_count)
    P, eps = np.broadcast_arrays(pressures, plant.strains(q[:, None]))
    s = plant.chambers_at(P, q)
    return s, evaluate_chambers(plant, s, eps, P)

r"""Simulating a plant with its controller, in fixed steps of the classic Runge-Kutta method.

A controller acts once a step of $\Delta t$; its commands are constant until it acts again, so that
no stage of a step sees the next command. Pressures are integrated by (T4) and corrected at the end
of each substep; of chambers the conserved states (T6) are integrated.

The whole run is one compiled loop, so that it can be batched and differentiated by numbers of the
plant and the controller. Numbers are its arguments: plants of one structure, with equally long
runs, are compiled once. `integrate` is its reference.

**Source:** Kutta (1901).
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..core.errors import InvalidInputError
from ..core.module import to_numpy, with_fields
from ..core.types import Batch, BoolBatch, Numbers, Values
from ..core.validation import check_positive, is_concrete
from ..fluid import validate_commands
from .chamber_pressure import conserved_state, project_chambers, solve_pressures
from .energy_ledger import LEDGER, ledger_rates, pressure_volume_term
from .equilibrium import equilibrium_state
from .motion import FrictionMemory, State, evaluate_plant, time_derivative, update_friction
from .outputs import STATUS, PlantOutputs, observe
from .plant import Plant
from .schedule import Controller, Measurement, Schedule
from .step_size import StepSizeEstimate, estimate_substeps


# leaves of a controller that are arguments of the compiled run; functions and texts are fixed
_NUMBERS = (jax.Array, np.ndarray, np.generic, float, int)
_NEWTON_START = 8  # pressures of a user's `start` may be a rough guess
_NEWTON = 2  # from integrated pressures, two steps leave 1e-12
_TIMES, _WEIGHTS = np.array([0.0, 0.5, 0.5, 1.0]), np.array([1, 2, 2, 1]) / 6  # of stages
# entries of the ledger that a substep adds to: friction's loss, and works taken by parts
_FRICTION = np.array([name == "friction" for name in LEDGER], float)
_BY_PARTS = np.array(
    [[name == entry for name in LEDGER] for entry in ("fluid_work", "mismatch", "displaced")], float
)


class IntegratorState(NamedTuple):
    """State of an integration between two steps: the plant's state, friction, and energy sums.

    `state` of the plant [SI]; its `friction_memory` [SI]; entries of the `LEDGER`, the mass [kg]
    and energies [J]; `folded`: true if a chamber's volume fell with pressure by more than its fluid
    and hose expand.
    """

    state: State
    friction_memory: FrictionMemory
    ledger: Numbers
    folded: BoolBatch


def substep(
    plant: Plant, time: Batch, progress: IntegratorState, command: Numbers, h: Batch
) -> IntegratorState:
    """Advance the `progress` [SI] of a `plant` from `time` [s] by a substep of `h` [s], under a
    `command` [-].
    """
    state, friction_memory, ledger, folded = progress

    def stage(carry: tuple, weights: Numbers) -> tuple[tuple, tuple]:
        """One Runge-Kutta stage: its slope, with the weighted sums of slopes and of the ledger's
        rates so far; and volumes [m³] and folds of its chambers.
        """
        slope, total, growth = carry
        delay, weight = weights
        stage_state = add_scaled(state, slope, delay * h)
        evaluation = evaluate_plant(plant, time + delay * h, stage_state, command, friction_memory)
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
        return IntegratorState(after, friction_memory, ledger, folded)
    friction_memory, loss = update_friction(plant, friction_memory, q, after.pressures)
    return IntegratorState(after, friction_memory, ledger + loss * _FRICTION, folded)


def add_scaled(state: State, rate: State, h: Batch) -> State:
    """Add `h` [s] times a `rate` [SI] to a `state` [SI]."""
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


class Trajectory(NamedTuple):
    """Results of a simulated run, times on the first axis.

    `time` [s]; `outputs`: the `PlantOutputs` at each time; `commands` from then on [-]; `ledger`:
    energies up to then [J], by the names of `LEDGER`; `substeps` in each step [-]; `step_size`: the
    `StepSizeEstimate` that chose them, or none; `end`: the state [SI] from which another run can
    go on, with friction relaxed.
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
    - `controller`: acts at the beginning of each step; or a `Schedule`; or the commands
      themselves [-], one row for each step.
    - `reference`: for the controller, one row for each step [-], of any unit.
    - `dt`: a step [s].
    - `duration`: of the run [s], with a `Schedule`; by default, as many steps as there are rows.
    - `start`: the state at the start [SI]; by default, at rest without pressure.
    - `substeps`: of each step; by default those of `estimate_substeps`, as many as the stiffest
      part needs, at most 64, and of a liquid at least 16, so that its energies balance.

    **Returns:** a `Trajectory` [SI]: one time more than there are steps.

    **Raises:** `ValueError` for an invalid `dt` or `duration`, rows that don't fit, and what
    `equilibrium_state` refuses.
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
    if not len(inputs):
        name = "reference" if callable(controller) else "commands"
        raise InvalidInputError(name, "must have a row for each step", 0, shown="none")
    leaves, kind = jax.tree.flatten(act)
    others = tuple(None if isinstance(x, _NUMBERS) else x for x in leaves)
    fixed = kind, others, round(plant.spool.dead_time / dt)
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


def _follow_reference(memory: Any, measurement: Measurement, reference: Numbers) -> tuple:
    """Controller that measures nothing, with the commands as its reference."""
    del measurement
    return memory, reference


def _prepare_controller(
    plant: Plant, controller: Any, reference: Values, dt: float, duration: float | None
) -> tuple[Any, Any, Numbers]:
    """Controller, its first memory, and its input at each step: the `reference`, or the commands of
    a schedule or array, which run open loop.
    """
    if callable(controller):
        if reference is None:
            rule = "must have a row for each step"
            raise InvalidInputError("reference", rule, None, shown="none")
        return controller, getattr(controller, "memory", ()), jnp.asarray(reference)
    if isinstance(controller, Schedule):
        end = controller.times[-1] + dt
        if duration is not None:
            end = check_positive(duration, "duration", "s")
        rows = controller.at(dt * np.arange(max(1, round(float(end) / dt))))
    else:
        rows = validate_commands(controller, "commands")
        rows = rows[:, None] if rows.ndim == 1 else rows
    return _follow_reference, (), plant.check_commands(rows)


class _Rows(NamedTuple):
    """Rows of a run, one for each time; without its description, a `Trajectory`."""

    outputs: PlantOutputs
    commands: Numbers
    ledger: Numbers
    state: State


def _run(
    plant: Plant,
    numbers: list[Any],
    memory: Any,
    inputs: Numbers,
    begin: State,
    dt: Batch,
    substeps: Any,
    fixed: tuple[Any, tuple[Any, ...], int],
) -> _Rows:
    """Rows of a run of a plant from the state `begin` [SI] by a step for each row of `inputs`.

    `numbers` and `fixed` are the controller's parts: arrays, and what doesn't change, such as its
    structure; and the steps by which the valves' dead time delays a command.
    """
    kind, others, late = fixed
    act = jax.tree.unflatten(
        kind, [x if y is None else y for x, y in zip(numbers, others, strict=True)]
    )
    hysteresis = plant.hysteresis
    spring_forces = jnp.zeros((plant.units, 0 if hysteresis is None else hysteresis.count))
    state = project_pressures(
        plant, 0.0, State(*(jnp.asarray(x, float) for x in begin)), _NEWTON_START
    )
    friction_memory = FrictionMemory(spring_forces, state.position, state.pressures)
    h = dt / substeps
    closed = jnp.zeros(plant.units)  # commands that shut all valves
    pending = jnp.zeros((late, plant.units))  # commands that haven't reached the valves

    # a derivative computes a step again, which takes less memory than storing it
    @partial(jax.checkpoint, prevent_cse=False)
    def step(carry: tuple, row: tuple) -> tuple[tuple, _Rows]:
        """One step: the state after it, and the row of its beginning."""
        progress, memory, command, pending = carry
        time, reference, is_last = row
        state, friction_memory = progress.state, progress.friction_memory
        evaluation = evaluate_plant(plant, time, state, closed, friction_memory)
        measurement = Measurement(  # its force is the muscles' pull without friction
            time,
            evaluation.position,
            evaluation.velocity,
            state.pressures,
            evaluation.pull,
            plant.supply.pressure_at(state.supply),
        )
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

        def advance(i: Any, progress: IntegratorState) -> IntegratorState:
            return substep(plant, time + i * h, progress, acting, h)

        progress = progress._replace(folded=jnp.zeros_like(progress.folded))
        progress = lax.fori_loop(0, substeps, advance, progress)
        return (progress, memory, command, pending), beginning

    progress = IntegratorState(state, friction_memory, jnp.zeros(len(LEDGER)), jnp.zeros((), bool))
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

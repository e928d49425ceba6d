r"""Simulating a plant with its controller, in fixed steps of the classic Runge-Kutta method.

A controller acts once a step of $\Delta t$; its commands are constant until it acts again, so that
no stage of a step sees the next command. Pressures are integrated by (T4) and corrected at the end
of each substep; of chambers the conserved states (T6) are integrated.

The whole run is one compiled loop, so that it can be batched and differentiated by numbers of the
plant and the controller; `integrate` is its reference.

**Source:** Kutta (1901).
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..core.errors import InvalidInputError
from ..core.module import Module, to_numpy
from ..core.types import Batch, BoolBatch, Numbers, Values
from ..core.validation import check_positive, is_concrete
from ..fluid import validate_commands
from .chamber_pressure import conserved_state, project_chambers, solve_pressures
from .energy_ledger import LEDGER, ledger_rates, pressure_volume_term
from .equilibrium import equilibrium_state
from .motion import FrictionMemory, evaluate_plant, time_derivative, update_friction
from .muscles import MuscleTables
from .outputs import STATUS, PlantOutputs, observe
from .plant import Plant, State
from .schedule import Controller, Measurement, Schedule
from .step_size import StepSizeEstimate, estimate_substeps


_NUMBERS = (
    jax.Array,
    np.ndarray,
    np.generic,
    float,
    int,
)  # leaves of a controller that may be differentiated
_NEWTON_START = 8  # pressures of a user's `start` may be a rough guess
_NEWTON = 2  # from integrated pressures, two steps leave 1e-12
_TIMES, _WEIGHTS = np.array([0.0, 0.5, 0.5, 1.0]), np.array([1, 2, 2, 1]) / 6  # of stages
# entries of the ledger that a substep adds to: friction's loss, and works taken by parts
_FRICTION = np.array([name == "friction" for name in LEDGER], float)
_BY_PARTS = np.array([[name == entry for name in LEDGER] for entry in
                      ("fluid_work", "mismatch", "displaced")], float)  # fmt: skip
_MIN_BITS, _MANY_BITS = 10, 16  # of a number of steps: least, and from which memory counts
_CHUNK = 20_000  # steps at once: their cells of the tables take some megabytes


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
    fixed = tuple(None if isinstance(x, _NUMBERS) else x for x in leaves)
    numbers = [x if isinstance(x, _NUMBERS) else None for x in leaves]
    is_concrete_run = is_concrete((plant, numbers, memory, inputs, begin))
    steps, count = len(inputs), None
    if is_concrete_run:
        # a power of four, or of two for many: another length mostly compiles nothing
        count, bits = np.int64(steps), max(_MIN_BITS, (steps - 1).bit_length())
        length = 1 << (bits + bits % 2 if bits < _MANY_BITS else bits)
        inputs = np.concatenate([inputs, np.repeat(inputs[-1:], length - steps, axis=0)])
    numbered = plant, numbers, memory, inputs, begin, np.float64(dt), count
    history, commands, last = _run_rows(*numbered, (fixed, kind), int(substeps))
    xp = jnp
    if is_concrete_run:
        history, commands, last = to_numpy((history, commands, last))
        history, commands = jax.tree.map(lambda x: x[:steps], (history, commands))
        xp = np
    history = jax.tree.map(lambda rows, row: xp.concatenate([rows, row[None]]), history, last)
    commands = xp.concatenate([commands, commands[-1:]])
    tables = isinstance(getattr(plant.muscles, "muscles", plant.muscles), MuscleTables)
    # tables need no compiler, which would take as long again as for the run
    observe_run = _observe_run_numpy if is_concrete_run and tables else _observe_run_jax
    outputs, pv_terms = observe_run(plant, dt, history, commands)
    if is_concrete_run:
        outputs, pv_terms = to_numpy((outputs, pv_terms))
    ledger = history.ledger + pv_terms - pv_terms[0]
    if step_size is not None and step_size.stiff:
        outputs = outputs._replace(status=outputs.status | (1 << STATUS.index("stiff")))
    return Trajectory(
        dt * np.arange(steps + 1), outputs, commands, ledger, int(substeps), step_size, last.state
    )


class _OpenLoop(Module):
    """Controller that takes its reference as the commands."""


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
    return _OpenLoop(), (), plant.check_commands(rows)


@partial(jax.jit, static_argnames=("fixed", "substeps"))
def _run_rows(
    plant: Plant, numbers: list[Any], memory: Any, inputs: Numbers, begin: State, dt: Batch,
    count: Any, fixed: tuple[tuple[Any, ...], Any], substeps: int,
) -> tuple[IntegratorState, Numbers, IntegratorState]:  # fmt: skip
    """Run a plant for the first `count` rows of `inputs`, or all: states of the integration before
    each step, commands, and the state after the last step.

    `numbers` and `fixed` are the controller's parts: arrays, and what doesn't change, such as its
    structure.
    """
    leaves, kind = fixed
    act = jax.tree.unflatten(
        kind, [x if y is None else y for x, y in zip(numbers, leaves, strict=True)]
    )
    hysteresis = plant.hysteresis
    spring_forces = jnp.zeros((plant.units, 0 if hysteresis is None else hysteresis.count))
    state = project_pressures(
        plant, 0.0, State(*(jnp.asarray(x, float) for x in begin)), _NEWTON_START
    )
    friction_memory = FrictionMemory(spring_forces, state.position, state.pressures)
    h = dt / substeps

    def step(carry: tuple, row: tuple) -> tuple[tuple, tuple]:
        progress, memory = carry
        time, reference = row
        if isinstance(act, _OpenLoop):  # which measures nothing
            command = reference
        else:
            state, no_command = progress.state, jnp.zeros(plant.units)
            evaluation = evaluate_plant(plant, time, state, no_command, progress.friction_memory)
            measurement = Measurement(  # its force is the muscles' pull without friction
                time, evaluation.position, evaluation.velocity, state.pressures, evaluation.pull,
                plant.supply.pressure_at(state.supply),
            )  # fmt: skip
            memory, command = act(memory, measurement, reference)

        # a derivative computes a substep again, which takes less memory than storing it
        @partial(jax.checkpoint, prevent_cse=False)
        def advance(i: Any, progress: IntegratorState) -> IntegratorState:
            return substep(plant, time + i * h, progress, command, h)

        initial = progress._replace(folded=jnp.zeros_like(progress.folded))
        return (lax.fori_loop(0, substeps, advance, initial), memory), (progress, command)

    initial = (
        IntegratorState(state, friction_memory, jnp.zeros(len(LEDGER)), jnp.zeros((), bool)),
        memory,
    )
    (last, _), (history, commands) = _scan(
        step, initial, (dt * jnp.arange(len(inputs)), inputs), count
    )
    return history, commands, last


def _scan(step: Callable, initial: Any, inputs: Any, count: Any) -> tuple[Any, Any]:
    """Result of `lax.scan` over the first `count` steps, or over all if it is `None`."""
    if count is None:
        return lax.scan(step, initial, inputs)
    step = jax.jit(step, inline=True)  # traced once for both
    row = jax.tree.map(lambda x: x[0], inputs)
    shapes = jax.eval_shape(step, initial, row)[1]
    rows = len(jax.tree.leaves(inputs)[0])

    def advance(i: Any, state: tuple) -> tuple:
        carry, history = state
        row = jax.tree.map(lambda x: lax.dynamic_index_in_dim(x, i, keepdims=False), inputs)
        carry, row = step(carry, row)
        history = jax.tree.map(
            lambda table, x: lax.dynamic_update_index_in_dim(table, x, i, 0), history, row
        )
        return carry, history

    empty = jax.tree.map(lambda x: jnp.zeros((rows, *x.shape), x.dtype), shapes)
    return lax.fori_loop(0, count, advance, (initial, empty))


def _observe_step(
    plant: Plant, time: Batch, progress: IntegratorState, command: Numbers
) -> tuple[PlantOutputs, Numbers]:
    """Outputs of a plant at a `time` [s], and the `pressure_volume_term` of its ledger [J]."""
    evaluation = evaluate_plant(plant, time, progress.state, command, progress.friction_memory)
    outputs = observe(plant, progress.state, progress.friction_memory, evaluation)
    folded = progress.folded * (1 << STATUS.index("folded"))
    return outputs._replace(status=outputs.status | folded), pressure_volume_term(plant, evaluation)


@jax.jit
def _observe_run_jax(
    plant: Plant, dt: Batch, history: IntegratorState, commands: Numbers
) -> tuple[PlantOutputs, Numbers]:
    """Outputs and `pressure_volume_term` [J] at each step of a run, by JAX; `dt` [s]."""
    times = dt * jnp.arange(len(commands))
    return jax.vmap(partial(_observe_step, plant))(times, history, commands)


def _observe_run_numpy(
    plant: Plant, dt: Batch, history: IntegratorState, commands: Numbers
) -> tuple[PlantOutputs, Numbers]:
    """Outputs and `pressure_volume_term` [J] at each step of a run, by NumPy; `dt` [s]."""
    times = dt * np.arange(len(commands))
    plant = jax.tree.map(lambda x: np.asarray(x)[()] if isinstance(x, jax.Array) else x, plant)
    chunks = []
    with np.errstate(all="ignore"):  # of branches that aren't taken
        for k in range(0, len(times), _CHUNK):
            chunk = slice(k, k + _CHUNK)
            progress = jax.tree.map(lambda x, chunk=chunk: x[chunk], history)
            chunks.append(_observe_step(plant, times[chunk], progress, commands[chunk]))
    return jax.tree.map(lambda *arrays: np.concatenate(arrays), *chunks)

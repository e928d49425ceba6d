"""Simulating a plant with its controller, step by step.

The whole run is one compiled loop of fixed steps, so that it can be batched and differentiated by
whatever the plant and the controller hold; `integrate` is the reference that it is held against.
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
from ..core.types import Batch, Numbers, Values
from ..core.validation import check_positive, is_concrete
from ..fluid import validate_commands
from .energy_ledger import LEDGER, pressure_volume_term
from .equilibrium import equilibrium_state
from .motion import FrictionMemory, evaluate_plant
from .muscles import Tables
from .outputs import STATUS, PlantOutputs, observe
from .plant import Plant
from .schedule import Controller, Measurement, Schedule
from .state import State
from .step_size import StepSizeEstimate, estimate_substeps
from .stepping import IntegratorState, project_pressures, substep


_NUMBERS = (jax.Array, np.ndarray, np.generic, float, int)


_NEWTON = 8  # a state that is given may be off
_LEAST, _MUCH = 10, 16  # powers of two of steps
_AT_ONCE = 20_000  # moments, of which tables' cells fill some megabytes


class Trajectory(NamedTuple):
    """A run, moments on the first axis.

    `time` [s]; `seen`: the `PlantOutputs` at each moment; `commands` from then on [-]; `account`:
    energies up to then [J], by the names of `LEDGER`; `substeps` in each step [-]; `pace`: the
    `StepSizeEstimate`, where it was made; `end`: the state [SI] from which another run can go on,
    with friction relaxed.
    """

    time: Numbers
    seen: PlantOutputs
    commands: Numbers
    account: Numbers
    substeps: int
    pace: StepSizeEstimate | None
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
    """A run of fixed steps, the commands held in each.

    **Arguments:**

    - `plant`: what moves [-].
    - `controller`: acts at the beginning of each step [-]; or a `Schedule`; or the commands [-]
      themselves, one row for each step.
    - `reference`: for the controller, one row for each step, of any unit [-].
    - `dt`: a step [s].
    - `duration`: of the run [s], with a `Schedule`; left out, as many steps as there are rows.
    - `start`: the state it begins with [SI]; left out, at `rest` without pressure.
    - `substeps`: in each step [-]; left out, as many as `pace` tells: what its stiffest part
      needs, at most 64, and of a liquid at least 16, so that its energies balance.

    **Returns:** a `Trajectory` [SI]: one moment more than there are steps.

    **Raises:** `ValueError` for a `dt` or `duration` that can't be, rows that don't fit, and what
    `rest` refuses.
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
    # numbers that a controller holds may be differentiated; all else about it is fixed
    leaves, kind = jax.tree.flatten(act)
    fixed = tuple(None if isinstance(x, _NUMBERS) else x for x in leaves)
    numbers = [x if isinstance(x, _NUMBERS) else None for x in leaves]
    is_known, steps, count = is_concrete((plant, numbers, memory, inputs, begin)), len(inputs), None
    if is_known:  # so that another length mostly compiles nothing
        count = np.int64(steps)
        inputs = np.concatenate(
            [inputs, np.repeat(inputs[-1:], _padded_steps(steps) - steps, axis=0)]
        )
    numbered = plant, numbers, memory, inputs, begin, np.float64(dt), count
    history, commands, last = _run(*numbered, (fixed, kind), int(substeps))
    xp = jnp
    if is_known:
        history, commands, last = to_numpy((history, commands, last))
        history, commands = jax.tree.map(lambda x: x[:steps], (history, commands))
        xp = np
    history = jax.tree.map(lambda many, one: xp.concatenate([many, one[None]]), history, last)
    commands = xp.concatenate([commands, commands[-1:]])
    tables = isinstance(getattr(plant.muscles, "muscles", plant.muscles), Tables)
    # tables are asked without a compiler, which would take as long again as for the run
    outputs, pv_terms = (_observe_numpy if is_known and tables else _observe_jax)(
        plant, dt, history, commands
    )
    outputs, pv_terms = to_numpy((outputs, pv_terms)) if is_known else (outputs, pv_terms)
    account = history.account + pv_terms - pv_terms[0]
    if step_size is not None and step_size.stiff:
        outputs = outputs._replace(status=outputs.status | (1 << STATUS.index("stiff")))
    return Trajectory(
        dt * np.arange(steps + 1), outputs, commands, account, int(substeps), step_size, last.state
    )


class _OpenLoop(Module):
    """No controller: the reference is what is commanded."""


def _prepare_controller(
    plant: Plant, controller: Any, reference: Values, dt: float, duration: float | None
) -> tuple[Any, Any, Numbers]:
    """Controller, memory to begin with, and a row for each step."""
    if callable(controller):
        if reference is None:
            raise InvalidInputError(
                "reference", "must have a row for each step", None, shown="none"
            )
        return controller, getattr(controller, "memory", ()), jnp.asarray(reference)
    if isinstance(controller, Schedule):
        end = (
            controller.times[-1] + dt
            if duration is None
            else check_positive(duration, "duration", "s")
        )
        rows = controller.at(dt * np.arange(max(1, round(float(end) / dt))))
    else:
        rows = validate_commands(controller, "commands")
        rows = rows[:, None] if rows.ndim == 1 else rows
    return _OpenLoop(), (), plant.checked(rows)


@partial(jax.jit, static_argnames=("fixed", "substeps"))
def _run(
    plant: Plant, numbers: list[Any], memory: Any, inputs: Numbers, begin: State, dt: Batch,
    count: Any, fixed: tuple[tuple[Any, ...], Any], substeps: int,
) -> tuple[IntegratorState, Numbers, IntegratorState]:  # fmt: skip
    """Before each step, commanded in it, and after the last: a row of `inputs` for each, of which
    `count` are made; all of them, where it is none.
    """
    leaves, kind = fixed
    act = jax.tree.unflatten(
        kind, [x if y is None else y for x, y in zip(numbers, leaves, strict=True)]
    )
    hysteresis = plant.hysteresis
    spring_forces = jnp.zeros((plant.units, 0 if hysteresis is None else hysteresis.count))
    state = project_pressures(plant, 0.0, State(*(jnp.asarray(x, float) for x in begin)), _NEWTON)
    anchor = FrictionMemory(spring_forces, state.position, state.pressures)
    h = dt / substeps

    def step(carry: tuple, numbers: tuple) -> tuple[tuple, tuple]:
        course, memory = carry
        time, reference = numbers
        if isinstance(act, _OpenLoop):  # which measures nothing
            command = reference
        else:
            memory, command = act(memory, _measure(plant, time, course), reference)

        # a derivative goes through a substep again, instead of keeping all that is in it
        @partial(jax.checkpoint, prevent_cse=False)
        def sub(i: Any, evaluation: IntegratorState) -> IntegratorState:
            return substep(plant, time + i * h, evaluation, command, h)

        initial = course._replace(folded=jnp.zeros_like(course.folded))
        return (lax.fori_loop(0, substeps, sub, initial), memory), (course, command)

    initial = IntegratorState(state, anchor, jnp.zeros(len(LEDGER)), jnp.zeros((), bool)), memory
    (last, _), (history, commands) = _scan(
        step, initial, (dt * jnp.arange(len(inputs)), inputs), count
    )
    return history, commands, last


def _scan(step: Callable, initial: Any, inputs: Any, count: Any) -> tuple[Any, Any]:
    """Result of `lax.scan` over the first `count` steps; over all where `count` is `None`."""
    if count is None:
        return lax.scan(step, initial, inputs)
    step = jax.jit(step, inline=True)  # traced once for both
    row = jax.tree.map(lambda x: x[0], inputs)
    shapes = jax.eval_shape(step, initial, row)[1]
    room = len(jax.tree.leaves(inputs)[0])

    def stepped(i: Any, evaluation: tuple) -> tuple:
        carry, history = evaluation
        carry, outputs_row = step(
            carry, jax.tree.map(lambda x: lax.dynamic_index_in_dim(x, i, keepdims=False), inputs)
        )
        return carry, jax.tree.map(
            lambda x, one: lax.dynamic_update_index_in_dim(x, one, i, 0), history, outputs_row
        )

    empty = jax.tree.map(lambda x: jnp.zeros((room, *x.shape), x.dtype), shapes)
    return lax.fori_loop(0, count, stepped, (initial, empty))


def _padded_steps(steps: int) -> int:
    """For how many steps there is room in a program that makes so many: a power of four, where
    that takes little memory, or of two.
    """
    bits = max(_LEAST, (steps - 1).bit_length())
    return 1 << (bits + bits % 2 if bits < _MUCH else bits)


def _observe_step(
    plant: Plant, time: Batch, course: IntegratorState, command: Numbers
) -> tuple[PlantOutputs, Numbers]:
    """Outputs of a plant, and the $P V$ terms of its ledger [J]."""
    evaluation = evaluate_plant(plant, time, course.state, command, course.anchor)
    outputs = observe(plant, course.state, course.anchor, evaluation)
    folded = course.folded * (1 << STATUS.index("folded"))
    return outputs._replace(status=outputs.status | folded), pressure_volume_term(plant, evaluation)


@jax.jit
def _observe_jax(
    plant: Plant, dt: Batch, history: IntegratorState, commands: Numbers
) -> tuple[PlantOutputs, Numbers]:
    times = dt * jnp.arange(len(commands))
    return jax.vmap(partial(_observe_step, plant))(times, history, commands)


def _observe_numpy(
    plant: Plant, dt: Batch, history: IntegratorState, commands: Numbers
) -> tuple[PlantOutputs, Numbers]:
    times = dt * np.arange(len(commands))
    plant = jax.tree.map(lambda x: np.asarray(x)[()] if isinstance(x, jax.Array) else x, plant)
    outputs_row = []
    with np.errstate(all="ignore"):  # of branches that aren't taken
        for k in range(0, len(times), _AT_ONCE):
            chunk = slice(k, k + _AT_ONCE)
            part = jax.tree.map(lambda x, chunk=chunk: x[chunk], history)
            outputs_row.append(_observe_step(plant, times[chunk], part, commands[chunk]))
    return jax.tree.map(lambda *parts: np.concatenate(parts), *outputs_row)


def _measure(plant: Plant, time: Batch, course: IntegratorState) -> Measurement:
    state = course.state
    evaluation = evaluate_plant(plant, time, state, jnp.zeros(plant.commands), course.anchor)
    # what all muscles pull with, friction not in it
    return Measurement(
        time, evaluation.position, evaluation.velocity, state.pressures, evaluation.pull,
        plant.supply.pressure_at(state.supply),
    )  # fmt: skip

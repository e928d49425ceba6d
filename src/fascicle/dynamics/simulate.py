"""Simulating a plant with its controller, step by step.

The whole run is one compiled loop of fixed steps, so that it can be batched and differentiated by
whatever the plant and the controller hold; `integrate` is the reference that it is held against.
"""

from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..core.checks import concrete, positive
from ..core.modules import numbers
from ..core.refused import Refused
from ..core.types import Batch, Numbers, Values
from ..fluid import checked_commands
from .motion import STATUS, Anchor, Seen, rates
from .plant import Plant
from .rest import rest
from .schedule import Controller, Measurement, Schedule
from .state import Layout, State
from .stepping import Pace, pace, substep


class Trajectory(NamedTuple):
    """A run, moments on the first axis.

    `time` [s]; `seen`: what the plant shows at each, a `Seen`; `commands` held from then on [-];
    `account`: energies up to then [J], by the names of `ACCOUNT`; `substeps` in each step [-];
    `pace`: how stiff it is, where that was looked at; `end`: the state [SI] from which another
    run can go on, with friction relaxed.
    """

    time: Numbers
    seen: Seen
    commands: Numbers
    account: Numbers
    substeps: int
    pace: Pace | None
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
    - `substeps`: in each step [-]; left out, as many as its stiffest part needs, at most 64.

    **Returns:** a `Trajectory` [SI]: one moment more than there are steps.

    **Raises:** `ValueError` for a `dt` or `duration` that can't be, rows that don't fit, and what
    `rest` refuses.
    """
    dt = float(positive(dt, "dt", "s"))
    begin = rest(plant) if start is None else start
    looked = None
    if substeps is None:
        looked = pace(plant, dt)
        substeps = looked.substeps
    elif substeps != int(substeps) or not substeps >= 1:
        raise Refused("substeps", "must be a whole number of at least 1", substeps)
    act, memory, inputs = _driven(plant, controller, reference, dt, duration)
    if not len(inputs):
        name = "reference" if callable(controller) else "commands"
        raise Refused(name, "must have a row for each step", 0, shown="none")
    layout = Layout.of(plant)
    found = _run(plant, layout, act, memory, inputs, begin, np.float64(dt), int(substeps))
    if concrete(found):
        found = numbers(found)
    steps = len(inputs)
    seen, commands, account, end = found
    if looked is not None and looked.stiff:
        seen = seen._replace(status=seen.status | (1 << STATUS.index("stiff")))
    return Trajectory(
        dt * np.arange(steps + 1), seen, commands, account, int(substeps), looked, end
    )


class _Held(eqx.Module):
    """No controller: the reference is what is commanded."""


def _driven(
    plant: Plant, controller: Any, reference: Values, dt: float, duration: float | None
) -> tuple[Any, Any, Numbers]:
    """Controller, memory to begin with, and a row for each step."""
    if callable(controller):
        if reference is None:
            raise Refused("reference", "must have a row for each step", None, shown="none")
        return controller, getattr(controller, "memory", ()), jnp.asarray(reference)
    if isinstance(controller, Schedule):
        end = controller.times[-1] + dt if duration is None else positive(duration, "duration", "s")
        rows = controller.at(dt * np.arange(max(1, round(float(end) / dt))))
    else:
        rows = checked_commands(controller, "commands")
        rows = rows[:, None] if rows.ndim == 1 else rows
    if rows.shape[-1] != plant.commands:
        raise Refused(
            "commands", f"must have {plant.commands} columns, one for each command", rows.shape[-1]
        )
    return _Held(), (), rows


@partial(jax.jit, static_argnums=(1, 7))
def _run(
    plant: Plant, layout: Layout, act: Any, memory: Any, inputs: Numbers, begin: State, dt: Batch,
    substeps: int,
) -> tuple[Seen, Numbers, Numbers, State]:  # fmt: skip
    hysteresis = plant.hysteresis
    kept = jnp.zeros((layout.units, 0 if hysteresis is None else hysteresis.count))
    row = layout.joined(State(*(jnp.asarray(x) for x in begin)))
    h = dt / substeps

    def step(carry: tuple, given: tuple) -> tuple[tuple, tuple]:
        row, anchor, memory = carry
        k, reference = given
        time = k * dt
        if isinstance(act, _Held):  # which measures nothing
            command = reference
        else:
            memory, command = act(memory, _measured(plant, layout, time, row, anchor), reference)

        def sub(i: Any, now: tuple) -> tuple:
            row, anchor = now
            return substep(plant, layout, time + i * h, row, anchor, command, h)

        if substeps == 1:
            after = sub(0, (row, anchor))
        else:
            after = lax.fori_loop(0, substeps, sub, (row, anchor))
        return (*after, memory), (row, anchor, command)

    steps = jnp.arange(len(inputs), dtype=float)
    begun = (row, Anchor(kept, jnp.asarray(begin.position), jnp.asarray(begin.pressures)), memory)
    (row, anchor, _), (rows, anchors, commands) = lax.scan(step, begun, (steps, inputs))
    rows = jnp.concatenate([rows, row[None]])
    anchors = jax.tree.map(lambda many, one: jnp.concatenate([many, one[None]]), anchors, anchor)
    commands = jnp.concatenate([commands, commands[-1:]])
    times = dt * jnp.arange(len(inputs) + 1)
    # all moments at once, of which the loop carries no more than their rows
    state = layout.apart(rows)
    seen = jax.vmap(lambda t, s, c, a: rates(plant, t, s, c, a)[1])(times, state, commands, anchors)
    return seen, commands, state.account, jax.tree.map(lambda x: x[-1], state)


def _measured(
    plant: Plant, layout: Layout, time: Batch, row: Numbers, anchor: Anchor
) -> Measurement:
    idle = jnp.zeros(plant.commands)
    _, seen = rates(plant, time, layout.apart(row), idle, anchor)
    force = jnp.sum(plant.lengths * plant.gains * seen.forces, axis=-1)
    return Measurement(
        time, seen.position, seen.velocity, seen.pressures, force, seen.supply_pressure
    )

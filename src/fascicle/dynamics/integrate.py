"""Integrating a plant with adaptive steps, open loop: the reference that fixed steps are held to.

Tsitouras' method of order 5 stops at each time at which a command changes, so that no step sees
two of them, and looks none up in a stage. Implicit methods are 6 to 60 times slower here at equal
error, in oil too: half of their steps fail at kinks.

**Source:** Tsitouras (2011), by diffrax (Kidger, 2021).
"""

from functools import partial
from itertools import pairwise
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..core.checks import positive
from ..core.modules import numbers
from ..core.refused import Refused
from ..core.types import Batch, Numbers, Values
from .motion import Anchor, Seen, rates
from .plant import Plant
from .rest import rest
from .schedule import Schedule
from .simulate import Trajectory
from .state import Layout, State


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

    - `plant`: what moves [-], without a hysteresis that remembers.
    - `schedule`: its commands [-].
    - `times`: at which it is seen [s], rising, the first at 0.
    - `start`: the state it begins with [SI]; left out, at `rest` without pressure.
    - `tolerance`: relative, of each number of the state [-]; absolute, of its size.

    **Returns:** a `Trajectory` [SI], of no substeps.

    **Raises:** `ValueError` for times that don't rise, a hysteresis that remembers, commands that
    don't fit, what `rest` refuses, and a run that the method gives up.
    """
    if plant.hysteresis is not None and plant.hysteresis.count:
        kind = type(plant.hysteresis).__name__
        remedy = "use `simulate`, or Coulomb's friction"
        raise Refused("hysteresis", "must remember nothing here", kind, remedy)
    if schedule.commands.shape[-1] != plant.commands:
        raise Refused(
            "commands", f"must have {plant.commands} columns, one for each command",
            schedule.commands.shape[-1],
        )  # fmt: skip
    t = np.asarray(times, float)
    if t.ndim != 1 or t.size < 2 or t[0] != 0 or np.any(np.diff(t) <= 0):
        raise Refused("times", "must begin at 0 s and rise", t.shape, shown="other ones")
    tolerance = float(positive(tolerance, "tolerance", "-"))
    begin = rest(plant) if start is None else start
    layout = Layout.of(plant)
    row = np.asarray(layout.joined(begin))
    found = [row[None]]
    # each command by itself: a stage can't see the next one
    edges = [*schedule.times[schedule.times < t[-1]], t[-1]]
    seen_at = [np.zeros(1)]
    size = _sizes(plant, layout, row)
    legs = [(low, high, t[(t > low) & (t <= high)]) for low, high in pairwise(edges)]
    most = 1 + max(len(inside) for _, _, inside in legs)
    for low, high, inside in legs:
        asked = np.unique(np.append(inside, high))
        # as many moments in each leg, so that one compilation serves all
        more = np.linspace(low, asked[0], most - len(asked) + 2)[1:-1]
        asked = np.append(more, asked)
        command = schedule.at(low)
        result, rows = _leg(
            plant, layout, jnp.asarray(row), jnp.asarray(command), low, jnp.asarray(asked),
            tolerance, jnp.asarray(size),
        )  # fmt: skip
        if not bool(result):
            raise Refused(
                "tolerance", f"can't be held: the method gave up between {low:g} and {high:g} s",
                tolerance, "loosen it, or take `simulate`", shown="",
            )  # fmt: skip
        rows = np.asarray(rows)
        row = rows[-1]
        found.append(rows[np.isin(asked, inside)])
        seen_at.append(inside)
    every, moments = np.concatenate(found), np.concatenate(seen_at)
    commands = schedule.at(moments)
    state = layout.apart(jnp.asarray(every))
    seen = numbers(_look(plant, jnp.asarray(moments), state, jnp.asarray(commands)))
    return Trajectory(
        moments, seen, commands, np.asarray(state.account), 0, None, layout.apart(row)
    )


@partial(jax.jit, static_argnums=(1,))
def _leg(
    plant: Plant, layout: Layout, row: Numbers, command: Numbers, low: Batch, asked: Numbers,
    tolerance: Batch, size: Numbers,
) -> tuple[Any, Numbers]:  # fmt: skip
    import diffrax

    def field(t: Batch, y: Numbers, _: Any) -> Numbers:
        state = layout.apart(y)
        moving, _ = rates(plant, t, state, command, _none(layout, state), _NEWTON)
        return layout.joined(moving)

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field), diffrax.Tsit5(), low, asked[-1], None, row,
        saveat=diffrax.SaveAt(ts=asked),
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance * size),
        max_steps=_MOST_STEPS, throw=False,
    )  # fmt: skip
    return solution.result == diffrax.RESULTS.successful, solution.ys


@jax.jit
def _look(plant: Plant, times: Numbers, state: State, commands: Numbers) -> Seen:
    layout = Layout.of(plant)

    def one(t: Batch, s: State, c: Numbers) -> Seen:
        return rates(plant, t, s, c, _none(layout, s), _NEWTON)[1]

    return jax.vmap(one)(times, state, commands)


def _none(layout: Layout, state: State) -> Anchor:
    """Friction that remembers nothing."""
    return Anchor(jnp.zeros((layout.units, 0)), state.position, state.pressures)


def _sizes(plant: Plant, layout: Layout, row: Numbers) -> Numbers:
    """Of each number of a state [SI], to which its absolute tolerance is a share."""
    top = float(plant.supply.pressure_at(plant.supply.start()))
    low, high = plant.way
    state = layout.apart(row)
    V = plant.counts * np.asarray(
        plant.muscles.at(np.full(plant.units, top), plant.strains(0.0)).volume
    )
    full = np.broadcast_to(
        plant.chamber.start(np.full(plant.units, top), V), (plant.units, plant.chamber.count)
    )
    energy = max(top * float(np.sum(V)), 1e-12)
    account = np.full(len(state.account), energy)
    account[7] = float(np.sum(full[..., 0]))
    return layout.joined(
        State(
            np.float64(high - low), np.float64(high - low), np.ones(layout.spool), full,
            np.full(plant.units, top), np.maximum(np.abs(state.supply), 1e-12), account,
        )
    )  # fmt: skip

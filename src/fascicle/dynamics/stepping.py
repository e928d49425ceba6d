r"""Fixed steps of the classic Runge-Kutta method, with inputs held, and how many they must be.

A controller acts once a step of $\Delta t$; what it commands is held until it acts again, so that
no stage of a step sees the next command. Between two actions there are as many equal substeps as
the stiffest part needs: the method is stable while $h |\lambda| \le 2.78$, and is used up to 2.

**Source:** Kutta (1901).
"""

import math
from typing import NamedTuple

import numpy as np
from jax import lax

from ..core.types import Batch, Numbers
from .motion import Anchor, rates, rubbed
from .muscles import volumes
from .plant import Plant
from .state import ACCOUNT, Layout


MOST_SUBSTEPS = 64
_FEWEST = 2  # with one, crossing the cells of a table leaves 1e-5 of the work; with two 1e-6
_STABLE = 2.0  # of h|λ|; the method's own limit is 2.78
# stages of the method: how far along each is, and what it weighs
_ALONG, _WEIGHTS = np.array([0.0, 0.5, 0.5, 1.0]), np.array([1, 2, 2, 1]) / 6
_FRICTION = ACCOUNT.index("friction")


class Pace(NamedTuple):
    """How stiff a plant is: its fastest `rate` [1/s], the part that is [-], the `substeps` that a
    step needs, whether they would have to be more.
    """

    rate: float
    part: str
    substeps: int
    stiff: bool


def pace(plant: Plant, dt: float) -> Pace:
    """How many substeps a step of `dt` [s] of a `plant` [-] needs."""
    fastest = {**_chamber_rates(plant), **_load_rates(plant)}
    part = max(fastest, key=lambda name: fastest[name])
    need = max(_FEWEST, math.ceil(dt * fastest[part] / _STABLE))
    return Pace(fastest[part], part, min(need, MOST_SUBSTEPS), need > MOST_SUBSTEPS)


def substep(
    plant: Plant, layout: Layout, time: Batch, row: Numbers, anchor: Anchor, command: Numbers,
    h: Batch,
) -> tuple[Numbers, Anchor]:  # fmt: skip
    """One substep of `h` [s] from `time` [s]: a `row` [SI] of a state, and friction's `anchor`."""

    def stage(carry: tuple, given: Numbers) -> tuple[tuple, None]:
        slope, total = carry
        along, weight = given
        at = layout.apart(row + along * h * slope)
        moving, _ = rates(plant, time + along * h, at, command, anchor)
        slope = layout.joined(moving)
        return (slope, total + weight * slope), None

    # a loop, as four copies of the stage would take four times as long to compile
    begun = (0.0 * row, 0.0 * row)
    (_, total), _ = lax.scan(stage, begun, np.stack([_ALONG, _WEIGHTS], axis=1))
    after = row + h * total
    if plant.hysteresis is None:
        return after, anchor
    state = layout.apart(after)
    q = plant.load.motion(time + h)[0] if plant.load.moved else state.position
    anchor, lost = rubbed(plant, anchor, q, state.pressures)
    return after.at[..., account_at(layout) + _FRICTION].add(lost), anchor


def account_at(layout: Layout) -> int:
    """Where the account begins in a row [-]."""
    return 2 + layout.spool + layout.units * (layout.chamber + 1) + layout.supply


def _chamber_rates(plant: Plant) -> dict[str, float]:
    """How fast chambers fill at most, valves wide open, and how fast spools move [1/s]."""
    top = float(plant.supply.pressure_at(plant.supply.start()))
    # flow is steepest where pressures are nearly equal
    near = top * np.logspace(-6, 0, 61)
    P = np.concatenate([[0.0], near, (top - near)[:-1]])[:, None, None]
    low, high = plant.way
    eps = plant.strains(np.linspace(low, high, 7)[:, None])  # [place, unit]
    chamber, n = plant.chamber, plant.counts
    room, T_a = chamber.room_pressure, chamber.room_temperature
    state = plant.supply.start()
    p_s, T_s = plant.supply.pressure_at(state) + room, plant.supply.temperature_at(state)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        at = plant.muscles.at(*np.broadcast_arrays(P, eps))
        V, _, V_P = volumes(plant.muscles, at, eps, plant.lengths)
        s = chamber.start(P, n * V)
        g = chamber.balance(s, P, n * V)
        along = np.sum(g.by_state * chamber.per_volume_rate(s, P), axis=-1)
        slope = g.by_pressure + (along + g.by_volume) * n * V_P
        c_p = 0.0 if plant.liquid else chamber.gas.c_p
        one, none = (chamber.rates(s, P, m, m * c_p * T_a, 0.0) for m in (1.0, 0.0))
        rise = -np.sum(g.by_state * (one - none), axis=-1) / slope  # of pressure with mass [Pa/kg]
        step = 1e-4 * np.maximum(P, 1e-6 * top)
        filling, venting = (
            np.abs(flow(P + room + step) - flow(P + room - step)) / (2 * step)
            for flow in (
                lambda p: plant.valve.flow(p_s, p, T_s, T_a),
                lambda p: plant.exhaust_valve.flow(p, room, T_a, T_a),
            )
        )
        fastest = np.max(np.where(slope > 0, np.maximum(filling, venting) * rise, 0.0))
    spool = getattr(plant.spool, "time_constant", None)
    return {
        "a chamber and its valve": float(fastest),
        "a spool": 0.0 if spool is None else float(np.max(1 / np.asarray(spool))),
    }


def _load_rates(plant: Plant) -> dict[str, float]:
    """How fast a load swings on its muscles with their valves shut, and on its stop, at most, and
    how fast its dampers slow it [1/s].
    """
    load, n, L, g = plant.load, plant.counts, plant.lengths, plant.gains
    if load.moved:
        return {}
    M = float(load.inertia)
    top = float(plant.supply.pressure_at(plant.supply.start()))
    low, high = plant.way
    P, eps = (
        np.linspace(0.0, top, 31)[:, None, None],
        plant.strains(np.linspace(low, high, 41)[:, None]),
    )
    with np.errstate(all="ignore"):  # of branches that aren't taken
        P, eps = np.broadcast_arrays(P, eps)
        at = plant.muscles.at(P, eps)
        V, by_strain, by_pressure = volumes(plant.muscles, at, eps, L)
        s = plant.chamber.start(P, n * V)
        balance = plant.chamber.balance(s, P, n * V)
        along = np.sum(balance.by_state * plant.chamber.per_volume_rate(s, P), axis=-1)
        slope = balance.by_pressure + (along + balance.by_volume) * n * by_pressure
        rise = -(along + balance.by_volume) * n * by_strain / slope  # of pressure with strain [Pa]
        spring = -n * L * g**2 * (at.force_by_strain + at.force_by_pressure * rise)
    stiff = float(
        np.nanmax(np.where(slope > 0, np.abs(np.sum(spring, axis=-1, keepdims=True)), 0.0))
    )
    if plant.hysteresis is not None and hasattr(plant.hysteresis, "stiffness"):
        stiff += float(np.sum(n * (L * g) ** 2) * np.sum(np.asarray(plant.hysteresis.stiffness)))
    rates = {
        "the load on its muscles": math.sqrt((stiff + float(load.stiffness)) / M),
        "the load's damper": float(load.damper) / M,
    }
    if load.stop:
        rates["the stop"] = math.sqrt(float(load.stop.stiffness) / M) + float(load.stop.damping) / M
    return rates

r"""The inverse: the pressures that give a force at a strain.

In recruitment state $k$ one throttled pressure $p$ is free (`free` tells of schemes whose units
are independent), so a demanded force $F_d$ asks for the roots of

$$F_k(p, \varepsilon) = F_d, \qquad 0 \le p \le P_s, \quad k = 1 \dots n. \tag{B9}$$

There may be several, in one state and in several: past its free strain a muscle resists
more at a low pressure than at none, so that the force falls with pressure before it rises.
All of them are found, as crossings of the states' curves, and one is chosen.

*Efficiency.* The fluid energy (29), $P_s \sum n_i (V_i(\varepsilon) - V_i(0))$ over the
active units, doesn't depend on the throttled pressure, and in orderly and batch recruitment the
active units of a state are among those of the next. While a muscle's volume grows with
contraction the lowest state is the cheapest; within it, the lowest pressure is taken. At
$\varepsilon \le 0$, where volumes shrink or stay, the lowest state is taken as well, for want of
an order. Where a scheme feeds other units in a later state, the energies are compared.

*Derivatives.* The pressure chosen is a root of (B9) and has its implicit derivative, where
it moves smoothly: not where two solutions meet, and not where the choice changes.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ...core.arrays import library, where
from ...core.roots import still
from ...core.sheet import printed
from ...core.types import AnyArray, Numbers
from ..printing import recruited_sheet, solutions_sheet
from ..states import States
from .curves import Bank
from .levels import Found, solve


REACHED, ABOVE, BELOW = 0, 1, 2


@printed(solutions_sheet)
class Solutions(NamedTuple):
    """All solutions on the last axis, by state and pressure: the throttled `pressure` [Pa],
    the `state`, whether `stable`; NaN, 0 and False where there are fewer. No derivatives.
    """

    pressure: Float[AnyArray, "*points solution"]
    state: Int[AnyArray, "*points solution"]
    stable: Bool[AnyArray, "*points solution"]


@printed(recruited_sheet)
class Recruited(NamedTuple):
    """What to do for a demanded force. `pressures` [Pa], units on the last axis; `state`,
    counted from 1; `force` [N] that they give; `status`: 0 reached, 1 the demanded force is
    above what is reachable there, 2 below: then all this is the nearest reachable force's.
    `stable`: the force falls with strain at these pressures. `solutions`, and their `count`.
    `unit`: the one that is throttled, the first of them, counted from 1.
    """

    pressures: Numbers
    state: Int[AnyArray, "*points"]
    force: Float[AnyArray, "*points"]
    status: Int[AnyArray, "*points"]
    stable: Bool[AnyArray, "*points"]
    solutions: Solutions
    count: Int[AnyArray, "*points"]
    unit: Int[AnyArray, "*points"]


def recruited(
    bank: Bank,
    force: Numbers,
    strain: Numbers,
    present: Numbers | None = None,
    taken: Numbers | None = None,
    *,
    states: States,
) -> Recruited:
    """Equation (B9) solved.

    **Arguments:**

    - `bank`: the bundle's curves [-].
    - `force`: demanded [N], one for each `strain`.
    - `strain`: the bundle's contractions [-].
    - `present`: pressures now [Pa], units last, or None.
    - `taken`: by each unit since rest [m³], units last; or None where states feed more and more.
    - `states`: of the scheme [-].

    **Returns:** what to do for each demand [-], without derivatives.
    """
    f, eps = still((force, strain))
    fixed = still(bank) if bank.guide is None else bank  # a copy would forget what it has kept
    at_work = library(f, eps, fixed.supply)
    beside = fixed.beside(eps)
    found = solve(fixed, f, eps, beside=beside)
    met = found.met
    reached = found.count > 0

    cost = where(met, np.arange(met.shape[1]) + 0.0, np.inf)  # they are in this order already
    if present is not None:
        every = states.pressures(found.state, found.level, fixed.supply)
        apart = at_work.sum((every - still(present)[:, None]) ** 2, axis=-1)
        cost = where(met, apart, np.inf)
    elif taken is not None:
        fed = at_work.maximum(still(taken), 0.0) @ states.fed.T.astype(float)
        cost = where(met, at_work.take_along_axis(fed, found.state, axis=1), np.inf)
    slot = at_work.argmin(cost, axis=1)
    taken_slots = (np.arange(len(slot)), slot)
    state, level = (
        where(reached, x[taken_slots], nearest)
        for x, nearest in ((found.state, found.nearest_state), (found.level, found.nearest))
    )
    there, slope, firm = _at_ends(fixed, found, slot, state, level, eps, beside)
    return Recruited(
        pressures=states.pressures(state, level, fixed.supply),
        state=state + 1,
        force=there,
        status=where(reached, REACHED, where(found.miss < 0, ABOVE, BELOW)),
        stable=slope < 0,
        solutions=Solutions(
            pressure=where(met, found.level * fixed.supply, np.nan),
            state=where(met, found.state + 1, 0),
            stable=firm,
        ),
        count=found.count,
        unit=at_work.asarray(states.leading)[state] + 1,
    )


def _at_ends(
    fixed: Bank,
    found: Found,
    taken: Any,
    state: Any,
    level: Numbers,
    strain: Numbers,
    beside: Any,
) -> tuple[Numbers, Numbers, Any]:
    """Force [N] in the `state` and at the `level` [-] of the slot `taken`, or nearest, its slope in
    strain [N], and which of the solutions are stable. `beside`: forces at each unit's ends [N].
    """
    at_work, held = library(level), fixed.held(beside)

    def forces(owner: Any, state: Any, level: Numbers) -> tuple[Numbers, Numbers]:
        own = fixed.throttled_force(state, level, strain[owner])
        return tuple(x + rest[owner, state] for x, rest in zip(own, held, strict=True))

    every = np.arange(len(state))
    if at_work is np:  # only those that there are
        owner, slot = np.nonzero(found.met)
        none = np.flatnonzero(found.count == 0)
        states = np.concatenate([found.state[owner, slot], state[none]])
        levels = np.concatenate([found.level[owner, slot], level[none]])
        place = (np.concatenate([owner, none]), np.concatenate([slot, taken[none]]))
        force, slope = (np.zeros(found.met.shape) for _ in range(2))
        force[place], slope[place] = forces(place[0], states, levels)
        return force[every, taken], slope[every, taken], found.met & (slope < 0)
    states, levels = (
        at_work.concatenate([own[:, None], x], axis=1).reshape(-1)
        for own, x in ((state, found.state), (level, found.level))
    )
    shape = (len(state), 1 + found.level.shape[1])
    force, slope = (x.reshape(shape) for x in forces(np.repeat(every, shape[1]), states, levels))
    return force[:, 0], slope[:, 0], found.met & (slope[:, 1:] < 0)

r"""The inverse where each unit has a pressure of its own: of all that give a force, the cheapest.

The forces of a set $A$ of fed units are independent, so together they give whatever lies between

$$F_0 + \sum_{i \in A} (\min_p F_i - F_i(0)) \le F_d \le
  F_0 + \sum_{i \in A} (\max_p F_i - F_i(0)), \tag{B11}$$

$F_0$ with none of $A$ fed. The fluid energy (29) asks which units are fed, not at which pressures:
so of all sets that reach a demand the one is taken whose units take in least, of these with fewer
units, and of these the earlier ones. None of its units could be left out. So all of them but the
last are at the pressure at which they pull most, or resist most where less than $F_0$ is demanded,
and the last is throttled, at the lowest pressure that meets the demand. There are infinitely many
others; the one is told. Where the last unit's force jumps past what it should
give (collapse for good ends at some pressure), one before it is throttled instead; what that
doesn't meet either is told as not reached. Compiled, the last alone is tried.

*Derivatives* are those of the throttled unit's pressure, and of the supply's, at which others are;
a unit that resists most at a pressure between is held there.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.arrays import library, maximum, where
from ...core.roots import still
from ...core.types import Numbers
from ..states import States
from .curves import Bank
from .inverse import ABOVE, BELOW, REACHED, Recruited, Solutions
from .levels import EXACT, solve


_SEEN = 5  # levels at which forces are looked at to know their size
_CLOSE = 1e-9  # of 1 N and the force: `EXACT` of one unit, and the rounding of a sum
_BEYOND = 100.0  # times that, and 10 N: no muscle gives as much, and 1e-13 of it is no force


def freed(
    bank: Bank,
    force: Numbers,
    strain: Numbers,
    taken: Numbers,
    *,
    sets: States,
    owner: np.ndarray,
    alike: Sequence[int],
) -> Recruited:
    """The cheapest pressures for each demand.

    **Arguments:**

    - `bank`: a state for each unit that throttles it alone [-].
    - `force`: demanded [N], one for each `strain`.
    - `strain`: the bundle's contractions [-].
    - `taken`: by each unit since rest [m³], units last.
    - `sets`: of units that may be fed [-].
    - `owner`: the state that each belongs to [-].
    - `alike`: which kind each unit is of [-].

    **Returns:** what to do for each demand [-], without derivatives.
    """
    fixed, f, eps, volume = still((bank, force, strain, taken))
    at_work = library(f, eps, volume, fixed.supply)
    units = len(alike)
    few = [list(alike).index(kind) for kind in range(len(set(alike)))]
    # a strain that many demands share is looked at once
    once, place = eps, np.arange(len(eps))
    if at_work is np:
        once, place = np.unique(eps, return_inverse=True)
    seen = _seen(fixed, few, once)
    none, full = (seen[end][place][:, np.array(alike)] for end in (0, -1))
    chosen = sets.throttled.T.astype(float)
    base = full @ sets.full.T.astype(float) + none @ (~sets.full).T.astype(float)
    # what pulls less than a set at its beginning is of no use to a demand for more, nor the reverse
    needed = [at_work.max(base, axis=1) > f, at_work.min(base, axis=1) <= f]
    if at_work is np:
        needed = [np.bincount(place, one, len(once)) > 0 for one in needed]
    least, most, at_least, at_most = (
        x[place][:, np.array(alike)] for x in _limits(fixed, few, once, seen, needed)
    )
    low, high = base + (least - none) @ chosen, base + (most - none) @ chosen
    wanted = f[:, None]
    off = maximum(maximum(low - wanted, wanted - high), 0.0)
    reached = at_work.min(off, axis=1) <= EXACT
    # what flows back counts as nothing: then the fewest units are taken
    cost = maximum(volume, 0.0) @ sets.fed.T.astype(float)
    cost = where(reached[:, None], where(off <= EXACT, cost, np.inf), off)
    taken_set = at_work.argmin(cost, axis=1)

    def at(x: Numbers) -> Numbers:
        return at_work.take_along_axis(x, taken_set[:, None], axis=1)[:, 0]

    target = at_work.clip(f, at(low), at(high))
    held, fed = (at_work.asarray(x)[taken_set] for x in (sets.full, sets.throttled))
    more = (target >= at(base))[:, None]
    level = where(held, 1.0, where(fed, where(more, at_most, at_least), 0.0))
    given = where(held, full, where(fed, where(more, most, least), none))
    unit = units - 1 - at_work.argmax(fed[:, ::-1], axis=1)
    begun, close = level, _CLOSE * (1 + at_work.abs(f))
    level, there, slope = _throttled(fixed, begun, given, unit, target, eps)
    if at_work is np:  # where the last unit's force jumps past what it should give, one before it
        for _ in range(units - 1):
            earlier = fed & (np.arange(units) < unit[:, None])
            missed = reached & (np.abs(there - f) > close) & earlier.any(axis=1)
            again = np.flatnonzero(missed)
            if not len(again):
                break
            unit[again] = units - 1 - np.argmax(earlier[again, ::-1], axis=1)
            some = (x[again] for x in (begun, given, unit, target, eps))
            level[again], there[again], slope[again] = _throttled(fixed, *some)
    # and what none of them meets isn't called reached
    reached = reached & (at_work.abs(there - f) <= close)
    throttled = np.arange(units) == unit[:, None]
    state = at_work.asarray(owner)[taken_set]
    stable = slope < 0
    own = at_work.sum(where(throttled, level, 0.0), axis=1)
    return Recruited(
        pressures=level * fixed.supply,
        state=state + 1,
        force=there,
        status=where(reached, REACHED, where(f > there, ABOVE, BELOW)),
        stable=stable,
        solutions=Solutions(
            pressure=where(reached, own * fixed.supply, np.nan)[:, None],
            state=where(reached, state + 1, 0)[:, None],
            stable=(reached & stable)[:, None],
        ),
        count=where(reached, 1, 0),
        unit=unit + 1,
    )


def _throttled(
    bank: Bank, level: Numbers, given: Numbers, unit: Any, target: Numbers, strain: Numbers
) -> tuple[Numbers, Numbers, Numbers]:
    """The levels [-] with that of one `unit` changed so that all together give the `target` [N],
    the lowest that does or the nearest to it; their force [N] and its slope in `strain` [N].
    `given`: what each unit gives at its `level` [N].
    """
    this = np.arange(level.shape[1]) == unit[:, None]
    rest = target - library(given).sum(where(this, 0.0, given), axis=1)
    found = solve(bank, rest, strain, unit)
    lowest = where(found.count > 0, found.level[:, 0], found.nearest)
    level = where(this, lowest[:, None], level)
    return level, *_forces(bank, level, strain)


def _seen(bank: Bank, units: Sequence[int], strain: Numbers) -> Numbers:
    """Forces [N] of `units` at some even levels, which are first, and each `strain` [-]."""
    at_work = library(strain, bank.supply)
    state, eps = np.array(units), strain[:, None]
    return at_work.stack([
        bank.state_force(state, level + 0.0 * eps, eps)[0]
        for level in np.linspace(0.0, 1.0, _SEEN)
    ])  # fmt: skip


def _limits(
    bank: Bank, units: Sequence[int], strain: Numbers, seen: Numbers, needed: Sequence[Any]
) -> tuple[Numbers, ...]:
    """Least and largest forces [N] of `units`, and at which levels [-] these are, at each `strain`
    [-], units last; where one isn't `needed`, that of the unit unfed. `seen`: some forces [N].
    """
    at_work, shape = library(strain, bank.supply), (2, *seen.shape[1:])
    beyond = _BEYOND * at_work.max(at_work.abs(seen), axis=0) + 10.0
    force, level = at_work.stack([seen[0], seen[0]]), at_work.zeros(shape)
    side, row, column = np.indices(shape).reshape(3, -1)
    if at_work is np:
        side, row, column = np.nonzero(np.broadcast_to(np.stack(needed)[..., None], shape))
    if len(side):
        state, eps = np.array(units)[column], strain[row]
        asked = where(side > 0, 1.0, -1.0) * beyond[row, column]
        levels = solve(bank, asked, eps, state).nearest
        forces, _ = bank.state_force(state, levels, eps)
        if at_work is np:
            force[side, row, column], level[side, row, column] = forces, levels
        else:
            force, level = forces.reshape(shape), levels.reshape(shape)
    return *force, *level


def _forces(bank: Bank, level: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
    """Force [N] of all units at their own `level` [-], and its slope in `strain` [N]."""
    at_work, (count, units) = library(level, strain, bank.supply), level.shape
    state = np.tile(np.arange(units), count)
    found = bank.state_force(state, level.reshape(-1), at_work.repeat(strain, units))
    force, slope = (at_work.sum(x.reshape(count, units), axis=1) for x in found)
    return force, slope

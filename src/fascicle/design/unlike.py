r"""Designs that differ in everything: every motor unit has a muscle of its own.

Each unit's table is made for its own sizes; states add them up as in (B1). The cost of a
design is that of the force law at no and at full pressure, unless its curves are asked for, or all
units share one throttled pressure: then it is that at all its units' levels and strains.
"""

from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from jax import Array, lax

from ..core.types import Float, Numbers, Whole
from ..muscle import Muscle
from .designs import Rows
from .every_level import at_every_level
from .kernel import Unlike, outcome
from .objectives import judged
from .outcome import Demand, Outcome, states_for
from .tables import COMPILE_ABOVE, UNLIKE, Resolution, Table, filled_up, run, tabulated


_AT_ONCE = 2**16  # forces worked on at once: what stays in cache


class Sizes(NamedTuple):
    """Designs as arrays: `counts` [-] and `radius` [m], `wall` [m] and `angle` [rad] of the
    muscles of each unit, their `length` [m]. Padded units have no muscles, and sizes that exist.
    """

    counts: Whole
    length: Numbers
    radius: Numbers
    wall: Numbers
    angle: Numbers


def unlike_objectives(
    drawing: Muscle,
    sizes: Sizes,
    demand: Demand,
    *,
    names: tuple[str, ...],
    needs: tuple[str, ...],
    resolution: Resolution = UNLIKE,
    among: int = 0,
) -> Numbers:
    """Objectives of designs that differ in everything.

    **Arguments:**

    - `drawing`: whose material, laws and tuning all muscles have [-].
    - `sizes`: of the designs, on the first axis [-].
    - `demand`: the task's [-].
    - `names`: of the objectives [-].
    - `needs`: what these need beyond the task's points [-].
    - `resolution`: of levels and strains [-].
    - `among`: how many designs are judged in all [-], where it is more than these: for many it
      pays to compile.

    **Returns:** them, a row for each name, in its unit [SI].
    """
    if whole_law(demand, np.shape(sizes.counts)[-1], needs):
        return _at_every_level(
            drawing, sizes, demand, names=names, needs=needs, resolution=resolution
        )
    own = Sizes(*map(np.asarray, sizes))
    designs, units = own.counts.shape
    forces = units * demand.travel.size
    compiling = max(designs, among) * forces > COMPILE_ABOVE
    # sizes of a ladder where it is compiled: else once more for every number of designs
    wanted = 1 << (designs - 1).bit_length() if compiling else designs
    # twice as many: most of a table is the tension law's, which takes little
    step = max(1, min(2 * _AT_ONCE // forces, wanted))
    if compiling:  # as are these, so that none are judged twice
        step = 1 << (step.bit_length() - 1)
    values = np.empty((len(names), designs))
    for places in filled_up(designs, step):
        counts, length, radius, wall, angle = (x[places].T for x in own)
        rows = Rows(drawing, length + 0.0 * radius, radius, wall, angle)
        table = tabulated(rows, demand, needs, resolution.level, compiling)
        found = run(_objectives, compiling, names)(table, counts, length, demand)
        values[:, places] = found
    return values


def whole_law(demand: Demand, units: int, needs: tuple[str, ...]) -> bool:
    """Whether designs of so many units have to be looked at at every level.

    **Arguments:**

    - `demand`: the task's [-].
    - `units`: of the designs [-].
    - `needs`: beyond the task's points [-].

    **Returns:** whether [-].
    """
    states = states_for(demand.scheme, units)
    return "curves" in needs or not (states.apart and states.joined)


def _objectives(
    table: Table, counts: Whole, length: Numbers, demand: Demand, names: tuple[str, ...]
) -> Numbers:
    return judged(outcome(Unlike(counts), table, length, demand), names)


@partial(jax.jit, static_argnames=("names", "needs", "resolution"))
def _at_every_level(
    drawing: Muscle,
    sizes: Sizes,
    demand: Demand,
    *,
    names: tuple[str, ...],
    needs: tuple[str, ...],
    resolution: Resolution,
) -> Float[Array, "objective design"]:
    units = sizes.counts.shape[-1]
    strains = demand.travel.size + ("curves" in needs) * resolution.strains
    block = max(1, _AT_ONCE // (units * resolution.levels * strains))

    def one(sizes: Sizes) -> Float[Array, " objective"]:
        return judged(unlike_outcome(drawing, sizes, demand, needs, resolution), names)

    return lax.map(one, sizes, batch_size=min(block, len(sizes.counts))).T


def unlike_outcome(
    drawing: Muscle,
    sizes: Sizes,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution = UNLIKE,
) -> Outcome:
    """What a single design does, without the designs' axis; arguments as of
    `unlike_objectives` [-]. Everything is looked at at every level, whatever it is: so it can be
    differentiated, and done for many at once.
    """
    rows = Rows(drawing, sizes.length + 0.0 * sizes.radius, *sizes[2:])
    n = sizes.counts
    table, low, high, depth, overlap = at_every_level(rows, n, demand, needs, resolution)
    return outcome(Unlike(n), table, sizes.length, demand, high, low, depth, overlap)

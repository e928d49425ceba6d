r"""Designs that are compositions of one muscle: its forces are shared, a design costs a few sums.

With $a$ muscles at full supply, $n$ throttled and $r$ unfed, all alike, the force is

$$F = a F_{full}(\varepsilon) + n F(p, \varepsilon) + r F_{none}(\varepsilon), \tag{G2}$$

so a state's largest force follows from three numbers at each strain: $F_{full}$, $F_{none}$ and
the largest $F$ over $p$. The depth of reversal depends on $(a, n)$ alone, the overlap of
two successive states on $(a, n, n')$: both are tabulated once for all compositions.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..bundle.states import states_of
from ..core.array_namespace import array_namespace, where
from ..core.types import Numbers, Whole
from ..muscle import Muscle
from .designs import Rows
from .kernel import Alike, outcome
from .objectives import judged
from .outcome import Demand, Outcome, existing, states_for
from .reversal import Curves, curves_of, depths, overlaps
from .tables import SHARED, Resolution, Table, run, tabulated


class Prepared(NamedTuple):
    """A muscle's `table`, how many `muscles` [-] a design has of it, and where asked for `depth`
    [-] by $(a, n)$ and `overlap` [N] by $(a, n, n')$.
    """

    table: Table
    muscles: int
    depth: Numbers | None
    overlap: Numbers | None


def prepared(
    muscle: Muscle,
    muscles: int,
    demand: Demand,
    *,
    most: int,
    needs: tuple[str, ...],
    resolution: Resolution = SHARED,
) -> Prepared:
    """What all compositions of one muscle share.

    **Arguments:**

    - `muscle`: the one [-].
    - `muscles`: how many of it a design has [-], at most `most`.
    - `demand`: the task's [-].
    - `most`: size of the tables [-].
    - `needs`: "size", "curves", both or nothing [-].
    - `resolution`: of levels and strains [-].

    **Returns:** what is shared [-].
    """
    sizes = (muscle.length, muscle.outer_radius, muscle.wall_thickness, muscle.braid_angle)
    rows = Rows(muscle, *(np.atleast_1d(np.asarray(x, float)) for x in sizes))
    (one,) = all_prepared(rows, [muscles], demand, most, needs, resolution)
    return one


def all_prepared(
    rows: Rows,
    muscles: Sequence[int],
    demand: Demand,
    most: int,
    needs: tuple[str, ...],
    resolution: Resolution = SHARED,
    compiling: bool = False,
    units: int | None = None,
) -> list[Prepared]:
    """What compositions share, of several muscles.

    **Arguments:**

    - `rows`: the muscles [-], NumPy's.
    - `muscles`: how many of each a design has [-], at most `most`.
    - `demand`: the task's [-].
    - `most`: size of the tables [-].
    - `needs`: "size", "curves", both or nothing [-].
    - `resolution`: of levels and strains [-].
    - `compiling`: whether the muscles' laws are compiled [-].
    - `units`: that a design may have [-]; left out, as many as muscles.

    **Returns:** what is shared, of each [-].
    """
    table = tabulated(rows, demand, needs, resolution.level, compiling)
    every: Sequence[Curves | None] = [None] * len(muscles)
    if "curves" in needs:
        every = curves_of(rows, float(demand.supply), resolution)
    found = []
    for i, (N, curves) in enumerate(zip(muscles, every, strict=True)):
        depth = overlap = None
        if curves is not None:
            depth = depths(curves, N, most)
            held = states_of(demand.scheme, units or most).in_turn
            overlap = overlaps(curves, N, most, held)
        found.append(Prepared(table.take(i), N, depth, overlap))
    return found


def shared_objectives(
    known: Prepared,
    counts: Whole,
    demand: Demand,
    *,
    names: tuple[str, ...],
    compiling: bool = False,
) -> Numbers:
    """Objectives of compositions of one muscle.

    **Arguments:**

    - `known`: what they share [-].
    - `counts`: muscles in each unit [-], zeros last, designs on the first axis.
    - `demand`: the task's [-].
    - `names`: of the objectives [-].
    - `compiling`: whether this is compiled [-].

    **Returns:** them, a row for each name, in its unit [SI].
    """
    return run(_objectives, compiling, names)(known, np.asarray(counts), demand)


def _objectives(known: Prepared, counts: Whole, demand: Demand, names: tuple[str, ...]) -> Numbers:
    return judged(shared_outcome(known, counts, demand), names)


def shared_outcome(known: Prepared, counts: Whole, demand: Demand) -> Outcome:
    """What compositions of one muscle do; arguments as of `shared_objectives` [-]."""
    n = counts.T
    states = states_for(demand.scheme, len(n))
    fed = where(existing(demand.scheme, n > 0), states.fed.astype(int) @ n, 0)
    depth = _deepest(known.depth, n[states.order])
    overlap = _widest(known.overlap, fed)
    return outcome(Alike(n), known.table, known.table.length, demand, depth=depth, overlap=overlap)


def _deepest(table: Numbers | None, n: Whole) -> Numbers | None:
    """Of units `n` [-] in the order of their recruitment."""
    # 0 for no muscles throttled, and for none before them
    return None if table is None else table[n.cumsum(axis=0) - n, n].max(axis=0)


def _widest(table: Numbers | None, fed: Whole) -> Numbers | None:
    """Of states that feed so many muscles, `fed` [-], each more than the one before it."""
    if table is None:
        return None
    at_work = array_namespace(fed)
    a = at_work.concatenate([0 * fed[:1], fed[:-1]])
    n = at_work.maximum(fed - a, 0)
    after = at_work.concatenate([n[1:], 0 * n[:1]])
    return table[a, n, after].max(axis=0)

r"""What muscles give for a task, on which everything a design does is based.

Levels $u = p/P_s$ are denser at low pressure, $u_i = (i/n)^{3/2}$, where collapse and free
strain change fastest. The largest force over them needs the whole law at few of them: past its
free strain a muscle only pushes, so that where any level pulls it is the largest pull. A tension
law that is linear in pressure pulls most at the supply's; another is looked at at every level,
without its buckling. Where no level pulls, the whole law is looked at at every level.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Float

from .._arrays import maximum, minimum, most, nodes, stack, where
from .._evaluate import COMPILE_ABOVE, compiled
from .._types import Numbers, Whole
from ..muscle import Muscle
from ..muscle.column import ROUNDING
from ..muscle.corrected import Meller2014
from ..muscle.force_balance import Kothera2009
from ..muscle.ideal import Ideal
from ..muscle.piecewise import Pressurized
from ..muscle.tension import KluteHannaford
from .outcome import Demand
from .rows import Rows


_AT_ONCE = 2**16  # forces worked on at once: what stays in cache
_LINEAR = (KluteHannaford, Ideal, Meller2014, Kothera2009)  # in pressure, where it isn't tuned


class Resolution(eqx.Module):
    """How many throttled `levels`, and `strains` along the curves [-]."""

    levels: int = eqx.field(static=True, default=33)
    strains: int = eqx.field(static=True, default=129)

    @property
    def level(self) -> np.ndarray:
        """Levels of throttled pressure over the supply's [-], from 0 to 1."""
        return np.linspace(0.0, 1.0, self.levels) ** 1.5


SHARED = Resolution(257, 513)  # one muscle serves thousands of designs
UNLIKE = Resolution(33, 129)  # every design has muscles of its own


class Table(NamedTuple):
    """Of muscles, on the last axes: the force at the task's points `unfed`, at `full` supply
    pressure and the `largest` at any level [N]; the fluid `volume` [m³] taken in at these, their
    `blocked` force [N] and `length` [m]; where asked for their `radius` and `bulge` [m] at the
    largest strain.
    """

    unfed: Numbers
    full: Numbers
    largest: Numbers
    volume: Numbers
    blocked: Numbers
    length: Numbers
    radius: Numbers | None = None
    bulge: Numbers | None = None

    def take(self, places: Any) -> "Table":
        """Those of the muscles at `places` [-] of the last axis."""
        return Table(*(None if x is None else x[..., places] for x in self))


def tabulated(
    rows: Rows,
    demand: Demand,
    needs: tuple[str, ...],
    level: Float[np.ndarray, " level"],
    compiling: bool = False,
) -> Table:
    """The table of muscles.

    **Arguments:**

    - `rows`: the muscles [-], NumPy's.
    - `demand`: the task's [-].
    - `needs`: "size" among them, where radius and bulge are asked for [-].
    - `level`: throttled pressures over the supply's, rising from 0 to 1 [-].
    - `compiling`: whether their laws are compiled [-].

    **Returns:** the table [-], NumPy's.
    """
    table = run(_at_the_ends, compiling, "size" in needs)(rows, demand)
    largest, inner = np.array(table.largest), level[1:-1] * demand.supply
    strain = np.broadcast_to(demand.strain(rows.length), largest.shape)
    tension, tuning = rows.drawing.tension, rows.drawing.tuning
    if not (isinstance(tension, _LINEAR) and tuning.pressures.shape[-1] == 1):
        step = max(1, _AT_ONCE // largest.size)
        for some in _filled_up(len(inner), min(step, len(inner))):
            pull = run(_largest_pull, compiling)(rows, inner[some], strain)
            np.maximum(largest, pull, out=largest)
    if np.any(largest < 0):
        largest = _where_none_pulls(rows, inner, strain, largest, compiling)
    return table._replace(largest=largest)


def highest(n: Whole, table: Table, scheme: str) -> list[Numbers]:
    """Largest force of each state.

    **Arguments:**

    - `n`: muscles in each unit, on the first axis [-].
    - `table`: of a muscle of each unit, points ahead of units [-].
    - `scheme`: of recruitment [-]; where it is "batch", the units must be alike.

    **Returns:** forces [N], of each state in turn.
    """
    full, unfed, largest = (n * x for x in (table.full, table.unfed, table.largest))
    found = []
    for k in range(len(n)):
        first = k if scheme == "orderly" else 0
        held = full[:, :first].sum(axis=1) + unfed[:, k + 1 :].sum(axis=1)
        found.append(held + largest[:, first : k + 1].sum(axis=1))
    return found


def run(law: Callable, compiling: bool, *static: Any) -> Callable:
    """A function of NumPy's arrays that gives NumPy's.

    **Arguments:**

    - `law`: what it is of any library's [-].
    - `compiling`: whether it is compiled [-].
    - `static`: its last arguments [-].

    **Returns:** the function [-].
    """
    if compiling:
        return lambda *arrays: jax.tree.map(np.asarray, compiled(law, static)(*arrays))

    def at_once(*arrays: Any) -> Any:
        with np.errstate(all="ignore"):  # of branches that aren't taken
            return law(*arrays, *static)

    return at_once


def sizes_at(
    muscle: Muscle, unfed: Pressurized, largest_strain: Numbers
) -> tuple[Numbers, Numbers]:
    """Radius [m], and how far it bows out up to there [m].

    **Arguments:**

    - `muscle`: one or several [-].
    - `unfed`: the same at no pressure [-].
    - `largest_strain`: of the task [-].

    **Returns:** both [m].
    """
    # deepest where it collapses, if it does before, else at the end
    stops = stack([largest_strain, minimum(unfed.collapse, largest_strain)])
    return muscle.braid.radius_at(largest_strain), most(unfed.deflection(stops))


def _at_the_ends(rows: Rows, demand: Demand, sizes: bool) -> Table:
    """The table with the largest force of no and full pressure."""
    muscle, strain = rows.muscle, demand.strain(rows.length)
    law, none = muscle._law(), 0.0 * rows.length
    unfed, full = law.at(none), law.at(demand.supply + none)
    forces = [at.force(strain + none)[0] for at in (unfed, full)]
    radius = bulge = None
    if sizes:
        radius, bulge = sizes_at(muscle, unfed, strain.max(axis=0) + none)
    return Table(
        *forces,
        largest=maximum(*forces),
        volume=muscle.braid.volume(strain + none) - muscle.braid.volume(none),
        blocked=law.tension.force(demand.supply, none),
        length=rows.length,
        radius=radius,
        bulge=bulge,
    )


def _largest_pull(rows: Rows, pressure: Numbers, strain: Numbers) -> Numbers:
    """Over pressures [Pa] at each `strain` [-]; none, where no muscle pulls."""
    tension = rows.muscle._law().tension
    P = nodes(pressure, rows.length)
    pulled = strain <= tension.free_strain(P)[:, None] + ROUNDING
    return most(where(pulled, tension.force(P[:, None], strain), -np.inf))


def _where_none_pulls(
    rows: Rows,
    pressure: Float[np.ndarray, " level"],
    strain: Float[np.ndarray, "point *row"],
    largest: Float[np.ndarray, "point *row"],
    compiling: bool,
) -> Float[np.ndarray, "point *row"]:
    """The `largest` force [N] with that at each `pressure` [Pa], where no level pulls."""
    found, eps = (x.reshape(len(largest), -1).copy() for x in (largest, strain))
    sizes = (np.broadcast_to(x, largest.shape[1:]).reshape(-1) for x in rows[1:])
    each, pushed = Rows(rows.drawing, *sizes), found < 0
    points, lanes = (np.flatnonzero(pushed.any(axis=axis)) for axis in (1, 0))
    compiling = compiling and points.size * lanes.size * len(pressure) > COMPILE_ABOVE
    if compiling:
        points = points[_filled_up(points.size, 1 << (points.size - 1).bit_length())[0]]
    step = max(1, _AT_ONCE // (points.size * len(pressure)))
    for some in _filled_up(lanes.size, step if compiling else min(step, lanes.size)):
        field = np.ix_(points, lanes[some])
        force = run(_largest_force, compiling)(each.take(lanes[some]), pressure, eps[field])
        found[field] = np.where(pushed[field], np.maximum(found[field], force), found[field])
    return found.reshape(largest.shape)


def _largest_force(rows: Rows, pressure: Numbers, strain: Numbers) -> Numbers:
    """Over pressures [Pa] at each `strain` [-]."""
    at = rows.muscle._law().at(nodes(pressure, strain) + 0.0 * rows.length)
    return most(at.force(strain)[0])


def _filled_up(count: int, step: int) -> list[np.ndarray]:
    """Places up to `count`, so many in a step; the last repeats its own, where it is short."""
    return [
        np.minimum(np.arange(start, start + step), count - 1) for start in range(0, count, step)
    ]

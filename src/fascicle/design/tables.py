r"""What muscles give for a task, on which everything a design does is based.

Levels $u = p/P_s$ are denser at low pressure, $u_i = (i/n)^{3/2}$, where collapse and free
strain change fastest. Buckling and collapse are asked for at few of them: past its free strain a
muscle only pushes, so that where any level pulls the largest force is a pull, of the tension law
alone. One that is linear in pressure pulls most at the supply's; another is looked at at every
level. Where no level pulls, or not that of the supply, the whole law is looked at at every level.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import numpy as np

from ..core.array_namespace import max_nodes, maximum, minimum, node_axis, stack, where
from ..core.jax_backend import compile_law
from ..core.types import Bool, Float, Numbers
from ..muscle import Muscle
from ..muscle.buckling.buckling_law import ROUNDING
from ..muscle.piecewise import Piecewise, Pressurized
from .designs import Rows
from .outcome import Demand


# points of a muscle's law: NumPy takes some 2 µs for each, compiling it a second
COMPILE_ABOVE = 200_000
_AT_ONCE = 2**16  # forces worked on at once: what stays in cache


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
    full, largest, pressure = table.full, table.largest, level[1:] * demand.supply
    strain = np.broadcast_to(demand.strain(rows.length), largest.shape)
    tension, tuning = rows.drawing.tension, rows.drawing.tuning
    # a tuning's tables bend what is linear
    if not (tension.linear_in_pressure and tuning.pressures.shape[-1] == 1):
        step = max(1, _AT_ONCE // largest.size)
        for some in filled_up(len(pressure), min(step, len(pressure))):
            pull = run(_largest_pull, compiling)(rows, pressure[some], strain)
            largest = np.maximum(largest, pull)
    pushed = full < 0  # as is where even the largest is less
    if np.any(pushed):
        found = _whole_law(rows, pressure, strain, pushed, compiling)
        full = np.where(pushed, found[0], full)
        largest = np.where(pushed, np.maximum(largest, found[1]), largest)
    return table._replace(full=full, largest=largest)


def run(law: Callable, compiling: bool, *static: Any) -> Callable:
    """A function of NumPy's arrays that gives NumPy's.

    **Arguments:**

    - `law`: what it is of any library's [-].
    - `compiling`: whether it is compiled [-].
    - `static`: its last arguments [-].

    **Returns:** the function [-].
    """
    if compiling:
        return lambda *arrays: jax.tree.map(np.asarray, compile_law(law, static)(*arrays))

    def at_once(*arrays: Any) -> Any:
        with np.errstate(all="ignore"):  # of branches that aren't taken
            return law(*arrays, *static)

    return at_once


def filled_up(count: int, step: int) -> list[np.ndarray]:
    """Places to work on one step after another: what is compiled has as many in every call.

    **Arguments:**

    - `count`: of the places [-].
    - `step`: how many there are in a step [-].

    **Returns:** those of each step [-]; the last repeats its own, where it is short.
    """
    starts = range(0, count, step)
    return [np.minimum(np.arange(start, start + step), count - 1) for start in starts]


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
    return muscle.braid.radius_at(largest_strain), max_nodes(unfed.deflection(stops))


def _at_the_ends(rows: Rows, demand: Demand, sizes: bool) -> Table:
    """The table as far as the tension law goes at full pressure: beyond, there is no force."""
    none, muscle = 0.0 * rows.length, rows.muscle
    strain, law = demand.strain(rows.length) + none, muscle.law
    # what depends on pressure alone isn't merged with what is asked of it at each point
    unfed, supply = law.at(none), demand.supply + none
    forces = (unfed.force(strain)[0], _pull(law, supply, strain))
    radius = bulge = None
    if sizes:
        radius, bulge = sizes_at(muscle, unfed, strain.max(axis=0))
    return Table(
        *forces,
        largest=maximum(*forces),
        volume=muscle.braid.volume(strain) - muscle.braid.volume(none),
        blocked=law.tension.force(supply, none),
        length=rows.length,
        radius=radius,
        bulge=bulge,
    )


def _pull(law: Piecewise, pressure: Numbers, strain: Numbers) -> Numbers:
    """Force [N] up to the free strain; beyond there is none, minus infinity."""
    pulled = strain <= law.tension.free_strain(pressure) + ROUNDING
    return where(pulled, law.tension.force(pressure, strain), -np.inf)


def _largest_pull(rows: Rows, pressure: Numbers, strain: Numbers) -> Numbers:
    """Over pressures [Pa] at each `strain` [-], [N]."""
    P = node_axis(pressure, rows.length)[:, None] + 0.0 * rows.length
    return max_nodes(_pull(rows.muscle.law, P, strain))


def _largest_force(rows: Rows, pressure: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
    """At the last of the pressures [Pa] and over all of them, at each `strain` [-], [N]."""
    P = node_axis(pressure, rows.length)[:, None] + 0.0 * rows.length
    force, _ = rows.muscle.law.at(P).force(strain)
    return force[-1], max_nodes(force)


def _whole_law(
    rows: Rows,
    pressure: Float[np.ndarray, " level"],
    strain: Float[np.ndarray, "point *row"],
    asked: Bool[np.ndarray, "point *row"],
    compiling: bool,
) -> Float[np.ndarray, "2 point *row"]:
    """Force [N] at the last pressure [Pa] and the largest over all, where it is `asked` for."""
    sizes = (np.broadcast_to(x, strain.shape[1:]).reshape(-1) for x in rows[1:])
    each, flat = Rows(rows.drawing, *sizes), (len(strain), -1)
    eps, asked = strain.reshape(flat), asked.reshape(flat)
    found = np.full((2, *eps.shape), -np.inf)
    points, lanes = (np.flatnonzero(asked.any(axis=axis)) for axis in (1, 0))
    compiling = compiling and points.size * lanes.size * len(pressure) > COMPILE_ABOVE
    if compiling:
        (some,) = filled_up(points.size, 1 << (points.size - 1).bit_length())
        points = points[some]
    step = max(1, _AT_ONCE // (points.size * len(pressure)))
    for some in filled_up(lanes.size, step if compiling else min(step, lanes.size)):
        down, across = np.ix_(points, lanes[some])
        law = run(_largest_force, compiling)
        found[:, down, across] = law(each.take(lanes[some]), pressure, eps[down, across])
    return found.reshape((2, *strain.shape))

r"""Tables of forces: what muscles give at the points of a task and along their curves.

Levels $u = p/P_s$ are denser at low pressure, $u_i = (i/n)^{3/2}$, where collapse and free
strain change fastest. A table of every level is the whole force law there. Most designs need only
the largest force over all levels, and buckling and collapse at few points: past its free strain a
muscle only pushes, so that where any level pulls the largest force is a pull, of the tension law
alone. One that is linear in pressure pulls most at the supply's. Where no level pulls, or not that
of the supply, the whole law is evaluated at every level.
"""

from dataclasses import dataclass

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, stack, where
from ..core.types import Bool, Float, Numbers
from ..muscle import Muscle
from ..muscle.buckling.buckling_law import ROUNDING
from ..muscle.piecewise import Piecewise, Pressurized
from .designs import Sizes
from .outcome import Demand, ForceTable


_BATCH = 2**16  # forces computed together: what stays in a processor's cache
_LEVELS = 32  # levels of a curve computed together, for the same reason


@dataclass(frozen=True)
class Resolution:
    """How many throttled `levels`, and `strains` along the curves."""

    levels: int = 33
    strains: int = 129

    @property
    def level(self) -> np.ndarray:
        """Levels of throttled pressure over the supply's [-], from 0 to 1."""
        return np.linspace(0.0, 1.0, self.levels) ** 1.5


UNIFORM = Resolution(257, 513)  # one muscle serves thousands of designs
MIXED = Resolution(33, 129)  # every design has muscles of its own


def largest_force_table(
    drawing: Muscle, sizes: Sizes, demand: Demand, needs: tuple[str, ...], resolution: Resolution
) -> ForceTable:
    """The table of muscles, with the largest force over all levels alone.

    **Arguments:**

    - `drawing`: whose material, laws and tuning all muscles have.
    - `sizes`: of the muscles, NumPy's, on one axis.
    - `demand`: the task's.
    - `needs`: "size" among them, where radius and bulge are needed.
    - `resolution`: of levels.

    **Returns:** the table, NumPy's.
    """
    muscle, none = sizes.muscle(drawing), 0.0 * sizes.length
    law, strain, supply = muscle.law, demand.strain(sizes.length) + none, demand.supply + none
    with np.errstate(all="ignore"):  # in branches of the law that a point doesn't take
        at_rest = law.at(none)
        unfed, full = at_rest.force(strain)[0], _pull(law, supply, strain)
        largest, pressure = maximum(unfed, full), resolution.level[1:] * demand.supply
        # a tuning's tables bend what is linear
        if not (drawing.tension.linear_in_pressure and drawing.tuning.pressures.shape[-1] == 1):
            step = max(1, _BATCH // largest.size)
            for start in range(0, len(pressure), step):
                P = pressure[start : start + step, None, None] + none
                largest = maximum(largest, _pull(law, P, strain).max(axis=0))
        pushes = full < 0  # as it does wherever even the largest force is less
        if np.any(pushes):
            force = _forces_where(pushes, drawing, sizes, pressure, strain)
            full = where(pushes, force[0], full)
            largest = where(pushes, maximum(largest, force[1]), largest)
        return _table(muscle, demand, needs, at_rest, unfed, full, largest[None])


def every_level_table(
    drawing: Muscle,
    sizes: Sizes,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution,
    curves_to: Numbers | None = None,
) -> tuple[ForceTable, Numbers]:
    """The table of muscles at every level, and their curves.

    **Arguments:**

    - `drawing`: whose material, laws and tuning all muscles have.
    - `sizes`: of the muscles, on one axis, NumPy's or JAX's.
    - `demand`: the task's.
    - `needs`: "size" among them, where radius and bulge are needed.
    - `resolution`: of levels, and strains of the curves.
    - `curves_to`: strain to which the curves go [-]; `None` for no curves.

    **Returns:** the table, and forces along the curves [N] by level, strain and muscle.
    """
    muscle = sizes.muscle(drawing)
    strain, none = demand.strain(sizes.length), 0.0 * sizes.length
    xp, count = array_namespace(none, strain), len(strain)
    strain = strain + none
    with np.errstate(all="ignore"):  # in branches of the law that a point doesn't take
        at = muscle.law.at(resolution.level[:, None, None] * demand.supply + none)
        every = strain
        if curves_to is not None:
            # one call for all strains, so that JAX compiles the law once
            even = np.linspace(0.0, 1.0, resolution.strains)[:, None]
            every = xp.concatenate([strain, curves_to * even + none])
        force = at.force(every)[0]
        levels = force[:, :count]
        at_rest = muscle.law.at(none) if "size" in needs else None
        table = _table(muscle, demand, needs, at_rest, levels[0], levels[-1], levels)
    return table, force[:, count:]


def force_curves(
    drawing: Muscle, sizes: Sizes, supply: float, resolution: Resolution
) -> tuple[Float[np.ndarray, "level strain"], float]:
    """The curves of one muscle at every level, from rest to the free strain at the supply's.

    **Arguments:**

    - `drawing`: whose material, laws and tuning it has.
    - `sizes`: its own, NumPy's.
    - `supply`: the supply's pressure [Pa].
    - `resolution`: of levels and strains.

    **Returns:** forces [N], and the free strain [-].
    """
    law, pressure = sizes.muscle(drawing).law, resolution.level[:, None] * supply
    force = np.empty((resolution.levels, resolution.strains))
    with np.errstate(all="ignore"):  # in branches of the law that a point doesn't take
        every = law.at(pressure)
        free = every.column.free_strain
        top = float(free[-1, 0])
        strain = np.linspace(0.0, top, resolution.strains)
        for start in range(0, resolution.levels, _LEVELS):
            some = slice(start, start + _LEVELS)
            at = law.at(
                pressure[some], free[some], np.broadcast_to(every.collapse, free.shape)[some]
            )
            # where all levels pull the tension law is enough, which takes a tenth of the time
            pulls = int(np.searchsorted(strain, free[some].min()))
            force[some, :pulls] = law.tension.force(pressure[some], strain[:pulls])
            force[some, pulls:] = at.force(strain[pulls:])[0]
    return force, top


def _table(
    muscle: Muscle,
    demand: Demand,
    needs: tuple[str, ...],
    at_rest: Pressurized | None,
    unfed: Numbers,
    full: Numbers,
    levels: Numbers,
) -> ForceTable:
    """A table with all that its muscles' forces don't tell."""
    none = 0.0 * muscle.length
    strain = demand.strain(muscle.length) + none
    radius = bulge = None
    if "size" in needs and at_rest is not None:
        largest = strain.max(axis=0)
        # it bows deepest where it collapses, if it does before, else at the end
        stops = stack([largest, minimum(at_rest.collapse, largest)])
        radius, bulge = muscle.braid.radius_at(largest), at_rest.deflection(stops).max(axis=0)
    volume = muscle.braid.volume(strain) - muscle.braid.volume(none)
    blocked = muscle.law.tension.force(demand.supply + none, none)
    return ForceTable(unfed, full, levels, volume, blocked, muscle.length, radius, bulge)


def _pull(law: Piecewise, pressure: Numbers, strain: Numbers) -> Numbers:
    """Force [N] up to the free strain; beyond there is none, minus infinity."""
    pulls = strain <= law.tension.free_strain(pressure) + ROUNDING
    return where(pulls, law.tension.force(pressure, strain), -np.inf)


def _forces_where(
    needed: Bool[np.ndarray, "point muscle"],
    drawing: Muscle,
    sizes: Sizes,
    pressure: Float[np.ndarray, " level"],
    strain: Float[np.ndarray, "point muscle"],
) -> Float[np.ndarray, "2 point muscle"]:
    """Force [N] at the last pressure [Pa] and the largest over all, where it is `needed`."""
    forces = np.full((2, *strain.shape), -np.inf)
    points, muscles = (np.flatnonzero(needed.any(axis=axis)) for axis in (1, 0))
    step = max(1, _BATCH // (points.size * len(pressure)))
    for start in range(0, muscles.size, step):
        some = muscles[start : start + step]
        part = sizes.take(some)
        at = part.muscle(drawing).law.at(pressure[:, None, None] + 0.0 * part.length)
        force = at.force(strain[np.ix_(points, some)])[0]
        forces[:, points[:, None], some] = force[-1], force.max(axis=0)
    return forces

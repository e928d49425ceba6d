r"""Tables of forces: of muscles at the points of a task and along their curves.

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
from ..core.types import Numbers
from ..muscle import Muscle
from ..muscle.buckling import ROUNDING
from ..muscle.piecewise import Piecewise, PressurizedMuscle
from .designs import Sizes
from .outcome import Demand, ForceTable


_BATCH = 2**16  # forces computed together: what stays in a processor's cache


@dataclass(frozen=True)
class Resolution:
    """Numbers of throttled `levels`, and of `strains` along the curves."""

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
    """Table of muscles of `sizes`, NumPy's, on one axis, with the largest force over all levels
    alone; radius and bulge if "size" is among the `needs`.
    """
    muscle, zero = sizes.muscle(drawing), 0.0 * sizes.length
    law, strain, supply = muscle.law, demand.strain(sizes.length) + zero, demand.supply + zero
    with np.errstate(all="ignore"):  # in branches of the law that a point doesn't take
        vented = law.at(zero)
        vented_force, full = vented.force(strain)[0], _tension_force(law, supply, strain)
        largest, pressure = maximum(vented_force, full), resolution.level[1:] * demand.supply
        # a tuning's tables bend what is linear
        if not (drawing.tension.linear_in_pressure and drawing.tuning.pressures.shape[-1] == 1):
            step = max(1, _BATCH // largest.size)
            for start in range(0, len(pressure), step):
                P = pressure[start : start + step, None, None] + zero
                largest = maximum(largest, _tension_force(law, P, strain).max(axis=0))
        pushes = full < 0  # as it does wherever even the largest force is less
        points, muscles = (np.flatnonzero(pushes.any(axis=axis)) for axis in (1, 0))
        step = max(1, _BATCH // max(1, points.size * len(pressure)))
        for start in range(0, muscles.size, step):
            block = np.ix_(points, muscles[start : start + step])
            block_sizes = sizes.take(block[1][0])
            pressurized = block_sizes.muscle(drawing).law.at(
                pressure[:, None, None] + 0.0 * block_sizes.length
            )
            force = np.where(pushes[block], pressurized.force(strain[block])[0], -np.inf)
            full[block] = where(pushes[block], force[-1], full[block])
            largest[block] = maximum(largest[block], force.max(axis=0))
        return _force_table(muscle, demand, needs, vented, vented_force, full, largest[None])


def every_level_table(
    drawing: Muscle,
    sizes: Sizes,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution,
    curves_to: Numbers | None = None,
) -> tuple[ForceTable, Numbers]:
    """Table of muscles of `sizes`, NumPy's or JAX's, on one axis, at every level; and their forces
    [N] by level, strain and muscle along curves from rest to the strain `curves_to` [-], if given.
    """
    muscle, zero = sizes.muscle(drawing), 0.0 * sizes.length
    strain = demand.strain(sizes.length) + zero
    xp, points = array_namespace(strain), len(strain)
    with np.errstate(all="ignore"):  # in branches of the law that a point doesn't take
        pressurized = muscle.law.at(resolution.level[:, None, None] * demand.supply + zero)
        if curves_to is not None:
            # one call for all strains, so that JAX compiles the law once
            even = np.linspace(0.0, 1.0, resolution.strains)[:, None]
            strain = xp.concatenate([strain, curves_to * even + zero])
        force = pressurized.force(strain)[0]
        levels = force[:, :points]
        vented = muscle.law.at(zero) if "size" in needs else None
        table = _force_table(muscle, demand, needs, vented, levels[0], levels[-1], levels)
    return table, force[:, points:]


def _force_table(
    muscle: Muscle,
    demand: Demand,
    needs: tuple[str, ...],
    vented: PressurizedMuscle | None,
    vented_force: Numbers,
    full: Numbers,
    levels: Numbers,
) -> ForceTable:
    """Force table of computed forces, with volume, blocked force and sizes of the muscles."""
    zero = 0.0 * muscle.length
    strain = demand.strain(muscle.length) + zero
    radius = bulge = None
    if "size" in needs and vented is not None:
        largest = strain.max(axis=0)
        # it bows deepest where it collapses, if it does before, else at the end
        deepest = stack([largest, minimum(vented.collapse_strain, largest)])
        radius, bulge = muscle.braid.radius_at(largest), vented.deflection(deepest).max(axis=0)
    volume = muscle.braid.volume(strain) - muscle.braid.volume(zero)
    blocked = muscle.law.tension.force(demand.supply + zero, zero)
    return ForceTable(vented_force, full, levels, volume, blocked, muscle.length, radius, bulge)


def _tension_force(law: Piecewise, pressure: Numbers, strain: Numbers) -> Numbers:
    """Force of the tension law [N] at a `pressure` [Pa] and a `strain` [-]; minus infinity past the
    free strain, where the law doesn't hold.
    """
    pulls = strain <= law.tension.free_strain(pressure) + ROUNDING
    return where(pulls, law.tension.force(pressure, strain), -np.inf)

r"""Objectives of designs: one evaluator, for all designs and arrays, on one table of forces.

Designs of one drawing are evaluated together, on a table of all the muscles they are made of: of
the largest force alone if their states depend on no more, else of the forces at every level. Only
designs of several muscles whose curves are needed are evaluated one by one: so can a single design
of JAX's arrays be, to be differentiated.

Levels $u = p/P_s$ are denser at low pressure, $u_i = (i/n)^{3/2}$, where collapse and free
strain change fastest. A table of every level is the whole force law there. Most designs need only
the largest force over all levels, and buckling and collapse at few points: past its free strain a
muscle only pushes, so that where any level pulls the largest force is a pull, of the tension law
alone. One that is linear in pressure pulls most at the supply's. Where no level pulls, or not that
of the supply, the whole law is evaluated at every level.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bundle.schemes import AbstractScheme
from ..bundle.states import is_prefix_consistent
from ..core.array_namespace import array_namespace, maximum, minimum, stack, where
from ..core.errors import InvalidInputError
from ..core.types import Float, Int, Numbers, Whole
from ..muscle import Muscle
from ..muscle.buckling import ROUNDING
from ..muscle.piecewise import Piecewise, PressurizedMuscle
from .designs import Designs, Sizes
from .objectives import check_objectives, needs, objective_values
from .outcome import (
    Demand,
    ForceTable,
    Outcome,
    existing_states,
    largest_overlap,
    outcome,
    recruitment_states,
    reversal_depth,
    uniform_reversal_depths,
)
from .task import Task


_BATCH = 2**20  # numbers computed together, some ten megabytes
_IN_CACHE = 2**16  # forces computed together: what stays in a processor's cache

Values = dict[str, Float[np.ndarray, " design"]]


@dataclass(frozen=True)
class Resolution:
    """Numbers of throttled `levels`, and of `strains` along the curves."""

    levels: int = 33
    strains: int = 129

    @property
    def level(self) -> np.ndarray:
        """Levels of throttled pressure over the supply's [-], from 0 to 1."""
        return np.linspace(0.0, 1.0, self.levels) ** 1.5


UNIFORM = Resolution(129, 513)  # one muscle serves thousands of designs
MIXED = Resolution(33, 129)  # every design has muscles of its own


def evaluate(
    designs: Designs,
    task: Task,
    objectives: Iterable[str],
    resolution: Resolution | None = None,
    force_factor: Numbers | float = 1.0,
) -> Values:
    """Objectives of designs for a task.

    **Arguments:**

    - `designs`: any number.
    - `task`: what is demanded.
    - `objectives`: by name, of `OBJECTIVES`.
    - `resolution`: of levels and strains; left out, `UNIFORM` for designs of one muscle, else
      `MIXED`.
    - `force_factor`: of each design, or all: its muscles' forces over the model's [-].

    **Returns:** an array for each, in its own unit [SI].

    **Raises:** `ValueError` for an unknown objective, and designs off the model's domain.
    """
    names = check_objectives(objectives, task.scheme)
    values = np.full((len(names), len(designs)), np.nan)
    for index, batch in outcomes(designs, task, needs(names), resolution, force_factor):
        values[:, index] = objective_values(batch, names)
    return dict(zip(names, values, strict=True))


def outcomes(
    designs: Designs,
    task: Task,
    needs: tuple[str, ...] = (),
    resolution: Resolution | None = None,
    force_factor: Numbers | float = 1.0,
) -> Iterator[tuple[Any, Outcome]]:
    """Indices and outcome of the designs of each batch; a single index for an outcome without an
    axis for designs.

    `needs`: of the objectives, "size", "curves", both or nothing; others as of `evaluate`.
    """
    if np.any(designs.wall >= designs.radius):
        rule = "must be less than `outer_radius` in every design"
        raise InvalidInputError("wall_thickness", rule, None)
    if np.any(designs.counts.sum(axis=1) < 1):
        raise InvalidInputError("counts", "must hold at least one muscle in every design", None)
    demand, factor = Demand.from_task(task), np.broadcast_to(force_factor, len(designs))
    # together: designs of one drawing and number of units, either all of one muscle each or not
    uniform = designs.uniform
    keys = np.stack([designs.kind, evaluated_units(designs, task.scheme), uniform], axis=1)
    for key in np.unique(keys, axis=0):
        index = np.flatnonzero(np.all(keys == key, axis=1))
        group = designs.take(index, int(key[1]))
        states = recruitment_states(demand.scheme, int(key[1]))
        res = resolution or (UNIFORM if key[2] and states.gapless else MIXED)
        if key[2] or "curves" not in needs:
            for portion, batch in _batches(group, bool(key[2]), demand, needs, res, factor[index]):
                yield index[portion], batch
            continue
        for i, design in enumerate(index):
            drawing, sizes, factor_i = group.drawing(i), group.sizes(i), factor[design]
            yield (
                design,
                design_outcome(drawing, group.counts[i], sizes, demand, needs, res, factor_i),
            )


def design_outcome(
    drawing: Muscle,
    counts: Whole,
    sizes: Sizes,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution = MIXED,
    force_factor: Numbers | float = 1.0,
) -> Outcome:
    """Outcome of a single design, computed at every level, without an axis for designs: by JAX,
    where any array is JAX's.

    `drawing`: with material, laws and tuning of all muscles; `counts` of muscles and their `sizes`
    by unit; `needs`: of the objectives, "size", "curves", both or nothing; `force_factor`: forces
    over the model's [-].
    """
    exists, states = counts > 0, recruitment_states(demand.scheme, len(counts))
    top = depth = overlap = None
    if "curves" in needs:
        top = where(exists, _free_strain(drawing, sizes, demand), 0.0).max()
    table, curves = every_level_table(drawing, sizes, demand, needs, resolution, top)
    table, curves = table.scale_forces(force_factor), curves * force_factor
    if top is not None:
        depth = reversal_depth(counts, curves, top, states)
        existing = existing_states(demand.scheme, exists)
        overlap = largest_overlap(counts, curves, curves, states, existing)
    return outcome(counts, table, sizes.length[0], demand, depth, overlap)


def evaluated_units(designs: Designs, scheme: AbstractScheme) -> Int[np.ndarray, " design"]:
    """Number of motor units that each design is evaluated with: the largest of all; the design's
    own if fewer units aren't the first states of more.
    """
    columns = designs.counts.shape[1]
    if scheme.independent or is_prefix_consistent(scheme, columns):
        return np.full(len(designs), columns)
    return designs.units


def _batches(
    designs: Designs,
    uniform: bool,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution,
    force_factor: Float[np.ndarray, " design"],
) -> Iterator[tuple[Int[np.ndarray, " batch"], Outcome]]:
    """Outcomes of designs of one drawing, batch by batch, with the batch's indices."""
    drawing, units = designs.drawing(0), designs.counts.shape[1]
    states = recruitment_states(demand.scheme, units)
    largest_only = states.gapless and (uniform or states.separable)
    points = demand.travel.size * (1 if largest_only else resolution.levels)
    step = max(1, _BATCH // (points * units))
    columns = 1 if uniform else units
    sizes = [x[:, :columns] for x in (designs.radius, designs.wall, designs.angle)]
    rows = np.stack([designs.length[:, None] + 0.0 * sizes[0], *sizes], axis=-1)
    muscles, muscle_of = np.unique(rows.reshape(-1, 4), axis=0, return_inverse=True)
    muscle_of = muscle_of.reshape(-1, columns)
    # designs of one muscle share its part of a table, however many they are
    order = muscle_of[:, 0] if uniform else np.arange(len(rows))
    batch_of = order // (max(1, _BATCH // points) if uniform else step)
    for number in np.unique(batch_of):
        (members,) = np.nonzero(batch_of == number)
        used, index = np.unique(muscle_of[members], return_inverse=True)
        sizes, index = Sizes(*muscles[used].T), index.reshape(-1, columns)
        if largest_only:
            table = largest_force_table(drawing, sizes, demand, needs, resolution)
        else:
            table, _ = every_level_table(drawing, sizes, demand, needs, resolution)
        depth = overlap = None
        if "curves" in needs:
            depth, overlap = np.empty((2, len(members)))
            for muscle in range(len(used)):
                (twins,) = np.nonzero(index[:, 0] == muscle)
                counts = designs.counts[members[twins]].T
                depth[twins], overlap[twins] = _curve_objectives(
                    drawing, sizes.take([muscle]), counts, demand, resolution
                )
        for start in range(0, len(members), step):
            cut = slice(start, start + step)
            batch = members[cut]
            factor, counts, length = force_factor[batch], designs.counts[batch].T, designs.length
            units_table = table.take(index[cut].T).scale_forces(factor)
            curves = ()
            if depth is not None and overlap is not None:
                curves = (depth[cut], factor * overlap[cut])
            yield batch, outcome(counts, units_table, length[batch], demand, *curves)


def _curve_objectives(
    drawing: Muscle,
    sizes: Sizes,
    counts: Int[np.ndarray, "unit design"],
    demand: Demand,
    resolution: Resolution,
) -> tuple[Float[np.ndarray, " design"], Float[np.ndarray, " design"]]:
    """Reversal depth [-] and overlap width [N] of designs of one muscle."""
    top = float(_free_strain(drawing, sizes, demand)[0])
    curves = every_level_table(drawing, sizes, demand, (), resolution, top)[1][..., 0]
    states, width = recruitment_states(demand.scheme, len(counts)), np.empty(counts.shape[1])
    exists = existing_states(demand.scheme, counts > 0)
    ends = np.stack([curves.min(axis=0), curves.max(axis=0)])[..., None, None]
    step = max(1, _BATCH // (ends.size * len(counts)))
    for start in range(0, len(width), step):
        cut = (slice(None), slice(start, start + step))
        width[cut[1]] = largest_overlap(
            counts[cut], curves[..., None, None], ends, states, exists[cut]
        )
    return uniform_reversal_depths(counts, curves, top, states), width


def _free_strain(drawing: Muscle, sizes: Sizes, demand: Demand) -> Numbers:
    """Free strain [-] of muscles of `sizes` at the demand's supply pressure."""
    law = sizes.muscle(drawing).law
    return law.tension.free_strain(demand.supply + 0.0 * sizes.length)


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
            step = max(1, _IN_CACHE // largest.size)
            for start in range(0, len(pressure), step):
                P = pressure[start : start + step, None, None] + zero
                largest = maximum(largest, _tension_force(law, P, strain).max(axis=0))
        pushes = full < 0  # as it does wherever even the largest force is less
        points, muscles = (np.flatnonzero(pushes.any(axis=axis)) for axis in (1, 0))
        step = max(1, _IN_CACHE // max(1, points.size * len(pressure)))
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

r"""Objectives of designs: one evaluator, for all designs and arrays, on one table of forces.

Designs of one drawing are evaluated together, on a table of all the muscles they are made of: of
the largest force alone if their states depend on no more, else of the forces at every level.

Levels $u = p/P_s$ are denser at low pressure, $u_i = (i/n)^{3/2}$, where collapse and free
strain change fastest. Most designs need only the largest force over all levels, and buckling and
collapse at few points: past its free strain a muscle only pushes, so that where any level pulls the
largest force is a pull, of the tension law alone. One that is linear in pressure pulls most at the
supply's. Where that doesn't pull, the whole law is evaluated at every level.
"""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from ..bundle.states import is_prefix_consistent
from ..core.array_namespace import slices
from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.types import Float, Int, Numbers
from ..core.validation import LARGEST_STRAIN
from ..muscle import Muscle
from ..muscle.buckling import ROUNDING
from ..muscle.piecewise import Piecewise
from .designs import SIZES, Designs, scaled_muscle
from .objectives import OBJECTIVES, check_objectives
from .outcome import ForceTable, Outcome, outcome, overlaps, recruitment_of, reversal_depths
from .task import Task


_BATCH = 2**17  # numbers computed together: what stays in a processor's cache

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
    force_factor: Float[np.ndarray, " design"] | float = 1.0,
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
    values = {name: np.empty(len(designs)) for name in names}
    needs = {OBJECTIVES[name].needs for name in names if name != "reversal_depth"}
    if "reversal_depth" in names:  # needs one of the curves' two figures
        needs.add("depth")
    for index, batch in outcomes(designs, task, needs, resolution, force_factor):
        for name in names:
            values[name][index] = OBJECTIVES[name].function(batch)
    return values


def outcomes(
    designs: Designs,
    task: Task,
    needs: Collection[str] = (),
    resolution: Resolution | None = None,
    force_factor: Float[np.ndarray, " design"] | float = 1.0,
) -> Iterator[tuple[Int[np.ndarray, " batch"], Outcome]]:
    """Indices and outcome of the designs of each batch; `needs`: of the objectives."""
    if np.any(designs.wall >= designs.radius):
        rule = "must be less than `outer_radius` in every design"
        raise InvalidInputError("wall_thickness", rule, None)
    if np.any(designs.counts.sum(axis=1) < 1):
        raise InvalidInputError("counts", "must hold at least one muscle in every design", None)
    scheme, factor = task.scheme, np.broadcast_to(force_factor, len(designs))
    units, columns = designs.units, designs.counts.shape[1]
    if scheme.independent or is_prefix_consistent(scheme, columns):
        units = np.full(len(designs), columns)  # fewer have the first states of more
    # together: designs of one drawing and number of units, either all of one muscle each or not
    keys = 2 * (designs.kind * (columns + 1) + units) + designs.uniform
    for key in np.unique(keys):
        index = np.flatnonzero(keys == key)
        group = designs.take(index, int(units[index[0]]))
        for portion, batch in _batches(group, task, needs, resolution, factor[index]):
            yield index[portion], batch


def _batches(
    designs: Designs,
    task: Task,
    needs: Collection[str],
    resolution: Resolution | None,
    force_factor: Float[np.ndarray, " design"],
) -> Iterator[tuple[Int[np.ndarray, " batch"], Outcome]]:
    """Outcomes of designs of one drawing, all or none uniform, with their indices."""
    drawing, units, uniform = designs.drawing(0), designs.counts.shape[1], bool(designs.uniform[0])
    recruitment = recruitment_of(task.scheme, units)
    states = recruitment.states
    resolution = resolution or (UNIFORM if uniform and states.gapless else MIXED)
    largest_only = states.gapless and (uniform or states.separable)
    points = len(task) * (1 if largest_only else resolution.levels)
    columns = 1 if uniform else units
    sizes = [x[:, :columns] for x in (designs.radius, designs.wall, designs.angle)]
    rows = np.stack([designs.length[:, None] + 0.0 * sizes[0], *sizes], axis=-1)
    muscles, muscle_of = np.unique(rows.reshape(-1, 4), axis=0, return_inverse=True)
    muscle_of = muscle_of.reshape(-1, columns)
    depth = overlap = None
    if not {"curves", "depth"}.isdisjoint(needs):
        depth, overlap = np.full((2, len(rows)), np.nan)
        for unit_muscles in np.unique(muscle_of, axis=0):
            (twins,) = np.nonzero(np.all(muscle_of == unit_muscles, axis=1))
            counts, muscle = designs.counts[twins].T, scaled_muscle(drawing, muscles[unit_muscles])
            top, forces = _force_curves(muscle, task.supply_pressure, resolution)
            depth[twins] = reversal_depths(counts, forces, top, states)
            if "curves" in needs:
                overlap[twins] = overlaps(counts, forces, recruitment)
        overlap *= force_factor
    # neighbors share muscles, whose forces are computed once in a batch
    order = np.argsort(muscle_of[:, 0], kind="stable")
    for cut in slices(len(order), max(1, _BATCH // (points * units))):
        batch = order[cut]
        used, index = np.unique(muscle_of[batch], return_inverse=True)
        table = force_table(drawing, muscles[used], task, needs, resolution, largest_only)
        table = table.take(index.reshape(-1, columns).T, force_factor[batch])
        curves = (x if x is None else x[batch] for x in (depth, overlap))
        task_of_batch = designs.counts[batch].T, table, designs.length[batch], task, recruitment
        yield batch, outcome(*task_of_batch, *curves)


def _force_curves(
    muscle: Muscle, supply: float, resolution: Resolution
) -> tuple[float, Float[np.ndarray, "level strain muscle"]]:
    """Largest free strain of some muscles [-], and their forces [N] at every level up to there."""
    sizes = {name: getattr(muscle, name)[:, None] for name in ("length", *SIZES)}
    law = with_fields(muscle, **sizes).law  # levels last
    pressure = resolution.level * supply + 0.0 * sizes["length"]
    top = float(law.tension.free_strain(pressure[:, -1:]).max())
    strain = top * np.linspace(0.0, 1.0, resolution.strains)
    with np.errstate(all="ignore"):  # in branches of the law that a point doesn't take
        force = _tension_force(law, pressure, strain[:, None, None])
        # only where a muscle pushes: the law of buckling takes longest
        point, level = np.nonzero((force == -np.inf).any(axis=1))
        pushes = law.at(pressure).take(level).pulling_force(strain[point])
    force[point, :, level] = pushes.T
    return top, np.moveaxis(force, -1, 0)


def force_table(
    drawing: Muscle,
    sizes: Float[np.ndarray, "muscle 4"],
    task: Task,
    needs: Collection[str],
    resolution: Resolution,
    largest_only: bool,
) -> ForceTable:
    """Table of muscles of `sizes`: with the forces at every level, or `largest_only`; radius and
    bulge if "size" is among the `needs`.
    """
    muscle, supply = scaled_muscle(drawing, sizes), task.supply_pressure
    law, zero = muscle.law, 0.0 * muscle.length
    strain = np.minimum(task.strain_of(muscle.length), LARGEST_STRAIN)
    radius = bulge = None
    with np.errstate(all="ignore"):  # in branches of the law that a point doesn't take
        vented = law.at(zero)
        if largest_only:
            vented_force = vented.pulling_force(strain)
            full, largest = _largest_force(drawing, sizes, supply, strain, vented_force, resolution)
            levels = largest[None]
        else:
            levels = law.at(resolution.level[:, None, None] * supply + zero).pulling_force(strain)
            vented_force, full = levels[0], levels[-1]
        if "size" in needs:
            largest = strain.max(axis=0)
            # it bows deepest where it collapses, if it does before, else at the end
            deepest = np.stack([largest, np.minimum(vented.collapse_strain, largest)])
            radius, bulge = muscle.braid.radius_at(largest), vented.deflection(deepest).max(axis=0)
    volume = muscle.braid.volume(strain) - muscle.braid.volume(zero)
    blocked = law.tension.force(supply + zero, zero)
    return ForceTable(vented_force, full, levels, volume, blocked, radius, bulge)


def _largest_force(
    drawing: Muscle,
    sizes: Float[np.ndarray, "muscle 4"],
    supply: float,
    strain: np.ndarray,
    vented: np.ndarray,
    resolution: Resolution,
) -> tuple[np.ndarray, np.ndarray]:
    """Force at the `supply` pressure [Pa], and the largest over all levels [N]."""
    law, zero = scaled_muscle(drawing, sizes).law, 0.0 * sizes[:, 0]
    full = _tension_force(law, supply + zero, strain)
    largest, pressure = np.maximum(vented, full), resolution.level[1:, None, None] * supply
    # a tuning's tables bend what is linear
    if not (drawing.tension.linear_in_pressure and drawing.tuning.pressures.shape[-1] == 1):
        for block in slices(len(pressure), max(1, _BATCH // largest.size)):
            pulls = _tension_force(law, pressure[block] + zero, strain)
            largest = np.maximum(largest, pulls.max(axis=0))
    # it pushes, as it does wherever even the largest force is less
    point, index = np.nonzero(full < 0)
    for block in slices(index.size, max(1, _BATCH // len(pressure))):
        i, j = point[block], index[block]
        pressurized = scaled_muscle(drawing, sizes[j]).law.at(pressure[:, 0] + zero[j])
        force = pressurized.pulling_force(strain[i, j])
        full[i, j], largest[i, j] = force[-1], np.maximum(largest[i, j], force.max(axis=0))
    return full, largest


def _tension_force(law: Piecewise, pressure: Numbers, strain: Numbers) -> np.ndarray:
    """Force of the tension law [N]; minus infinity past the free strain, where it doesn't hold."""
    pulls = strain <= law.tension.free_strain(pressure) + ROUNDING
    return np.where(pulls, law.tension.force(pressure, strain), -np.inf)

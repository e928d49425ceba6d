r"""Objectives of designs: one evaluator, for all designs and arrays.

Designs whose units have one muscle, and others whose states depend on the largest force of
each unit alone, are evaluated together, on a table of all the muscles they are made of. Designs of
several muscles whose curves are needed, or whose units share a throttled pressure, and all where a
scheme leaves gaps between states, are evaluated one by one on tables of every level: so can a
single design of JAX's arrays be, to be differentiated, or mapped over draws.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ..bundle.schemes import AbstractScheme
from ..bundle.states import is_prefix_consistent
from ..core.array_namespace import where
from ..core.errors import InvalidInputError
from ..core.types import Float, Int, Whole
from ..muscle import Muscle
from .designs import Designs, Sizes
from .objectives import check_objectives, needs, objective_values
from .outcome import Demand, Outcome, existing_states, outcome, recruitment_states
from .reversal import largest_overlap, reversal_depth, uniform_reversal_depths
from .tables import (
    MIXED,
    UNIFORM,
    Resolution,
    every_level_table,
    force_curves,
    largest_force_table,
)
from .task import Task


_BATCH = 2**20  # numbers computed together, some ten megabytes

Values = dict[str, Float[np.ndarray, " design"]]


def evaluate(
    designs: Designs,
    task: Task,
    objectives: Iterable[str],
    resolution: Resolution | None = None,
) -> Values:
    """Objectives of designs for a task.

    **Arguments:**

    - `designs`: any number.
    - `task`: what is demanded.
    - `objectives`: by name, of `OBJECTIVES`.
    - `resolution`: of levels and strains; left out, `UNIFORM` for designs of one muscle, else
      `MIXED`.

    **Returns:** an array for each, in its own unit [SI].

    **Raises:** `ValueError` for an unknown objective, and designs off the model's domain.
    """
    names = check_objectives(objectives, task.scheme)
    values = np.full((len(names), len(designs)), np.nan)
    for index, batch in outcomes(designs, task, needs(names), resolution):
        values[:, index] = objective_values(batch, names)
    return dict(zip(names, values, strict=True))


def outcomes(
    designs: Designs,
    task: Task,
    needs: tuple[str, ...] = (),
    resolution: Resolution | None = None,
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
    demand = Demand.from_task(task)
    # together: designs of one drawing and number of units, either all of one muscle each or not
    uniform = designs.uniform
    keys = np.stack([designs.kind, evaluated_units(designs, task.scheme), uniform], axis=1)
    for key in np.unique(keys, axis=0):
        index = np.flatnonzero(np.all(keys == key, axis=1))
        group = designs.take(index, int(key[1]))
        states = recruitment_states(demand.scheme, int(key[1]))
        one_table = bool(key[2]) and states.gapless
        res = resolution or (UNIFORM if one_table else MIXED)
        if one_table or (states.gapless and states.separable and "curves" not in needs):
            for portion, batch in _batches(group, bool(key[2]), demand, needs, res):
                yield index[portion], batch
            continue
        for i, design in enumerate(index):
            drawing, sizes = group.drawing(i), group.sizes(i)
            yield design, design_outcome(drawing, group.counts[i], sizes, demand, needs, res)


def design_outcome(
    drawing: Muscle,
    counts: Whole,
    sizes: Sizes,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution = MIXED,
) -> Outcome:
    """Outcome of a single design, computed at every level, without an axis for designs: by JAX,
    where any array is JAX's.

    `drawing`: with material, laws and tuning of all muscles; `counts` of muscles and their `sizes`
    by unit; `needs`: of the objectives, "size", "curves", both or nothing.
    """
    exists, states = counts > 0, recruitment_states(demand.scheme, len(counts))
    top = depth = overlap = None
    if "curves" in needs:
        law = sizes.muscle(drawing).law
        free = law.tension.free_strain(demand.supply + 0.0 * sizes.length)
        top = where(exists, free, 0.0).max()
    table, curves = every_level_table(drawing, sizes, demand, needs, resolution, top)
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
) -> Iterator[tuple[Int[np.ndarray, " batch"], Outcome]]:
    """Outcomes of designs of one drawing, batch by batch, with the batch's indices."""
    points, units = demand.travel.size, designs.counts.shape[1]
    step, drawing = max(1, _BATCH // (points * units)), designs.drawing(0)
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
        table = largest_force_table(drawing, sizes, demand, needs, resolution)
        depth = overlap = None
        if "curves" in needs:
            depth, overlap = np.empty((2, len(members)))
            for muscle in range(len(used)):
                (twins,) = np.nonzero(index[:, 0] == muscle)
                counts = designs.counts[members[twins]].T
                depth[twins], overlap[twins] = _curve_objectives(
                    drawing, sizes.take(muscle), counts, demand, resolution
                )
        for start in range(0, len(members), step):
            cut = slice(start, start + step)
            batch, table_of_units = members[cut], table.take(index[cut].T)
            curves = () if depth is None or overlap is None else (depth[cut], overlap[cut])
            yield (
                batch,
                outcome(
                    designs.counts[batch].T, table_of_units, designs.length[batch], demand, *curves
                ),
            )


def _curve_objectives(
    drawing: Muscle,
    sizes: Sizes,
    counts: Int[np.ndarray, "unit design"],
    demand: Demand,
    resolution: Resolution,
) -> tuple[Float[np.ndarray, " design"], Float[np.ndarray, " design"]]:
    """Reversal depth [-] and overlap width [N] of designs of one muscle."""
    curves, top = force_curves(drawing, sizes, float(demand.supply), resolution)
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

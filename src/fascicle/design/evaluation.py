r"""Objectives of designs: one evaluator, for whatever designs and arrays.

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
from .objectives import check_turns, known, needs, objective_values
from .outcome import Demand, Outcome, existing_states, outcome, states_for
from .reversal import overlap_width, reversal_depth, uniform_reversal_depths
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
    names = known(objectives)
    check_turns(names, task.scheme)
    values = np.full((len(names), len(designs)), np.nan)
    for index, found in outcomes(designs, task, needs(names), resolution):
        values[:, index] = objective_values(found, names)
    return dict(zip(names, values, strict=True))


def outcomes(
    designs: Designs,
    task: Task,
    needs: tuple[str, ...] = (),
    resolution: Resolution | None = None,
) -> Iterator[tuple[Any, Outcome]]:
    """Outcomes of designs for a task, batch by batch.

    **Arguments:** `needs`: of the objectives, "size", "curves", both or nothing; others as of
    `evaluate`.

    **Returns:** the indices of the designs in a batch, and their outcome; a single index for an
    outcome without an axis for designs.

    **Raises:** `ValueError` for designs off the model's domain.
    """
    _check(designs)
    demand = Demand.from_task(task)
    for index, units, uniform in _groups(designs, task.scheme):
        some = designs.take(index, units)
        states = states_for(demand.scheme, units)
        shared = uniform and states.gapless
        chosen = resolution or (UNIFORM if shared else MIXED)
        if shared or (states.gapless and states.separable and "curves" not in needs):
            for part, found in _batches(some, uniform, demand, needs, chosen):
                yield index[part], found
            continue
        for i, single in enumerate(index):
            sizes = some.sizes(i)
            yield (
                single,
                design_outcome(some.drawing(i), some.counts[i], sizes, demand, needs, chosen),
            )


def design_outcome(
    drawing: Muscle,
    counts: Whole,
    sizes: Sizes,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution = MIXED,
) -> Outcome:
    """What a single design does, computed at every level: by JAX, where any array is JAX's.

    **Arguments:**

    - `drawing`: whose material, laws and tuning all muscles have.
    - `counts`: muscles in each unit.
    - `sizes`: of the muscles of each unit.
    - `demand`: the task's.
    - `needs`: of the objectives, "size", "curves", both or nothing.
    - `resolution`: of levels and strains.

    **Returns:** the outcome, without an axis for designs.
    """
    exists, states = counts > 0, states_for(demand.scheme, len(counts))
    top = depth = overlap = None
    if "curves" in needs:
        law = sizes.muscle(drawing).law
        free = law.tension.free_strain(demand.supply + 0.0 * sizes.length)
        top = where(exists, free, 0.0).max()
    table, curves = every_level_table(drawing, sizes, demand, needs, resolution, top)
    if top is not None:
        depth = reversal_depth(counts, curves, top, states)
        overlap = overlap_width(
            counts, curves, curves, states, existing_states(demand.scheme, exists)
        )
    return outcome(counts, table, sizes.length[0], demand, depth, overlap)


def room_for_units(designs: Designs, scheme: AbstractScheme) -> Int[np.ndarray, " design"]:
    """How many motor units each design is evaluated with: as many as any has, or its own number
    where a `scheme` doesn't take a design of fewer units as the beginning of one of more.
    """
    most = designs.counts.shape[1]
    if scheme.independent or is_prefix_consistent(scheme, most):
        return np.full(len(designs), most)
    return designs.units


def _groups(
    designs: Designs, scheme: AbstractScheme
) -> Iterator[tuple[Int[np.ndarray, " some"], int, bool]]:
    """Indices of designs that can be evaluated together: of one drawing, with so many units,
    and either all of one muscle each or not.
    """
    keys = np.stack([designs.kind, room_for_units(designs, scheme), designs.uniform], axis=1)
    for key in np.unique(keys, axis=0):
        yield np.flatnonzero(np.all(keys == key, axis=1)), int(key[1]), bool(key[2])


def _batches(
    designs: Designs,
    uniform: bool,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution,
) -> Iterator[tuple[Int[np.ndarray, " some"], Outcome]]:
    """Outcomes of designs of one drawing, batch by batch, with the batch's indices."""
    points, units = demand.travel.size, designs.counts.shape[1]
    step, drawing = max(1, _BATCH // (points * units)), designs.drawing(0)
    columns = 1 if uniform else units
    sizes = [x[:, :columns] for x in (designs.radius, designs.wall, designs.angle)]
    rows = np.stack([designs.length[:, None] + 0.0 * sizes[0], *sizes], axis=-1)
    muscles, which = np.unique(rows.reshape(-1, 4), axis=0, return_inverse=True)
    which = which.reshape(-1, columns)
    # designs of one muscle share its part of a table, however many they are
    batch = which[:, 0] // max(1, _BATCH // points) if uniform else np.arange(len(rows)) // step
    for number in np.unique(batch):
        (some,) = np.nonzero(batch == number)
        own, index = np.unique(which[some], return_inverse=True)
        part, index = Sizes(*muscles[own].T), index.reshape(-1, columns)
        table = largest_force_table(drawing, part, demand, needs, resolution)
        depth = overlap = None
        if "curves" in needs:
            depth, overlap = np.empty((2, len(some)))
            for muscle in range(len(own)):
                (like,) = np.nonzero(index[:, 0] == muscle)
                counts = designs.counts[some[like]].T
                depth[like], overlap[like] = _curve_objectives(
                    drawing, part.take(muscle), counts, demand, resolution
                )
        for start in range(0, len(some), step):
            cut = slice(start, start + step)
            found = outcome(
                designs.counts[some[cut]].T,
                table.take(index[cut].T),
                designs.length[some[cut]],
                demand,
                None if depth is None else depth[cut],
                None if overlap is None else overlap[cut],
            )
            yield some[cut], found


def _curve_objectives(
    drawing: Muscle,
    sizes: Sizes,
    counts: Int[np.ndarray, "unit design"],
    demand: Demand,
    resolution: Resolution,
) -> tuple[Float[np.ndarray, " design"], Float[np.ndarray, " design"]]:
    """Reversal depth [-] and overlap width [N] of designs of one muscle."""
    curves, top = force_curves(drawing, sizes, float(demand.supply), resolution)
    states, width = states_for(demand.scheme, len(counts)), np.empty(counts.shape[1])
    exists = existing_states(demand.scheme, counts > 0)
    ends = np.stack([curves.min(axis=0), curves.max(axis=0)])[..., None, None]
    step = max(1, _BATCH // (ends.size * len(counts)))
    for start in range(0, counts.shape[1], step):
        cut = (slice(None), slice(start, start + step))
        width[cut[1]] = overlap_width(
            counts[cut], curves[..., None, None], ends, states, exists[cut]
        )
    return uniform_reversal_depths(counts, curves, top, states), width


def _check(designs: Designs) -> None:
    if np.any(designs.wall >= designs.radius):
        raise InvalidInputError(
            "wall_thickness", "must be less than `outer_radius` in every design", None
        )
    if np.any(designs.counts.sum(axis=1) < 1):
        raise InvalidInputError("counts", "must hold at least one muscle in every design", None)

"""Objectives of any designs: those of one muscle share its forces, the others go one by one.

Few designs are judged by NumPy, at once; where there are many it is compiled, in batches that are
filled up to a few fixed shapes. A design's numbers depend on what it is judged among in the last
bits at most; the same call gives the same bits.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ..bundle.schemes import AbstractScheme
from ..bundle.states import extends
from ..core.errors import InvalidInputError
from ..core.module import to_numpy
from ..core.types import Bool, Float, Int
from ..muscle import Muscle
from .designs import Designs, Rows
from .objectives import check_turns, known, needs
from .outcome import Demand, states_for
from .shared import Prepared, all_prepared, shared_objectives
from .tables import COMPILE_ABOVE
from .task import Task
from .unlike import Sizes, unlike_objectives, whole_law


_LARGEST, _LEAST = 4096, 16  # designs in a batch of one muscle's
_STEP = 4  # muscles by which tables grow, so that few sizes of them are compiled for
_MUSCLES = 256  # that are prepared together
_LARGEST_UNLIKE = 1024
# pairs of a design and a point of its task: NumPy takes some 0.2 µs for each
_COMPILE_ABOVE = 5_000_000
_LARGE = 20_000  # of one muscle's: to call what is compiled takes as long as NumPy with fewer

Values = dict[str, Float[np.ndarray, " design"]]


def evaluate(designs: Designs, task: Task, objectives: Iterable[str], among: int = 0) -> Values:
    """Objectives of designs for a task.

    **Arguments:**

    - `designs`: any number [-].
    - `task`: what is demanded [-].
    - `objectives`: by name, of `OBJECTIVES` [-].
    - `among`: how many designs are judged in all [-], where it is more than these: for many it
      pays to compile.

    **Returns:** an array for each, in its own unit [SI].

    **Raises:** `ValueError` for an unknown objective, and designs off the model's domain.
    """
    names = known(objectives)
    check_turns(names, task.scheme)
    _check(designs)
    values = np.full((len(names), len(designs)), np.nan)
    for rows, some in of_one_number(designs, task.scheme):
        values[:, rows] = _evaluated(some, task, names, max(among, len(designs)))
    return dict(zip(names, values, strict=True))


def _evaluated(
    designs: Designs, task: Task, names: tuple[str, ...], among: int
) -> Float[np.ndarray, "objective design"]:
    values = np.full((len(names), len(designs)), np.nan)
    demand, asked, units = Demand.of(task), needs(names), designs.counts.shape[1]
    states = states_for(demand.scheme, units)
    # what one muscle's designs share is made for states that grow, with no gap between them
    grows = states.in_turn or states.together
    alike = designs.alike & (states.joined and (grows or "curves" not in asked))
    share = max(1.0, among / max(1, len(designs)))
    many = len(designs) * len(task) * share > _COMPILE_ABOVE
    of_kind: dict[int, list[tuple[np.ndarray, int]]] = {}
    for group in groups(designs, alike):
        of_kind.setdefault(int(designs.kind[group[1]]), []).append(group)
    for kind, drawing in enumerate(map(to_numpy, designs.drawings.values())):
        found = of_kind.get(kind, [])
        many_muscles = 2 * len(found) * len(task) * share > COMPILE_ABOVE
        for start in range(0, len(found), _MUSCLES):
            some = found[start : start + _MUSCLES]
            for (rows, _), one in zip(
                some, _prepared(designs, drawing, some, demand, names, many_muscles), strict=True
            ):
                large = many and len(rows) * len(task) > _LARGE
                values[:, rows] = _of_one_muscle(one, designs.counts[rows], demand, names, large)
        (rows,) = np.nonzero(~alike & (designs.kind == kind))
        for start in range(0, len(rows), _LARGEST_UNLIKE):
            block = rows[start : start + _LARGEST_UNLIKE]
            full = block
            if whole_law(demand, units, asked):
                full = _filled(block, _power(len(block), _LEAST, _LARGEST_UNLIKE))
            part = unlike_objectives(
                drawing, sizes_of(designs, full), demand, names=names, needs=asked,
                among=int(len(rows) * share),
            )  # fmt: skip
            values[:, block] = np.asarray(part)[:, : len(block)]
    return values


def _prepared(
    designs: Designs,
    drawing: Muscle,
    some: list[tuple[np.ndarray, int]],
    demand: Demand,
    names: tuple[str, ...],
    compiling: bool,
) -> list[Prepared]:
    """What the designs of each of some groups share."""
    place = np.array([first for _, first in some])
    own = (x[place, 0] for x in (designs.radius, designs.wall, designs.angle))
    totals = designs.counts[place].sum(axis=1)
    # one size of tables for all groups, and few of them for all calls
    most = -(-int(designs.counts.sum(axis=1).max()) // _STEP) * _STEP
    rows = Rows(drawing, designs.length[place], *own)
    return all_prepared(
        rows, totals.tolist(), demand, most, needs(names), compiling=compiling,
        units=designs.counts.shape[1],
    )  # fmt: skip


def _of_one_muscle(
    shared: Prepared,
    counts: np.ndarray,
    demand: Demand,
    names: tuple[str, ...],
    compiling: bool,
) -> Float[np.ndarray, "objective design"]:
    """Objectives of compositions, a row for each name [SI]."""
    values = np.empty((len(names), len(counts)))
    for start in range(0, len(counts), _LARGEST):
        places = np.arange(start, min(start + _LARGEST, len(counts)))
        full = places
        if compiling:
            full = _filled(places, _power(len(places), _LEAST, _LARGEST))
        part = shared_objectives(shared, counts[full], demand, names=names, compiling=compiling)
        values[:, places] = part[:, : len(places)]
    return values


def groups(
    designs: Designs, alike: Bool[np.ndarray, " design"] | None = None
) -> list[tuple[np.ndarray, int]]:
    """Designs of one muscle and as many of it: the indices of each group, and its first [-].

    **Arguments:**

    - `designs`: any [-].
    - `alike`: those that are meant [-]; left out, all whose muscles are alike.

    **Returns:** the groups [-], in the order of their first designs.
    """
    (rows,) = np.nonzero(designs.alike if alike is None else alike)
    if not rows.size:
        return []
    first = (x[rows, 0] for x in (designs.radius, designs.wall, designs.angle))
    total = designs.counts[rows].sum(axis=1)
    key = np.stack([designs.kind[rows], designs.length[rows], *first, total], axis=1)
    _, start, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(which.reshape(-1), kind="stable")
    parts = np.split(rows[order], np.cumsum(np.bincount(which.reshape(-1)))[:-1])
    found = [(part, int(rows[i])) for part, i in zip(parts, start, strict=True)]
    return sorted(found, key=lambda group: group[1])


def sizes_of(designs: Designs, rows: np.ndarray) -> Sizes:
    """The sizes of some designs as the kernel takes them; `designs` and `rows` [-]."""
    own = designs.take(rows)
    return Sizes(own.counts, own.length, own.radius, own.wall, own.angle)


def size_of(designs: Designs, place: int, scheme: AbstractScheme) -> Sizes:
    """The sizes of one design, without an axis for designs; `designs`, `place` and the `scheme` of
    its recruitment [-].
    """
    ((_, one),) = of_one_number(designs.take(np.array([place])), scheme)
    return Sizes(*(leaf[0] for leaf in sizes_of(one, np.array([0]))))


def of_one_number(
    designs: Designs, scheme: AbstractScheme
) -> list[tuple[Int[np.ndarray, " some"], Designs]]:
    """Designs as they can be judged together.

    **Arguments:**

    - `designs`: any [-].
    - `scheme`: of recruitment [-].

    **Returns:** places and designs [-]: all, or those of each number of units where the scheme
    doesn't take one of fewer units as the beginning of one of more.
    """
    most = designs.counts.shape[1]
    if scheme.independent or extends(scheme, most):
        return [(np.arange(len(designs)), designs)]
    found = []
    for units in np.unique(designs.units).tolist():
        (rows,) = np.nonzero(designs.units == units)
        some = designs.take(rows)
        cut = {key: getattr(some, key)[:, :units] for key in ("counts", "radius", "wall", "angle")}
        found.append((rows, replace(some, **cut)))
    return found


def _check(designs: Designs) -> None:
    straight = np.asarray(designs.wall >= designs.radius)
    if np.any(straight):
        raise InvalidInputError(
            "wall_thickness", "must be less than `outer_radius` in every design", None
        )
    if np.any(designs.counts.sum(axis=1) < 1):
        raise InvalidInputError("counts", "must hold at least one muscle in every design", None)


def _power(count: int, least: int, most: int) -> int:
    """The next power of two, within bounds."""
    return min(max(least, 1 << (count - 1).bit_length()), most)


def _filled(rows: np.ndarray, size: int) -> np.ndarray:
    return np.concatenate([rows, np.full(size - len(rows), rows[0])])

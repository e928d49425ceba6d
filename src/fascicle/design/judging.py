"""Objectives of any designs: those of one muscle share its forces, the others go one by one.

Batches are filled up to a few fixed shapes, so that little is compiled. A design's numbers
depend on the shape of its batch in the last bits at most; the same call gives the same bits.
"""

from collections.abc import Iterable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from .designs import Designs
from .objectives import known, needs
from .outcome import Demand
from .shared import prepared, shared_objectives
from .task import Task
from .unlike import Sizes, unlike_objectives


_LARGEST, _LEAST = 4096, 16  # designs in a batch of one muscle's
_STEP = 4  # muscles by which tables grow
_LARGEST_UNLIKE, _LEAST_UNLIKE = 1024, 8

Values = dict[str, Float[np.ndarray, " design"]]


def evaluate(designs: Designs, task: Task, objectives: Iterable[str]) -> Values:
    """Objectives of designs for a task.

    **Arguments:**

    - `designs`: any number [-].
    - `task`: what is demanded [-].
    - `objectives`: by name, of `OBJECTIVES` [-].

    **Returns:** an array for each, in its own unit [SI].

    **Raises:** `ValueError` for an unknown objective, and designs off the model's domain.
    """
    names = known(objectives)
    _check(designs)
    values = np.full((len(names), len(designs)), np.nan)
    demand = Demand.of(task)
    # one size of tables for all groups, and few of them for all calls: less to compile
    most = -(-int(designs.counts.sum(axis=1).max(initial=1)) // _STEP) * _STEP
    for rows, place in groups(designs):
        values[:, rows] = of_one_muscle(designs, rows, place, demand, names, most)
    for kind, drawing in enumerate(designs.drawings.values()):
        (rows,) = np.nonzero(~designs.alike & (designs.kind == kind))
        for block in _blocks(rows, _LARGEST_UNLIKE):
            full = _filled(block, _power(len(block), _LEAST_UNLIKE, _LARGEST_UNLIKE))
            part = unlike_objectives(
                drawing, sizes_of(designs, full), demand, names=names, needs=needs(names)
            )
            values[:, block] = np.asarray(part)[:, : len(block)]
    return dict(zip(names, values, strict=True))


def of_one_muscle(
    designs: Designs,
    rows: np.ndarray,
    place: int,
    demand: Demand,
    names: tuple[str, ...],
    most: int,
) -> Float[np.ndarray, "objective design"]:
    """Objectives of designs that are compositions of as many of the same muscle.

    **Arguments:**

    - `designs`: among others [-].
    - `rows`: which of them [-].
    - `place`: of one of these [-].
    - `demand`: the task's [-].
    - `names`: of the objectives [-].
    - `most`: muscles that tables are made for [-], at least as many as a design has.

    **Returns:** them, a row for each name, in its unit [SI].
    """
    counts = designs.counts
    total = int(counts[place].sum())
    shared = prepared(designs.muscle(place), total, demand, most=most, needs=needs(names))
    values = np.empty((len(names), len(rows)))
    for start in range(0, len(rows), _LARGEST):
        block = rows[start : start + _LARGEST]
        full = _filled(block, _power(len(block), _LEAST, _LARGEST))
        part = shared_objectives(shared, jnp.asarray(counts[full]), demand, names=names)
        values[:, start : start + len(block)] = np.asarray(part)[:, : len(block)]
    return values


def groups(designs: Designs) -> list[tuple[np.ndarray, int]]:
    """Designs of one muscle and as many of it: the indices of each group, and its first [-].

    **Arguments:** `designs`: any [-].

    **Returns:** the groups [-], in the order of their first designs.
    """
    (rows,) = np.nonzero(designs.alike)
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
    arrays = (own.counts, own.length, own.radius, own.wall, own.angle)
    return Sizes(*(jnp.asarray(x) for x in arrays))


def size_of(designs: Designs, place: int) -> Sizes:
    """The sizes of one design, without an axis for designs; `designs` and `place` [-]."""
    return Sizes(*(leaf[0] for leaf in sizes_of(designs, np.array([place]))))


def _check(designs: Designs) -> None:
    straight = np.asarray(designs.wall >= designs.radius)
    if np.any(straight):
        raise ValueError("`wall_thickness` must be less than `outer_radius` in every design.")
    if np.any(designs.counts.sum(axis=1) < 1):
        raise ValueError("`counts` must hold at least one muscle in every design.")


def _blocks(rows: np.ndarray, most: int) -> list[np.ndarray]:
    return [rows[start : start + most] for start in range(0, len(rows), most)]


def _power(count: int, least: int, most: int) -> int:
    """The next power of two, within bounds."""
    return min(max(least, 1 << (count - 1).bit_length()), most)


def _filled(rows: np.ndarray, size: int) -> np.ndarray:
    return np.concatenate([rows, np.full(size - len(rows), rows[0])])

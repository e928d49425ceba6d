"""A record as a fit sees it: levels of pressure, and the readings at each.

Free strain and collapse depend on pressure alone, so readings at one pressure share them.
Pressures that a transducer scattered are gathered into levels, a long sweep is averaged
in even steps of strain, and the rows are filled up to one length: a fit then costs one
solve for each level, and is compiled once for each shape.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..records.record import Record


_GAP = 0.005  # of the largest pressure: readings closer than this share a level
_WIDEST = 0.02  # of the largest pressure: a level wider than this is a sweep, cut finer
LONGEST = 400  # readings of a level; a longer sweep is averaged

Table = Float[Array, "level reading"]


class Grid(eqx.Module):
    """Readings by level of pressure, in rows of one length.

    - `pressure`: of each level [Pa], as a column.
    - `strain`, `force`: of each reading [-], [N].
    - `count`: how many readings are averaged there [-]; 0 where a row is filled up.
    - `censored`: whether the reading only says "not above" [-].
    """

    pressure: Float[Array, "level 1"]
    strain: Table
    force: Float[Array, "*seeds level reading"]
    count: Table
    censored: Bool[Array, "level reading"]

    @property
    def uncensored(self) -> Bool[Array, "level reading"]:
        """Which places hold a force that was measured [-]."""
        return (self.count > 0) & ~self.censored


def grid(record: Record, longest: int = LONGEST) -> Grid:
    """`record` [-] by level of pressure, at most `longest` readings [-] in each."""
    levels = level_of(record.pressure)
    rows = [
        _row(record, np.flatnonzero(levels == level), longest) for level in range(levels.max() + 1)
    ]
    width = max(strain.size for _, strain, _, _, _ in rows)

    def filled(place: int, kind: type = float) -> np.ndarray:
        table = np.zeros((len(rows), width), kind)
        for i, row in enumerate(rows):
            table[i, : row[place].size] = row[place]
        return table

    return Grid(
        pressure=jnp.asarray([[row[0]] for row in rows]),
        strain=jnp.asarray(filled(1)),
        force=jnp.asarray(filled(2)),
        count=jnp.asarray(filled(3)),
        censored=jnp.asarray(filled(4, bool)),
    )


def level_of(pressure: np.ndarray) -> np.ndarray:
    """The level of each `pressure` [Pa], numbered from the lowest [-]."""
    order = np.argsort(pressure, kind="stable")
    P, top = pressure[order], max(float(np.max(pressure)), 1.0)
    cluster = np.concatenate([[0], np.cumsum(np.diff(P) > _GAP * top)])
    first, last = (
        P[np.searchsorted(cluster, cluster)],
        P[np.searchsorted(cluster, cluster, "right") - 1],
    )
    # a pressure that was swept has no gaps: cut it in steps as fine as a gap
    within = np.where(last - first > _WIDEST * top, np.floor((P - first) / (_GAP * top)), 0.0)
    new = (np.diff(cluster) > 0) | (np.diff(within) != 0)
    levels = np.empty(P.size, dtype=int)
    levels[order] = np.concatenate([[0], np.cumsum(new)])
    return levels


def _row(record: Record, points: np.ndarray, longest: int) -> tuple:
    """Pressure of a level, and its readings averaged to at most `longest`."""
    P = float(np.mean(record.pressure[points]))
    strain, force = record.strain[points], record.force[points]
    censored = record.censored[points]
    if points.size <= longest:
        return P, strain, force, np.ones(points.size), censored
    low, high = strain.min(), strain.max()
    steps = longest // 2  # censored readings are never averaged with others
    place = np.minimum((steps * (strain - low) / max(high - low, 1e-12)).astype(int), steps - 1)
    _, inverse, count = np.unique(2 * place + censored, return_inverse=True, return_counts=True)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(inverse, values) / count

    return P, mean(strain), mean(force), count.astype(float), mean(censored) > 0.5

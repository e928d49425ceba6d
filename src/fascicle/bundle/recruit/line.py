"""A closer look at parts of curves: at a lane's own strain, at levels that are solved for.

What a muscle's law solves for depends on pressure alone, so at kept levels a force costs a fifth of
what it does elsewhere. Over these a part of a curve is seen as it is: neighboring cells that all
rise or all fall hold a demand once, where its sign changes, or not at all. The demand may be in a
cell that spans it, with a margin of what the cell and its neighbors span: no farther does a dip
between two nodes reach. What turns there is left to the search that looks at every stretch. Where
nothing is met, the turns that may be nearest are found in the same way.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .guide import Parts, Runs
from .single import CELLS, LEVELS


Along = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Turns(NamedTuple):
    """Where lanes may turn, an entry each: its `lane`, levels [-] on both sides, a `level` between
    them, and how far above what is wanted the lane is there, its `miss` [N].
    """

    lane: np.ndarray
    low: np.ndarray
    high: np.ndarray
    level: np.ndarray
    miss: np.ndarray


def closer(above: Along, parts: Parts, close: np.ndarray) -> tuple[Runs, Parts]:
    """Where lanes are met within parts of their curves.

    **Arguments:**

    - `above`: how far lanes are above what is wanted [N] at numbered levels, these along a second
      axis [-].
    - `parts`: whose levels are the guide's [-].
    - `close`: what counts as met at a curve's ends [N], an entry for each part.

    **Returns:** runs, each between two levels, and the parts that are left [-].
    """
    node, value, beside, margin, inside = _seen(above, parts)
    left, right = value[:, :-1], value[:, 1:]
    may = (np.minimum(left, right) - margin <= 0) & (np.maximum(left, right) + margin >= 0)
    may = may & inside
    row, place = np.nonzero(np.diff(_between(False, may, False), axis=1))
    row, a, b = row[::2], place[::2], place[1::2]

    risen = _between(0.0, np.cumsum(np.sign(beside), axis=1))
    total = risen[row, b + 2] - risen[row, a]
    simple, sense = np.abs(total) == b + 2 - a, np.sign(total)
    upward = sense[:, None] * value[row]
    every = np.arange(len(row))
    below, over, near = upward[every, a], upward[every, b], close[row]
    starts, finishes = node[row, a] == 0, node[row, b] == CELLS
    # an end that is met is counted as such
    beyond = (starts & (below >= -near)) | (finishes & (over <= near))
    met = simple & (below < 0) & (over > 0) & ~beyond

    lane, low, high = parts.lane[row], LEVELS[node[row, a]], LEVELS[node[row, b]]
    left = Parts(*(x[~simple] for x in (lane, low, high)))
    row, sense, upward, a, b = (x[met] for x in (row, sense, upward, a, b))
    among = (a[:, None] <= np.arange(node.shape[1])) & (np.arange(node.shape[1]) <= b[:, None])
    a = a + np.sum(among & (upward < 0), axis=1) - 1
    every = np.arange(len(row))
    low, high = LEVELS[node[row, a]], LEVELS[node[row, a + 1]]
    g_a, g_b = upward[every, a], upward[every, a + 1]
    slope = (g_b - g_a) / (high - low)
    return Runs(lane[met], low, high, sense > 0, low - g_a / slope, sense * slope), left


def turns(above: Along, parts: Parts, within: np.ndarray) -> tuple[Turns, np.ndarray]:
    """Where lanes that are met nowhere may turn nearer than `within` [N].

    **Arguments:** as of `closer`; `within`: an entry for each part [N].

    **Returns:** turns, and marks of those `parts` that jump past what is wanted [-].
    """
    node, value, _, margin, inside = _seen(above, parts)
    jumps = np.any((value[:, 1:] > 0) != (value[:, :-1] > 0), axis=1)
    size = np.abs(value)
    falls = inside & (size[:, 1:] <= size[:, :-1])
    rises = inside & (size[:, 1:] >= size[:, :-1])
    # at a curve's end it may turn within its first cell
    falls = _between(False, falls) | (node == 0)
    rises = _between(rises, False) | (node == CELLS)
    wide = _between(margin[:, :1], margin, margin[:, -1:])
    least = size - np.maximum(wide[:, 1:], wide[:, :-1])
    row, place = np.nonzero(falls & rises & (least < within[:, None]) & ~jumps[:, None])
    before, after = np.maximum(place - 1, 0), np.minimum(place + 1, node.shape[1] - 1)
    low, high, near = (LEVELS[node[row, x]] for x in (before, after, place))
    return Turns(parts.lane[row], low, high, near, value[row, place]), jumps


def _seen(above: Along, parts: Parts) -> tuple[np.ndarray, ...]:
    """Numbered levels in each of the `parts` and one beyond, values there [N], by how much these
    rise from one to the next, with one more on both sides, the margin of each cell [N], and whether
    it is inside.
    """
    first, last = (np.rint(np.sqrt(x) * CELLS).astype(int) for x in (parts.low, parts.high))
    begin, end = np.maximum(first - 1, 0)[:, None], np.minimum(last + 1, CELLS)[:, None]
    node = np.minimum(begin + np.arange(int(np.max(end - begin)) + 1), end)
    value = above(parts.lane, node)
    along = np.arange(node.shape[1] - 1)
    # beyond its last cell a row goes on as it did
    rise = np.take_along_axis(np.diff(value, axis=1), np.minimum(along, end - begin - 1), axis=1)
    beside = _between(rise[:, :1], rise, rise[:, -1:])
    margin = np.abs(np.stack([beside[:, :-2], rise, beside[:, 2:]])).max(axis=0)
    inside = (first[:, None] <= node[:, :-1]) & (node[:, :-1] < last[:, None])
    return node, value, beside, margin, inside


def _between(*columns: Any) -> np.ndarray:
    """Columns beside one another, where one may be a number for all rows."""
    rows = max(len(x) for x in columns if isinstance(x, np.ndarray))
    whole = [x if isinstance(x, np.ndarray) else np.full((rows, 1), x) for x in columns]
    return np.concatenate(whole, axis=1)

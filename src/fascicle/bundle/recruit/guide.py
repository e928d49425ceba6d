r"""In which levels a state's curve is to be looked for a demand: a grid of forces, as a guide.

The curves (B8) are evaluated on a grid of levels and strains, strains as they are asked for. In a
cell of it a curve lies between the least and the largest of its corners, with a margin of what
its units span there; a demand beyond isn't met in the cell. Cells in a row where it may be, of
which all rise or all fall, at both strains and together with their neighbors, hold it once or not
at all, and from the corners its level is nearly known. Any other row is left to the search that
looks at every stretch in it.

It is a guide only, the forces that are met are the law's own. NumPy's alone.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...core.evaluate import compiled
from ...core.modules import Module
from ...core.tiles import scattered
from ..plates import muscle_strain
from .single import LEVELS


_CELL = 2.0**-8  # of strain
_LEVELS = LEVELS[::8]  # with cells eight times as wide
_REMEMBERED = 256  # cells, of some 30 kB each
_MARGIN = 0.5  # of what the units span in a cell, beyond its corners

Forces = tuple[np.ndarray, ...]  # and their slopes in strain [N], kinds last


class Runs(NamedTuple):
    """Where lanes are met once, an entry each: its `lane`, levels [-] on both sides, whether the
    force `rises` from one to the other, a level `near` it, and the force's slope by level [N].
    """

    lane: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rises: np.ndarray
    near: np.ndarray
    slope: np.ndarray


class Parts(NamedTuple):
    """Where lanes may be met any number of times, an entry each: its `lane`, and the levels [-]
    between which that is.
    """

    lane: np.ndarray
    low: np.ndarray
    high: np.ndarray


class _Cells(NamedTuple):
    """Cells of strain, in order of their `number`: the states' forces [N] at both strains, every
    level; between which forces [N] they lie between levels, and between all; and how many cells
    rise less how many fall up to each, one beside the levels at both ends.
    """

    number: np.ndarray
    corners: np.ndarray
    low: np.ndarray
    high: np.ndarray
    least: np.ndarray
    most: np.ndarray
    risen: np.ndarray


class _Rows(NamedTuple):
    """Rows of cells of a lane each: levels from the `first` to the `last`, whether the curve rises
    or falls, whether that is `simple`, and how far it is `above` at a level, made to rise [N].
    """

    lane: np.ndarray
    first: np.ndarray
    last: np.ndarray
    sense: np.ndarray
    simple: np.ndarray
    above: Callable[[np.ndarray], np.ndarray]


class Told(NamedTuple):
    """A cell of strain, state by state, in Python's numbers: as `_Cells`, and the forces [N] at
    `one` and at the `other` of its strains, every level.
    """

    least: list[float]
    most: list[float]
    low: list[list[float]]
    high: list[list[float]]
    risen: list[list[int]]
    one: list[list[float]]
    other: list[list[float]]


class _Ends(Module):
    """Rows of muscles at no and at supply pressure; $L/L_i$ [-] of each, where lengths differ."""

    at: tuple[Any, ...]
    ratios: tuple[Any, ...]


class Guide:
    """The grid of a bank of curves."""

    def __init__(
        self,
        rows: Sequence[Any],
        supply: Any,
        throttled: np.ndarray,
        kept: Callable[[Forces], Forces],
    ):
        """`places`: of each kind its row, and the place [-] in it.

        **Arguments:**

        - `rows`: of muscles of the same laws [-].
        - `supply`: $P_s$ [Pa].
        - `throttled`: how many muscles of each kind a state throttles [-].
        - `kept`: what counts of forces and slopes [N].
        """
        self.places = [(row, place) for row in rows for place in range(row.size)]
        self._supply = float(supply)
        self._throttled, self._kept = throttled, kept
        self._ratios = tuple(row.ratios for row in rows)
        P = (_LEVELS * supply)[:, None]
        self._at = tuple(row.muscles.law.at(P * np.ones(row.size)) for row in rows)
        both = np.array([[0.0], [supply]])
        ends = (row.muscles.law.at(both * np.ones(row.size)) for row in rows)
        self._ends = _Ends(tuple(ends), self._ratios)
        self._cells: _Cells | None = None
        self._told: dict[int, Told] = {}

    def ends(self, strain: np.ndarray, many: bool) -> tuple[Forces, Forces]:
        """Forces of one muscle of each kind at no and at supply pressure [N] at each `strain` [-],
        by a compiled law if they are `many`.
        """
        if len(strain) == 1 and (told := self.single_ends(float(strain[0]))) is not None:
            (off, off_slope), (on, on_slope) = (np.transpose(end)[:, None] for end in told)
            return (off, off_slope), (on, on_slope)
        law = partial(scattered, compiled(_forces)) if many else _forces
        found = zip(*law(self._ends, strain), strict=True)
        force, slope = self._kept(tuple(np.concatenate(rows, axis=-1) for rows in found))
        return (force[:, 0], slope[:, 0]), (force[:, 1], slope[:, 1])

    def single_ends(self, strain: float) -> list[list[Any]] | None:
        """The same at one `strain` [-], kind by kind, as they count; `None` until they are asked
        for often.
        """
        if not all(row.each[place].ends_at_once() for row, place in self.places):
            return None
        return [
            [self._kept(row.single(place, pressure, strain)) for row, place in self.places]
            for pressure in (0.0, self._supply)
        ]

    def told(self, strain: float) -> tuple["Told", float]:
        """The cell of one `strain` [-] in Python's numbers, and how far in it that is [-]."""
        place = strain / _CELL
        number = math.floor(place)
        if number not in self._told:
            if len(self._told) > _REMEMBERED:
                self._told.clear()
            cells, slot, _ = self._at_strain(np.array([strain]))
            at = slot[0]
            sides = np.swapaxes(cells.corners[at], 1, 2)
            parts = (cells.least, cells.most, cells.low, cells.high, cells.risen)
            self._told[number] = Told(*(x[at].tolist() for x in parts), *sides.tolist())
        return self._told[number], place - number

    def runs(
        self,
        state: np.ndarray,
        strain: np.ndarray,
        wanted: np.ndarray,
        ends: tuple[np.ndarray, np.ndarray],
        close: np.ndarray,
    ) -> tuple[Runs, Parts]:
        """Where lanes are met within a state's curve.

        **Arguments:**

        - `state`: of each lane [-].
        - `strain`: of each lane [-].
        - `wanted`: of the throttled units [N].
        - `ends`: how far they are above it at both ends of the curve [N].
        - `close`: what counts as met there [N].

        **Returns:** the runs of cells, and the parts of curves of which they don't tell all [-].
        """
        rows = self._rows(state, strain, wanted, wanted)
        lane, first, last, sense, above = rows.lane, rows.first, rows.last, rows.sense, rows.above
        starts, finishes = first == 0, last == len(_LEVELS) - 1
        below = np.where(starts, sense * ends[0][lane], above(first))
        over = np.where(finishes, sense * ends[1][lane], above(last))
        simple = rows.simple
        # an end that is met is counted as such
        beyond = simple & ((starts & (below >= -close[lane])) | (finishes & (over <= close[lane])))
        met = simple & (below < 0) & (over > 0) & ~beyond

        a, b = first, last
        while np.any(b - a > 1):
            middle = (a + b) // 2
            higher = above(middle) > 0
            a, b = np.where(higher | (b - a <= 1), a, middle), np.where(higher, middle, b)
        low, high, g_a, g_b = _LEVELS[a], _LEVELS[b], above(a), above(b)
        slope = np.maximum(g_b - g_a, 0.0) / (high - low)
        near = low - g_a / np.where(slope > 0, slope, np.inf)
        runs = Runs(
            lane, _LEVELS[first], _LEVELS[last], sense > 0,
            np.minimum(np.maximum(near, low), high), sense * slope,
        )  # fmt: skip
        left = ~met & ~beyond
        parts = Parts(lane[left], runs.low[left], runs.high[left])
        return Runs(*(x[met] for x in runs)), parts

    def nearer(
        self, state: np.ndarray, strain: np.ndarray, wanted: np.ndarray, within: np.ndarray
    ) -> Parts:
        """Where lanes, met nowhere, may come nearer than their ends, and nearer than `within` [N].

        **Arguments:** those of `runs`.

        **Returns:** parts of their curves [-].
        """
        rows = self._rows(state, strain, wanted - within, wanted + within)
        first, last = rows.first, rows.last
        ends = (first == 0) | (last == len(_LEVELS) - 1)
        # what rises all along is nearest at an end, unless it jumps past what is wanted
        aside = (rows.above(first) > 0) == (rows.above(last) > 0)
        some = ~(rows.simple & ends & aside)
        return Parts(rows.lane[some], _LEVELS[first[some]], _LEVELS[last[some]])

    def _rows(
        self, state: np.ndarray, strain: np.ndarray, least: np.ndarray, most: np.ndarray
    ) -> "_Rows":
        """Rows of cells in which lanes may give between `least` and `most` [N]."""
        cells, slot, share = self._at_strain(strain)
        some = cells.least[slot, state] <= most
        some = np.flatnonzero(some & (least <= cells.most[slot, state]))
        low, high = (x[slot[some], state[some]] for x in (cells.low, cells.high))
        may = (low <= most[some, None]) & (least[some, None] <= high)
        edges = np.zeros((len(may), may.shape[1] + 2), bool)
        edges[:, 1:-1] = may
        lane, place = np.nonzero(edges[:, 1:] != edges[:, :-1])
        lane, first, last = some[lane[::2]], place[::2], place[1::2]
        curve = (slot[lane], state[lane])
        risen = cells.risen[(*curve, last + 2)] - cells.risen[(*curve, first)]
        sense, middle = np.sign(risen), 0.5 * (least + most)[lane]

        def above(node: np.ndarray) -> np.ndarray:
            one, other = (cells.corners[slot[lane], side, node, state[lane]] for side in (0, 1))
            return sense * (one + share[lane] * (other - one) - middle)

        return _Rows(lane, first, last, sense, np.abs(risen) == last + 2 - first, above)

    def _at_strain(self, strain: np.ndarray) -> tuple[_Cells, np.ndarray, np.ndarray]:
        """Cells, in which of them each `strain` [-] is, and how far in it [-]."""
        place = strain / _CELL
        number = np.floor(place).astype(int)
        cells = self._cells
        if cells is None:
            cells = self._cells = self._made(np.unique(number))
        slot = np.searchsorted(cells.number, number)
        new = number[cells.number.take(slot, mode="clip") != number]
        if len(new):
            more = self._made(np.unique(new))
            both = [np.concatenate(pair) for pair in zip(cells, more, strict=True)]
            order = np.argsort(both[0])
            cells = self._cells = _Cells(*(x[order] for x in both))
            slot = np.searchsorted(cells.number, number)
        return cells, slot, place - number

    def _made(self, number: np.ndarray) -> _Cells:
        """Those cells of strain."""
        nodes = _CELL * (number[:, None] + np.arange(2))
        of_kinds = []
        for at, ratio in zip(self._at, self._ratios, strict=True):
            eps = nodes[..., None, None]
            own = eps if ratio is None else muscle_strain(ratio, eps)
            of_kinds.append(self._kept(at.force(own))[0])
        force = np.concatenate(of_kinds, axis=-1)  # [cell, side, level, kind]

        curves = force @ self._throttled.T
        low, high = curves.min(axis=1), curves.max(axis=1)
        low, high = np.minimum(low[:, :-1], low[:, 1:]), np.maximum(high[:, :-1], high[:, 1:])
        least, most = force.min(axis=1), force.max(axis=1)
        span = np.maximum(most[:, :-1], most[:, 1:]) - np.minimum(least[:, :-1], least[:, 1:])
        margin = _MARGIN * span @ self._throttled.T
        low, high = low - margin, high + margin
        # beyond a law's domain nothing is known
        known = np.isfinite(low) & np.isfinite(high)
        low, high = np.where(known, low, -np.inf), np.where(known, high, np.inf)

        one, other = np.sign(np.moveaxis(np.diff(curves, axis=2), 1, 0))
        rises = np.where(known & (one == other), one, 0.0)
        beside = np.pad(rises, ((0, 0), (1, 1), (0, 0)), mode="edge")
        risen = np.cumsum(np.pad(beside, ((0, 0), (1, 0), (0, 0))), axis=1).astype(int)
        low, high, risen = (np.swapaxes(x, 1, 2) for x in (low, high, risen))
        low, high, risen = map(np.ascontiguousarray, (low, high, risen))
        return _Cells(number, curves, low, high, low.min(axis=2), high.max(axis=2), risen)


def _forces(ends: _Ends, strain: Any) -> Any:
    """Forces of muscles at both pressures [N], rows of which may have another length than the
    plates are apart, and their slopes [N]; pressures along a second axis, kinds last.
    """
    found = []
    for at, ratio in zip(ends.at, ends.ratios, strict=True):
        eps = strain[:, None, None]
        force, slope = at.force(eps if ratio is None else muscle_strain(ratio, eps))
        found.append((force, slope if ratio is None else slope * ratio))
    return tuple(found)

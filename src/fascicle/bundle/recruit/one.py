"""One demand, without arrays: as a controller asks, again and again.

A dozen numbers in arrays take NumPy as long as a thousand, so what `guide`, `line` and `levels` do
for many demands is done here for one, number by number, and is the same to rounding. Where that
doesn't tell all, arrays do: where a curve turns near the demand, and where states are not of one
kind of muscle each.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import given
from ..states import States
from .curves import Bank
from .guide import Told
from .inverse import ABOVE, BELOW, REACHED, Recruited, Solutions
from .levels import EXACT, ROOM, ROUNDING, followed
from .nearest import ALIKE
from .single import CELLS, LEVELS


_LEVELS: list[float] = LEVELS.tolist()
_WIDE = 8  # of these cells in one of the guide's


class _Unclear(Exception):  # noqa: N818 it is no error
    """More is to be looked at than is here."""


class _State(NamedTuple):
    """A state at a strain: what its other units give and its slope [N], what it is to give, what
    counts as met, how far it is above that at no and at full pressure [N], and at a level [-].
    """

    held: float
    held_slope: float
    wanted: float
    close: float
    low: float
    high: float
    above: Callable[[float], float]


def one(
    bank: Bank, force: Any, strain: Any, present: Any = None, *, states: States
) -> Recruited | None:
    """Equation (B9) for one demand; `None` where arrays are needed.

    **Arguments:** as of `recruited`, arrays of one demand.

    **Returns:** the same [-], of one demand.
    """
    if bank.guide is None or not bank.spoken or bank.by_itself or not given(force, strain):
        return None
    F, eps = float(force[0]), float(strain[0])
    ends = bank.guide.single_ends(eps)
    if ends is None:
        return None
    told, share = bank.guide.told(eps)
    every = [_at(bank, k, F, eps, ends) for k in range(bank.states)]
    try:
        found = [
            (k, level)
            for k, state in enumerate(every)
            for level in _levels(bank, k, eps, state, told, share)
        ]
        met = len(found)
        if not found:
            found = [_nearest(every, told, share)]
    except _Unclear:
        return None
    forces = []
    for k, level in found:
        own, slope = bank.single(k, level, eps)
        forces.append((own + every[k].held, slope + every[k].held_slope))
    return _recruited(bank, states, found, forces, met, F, present)


def _at(bank: Bank, k: int, force: float, strain: float, ends: Any) -> _State:
    """State `k` [-] at a strain [-]."""
    (kind, share, none, full), (off, on) = bank.spoken[k], ends
    held, slope = (
        sum(a * x[i] for a, x in zip(none, off, strict=True))
        + sum(a * x[i] for a, x in zip(full, on, strict=True))
        for i in (0, 1)
    )
    wanted = force - held

    def above(level: float) -> float:
        return bank.single(k, level, strain)[0] - wanted

    low, high = (share * end[kind][0] - wanted for end in (off, on))
    return _State(held, slope, wanted, EXACT + ROUNDING * abs(wanted), low, high, above)


def _levels(
    bank: Bank, k: int, strain: float, state: _State, told: Told, share: float
) -> Iterator[float]:
    """Levels [-] at which it is met, rising."""
    begins, finishes = (one[k] for one in bank.counted)
    if abs(state.low) <= state.close and begins:
        yield 0.0
    for first, nodes, simple, sense in _rows(told, k, state.wanted, 0.0):
        if not simple:
            yield from _closer(bank, k, strain, state, nodes[0], nodes[-1])
            continue
        values = _values(told, k, share, state.wanted, first, len(nodes))
        values[0] = state.low if nodes[0] == 0 else values[0]
        values[-1] = state.high if nodes[-1] == CELLS else values[-1]
        yield from _met(state, nodes, values, sense)
    if abs(state.high) <= state.close and finishes:
        yield 1.0


def _nearest(every: Sequence[_State], told: Told, share: float) -> tuple[int, float]:
    """The state and the level of the end [-] that is nearest to what nothing gives."""
    misses = [abs(miss) for state in every for miss in (state.low, state.high)]
    within = min(misses)
    for k, state in enumerate(every):
        for first, nodes, simple, _ in _rows(told, k, state.wanted, within):
            values = _values(told, k, share, state.wanted, first, len(nodes))
            # what rises all along is nearest at an end, unless it jumps past what is wanted
            aside = (values[0] > 0) == (values[-1] > 0)
            if not (simple and aside and (nodes[0] == 0 or nodes[-1] == CELLS)):
                raise _Unclear
    # of those that are one the lowest state is told
    k, side = divmod(next(i for i, miss in enumerate(misses) if miss <= within + ALIKE), 2)
    return k, float(side)


def _rows(
    told: Told, k: int, wanted: float, within: float
) -> Iterator[tuple[int, list[int], bool, float]]:
    """Rows of the guide's cells in which state `k` [-] may come so near to what is wanted [N]: the
    first level of the guide's, numbered levels, whether all rise or all fall, and which of both.
    """
    least, most = wanted - within, wanted + within
    if told.least[k] > most or told.most[k] < least:
        return
    risen, sides = told.risen[k], zip(told.low[k], told.high[k], strict=True)
    for first, last in _runs(low <= most and least <= high for low, high in sides):
        rise = risen[last + 2] - risen[first]
        nodes = [n * _WIDE for n in range(first, last + 1)]
        yield first, nodes, abs(rise) == last + 2 - first, math.copysign(1.0, rise)


def _values(told: Told, k: int, share: float, wanted: float, first: int, count: int) -> list[float]:
    """How far it is above what is wanted [N] at so many levels of the guide's, by its corners."""
    one, other = (side[k][first : first + count] for side in (told.one, told.other))
    return [x + share * (y - x) - wanted for x, y in zip(one, other, strict=True)]


def _closer(
    bank: Bank, k: int, strain: float, state: _State, first: int, last: int
) -> Iterator[float]:
    """The same in a part that the guide doesn't see through, at all levels in it."""
    begin, end = max(first - 1, 0), min(last + 1, CELLS)
    nodes = list(range(begin, end + 1))
    value = [x - state.wanted for x in bank.levels(k, nodes, strain)]
    rise = [y - x for x, y in pairwise(value)]
    beside = [rise[0], *rise, rise[-1]]
    margin = [max(map(abs, beside[i : i + 3])) for i in range(len(rise))]
    may = [
        first <= n < last and min(x, y) - m <= 0 <= max(x, y) + m
        for n, (x, y), m in zip(nodes, pairwise(value), margin, strict=False)
    ]
    for a, b in _runs(may):
        senses = {math.copysign(1.0, x) if x else 0.0 for x in beside[a : b + 2]}
        if len(senses) > 1 or 0.0 in senses:
            raise _Unclear  # it turns there
        yield from _met(state, nodes[a : b + 1], value[a : b + 1], senses.pop())


def _met(
    state: _State, nodes: Sequence[int], values: Sequence[float], sense: float
) -> Iterator[float]:
    """Where values [N] that all rise or all fall over numbered levels change their sign."""
    upward = [sense * x for x in values]
    # an end that is met is counted as such
    ends = (nodes[0] == 0 and upward[0] >= -state.close) or (
        nodes[-1] == CELLS and upward[-1] <= state.close
    )
    if ends or not upward[0] < 0 < upward[-1]:
        return
    i = next(n for n, x in enumerate(upward) if x >= 0) - 1
    low, high = _LEVELS[nodes[i]], _LEVELS[nodes[i + 1]]
    slope = (upward[i + 1] - upward[i]) / (high - low)
    near = min(max(low - upward[i] / slope, low), high)
    whole = (_LEVELS[nodes[0]], _LEVELS[nodes[-1]])
    level, miss = followed(state.above, 1e-2 * state.close, whole, sense, near, slope)
    if abs(miss) > state.close:
        raise _Unclear  # a jump
    yield level


def _runs(marks: Any) -> Iterator[tuple[int, int]]:
    """Where marks in a row begin and end."""
    first, n = None, -1
    for n, mark in enumerate(marks):
        if mark and first is None:
            first = n
        elif not mark and first is not None:
            yield first, n
            first = None
    if first is not None:
        yield first, n + 1


def _recruited(
    bank: Bank, states: States, found: list, forces: list, met: int, demand: float, present: Any
) -> Recruited:
    """Of all that was `found` the first, or the one whose pressures are nearest to the `present`
    [Pa]; so many of them are `met` [-].
    """
    state, level = map(np.array, zip(*found, strict=True))
    force, slope = np.transpose(forces)
    every = states.pressures(state, level, bank.supply)
    apart = np.zeros(len(found)) if present is None else ((every - present) ** 2).sum(axis=-1)
    taken = int(np.argmin(apart))
    best = slice(taken, taken + 1)
    slots = max(ROOM * bank.states + 2, met)
    pressure, number = np.full((1, slots), np.nan), np.zeros((1, slots), int)
    stable, firm = slope < 0, np.zeros((1, slots), bool)
    pressure[0, :met] = level[:met] * bank.supply
    number[0, :met], firm[0, :met] = state[:met] + 1, stable[:met]
    status = REACHED if met else ABOVE if force[0] < demand else BELOW
    return Recruited(
        pressures=every[best],
        state=state[best] + 1,
        force=force[best],
        status=np.array([status]),
        stable=stable[best],
        solutions=Solutions(pressure, number, firm),
        count=np.array([met]),
        unit=states.leading[state[best]] + 1,
    )

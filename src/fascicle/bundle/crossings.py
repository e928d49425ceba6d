r"""Where curves cross zero, many curves at once, none missed that can be helped.

A curve is a sum of terms that are smooth in the stretches between given ends. In a stretch
each term lies, with a margin, among the control points of the cubic through its values and
slopes at the stretch's two sides; where their sums leave zero out, nothing crosses. The few
other stretches are cut into cells, each once more at the extremum of its own cubic, and a
crossing is a change of sign between two nodes, in a stretch or from it to the next. A pair
that is missed lies in a dip shallower than that cubic's error, of fourth order in the cell.
"""

from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, running_max, sqrt, where
from ..core.types import AnyArray, Bool, Float, Int, Numbers
from .lists import listed, worked


CELLS = 8  # of a stretch that may hold a crossing
_MARGIN = 0.25  # of a term's span over a stretch, beyond its control points
_WIDTH = 1e-13  # ends closer than this are one

Ends = Float[AnyArray, "lane end"]
PerStretch = Float[AnyArray, "lane stretch"]
Listed = Float[AnyArray, " entry"]


@runtime_checkable
class Curves(Protocol):
    """Sums of terms: what the terms of some lanes' curves are, on a last axis, at places along a
    second [any unit].
    """

    def terms(self, lane: Any, place: Any, /) -> tuple[Any, Any]:
        """Values of the terms and their slopes."""
        ...

    def values(self, lane: Any, place: Any, /) -> Any:
        """Values of the terms alone."""
        ...


class Sides(NamedTuple):
    """Stretches of every lane, `low` to `high`, as seen from just inside them: the curve's value
    and slope there, and between which values it lies; all in the units of the curve.
    """

    low: PerStretch
    high: PerStretch
    value_low: PerStretch
    value_high: PerStretch
    slope_low: PerStretch
    slope_high: PerStretch
    least: PerStretch
    most: PerStretch

    @property
    def real(self) -> Bool[AnyArray, "lane stretch"]:
        """Which of them have a width."""
        return self.high - self.low > _WIDTH

    @property
    def may_cross(self) -> Bool[AnyArray, "lane stretch"]:
        """Which of them may hold a crossing of zero."""
        return self.real & (self.least <= 0) & (self.most >= 0)


class Cut(NamedTuple):
    """Stretches that were cut, a row each: its `lane`, `nodes` that leave one crossing at most
    between two, the last on the next stretch, and the curve's `value` there.
    """

    lane: Int[AnyArray, " row"]
    nodes: Float[AnyArray, "row node"]
    value: Float[AnyArray, "row node"]
    real: Bool[AnyArray, " row"]


class Crossings(NamedTuple):
    """Crossings in the order of lanes and places: the `lane` of each, the places before and
    behind it, the curve's values at these, and whether it falls. `total` are meant, the rest is
    room.
    """

    lane: Int[AnyArray, " entry"]
    low: Listed
    high: Listed
    value_low: Listed
    value_high: Listed
    falls: Bool[AnyArray, " entry"]
    total: Any


def sides(curves: Curves, ends: Ends, inset: Numbers) -> Sides:
    """Stretches and what is seen of them.

    **Arguments:**

    - `curves`: the lanes' [any unit].
    - `ends`: of each lane's stretches, rising [any unit].
    - `inset`: how far inside its sides are looked at, as a share of its width [-].

    **Returns:** the stretches [any unit].
    """
    at_work = array_namespace(ends)
    a, b = ends[:, :-1], ends[:, 1:]
    step = inset * (b - a)
    # the first and the last end have no other side
    low = where(a > ends[:, :1], a + step, a)
    high = where(b < ends[:, -1:], b - step, b)
    (v_a, v_b), (s_a, s_b) = _seen(curves, low, high, b - a > _WIDTH)
    thirds = (high - low)[..., None] / 3
    control = (v_a + s_a * thirds, v_b - s_b * thirds)
    least, most = (pick(pick(v_a, v_b), pick(*control)) for pick in (minimum, maximum))
    margin = _MARGIN * (most - least)
    summed = (v_a, v_b, s_a, s_b, least - margin, most + margin)
    return Sides(low, high, *(at_work.sum(x, axis=-1) for x in summed))


def cut(curves: Curves, stretches: Sides, marks: Bool[AnyArray, "lane stretch"]) -> Cut:
    """Those stretches that are marked, cut into cells.

    **Arguments:**

    - `curves`: the lanes' [any unit].
    - `stretches`: of every lane [any unit].
    - `marks`: which are to be cut [-].

    **Returns:** their nodes and values [any unit].
    """

    def look(lane: Any, *of: Listed) -> tuple[Numbers, Numbers]:
        low, high, v_low, v_high, s_low, s_high, after, v_after = of
        at_work = array_namespace(low)
        x = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, CELLS + 1)
        value, slope = (at_work.sum(y, axis=-1) for y in curves.terms(lane, x[:, 1:-1]))
        value, slope = (
            at_work.concatenate([first[:, None], y, last[:, None]], axis=1)
            for first, y, last in ((v_low, value, v_high), (s_low, slope, s_high))
        )
        step = x[:, 1:] - x[:, :-1]
        turn = _extremum(value[:, :-1], value[:, 1:], slope[:, :-1] * step, slope[:, 1:] * step)
        between = x[:, :-1] + step * turn
        turned = at_work.sum(curves.values(lane, between), axis=-1)
        return (
            _interleaved(x, between, after[:, None]),
            _interleaved(value, turned, v_after[:, None]),
        )

    (lane, place), total = listed(marks, marks.size)
    seen = [x[lane, place] for x in stretches[:6]]
    next_one = following(stretches.real)[lane, place]
    last = next_one == marks.shape[1]
    beside = where(last, place, next_one)
    after, v_after = (
        where(last, high[lane, place], low[lane, beside])
        for low, high in (
            (stretches.low, stretches.high), (stretches.value_low, stretches.value_high)
        )
    )  # fmt: skip
    nodes, value = worked(look, total, lane, *seen, after, v_after)
    return Cut(lane, nodes, value, np.arange(len(lane)) < total)


def changes(stretches: Cut, room: int) -> Crossings:
    """Where the values at the nodes of cut `stretches` [any unit] change sign; compiled, there is
    `room` for so many [-].
    """
    above = stretches.value > 0
    (row, node), total = listed((above[:, 1:] != above[:, :-1]) & stretches.real[:, None], room)
    (low, high), (v_low, v_high) = (
        (x[row, node], x[row, node + 1]) for x in (stretches.nodes, stretches.value)
    )
    return Crossings(stretches.lane[row], low, high, v_low, v_high, above[row, node], total)


def following(real: Bool[AnyArray, "lane stretch"]) -> Int[AnyArray, "lane stretch"]:
    """Place of the next stretch that is `real` [-]; as many as there are where none is."""
    count = real.shape[1]
    places = where(real, np.arange(count), count)[:, ::-1]
    ahead = -running_max(-places, 1)[:, ::-1]
    at_work = array_namespace(real)
    return at_work.concatenate([ahead[:, 1:], 0 * ahead[:, :1] + count], axis=1)


def _seen(curves: Curves, low: Numbers, high: Numbers, real: Any) -> Any:
    """Values of the terms at the two sides of each stretch, and their slopes [any unit]; zeros for
    those without a width, but a curve's first and last.
    """
    at_work, count = array_namespace(low), low.shape[1]
    if at_work is not np:
        found = curves.terms(np.arange(len(low)), at_work.concatenate([low, high], axis=1))
        return tuple((one[:, :count], one[:, count:]) for one in found)
    asked = real.copy()
    asked[:, [0, -1]] = True
    lane, place = np.nonzero(asked)
    found = curves.terms(lane, np.stack([low[lane, place], high[lane, place]], axis=1))
    both = np.zeros((2, 2, *low.shape, found[0].shape[-1]))
    both[:, :, lane, place] = np.swapaxes(found, 1, 2)
    return both


def _interleaved(ends: Numbers, between: Numbers, after: Numbers) -> Numbers:
    at_work = array_namespace(ends, between)
    pairs = at_work.stack([ends[:, :-1], between], axis=-1).reshape(len(ends), 2 * CELLS)
    return at_work.concatenate([pairs, ends[:, -1:], after], axis=1)


def _extremum(left: Numbers, right: Numbers, left_slope: Numbers, right_slope: Numbers) -> Numbers:
    """Where in (0, 1) the cubic of these values and slopes turns; the middle if nowhere."""
    c3 = 2 * (left - right) + left_slope + right_slope
    c2 = 3 * (right - left) - 2 * left_slope - right_slope
    # 3 c3 t² + 2 c2 t + left_slope = 0, by the form that doesn't cancel
    inside = sqrt(maximum(c2**2 - 3 * c3 * left_slope, 0.0))
    q = -(c2 + where(c2 < 0, -inside, inside))
    t1 = q / where(c3 == 0, np.inf, 3 * c3)
    t2 = left_slope / where(q == 0, np.inf, q)
    good1, good2 = (t1 > 0) & (t1 < 1), (t2 > 0) & (t2 < 1)
    return where(good1, t1, where(good2, t2, 0.5))

r"""One muscle's force curves over throttled pressure, and what follows of them for compositions.

Strains of the curves are even, from rest to the free strain at the supply's pressure. Of all
levels the first whose force vanishes is found on the least of them: at the strain where this does,
and there alone, levels are told apart.
"""

from typing import NamedTuple

import numpy as np

from ..bundle.states import common
from ..core.array_namespace import array_namespace, minimum, where
from ..core.types import AnyArray, Float, Int, Numbers
from ..muscle.piecewise import Pressurized
from .designs import Rows
from .tables import COMPILE_ABOVE, Resolution, run


def first_push(force: Float[AnyArray, "*any strain"]) -> Int[AnyArray, "*any"]:
    """The first strain after rest at which a force doesn't pull.

    **Arguments:** `force`: over strains, on the last axis [N].

    **Returns:** its place [-]; the last, if there is none.
    """
    at_work = array_namespace(force)
    place = at_work.arange(force.shape[-1])
    pushes = ((force <= 0) & (place > 0)) | (place == force.shape[-1] - 1)
    return at_work.argmax(pushes, axis=-1)


def share(left: Numbers, right: Numbers) -> Numbers:
    """How far from one strain to the next a force vanishes.

    **Arguments:** `left`, `right`: at both [N].

    **Returns:** the share of the way [-].
    """
    # the last of all may still pull by rounding: it is the zero itself
    drop = left - minimum(right, 0.0)
    return where(left > 0, left / where(drop > 0, drop, 1.0), 0.0)


_TOGETHER = 8  # muscles of one call: with more their forces leave the cache
_AT_ONCE = 2**20  # numbers worked on at once

PerStrain = Float[np.ndarray, " strain"]
Counted = Int[np.ndarray, " transition"]


class Curves(NamedTuple):
    """The `force` [N] of one muscle at each level and even strain up to its free strain `top`
    [-]; the `least` and the `largest` of all levels [N].
    """

    force: Float[np.ndarray, "level strain"]
    least: PerStrain
    largest: PerStrain
    top: float


def curves_of(rows: Rows, supply: float, resolution: Resolution) -> list[Curves]:
    """The curves of muscles.

    **Arguments:**

    - `rows`: the muscles, on one axis [-], NumPy's.
    - `supply`: the supply's pressure [Pa].
    - `resolution`: of levels and strains [-].

    **Returns:** them, of each [-].
    """
    count, pressure = rows.length.size, resolution.level[:, None] * supply
    even = np.linspace(0.0, 1.0, resolution.strains)
    compiling = count * pressure.size * even.size > COMPILE_ABOVE
    found = []
    for start in range(0, count, _TOGETHER):
        places = np.arange(start, start + _TOGETHER)
        # filled up: what is compiled has as many in every call
        places = np.minimum(places, count - 1) if compiling else places[places < count]
        law = rows.take((places, None, None)).muscle.law
        # free strain and collapse are few searches, which take longer to compile than to do
        at = run(law.at, False)(pressure)
        top = at.column.free_strain[:, -1:]
        force = run(_force, compiling)(at, top * even)
        least, largest = force.min(axis=1), force.max(axis=1)
        found += [
            Curves(force[i], least[i], largest[i], float(top[i, 0, 0]))
            for i in range(min(_TOGETHER, count - start))
        ]
    return found


def depths(curves: Curves, muscles: int, most: int) -> Float[np.ndarray, "a n"]:
    """Fall of the free strain while further muscles are pressurized.

    **Arguments:**

    - `curves`: of the muscle [-].
    - `muscles`: how many a design has [-].
    - `most`: size of the table [-].

    **Returns:** the fall for each $(a, n)$ [-]; 0 where there is no such transition.
    """
    falls = np.zeros((most + 1, most + 1))
    force, places = curves.force, np.arange(curves.least.size)
    a, n = _transitions(muscles, before=1)
    for some in _parts(a.size, curves.least.size + len(force)):
        first, own = a[some][:, None], n[some][:, None]
        unfed = muscles - first - own

        def total(curve: np.ndarray, at: Int[np.ndarray, "#some place"]) -> np.ndarray:
            """The bundle's force where the throttled muscles give `curve`."""
            return first * force[-1][at] + own * curve + unfed * force[0][at]  # noqa: B023

        right = first_push(total(curves.least, places[None]))[:, None]
        ahead, behind = (total(force[:, at[:, 0]].T, at) for at in (right - 1, right))
        shares = np.where((behind <= 0) | (right == places[-1]), share(ahead, behind), 1.0)
        unfed_right = first_push(total(force[0], places[None]))[:, None]
        begun = share(*(total(force[0][at], at) for at in (unfed_right - 1, unfed_right)))
        fall = (unfed_right + begun)[:, 0] - (right[:, 0] + shares.min(axis=1))
        falls[a[some], n[some]] = curves.top * fall / places[-1]
    return falls


def overlaps(curves: Curves, muscles: int, most: int, held: bool) -> Float[np.ndarray, "a n after"]:
    """Widest overlap of the states $(a, n)$ and $(a + n, n')$.

    **Arguments:**

    - `curves`: of the muscle [-].
    - `muscles`: how many a design has [-].
    - `most`: size of the table [-].
    - `held`: whether the $a$ muscles before are held at full supply, else all share a pressure [-].

    **Returns:** the overlap for each $(a, n, n')$ [N]; 0 where there are no such states.
    """
    full, none = curves.force[-1], curves.force[0]
    widths = np.zeros((most + 1,) * 3)
    a, n = _transitions(muscles, before=0)
    after = muscles - a - n
    which = np.repeat(np.arange(a.size), after)
    a, n = a[which], n[which]
    m = np.arange(which.size) - np.repeat(np.cumsum(after) - after, after) + 1

    def edges(before: np.ndarray, own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if not held:
            before, own = 0 * before, before + own
        others = before * full + (muscles - before - own) * none
        return others + own * curves.least, others + own * curves.largest

    for some in _parts(a.size, full.size):
        first, own, more = (x[some][:, None] for x in (a, n, m))
        bottom, top = common(edges(first, own), edges(first + own, more))
        width = np.max(top - bottom, axis=1)
        widths[a[some], n[some], m[some]] = np.maximum(width, 0.0)
    return widths


def _force(at: Pressurized, strain: Numbers) -> Numbers:
    return at.force(strain)[0]


def _transitions(muscles: int, before: int) -> tuple[Counted, Counted]:
    """Muscles fed, at least as many as `before`, and muscles throttled, at least one."""
    a, n = np.nonzero(np.add.outer(np.arange(muscles), np.arange(1, muscles + 1)) <= muscles)
    there = a >= before
    return a[there], n[there] + 1


def _parts(count: int, width: int) -> list[slice]:
    step = max(1, _AT_ONCE // width)
    return [slice(start, start + step) for start in range(0, count, step)]

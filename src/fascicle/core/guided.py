r"""Where roots that depend on one number are searched for at many, a few say where to begin.

A function of a number $x$ from 0 to some end solves for roots on its way, and each is smooth in
$x$ but at kinks. It is called at a few numbers, and each root becomes a Chebyshev series in
$x/(x + a)$, which is linear for small $x$ and saturates, as free and collapse strains do. At many
numbers each search then begins at what its series says.

A series decides nothing: a search that begins there ends where it would have, by the same test,
or goes on as from anywhere else. One that is too far off, as across a kink, isn't asked.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from .apart import apart
from .arrays import maximum, minimum
from .roots import still, watched
from .series import series
from .types import Batch


_TERMS = 48  # of a series, at most
# a, of the end: 100 kPa of 1 MPa. Free strains bend at some 50, collapse strains at 150, and
# fewest terms tell of both between
_BEND = 0.1
# how far it may be off the root, and so many steps of Newton's come as near as a search ends
_OFF = ((3e-8, 1), (1e-3, 2))


class Line(NamedTuple):
    """A root along $x$: its `series` [-], and how many `steps` of Newton's from there are enough;
    none where it says too little.
    """

    series: tuple[float, ...]
    steps: int


_NONE = Line((), 0)


def lines(function: Callable[[np.ndarray], Any], end: float) -> tuple[Line, ...]:
    """The roots that a `function` of $x$ [any unit], from 0 to `end`, searches for on its way.

    **Arguments:**

    - `function`: elementwise, of NumPy's arrays [-].
    - `end`: of $x$ [any unit].

    **Returns:** them, in the order of its searches [-].
    """
    nodes, between = chebyshev.chebpts1(_TERMS), chebyshev.chebpts2(_TERMS)
    place = np.concatenate([nodes, between])
    share = (1 + place) / 2
    x = end * _BEND * share / (1 + _BEND - share)
    found: list[Any] = []

    def seen(search: Callable, low: Batch, high: Batch, start: Batch, soon: int) -> Batch:
        del low, high
        found.append(search(start, soon))
        return found[-1]

    with np.errstate(all="ignore"), watched(seen):  # of branches that aren't taken
        function(x)
    return tuple(_line(nodes, between, root) for root in found)


@contextmanager
def guided(known: tuple[Line, ...], x: Batch, end: float) -> Iterator[None]:
    """Searches inside begin where the lines `known` [-] say, at `x` from 0 to `end` [any unit]."""
    x = still(x)
    place = 2 * (1 + _BEND) * x / (x + _BEND * end) - 1
    rest = iter(known)

    def began(search: Callable, low: Batch, high: Batch, start: Batch, soon: int) -> Batch:
        line = next(rest, _NONE)
        if not line.steps:
            return search(start, soon)
        told = apart(partial(series, line.series), place)
        return search(minimum(maximum(told, low), high), line.steps)

    with watched(began):
        yield


def _line(nodes: np.ndarray, between: np.ndarray, root: Any) -> Line:
    if np.shape(root) != (2 * _TERMS,) or not np.all(np.isfinite(root)):
        return _NONE
    at_nodes, others = np.split(np.asarray(root), 2)
    terms = chebyshev.chebfit(nodes, at_nodes, _TERMS - 1)
    told = np.cumsum(terms[:, None] * chebyshev.chebvander(between, _TERMS - 1).T, axis=0)
    off = np.max(np.abs(told - others) / (1 + np.abs(others)), axis=1)
    for most, steps in _OFF:
        if (near := off <= most).any():
            return Line(tuple(terms[: np.argmax(near) + 1].tolist()), steps)
    return _NONE

"""A law at single points: NumPy's, until it was asked so often that spelling it out pays."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import jax
import numpy as np

from .spelled import REFUSED, SpellingError, spelled


# points that NumPy answers in as long as a law takes to be spelled out, some 20 ms
_PAYS = 64


class Often:
    """`law(part, *numbers)` at one point after the other."""

    def __init__(self, law: Callable[..., Any], part: Any, count: int):
        """**Arguments:** `law`: elementwise [-]; `part`: a tree of NumPy's numbers [SI]; `count`:
        how many numbers it takes beside [-].
        """
        self._law, self._part, self._count = law, part, count
        self._points = _points(law, jax.tree.structure(part))
        self._spelled: Callable[..., Any] | None = None

    def __call__(self, *numbers: float) -> Any:
        """What the law gives of floats [SI]: NumPy's numbers or Python's."""
        if self.spelled_out():
            try:
                return self._spelled(*map(float, numbers))  # type: ignore[misc] it is
            except REFUSED:
                pass
        with np.errstate(all="ignore"):  # of branches that aren't taken
            return self._law(self._part, *map(np.float64, numbers))

    def spelled_out(self, points: int = 1) -> bool:
        """Whether it is by now, as it is asked about so many `points` [-]."""
        if self._spelled is not None:
            return True
        self._points.asked += points
        if self._points.asked >= _PAYS:
            try:
                self._spelled = spelled(self._law, self._part, self._count)
            except (SpellingError, *REFUSED):
                self._points = _Points(-np.inf)  # NumPy's from now on
        return self._spelled is not None


class _Points:
    """How many points were asked for of parts that are made alike."""

    def __init__(self, asked: float = 0.0):
        self.asked = asked


@lru_cache(maxsize=256)
def _points(law: Callable, structure: Any) -> _Points:  # noqa: ARG001 it is found again by them
    return _Points()

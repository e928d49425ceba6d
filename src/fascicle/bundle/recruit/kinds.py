"""Unlike muscles of the same laws, in a row, and their forces at points of a bundle."""

import math
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import given, maximum, minimum
from ...core.evaluate import COMPILE_ABOVE, compiled
from ...core.tiles import scattered
from ...core.types import Numbers
from ...muscle import Muscle
from ..alike import taken
from ..plates import muscle_strain, plate_strain
from .single import Single


SINGLE = 4  # points up to which one by one is sooner than an array


class Kinds(NamedTuple):
    """Unlike muscles of the same laws, in a row; $L/L_i$ [-] of each, where they aren't as long as
    the plates are apart; `which` of them [-] are meant, all of them where left out. Beyond
    `at_once` points [-] their law is compiled. `each`: at single points, where NumPy works.
    """

    muscles: Muscle
    ratios: Numbers | None
    size: int
    which: Any = None
    at_once: int = COMPILE_ABOVE
    each: tuple[Single, ...] = ()

    def force(self, pressure: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force [N] and its slope in the bundle's `strain` [-], at `pressure` [Pa], kinds last
        unless some are picked.
        """
        ratios = self.ratios
        if ratios is not None and np.ndim(ratios) > 0 and self.which is not None:
            ratios = ratios[self.which]
        own = strain if ratios is None else muscle_strain(ratios, strain)
        value, slope = self._evaluated(pressure, own)
        return value, slope if ratios is None else slope * ratios

    def single(self, place: int, pressure: float, strain: float) -> tuple[float, float]:
        """Force [N] of the one at `place` [-], at `pressure` [Pa] and the bundle's `strain` [-],
        and its slope in that [N].
        """
        if self.ratios is None:
            return self.each[place].force(pressure, strain)
        ratio = float(np.broadcast_to(self.ratios, self.size)[place])
        force, slope = self.each[place].force(pressure, muscle_strain(ratio, strain))
        return force, slope * ratio

    def along(self, place: int, node: np.ndarray, strain: Numbers) -> np.ndarray:
        """The same at numbered levels, forces [N] alone."""
        if self.ratios is not None:
            strain = muscle_strain(np.broadcast_to(self.ratios, self.size)[place], strain)
        return self.each[place].along(node, strain)

    def kinks(self, pressure: Numbers) -> Numbers:
        """Strains of the bundle [-] at which they have kinks, on a new first axis."""
        kinks = self.muscles.law.at(pressure).kinks
        return kinks if self.ratios is None else plate_strain(self.ratios, kinks)

    def picked(self, place: Any) -> "Kinds":
        """Those at `place` [-], as many as it has."""
        return self._replace(which=minimum(maximum(place, 0), self.size - 1))

    def _evaluated(self, pressure: Numbers, strain: Numbers) -> Any:
        muscles, which = self.muscles, self.which
        if muscles.is_numpy and given(pressure, strain):
            kinds = np.arange(self.size) if which is None else which
            shape = np.broadcast_shapes(np.shape(pressure), np.shape(strain), kinds.shape)
            points = math.prod(shape)
            if 0 < points <= SINGLE or points > self.at_once:
                laid = [np.broadcast_to(x, shape).reshape(-1) for x in (kinds, pressure, strain)]
                if points <= SINGLE:
                    rows = zip(*laid, strict=True)
                    found = zip(*(self.each[i].force(P, eps) for i, P, eps in rows), strict=True)
                else:
                    found = scattered(compiled(_force), muscles, *laid)
                return tuple(np.reshape(x, shape) for x in found)
            if which is not None and points and np.all(which == which.flat[0]):
                return self.each[which.flat[0]].law.at(pressure).force(strain)
        if which is not None:
            muscles = taken(muscles, which)
        return muscles.law.at(pressure).force(strain)


def _force(muscles: Muscle, which: Any, pressure: Numbers, strain: Numbers) -> tuple:
    return taken(muscles, which).law.at(pressure).force(strain)

"""Laws that can be exchanged without compiling anew, for comparing many of them.

A law is chosen by a row of weights, 1 for it and 0 for its siblings: all choices are then
one function of their numbers.
"""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from ...core.types import AnyArray, Batch, BatchLike, Float
from ...muscle.bladder import Bladder
from ...muscle.buckling import Column
from ...muscle.collapse import COLLAPSE_LAWS, AbstractCollapse
from ...muscle.post_collapse import POST_COLLAPSE_LAWS, AbstractPostCollapse


class AnyCollapse(AbstractCollapse):
    """One of several collapse `laws` [-], by `weight` in their order [-]."""

    name: ClassVar[str] = "any"
    laws: tuple[AbstractCollapse, ...]
    weight: Float[AnyArray, "law"]
    factor: Batch

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m] at `youngs_modulus` [Pa] and `pressure` [Pa]."""
        moments = [law.moment(bladder, youngs_modulus, pressure) for law in self.laws]
        return self.factor * _weighed(self.weight, moments)


class AnyPostCollapse(AbstractPostCollapse):
    """One of several readings of what follows collapse, `laws` [-], by `weight` in their order
    [-]; its force is that reading's, its shape the derived one's.
    """

    name: ClassVar[str] = "any"
    slope_factor: ClassVar[float] = 1.0
    laws: tuple[AbstractPostCollapse, ...]
    weight: Float[AnyArray, "law"]

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """The halves' bending force $B$ [N] at `compression` $x$ [m], and its slope [N/m]."""
        forces, slopes = zip(*(law.halves(column, compression) for law in self.laws), strict=True)
        return _weighed(self.weight, forces), _weighed(self.weight, slopes)


def collapse_named(name: str, own: AbstractCollapse) -> AnyCollapse:
    """The collapse law of this `name` [-]; with its numbers where it is the muscle's `own` [-]."""
    laws = _laws(COLLAPSE_LAWS, own)
    return AnyCollapse(laws, _row(name, list(COLLAPSE_LAWS)), np.asarray(1.0))


def post_collapse_named(name: str, own: AbstractPostCollapse) -> AnyPostCollapse:
    """The reading of what follows collapse of this `name` [-]; with its numbers where it is the
    muscle's `own` [-].
    """
    return AnyPostCollapse(_laws(POST_COLLAPSE_LAWS, own), _row(name, list(POST_COLLAPSE_LAWS)))


def _laws(known: Mapping[str, Any], own: Any) -> tuple:
    """One of each, with its defaults, but for the muscle's own."""
    return tuple(own if type(own) is law else law() for law in known.values())


def _weighed(weight: Float[AnyArray, "law"], values: Sequence[Batch]) -> Batch:
    total = weight[0] * values[0]
    for w, value in zip(weight[1:], values[1:], strict=True):
        total = total + w * value
    return total


def _row(name: str, names: list[str]) -> Float[AnyArray, "law"]:
    return (np.arange(len(names)) == names.index(name)).astype(float)

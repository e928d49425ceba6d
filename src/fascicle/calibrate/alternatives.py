"""Laws that can be exchanged without compiling anew, for comparing many of them.

A law is chosen by a row of weights, 1 for it and 0 for its siblings: all choices are then
one function of their numbers.
"""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float

from .._types import AnyArray, Batch, BatchLike
from ..muscle.bladder import Bladder
from ..muscle.collapse import (
    COLLAPSE_LAWS,
    POST_COLLAPSE_LAWS,
    AbstractCollapse,
    AbstractPostCollapse,
)
from ..muscle.column import Column


class AnyCollapse(AbstractCollapse):
    """One of the collapse laws, by `weight` in their order [-]."""

    name: ClassVar[str] = "any"
    weight: Float[AnyArray, "law"]
    factor: Batch

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m] at `youngs_modulus` [Pa] and `pressure` [Pa]."""
        laws = [_made(law) for law in COLLAPSE_LAWS.values()]
        moments = [law.moment(bladder, youngs_modulus, pressure) for law in laws]
        return self.factor * _weighed(self.weight, moments)


class AnyPostCollapse(AbstractPostCollapse):
    """One of the readings of what follows collapse, by `weight` in their order [-]; its
    force is that reading's, its shape the derived one's.
    """

    name: ClassVar[str] = "any"
    slope_factor: ClassVar[float] = 1.0
    weight: Float[AnyArray, "law"]

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """The halves' bending force $B$ [N] at `compression` $x$ [m], and its slope [N/m]."""
        laws = POST_COLLAPSE_LAWS.values()
        forces, slopes = zip(*(_made(law).halves(column, compression) for law in laws), strict=True)
        return _weighed(self.weight, forces), _weighed(self.weight, slopes)


def collapse_named(name: str, factor: Any = 1.0) -> AnyCollapse:
    """The collapse law of this `name` [-], with a `factor` on its moment [-]."""
    return AnyCollapse(_row(name, list(COLLAPSE_LAWS)), np.asarray(factor, dtype=float))


def post_collapse_named(name: str) -> AnyPostCollapse:
    """The reading of what follows collapse of this `name` [-]."""
    return AnyPostCollapse(_row(name, list(POST_COLLAPSE_LAWS)))


def _made(law: Any) -> Any:
    """A law with its own defaults."""
    return law()


def _weighed(weight: Float[AnyArray, "law"], values: Sequence[Batch]) -> Batch:
    total = weight[0] * values[0]
    for w, value in zip(weight[1:], values[1:], strict=True):
        total = total + w * value
    return total


def _row(name: str, names: list[str]) -> Float[AnyArray, "law"]:
    return (np.arange(len(names)) == names.index(name)).astype(float)

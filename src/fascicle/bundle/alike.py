"""Muscles and units that are alike: of the same laws, stacked; equal ones, computed once."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .._checks import concrete
from ..muscle import Muscle


def stacked(muscles: Sequence[Muscle]) -> list[tuple[tuple[int, ...], Muscle]]:
    """Muscles of the same laws together, with their places among `muscles` [-], on a first axis."""
    alike: dict[Any, list[int]] = {}
    for i, muscle in enumerate(muscles):
        leaves, structure = jax.tree.flatten(muscle)
        alike.setdefault((structure, tuple(map(jnp.shape, leaves))), []).append(i)
    return [
        (
            tuple(places),
            jax.tree.map(lambda *leaves: jnp.stack(leaves), *(muscles[i] for i in places)),
        )
        for places in alike.values()
    ]


def unlike(things: Sequence[Any]) -> tuple[list[int], tuple[int, ...]]:
    """The places of those `things` [-] that equal none before them, and for each thing which of
    these it equals [-].
    """
    kept: list[int] = []
    which = []
    for i, thing in enumerate(things):
        same = (k for k, j in enumerate(kept) if _equal(thing, things[j]))
        which.append(next(same, len(kept)))
        if which[-1] == len(kept):
            kept.append(i)
    return kept, tuple(which)


def _equal(a: Any, b: Any) -> bool:
    if a is b:
        return True
    (these, structure), (those, other) = jax.tree.flatten(a), jax.tree.flatten(b)
    return structure == other and all(
        x is y or (concrete(x, y) and np.array_equal(np.asarray(x), np.asarray(y)))
        for x, y in zip(these, those, strict=True)
    )

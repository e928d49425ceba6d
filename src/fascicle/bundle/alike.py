"""Muscles and units that are alike: of the same laws, in a row; equal ones, computed once."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core.array_namespace import array_namespace
from ..core.module import tree_leaves, tree_replace, tree_structure
from ..muscle import Muscle
from ..muscle.muscle import batch_shape, tuning_tables


def stacked(muscles: Sequence[Muscle]) -> list[tuple[tuple[int, ...], Muscle]]:
    """Muscles of the same laws as one, with their places among `muscles` [-] on its last axis;
    several that are one and the same stay that one, which broadcasts.
    """
    alike: dict[Any, list[int]] = {}
    for i, muscle in enumerate(muscles):
        key = tree_structure(muscle), tuple(map(np.shape, tree_leaves(muscle)))
        alike.setdefault(key, []).append(i)
    return [(tuple(places), _row([muscles[i] for i in places])) for places in alike.values()]


def taken(muscle: Muscle, places: Any) -> Muscle:
    """Of a row of muscles those at `places` [-]; a single one stays as it is."""
    if np.ndim(muscle.length) == 0:
        return muscle
    leaves = tree_leaves(muscle)
    rows = _are_tables(muscle, leaves)
    some = [
        leaf[..., places, :] if row else leaf[..., places]
        for leaf, row in zip(leaves, rows, strict=True)
    ]
    return tree_replace(muscle, some)


def unlike(things: Sequence[Any]) -> tuple[list[int], tuple[int, ...]]:
    """The places of those `things` [-] that equal none before them, and for each thing which of
    these it equals [-].
    """
    kept: list[int] = []
    which = []
    for i, thing in enumerate(things):
        same = (k for k, j in enumerate(kept) if thing == things[j])
        which.append(next(same, len(kept)))
        if which[-1] == len(kept):
            kept.append(i)
    return kept, tuple(which)


def _row(muscles: list[Muscle]) -> Muscle:
    first = muscles[0]
    if all(muscle is first for muscle in muscles) and not batch_shape(first):
        return first
    leaves = tree_leaves(first)
    rows = zip(*map(tree_leaves, muscles), strict=True)
    joined = [
        array_namespace(*row).stack(row, axis=-2 if table else -1)
        for row, table in zip(rows, _are_tables(first, leaves), strict=True)
    ]
    return tree_replace(first, joined)


def _are_tables(muscle: Muscle, leaves: list[Any]) -> list[bool]:
    """Which of a muscle's leaves [-] are tables, whose last axis is their own."""
    tables = tuning_tables(muscle)
    return [id(leaf) in tables for leaf in leaves]

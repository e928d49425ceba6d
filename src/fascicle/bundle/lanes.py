"""Bundles at pressures, one a lane: of one bundle at many pressures, or of rows of bundles.

A bundle whose muscles are rows of muscles is a row of bundles. Searches work on lanes, some at a
time, so each lane takes its own bundle along.
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace
from ..core.module import tree_leaves, tree_map
from ..core.types import Numbers, PerUnit
from ..core.validation import broadcast_shape
from ..muscle.muscle import batch_shape, tuning_tables
from .at import Pressurized, pressurized


class Lanes(NamedTuple):
    """A `bundle` whose numbers are the same in all lanes, or one for each on an axis ahead of an
    axis of one; gauge `pressures` [Pa], lanes first.
    """

    bundle: Any
    pressures: PerUnit

    @property
    def at_once(self) -> bool:
        """Whether they are NumPy's [-]."""
        return array_namespace(self.pressures, *tree_leaves(self.bundle)) is np

    @property
    def single(self) -> bool:
        """Whether they are of one bundle [-]."""
        return not any(map(_is_row, tree_leaves(self.bundle)))

    @property
    def live(self) -> Pressurized:
        """They, at their pressures, with an axis of one ahead of units [-]."""
        return pressurized(self.bundle, self.pressures[:, None, :])

    def of(self, which: Any) -> "Lanes":
        """Those lanes [-] that are asked for."""
        bundle = self.bundle
        if not self.single:
            bundle = tree_map(lambda x: x[which] if _is_row(x) else x, bundle)
        return Lanes(bundle, self.pressures[which])


def batch(bundle: Any) -> tuple[int, ...]:
    """The shape of a row of bundles [-], `()` of a single one."""
    shapes = {"length": np.shape(bundle.plate_distance)}
    for i, unit in enumerate(bundle.motor_units, start=1):
        shapes |= {f"motor unit {i}": batch_shape(unit.muscle), f"count {i}": np.shape(unit.count)}
    return broadcast_shape(**shapes)


def laned(bundle: Any, pressures: PerUnit, *others: Numbers) -> tuple[Lanes, tuple[int, ...]]:
    """A bundle at pressures, or a row of bundles, as lanes.

    **Arguments:**

    - `bundle`: one, or a row of them [-].
    - `pressures`: gauge pressures [Pa], units on the last axis, the rest broadcasts.
    - `others`: whatever broadcasts against both [any unit].

    **Returns:** the lanes, and the shape [-] that they had.
    """
    rows, units = bundle._batch, np.shape(pressures)[-1]
    shape = np.broadcast_shapes(rows, np.shape(pressures)[:-1], *map(np.shape, others))
    each = array_namespace(pressures).broadcast_to(pressures, (*shape, units)).reshape(-1, units)
    if not rows:
        return Lanes(bundle, each), shape
    tables = set().union(*(tuning_tables(unit.muscle) for unit in bundle.motor_units))

    def row(leaf: Any) -> Any:
        own = np.shape(leaf)[-1:] if id(leaf) in tables else ()
        if np.ndim(leaf) == len(own):
            return leaf
        return array_namespace(leaf).broadcast_to(leaf, (*shape, *own)).reshape(-1, 1, *own)

    return Lanes(tree_map(row, bundle), each), shape


def _is_row(leaf: Any) -> bool:
    return np.ndim(leaf) > 1

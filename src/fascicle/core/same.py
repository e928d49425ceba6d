"""Trees of numbers as keys: what takes a while to make of the same numbers is made once."""

from typing import Any

import jax
import numpy as np


class Same:
    """Equal to another that holds the same `tree` [-]: of one kind, with the same numbers of the
    same libraries.
    """

    def __init__(self, tree: Any) -> None:
        self.tree = tree
        leaves, kind = jax.tree.flatten(tree)
        arrays = [(type(leaf), np.asarray(leaf)) for leaf in leaves]
        self._key = kind, *((of, x.shape, x.dtype.str, x.tobytes()) for of, x in arrays)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

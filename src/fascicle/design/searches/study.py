"""A search cut into blocks: what it is, who it is, and what one block of it gives.

Blocks are ranges of the space's index, so a block can be made anywhere, and again. What makes
the numbers what they are goes into a study's digest: results of another one are told apart.
"""

import hashlib
import json
from dataclasses import dataclass, fields
from functools import cached_property
from importlib.metadata import version
from typing import Any

import jax
import numpy as np

from ...core.errors import InvalidInputError
from ..judge.allowed import Limit, checked
from ..judge.judging import Values, evaluate
from ..judge.reach import demanding, recorded
from ..space.grids import Space
from ..space.task import Task


LARGEST = 4_000_000_000  # designs; an index is a 64-bit number, a journal has a line a block


@dataclass(frozen=True, eq=False)
class Study:
    """Designs of a `space` for a `task`, `names` of the objectives to record, their `senses`
    and `limits`, which make the front in the end; `block`: designs worked on at once.
    """

    space: Space
    task: Task
    names: tuple[str, ...]
    senses: dict[str, str]
    limits: dict[str, Limit]
    block: int

    @classmethod
    def of(
        cls,
        space: Space,
        task: Task,
        senses: dict[str, str],
        limits: dict[str, Limit] | None = None,
        extra: tuple[str, ...] = (),
        block: int = 4096,
    ) -> "Study":
        """A study.

        **Arguments:**

        - `space`: the designs [-].
        - `task`: what is demanded [-].
        - `senses`: "min" or "max" by objective [-].
        - `limits`: on objectives, by name [-].
        - `extra`: objectives to record that don't make the front [-].
        - `block`: designs worked on at once [-].

        **Returns:** the study [-].

        **Raises:** `ValueError` for unknown objectives, and blocks and spaces out of range.
        """
        limits = demanding(limits)
        names = recorded(senses, limits, extra)
        checked(senses, limits)
        if not 1 <= block <= 2**20:
            raise InvalidInputError("block", "must lie in [1, 1048576]", block)
        if len(space) > LARGEST:
            raise ValueError(f"the space holds {len(space)} designs, more than {LARGEST}.")
        return cls(space, task, names, dict(senses), limits, block)

    @property
    def blocks(self) -> int:
        """How many blocks there are [-]; the last may be shorter."""
        return -(-len(self.space) // self.block)

    @cached_property
    def digest(self) -> str:
        """What tells this study from any other whose numbers could differ [-]."""
        told = hashlib.sha256()
        told.update(json.dumps([version("fascicle"), self.names, self.block]).encode())
        for part in (self.task, self.space):
            for field in fields(part):
                told.update(field.name.encode())
                _feed(told, getattr(part, field.name))
        return told.hexdigest()

    def index(self, block: int) -> np.ndarray:
        """Indices of a block's designs [-]; `block` counts from 0 [-]."""
        start = block * self.block
        return np.arange(start, min(start + self.block, len(self.space)))

    def values(self, block: int) -> Values:
        """Objectives [SI] of a block's designs by name; `block` counts from 0 [-]."""
        # for all blocks alike, whoever computes them, so that the bits are the same
        among = len(self.space)
        return evaluate(self.space.at(self.index(block)), self.task, self.names, among)


def bits(values: Values) -> str:
    """A digest [-] of objectives' `values` [SI]: the same if, and only if, all bits are."""
    told = hashlib.sha256()
    for name, one in values.items():
        told.update(name.encode())
        told.update(np.ascontiguousarray(one, dtype="<f8").tobytes())
    return told.hexdigest()


def _feed(told: Any, value: Any) -> None:
    """Muscles by their laws and numbers, arrays by their bits, all else by its text."""
    if isinstance(value, np.ndarray):
        told.update(np.ascontiguousarray(value).tobytes())
        return
    if isinstance(value, dict):
        for name, one in value.items():
            told.update(str(name).encode())
            leaves, structure = jax.tree.flatten(one)
            told.update(str(structure).encode())
            for leaf in leaves:
                told.update(np.asarray(leaf, float).tobytes())
        return
    told.update(repr(value).encode())

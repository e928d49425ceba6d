"""What a bundle is wanted for: demanded forces at strains, how much each counts, the supply.

A task is a cloud of points of the force-strain plane with weights. One that is given in time
becomes a cloud whose weights are how long each point is held.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from .._checks import one_of, within
from .._limits import plausible
from ..bundle.bundle import SCHEMES


_LARGEST_STRAIN = 0.6
_MOST_POINTS = 100_000

Points = Float[np.ndarray, " point"]


@dataclass(frozen=True, eq=False)
class Task:
    """Demanded `force` [N] at `strain` [-], `weight` [-], `supply_pressure` [Pa]; the `scheme`
    of recruitment [-]; `name` and `source` [-]: where the figures come from.
    """

    force: Points
    strain: Points
    weight: Points
    supply_pressure: float
    scheme: str = "orderly"
    name: str = "task"
    source: str = ""

    @classmethod
    def of(
        cls,
        force: Any,
        strain: Any,
        supply_pressure: float,
        weight: Any = None,
        scheme: str = "orderly",
        name: str = "task",
        source: str = "",
    ) -> "Task":
        """A task of points that count by weight.

        **Arguments:**

        - `force`: demanded pulling forces [N], none negative.
        - `strain`: contractions at which they are demanded [-], none negative.
        - `supply_pressure`: the supply's gauge pressure [Pa].
        - `weight`: how much each point counts [-]; left out, all the same.
        - `scheme`: "orderly" or "batch" [-].
        - `name`: what it is [-].
        - `source`: where the figures come from [-].

        **Returns:** the task [-].

        **Raises:** `ValueError` for values off the domain and lists of unlike length.
        """
        closed = (True, True)
        F = np.atleast_1d(within(force, 0.0, 1e6, "force", "N", closed=closed)).astype(float)
        eps = within(strain, 0.0, _LARGEST_STRAIN, "strain", "-", closed=closed)
        eps = np.atleast_1d(eps).astype(float)
        if weight is None:
            weight = np.ones(F.shape)
        w = np.atleast_1d(within(weight, 0.0, 1e12, "weight", "-", closed=closed)).astype(float)
        if not F.shape == eps.shape == w.shape or F.ndim != 1:
            raise ValueError(
                "`force`, `strain` and `weight` must be lists of one length, got"
                f" {F.size}, {eps.size} and {w.size}."
            )
        if not 0 < F.size <= _MOST_POINTS:
            raise ValueError(f"`force` must hold 1 to {_MOST_POINTS} points, got {F.size}.")
        if not np.any((w > 0) & (F > 0) & (eps > 0)):
            raise ValueError(
                "`force` and `strain` must both be positive at a point that counts: this task"
                " does no work."
            )
        supply = within(supply_pressure, 0.0, 1e6, "supply_pressure", "Pa", closed=(False, True))
        plausible(supply, "supply_pressure")
        one_of(scheme, SCHEMES, "scheme")
        return cls(F, eps, w, float(supply), scheme, name, source)

    @classmethod
    def in_time(
        cls, time: Any, force: Any, strain: Any, supply_pressure: float, **more: Any
    ) -> "Task":
        """A task that is given in time; each point counts for as long as it is nearest.

        **Arguments:**

        - `time`: rising times [s].
        - `force`: demanded then [N].
        - `strain`: contractions then [-].
        - `supply_pressure`: the supply's gauge pressure [Pa].
        - `more`: as of `of` [-].

        **Returns:** the task [-].

        **Raises:** `ValueError` for times that don't rise, and as `of`.
        """
        t = np.atleast_1d(within(time, -1e12, 1e12, "time", "s")).astype(float)
        if t.ndim != 1 or t.size < 2 or np.any(np.diff(t) <= 0):
            raise ValueError("`time` must be a list of two or more that rises.")
        weight = np.gradient(t) * np.where((np.arange(t.size) % (t.size - 1)) == 0, 0.5, 1.0)
        return cls.of(force, strain, supply_pressure, weight, **more)

    @property
    def largest_strain(self) -> float:
        """The largest contraction demanded [-]."""
        return float(self.strain.max())

    def __len__(self) -> int:
        return self.force.size

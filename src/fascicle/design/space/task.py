"""What a bundle is wanted for: load cases, how much each counts, the supply.

A load case is a demanded force at a contraction, which is given as a strain, or as a stroke: a
length, which long muscles contract by with less strain. A task is a cloud of load cases with
weights. One that is given in time becomes a cloud whose weights are how long each is held.

Weights say how much a load case counts in a mean. None is so small that the bundle needn't
reach it: see `reach`.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...bundle.schemes import AbstractScheme, Orderly, scheme_of
from ...core.errors import InvalidInputError
from ...core.types import Float
from ...core.validation import (
    HIGHEST_PRESSURE,
    LARGEST_STRAIN,
    check_choice,
    check_interval,
    check_plausible,
)


_LONGEST_STROKE = 10.0  # m
_MOST_POINTS = 100_000
FLUIDS = ("air", "liquid")

Points = Float[np.ndarray, " point"]


@dataclass(frozen=True, eq=False)
class Task:
    """Demanded `force` [N], at `strain` [-] or after `stroke` [m], the other being `None`;
    `weight` [-], `supply_pressure` [Pa]; the `scheme` of recruitment [-]; `name` and `source`
    [-]: where the figures come from; `time` [s] of each point, if it has one; the `fluid` [-].
    """

    force: Points
    strain: Points | None
    weight: Points
    supply_pressure: float
    scheme: AbstractScheme = field(default_factory=Orderly)
    name: str = "task"
    source: str = ""
    stroke: Points | None = None
    time: Points | None = None
    fluid: str = "air"

    def __post_init__(self):
        # `replace` may be given a name; the object equals it
        object.__setattr__(self, "scheme", scheme_of(self.scheme))

    @classmethod
    def of(
        cls,
        force: Any,
        strain: Any,
        supply_pressure: float,
        weight: Any = None,
        scheme: AbstractScheme | str = "orderly",
        name: str = "task",
        source: str = "",
        stroke: Any = None,
        fluid: str = "air",
    ) -> "Task":
        """A task of points that count by weight.

        **Arguments:**

        - `force`: demanded pulling forces [N], none negative; a number stands for all points.
        - `strain`: contractions at which they are demanded [-], none negative, or a number;
          `None` where the stroke is given.
        - `supply_pressure`: the supply's gauge pressure [Pa].
        - `weight`: how much each point counts [-]; left out, all the same.
        - `scheme`: one of `fascicle.schemes`, by name or as an object [-].
        - `name`: what it is [-].
        - `source`: where the figures come from [-].
        - `stroke`: how much shorter the bundle is then [m], instead of `strain`.
        - `fluid`: "air" or "liquid" [-], of which its consumption is told.

        **Returns:** the task [-].

        **Raises:** `ValueError` for values off the domain and lists of unlike length, and where
        both of strain and stroke are given, or neither.
        """
        if (strain is None) == (stroke is None):
            which = "neither" if strain is None else "both"
            raise InvalidInputError(
                "stroke",
                "in m or `strain` tells how far the bundle contracts",
                None,
                f"give one of them, got {which}",
            )
        closed = (True, True)
        F = check_interval(force, 0.0, 1e6, "force", "N", closed=closed)
        if stroke is None:
            travel = check_interval(strain, 0.0, LARGEST_STRAIN, "strain", "-", closed=closed)
        else:
            travel = check_interval(stroke, 0.0, _LONGEST_STROKE, "stroke", "m", closed=closed)
        w = check_interval(
            1.0 if weight is None else weight, 0.0, 1e12, "weight", "-", closed=closed
        )
        size = next((np.size(x) for x in (F, travel, w) if np.ndim(x)), 1)
        F, travel, w = (
            np.full(size, float(x)) if np.ndim(x) == 0 else np.asarray(x, float)
            for x in (F, travel, w)
        )
        if not F.shape == travel.shape == w.shape or F.ndim != 1:
            called = "strain" if stroke is None else "stroke"
            raise InvalidInputError(
                "force",
                f", `{called}` and `weight` must be lists of one length",
                (F.size, travel.size, w.size),
                shown=f"{F.size}, {travel.size} and {w.size}",
            )
        if not 0 < F.size <= _MOST_POINTS:
            raise InvalidInputError("force", f"must hold 1 to {_MOST_POINTS} points", F.size)
        if not np.any((w > 0) & (F > 0) & (travel > 0)):
            raise InvalidInputError(
                "force",
                "and contraction must both be positive at a point that counts",
                None,
                "this task does no work",
            )
        supply = check_interval(
            supply_pressure, 0.0, HIGHEST_PRESSURE, "supply_pressure", "Pa", closed=(False, True)
        )
        check_plausible(supply, "supply_pressure")
        check_choice(fluid, FLUIDS, "fluid")
        eps, s = (travel, None) if stroke is None else (None, travel)
        return cls(F, eps, w, float(supply), scheme_of(scheme), name, source, s, fluid=fluid)

    @classmethod
    def in_time(
        cls, time: Any, force: Any, strain: Any, supply_pressure: float, **more: Any
    ) -> "Task":
        """A task that is given in time; each point counts for as long as it is nearest.

        **Arguments:**

        - `time`: rising times [s].
        - `force`: demanded then [N].
        - `strain`: contractions then [-], or `None` with a `stroke`.
        - `supply_pressure`: the supply's gauge pressure [Pa].
        - `more`: as of `of` [-].

        **Returns:** the task [-].

        **Raises:** `ValueError` for times that don't rise, and as `of`.
        """
        t = np.atleast_1d(check_interval(time, -1e12, 1e12, "time", "s")).astype(float)
        if t.ndim != 1 or t.size < 2 or np.any(np.diff(t) <= 0):
            raise InvalidInputError("time", "must be a list of two or more that rises", None)
        weight = np.gradient(t) * np.where((np.arange(t.size) % (t.size - 1)) == 0, 0.5, 1.0)
        made = cls.of(force, strain, supply_pressure, weight, **more)
        return replace(made, time=t)

    def strain_of(self, length: float) -> Points:
        """Contractions demanded of a bundle [-]; `length`: its own at rest [m].

        A stroke that is longer than the bundle is a strain above 1.
        """
        if self.strain is not None:
            return self.strain
        assert self.stroke is not None
        return self.stroke / length

    def stroke_of(self, length: float) -> Points:
        """How much shorter than at rest a bundle must get [m]; `length`: its own at rest [m]."""
        return self.strain_of(length) * length if self.stroke is None else self.stroke

    @property
    def reference(self) -> Points:
        """What a shortfall is told as a share of [N]: the demanded force; the task's largest, where
        none is.
        """
        return np.where(self.force > 0, self.force, self.force.max())

    @property
    def largest_strain(self) -> float:
        """The largest contraction demanded [-]; NaN where it hangs on the bundle's length."""
        return float("nan") if self.strain is None else float(self.strain.max())

    def __len__(self) -> int:
        return self.force.size

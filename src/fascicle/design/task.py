"""Tasks: load cases, how much each counts, the supply; and named examples.

A load case is a demanded force at a contraction: a strain, or a stroke, a length that long muscles
contract by with less strain. Weights count in means; of a task in time they are durations.

All figures of the examples are made up: shapes as such motions have, scaled to bundles of a
handful of half-inch muscles. None was measured, and none should be cited as if it were.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..bundle.schemes import AbstractScheme, Orderly, scheme_of
from ..core.errors import InvalidInputError
from ..core.types import Float, Numbers
from ..core.validation import (
    HIGHEST_PRESSURE,
    LARGEST_STRAIN,
    check_choice,
    check_interval,
    check_plausible,
)


_LONGEST_STROKE = 10.0  # m, of a building's crane
_LARGEST_FORCE = 1e6  # N, a hundred times what the largest muscles pull
_LARGEST_WEIGHT = 1e12  # far from where sums of weights lose digits
_MOST_POINTS = 100_000  # of a task; their tables fit into memory
_LARGEST_TIME = 1e12  # s, far from where differences of times lose digits
FLUIDS = ("air", "liquid")

Points = Float[np.ndarray, " point"]


@dataclass(frozen=True, eq=False)
class Task:
    """Load cases: demanded `force` [N], at `strain` [-] or after `stroke` [m], the other being
    `None`; `weight` [-], `supply_pressure` [Pa]; the `scheme` of recruitment; `name` and `source`
    of the figures; `time` [s] of each point, if it has one; the `fluid`.
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
        - `weight`: of each point in means [-]; default: all the same.
        - `scheme`: one of `fascicle.schemes`, by name or as an object.
        - `name`, `source`: of the task, and of its figures.
        - `stroke`: shortening of the bundle [m], instead of `strain`.
        - `fluid`: "air" or "liquid", whose consumption is computed.

        **Raises:** `ValueError` for values off the domain, lists of different lengths, and both of
        strain and stroke, or neither.
        """
        if (strain is None) == (stroke is None):
            rule = "in m or `strain` must give the contraction"
            remedy = f"give one of them, got {'neither' if strain is None else 'both'}"
            raise InvalidInputError("stroke", rule, None, remedy)
        travel, name_of_travel, largest, unit = strain, "strain", LARGEST_STRAIN, "-"
        if stroke is not None:
            travel, name_of_travel, largest, unit = stroke, "stroke", _LONGEST_STROKE, "m"
        closed, weight = (True, True), 1.0 if weight is None else weight
        arrays = (
            check_interval(force, 0.0, _LARGEST_FORCE, "force", "N", closed=closed),
            check_interval(travel, 0.0, largest, name_of_travel, unit, closed=closed),
            check_interval(weight, 0.0, _LARGEST_WEIGHT, "weight", "-", closed=closed),
        )
        size = next((np.size(x) for x in arrays if np.ndim(x)), 1)
        F, travel, w = (np.full(size, float(x)) if np.ndim(x) == 0 else x for x in arrays)
        if not F.shape == travel.shape == w.shape or F.ndim != 1:
            rule = f", `{name_of_travel}` and `weight` must be lists of one length"
            sizes = (F.size, travel.size, w.size)
            text = "{}, {} and {} values".format(*sizes)
            raise InvalidInputError("force", rule, sizes, shown=text)
        if not 0 < F.size <= _MOST_POINTS:
            raise InvalidInputError("force", f"must hold 1 to {_MOST_POINTS} points", F.size)
        if not np.any((w > 0) & (F > 0) & (travel > 0)):
            rule = "and contraction must both be positive at a point that counts"
            raise InvalidInputError("force", rule, None, "this task does no work")
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
        """A task in time; each point counts for as long as it is the nearest one.

        **Arguments:**

        - `time`: rising times [s].
        - `force`, `strain`, `supply_pressure`, `more`: as of `of` [SI].

        **Raises:** `ValueError` for times that don't rise, and as `of`.
        """
        t = np.atleast_1d(check_interval(time, -_LARGEST_TIME, _LARGEST_TIME, "time", "s"))
        t = t.astype(float)
        if t.ndim != 1 or t.size < 2 or np.any(np.diff(t) <= 0):
            raise InvalidInputError("time", "must be a list of two or more that rises", None)
        weight = np.gradient(t) * np.where((np.arange(t.size) % (t.size - 1)) == 0, 0.5, 1.0)
        return replace(cls.of(force, strain, supply_pressure, weight, **more), time=t)

    def strain_of(self, length: Numbers) -> Points:
        """Contractions of bundles of a `length` at rest [m], points first [-]; above 1 for a stroke
        that is longer than the bundle.
        """
        if self.strain is not None:
            return np.multiply.outer(self.strain, np.ones_like(length))
        assert self.stroke is not None
        return np.divide.outer(self.stroke, length)

    def stroke_of(self, length: Numbers) -> Points:
        """Shortening demanded of bundles [m], points first; `length`: at rest [m]."""
        if self.strain is not None:
            return np.multiply.outer(self.strain, length)
        return np.multiply.outer(self.strain_of(1.0), np.ones_like(length))

    @property
    def reference(self) -> Points:
        """Force that shares refer to [N]: the demanded one, or the task's largest if none is."""
        return np.where(self.force > 0, self.force, self.force.max())

    def __len__(self) -> int:
        return self.force.size


def _sit_to_stand_knee() -> dict[str, np.ndarray]:
    """A knee that rises from a seat: least force when the leg is straight."""
    time = np.linspace(0.0, 1.5, 16)  # s
    done = np.sin(0.5 * np.pi * time / time[-1]) ** 2  # share of the path
    return {"time": time, "force": 80.0 + 420.0 * (1 - done) ** 1.5, "strain": 0.02 + 0.16 * done}


def _pick_and_place_arm() -> dict[str, np.ndarray]:
    """An arm that lifts loads of three sizes to three heights, mostly small ones."""
    force = np.repeat([60.0, 150.0, 280.0], 3)
    strain = np.tile([0.06, 0.11, 0.16], 3) - np.repeat([0.0, 0.01, 0.03], 3)
    return {"force": force, "strain": strain, "weight": np.repeat([6.0, 3.0, 1.0], 3)}


def _walking_ankle() -> dict[str, np.ndarray]:
    """An ankle over one stride: the load builds up, pushes off, the foot swings."""
    time = np.linspace(0.0, 1.1, 23)  # s
    s = time / time[-1]
    force = 20.0 + 430.0 * np.exp(-(((s - 0.48) / 0.12) ** 2)) + 60.0 * np.exp(-((s / 0.2) ** 2))
    strain = 0.03 + 0.11 / (1 + np.exp(-(s - 0.55) / 0.035)) * np.exp(-(((s - 0.6) / 0.3) ** 2))
    return {"time": time, "force": force, "strain": strain}


TASKS = {
    "sit_to_stand_knee": _sit_to_stand_knee,
    "pick_and_place_arm": _pick_and_place_arm,
    "walking_ankle": _walking_ankle,
}


def example_task(name: str, supply_pressure: float = 413.7e3) -> Task:
    """Task of `TASKS` with a `name`, with made-up figures, at a supply pressure [Pa]; `ValueError`
    for another name, with the nearest.
    """
    figures: dict[str, Any] = TASKS[check_choice(name, TASKS, "example")]()
    make = Task.in_time if "time" in figures else Task.of
    source = "made up, no measurement"
    return make(**figures, supply_pressure=supply_pressure, name=name, source=source)

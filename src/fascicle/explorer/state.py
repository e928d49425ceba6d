"""State of a session: one immutable `View`, and callbacks for its changes.

Values are in SI; the units shown are part of the view. Tabs never call one another: each changes
the view, and hears of every change.
"""

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from dataclasses import field as of_dataclass
from types import MappingProxyType
from typing import Any

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..files import dumps
from ..muscle import Muscle
from ..muscle.fitted_length import copy_fit_info


TABS = ("muscle", "bundle", "reversal", "efficiency", "data")
SHOWN: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"pressure": ("kPa", "psi", "bar"), "length": ("mm", "in"), "force": ("N", "lbf")}
)
SUPPLY = 413.7e3  # Pa, where nothing says what the supply gives
MOST_UNITS, MOST_MUSCLES = 8, 60
SIZES = (0.1, 10)  # of a unit's radius in the shared muscle's
_START = {"pressure": 137.9e3, "strain": 0.1}


@dataclass(frozen=True)
class Unit:
    """A motor unit of `count` muscles.

    Their radius and wall are `size` times [-] those of the view's muscle; or `own` is another
    muscle instead of it.
    """

    count: int = 1
    size: float = 1.0
    own: Muscle | None = None


@dataclass(frozen=True)
class View:
    """All that a session shows.

    `name` of the muscle; `supply`, `pressure` and the motor units' `pressures` [Pa]; `strain` [-];
    `distance` between the plates [m], where muscles differ; `compared` laws, such as
    `buckling:elastica`; `shown` units by dimension.
    """

    name: str
    muscle: Muscle
    units: tuple[Unit, ...] = (Unit(),)
    supply: float = SUPPLY
    scheme: str = "orderly"
    distance: float | None = None
    pressure: float = _START["pressure"]
    strain: float = _START["strain"]
    pressures: tuple[float, ...] = (SUPPLY,)
    resistance: bool = True
    compared: tuple[str, ...] = ()
    path: str = "isobaric"
    splits: tuple[tuple[int, ...], ...] = ((1, 4), (2, 3), (4, 1))
    shown: Mapping[str, str] = of_dataclass(
        default_factory=lambda: {kind: units[0] for kind, units in SHOWN.items()}
    )
    tab: str = TABS[0]

    @property
    def bundle(self) -> Bundle:
        """Bundle of all motor units."""
        units = [MotorUnit(self.muscle_of(unit), unit.count) for unit in self.units]
        return Bundle(units, self.supply, self.scheme, self.distance)

    def muscle_of(self, unit: Unit) -> Muscle:
        """Muscle of a `unit`."""
        return scaled(self.muscle, unit.size) if unit.own is None else unit.own

    @property
    def text(self) -> str:
        """Text of a file with the muscle, or with the bundle where there are several units."""
        single = len(self.units) == 1 and self.units[0] == Unit()
        return dumps(self.muscle if single else self.bundle)


def scaled(muscle: Muscle, size: float) -> Muscle:
    """A muscle of `size` times the radius and wall thickness [-] and the same length."""
    if size == 1:
        return muscle
    radius, wall = muscle.outer_radius * size, muscle.wall_thickness * size
    return copy_fit_info(muscle, with_fields(muscle, outer_radius=radius, wall_thickness=wall))


def view_of(target: Muscle | Bundle, name: str, before: View | None = None) -> View:
    """View of a muscle or a bundle that is opened.

    **Arguments:**

    - `target`: the muscle or bundle.
    - `name`: of it, as the page shows it.
    - `before`: the view it replaces, whose units, tab and options stay.

    **Raises:** `ValueError` for a bundle that is too large to show.
    """
    muscle = target if isinstance(target, Muscle) else target.motor_units[0].muscle
    view = View(name, muscle)
    if before is not None:
        view = replace(view, shown=before.shown, tab=before.tab, resistance=before.resistance,
                       path=before.path, splits=before.splits)  # fmt: skip
    if isinstance(target, Muscle):
        return replace(view, units=(Unit(1), Unit(1)), pressures=(SUPPLY, SUPPLY))
    # checked before anything is computed of them
    check_units(tuple(Unit(int(unit.count)) for unit in target.motor_units))
    units = tuple(
        Unit(int(unit.count), own=None if unit.muscle == muscle else unit.muscle)
        for unit in target.motor_units
    )
    supply = SUPPLY if target.supply_pressure is None else float(target.supply_pressure)
    return replace(
        view,
        units=units,
        supply=supply,
        scheme=target.scheme.name,
        distance=None if target.plate_distance is None else float(target.plate_distance),
        pressure=min(view.pressure, supply),
        pressures=(supply,) * len(units),
    )


def check_units(units: tuple[Unit, ...]) -> None:
    """Raise `InvalidInputError` for `units` that are too many to show, or impossible."""
    if not 1 <= len(units) <= MOST_UNITS:
        raise InvalidInputError("units", f"must be 1 to {MOST_UNITS} motor units", len(units))
    muscles = sum(unit.count for unit in units)
    least = min(unit.count for unit in units)
    if least < 1 or muscles > MOST_MUSCLES:
        raise InvalidInputError(
            "count",
            f"must be 1 or more in each motor unit and {MOST_MUSCLES} in all",
            muscles,
            shown=f"{least}" if least < 1 else f"{muscles} in all",
        )
    for unit in units:
        if not (math.isfinite(unit.size) and SIZES[0] <= unit.size <= SIZES[1]):
            rule = f"must lie in [{SIZES[0]:g}, {SIZES[1]:g}] times the shared muscle's"
            raise InvalidInputError("radius", rule, unit.size, shown=f"{unit.size:g} times")


class Session:
    """View of one visitor, and the callbacks for its changes."""

    def __init__(self, view: View, batch: Callable[[], AbstractContextManager[Any]] = nullcontext):
        """**Arguments:**

        - `view`: the first one.
        - `batch`: context that callbacks run in, such as one that sends all changes at once.
        """
        self.view, self._batch = view, batch
        self.opened: set[str] = set()  # names of files that were read, which no output may bear
        self._callbacks: list[Callable[[View, View], None]] = []

    def watch(self, callback: Callable[[View, View], None]) -> None:
        """Call `callback` with the views before and after each change."""
        self._callbacks.append(callback)

    def change(self, **changes: Any) -> None:
        """Replace some fields of the view."""
        self.show(replace(self.view, **changes))

    def show(self, view: View) -> None:
        """Replace the view."""
        before, self.view = self.view, view
        with self._batch():
            for callback in self._callbacks:
                callback(before, view)


def changed(before: View, after: View, *names: str) -> bool:
    """Whether one of the fields `names` differs between two views."""
    # by identity: two muscles are compared by their arrays, and any change makes a new one
    return any(getattr(before, name) is not getattr(after, name) for name in names)

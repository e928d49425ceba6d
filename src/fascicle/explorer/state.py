"""State of a session: one immutable `View`, which tabs watch and replace, and its history.

Values are in SI; the units shown are part of the view.
"""

import math
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import param

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN, check_finite, check_interval
from ..files import dumps, example, named_muscles
from ..muscle import Muscle
from .scenario_setup import Setup


TABS = ("muscle", "bundle", "compare", "data", "time")
DISPLAY_UNITS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"pressure": ("kPa", "psi", "bar"), "length": ("mm", "in"), "force": ("N", "lbf")}
)
SUPPLY = 413.7e3  # Pa, the paper's 60 psi, where a file names no supply pressure
MOST_UNITS, MOST_MUSCLES = 8, 60  # more can't be told apart in the figures
CHANGED = ", changed"  # after the name of an opened muscle that was changed
_DISPLAY_FIELDS = ("tab", "display_units")  # that undo and reset leave as they are
_ONE_CHANGE = 1.0  # s within which changes of the same fields are one: a slider's steps
# of a muscle without a bundle: the paper's 1 + 4, whose free strain falls at this pressure [Pa]
_COUNTS, _SECOND_PRESSURE = (1, 4), 60e3


# by field: least and largest value [SI], unit, and whether the ends are allowed
_LIMITS = {
    "pressure": (0.0, HIGHEST_PRESSURE, "Pa", (True, True)),
    "supply": (0.0, HIGHEST_PRESSURE, "Pa", (False, True)),
    "strain": (0.0, LARGEST_STRAIN, "-", (True, True)),
}


@dataclass(frozen=True)
class Unit:
    """A motor unit: `count` muscles, the view's or `own` ones."""

    count: int = 1
    own: Muscle | None = None


@dataclass(frozen=True)
class Pin:
    """A curve to compare: a `muscle` at a `pressure` [Pa], by a unique `name`."""

    name: str
    muscle: Muscle
    pressure: float


@dataclass(frozen=True)
class View:
    """Content of the page.

    `name` of the muscle; `supply`, `pressure` and the motor units' `pressures` [Pa]; `strain` [-];
    `load` on the bundle [N], if any; `distance` between the plates [m], where muscles differ;
    `pins` to compare, the first is the reference; `path` of the efficiency; `display_units` by
    dimension; the `setup` of a simulation.
    """

    name: str
    muscle: Muscle
    units: tuple[Unit, ...] = (Unit(),)
    supply: float = SUPPLY
    scheme: str = "orderly"
    distance: float | None = None
    pressure: float = 137.9e3  # 20 psi, as in the paper's Fig. 6
    strain: float = 0.1
    pressures: tuple[float, ...] = (SUPPLY,)
    load: float | None = None
    resistance: bool = True
    pins: tuple[Pin, ...] = ()
    path: str = "isobaric"
    display_units: Mapping[str, str] = field(
        default_factory=lambda: {kind: units[0] for kind, units in DISPLAY_UNITS.items()}
    )
    tab: str = TABS[0]
    setup: Setup = Setup()

    @property
    def bundle(self) -> Bundle:
        units = [MotorUnit(unit.own or self.muscle, unit.count) for unit in self.units]
        return Bundle(units, self.supply, self.scheme, self.distance)

    @property
    def text(self) -> str:
        """Text of a file with the muscle, or with the bundle if it is more than one such muscle."""
        return dumps(self.muscle if self.units == (Unit(),) else self.bundle)


# fields of the view that undo and reset restore
CONTENT_FIELDS = tuple(entry.name for entry in fields(View) if entry.name not in _DISPLAY_FIELDS)


def view_of(target: Muscle | Bundle, name: str, before: View | None = None) -> View:
    """View of an opened muscle or bundle; tab, options, pins and units are those of `before`."""
    muscle = target if isinstance(target, Muscle) else target.motor_units[0].muscle
    view = View(name, muscle)
    if before is not None:
        names = ("display_units", "tab", "resistance", "path", "pins", "setup")
        view = replace(view, **{name: getattr(before, name) for name in names})
    if isinstance(target, Muscle):
        units = tuple(map(Unit, _COUNTS))
        return replace(view, units=units, pressures=(SUPPLY, _SECOND_PRESSURE))
    counts = [int(unit.count) for unit in target.motor_units]
    check_units(tuple(map(Unit, counts)))  # first: comparing thousands of muscles takes long
    muscles = [unit.muscle for unit in target.motor_units]
    units = tuple(
        Unit(count, own=None if own == muscle else own)
        for count, own in zip(counts, muscles, strict=True)
    )
    supply = SUPPLY if target.supply_pressure is None else float(target.supply_pressure)
    view = replace(view, units=units, supply=supply, pressures=(supply,) * len(units))
    distance = None if target.plate_distance is None else float(target.plate_distance)
    pressure = min(view.pressure, supply)
    return replace(view, scheme=target.scheme.name, distance=distance, pressure=pressure)


def shipped_muscle(name: str) -> Muscle:
    """Muscle of an example or of a measured muscle; of a bundle, its first unit's."""
    return view_of(example(name), name).muscle


def is_shipped(name: str, muscle: Muscle) -> bool:
    """True for the shipped `muscle` of a `name`, unchanged."""
    return name in named_muscles() and muscle == shipped_muscle(name)


def check_value(name: str, value: float) -> float:
    """A `value` [SI] of the view's field with a `name`; `InvalidInputError` out of its limits."""
    if name == "load":
        return float(check_finite(value, name, "N"))
    low, high, unit, closed = _LIMITS[name]
    why = "(gauge)" if unit == "Pa" else ""
    return float(check_interval(value, low, high, name, unit, why, closed))


def check_units(units: tuple[Unit, ...]) -> None:
    """Raise `InvalidInputError` for `units` that are too many to show, or impossible."""
    if not 1 <= len(units) <= MOST_UNITS:
        raise InvalidInputError("units", f"must be 1 to {MOST_UNITS} motor units", len(units))
    total, fewest = sum(unit.count for unit in units), min(unit.count for unit in units)
    if fewest < 1 or total > MOST_MUSCLES:
        rule = f"must be 1 or more in each motor unit and {MOST_MUSCLES} in all"
        text = f"{fewest}" if fewest < 1 else f"{total} in all"
        raise InvalidInputError("count", rule, total, shown=text)


class Session(param.Parameterized):
    """View of one visitor, and the views before; `opened`: the view that was opened last, by a
    link, an example or a file. Callbacks run in a `batch`, which sends all changes at once.
    """

    if TYPE_CHECKING:
        view: View
    else:
        view = param.ClassSelector(class_=View, allow_None=False)

    def __init__(
        self,
        view: View,
        opened: View | None = None,
        batch: Callable[[], AbstractContextManager[None]] = nullcontext,
    ):
        super().__init__(view=view)
        self.opened = opened or view
        self._batch = batch
        self._past: list[View] = []
        self._future: list[View] = []  # views that were undone
        self._last: tuple[set[str], float] = (set(), -math.inf)  # fields changed, and when [s]

    def watch(self, callback: Callable[[View, View], object]) -> None:
        """Call `callback` with the views before and after each change."""
        self.param.watch(lambda event: callback(event.old, event.new), "view")

    def change(self, **changes: object) -> None:
        """Replace fields of the view, if it has other values: widgets that show it call this."""
        if any(getattr(self.view, name) != value for name, value in changes.items()):
            self.show(replace(self.view, **changes))

    def show(self, view: View) -> None:
        """Replace the view; remember the present one unless this is a step of the last change."""
        names = {name for name in CONTENT_FIELDS if changed(self.view, view, name)}
        (last_names, last), time_now = self._last, time.monotonic()
        if names:
            if names != last_names or time_now - last > _ONE_CHANGE:
                self._past.append(self.view)
            self._future, self._last = [], (names, time_now)
        self._set(view)

    def open(self, view: View) -> None:
        """Show a view that was opened, to which `reset` returns."""
        self.opened, self._last = view, (set(), -math.inf)
        self.show(view)

    @property
    def changes(self) -> tuple[int, int]:
        """Numbers of changes to undo and to redo."""
        return len(self._past), len(self._future)

    def forget_changes(self, number: int) -> None:
        """Keep so many of the changes to undo, those that were made first."""
        del self._past[number:]

    def undo(self) -> None:
        """Show the view before the last change; the tab and the units shown stay."""
        self._step(self._past, self._future)

    def redo(self) -> None:
        self._step(self._future, self._past)

    def reset(self) -> None:
        """Show the view as it was opened, but keep the tab and the display units."""
        self._last = set(), -math.inf  # not a step of the last change
        self.show(self._with_display(self.opened))

    def _step(self, source: list[View], target: list[View]) -> None:
        if source:
            target.append(self.view)
            self._last = set(), -math.inf
            self._set(self._with_display(source.pop()))

    def _with_display(self, view: View) -> View:
        return replace(view, **{name: getattr(self.view, name) for name in _DISPLAY_FIELDS})

    def _set(self, view: View) -> None:
        with self._batch():
            self.view = view


def changed(before: View, after: View, *names: str) -> bool:
    """True if one of the fields `names` is another object in the two views, even an equal one."""
    # by identity: two muscles are compared by their arrays, and any change makes a new one
    return any(getattr(before, name) is not getattr(after, name) for name in names)

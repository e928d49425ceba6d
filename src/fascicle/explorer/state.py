"""What a session shows: one immutable `View`, and who is told when it changes.

Everything is in SI; the units that are shown are part of the view. Tabs never talk to one
another: each changes the view and is told of changes, whoever made them.
"""

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from dataclasses import field as of_dataclass
from types import MappingProxyType
from typing import Any

import equinox as eqx

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
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
    """A motor unit: `count` muscles [-], their radius and wall `size` times the shared
    muscle's [-], or `own`, another muscle instead of it.
    """

    count: int = 1
    size: float = 1.0
    own: Muscle | None = None


@dataclass(frozen=True)
class View:
    """What is shown. `name` of the muscle; `supply`, `pressure` and the motor units'
    `pressures` [Pa]; `strain` [-]; `distance` between the plates [m], where muscles are unlike;
    `compared` laws, as `tension`-like keys and names; `shown` units by dimension.
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
        """The bundle of all motor units [-]."""
        units = [MotorUnit(self.muscle_of(unit), unit.count) for unit in self.units]
        return Bundle(units, self.supply, self.scheme, self.distance)

    def muscle_of(self, unit: Unit) -> Muscle:
        """The muscle [-] of one `unit` [-]."""
        return scaled(self.muscle, unit.size) if unit.own is None else unit.own

    @property
    def text(self) -> str:
        """The muscle, or the bundle where there are several units, as a file [-]."""
        alone = len(self.units) == 1 and self.units[0] == Unit()
        return dumps(self.muscle if alone else self.bundle)


def scaled(muscle: Muscle, size: float) -> Muscle:
    """A muscle `size` times as thick [-], as long, its wall in proportion."""
    if size == 1:
        return muscle
    sizes = (muscle.outer_radius * size, muscle.wall_thickness * size)
    grown = eqx.tree_at(lambda m: (m.outer_radius, m.wall_thickness), muscle, sizes)
    return copy_fit_info(muscle, grown)


def view_of(found: Muscle | Bundle, name: str, before: View | None = None) -> View:
    """What is shown of a muscle or a bundle that was just opened.

    **Arguments:**

    - `found`: it [-].
    - `name`: what it is called [-].
    - `before`: the view it replaces, whose units and tab are kept [-].

    **Returns:** the view [-].

    **Raises:** `ValueError` for a bundle that is too large to show.
    """
    base = View(name, found if isinstance(found, Muscle) else found.motor_units[0].muscle)
    if before is not None:
        base = replace(base, shown=before.shown, tab=before.tab, resistance=before.resistance,
                       path=before.path, splits=before.splits)  # fmt: skip
    if isinstance(found, Muscle):
        return replace(base, units=(Unit(1), Unit(1)), pressures=(SUPPLY, SUPPLY))
    # before anything is made of them
    check_units(tuple(Unit(int(unit.count)) for unit in found.motor_units))
    units = tuple(
        Unit(int(unit.count), own=None if unit.muscle == base.muscle else unit.muscle)
        for unit in found.motor_units
    )
    supply = SUPPLY if found.supply_pressure is None else float(found.supply_pressure)
    return replace(
        base,
        units=units,
        supply=supply,
        scheme=found.scheme.name,
        distance=None if found.plate_distance is None else float(found.plate_distance),
        pressure=min(base.pressure, supply),
        pressures=(supply,) * len(units),
    )


def check_units(units: tuple[Unit, ...]) -> None:
    """Refuse `units` [-] that are too many to show, or that can't be."""
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
    """The view of one visitor, and who is told when it changes."""

    def __init__(
        self, view: View, together: Callable[[], AbstractContextManager[Any]] = nullcontext
    ):
        """**Arguments:**

        - `view`: the first [-].
        - `together`: what follows from a change happens inside it [-]; left out, nothing.
        """
        self.view, self.together = view, together
        self._watchers: list[Callable[[View, View], None]] = []

    def watch(self, told: Callable[[View, View], None]) -> None:
        """Call `told` [-] with the view before and after each change."""
        self._watchers.append(told)

    def change(self, **changes: Any) -> None:
        """Replace some of the view's fields by `changes` [-]."""
        self.become(replace(self.view, **changes))

    def become(self, view: View) -> None:
        """Show another `view` [-]; all are told."""
        before, self.view = self.view, view
        with self.together():
            for told in self._watchers:
                told(before, view)


def changed(before: View, after: View, *names: str) -> bool:
    """Whether one of the fields `names` [-] is another one in `after` than `before` [-]."""
    # by identity: two muscles are compared by their arrays, and any change makes a new one
    return any(getattr(before, name) is not getattr(after, name) for name in names)

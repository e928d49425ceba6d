"""From a scenario file to a plant, what it is commanded, and where it begins: checked once."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydantic import BaseModel, ValidationError

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..core.validation import check_choice
from ..dynamics import (
    AntagonisticJoint,
    MaxwellSlip,
    Plant,
    Schedule,
    State,
    Stop,
    Trajectory,
    equilibrium_state,
    simulate,
)
from ..fluid import (
    AIR,
    NITROGEN,
    OIL,
    WATER,
    Gas,
    Line,
    LiquidChamber,
    OrderlyValve,
    Orifice,
    SonicValve,
    checked_commands,
)
from ..muscle import Muscle
from .faults import from_validation, nearest
from .kinds import check_kind
from .measured import with_measured
from .places import Place
from .reading import described, load, loads, parsed, text_of
from .scenario_schema import PARTS, chosen
from .shipped import names as shipped
from .shipped import text as shipped_text
from .supplies import supply_of


if TYPE_CHECKING:
    from .controlled import Controlled

_EXAMPLES = "examples"
MEDIA = {"air": AIR, "nitrogen": NITROGEN, "oil": OIL, "water": WATER}
_MOST_STEPS = 2_000_000
# numbers of a run's results, a gigabyte: what two motor units make in as many steps
_MOST_NUMBERS, _OF_A_STEP, _OF_A_UNIT = 128_000_000, 40, 12
_DT = 1e-3  # s
_GRID = 1e-6  # of a step, by which a time may miss one: rounding


@dataclass(frozen=True, eq=False)
class Scenario:
    """A plant that is to be driven: its `name`, the `plant`, the `schedule` of its commands or what
    it is `controlled` by, the state that it begins with, `start`, its step `dt` [s] and `duration`
    [s], where its figures come from (`source`), and `notes` on what isn't done as it is written.
    """

    name: str
    plant: Plant
    schedule: Schedule | None
    start: State
    dt: float
    duration: float
    source: str = ""
    notes: tuple[str, ...] = ()
    controlled: "Controlled | None" = None

    def taking(self, policy: str | None = None, compensate: bool | None = None) -> "Scenario":
        """The same, controlled by another `policy` [-], by name, or where friction is, or isn't,
        fed forward: `compensate` [-]; `ValueError` for another name, and where nothing is
        controlled.
        """
        made = self.controlled
        if made is None:
            rule = "needs a scenario with [control]: this one is commanded by a schedule"
            name = "compensate" if policy is None else "policy"
            raise InvalidInputError(name, rule, policy, shown="")
        made = made.taking(policy, compensate)
        return replace(self, controlled=made, notes=made.notes)

    def run(self) -> Trajectory:
        """Drive it, from its start for its duration: the run [SI]."""
        if self.controlled is not None:
            made = self.controlled
            return simulate(
                self.plant, made.controller, made.reference, dt=self.dt, start=self.start
            )
        assert self.schedule is not None
        return simulate(
            self.plant, self.schedule, dt=self.dt, duration=self.duration, start=self.start
        )


def load_scenario(path: str | os.PathLike[str]) -> Scenario:
    """Read a scenario file.

    **Arguments:** `path`: the TOML file [-]; bundles that it names by a path stand beside it.

    **Returns:** the scenario [-].

    **Raises:** `OSError` where it can't be read; `ValueError`, in one line with the path and
    the key, where what it says can't be.
    """
    path = Path(path)
    return scenario_of(parsed(text_of(path), str(path)), str(path), path.parent, path.stem)


def loads_scenario(text: str, source: str = "<text>", folder: Path = Path()) -> Scenario:
    """Read what a scenario file holds.

    **Arguments:**

    - `text`: the TOML [-].
    - `source`: what to call it in an error [-].
    - `folder`: where files of bundles stand that it names [-].

    **Returns:** as `load_scenario` [-].

    **Raises:** as `load_scenario`.
    """
    return scenario_of(parsed(text, source), source, folder, source)


def scenario_of(data: dict[str, Any], source: str, folder: Path, name: str) -> Scenario:
    """The scenario in a file's tables.

    **Arguments:**

    - `data`: the tables [-].
    - `source`: what to call the file in an error [-].
    - `folder`: where files of bundles stand that it names [-].
    - `name`: of the scenario, where the file has none [-].

    **Returns:** as `load_scenario` [-].

    **Raises:** as `load_scenario`.
    """
    check_kind(data, "scenario", source)
    place = Place(source, data, (), "scenario")
    data = with_measured(data, place, folder)
    schema, classes = chosen(data, place)
    try:
        file: Any = schema.model_validate(data)
    except ValidationError as error:
        raise ValueError(from_validation(error, source, data, schema)) from None
    bundles = _bundles(data, source, place, folder)
    given = {key: _given(getattr(file, key)) for key in classes}
    units = sum(len(bundle.motor_units) for bundle in bundles)
    sides = 2 if classes["load"] is AntagonisticJoint else 1
    if len(bundles) != sides:
        rule = "must be a list of two for a joint" if sides == 2 else "must be one for this load"
        raise place.refuse(("bundle",), f"{rule}, got {len(bundles)}.")
    for key, part in PARTS.items():
        if key in given and part.many:
            springs = classes[key] is MaxwellSlip
            many = np.size(given[key].get("stiffness", 0)) if springs else units
            what = "springs" if springs else "motor units"
            _one_for_each(given[key], many, what, place.inner(key, kind="part"))
    room = _Room.of(given["fluid"], classes["fluid"], place.inner("fluid", kind="part"))
    parts = _parts(given, classes, room, units, place)
    run = file.run
    options = {key: x for key in ("law", "volume") if (x := getattr(run, key)) is not None}
    with place.naming():
        plant = Plant(bundles[0] if len(bundles) == 1 else bundles, **parts, **options)
    if not np.subtract(*plant.way) < 0:
        rule = "leaves no way on which all muscles' strains are known: check its sizes."
        raise place.refuse(("load",), rule)
    dt, duration = _times(run, units, place.inner("run", kind="part"))
    schedule, notes, made = None, (), None
    if isinstance(data.get("control"), dict):
        from .controlled import checked_start, controlled  # a scenario without needs none of it

        checked_start(run.pressures, plant, place.inner("run", kind="part"))
        made = controlled(file, plant, dt, duration, place)
        notes = made.notes
    else:
        schedule, notes = _schedule(file.schedule, plant, dt, duration, place)
    if plant.load.moved and run.position is not None:
        raise place.refuse(("run", "position"), "the load's motion is given: drop this key.")
    # where a motion is given, it is that which leads too far
    begins = Place(source, data, (), "moved") if plant.load.moved else place
    with begins.naming():
        start = equilibrium_state(
            plant, 0.0 if run.pressures is None else run.pressures, run.position
        )
    about = file.source or ""
    return Scenario(file.name or name, plant, schedule, start, dt, duration, about, notes, made)


class _Room(NamedTuple):
    """The `medium` and the room around: `pressure`, absolute [Pa], and `temperature` [K], where
    they are given.
    """

    medium: Any
    given: dict[str, Any]

    @classmethod
    def of(cls, fluid: dict[str, Any], chamber: type, place: Place) -> "_Room":
        liquid = chamber is LiquidChamber
        name = fluid.pop("medium", None) or ("oil" if liquid else "air")
        with place.naming():
            medium = MEDIA[check_choice(name, MEDIA, "medium")]
        if liquid == isinstance(medium, Gas):
            kinds = "adiabatic_wall, isothermal or polytropic" if liquid else "liquid"
            what = "gas" if liquid else "liquid"
            raise place.refuse(("medium",), f"{name} is a {what}: take chamber = {kinds}.")
        if liquid and not np.all(np.asarray(fluid.get("compliance", 0.0)) > 0):
            rule = "must be there and positive for a liquid, which hardly gives way itself: write"
            such = 'compliance = "2e-11 m^3/Pa", of bladder, hose and fittings of each motor unit.'
            raise place.refuse(("compliance",), f"{rule} {such}")
        keys = ("room_pressure", "room_temperature")
        return cls(medium, {key: fluid[key] for key in keys if key in fluid})


def _given(section: BaseModel) -> dict[str, Any]:
    """What a table says, by key."""
    values = {name: getattr(section, name) for name in type(section).model_fields}
    return {
        name: _given(x) if isinstance(x, BaseModel) else x
        for name, x in values.items()
        if x is not None and name not in ("kind", "chamber")
    }


def _one_for_each(given: Mapping[str, Any], many: int, what: str, place: Place) -> None:
    for key, value in given.items():
        if isinstance(value, np.ndarray) and len(value) != many:
            rule = f"must be one value, or a list of one for each of the {what}, {many}"
            raise place.refuse((key,), f"{rule}, got {len(value)}.")


def _bundles(data: dict[str, Any], source: str, place: Place, folder: Path) -> list[Bundle]:
    named = data.get("bundle")
    if "muscle" in data:
        if not isinstance(named, dict | None):
            raise place.refuse(("bundle",), "there is a [muscle], too: keep one of them.")
        inline = {key: data[key] for key in ("format", "muscle", "bundle") if key in data}
        return [_as_bundle(described(inline, source))]
    names: list[Any] = named if isinstance(named, list) else [named]
    if not names or not all(isinstance(name, str) for name in names):
        rule = 'must name a bundle or its file, such as "kim2021_bundle_1_4", or a list of two'
        raise place.refuse(("bundle",), f"{rule}; or write [muscle] and [bundle] as in its file.")
    known, found = shipped(_EXAMPLES), []
    for name in names:
        path = folder / name
        if name not in known and not path.exists():
            rule = f"{name!r} is neither a file nor a named example{nearest(name, known)}"
            raise place.refuse(("bundle",), rule)
        with place.inner("bundle", kind="part").naming():
            made = loads(shipped_text(_EXAMPLES, name), name) if name in known else load(path)
        found.append(_as_bundle(made))
    return found


def _as_bundle(found: Muscle | Bundle) -> Bundle:
    return found if isinstance(found, Bundle) else Bundle([MotorUnit(found)])


def _parts(
    given: dict[str, dict[str, Any]], classes: Mapping[str, type], room: _Room, units: int,
    place: Place,
) -> dict[str, Any]:  # fmt: skip
    gas = isinstance(room.medium, Gas)
    fluid = given["fluid"]
    fluid["gas" if gas else "liquid"] = room.medium
    made: dict[str, Any] = {}
    for key, table in given.items():
        kind, at = classes[key], place.inner(key, kind="part")
        for inner, one in (("stop", Stop), ("line", Line)):
            if inner in table:
                with at.inner(inner, kind="part").naming():
                    table[inner] = one(**table[inner])
        if kind is OrderlyValve:
            table["units"] = units
        if kind is Orifice and not gas:
            table.setdefault("density", float(room.medium.reference_density))
        if kind is SonicValve and gas and room.medium is not AIR:
            # as the same hole lets another gas through
            ratio = AIR.specific_gas_constant / room.medium.specific_gas_constant
            table.setdefault(
                "reference_density", float(SonicValve(1e-9, 0.3).reference_density * np.sqrt(ratio))
            )
        if key == "supply":
            made[key] = supply_of(table, kind, room.medium, room.given, at)
            continue
        with at.naming():
            made["chamber" if key == "fluid" else key] = kind(**table)
    return made


def _times(run: Any, units: int, place: Place) -> tuple[float, float]:
    dt, duration = _DT if run.dt is None else run.dt, run.duration
    for key, value, such in (("dt", dt, _DT), ("duration", duration, 10.0)):
        if value <= 0:
            raise place.refuse((key,), f"must be positive, such as {such:g} s.")
    steps = round(duration / dt)
    if abs(steps - duration / dt) > _GRID * max(1, steps):
        shown = f"{max(steps, 1) * dt:.12g} s"
        raise place.refuse(("duration",), f"must be whole steps of {dt:g} s: take {shown}.")
    most = min(_MOST_STEPS, _MOST_NUMBERS // (_OF_A_STEP + _OF_A_UNIT * units))
    if steps > most:
        of = f" of {units} motor units" if most < _MOST_STEPS else ""
        rule = f"makes {steps} steps of {dt:g} s{of}, more than {most}: take a longer `dt`."
        raise place.refuse(("duration",), rule)
    return dt, duration


def _schedule(
    rows: list[Any], plant: Plant, dt: float, duration: float, place: Place
) -> tuple[Schedule, tuple[str, ...]]:
    if not rows:
        raise place.refuse(("schedule",), "is empty: write [[schedule]] with time and command.")
    last, commands, notes = None, [], []
    for k, row in enumerate(rows):
        at = place.inner("schedule", k, kind="schedule")
        if last is None and row.time != 0:
            raise at.refuse(("time",), "the first must be 0 s.")
        if last is not None and row.time <= last:
            raise at.refuse(("time",), f"times must rise, it comes after {last:g} s.")
        last = row.time
        many = plant.commands
        if np.size(row.command) not in (1, many) or (
            np.ndim(row.command) and np.size(row.command) != many
        ):
            rule = f"must be one number, or a list of one for each command, {many}"
            raise at.refuse(("command",), f"{rule}, got {np.size(row.command)}.")
        with at.naming():
            commands.append(np.broadcast_to(checked_commands(row.command), (many,)))
        if row.time >= duration:
            notes.append(
                f"the command at {row.time:g} s never comes: the run ends at {duration:g} s."
            )
        elif abs(row.time / dt - round(row.time / dt)) > 1e-6:
            then = dt * np.ceil(row.time / dt)
            notes.append(f"the command at {row.time:g} s comes with the next step, at {then:g} s.")
    times = np.array([row.time for row in rows])
    return Schedule(times, np.array(commands)), tuple(notes)

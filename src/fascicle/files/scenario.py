"""Scenario files: from TOML to a plant, its commands or controller, and its initial state."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import dynamics, fluid
from ..bundle import Bundle
from ..bundle.bundle import as_bundle
from ..core.errors import InvalidInputError
from ..core.findings import Finding
from ..core.validation import check_choice, distinct_texts
from ..dynamics import Plant, Schedule, State, Trajectory
from ..fluid.flow_elements import REFERENCE_DENSITY
from ..table_model import validate
from .muscle_files import from_dict, load_named, parse_file, provenance, read_file
from .scenario_schema import DATA_SHEET, INNER, PARTS, choose_schema
from .schema import FileLocation, check_kind


if TYPE_CHECKING:  # a scenario without control loads none of it
    from ..control import Cascade

_MEDIA = {"air": fluid.AIR, "nitrogen": fluid.NITROGEN, "oil": fluid.OIL, "water": fluid.WATER}
_MAX_STEPS = 2_000_000  # of a run: some minutes
_MAX_NUMBERS = 128_000_000  # of a run's results: a gigabyte, two motor units in that many steps
_NUMBERS_PER_STEP, _NUMBERS_PER_UNIT = 40, 12  # of these: of the plant, and of each motor unit
_STEP = 1e-3  # s: resolves valves and muscles
_ROUNDING = 1e-6  # of a step, by which rounding may shift a time
_SPRINGS = ("kind", "stiffness", "slip_force", "slip_force_slope")
_ACCUMULATORS = (fluid.Accumulator, fluid.PumpedAccumulator)
# figures of a data sheet, to the conductance C
_CONVERSIONS = {
    "nominal_flow": fluid.conductance_from_nominal_flow,
    "Kv": fluid.conductance_from_kv,
    "Cv": fluid.conductance_from_cv,
}


class ScenarioControl(NamedTuple):
    """A `controller` with its demand at each step, the `reference` [SI]; its `policy` and other
    `options`; `no_crossing`: why `hand_over` acts as `threshold`, if it does.
    """

    controller: "Cascade"
    reference: np.ndarray
    policy: str
    options: Mapping[str, Any]
    no_crossing: Finding | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """The controller's warnings, as sentences."""
        return tuple(f"{warning}." for warning in self.controller.warnings)


def _controlled(
    plant: Plant, output: str, reference: np.ndarray, policy: str, options: Mapping[str, Any]
) -> ScenarioControl:
    """Control of an `output` by a controller with a `plant` as its model."""
    from ..control import cascade, crossings_on_reference

    obstacle = None
    if policy == "hand_over":
        dt, delay = options["dt"], options.get("delay", 0.0)
        crossings = crossings_on_reference(plant, reference, dt, output, delay)
        obstacle = next((each.obstacle for each in crossings if not each.is_resolved), None)
    controller = cascade(plant, "threshold" if obstacle else policy, output, **options)
    return ScenarioControl(controller, reference, policy, options, obstacle)


@dataclass(frozen=True, eq=False)
class Scenario:
    """A `plant` with its commands in time, the `schedule`, or its `control`; the other is `None`.

    - `start`: initial state [SI].
    - `dt`, `duration`: step and length of the run [s].
    - `source`: of the file's numbers.
    - `notes`: on settings that the run can't follow exactly.
    """

    name: str
    plant: Plant
    schedule: Schedule | None
    start: State
    dt: float
    duration: float
    source: str = ""
    notes: tuple[str, ...] = ()
    control: ScenarioControl | None = None

    def with_policy(self, policy: str | None = None, compensate: bool | None = None) -> "Scenario":
        """Copy with another `policy`, one of `control.POLICIES`, or with the feedforward of
        friction if `compensate` is true; default: as it is.

        Raises `InvalidInputError` for another name, and for a scenario without [control].
        """
        if self.control is None:
            rule = "needs a scenario with [control]: this one is commanded by a schedule"
            name = "compensate" if policy is None else "policy"
            raise InvalidInputError(name, rule, policy, shown="")
        if policy is None and compensate is None:
            return self
        controller, reference, own_policy, options, _ = self.control
        if compensate is not None:
            options = {**options, "compensate": compensate}
        policy = policy or own_policy
        control = _controlled(controller.plant, controller.of, reference, policy, options)
        return replace(self, control=control, notes=control.notes)

    def run(self) -> Trajectory:
        """Simulate the scenario."""
        options: dict[str, Any] = {"dt": self.dt, "start": self.start}
        if self.control is not None:
            command, options["reference"] = self.control.controller, self.control.reference
        else:
            command, options["duration"] = self.schedule, self.duration
        return dynamics.simulate(self.plant, command, **options)


def load_scenario(path: str | os.PathLike[str]) -> Scenario:
    """Read a scenario file, with paths relative to its folder; raises as `load`."""
    path = Path(path)
    return scenario_from_dict(read_file(path), str(path), path.parent, path.stem)


def loads_scenario(
    text: str, source: str = "<text>", folder: Path | None = None, name: str = ""
) -> Scenario:
    """Read a scenario from the `text` of a file; raises as `load`.

    `source`: its name in errors; `folder`: of the files that it names, by default it may name
    none; `name`: of a scenario that has none in the file, default: `source`.
    """
    return scenario_from_dict(parse_file(text, source), source, folder, name or source)


def scenario_from_dict(
    data: dict[str, Any], source: str, folder: Path | None, name: str
) -> Scenario:
    """The scenario in a file's tables; arguments as for `loads_scenario`."""
    check_kind(data, "scenario", source)
    root = FileLocation(source, data, kind="scenario")
    data = _with_measured_friction(data, root, folder)
    schema, classes = choose_schema(data, root)
    file: Any = validate(schema, data, source)
    bundles = _bundles(data, source, root, folder)
    tables = {
        key: getattr(file, key).model_dump(exclude_none=True, exclude={"kind", "chamber"})
        for key in classes
    }
    units = sum(len(bundle.motor_units) for bundle in bundles)
    sides = 2 if classes["load"] is dynamics.AntagonisticJoint else 1
    if len(bundles) != sides:
        rule = "must be a list of two for a joint" if sides == 2 else "must be one for this load"
        raise root.error(("bundle",), f"{rule}, got {len(bundles)}.")
    _check_list_lengths(tables, classes, units, root)
    parts = _parts(tables, classes, root)
    run = file.run
    options = run.model_dump(exclude_none=True, include={"law", "volume"})

    def make_plant(bundles: list[Bundle]) -> Plant:
        return root.call(Plant, bundles[0] if len(bundles) == 1 else bundles, **parts, **options)

    plant = make_plant(bundles)
    if not np.subtract(*plant.stroke) < 0:
        rule = "leaves no stroke with valid strains of all muscles: check its sizes."
        raise root.error(("load",), rule)
    dt, duration = _times(run, units, root.child("run", kind="part"))
    schedule = control = None
    if isinstance(data.get("control"), dict):
        highest = 0.0 if run.pressures is None else float(np.max(run.pressures))
        if highest > plant.supply_pressure:
            texts = distinct_texts(highest, plant.supply_pressure)
            rule = f"must be at most the supply's {texts[1]} Pa, got {texts[0]} Pa."
            raise root.error(("run", "pressures"), rule)
        model, model_plant = file.control.model, plant
        if model is not None:
            model_plant = make_plant(_model_bundles(model, bundles, root, folder))
        control = _control(file, model_plant, dt, duration, root)
        notes = control.notes
    else:
        schedule, notes = _schedule(file.schedule, plant, dt, duration, root)
    if plant.load.prescribed and run.position is not None:
        raise root.error(("run", "position"), "the load's motion is given: drop this key.")
    # a prescribed motion itself may leave the stroke
    start_location = FileLocation(source, data, kind="motion") if plant.load.prescribed else root
    with start_location.error_context():
        pressures = _first_pressures(plant, control) if run.pressures is None else run.pressures
        start = dynamics.equilibrium_state(plant, pressures, run.position)
    name, source = file.name or name, file.source or ""
    return Scenario(name, plant, schedule, start, dt, duration, source, notes, control)


def _first_pressures(plant: Plant, control: ScenarioControl | None) -> Any:
    """Pressures [Pa] at the start: those that meet a controller's first demand at rest; zero of a
    schedule, of a joint and of a force on a free load.
    """
    if control is None or len(plant.bundles) > 1:
        return 0.0
    first = float(control.reference[0])
    if control.controller.of == "position":
        return dynamics.holding_pressures(plant, position=first)
    return dynamics.holding_pressures(plant, force=first) if plant.load.prescribed else 0.0


def _with_measured_friction(
    data: dict[str, Any], root: FileLocation, folder: Path | None
) -> dict[str, Any]:
    """A scenario's tables, with a calibration's springs in place of `kind = "measured"`; without
    `[hysteresis]` if the calibration found none.
    """
    table = data.get("hysteresis")
    if not isinstance(table, dict) or table.get("kind") != "measured":
        return data
    for key in table:
        if key not in ("kind", "muscle"):
            raise root.error(("hysteresis", key), "measured: the file of the muscle has it.")
    name = table.get("muscle", data.get("bundle"))
    if not isinstance(name, str) or folder is None or not (folder / name).is_file():
        rule = 'must name the calibrated muscle\'s file: write muscle = "muscle.toml".'
        raise root.error(("hysteresis", "muscle"), rule)
    springs = root.child("hysteresis").call(provenance, folder / name).get("hysteresis")
    springs = springs if isinstance(springs, dict) else {}
    if springs.get("kind") == "none":
        return {key: value for key, value in data.items() if key != "hysteresis"}
    if any(key not in springs for key in _SPRINGS):
        rule = f"{name} has no friction: `fascicle calibrate` finds it in records of both ways."
        raise root.error(("hysteresis", "kind"), rule)
    return data | {"hysteresis": {key: springs[key] for key in _SPRINGS}}


def _check_list_lengths(
    tables: dict[str, dict[str, Any]], classes: dict[str, type], units: int, root: FileLocation
) -> None:
    """Refuse lists that aren't one value for each motor unit, or each spring of the friction."""
    for name, table in tables.items():
        items, count = "motor units", units
        if classes[name] is dynamics.MaxwellSlip:
            items, count = "springs", np.size(table.get("stiffness", 0))
        for key, value in table.items():
            if PARTS[name].many and isinstance(value, np.ndarray) and len(value) != count:
                rule = f"must be one value, or a list of one for each of the {items}, {count}"
                raise root.error((name, key), f"{rule}, got {len(value)}.")


def _bundles(
    data: dict[str, Any], source: str, root: FileLocation, folder: Path | None
) -> list[Bundle]:
    names: Any = data.get("bundle")
    if "muscle" in data:
        if not isinstance(names, dict | None):
            raise root.error(("bundle",), "there is a [muscle], too: keep one of them.")
        inline = {key: data[key] for key in ("format", "muscle", "bundle") if key in data}
        return [as_bundle(from_dict(inline, source, folder))]
    rule = 'must name a bundle or its file, such as "kim2021_bundle_1_4", or a list of two'
    rule = f"{rule}; or write [muscle] and [bundle] as in its file."
    return _named_bundles(names, root.child("bundle"), rule, folder)


def _named_bundles(
    names: Any, location: FileLocation, rule: str, folder: Path | None
) -> list[Bundle]:
    """Bundles by names of examples or files; `rule`: of an error, if they aren't names."""
    names = names if isinstance(names, list) else [names]
    if not names or not all(isinstance(name, str) for name in names):
        raise location.error((), rule)
    with location.error_context():
        return [as_bundle(load_named(name, folder)) for name in names]


def _model_bundles(
    names: Any, bundles: list[Bundle], root: FileLocation, folder: Path | None
) -> list[Bundle]:
    """The bundles that a controller takes for its scenario's."""
    location = root.child("control", kind="part").child("model")
    rule = "must name a bundle or its file, for a joint a list of two."
    model = _named_bundles(names, location, rule, folder)

    def sizes(group: list[Bundle]) -> list[list[tuple[int, float]]]:
        return [[(x.count, float(x.muscle.length)) for x in b.motor_units] for b in group]

    if sizes(bundles) != sizes(model):
        raise location.error((), "must have the bundle's motor units, with muscles as long.")
    return model


def _parts(
    tables: dict[str, dict[str, Any]], classes: dict[str, type], root: FileLocation
) -> dict[str, Any]:
    """Parts of the plant by the name of its argument."""
    section = tables["fluid"]
    medium = _medium(section, classes["fluid"] is fluid.LiquidChamber, root.child("fluid"))
    gas = isinstance(medium, fluid.Gas)
    room = {key: section[key] for key in ("room_pressure", "room_temperature") if key in section}
    section["gas" if gas else "liquid"] = medium
    parts: dict[str, Any] = {}
    for key, table in tables.items():
        kind, location = classes[key], root.child(key, kind="part")
        for inner in INNER.keys() & table.keys():
            table[inner] = location.child(inner, kind="part").call(INNER[inner], **table[inner])
        if kind is fluid.Orifice and not gas:
            table.setdefault("density", float(medium.reference_density))
        if kind is fluid.SonicValve:
            _convert_data_sheet(table, location)
            if gas and medium is not fluid.AIR:
                # the same hole, for another gas
                ratio = fluid.AIR.specific_gas_constant / medium.specific_gas_constant
                table.setdefault("reference_density", REFERENCE_DENSITY * float(np.sqrt(ratio)))
        if key == "supply":
            parts[key] = _supply(table, kind, medium, room, location)
            continue
        with location.error_context():
            parts["chamber" if key == "fluid" else key] = kind(**table)
    return parts


def _convert_data_sheet(table: dict[str, Any], location: FileLocation) -> None:
    """Replace a data sheet's figure by the conductance C, in the values of a valve's table."""
    keys = [key for key in ("C", *DATA_SHEET) if key in table]
    if len(keys) != 1:
        rule = "give the valve's C, or one of nominal_flow (6 to 5 bar gauge), Kv and Cv"
        raise location.error((keys[-1] if keys else "C",), f"{rule}, one of them.")
    if keys != ["C"]:
        table["C"] = location.call(_CONVERSIONS[keys[0]], table.pop(keys[0]), table["b"])


def _medium(section: dict[str, Any], liquid: bool, location: FileLocation) -> Any:
    """The gas or liquid, taken out of the values of [fluid]."""
    name = section.pop("medium", None) or ("oil" if liquid else "air")
    medium = _MEDIA[location.call(check_choice, name, _MEDIA, "medium")]
    if liquid == isinstance(medium, fluid.Gas):
        phase, kinds = ("gas", "adiabatic_wall or isothermal") if liquid else ("liquid", "liquid")
        raise location.error(("medium",), f"{name} is a {phase}: take chamber = {kinds}.")
    if liquid and not np.all(np.asarray(section.get("compliance", 0.0)) > 0):
        rule = "must be positive for a liquid, which itself is nearly incompressible: write"
        example = 'compliance = "2e-11 m^3/Pa", of bladder, hose and fittings of each motor unit.'
        raise location.error(("compliance",), f"{rule} {example}")
    return medium


def _supply(
    table: dict[str, Any], kind: type, medium: Any, room: dict[str, Any], location: FileLocation
) -> Any:
    gas, holds_liquid = isinstance(medium, fluid.Gas), kind in _ACCUMULATORS
    if holds_liquid and gas:
        raise location.error(("kind",), "it holds a liquid: take constant or tank for a gas.")
    if kind is fluid.Tank and not gas:
        rule = "it holds a gas: take constant, accumulator or pumped for a liquid."
        raise location.error(("kind",), rule)
    pump = None
    if "pump" in table:
        values = {**table.pop("pump"), "liquid": medium}
        pump = location.child("pump", kind="part").call(fluid.FixedPump, **values)
    with location.error_context():
        if holds_liquid:
            store = fluid.Accumulator(**table, liquid=medium, **room)
            return store if pump is None else fluid.PumpedAccumulator(store, pump)
        if kind is fluid.Tank:
            if "conductance" not in table:
                return fluid.Tank(fluid.Isothermal(gas=medium, **room), **table)
            wall = table.pop("conductance")
            return fluid.Tank(fluid.AdiabaticWall(gas=medium, conductance=wall, **room), **table)
        names = {"room_temperature": "supply_temperature", "room_pressure": "room_pressure"}
        return kind(**{names[key]: value for key, value in room.items()} | table)


def _times(run: Any, units: int, location: FileLocation) -> tuple[float, float]:
    """Step and duration of a run [s]; refuses a broken step, or too many for the `units`."""
    dt, duration = run.dt or _STEP, run.duration
    steps = round(duration / dt)
    if abs(steps - duration / dt) > _ROUNDING * max(1, steps):
        suggestion = f"{max(steps, 1) * dt:.12g} s"
        raise location.error(("duration",), f"must be whole steps of {dt:g} s: take {suggestion}.")
    limit = min(_MAX_STEPS, _MAX_NUMBERS // (_NUMBERS_PER_STEP + _NUMBERS_PER_UNIT * units))
    if steps > limit:
        plant = f" of {units} motor units" if limit < _MAX_STEPS else ""
        rule = f"makes {steps} steps of {dt:g} s{plant}, more than {limit}: take a longer `dt`."
        raise location.error(("duration",), rule)
    return dt, duration


def _schedule(
    rows: list[Any], plant: Plant, dt: float, duration: float, root: FileLocation
) -> tuple[Schedule, tuple[str, ...]]:
    """Commands in time, and notes on those that the run can't follow exactly."""
    times, commands, notes = _rising_times(rows, "schedule", root), [], []
    for index, row in enumerate(rows):
        location, count, size = root.child("schedule", index), plant.units, np.size(row.command)
        if size != count and (np.ndim(row.command) or size != 1):
            rule = f"must be one number, or a list of one for each command, {count}"
            raise location.error(("command",), f"{rule}, got {size}.")
        with location.error_context():
            commands.append(np.broadcast_to(fluid.validate_commands(row.command), (count,)))
        command = f"the command at {row.time:g} s"
        if row.time >= duration:
            notes.append(f"{command} never comes: the run ends at {duration:g} s.")
        elif abs(row.time / dt - round(row.time / dt)) > _ROUNDING:
            step = dt * np.ceil(row.time / dt)
            notes.append(f"{command} comes with the next step, at {step:g} s.")
    return Schedule(times, np.array(commands)), tuple(notes)


def _rising_times(rows: list[Any], key: str, root: FileLocation) -> np.ndarray:
    """Times of the rows of a table [s], which begin at 0 and rise."""
    if not rows:
        raise root.error((key,), f"is empty: write [[{key}]] with time and values.")
    times = np.array([row.time for row in rows])
    if times[0] != 0:
        raise root.error((key, 0, "time"), "the first must be 0 s.")
    for index in np.flatnonzero(np.diff(times) <= 0).tolist():
        rule = f"times must rise, it comes after {times[index]:g} s."
        raise root.error((key, index + 1, "time"), rule)
    return times


def _control(
    file: Any, plant: Plant, dt: float, duration: float, root: FileLocation
) -> ScenarioControl:
    """Controller with a `plant` as its model."""
    from ..control import Gains

    output, reference = _reference(file, dt, duration, root)
    values = file.control.model_dump(exclude_none=True, exclude={"policy", "model"})
    default, position = Gains(), values.pop("position_gain", 0.0)
    gains = Gains(
        position,
        position / values.pop("integral_time", np.inf),
        values.pop("velocity_gain", 0.0),
        values.pop("force_gain", default.force),
        1 / values.pop("force_integral_time", 1 / default.force_integral),
        values.pop("pressure_time", default.pressure_time),
    )
    arguments = (
        plant,
        output,
        reference,
        file.control.policy,
        {"gains": gains, "dt": dt, **values},
    )
    return root.child("control", kind="part").call(_controlled, *arguments)


def _reference(file: Any, dt: float, duration: float, root: FileLocation) -> tuple[str, np.ndarray]:
    """The controlled output, "force" or "position", and its demand at each step [SI]."""
    time = dt * np.arange(round(duration / dt))
    times = _rising_times(file.demand, "demand", root)
    output = "force" if file.demand[0].force is not None else "position"
    for index, row in enumerate(file.demand):
        if (row.force is None) == (row.position is None) or getattr(row, output) is None:
            rule = "write `force` in each row, or `position` in each."
            raise root.error(("demand", index, output), rule)
    return output, np.interp(time, times, [getattr(row, output) for row in file.demand])

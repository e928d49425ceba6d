"""Scenario files: from TOML to a plant, its commands or controller, and its initial state.

A part's table holds the arguments of its class, which its `kind` chooses; the unit of each key is
that of the class's field.
"""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import attrs
import numpy as np
from pydantic import BaseModel, Field, StrictBool, StrictInt, create_model

from .. import dynamics, fluid
from ..bundle import Bundle
from ..bundle.bundle import as_bundle
from ..core.errors import InvalidInputError
from ..core.findings import Finding, Severity
from ..core.validation import check_choice, distinct_texts
from ..dynamics import Plant, Schedule, State, Trajectory
from ..fluid.flow_elements import REFERENCE_DENSITY
from ..table_model import Quantity, TableModel, did_you_mean, validate
from ..units import dimension_of_unit, exact, parse, quantity_example
from . import shipped_text
from .muscle_files import dumps, from_dict, load_named, parse_file, provenance, read_file
from .schema import Angle, FileLocation, Force, Length, Number, Pressure, check_kind


if TYPE_CHECKING:  # a scenario without control loads none of it
    from ..control import Cascade

_MEDIA = {"air": fluid.AIR, "nitrogen": fluid.NITROGEN, "oil": fluid.OIL, "water": fluid.WATER}
_MAX_STEPS = 2_000_000  # of a run: some minutes
_MAX_NUMBERS = 128_000_000  # of a run's results: a gigabyte, two motor units in that many steps
_NUMBERS_PER_STEP, _NUMBERS_PER_UNIT = 40, 12  # of these: of the plant, and of each motor unit
_STEP = 1e-3  # s: resolves valves and muscles
_ROUNDING = 1e-6  # of a step, by which rounding may shift a time
# keys of parts that a calibration measures
_MEASURED = {
    "hysteresis": ("kind", "stiffness", "slip_force", "slip_force_slope"),
    "damping": ("kind", "shortening", "lengthening", "shortening_slope", "lengthening_slope"),
}
_ACCUMULATORS = (fluid.Accumulator, fluid.PumpedAccumulator)
# figures of a valve's data sheet, their dimensions and conversions to the conductance C; nominal
# flow: 6 to 5 bar gauge, normal liters
_DATA_SHEET = {
    "nominal_flow": ("volume_flow", fluid.conductance_from_nominal_flow),
    "Kv": ("volume_flow", fluid.conductance_from_kv),
    "Cv": ("number", fluid.conductance_from_cv),
}


# of a part whose quantities are lengths, or angles where its load turns
_LINEAR_DIMENSIONS = {"low": "length", "high": "length"}
_ROTARY_DIMENSIONS: dict[str, str] = dict.fromkeys(("low", "high", "position"), "angle")
_ROTARY_DIMENSIONS |= {"damping": "angular_damping", "stiffness": "angular_stiffness"}
_NAME: tuple[Any, Any] = (str | None, None)
_INNER = {"stop": dynamics.Stop, "line": fluid.Line}  # tables in a part's table


class _Part(NamedTuple):
    """A part of a plant, one of the classes in `kinds`."""

    key: str  # by which the class is chosen
    kinds: Mapping[str, type]
    default: str = ""  # name of the class if the file has none
    supplied: tuple[str, ...] = ()  # arguments that don't come from its table
    optional: bool = False  # if the table may be missing
    many: bool = True  # if its numbers may be a list, one for each motor unit, spring, …


_VALVES = {"sonic_valve": fluid.SonicValve, "orifice": fluid.Orifice}
_ROOM = ("room_pressure", "room_temperature", "gas", "liquid")
_LOADS = {
    "hanging_mass": dynamics.HangingMass,
    "inertia_spring_damper": dynamics.InertiaSpringDamper,
    "antagonistic_joint": dynamics.AntagonisticJoint,
    "prescribed_motion": dynamics.PrescribedMotion,
}
_CHAMBERS = {
    "adiabatic_wall": fluid.AdiabaticWall,
    "isothermal": fluid.Isothermal,
    "liquid": fluid.LiquidChamber,
}
_SUPPLIES = {
    "constant": fluid.ConstantSupply,
    "tank": fluid.Tank,
    "accumulator": fluid.Accumulator,
    "pumped": fluid.PumpedAccumulator,
}
_SPOOLS = {"direct": fluid.Direct, "servovalve": fluid.Servovalve, "solenoid": fluid.Solenoid}
_FRICTION = {
    "maxwell_slip": dynamics.MaxwellSlip,
    "dahl": dynamics.Dahl,
    "coulomb": dynamics.Coulomb,
}
_PARTS = {
    "load": _Part("kind", _LOADS, many=False),
    "fluid": _Part("chamber", _CHAMBERS, supplied=("gas", "liquid")),
    "supply": _Part("kind", _SUPPLIES, supplied=(*_ROOM, "chamber"), many=False),
    "valve": _Part("kind", _VALVES),
    "exhaust_valve": _Part("kind", _VALVES, optional=True),
    "spool": _Part("kind", _SPOOLS, "direct", optional=True),
    "hysteresis": _Part("kind", _FRICTION, optional=True),
    "damping": _Part("kind", {"viscous": dynamics.Damping}, "viscous", optional=True),
}
_NAMELESS = _Part("", {}, supplied=("liquid",), many=False)  # a table of one class: [load.stop]


class CommandSection(TableModel):
    """`[[schedule]]`: from a time on, a command for each valve, or one for all of them."""

    time: Annotated[float, Quantity("time")] = Field(examples=['"0 s"'])
    command: Annotated[Any, Quantity("number", many=True)] = Field(examples=["[1, 0]"])


_Time = Annotated[float, Quantity("time")]
_NotNegative = Field(None, ge=0)
_Positive = Field(None, gt=0)


class RunSection(TableModel):
    """`[run]`."""

    duration: _Time = Field(gt=0, examples=[quantity_example("time")])
    dt: _Time | None = _Positive
    law: str | None = None
    volume: str | None = None
    pressures: Annotated[Any, Quantity("pressure", many=True)] = None
    position: Length | None = None


class JointRunSection(RunSection):
    """`[run]` of a joint."""

    position: Angle | None = None


class ScenarioTables(TableModel):
    """Keys of each scenario; the tables of its parts depend on their kinds."""

    format: StrictInt = Field(examples=["1"])
    name: str | None = None
    source: str | None = None
    bundle: Any = None
    muscle: Any = None


class Control(TableModel):
    """`[control]`: policy of recruitment, and gains of the cascade."""

    policy: str = Field(examples=['"hand_over"'])
    compensate: StrictBool | None = None
    model: Any = None
    band: Force | None = None
    co_contraction: Force | None = None
    highest_pressure: Pressure | None = None
    flow_limit: Number | None = None
    sample_time: _Time | None = None
    delay: _Time | None = None
    position_gain: Annotated[float, Quantity("stiffness")] | None = _NotNegative
    velocity_gain: Annotated[float, Quantity("damping")] | None = _NotNegative
    integral_time: _Time | None = _Positive
    force_gain: Number | None = _NotNegative
    force_integral_time: _Time | None = _Positive
    pressure_time: _Time | None = _Positive


class JointControl(Control):
    """`[control]` of a joint."""

    position_gain: Annotated[float, Quantity("angular_stiffness")] | None = _NotNegative
    velocity_gain: Annotated[float, Quantity("angular_damping")] | None = _NotNegative


class Demand(TableModel):
    """`[[demand]]`: force or position at a time, between which it is linear."""

    time: _Time = Field(examples=['"0 s"'])
    force: Force | None = None
    position: Length | None = None


class JointDemand(Demand):
    """`[[demand]]` of a joint: a torque, or an angle."""

    force: Annotated[float, Quantity("moment")] | None = None
    position: Angle | None = None


def _choose_schema(
    data: Mapping[str, Any], location: FileLocation
) -> tuple[type[BaseModel], dict[str, type]]:
    """Schema for the kinds of parts in a file's tables, and the class of each part by its key.

    Raises a `ValueError`, in one line, for an unknown kind.
    """
    classes = {
        name: _class(name, part, data[name], location)
        for name, part in _PARTS.items()
        if isinstance(data.get(name), dict)
    }
    rotary = classes.get("load") is dynamics.AntagonisticJoint
    keys: dict[str, Any] = {}
    for name, part in _PARTS.items():
        table: Any = TableModel
        if name in classes:
            table = _table_model(part, classes[name], rotary and name == "load")
        required = (table, Field(examples=[f"[{name}]"]))
        keys[name] = (table | None, None) if part.optional else required
    run, control, demand = RunSection, Control, Demand
    if rotary:
        run, control, demand = JointRunSection, JointControl, JointDemand
    keys["run"] = (run, Field(examples=["[run]"]))
    if isinstance(data.get("control"), dict):
        keys["control"] = (control, Field(examples=["[control]"]))
        keys["demand"] = (list[demand], Field(examples=["[[demand]]"]))
    else:
        keys["schedule"] = (list[CommandSection], Field(examples=["[[schedule]]"]))
    return create_model("ScenarioFileSection", __base__=ScenarioTables, **keys), classes


def _key(dimension: str, many: bool, required: bool) -> tuple[Any, Any]:
    """Type and default of a key."""
    kind: Any = Annotated[Any, Quantity(dimension, many)]
    return kind, Field(examples=[quantity_example(dimension)]) if required else None


def _table_model(part: _Part, kind: type, rotary: bool = False) -> type[TableModel]:
    """Table of a class: the arguments of its constructor."""
    keys: dict[str, Any] = {part.key: _NAME} if part.key else {}
    if kind is fluid.PumpedAccumulator:
        pump = _table_model(_NAMELESS, fluid.FixedPump)
        keys["pump"] = (pump, Field(examples=["[supply.pump]"]))
        kind = fluid.Accumulator
    dimensions = _ROTARY_DIMENSIONS if rotary else _LINEAR_DIMENSIONS
    units = {field.name: field.metadata.get("unit", "") for field in attrs.fields(kind)}
    for name, parameter in signature(kind).parameters.items():
        if name in _INNER:
            inner: Any = _table_model(_NAMELESS, _INNER[name], rotary)
            keys[name] = (inner | None, None)
        elif name not in part.supplied:
            dimension = dimensions.get(name) or dimension_of_unit(units[name])
            if dimension is None:
                raise TypeError(f"{kind.__name__}.{name} declares no unit.")
            keys[name] = _key(dimension, part.many, parameter.default is Parameter.empty)
    if kind is fluid.SonicValve:
        keys["C"] = _key("sonic_conductance", part.many, False)
        keys |= {name: _key(x, part.many, False) for name, (x, _) in _DATA_SHEET.items()}
    if kind is fluid.Tank:  # the tank's wall, apart from that of the chambers
        keys["conductance"] = _key("wall_conductance", False, False)
    if part is _PARTS["fluid"]:
        keys["medium"] = _NAME
    return create_model(f"{kind.__name__}Section", __base__=TableModel, **keys)


def _class(name: str, part: _Part, table: Mapping[str, Any], location: FileLocation) -> type:
    """Class of a part, by the name in its table."""
    kind = table.get(part.key, part.default or None)
    if name == "fluid" and kind is None:
        kind = "liquid" if table.get("medium") in ("oil", "water") else "adiabatic_wall"
    choices = ", ".join(part.kinds)
    if kind is None:
        rule = f"missing, write {part.key} = one of {choices}."
    elif not isinstance(kind, str):
        rule = f"must be a name in quotes, one of {choices}."
    elif kind not in part.kinds:
        rule = f"there is none{did_you_mean(kind, part.kinds)}"
    else:
        return part.kinds[kind]
    raise location.error((name, part.key), rule)


class ScenarioControl(NamedTuple):
    """A `controller` with its demand at each step, the `reference` [SI]; its `policy` and other
    `options`; `hand_over_obstacle`: why units can't hand over without a dip, if they can't.
    """

    controller: "Cascade"
    reference: np.ndarray
    policy: str
    options: Mapping[str, Any]
    hand_over_obstacle: Finding | None = None

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Why units can't hand over without a dip, if so; findings on the gains and the demand."""
        obstacle, controller = filter(None, [self.hand_over_obstacle]), self.controller
        return (*obstacle, *controller.findings, *controller.demand_findings(self.reference))


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
    - `findings`: settings that the run can't follow exactly.
    """

    name: str
    plant: Plant
    schedule: Schedule | None
    start: State
    dt: float
    duration: float
    source: str = ""
    findings: tuple[Finding, ...] = ()
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
        return replace(self, control=control, findings=control.findings)

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


def lift_scenario(
    bundle: Bundle, name: str, path: Path | None = None, mass: float | None = None
) -> Scenario:
    """Scenario `lift_gas` with another `bundle`: its motor units fill one after another, lift a
    `mass` [kg], by default half of the first one's blocked force, and are vented in reverse.
    `path`: of a calibrated muscle, whose friction it has.
    """
    data = parse_file(shipped_text("scenarios", "lift_gas"), name)
    tables = parse_file(dumps(bundle), name)
    data |= {key: tables[key] for key in ("muscle", "bundle")}
    supply, units = data["supply"], bundle.motor_units
    if bundle.supply_pressure is not None:
        supply["pressure"] = exact(float(bundle.supply_pressure), "pressure")
    pressure, first = parse(supply["pressure"], "pressure"), units[0]
    if mass is None:
        gravity = float(dynamics.HangingMass(1.0).gravity)
        half = first.count * float(first.muscle.blocked_force(pressure)) / 2
        mass = float(f"{half / gravity:.3g}")
    # about as in `lift_gas`: damping by mass, stops by length, valves and hoses by volume
    length, volume = float(first.muscle.length), 1e6 * float(first.muscle.braid.volume(0.0))
    data["load"] |= {"mass": f"{mass!r} kg", "damping": f"{10 * mass:.3g} N*s/m"}
    data["load"]["stop"] = {"low": f"{-0.15 * length:.3g} m", "high": f"{0.25 * length:.3g} m"}
    data["fluid"]["dead_volume"] = [f"{0.125 * volume * unit.count:.3g} mL" for unit in units]
    data["valve"]["C"] = f"{volume / 160:.3g} L/(s*bar)"
    count, shut = len(units), [0] * len(units)
    commands = [[*shut[:k], way, *shut[k + 1 :]] for way in (1, -1) for k in range(count)]
    times = [*(2 * k for k in range(count)), *(3 * count - 1 - k for k in range(count))]
    rows = dict(zip(times, commands, strict=True)) | {2 * k + 1: shut for k in range(count)}
    data["schedule"] = [{"time": f"{t} s", "command": rows[t]} for t in sorted(rows)]
    # a quarter of its step: then the energies balance to 1e-7 where muscles buckle
    data["run"] |= {"duration": f"{3 * count} s", "dt": "0.25 ms"}
    data["name"] = f"{name} with {mass:.3g} kg"
    if path is None:
        return scenario_from_dict(data, name, None, name)
    calibration = provenance(path)
    for part in (part for part in _MEASURED if "kind" in calibration.get(part, {})):
        data[part] = {"kind": "measured", "muscle": path.name}
    return scenario_from_dict(data, name, path.parent, name)


def scenario_from_dict(
    data: dict[str, Any], source: str, folder: Path | None, name: str
) -> Scenario:
    """The scenario in a file's tables; arguments as for `loads_scenario`."""
    check_kind(data, "scenario", source)
    root = FileLocation(source, data, kind="scenario")
    for part in _MEASURED:
        data = _with_measured(part, data, root, folder)
    schema, classes = _choose_schema(data, root)
    file: Any = validate(schema, data, source)
    bundles = _bundles(data, source, root, folder)
    tables = {
        key: getattr(file, key).model_dump(exclude_none=True, exclude={"kind", "chamber"})
        for key in classes
    }
    units = sum(len(bundle.motor_units) for bundle in bundles)
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
        findings = control.findings
    else:
        schedule, findings = _schedule(file.schedule, plant, dt, duration, root)
    if plant.load.prescribed and run.position is not None:
        raise root.error(("run", "position"), "the load's motion is given: drop this key.")
    # a prescribed motion itself may leave the stroke
    start_location = FileLocation(source, data, kind="motion") if plant.load.prescribed else root
    with start_location.error_context():
        pressures = _first_pressures(plant, control) if run.pressures is None else run.pressures
        start = dynamics.equilibrium_state(plant, pressures, run.position)
    name, source = file.name or name, file.source or ""
    return Scenario(name, plant, schedule, start, dt, duration, source, findings, control)


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


def _with_measured(
    part: str, data: dict[str, Any], root: FileLocation, folder: Path | None
) -> dict[str, Any]:
    """A scenario's tables, with a calibration's numbers of a `part` in place of
    `kind = "measured"`; without its table if the calibration measured none.
    """
    table = data.get(part)
    if not isinstance(table, dict) or table.get("kind") != "measured":
        return data
    for key in table:
        if key not in ("kind", "muscle"):
            raise root.error((part, key), "measured: the file of the muscle has it.")
    name = table.get("muscle", data.get("bundle"))
    if not isinstance(name, str) or folder is None or not (folder / name).is_file():
        rule = 'must name the calibrated muscle\'s file: write muscle = "muscle.toml".'
        raise root.error((part, "muscle"), rule)
    numbers = root.child(part).call(provenance, folder / name).get(part)
    numbers = numbers if isinstance(numbers, dict) else {}
    if numbers.get("kind") == "none":
        return {key: value for key, value in data.items() if key != part}
    if any(key not in numbers for key in _MEASURED[part]):
        need = "of two speeds" if part == "damping" else "of both ways"
        rule = f"{name} has no {part}: `fascicle calibrate` finds it in records {need}."
        raise root.error((part, "kind"), rule)
    return data | {part: {key: numbers[key] for key in _MEASURED[part]}}


def _check_list_lengths(
    tables: dict[str, dict[str, Any]], classes: dict[str, type], units: int, root: FileLocation
) -> None:
    """Refuse lists that aren't one value for each motor unit, or each spring of the friction."""
    for name, table in tables.items():
        items, count = "motor units", units
        if classes[name] is dynamics.MaxwellSlip:
            items, count = "springs", np.size(table.get("stiffness", 0))
        for key, value in table.items():
            if _PARTS[name].many and isinstance(value, np.ndarray) and len(value) != count:
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
        for inner in _INNER.keys() & table.keys():
            table[inner] = location.child(inner, kind="part").call(_INNER[inner], **table[inner])
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
    keys = [key for key in ("C", *_DATA_SHEET) if key in table]
    if len(keys) != 1:
        rule = "give the valve's C, or one of nominal_flow (6 to 5 bar gauge), Kv and Cv"
        raise location.error((keys[-1] if keys else "C",), f"{rule}, one of them.")
    if keys != ["C"]:
        convert = _DATA_SHEET[keys[0]][1]
        table["C"] = location.call(convert, table.pop(keys[0]), table["b"])


def _medium(section: dict[str, Any], liquid: bool, location: FileLocation) -> Any:
    """The gas or liquid, taken out of the values of [fluid]."""
    name = section.pop("medium", None) or ("oil" if liquid else "air")
    medium = _MEDIA[location.call(check_choice, name, _MEDIA, "medium")]
    if liquid == isinstance(medium, fluid.Gas):
        phase, kinds = ("gas", "adiabatic_wall or isothermal") if liquid else ("liquid", "liquid")
        raise location.error(("medium",), f"{name} is a {phase}: take chamber = {kinds}.")
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
    pump = table.pop("pump", None)
    if pump is not None:
        pump = location.child("pump", kind="part").call(fluid.FixedPump, **pump, liquid=medium)
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
) -> tuple[Schedule, tuple[Finding, ...]]:
    """Commands in time, and findings on those that the run can't follow exactly."""
    times, commands, findings = _rising_times(rows, "schedule", root), [], []
    for index, row in enumerate(rows):
        location, count, size = root.child("schedule", index), plant.units, np.size(row.command)
        if size != count and (np.ndim(row.command) or size != 1):
            rule = f"must be one number, or a list of one for each command, {count}"
            raise location.error(("command",), f"{rule}, got {size}.")
        with location.error_context():
            commands.append(np.broadcast_to(fluid.validate_commands(row.command), (count,)))
        if row.time >= duration:
            code, data = "command_after_end", {"time": row.time, "end": duration}
        elif abs(row.time / dt - round(row.time / dt)) > _ROUNDING:
            code, data = (
                "command_delayed",
                {"time": row.time, "step": dt * math.ceil(row.time / dt)},
            )
        else:
            continue
        findings.append(Finding(f"scenario.{code}", Severity.WARNING, data))
    return Schedule(times, np.array(commands)), tuple(findings)


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

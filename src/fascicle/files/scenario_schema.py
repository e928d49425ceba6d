"""Schema of a scenario file, format 1. A part's table holds the arguments of its class, which its
`kind` chooses; the unit of each key is that of the class's field.
"""

from collections.abc import Mapping
from inspect import Parameter, signature
from typing import Annotated, Any, NamedTuple

import attrs
from pydantic import BaseModel, Field, StrictBool, StrictInt, create_model

from .. import dynamics, fluid
from ..table_model import Quantity, TableModel, did_you_mean
from ..units import dimension_of_unit, quantity_example
from .schema import Angle, FileLocation, Force, Length, Number, Pressure


# of a part whose quantities are lengths, or angles where its load turns
_LINEAR_DIMENSIONS = {"low": "length", "high": "length"}
_ROTARY_DIMENSIONS: dict[str, str] = dict.fromkeys(("low", "high", "position"), "angle")
_ROTARY_DIMENSIONS |= {"damping": "angular_damping", "stiffness": "angular_stiffness"}
_NAME: tuple[Any, Any] = (str | None, None)
# keys of a valve's data sheet that stand for C; nominal flow: 6 to 5 bar gauge, normal liters
DATA_SHEET = {"nominal_flow": "volume_flow", "Kv": "volume_flow", "Cv": "number"}
INNER = {"stop": dynamics.Stop, "line": fluid.Line}  # tables in a part's table


class Part(NamedTuple):
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
PARTS = {
    "load": Part("kind", _LOADS, many=False),
    "fluid": Part("chamber", _CHAMBERS, supplied=("gas", "liquid")),
    "supply": Part("kind", _SUPPLIES, supplied=(*_ROOM, "chamber"), many=False),
    "valve": Part("kind", _VALVES),
    "exhaust_valve": Part("kind", _VALVES, optional=True),
    "spool": Part("kind", _SPOOLS, "direct", optional=True),
    "hysteresis": Part("kind", _FRICTION, optional=True),
}
_NAMELESS = Part("", {}, supplied=("liquid",), many=False)  # a table of one class: [load.stop]


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


def choose_schema(
    data: Mapping[str, Any], location: FileLocation
) -> tuple[type[BaseModel], dict[str, type]]:
    """Schema for the kinds of parts in a file's tables, and the class of each part by its key.

    Raises a `ValueError`, in one line, for an unknown kind.
    """
    classes = {
        name: _class(name, part, data[name], location)
        for name, part in PARTS.items()
        if isinstance(data.get(name), dict)
    }
    rotary = classes.get("load") is dynamics.AntagonisticJoint
    keys: dict[str, Any] = {}
    for name, part in PARTS.items():
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


def _table_model(part: Part, kind: type, rotary: bool = False) -> type[TableModel]:
    """Table of a class: the arguments of its constructor."""
    keys: dict[str, Any] = {part.key: _NAME} if part.key else {}
    if kind is fluid.PumpedAccumulator:
        pump = _table_model(_NAMELESS, fluid.FixedPump)
        keys["pump"] = (pump, Field(examples=["[supply.pump]"]))
        kind = fluid.Accumulator
    dimensions = _ROTARY_DIMENSIONS if rotary else _LINEAR_DIMENSIONS
    units = {field.name: field.metadata.get("unit", "") for field in attrs.fields(kind)}
    for name, parameter in signature(kind).parameters.items():
        if name in INNER:
            inner: Any = _table_model(_NAMELESS, INNER[name], rotary)
            keys[name] = (inner | None, None)
        elif name not in part.supplied:
            dimension = dimensions.get(name) or dimension_of_unit(units[name])
            if dimension is None:
                raise TypeError(f"{kind.__name__}.{name} declares no unit.")
            keys[name] = _key(dimension, part.many, parameter.default is Parameter.empty)
    if kind is fluid.SonicValve:
        dimensions = DATA_SHEET | {"C": "sonic_conductance"}
        keys |= {name: _key(unit, part.many, False) for name, unit in dimensions.items()}
    if kind is fluid.Tank:  # the tank's wall, apart from that of the chambers
        keys["conductance"] = _key("wall_conductance", False, False)
    if part is PARTS["fluid"]:
        keys["medium"] = _NAME
    return create_model(f"{kind.__name__}Section", __base__=TableModel, **keys)


def _class(name: str, part: Part, table: Mapping[str, Any], location: FileLocation) -> type:
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

"""Schema of a scenario file, format 1: tables of a plant's parts, the run, commands, control.

A part's table holds what its class declares; the class is chosen by the table's `kind`. Only each
name's dimension is given here, once for all classes.
"""

from collections.abc import Mapping
from functools import partial
from inspect import Parameter, signature
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, Field, StrictBool, StrictInt, create_model

from ..dynamics import (
    AntagonisticJoint,
    Coulomb,
    Dahl,
    HangingMass,
    InertiaSpringDamper,
    MaxwellSlip,
    PrescribedMotion,
    Stop,
)
from ..fluid import (
    Accumulator,
    AdiabaticWall,
    ConstantSupply,
    Direct,
    FixedPump,
    Isothermal,
    Line,
    LiquidChamber,
    OrderlyValve,
    Orifice,
    Polytropic,
    PressureBand,
    PumpedAccumulator,
    Relief,
    Servovalve,
    SonicValve,
    Tank,
    VariablePump,
)
from ..units import sample
from .errors import FileLocation
from .table_model import Quantity, TableModel, did_you_mean


_CONTROL_DIMENSIONS = {
    "band": "force", "sample_time": "time", "delay": "time", "highest_pressure": "pressure",
    "flow_limit": "number", "co_contraction": "force", "integral_time": "time",
    "force_gain": "number", "force_integral_time": "time", "pressure_time": "time",
}  # fmt: skip
_DIMENSIONS = {
    "mass": "mass", "gravity": "acceleration", "damping": "damping", "rest": "length",
    "spring_stiffness": "stiffness", "force_outside": "force", "inertia_moment": "inertia_moment",
    "radius": "length", "contraction": "length", "gravity_moment": "moment", "mean": "length",
    "amplitude": "length", "frequency": "frequency", "low": "length", "high": "length",
    "stiffness": "stiffness", "conductance": "wall_conductance", "dead_volume": "volume",
    "room_pressure": "pressure", "room_temperature": "temperature", "compliance": "compliance",
    "exponent": "number", "pressure": "pressure", "precharge": "pressure", "volume": "volume",
    "supply_temperature": "temperature", "C": "sonic_conductance", "b": "number", "m": "number",
    "reference_density": "density", "area": "area", "density": "density",
    "discharge_coefficient": "number", "critical_pressure_difference": "pressure",
    "length": "length", "diameter": "length", "viscosity": "viscosity",
    "friction_factor": "number", "overlap": "number", "time_constant": "time",
    "displacement": "volume", "speed": "frequency", "volumetric_efficiency": "number",
    "mechanical_efficiency": "number", "crack": "pressure", "slope": "relief_slope",
    "slip_force": "force", "slip_force_slope": "slip", "width": "pressure",
    "velocity": "velocity",
}  # fmt: skip
_ROTARY_DIMENSIONS = {
    "damping": "angular_damping", "stiffness": "angular_stiffness", "low": "angle", "high": "angle",
    "position": "angle",
}  # fmt: skip
# dimensions of a name in one class alone
_CLASS_DIMENSIONS: Mapping[type, Mapping[str, str]] = {
    PressureBand: {"low": "pressure", "high": "pressure"},
    VariablePump: {"band": "pressure"},
}
_NAME: tuple[Any, Any] = (str | None, None)
_INNER = {"stop": Stop, "line": Line}  # tables in a table
PUMPED = {"band": PressureBand, "relief": Relief}  # and in that of a supply with a pump


def _key(dimension: str, many: bool = False, needed: bool = True) -> tuple[Any, Any]:
    """Type and default of a key."""
    kind: Any = Annotated[Any, Quantity(dimension, many)]
    return kind, Field(examples=[sample(dimension)]) if needed else None


class Part(NamedTuple):
    """A part of a plant.

    - `key`: the key by which its class is chosen.
    - `kinds`: classes by name; `default`: the one if none is named.
    - `supplied`: arguments that don't come from its table.
    - `optional`: true if the table may be missing.
    - `many`: true if its numbers may be a list, one for each motor unit, spring, ….
    """

    key: str
    kinds: Mapping[str, type]
    default: str = ""
    supplied: tuple[str, ...] = ()
    optional: bool = False
    many: bool = True


_VALVES = {"sonic_valve": SonicValve, "orifice": Orifice}
_ROOM = ("room_pressure", "room_temperature", "gas", "liquid")
PARTS = {
    "load": Part("kind", {
        "hanging_mass": HangingMass, "inertia_spring_damper": InertiaSpringDamper,
        "antagonistic_joint": AntagonisticJoint, "prescribed_motion": PrescribedMotion,
    }, many=False),
    "fluid": Part("chamber", {
        "adiabatic_wall": AdiabaticWall, "isothermal": Isothermal, "polytropic": Polytropic,
        "liquid": LiquidChamber,
    }, supplied=("gas", "liquid")),
    "supply": Part("kind", {
        "constant": ConstantSupply, "tank": Tank, "accumulator": Accumulator,
        "pumped": PumpedAccumulator,
    }, supplied=(*_ROOM, "chamber"), many=False),
    "valve": Part("kind", _VALVES),
    "exhaust_valve": Part("kind", _VALVES, optional=True),
    "spool": Part("kind", {
        "direct": Direct, "servovalve": Servovalve, "orderly": OrderlyValve,
    }, "direct", supplied=("units",), optional=True),
    "hysteresis": Part("kind", {
        "maxwell_slip": MaxwellSlip, "dahl": Dahl, "coulomb": Coulomb,
    }, optional=True),
}  # fmt: skip
_PUMPS = Part("kind", {"fixed": FixedPump, "variable": VariablePump}, "fixed",
              supplied=("liquid",), many=False)  # fmt: skip


def _table(part: Part, kind: type, turns: bool) -> type[TableModel]:
    """Table of a class: the arguments of its constructor."""
    keys: dict[str, Any] = {part.key: _NAME} if part.key else {}
    for name, parameter in signature(kind).parameters.items():
        if name in part.supplied:
            continue
        if name in _INNER:
            inner: Any = _table(Part("", {}, many=False), _INNER[name], turns)
            keys[name] = (inner | None, None)
            continue
        names = _CLASS_DIMENSIONS.get(kind, _ROTARY_DIMENSIONS if turns else {})
        dimension = names.get(name)
        needed = parameter.default is Parameter.empty
        keys[name] = _key(dimension or _DIMENSIONS[name], part.many, needed)
    if kind is Tank:  # it stands behind a wall of its own
        keys["conductance"] = _key("wall_conductance", needed=False)
    return create_model(f"{kind.__name__}Section", __base__=TableModel, **keys)


def _pumped(data: Mapping[str, Any], location: FileLocation) -> type[TableModel]:
    """The table of an accumulator with the kind of pump that a scenario's `data` name."""
    keys: dict[str, Any] = {
        name: (_table(Part("", {}, many=False), kind, turns=False) | None, None)
        for name, kind in PUMPED.items()
    }
    pump = _table(_PUMPS, pump_class(data, location), turns=False)
    keys["pump"] = (pump, Field(examples=["[supply.pump]"]))
    store = _table(PARTS["supply"], Accumulator, turns=False)
    return create_model("PumpedSection", __base__=store, **keys)


def pump_class(data: Mapping[str, Any], location: FileLocation) -> type:
    """Class of the pump in a scenario's tables."""
    table = data["supply"].get("pump")
    inner = location.inner("supply", kind="part")
    return _class("pump", _PUMPS, table if isinstance(table, dict) else {}, inner)


class CommandSection(TableModel):
    """`[[schedule]]`: from a time on, a command for each valve, or one for all of them."""

    time: Annotated[float, Quantity("time")] = Field(examples=['"0 s"'])
    command: Annotated[Any, Quantity("number", many=True)] = Field(examples=["[1, 0]"])


def _run(turns: bool) -> type[TableModel]:
    return create_model(
        "RunSection",
        __base__=TableModel,
        duration=(Annotated[float, Quantity("time")], Field(examples=['"10 s"'])),
        dt=_key("time", needed=False),
        law=_NAME,
        volume=_NAME,
        pressures=_key("pressure", many=True, needed=False),
        position=_key("angle" if turns else "length", needed=False),
    )


def choose_schema(
    data: Mapping[str, Any], location: FileLocation
) -> tuple[type[BaseModel], dict[str, type]]:
    """Schema for the kinds of parts in a file's tables, and the class of each part by its key.

    Raises a `ValueError`, in one line, for an unknown kind.
    """
    classes = {}
    for name, part in PARTS.items():
        table = data.get(name)
        if isinstance(table, dict):
            classes[name] = _class(name, part, table, location)
    turns = classes.get("load") is AntagonisticJoint
    keys: dict[str, Any] = {
        "format": (StrictInt, Field(examples=["1"])),
        "name": _NAME,
        "source": _NAME,
        "bundle": (Any, None),
        "muscle": (Any, None),
    }
    for name, part in PARTS.items():
        kind: Any = TableModel
        if classes.get(name) is PumpedAccumulator:
            kind = _pumped(data, location)
        elif name in classes:
            kind = _table(part, classes[name], turns and name == "load")
        if name == "fluid" and name in classes:
            kind = create_model("FluidSection", __base__=kind, medium=_NAME)
        needed = (kind, Field(examples=[f"[{name}]"]))
        keys[name] = (kind | None, None) if part.optional else needed
    keys["run"] = (_run(turns), Field(examples=["[run]"]))
    if isinstance(data.get("control"), dict):
        keys |= _control_keys(turns)
    else:
        keys["schedule"] = (list[CommandSection], Field(examples=["[[schedule]]"]))
    return create_model("ScenarioFileSection", __base__=TableModel, **keys), classes


def _control_keys(turns: bool) -> dict[str, Any]:
    """Keys of a controlled scenario's file; `turns`: true for a joint."""
    may = partial(_key, needed=False)
    keys: dict[str, Any] = {name: may(dimension) for name, dimension in _CONTROL_DIMENSIONS.items()}
    keys["position_gain"] = may("angular_stiffness" if turns else "stiffness")
    keys["velocity_gain"] = may("angular_damping" if turns else "damping")
    named: Any = (str, Field(examples=['"hand_over"']))
    control: Any = create_model(
        "ControlSection", __base__=TableModel, policy=named,
        compensate=(StrictBool | None, None), **keys,
    )  # fmt: skip
    where = "angle" if turns else "length"
    force = "moment" if turns else "force"
    demand: Any = create_model(
        "DemandSection", __base__=TableModel, time=_key("time"), force=may(force),
        position=may(where),
    )  # fmt: skip
    sine: Any = create_model(
        "SineSection", __base__=TableModel, mean=_key(where), amplitude=_key(where),
        frequency=_key("frequency"),
    )  # fmt: skip
    return {
        "control": (control, Field(examples=["[control]"])),
        "demand": (list[demand] | None, None),
        "sine": (sine | None, None),
    }


def _class(name: str, part: Part, table: Mapping[str, Any], location: FileLocation) -> type:
    kind = table.get(part.key, part.default or None)
    if name == "fluid" and kind is None:
        kind = "liquid" if table.get("medium") in ("oil", "water") else "adiabatic_wall"
    if kind is None:
        known = ", ".join(part.kinds)
        raise location.error((name, part.key), f"missing, write {part.key} = one of {known}.")
    if not isinstance(kind, str):
        rule = f"must be a name in quotes, one of {', '.join(part.kinds)}."
        raise location.error((name, part.key), rule)
    if kind not in part.kinds:
        raise location.error((name, part.key), f"there is none{did_you_mean(kind, part.kinds)}")
    return part.kinds[kind]

"""The sections of a scenario file, format 1: a table for each part of a plant, the run, commands.

What a part's table may hold is what its class declares; a class is chosen by the table's `kind`.
Only each name's dimension is said here, once for all of them.
"""

from collections.abc import Mapping
from inspect import Parameter, signature
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, Field, StrictInt, create_model

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
from .control_schema import control_keys
from .faults import nearest
from .places import Place
from .schema import Section, key, quantity


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
_OF_A_TURN = {
    "damping": "angular_damping", "stiffness": "angular_stiffness", "low": "angle", "high": "angle",
    "position": "angle",
}  # fmt: skip
# what a name is in one class alone
_OF_A_CLASS: Mapping[type, Mapping[str, str]] = {
    PressureBand: {"low": "pressure", "high": "pressure"},
    VariablePump: {"band": "pressure"},
}
_NAME: tuple[Any, Any] = (str | None, None)
_INNER = {"stop": Stop, "line": Line}  # tables in a table
PUMPED = {"band": PressureBand, "relief": Relief}  # and in that of a supply with a pump


class Part(NamedTuple):
    """A part of a plant: the key `by` which its class is chosen, `kinds` by name, which of them is
    the `usual` one where none is said, names that its table doesn't have, as they are `found`
    elsewhere, whether the table may be `left_out`, and whether its numbers may be a list, one for
    each motor unit, a valve's spring, … (`many`).
    """

    by: str
    kinds: Mapping[str, type]
    usual: str = ""
    found: tuple[str, ...] = ()
    left_out: bool = False
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
    }, found=("gas", "liquid")),
    "supply": Part("kind", {
        "constant": ConstantSupply, "tank": Tank, "accumulator": Accumulator,
        "pumped": PumpedAccumulator,
    }, found=(*_ROOM, "chamber"), many=False),
    "valve": Part("kind", _VALVES),
    "exhaust_valve": Part("kind", _VALVES, left_out=True),
    "spool": Part("kind", {
        "direct": Direct, "servovalve": Servovalve, "orderly": OrderlyValve,
    }, "direct", found=("units",), left_out=True),
    "hysteresis": Part("kind", {
        "maxwell_slip": MaxwellSlip, "dahl": Dahl, "coulomb": Coulomb,
    }, left_out=True),
}  # fmt: skip
_PUMPS = Part("kind", {"fixed": FixedPump, "variable": VariablePump}, "fixed",
              found=("liquid",), many=False)  # fmt: skip


def _or_none(kind: Any) -> Any:
    return kind | None


def _table(part: Part, kind: type, turns: bool) -> type[Section]:
    """The table of a class: what its constructor takes."""
    keys: dict[str, Any] = {part.by: _NAME} if part.by else {}
    for name, one in signature(kind).parameters.items():
        if name in part.found:
            continue
        if name in _INNER:
            inner: Any = _table(Part("", {}, many=False), _INNER[name], turns)
            keys[name] = (_or_none(inner), None)
            continue
        own = _OF_A_CLASS.get(kind, _OF_A_TURN if turns else {})
        dimension = own.get(name)
        needed = one.default is Parameter.empty
        keys[name] = key(dimension or _DIMENSIONS[name], part.many, needed)
    if kind is Tank:  # it stands behind a wall of its own
        keys["conductance"] = key("wall_conductance", needed=False)
    return create_model(f"{kind.__name__}Section", __base__=Section, **keys)


def _pumped(data: Mapping[str, Any], place: Place) -> type[Section]:
    """The table of an accumulator with the kind of pump that a scenario's `data` name."""
    keys: dict[str, Any] = {
        name: (_or_none(_table(Part("", {}, many=False), kind, turns=False)), None)
        for name, kind in PUMPED.items()
    }
    pump = _table(_PUMPS, pump_class(data, place), turns=False)
    keys["pump"] = (pump, Field(examples=["[supply.pump]"]))
    store = _table(PARTS["supply"], Accumulator, turns=False)
    return create_model("PumpedSection", __base__=store, **keys)


def pump_class(data: Mapping[str, Any], place: Place) -> type:
    """The class of the pump [-] that a scenario's `data` [-] name, of the whole file's `place`."""
    table = data["supply"].get("pump")
    at = place.inner("supply", kind="part")
    return _class("pump", _PUMPS, table if isinstance(table, dict) else {}, at)


class CommandSection(Section):
    """`[[schedule]]`: from a time on, a command for each valve, or one for all of them."""

    time: Annotated[float, quantity("time")] = Field(examples=['"0 s"'])
    command: Annotated[Any, quantity("number", many=True)] = Field(examples=["[1, 0]"])


def _run(turns: bool) -> type[Section]:
    return create_model(
        "RunSection",
        __base__=Section,
        duration=(Annotated[float, quantity("time")], Field(examples=['"10 s"'])),
        dt=key("time", needed=False),
        law=_NAME,
        volume=_NAME,
        pressures=key("pressure", many=True, needed=False),
        position=key("angle" if turns else "length", needed=False),
    )


def chosen(data: Mapping[str, Any], place: Place) -> tuple[type[BaseModel], dict[str, type]]:
    """The file's schema, for the kinds of parts that it names.

    **Arguments:**

    - `data`: what it holds [-].
    - `place`: of the whole file [-].

    **Returns:** the schema, and the class of each part that is there, by its key [-].

    **Raises:** `ValueError`, in one line, for a kind that there isn't.
    """
    classes = {}
    for name, part in PARTS.items():
        table = data.get(name)
        if isinstance(table, dict):
            classes[name] = _class(name, part, table, place)
    turns = classes.get("load") is AntagonisticJoint
    keys: dict[str, Any] = {
        "format": (StrictInt, Field(examples=["1"])),
        "name": _NAME,
        "source": _NAME,
        "bundle": (Any, None),
        "muscle": (Any, None),
    }
    for name, part in PARTS.items():
        kind: Any = Section
        if classes.get(name) is PumpedAccumulator:
            kind = _pumped(data, place)
        elif name in classes:
            kind = _table(part, classes[name], turns and name == "load")
        if name == "fluid" and name in classes:
            kind = create_model("FluidSection", __base__=kind, medium=_NAME)
        needed = (kind, Field(examples=[f"[{name}]"]))
        keys[name] = (_or_none(kind), None) if part.left_out else needed
    keys["run"] = (_run(turns), Field(examples=["[run]"]))
    if isinstance(data.get("control"), dict):
        keys |= control_keys(turns)
    else:
        keys["schedule"] = (list[CommandSection], Field(examples=["[[schedule]]"]))
    return create_model("ScenarioFileSection", __base__=Section, **keys), classes


def _class(name: str, part: Part, table: Mapping[str, Any], place: Place) -> type:
    kind = table.get(part.by, part.usual or None)
    if name == "fluid" and kind is None:
        kind = "liquid" if table.get("medium") in ("oil", "water") else "adiabatic_wall"
    if kind is None:
        known = ", ".join(part.kinds)
        raise place.refuse((name, part.by), f"missing, write {part.by} = one of {known}.")
    if not isinstance(kind, str):
        rule = f"must be a name in quotes, one of {', '.join(part.kinds)}."
        raise place.refuse((name, part.by), rule)
    if kind not in part.kinds:
        raise place.refuse((name, part.by), f"there is none{nearest(kind, part.kinds)}")
    return part.kinds[kind]

"""Scenario files: from TOML to a plant, its commands or controller, and its initial state."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydantic import BaseModel

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
    Accumulator,
    AdiabaticWall,
    Gas,
    Isothermal,
    Line,
    LiquidChamber,
    OrderlyValve,
    Orifice,
    PumpedAccumulator,
    SonicValve,
    Tank,
    validate_commands,
)
from ..muscle import Muscle
from .errors import FileLocation, check_kind, validate
from .muscle_files import from_dict, load_muscle, loads, parse_file, provenance, read_text
from .scenario_schema import PARTS, PUMPED, choose_schema, pump_class
from .shipped_files import shipped_names, shipped_text
from .table_model import did_you_mean


if TYPE_CHECKING:  # a scenario without control loads none of it
    from ..control import Cascade, Gains, PolicyChoice

MEDIA = {"air": AIR, "nitrogen": NITROGEN, "oil": OIL, "water": WATER}
_MOST_STEPS = 2_000_000
# numbers of a run's results, a gigabyte: what two motor units make in as many steps
_MOST_NUMBERS, _NUMBERS_PER_STEP, _NUMBERS_PER_UNIT = 128_000_000, 40, 12
_DT = 1e-3  # s
_GRID = 1e-6  # of a step, by which a time may miss one: rounding
_GAINS = ("position_gain", "velocity_gain", "force_gain")
_TIMES = ("integral_time", "force_integral_time", "pressure_time")
_SPRINGS = ("stiffness", "slip_force", "slip_force_slope")


class Controlled(NamedTuple):
    """The controller of a scenario.

    - `controller`, `reference`: and its demand at each step [SI].
    - `choice`: the comparison by which `auto` chose the policy, or `None`.
    - `policy`: its name; `options`: the controller's other arguments.
    """

    controller: "Cascade"
    reference: np.ndarray
    choice: "PolicyChoice | None"
    policy: str
    options: Mapping[str, Any]

    @property
    def notes(self) -> tuple[str, ...]:
        """The choice of `auto`, and warnings of likely instability."""
        warnings = tuple(f"{warning}." for warning in self.controller.warnings)
        if self.choice is None:
            return warnings
        return (f"auto took {self.choice.policy}: {self.choice.why}.", *warnings)

    def taking(self, policy: str | None = None, compensate: bool | None = None) -> "Controlled":
        """A copy with another policy, or with or without feedforward of friction.

        **Arguments:**

        - `policy`: `auto` or one of `control.POLICIES`.
        - `compensate`: true to feed friction forward.
        """
        from ..control import POLICIES, cascade, select_policy

        if compensate is not None:
            other = self._replace(options={**self.options, "compensate": compensate})
            return other.taking(policy or self.policy)
        if policy is None:
            return self
        plant, output = self.controller.plant, self.controller.of
        if policy != "auto":
            check_choice(policy, (*POLICIES, "auto"), "policy")
        choice = None
        if policy == "auto":
            choice = select_policy(plant, self.reference, self.options["dt"], output)
            policy = choice.policy
        controller = cascade(plant, policy, output, **self.options)
        return Controlled(controller, self.reference, choice, policy, self.options)


@dataclass(frozen=True, eq=False)
class Scenario:
    """A plant with its commands or controller.

    - `name`, `plant`.
    - `schedule`: of the commands, or `None` if it is `controlled`.
    - `start`: initial state [SI].
    - `dt`, `duration`: step and length of the run [s].
    - `source`: of its figures.
    - `notes`: on what isn't done as it is written.
    - `controlled`: controller and reference, or `None`.
    """

    name: str
    plant: Plant
    schedule: Schedule | None
    start: State
    dt: float
    duration: float
    source: str = ""
    notes: tuple[str, ...] = ()
    controlled: Controlled | None = None

    def taking(self, policy: str | None = None, compensate: bool | None = None) -> "Scenario":
        """Change the policy, or the feedforward of friction.

        **Arguments:**

        - `policy`: its name [-].
        - `compensate`: true to feed friction forward [-].

        **Returns:** the changed copy [SI].

        **Raises:** `InvalidInputError` for another name, and for a scenario without [control].
        """
        if self.controlled is None:
            rule = "needs a scenario with [control]: this one is commanded by a schedule"
            name = "compensate" if policy is None else "policy"
            raise InvalidInputError(name, rule, policy, shown="")
        controlled = self.controlled.taking(policy, compensate)
        return replace(self, controlled=controlled, notes=controlled.notes)

    def run(self) -> Trajectory:
        """Simulate it: the run [SI]."""
        if self.controlled is not None:
            control = self.controlled
            return simulate(
                self.plant, control.controller, control.reference, dt=self.dt, start=self.start
            )
        assert self.schedule is not None
        return simulate(
            self.plant, self.schedule, dt=self.dt, duration=self.duration, start=self.start
        )


def load_scenario(path: str | os.PathLike[str]) -> Scenario:
    """Read a scenario file.

    **Arguments:** `path`: the TOML file [-]; bundles that it names by a path stand beside it.

    **Returns:** the scenario [SI].

    **Raises:** `OSError` if it can't be read; `ValueError`, in one line with path and key, for
    values that aren't valid.
    """
    path = Path(path)
    data = parse_file(read_text(path), str(path))
    return scenario_from_dict(data, str(path), path.parent, path.stem)


def loads_scenario(text: str, source: str = "<text>", folder: Path = Path()) -> Scenario:
    """Read a scenario from text.

    **Arguments:**

    - `text`: the TOML [-].
    - `source`: its name in errors [-].
    - `folder`: where files of bundles stand that it names [-].

    **Returns:** as `load_scenario` [SI].

    **Raises:** as `load_scenario`.
    """
    return scenario_from_dict(parse_file(text, source), source, folder, source)


def scenario_from_dict(data: dict[str, Any], source: str, folder: Path, name: str) -> Scenario:
    """The scenario in a file's tables.

    **Arguments:**

    - `data`: the tables.
    - `source`: the file's name in errors.
    - `folder`: where files of bundles stand that it names.
    - `name`: of the scenario, if the file has none.

    **Returns:** as `load_scenario`.

    **Raises:** as `load_scenario`.
    """
    check_kind(data, "scenario", source)
    whole = FileLocation(source, data, kind="scenario")
    data = _with_measured_friction(data, whole, folder)
    schema, classes = choose_schema(data, whole)
    file = validate(schema, data, source)
    bundles = _bundles(data, source, whole, folder)
    tables = {key: _values(getattr(file, key)) for key in classes}
    units = sum(len(bundle.motor_units) for bundle in bundles)
    sides = 2 if classes["load"] is AntagonisticJoint else 1
    if len(bundles) != sides:
        rule = "must be a list of two for a joint" if sides == 2 else "must be one for this load"
        raise whole.error(("bundle",), f"{rule}, got {len(bundles)}.")
    _check_list_lengths(tables, classes, units, whole)
    medium, room = _medium_and_room(tables["fluid"], classes["fluid"], whole.inner("fluid"))
    parts = _parts(tables, classes, medium, room, units, whole)
    run, run_location = file.run, whole.inner("run", kind="part")
    options = {key: x for key in ("law", "volume") if (x := getattr(run, key)) is not None}
    with whole.error_context():
        plant = Plant(bundles[0] if len(bundles) == 1 else bundles, **parts, **options)
    if not np.subtract(*plant.stroke) < 0:
        rule = "leaves no way on which all muscles' strains are known: check its sizes."
        raise whole.error(("load",), rule)
    dt, duration = _times(run, units, run_location)
    schedule = controlled = None
    if isinstance(data.get("control"), dict):
        supply, pressures = plant.supply_pressure, run.pressures
        if pressures is not None and np.max(pressures) > supply:
            with run_location.error_context():
                rule, highest = f"must be at most the supply's {supply:g} Pa", np.max(pressures)
                shown = f"{highest:g} Pa"
                raise InvalidInputError("pressures", rule, float(highest), shown=shown)
        controlled = _controlled(file, plant, dt, duration, whole)
        notes = controlled.notes
    else:
        schedule, notes = _schedule(file.schedule, plant, dt, duration, whole)
    if plant.load.moved and run.position is not None:
        raise whole.error(("run", "position"), "the load's motion is given: drop this key.")
    # a prescribed motion itself may lead too far
    begins = FileLocation(source, data, kind="moved") if plant.load.moved else whole
    with begins.error_context():
        pressures = 0.0 if run.pressures is None else run.pressures
        start = equilibrium_state(plant, pressures, run.position)
    return Scenario(
        file.name or name,
        plant,
        schedule,
        start,
        dt,
        duration,
        file.source or "",
        notes,
        controlled,
    )


def _with_measured_friction(
    data: dict[str, Any], whole: FileLocation, folder: Path
) -> dict[str, Any]:
    """A scenario's tables, with a calibration's springs in place of `kind = "measured"`.

    The springs of one muscle are read from the file that `muscle` or the scenario's `bundle` names,
    in `folder`. They hold for each of the scenario's muscles. If both branches were one, there is
    no friction, and the scenario has no `[hysteresis]`.
    """
    table = data.get("hysteresis")
    if not isinstance(table, dict) or table.get("kind") != "measured":
        return data
    for key in table:
        if key not in ("kind", "muscle"):
            raise whole.error(("hysteresis", key), "measured: the file of the muscle has it.")
    name = table.get("muscle", data.get("bundle"))
    if not isinstance(name, str) or not (folder / name).is_file():
        rule = 'must name the calibrated muscle\'s file: write muscle = "muscle.toml".'
        raise whole.error(("hysteresis", "muscle"), rule)
    with whole.inner("hysteresis").error_context():
        springs = provenance(folder / name).get("hysteresis")
    kind = springs.get("kind") if isinstance(springs, dict) else None
    rest = {key: value for key, value in data.items() if key != "hysteresis"}
    if kind == "none":
        return rest
    if kind is None or not isinstance(springs, dict) or any(key not in springs for key in _SPRINGS):
        rule = f"{name} has no friction: `fascicle calibrate` finds it in records of both ways."
        raise whole.error(("hysteresis", "kind"), rule)
    return rest | {"hysteresis": {"kind": kind} | {key: springs[key] for key in _SPRINGS}}


def _values(section: BaseModel) -> dict[str, Any]:
    """Values of a table, by key."""
    values = {name: getattr(section, name) for name in type(section).model_fields}
    return {
        name: _values(x) if isinstance(x, BaseModel) else x
        for name, x in values.items()
        if x is not None and name not in ("kind", "chamber")
    }


def _check_list_lengths(
    tables: Mapping[str, Mapping[str, Any]],
    classes: Mapping[str, type],
    units: int,
    whole: FileLocation,
) -> None:
    """Refuse lists that aren't one value for each motor unit, or each spring of the friction."""
    for name, part in PARTS.items():
        if name not in tables or not part.many:
            continue
        springs = classes[name] is MaxwellSlip
        many = np.size(tables[name].get("stiffness", 0)) if springs else units
        for key, value in tables[name].items():
            if isinstance(value, np.ndarray) and len(value) != many:
                what = "springs" if springs else "motor units"
                rule = f"must be one value, or a list of one for each of the {what}, {many}"
                raise whole.error((name, key), f"{rule}, got {len(value)}.")


def _medium_and_room(
    fluid: dict[str, Any], chamber: type, location: FileLocation
) -> tuple[Any, dict[str, Any]]:
    """The fluid, and the room's absolute pressure [Pa] and temperature [K] where they are given."""
    liquid = chamber is LiquidChamber
    name = fluid.pop("medium", None) or ("oil" if liquid else "air")
    with location.error_context():
        medium = MEDIA[check_choice(name, MEDIA, "medium")]
    if liquid == isinstance(medium, Gas):
        kinds = "adiabatic_wall, isothermal or polytropic" if liquid else "liquid"
        what = "gas" if liquid else "liquid"
        raise location.error(("medium",), f"{name} is a {what}: take chamber = {kinds}.")
    if liquid and not np.all(np.asarray(fluid.get("compliance", 0.0)) > 0):
        rule = "must be there and positive for a liquid, which hardly gives way itself: write"
        example = 'compliance = "2e-11 m^3/Pa", of bladder, hose and fittings of each motor unit.'
        raise location.error(("compliance",), f"{rule} {example}")
    keys = ("room_pressure", "room_temperature")
    return medium, {key: fluid[key] for key in keys if key in fluid}


def _bundles(data: dict[str, Any], source: str, whole: FileLocation, folder: Path) -> list[Bundle]:
    names: Any = data.get("bundle")
    if "muscle" in data:
        if not isinstance(names, dict | None):
            raise whole.error(("bundle",), "there is a [muscle], too: keep one of them.")
        inline = {key: data[key] for key in ("format", "muscle", "bundle") if key in data}
        return [_as_bundle(from_dict(inline, source))]
    names = list(names) if isinstance(names, list) else [names]
    if not names or not all(isinstance(name, str) for name in names):
        rule = 'must name a bundle or its file, such as "kim2021_bundle_1_4", or a list of two'
        raise whole.error(("bundle",), f"{rule}; or write [muscle] and [bundle] as in its file.")
    shipped, bundles = shipped_names("examples"), []
    for name in names:
        path = folder / name
        if name not in shipped and not path.exists():
            rule = f"{name!r} is neither a file nor a named example{did_you_mean(name, shipped)}"
            raise whole.error(("bundle",), rule)
        with whole.inner("bundle").error_context():
            if name in shipped:
                bundles.append(_as_bundle(loads(shipped_text("examples", name), name)))
            else:
                bundles.append(_as_bundle(load_muscle(path)))
    return bundles


def _as_bundle(obj: Muscle | Bundle) -> Bundle:
    return obj if isinstance(obj, Bundle) else Bundle([MotorUnit(obj)])


def _parts(
    tables: dict[str, dict[str, Any]],
    classes: Mapping[str, type],
    medium: Any,
    room: dict[str, Any],
    units: int,
    whole: FileLocation,
) -> dict[str, Any]:
    """Parts of the plant by the name of its argument."""
    gas = isinstance(medium, Gas)
    tables["fluid"]["gas" if gas else "liquid"] = medium
    parts: dict[str, Any] = {}
    for key, table in tables.items():
        kind, location = classes[key], whole.inner(key, kind="part")
        for inner, part in (("stop", Stop), ("line", Line)):
            if inner in table:
                with location.inner(inner, kind="part").error_context():
                    table[inner] = part(**table[inner])
        if kind is OrderlyValve:
            table["units"] = units
        if kind is Orifice and not gas:
            table.setdefault("density", float(medium.reference_density))
        if kind is SonicValve and gas and medium is not AIR:
            # the same hole, for another gas
            ratio = AIR.specific_gas_constant / medium.specific_gas_constant
            table.setdefault(
                "reference_density", float(SonicValve(1e-9, 0.3).reference_density * np.sqrt(ratio))
            )
        if key == "supply":
            parts[key] = _supply(table, kind, medium, room, location)
            continue
        with location.error_context():
            parts["chamber" if key == "fluid" else key] = kind(**table)
    return parts


def _supply(
    table: dict[str, Any], kind: type, medium: Any, room: dict[str, Any], location: FileLocation
) -> Any:
    gas = isinstance(medium, Gas)
    if kind in (Accumulator, PumpedAccumulator) and gas:
        raise location.error(("kind",), "it holds a liquid: take constant or tank for a gas.")
    if kind is Tank and not gas:
        rule = "it holds a gas: take constant, accumulator or pumped for a liquid."
        raise location.error(("kind",), rule)
    parts: dict[str, Any] = {}
    if kind is PumpedAccumulator:
        whole = FileLocation(location.source, location.data)
        for key, part in {"pump": pump_class(location.data, whole), **PUMPED}.items():
            if key in table:
                options = table.pop(key) | ({"liquid": medium} if key == "pump" else {})
                with location.inner(key, kind="part").error_context():
                    parts[key] = part(**options)
    with location.error_context():
        if kind is PumpedAccumulator:
            return PumpedAccumulator(Accumulator(**table, liquid=medium, **room), **parts)
        if kind is Accumulator:
            return Accumulator(**table, liquid=medium, **room)
        if kind is Tank:
            wall = table.pop("conductance", None)
            chamber: Any = Isothermal if wall is None else AdiabaticWall
            options = {} if wall is None else {"conductance": wall}
            return Tank(chamber(gas=medium, **options, **room), **table)
        if "room_temperature" in room:
            table.setdefault("supply_temperature", room["room_temperature"])
        around = {key: x for key, x in room.items() if key == "room_pressure"}
        return kind(**table, **around)


def _times(run: Any, units: int, location: FileLocation) -> tuple[float, float]:
    dt, duration = _DT if run.dt is None else run.dt, run.duration
    for key, value, example in (("dt", dt, _DT), ("duration", duration, 10.0)):
        if value <= 0:
            raise location.error((key,), f"must be positive, such as {example:g} s.")
    steps = round(duration / dt)
    if abs(steps - duration / dt) > _GRID * max(1, steps):
        shown = f"{max(steps, 1) * dt:.12g} s"
        raise location.error(("duration",), f"must be whole steps of {dt:g} s: take {shown}.")
    most = min(_MOST_STEPS, _MOST_NUMBERS // (_NUMBERS_PER_STEP + _NUMBERS_PER_UNIT * units))
    if steps > most:
        plant = f" of {units} motor units" if most < _MOST_STEPS else ""
        rule = f"makes {steps} steps of {dt:g} s{plant}, more than {most}: take a longer `dt`."
        raise location.error(("duration",), rule)
    return dt, duration


def _schedule(
    rows: list[Any], plant: Plant, dt: float, duration: float, whole: FileLocation
) -> tuple[Schedule, tuple[str, ...]]:
    if not rows:
        raise whole.error(("schedule",), "is empty: write [[schedule]] with time and command.")
    last, commands, notes = None, [], []
    for index, row in enumerate(rows):
        location = whole.inner("schedule", index)
        if last is None and row.time != 0:
            raise location.error(("time",), "the first must be 0 s.")
        if last is not None and row.time <= last:
            raise location.error(("time",), f"times must rise, it comes after {last:g} s.")
        last = row.time
        many, size = plant.commands, np.size(row.command)
        if size != many and (np.ndim(row.command) or size != 1):
            rule = f"must be one number, or a list of one for each command, {many}"
            raise location.error(("command",), f"{rule}, got {size}.")
        with location.error_context():
            commands.append(np.broadcast_to(validate_commands(row.command), (many,)))
        if row.time >= duration:
            notes.append(
                f"the command at {row.time:g} s never comes: the run ends at {duration:g} s."
            )
        elif abs(row.time / dt - round(row.time / dt)) > _GRID:
            then = dt * np.ceil(row.time / dt)
            notes.append(f"the command at {row.time:g} s comes with the next step, at {then:g} s.")
    times = np.array([row.time for row in rows])
    return Schedule(times, np.array(commands)), tuple(notes)


def _controlled(
    file: Any, plant: Plant, dt: float, duration: float, whole: FileLocation
) -> Controlled:
    from ..control import cascade

    output, reference = _reference(file, dt, duration, whole)
    values = _values(file.control)
    policy = values.pop("policy")
    location = whole.inner("control", kind="part")
    if values.get("delay", 0.0) > duration:
        rule = f"must be at most the run's {duration:g} s, in which nothing would be measured."
        raise location.error(("delay",), rule)
    options = {"gains": _gains(values, location), "dt": dt, **values}
    with location.error_context():
        plain = cascade(plant, "orderly", output, **options)
        return Controlled(plain, reference, None, "orderly", options).taking(policy)


def _gains(values: dict[str, Any], location: FileLocation) -> "Gains":
    """Gains of a controller, taken out of the values of [control]."""
    from ..control import Gains

    for name in _GAINS:
        if values.get(name, 0.0) < 0:
            raise location.error((name,), "must not be below zero.")
    for name in _TIMES:
        if values.get(name, 1.0) <= 0:
            raise location.error((name,), "must be positive; leave it out for none.")
    default = Gains()
    position = values.pop("position_gain", 0.0)
    integral_time = values.pop("integral_time", np.inf)
    force_integral_time = values.pop("force_integral_time", 1 / default.force_integral)
    return Gains(
        position,
        position / integral_time,
        values.pop("velocity_gain", 0.0),
        values.pop("force_gain", default.force),
        1 / force_integral_time,
        values.pop("pressure_time", default.pressure_time),
    )


def _reference(
    file: Any, dt: float, duration: float, whole: FileLocation
) -> tuple[str, np.ndarray]:
    """The controlled output, "force" or "position", and its demand at each step [SI]."""
    time = dt * np.arange(round(duration / dt))
    if (file.demand is None) == (file.sine is None):
        rule = "write [[demand]] with time and force or position, or [sine], one of both."
        raise whole.error(("demand",), rule)
    if file.sine is not None:
        if file.sine.frequency <= 0:
            raise whole.error(("sine", "frequency"), "must be positive.")
        phase = 2 * np.pi * file.sine.frequency * time
        return "position", file.sine.mean + file.sine.amplitude * np.sin(phase)
    if not file.demand:
        raise whole.error(("demand",), "is empty: write [[demand]] with time and force.")
    output = "force" if file.demand[0].force is not None else "position"
    times, values = [], []
    for index, row in enumerate(file.demand):
        location = whole.inner("demand", index)
        if (row.force is None) == (row.position is None) or getattr(row, output) is None:
            raise location.error((output,), "write `force` in each row, or `position` in each.")
        if (not times and row.time != 0) or (times and row.time <= times[-1]):
            raise location.error(("time",), "times must begin at 0 s and rise.")
        times.append(row.time)
        values.append(getattr(row, output))
    return output, np.interp(time, times, values)

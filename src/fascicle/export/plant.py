r"""A functional mock-up unit of a plant, for those who write its controller in another program.

It has what `simulate` moves, by the same table, equations and steps: a bundle, chambers, valves and
a load. Its inputs are the valves' commands, the supply's pressure and a further
force on the load. A supply that empties, friction in the muscles and a joint of two bundles are
refused.

**Step.** A step of the host is divided into equal steps of at most those that `simulate` takes,
short enough for the stiffest part to be stable. Where nothing has a kink their error falls with the
fourth power of the step, far below the table's.
"""

import os
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_positive
from ..dynamics import (
    HangingMass,
    InertiaSpringDamper,
    Plant,
    PrescribedMotion,
    State,
    Stop,
    equilibrium_state,
    estimate_substeps,
)
from ..dynamics.loads import DAMPER_DEPTH
from ..dynamics.muscles import MuscleTables
from ..fluid import (
    AdiabaticWall,
    ConstantSupply,
    Direct,
    Isothermal,
    LiquidChamber,
    Orifice,
    Servovalve,
    Solenoid,
    SonicValve,
)
from ..fluid.fields import ROOM_TEMPERATURE
from ..fluid.flow_elements import LAMINAR_FROM
from .c_files import c_array, check_c_name, render_template
from .c_table import tabulate
from .fmu import FmuVariable, describe_unit, unit_guid, unit_platform, write_unit


_CHAMBERS = {Isothermal: "ISOTHERMAL", AdiabaticWall: "WALL", LiquidChamber: "LIQUID"}
_SPOOLS = {Direct: "DIRECT", Servovalve: "SERVOVALVE", Solenoid: "SOLENOID"}
_LOADS = (HangingMass, InertiaSpringDamper, PrescribedMotion)
_STATUS = (
    "sum of what was met: 1 folded, 2 cavitates, 4 off the table, 8 unsettled pressure,"
    " 16 no supply pressure, 32 at its stop"
)


def write_plant_fmu(
    plant: Plant,
    path: str | os.PathLike[str],
    name: str = "plant",
    start: State | None = None,
    dt: Values = 1e-3,
    platform: str | None = None,
) -> Path:
    """Write a plant as an FMU for co-simulation, to a file whose path it returns.

    **Arguments:**

    - `plant`: one bundle on gas or liquid, with a supply of constant pressure, no friction.
    - `path`: the file, which ends in .fmu.
    - `name`: of the model, a name in C.
    - `start`: the state at the start [SI]; by default, at rest without pressure.
    - `dt`: step suggested to the host [s]; inside it is divided as `simulate` does.
    - `platform`: of the binary, as FMI names it; default: this one.

    **Raises:** `ValueError` for a part that the unit doesn't have, and invalid arguments;
    `UnbuiltUnitError` without a compiler for the platform: the file is written with its sources.
    """
    path, folder = Path(path), unit_platform(platform)
    check_c_name(name)
    step = float(check_positive(dt, "dt", "s", "such as 0.001"))
    _check_parts(plant)
    assert isinstance(plant.muscles, MuscleTables)
    begin = equilibrium_state(plant) if start is None else start
    estimate = estimate_substeps(plant, step)
    if estimate.stiff:
        remedy = f"take a smaller one: {estimate.part} is faster"
        raise InvalidInputError("dt", "must be at most 64 of the stable steps", step, remedy)
    lines, columns = plant.muscles.table.coefficients.shape[-4:-2]
    shape = lines + 1, columns + 1  # nodes, as many as `simulate` has
    top = float(np.max(plant.muscles.highest_pressure))
    tables = tabulate(plant.bundles[0], highest_pressure=top, shape=shape)
    header, table = tables.code(name)
    values = _template_values(plant, begin, step / estimate.substeps)
    values |= {"name": name, "guard": name.upper(), "files": f"{name}.c"}
    values["guid"] = unit_guid(header + table + repr(sorted(values.items())) + __version__)
    values["model"] = render_template("fmu_plant.c", values)
    source = table + render_template("plant.c", values) + render_template("fmu.c", values)
    about = "Fluidic artificial muscles with chambers, valves and a load"
    numbers = plant_variables(plant)
    description = describe_unit(numbers, about, name, values["guid"], step, [f"{name}.c"])
    return write_unit(path, name, folder, {f"{name}.h": header, f"{name}.c": source}, description)


def plant_variables(plant: Plant) -> list[FmuVariable]:
    """The numbers of a plant's FMU, in the order of their references."""
    units = range(1, plant.units + 1)
    text = "from -1, open to the room, to 1, open to the supply"
    inputs = [(f"command_{i}", "1", f"command of unit {i}'s valve, {text}", 0.0) for i in units]
    supply = plant.supply_pressure
    inputs += [("supply_pressure", "Pa", "gauge pressure of the supply", supply)]
    if not plant.load.prescribed:
        inputs += [("load_force", "N", "further force on the load, along position", 0.0)]
    outputs = [
        ("position", "m", "contraction of the bundle"),
        ("velocity", "m/s", "its rate"),
        ("strain", "1", "contraction over the plates' distance at rest"),
        ("force", "N", "force that pulls the plates together"),
    ]
    outputs += [(f"pressure_{i}", "Pa", f"gauge pressure of unit {i}") for i in units]
    outputs += [(f"temperature_{i}", "K", f"temperature of unit {i}'s fluid") for i in units]
    outputs += [("supply_flow", "kg/s", "mass flow from the supply")]
    numbers = [FmuVariable(name, unit, True, text, value) for name, unit, text, value in inputs]
    numbers += [FmuVariable(name, unit, False, text) for name, unit, text in outputs]
    return [*numbers, FmuVariable("status", None, False, _STATUS)]


def _check_parts(plant: Plant) -> None:
    """Refuse a `plant` with a part that the unit doesn't have."""
    supported = {
        "load": _LOADS,
        "supply": (ConstantSupply,),
        "chamber": tuple(_CHAMBERS),
        "valve": (SonicValve, Orifice),
        "exhaust_valve": (SonicValve, Orifice),
        "spool": tuple(_SPOOLS),
        "hysteresis": (type(None),),
        "damping": (type(None),),
        "muscles": (MuscleTables,),
    }
    for part, kinds in supported.items():
        value = getattr(plant, part)
        if not isinstance(value, kinds):
            names = ", ".join(kind.__name__ for kind in kinds).replace("NoneType", "left out")
            rule, kind = "isn't in a plant's FMU", type(value).__name__
            raise InvalidInputError(part, rule, None, f"it must be {names}", shown=kind)


def _template_values(plant: Plant, begin: State, longest_step: float) -> dict[str, object]:
    """Values of the C templates for a `plant` that begins at a state [SI], by steps of at most
    `longest_step` [s].
    """
    chamber, spool, load, units = plant.chamber, plant.spool, plant.load, plant.units
    medium, stop = chamber.liquid if plant.liquid else chamber.gas, load.stop or Stop(-1.0, 1.0)
    states, clocks = np.zeros((units, 2)), np.zeros(units)
    states[:, : chamber.count] = begin.chambers
    clocks[: np.size(begin.spool)] = begin.spool
    rest = getattr(load, "rest", 0.0)
    numbers = {
        "longest_step": longest_step,
        "dead_time": spool.dead_time,
        "plate_length": plant.distances[0],
        "supply_temperature": plant.supply.temperature_at(begin.supply),
        "supply_pressure": plant.supply_pressure,
        "position": begin.position,
        "velocity": begin.velocity,
        "laminar_from": LAMINAR_FROM,
        "reference_temperature": ROOM_TEMPERATURE,
        "damper_depth": DAMPER_DEPTH,
        # the force of a free load is affine in its position: that at its spring's rest, the spring
        "steady_force": load.force(rest),
        "spring_rest": rest,
    }
    rows = {"spools": clocks, "pressures": begin.pressures}
    # what other chambers, spools and loads have is in parts of the template that aren't compiled
    for part, prefix, keys in (
        (chamber, "", "dead_volume room_pressure room_temperature lowest_pressure"),
        (chamber, "", "conductance compliance"),
        (medium, "", "specific_gas_constant heat_capacity_ratio reference_density bulk_modulus"),
        (spool, "", "overlap time_constant period opening_delay closing_delay"),
        (load, "load_", "inertia damping stiffness mean amplitude frequency"),
        (stop, "stop_", "low high stiffness damping"),
    ):
        values = {prefix + key: getattr(part, key, 0.0) for key in keys.split()}
        (numbers if prefix else rows).update(values)
    return {
        "chamber": _CHAMBERS[type(chamber)],
        "spool": _SPOOLS[type(spool)],
        "prescribed": int(load.prescribed),
        "has_stop": int(load.stop is not None),
        "chambers": c_array(states, _number),
        "valves": _valve_arrays(plant),
        **{key: _number(value) for key, value in numbers.items()},
        **{key: c_array(np.broadcast_to(x, units), _number) for key, x in rows.items()},
    }


def _number(value: Any) -> str:
    """Number in C, with all its digits; infinite ones by C's name."""
    return repr(float(value)).replace("inf", "INFINITY")


def _valve_arrays(plant: Plant) -> str:
    """Constants [valve, unit, 5] of both valves of each unit, with their hoses."""
    constants = np.zeros((2, plant.units, 5))
    for rows, valve in zip(constants, (plant.valve, plant.exhaust_valve), strict=True):
        if isinstance(valve, SonicValve):
            rho = valve.reference_density
            columns = [valve.C * rho, valve.b, valve.m]
            if valve.line is not None:
                columns += [valve.line.conductance * rho, valve.line.critical_pressure_ratio]
        else:
            resistance = 1 / (2 * valve.density * (valve.discharge_coefficient * valve.area) ** 2)
            columns = [resistance, valve.critical_pressure_difference, 0.0]
            if valve.line is not None:
                columns += [valve.line.laminar_resistance(valve.density)]
                columns += [valve.line.turbulent_resistance(valve.density)]
        for index, column in enumerate(columns):
            rows[:, index] = column
    return c_array(constants, _number)

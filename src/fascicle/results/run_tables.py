"""Tables of runs in time: outputs, energy ledger, events, control metrics; policies compared."""

from typing import TYPE_CHECKING, Any

import numpy as np

from .labelled import Table, build_table


if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..control import Cascade, ControlMetrics
    from ..dynamics import Audit, Plant, Trajectory

_LEDGER = {
    "supplied": "from the supply", "valve": "lost in valves", "exhaust": "lost in warm exhaust",
    "mixing": "lost in mixing", "wall": "lost through walls", "fluid_work": "on the muscles",
    "mismatch": "error of the volume's integration", "mass": "into the chambers",
    "enthalpy": "into the chambers", "heat": "out through walls",
    "displaced": "absolute, on the muscles", "pull": "on the load",
    "damper": "lost in the damper", "stop": "lost in the stop", "friction": "lost in friction",
    "motor": "of a given motion",
}  # fmt: skip
_METRICS = {
    "drawdown": "deepest fall while the demand didn't fall",
    "dip": "deepest dip of a unit at the strains of the run",
    "rms": "root mean square of the error while the demand was reachable",
    "largest_error": "largest error while the demand was reachable",
    "lag": "delay at which the output follows best",
    "supply_energy": "exergy drawn from the supply",
    "fluid": "drawn from the supply",
    "recruited": "number of recruitments of units",
    "unreachable": "demands that no policy could reach",
    "moments": "demands in all",
    "first": "first unreachable demand",
    "last": "last unreachable demand",
    "short": "largest force or moment that an unreachable demand lacks",
}
_STORES = {"fluid": "exergy of a gas, energy of a liquid", "muscles": "in the muscles",
           "motion": "kinetic", "load": "potential", "stop": "in the stop's springs",
           "friction": "in friction's springs"}  # fmt: skip


def simulated(
    plant: "Plant",
    run: "Trajectory",
    audit: "Audit | None" = None,
    controller: "Cascade | None" = None,
    reference: Any = None,
) -> Table:
    """A run, a moment a row, and its balances.

    **Arguments:**

    - `plant`: that ran.
    - `run`: one run, not a batch of them.
    - `audit`: of the run; default: the table has events, but no balances.
    - `controller`: of the run, from `control.cascade`, if there is one.
    - `reference`: demand of the controlled output at each step [SI].

    **Returns:** a table: quantities over `time`, the remainder of each `balance`, the `event`s, and
    the control metrics.
    """
    from ..dynamics import events
    from ..dynamics.energy_ledger import LEDGER, STORES
    from ..dynamics.outputs import STATUS

    outputs, unit = run.outputs, plant.load.unit
    bits = ", ".join(f"{1 << index} {name}" for index, name in enumerate(STATUS))
    columns = (
        ("pressure", outputs.pressures, "Pa", "gauge, in each unit's chamber"),
        ("temperature", outputs.temperatures, "K", "in each unit's chamber"),
        ("strain", outputs.strains, "-", "contraction over length at rest"),
        ("force", outputs.forces, "N", "pulling force of the unit's muscles together"),
        ("volume", outputs.volumes, "m³", "of fluid in the unit's muscles, without dead volume"),
        ("fluid_mass", outputs.masses, "kg", "in each unit's chamber"),
        ("supply_opening", outputs.supply, "-", "share of the valve open to the supply"),
        ("exhaust_opening", outputs.exhaust, "-", "share of the valve open to the room"),
        ("drawn", outputs.drawn, "kg/s", "flow from the supply into the chamber"),
        ("vented", outputs.vented, "kg/s", "flow from the chamber to the room"),
    )
    rows: list[tuple] = [
        ("time", "time", run.time, "s", "from the start"),
        ("position", "time", outputs.position, unit, "of the load, rising in contraction"),
        ("velocity", "time", outputs.velocity, f"{unit}/s", "of the load"),
        ("motor_unit", "motor_unit", np.arange(plant.units) + 1, "-", "in the recruitment order"),
        ("bundle", "motor_unit", np.asarray(plant.sides) + 1, "-", "to which the unit belongs"),
        ("muscles", "motor_unit", plant.counts, "-", "in the unit"),
        *(
            (name, "time motor_unit", np.broadcast_to(x, (len(run.time), plant.units)), *texts)
            for name, x, *texts in columns
        ),
        ("supply_pressure", "time", outputs.supply_pressure, "Pa", "gauge"),
        ("valve", "valve", np.arange(run.commands.shape[-1]) + 1, "-", "that has a command"),
        ("command", "time valve", run.commands, "-", "until the next step"),
        ("status", "time", outputs.status, "-", f"sum of the flags {bits}"),
    ]
    if controller is not None:
        rows += _tracking_rows(controller, run, reference)
    for name, energy in zip(LEDGER, np.asarray(run.ledger).T, strict=True):
        about = f"cumulative: {_LEDGER[name]}"
        rows.append((f"account_{name}", "time", energy, "kg" if name == "mass" else "J", about))
    for name, energy in zip(STORES, np.asarray(outputs.store).T, strict=True):
        rows.append((f"stored_{name}", "time", energy, "J", f"stored: {_STORES[name]}"))
    if audit is not None:
        names, left, share, within, closes = (
            [getattr(balance, name) for balance in audit.balances]
            for name in ("name", "left", "share", "closes_within", "closes")
        )
        rows += [
            ("balance", "balance", names, "-", "balanced quantity"),
            ("left_over", "balance", left, "J", "in kg of the fluid's mass"),
            ("left_over_share", "balance", share, "-", "of the largest term"),
            ("closes_within", "balance", within, "-", "largest share of a balance that closes"),
            ("closes", "balance", closes, "-", "true if the balance closes"),
        ]
    names, first, last, trusted = (
        np.array([getattr(event, name) for event in events(run)], kind)
        for name, kind in (("name", str), ("first", float), ("last", float), ("trusted", bool))
    )
    about = "true if the run can be trusted all the same"
    return build_table(
        *rows,
        ("event", "event", names, "-", "event in the run"),
        ("event_first", "event", first, "s", "first time"),
        ("event_last", "event", last, "s", "last time"),
        ("event_trusted", "event", trusted, "-", about),
    )


def policy_table(
    controllers: "Mapping[str, Cascade]", metrics: list["ControlMetrics"], closes: Any
) -> Table:
    """Compare policies.

    **Arguments:**

    - `controllers`: by the name of the policy.
    - `metrics`: of each one's run.
    - `closes`: flags of runs whose energy balance closes.

    **Returns:** a table, a policy a row, with the front of drawdown against supply energy.
    """
    from ..control import front

    best = front([x.drawdown for x in metrics], [x.supply_energy for x in metrics])
    about = "true if no other policy has a smaller drawdown at no more energy, or the reverse"
    return build_table(
        ("policy", "policy", list(controllers), "-", "order of recruitment in time"),
        *_metric_rows(next(iter(controllers.values())), metrics, "policy"),
        ("on_front", "policy", best, "-", about),
        ("trusted", "policy", closes, "-", "true if its balances close"),
    )


def _tracking_rows(controller: "Cascade", run: "Trajectory", reference: Any) -> list[tuple]:
    """Demand, reachability and control metrics; the last step's demand is held at the end."""
    from ..control import control_metrics, controlled_output, reachability

    unit, force = _units(controller)
    reach = reachability(controller, run.outputs, reference)
    demand, reachable, lacking = (
        np.append(values, values[-1])
        for values in (np.asarray(reference, float), reach.can, reach.short)
    )
    output = controlled_output(controller, run)
    return [
        ("demand", "time", demand, unit, f"of {controller.of}, until the next step"),
        ("controlled", "time", output, unit, f"controlled {controller.of}"),
        ("reachable", "time", reachable, "-", "true if the muscles can reach the demand"),
        ("short", "time", lacking, force, "part of the demand that the muscles lack"),
        *_metric_rows(controller, [control_metrics(controller, run, reference)], ""),
    ]


def _metric_rows(controller: "Cascade", metrics: list["ControlMetrics"], dims: str) -> list[tuple]:
    """Control metrics of one run, or of several along the dimension `dims`."""
    unit, force = _units(controller)
    units = {
        "drawdown": unit, "dip": "N", "rms": unit, "largest_error": unit, "lag": "s",
        "supply_energy": "J", "fluid": "kg", "first": "s", "last": "s", "short": force,
    }  # fmt: skip
    rows = []
    for name, about in _METRICS.items():
        values = [getattr(run, name) for run in metrics]
        rows.append(
            (f"control_{name}", dims, values if dims else values[0], units.get(name, "-"), about)
        )
    return rows


def _units(controller: "Cascade") -> tuple[str, str]:
    """Units of the controlled output, and of its forces."""
    unit = controller.plant.load.unit
    force = "N·m" if unit == "rad" else "N"
    return (unit if controller.of == "position" else force), force

"""Tables of runs in time: outputs, energy ledger, events, control metrics; policies compared."""

from typing import TYPE_CHECKING, Any

import numpy as np

from .labelled import Table, Variable


if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..control import Cascade, ControlMetrics
    from ..dynamics import Audit, Plant, Trajectory

_LAST = {
    "supplied": "from the supply", "valve": "lost in valves", "exhaust": "lost in warm exhaust",
    "mixing": "lost in mixing", "wall": "lost through walls", "fluid_work": "on the muscles",
    "mismatch": "made by the volume", "mass": "into the chambers",
    "enthalpy": "into the chambers", "heat": "out through walls",
    "displaced": "absolute, on the muscles", "pull": "on the load",
    "damper": "lost in the damper", "stop": "lost in the stop", "friction": "lost in friction",
    "motor": "of a given motion",
}  # fmt: skip
_METRICS = {
    "drawdown": "deepest fall while the demand didn't fall",
    "dip": "deepest dip of a unit at the strains that were passed",
    "rms": "root mean square of the error, where it could be reached",
    "largest_error": "largest error, where it could be reached",
    "lag": "by which it follows best",
    "supply_energy": "exergy that was drawn from the supply",
    "fluid": "that was drawn from the supply",
    "recruited": "how often a unit was",
    "unreachable": "demands that no policy could reach",
    "moments": "demands in all",
    "first": "unreachable demand",
    "last": "unreachable demand",
    "short": "largest force or moment that an unreachable demand lacks",
}
_STORED = {"fluid": "exergy of a gas, energy of a liquid", "muscles": "in the muscles",
           "motion": "kinetic", "load": "potential", "stop": "in the stop's springs",
           "friction": "in friction's springs"}  # fmt: skip


def simulated(
    plant: "Plant",
    run: "Trajectory",
    found: "Audit | None" = None,
    controller: "Cascade | None" = None,
    reference: Any = None,
) -> Table:
    """A run, a moment a row, and its balances.

    **Arguments:**

    - `plant`: that ran [-].
    - `run`: one run, not a batch of them [SI].
    - `found`: its `audit` [-]; left out, the table has no balances, but still says what happened.
    - `controller`: that it was run with, of `control.cascade` [-], or none.
    - `reference`: what was demanded of it, one for each step [SI].

    **Returns:** a table [-]: with `time` everything that changes, with `balance` what is left over
    of each, with `event` what happened; and what control was worth.
    """
    from ..dynamics import events

    seen, unit = run.seen, plant.load.unit
    n = plant.units

    def now(values: Any, unit: str, about: str) -> Variable:
        return Variable(("time",), np.asarray(values), unit, about)

    def each(values: Any, unit: str, about: str) -> Variable:
        shape = (len(run.time), n)
        return Variable(
            ("time", "motor_unit"), np.broadcast_to(np.asarray(values), shape), unit, about
        )

    side = np.asarray(plant.sides) + 1
    counted = np.arange(1, n + 1)
    command = np.arange(1, run.commands.shape[-1] + 1)
    return Table(
        {
            "time": now(run.time, "s", "from the start"),
            "position": now(seen.position, unit, "of the load, rising as the bundle contracts"),
            "velocity": now(seen.velocity, f"{unit}/s", "of the load"),
            "motor_unit": Variable(("motor_unit",), counted, "-", "in the order of recruitment"),
            "bundle": Variable(("motor_unit",), side, "-", "to which the unit belongs"),
            "muscles": Variable(("motor_unit",), plant.counts, "-", "in the unit"),
            "pressure": each(seen.pressures, "Pa", "gauge, in each unit's chamber"),
            "temperature": each(seen.temperatures, "K", "in each unit's chamber"),
            "strain": each(seen.strains, "-", "contraction over length at rest"),
            "force": each(seen.forces, "N", "pulling force of the unit's muscles together"),
            "volume": each(
                seen.volumes, "m³", "of fluid in the unit's muscles, without dead volume"
            ),
            "fluid_mass": each(seen.masses, "kg", "in each unit's chamber"),
            "supply_opening": each(seen.supply, "-", "share of the valve open to the supply"),
            "exhaust_opening": each(seen.exhaust, "-", "share of the valve open to the room"),
            "drawn": each(seen.drawn, "kg/s", "flow from the supply into the chamber"),
            "vented": each(seen.vented, "kg/s", "flow from the chamber to the room"),
            "supply_pressure": now(seen.supply_pressure, "Pa", "gauge"),
            "valve": Variable(("valve",), command, "-", "that has a command"),
            "command": Variable(
                ("time", "valve"), np.asarray(run.commands), "-", "held from then on"
            ),
            "status": now(seen.status, "-", _bits()),
            **({} if controller is None else _tracking_variables(controller, run, reference)),
            **_energies(run),
            **_balances(found),
            **_events(events(run)),
        }
    )


def _bits() -> str:
    from ..dynamics.outputs import STATUS

    listed = ", ".join(f"{1 << place} {name}" for place, name in enumerate(STATUS))
    return f"sum of what holds: {listed}"


def _energies(run: "Trajectory") -> dict[str, Variable]:
    from ..dynamics.energy_ledger import LEDGER, STORES

    account = {
        f"account_{name}": Variable(
            ("time",), np.asarray(run.account)[:, place], "kg" if name == "mass" else "J",
            f"up to then: {_LAST[name]}",
        )
        for place, name in enumerate(LEDGER)
    }  # fmt: skip
    store = np.asarray(run.seen.store)
    return account | {
        f"stored_{name}": Variable(("time",), store[:, place], "J", f"stored: {_STORED[name]}")
        for place, name in enumerate(STORES)
    }


def _balances(found: "Audit | None") -> dict[str, Variable]:
    if found is None:
        return {}
    every = found.balances

    def each(values: Any, unit: str, about: str) -> Variable:
        return Variable(("balance",), np.array(values), unit, about)

    return {
        "balance": each([one.name for one in every], "-", "what is balanced"),
        "left_over": each([one.left for one in every], "J", "in kg of the fluid's mass"),
        "left_over_share": each([one.share for one in every], "-", "of the largest term"),
        "closes_within": each([one.closes_within for one in every], "-", "share that is let pass"),
        "closes": each([one.closes for one in every], "-", "whether it does"),
    }


def _events(happened: Any) -> dict[str, Variable]:
    def each(values: Any, unit: str, about: str, kind: Any = None) -> Variable:
        return Variable(("event",), np.array(values, kind), unit, about)

    return {
        "event": each([one.name for one in happened], "-", "what happened", str),
        "event_first": each([one.first for one in happened], "s", "when first", float),
        "event_last": each([one.last for one in happened], "s", "when last", float),
        "event_trusted": each(
            [one.trusted for one in happened], "-", "whether the run can be trusted all the same",
            bool,
        ),
    }  # fmt: skip


def _tracking_variables(
    controller: "Cascade", run: "Trajectory", reference: Any
) -> dict[str, Variable]:
    """Demand, reachability and control metrics; the last step's demand is held at the end."""
    from ..control import control_metrics, controlled_output, reachability

    unit, force = _units(controller)
    reach = reachability(controller, run.seen, reference)

    def now(values: Any, unit: str, about: str) -> Variable:
        return Variable(("time",), np.append(values, values[-1]), unit, about)

    pulled = Variable(
        ("time",), controlled_output(controller, run), unit, f"{controller.of} that is controlled"
    )
    return {
        "demand": now(np.asarray(reference, float), unit, f"of {controller.of}, from then on"),
        "controlled": pulled,
        "reachable": now(reach.can, "-", "whether the muscles could do it"),
        "short": now(reach.short, force, "what they lack of it"),
        **_metric_variables(controller, [control_metrics(controller, run, reference)], ()),
    }


def _metric_variables(
    controller: "Cascade", metrics: list["ControlMetrics"], dims: tuple[str, ...]
) -> dict[str, Variable]:
    """Control metrics of a run, or of runs along the dimension in `dims`."""
    unit, force = _units(controller)
    units = {
        "drawdown": unit, "dip": "N", "rms": unit, "largest_error": unit, "lag": "s",
        "supply_energy": "J", "fluid": "kg", "first": "s", "last": "s", "short": force,
    }  # fmt: skip
    return {
        f"control_{name}": Variable(
            dims,
            np.array([getattr(x, name) for x in metrics]) if dims else getattr(metrics[0], name),
            units.get(name, "-"), f"{name if name in ('first', 'last') else ''} {words}".strip(),
        )
        for name, words in _METRICS.items()
    }  # fmt: skip


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

    dims, first = ("policy",), next(iter(controllers.values()))
    best = front([x.drawdown for x in metrics], [x.supply_energy for x in metrics])
    return Table(
        {
            "policy": Variable(dims, np.array(list(controllers)), "-", "which units are fed, when"),
            **_metric_variables(first, metrics, dims),
            "on_front": Variable(
                dims, best, "-", "whether none dips less and takes no more energy, or the reverse"
            ),
            "trusted": Variable(dims, np.array(closes), "-", "whether its balances close"),
        }
    )


def _units(controller: "Cascade") -> tuple[str, str]:
    """Units of the controlled output, and of its forces."""
    turns = controller.plant.load.unit == "rad"
    force = "N·m" if turns else "N"
    return (controller.plant.load.unit if controller.of == "position" else force), force

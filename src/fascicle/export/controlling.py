"""A cascade's step in C: what it needs beside the muscles' tables.

What can be written without Python is the smallest set that controls a bundle's force: recruitment
in turn, by the policies "orderly" and "threshold", pressures by the branches' inverse (K1), valves
by (K3), and the force's integral with its anti-windup, on gas. A loop of position is for any
controller to close around it.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..control import Cascade
from ..control.branches import Branches
from ..control.sequential_policies import SequentialPolicy
from ..core.errors import InvalidInputError
from ..dynamics import Plant
from ..dynamics.muscles import Tables
from ..fluid import AdiabaticWall, Isothermal, Polytropic, SonicValve
from ..fluid.fields import ROOM_TEMPERATURE
from ..fluid.flow_elements import LAMINAR_FROM


_CHAMBERS = (Isothermal, AdiabaticWall, Polytropic)


def on_table(controller: Cascade, shape: tuple[int, int]) -> Cascade:
    """The controller that C computes.

    **Arguments:**

    - `controller`: a `Cascade` of force, "orderly" or "threshold", of one bundle on gas [-].
    - `shape`: nodes of the muscles' tables in pressure and strain [-].

    **Returns:** the same one on these tables, that acts at each of its samples [-].

    **Raises:** `ValueError` for a controller whose step can't be written as C.
    """
    plant = checked(controller).plant
    supply = plant.supply_pressure
    top = float(np.max(plant.muscles.highest_pressure))
    muscles = [unit.muscle for unit in plant.bundles[0].motor_units]
    branches = Branches.tabulated(Tables.from_muscles(muscles, top, shape), supply)
    units = (replace(controller.units[0], branches=branches),)
    return replace(controller, units=units, dt=controller.dt * controller.every, every=1)


def checked(controller: Cascade) -> Cascade:
    """A `controller` [-] as it is [-], refused where its step can't be written as C."""
    plant = controller.plant
    no = (
        (len(plant.bundles) > 1, "has two bundles", "each of a joint's takes one of its own"),
        (controller.of != "force", "is of position", "close that loop around one of force"),
        (plant.liquid, "is of a liquid", "only gas has been written as C yet"),
        (not isinstance(plant.chamber, _CHAMBERS), "has a chamber of another kind", ""),
        (controller.delay > 0, "has a delay", "leave it out: what C measures is late by itself"),
        (_policy(controller) is None, "has a policy of another kind", "take orderly or threshold"),
    )
    for true, what, remedy in no:
        if true:
            raise InvalidInputError("controller", f"can't be written as C: it {what}", None, remedy)
    return controller


def words(controller: Cascade, number: Any) -> dict[str, Any]:
    """Entries of the C template for a `controller` on its table; `number` formats one number."""
    units, gains = controller.units[0], controller.gains
    branches, count = units.branches, units.many
    policy = controller.policies[0]
    chamber, room = units.chamber, units.chamber.room_pressure
    temperature = float(chamber.room_temperature)
    supplied = float(units.supply_temperature)

    def row(values: Any) -> str:
        return ", ".join(number(x) for x in np.broadcast_to(np.asarray(values, float), (count,)))

    def rows(values: np.ndarray) -> str:
        if values.ndim == 1:
            return "{" + ", ".join(number(x) for x in values) + "}"
        return "{" + ",\n".join(map(rows, values)) + "}"

    dense = np.broadcast_to(chamber.gas.density(np.asarray(room), temperature), (count,))
    soft = 1 / np.asarray(getattr(chamber, "exponent", 1.0))
    return {
        "policy": _policy(controller),
        "shares": branches.pressures.shape[-1] - 1,
        "onsets": ",\n".join(rows(np.asarray(value)) for value in branches.onsets),
        "branches": ",\n".join(rows(np.asarray(value)) for value in branches.pressures),
        "branch_top": number(branches.top),
        "highest_pressure": number(controller.highest_pressure),
        "dt": number(controller.dt * controller.every),
        "force_gain": number(gains.force),
        "force_integral": number(gains.force_integral),
        "pressure_time": number(gains.pressure_time),
        "flow_limit": number(controller.flow_limit),
        "band": number(policy.band),
        "parked": int(float(policy.parked) > 0),
        "room": row(room),
        "dead": row(chamber.dead_volume),
        "dense": row(dense),
        "softness": row(soft),
        "supply_valve": rows(_valve(units.valve, (supplied, temperature), count))[1:-1],
        "exhaust_valve": rows(_valve(units.exhaust_valve, (temperature, temperature), count))[1:-1],
        "linear": number(LAMINAR_FROM),
        "half": number(0.5),
        "strained": number(1e-4),
        "trickle": number(1e-9),
        "nearly": number(1e-9),
        "pow": "powf" if number(0.5).endswith("f") else "pow",
    }  # fmt: skip


def bundle_of(plant: Plant) -> Any:
    """The one bundle of a `plant` [-]; `ValueError` where there are two."""
    if len(plant.bundles) > 1:
        raise InvalidInputError(
            "plant", "must have one bundle", len(plant.bundles), "write each by itself"
        )
    return next(iter(plant.bundles))


def _policy(controller: Cascade) -> str | None:
    policy = next(iter(controller.policies))
    if not isinstance(policy, SequentialPolicy) or float(policy.early) or float(policy.wide):
        return None
    return "threshold" if float(policy.parked) else "orderly"


def _valve(valve: SonicValve, temperatures: tuple[float, float], count: int) -> np.ndarray:
    """Of each unit's valve [unit, way, 3], with its hose, onward and back."""
    code = np.empty((count, 2, 3))
    for back, T in enumerate(temperatures):
        C, b = valve._passage(np.array(not back), 1.0)
        code[:, back, 0] = C * valve.reference_density * np.sqrt(ROOM_TEMPERATURE / T)
        code[:, back, 1], code[:, back, 2] = b, valve.m
    return code

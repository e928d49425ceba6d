"""A cascade's step in C: its constants besides the muscles' tables.

C covers the smallest set that controls a bundle's force: recruitment by the policies "orderly",
"threshold" and "hand_over", pressures by the branches' inverse (K1), valves by (K3), the observer
of (K2a), and the force's integral with its anti-windup, on gas. Any controller can close a loop of
position around it.
"""

from collections.abc import Callable, Mapping

import attrs
import numpy as np

from ..bundle import Bundle
from ..control import Cascade
from ..control.branches import Branches
from ..control.controller import RATE_FILTER
from ..control.policies import TOLERANCE, HandOverPolicy, SequentialPolicy
from ..control.units import ABOVE, CHORD, CLOSE, LATE, SLACK
from ..core.errors import InvalidInputError
from ..core.types import Numbers
from ..dynamics import Plant
from ..dynamics.muscles import MuscleTables
from ..fluid import AdiabaticWall, Isothermal, SonicValve
from ..fluid.fields import ROOM_TEMPERATURE
from ..fluid.flow_elements import LAMINAR_FROM
from .c_files import c_array, render_template, table_strains


# chambers whose content the C code computes
_CHAMBERS = (Isothermal, AdiabaticWall)
# of one controller, in a test: without a compiler there is no figure of each one's own
ROUNDED_COMMANDS = """
Its valves' commands are off by up to 5e-4 of a full opening, measured against double precision
in 20 random ramps of "hand_over" for one and four muscles, at equal measurements."""


def tabulate_controller(controller: Cascade, shape: tuple[int, int]) -> Cascade:
    """Copy of a `Cascade` of force, of one bundle on gas, for C: its branches tabulated anew
    at `shape` (pressure, strain), its own period as the step. `ValueError` for a controller whose
    step can't be written as C.
    """
    if not isinstance(controller, Cascade):
        rule, kind = "must be a Muscle, a Bundle, a Joint or a Cascade", type(controller).__name__
        raise InvalidInputError("target", rule, None, shown=kind)
    plant = controller.plant
    limitations = (
        (len(plant.bundles) > 1, "has two bundles", "write a controller for each of a joint's"),
        (controller.of != "force", "is of position", "close that loop around one of force"),
        (plant.liquid, "is of a liquid", "use gas"),
        (not isinstance(plant.chamber, _CHAMBERS), "has a chamber that C doesn't have", ""),
        (not _c_policy(controller), "has a policy that C doesn't have", "don't use batch"),
    )
    for is_violated, reason, remedy in limitations:
        if is_violated:
            rule = f"can't be written as C: it {reason}"
            raise InvalidInputError("controller", rule, None, remedy)
    muscles = [unit.muscle for unit in plant.bundles[0].motor_units]
    strains = table_strains(plant.bundles[0])
    tables = MuscleTables.from_muscles(muscles, plant.supply_pressure, shape, strains)
    branches = Branches.tabulated(tables, plant.supply_pressure)
    units = (attrs.evolve(controller.units[0], branches=branches),)
    return attrs.evolve(controller, units=units, dt=controller.dt * controller.every, every=1)


def template_values(
    controller: Cascade, names: dict[str, str], number: Callable[[float], str]
) -> Mapping[str, object]:
    """Values of the C template for a controller on its table, besides the `names`; `number` formats
    one number.
    """
    units, gains, policy = controller.units[0], controller.gains, controller.policies[0]
    branches, chamber, count = units.branches, units.chamber, units.count
    temperature = float(chamber.room_temperature)
    density = chamber.gas.density(np.asarray(chamber.room_pressure), temperature)

    def initializers(values: Numbers) -> str:
        return c_array(np.broadcast_to(np.asarray(values, float), (count,)), number)

    def valve(valve: SonicValve, temperatures: tuple[float, float]) -> str:
        """Constants [unit, direction, 3] of each unit's valve with its hose, forward and back."""
        constants = np.empty((count, 2, 3))
        for back, T in enumerate(temperatures):
            C, b = valve.hose_series(np.array(not back), 1.0)
            constants[:, back, 0] = C * valve.reference_density * np.sqrt(ROOM_TEMPERATURE / T)
            constants[:, back, 1], constants[:, back, 2] = b, valve.m
        return c_array(constants, number)

    dt, observer = float(controller.dt * controller.every), float(gains.observer_time)
    values = {
        "branch_count": len(branches.onsets),
        "branch_of": c_array(np.asarray(branches.muscles.indices)),
        "policy": _c_policy(controller),
        "shares": branches.pressures.shape[-1] - 1,
        "onsets": c_array(branches.onsets, number),
        "branches": c_array(branches.pressures, number),
        "branch_top": number(branches.top),
        "highest_pressure": number(controller.highest_pressure),
        "dt": number(dt),
        "observed": number(dt / (dt + observer)),
        "filtered": number(dt / (dt + RATE_FILTER)),
        "dips": c_array(branches.dips, number),
        "dip_pressures": c_array(branches.dip_pressures, number),
        "correction": number(gains.pressure_time + (observer if np.isfinite(observer) else 0.0)),
        "tolerance": number(TOLERANCE),
        "slack": number(SLACK),
        "near_supply": number(CLOSE),
        "chord": number(CHORD),
        "late": number(LATE),
        "force_gain": number(gains.force),
        "force_integral": number(gains.force_integral),
        "pressure_time": number(gains.pressure_time),
        "flow_limit": number(controller.flow_limit),
        "band": number(policy.band),
        "above": number(ABOVE),
        "parked": int(_c_policy(controller) == "threshold"),
        "room": initializers(chamber.room_pressure),
        "dead": initializers(chamber.dead_volume),
        "dense": initializers(density),
        "supply_valve": valve(units.valve, (float(units.supply_temperature), temperature)),
        "exhaust_valve": valve(units.exhaust_valve, (temperature, temperature)),
        "linear": number(LAMINAR_FROM),
    }
    file = "policy_hand_over.c" if values["policy"] == "hand_over" else "policy_in_turn.c"
    return {**values, "policy_code": render_template(file, names | values)}


def single_bundle(plant: Plant) -> Bundle:
    """The bundle of a plant; `ValueError` if there are two."""
    if len(plant.bundles) > 1:
        count, remedy = len(plant.bundles), "write each by itself"
        raise InvalidInputError("plant", "must have one bundle", count, remedy)
    return next(iter(plant.bundles))


def _c_policy(controller: Cascade) -> str | None:
    """Name of the controller's policy in C; `None` for one that C doesn't have."""
    policy = next(iter(controller.policies))
    if isinstance(policy, HandOverPolicy):
        return "hand_over"
    if not isinstance(policy, SequentialPolicy):
        return None
    return "threshold" if float(policy.parks) else "orderly"

"""Policies by name, and controllers with them."""

import warnings
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import attrs
import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_choice, check_interval, check_positive
from ..dynamics import Plant, PrescribedMotion
from .controller import DAMPED, FASTEST, OBSERVER, Cascade, Gains, valve_lag
from .crossings import Crossing, Path, crossing
from .sequential_policies import hand_over, orderly, threshold
from .simultaneous_policies import batch
from .units import ControlledUnits


POLICIES: Mapping[str, Callable[[Any], Any]] = MappingProxyType({
    "orderly": orderly,
    "batch": batch,
    "threshold": threshold,
    "hand_over": hand_over,
})  # fmt: skip
OF = ("force", "position")  # values of the argument `of`
_SAMPLES = 401  # of a reference: steps of a quarter of a percent
_BAND = 0.02  # of the largest unit's force at rest: more than noise


def cascade(
    plant: Plant,
    policy: str,
    of: str = "force",
    gains: Gains = Gains(),  # noqa: B008 a tuple of numbers
    band: Values = None,
    dt: Values = 1e-3,
    sample_time: Values = None,
    delay: Values = 0.0,
    highest_pressure: Values = None,
    flow_limit: Values = 1.0,
    compensate: bool = False,
    co_contraction: Values = 0.0,
) -> Cascade:
    """Controller of a plant, as `simulate` takes it.

    **Arguments:**

    - `plant`: the plant, which is its model, too.
    - `policy`: name of the policy, one of `POLICIES`.
    - `of`: quantity of the reference, "force" or "position".
    - `gains`: of the cascade, `Gains` [SI], none below zero; a `pressure_time` too fast for the
      plant raises a warning.
    - `band`: decrease of the demand before a unit is vented [N]; left out, 2 % of the largest
      unit's force at rest.
    - `dt`: the simulation's step [s].
    - `sample_time`: period of its commands [s], whole steps; left out, each step.
    - `delay`: dead time of the bench's valves and measurements [s]. It is declared, for a
      `pressure_time` that fits, and adds none; the lag of valves is the plant's.
    - `highest_pressure`: of its targets [Pa]; left out, the supply's.
    - `flow_limit`: largest opening of a valve [-].
    - `compensate`: feedforward of the plant's friction.
    - `co_contraction`: of each of a joint's bundles [N].

    **Raises:** `InvalidInputError` for arguments that don't fit.
    """
    policy_with_band = POLICIES[check_choice(policy, POLICIES, "policy")]
    check_choice(of, OF, "of")
    if of == "position" and isinstance(plant.load, PrescribedMotion):
        raise InvalidInputError("of", "must be force where the motion is given", of)
    closed = (True, False)
    for name, value in gains._asdict().items():
        if name not in ("pressure_time", "observer_time"):
            check_interval(value, 0.0, np.inf, f"{name} gain", "SI", closed=closed)
    step = float(check_positive(dt, "dt", "s", "such as 0.001"))
    period = check_positive(step if sample_time is None else sample_time, "sample_time", "s")
    period_steps = _whole_steps(period, step, "sample_time")
    dead_time = check_interval(delay, 0.0, np.inf, "delay", "s", closed=closed)
    supply = plant.supply_pressure
    highest = float(check_interval(
        supply if highest_pressure is None else highest_pressure, 0.0, supply, "highest_pressure",
        "Pa", "of the supply", (False, True),
    ))  # fmt: skip
    limit = check_interval(flow_limit, 0.0, 1.0, "flow_limit", "-", closed=(False, True))
    units = tuple(ControlledUnits.from_plant(plant, side) for side in range(len(plant.bundles)))
    if band is None:
        zeros = [np.zeros(bundle.count) for bundle in units]
        blocked = [
            x.counts * x.branches.force(supply + z, z) for x, z in zip(units, zeros, strict=True)
        ]
        band = _BAND * float(np.max(np.concatenate(blocked)))
    policies = tuple(policy_with_band(band) for _ in units)
    for rule, bundle in zip(policies, units, strict=True):
        rule.begin(bundle)
    derived = gains.pressure_time is None
    pressure_time = FASTEST if derived else gains.pressure_time
    pressure_time = check_positive(pressure_time, "pressure_time", "s")
    observer = gains.observer_time
    if observer is None:
        observer = OBSERVER if policy == "hand_over" else np.inf
    observer = check_interval(observer, 0.0, np.inf, "observer_time", "s", closed=(False, True))
    gains = gains._replace(pressure_time=pressure_time, observer_time=observer)
    gains = Gains(*map(np.float64, gains))
    tension = check_interval(co_contraction, 0.0, np.inf, "co_contraction", "N", closed=closed)
    controller = Cascade(
        plant, units, policies, gains, np.float64(highest), np.float64(limit),
        plant.hysteresis if compensate else None, np.float64(tension), np.float64(dead_time),
        np.float64(step), of, period_steps,
    )  # fmt: skip
    if derived:
        pressure_time = np.float64(max(FASTEST, DAMPED * controller.lateness))
        return attrs.evolve(controller, gains=gains._replace(pressure_time=pressure_time))
    for warning in controller.warnings:
        warnings.warn(f"{warning}.", stacklevel=2)
    return controller


def _whole_steps(value: Any, dt: float, name: str) -> int:
    """Number of steps of `dt` [s] in a `value` [s], refused unless it is whole and 1 or more."""
    steps = round(float(value) / dt)
    # whole but for the rounding of numbers in a file
    if steps < 1 or abs(steps - float(value) / dt) > 1e-6 * steps:
        rule = f"must be whole steps of {dt:g} s"
        raise InvalidInputError(name, rule, float(value), shown=f"{float(value):g} s")
    return steps


def crossings_on_reference(
    plant: Plant, reference: Values, dt: float, of: str, delay: float = 0.0
) -> tuple[Crossing, ...]:
    """Crossings to each unit but the first along the quasi-static motion that follows a reference.

    **Arguments:**

    - `plant`: the plant.
    - `reference`: one for each step [SI].
    - `dt`: the step [s].
    - `of`: quantity of the reference, "force" or "position".
    - `delay`: of measurements [s]; the lag of valves is the plant's.

    **Returns:** a `Crossing` [s] of each unit; none for two bundles, whose demands depend on the
    controller.

    **Raises:** `InvalidInputError` as `crossing` does.
    """
    bundle, *others = plant.bundles
    if others:
        return ()
    target = np.asarray(reference, float)
    steps = np.unique(np.linspace(0, len(target) - 1, _SAMPLES).astype(int))
    time, target = dt * steps, target[steps]
    low, high = plant.stroke
    if of == "position":
        q = np.clip(target, low, high)
        force, strain = -np.asarray(plant.load.force(q)), plant.strains(q[:, None])[:, 0]
    else:
        q = float(plant.load.motion_at(0.0, 0.0, 0.0)[0])
        force, strain = target, float(np.atleast_1d(plant.strains(q))[0])
    path, lag = Path.of(time, force, strain), DAMPED * (valve_lag(plant) + delay)
    supply = plant.supply_pressure
    units = range(2, plant.units + 1)
    return tuple(crossing(bundle, path, plant, unit, supply, lag=lag) for unit in units)

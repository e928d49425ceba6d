"""Policies by name, and controllers made of them."""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_choice, check_interval, check_positive
from ..dynamics import Plant, PrescribedMotion
from .cascade import DAMPED, FASTEST, Cascade, Gains
from .sequential_policies import fast_cross, hand_over, orderly, pre_charge, threshold
from .simultaneous_policies import batch, energy_aware
from .units import Units


POLICIES: Mapping[str, Callable[[Any], Any]] = MappingProxyType({
    "orderly": orderly,
    "batch": batch,
    "threshold": threshold,
    "energy_aware": energy_aware,
    "hand_over": hand_over,
    "pre_charge": pre_charge,
    "fast_cross": fast_cross,
})  # fmt: skip
OF = ("force", "position")
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
    - `delay`: of its measurements [s], whole steps.
    - `highest_pressure`: of its targets [Pa]; left out, the supply's.
    - `flow_limit`: largest opening of a valve [-].
    - `compensate`: feedforward of the plant's friction.
    - `co_contraction`: of each of a joint's bundles [N].

    **Raises:** `InvalidInputError` for arguments that don't fit.
    """
    create = POLICIES[check_choice(policy, POLICIES, "policy")]
    check_choice(of, OF, "of")
    if plant.commands != plant.units:
        rule = "must have one command for each motor unit"
        raise InvalidInputError("spool", rule, plant.commands, "take Direct or Servovalve")
    if of == "position" and isinstance(plant.load, PrescribedMotion):
        raise InvalidInputError("of", "must be force where the motion is given", of)
    closed = (True, False)
    for name, value in gains._asdict().items():
        if name != "pressure_time":
            check_interval(value, 0.0, np.inf, f"{name} gain", "SI", closed=closed)
    step = float(check_positive(dt, "dt", "s", "such as 0.001"))
    period = check_positive(step if sample_time is None else sample_time, "sample_time", "s")
    period_steps = _steps(period, step, "sample_time")
    lateness = check_interval(delay, 0.0, np.inf, "delay", "s", closed=closed)
    delay_steps = _steps(lateness, step, "delay") if lateness else 0
    supply = plant.supply_pressure
    highest = float(check_interval(
        supply if highest_pressure is None else highest_pressure, 0.0, supply, "highest_pressure",
        "Pa", "of the supply", (False, True),
    ))  # fmt: skip
    limit = check_interval(flow_limit, 0.0, 1.0, "flow_limit", "-", closed=(False, True))
    units = tuple(Units.of(plant, side) for side in range(len(plant.bundles)))
    if band is None:
        forces = (
            bundle.counts
            * bundle.branches.force(np.full(bundle.count, supply), np.zeros(bundle.count))
            for bundle in units
        )
        band = _BAND * max(float(np.max(force)) for force in forces)
    policies = tuple(create(band) for _ in units)
    for rule, bundle in zip(policies, units, strict=True):
        rule.begin(bundle)
    derived = gains.pressure_time is None
    pressure_time = FASTEST if derived else gains.pressure_time
    pressure_time = check_positive(pressure_time, "pressure_time", "s")
    gains = Gains(*map(np.float64, gains._replace(pressure_time=pressure_time)))
    controller = Cascade(
        plant, units, policies, gains, np.float64(highest), np.float64(limit),
        plant.hysteresis if compensate else None,
        np.float64(
            check_interval(co_contraction, 0.0, np.inf, "co_contraction", "N", closed=closed)
        ),
        np.float64(step), of, delay_steps, period_steps,
    )  # fmt: skip
    if derived:
        pressure_time = np.float64(max(FASTEST, DAMPED * controller.lateness))
        return replace(controller, gains=gains._replace(pressure_time=pressure_time))
    for warning in controller.warnings:
        warnings.warn(f"{warning}.", stacklevel=2)
    return controller


def _steps(value: Any, dt: float, name: str) -> int:
    steps = round(float(value) / dt)
    if steps < 1 or abs(steps - float(value) / dt) > 1e-6 * steps:
        rule = f"must be whole steps of {dt:g} s"
        raise InvalidInputError(name, rule, float(value), shown=f"{float(value):g} s")
    return steps

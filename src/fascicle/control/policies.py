"""Policies by name, and a controller of a plant made of one."""

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
_BAND = 0.02  # of what the largest unit pulls at rest


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
    """A controller of a plant, as `simulate` takes it.

    **Arguments:**

    - `plant`: that it controls, and knows [-].
    - `policy`: which units are fed, by name [-]: one of `POLICIES`.
    - `of`: what the reference is, "force" or "position" [-].
    - `gains`: of the cascade, `Gains` [SI], none below zero; a `pressure_time` faster than the
      plant allows is warned of.
    - `band`: by how much a demand must be lower before a unit is let go [N]; left out, 2 % of what
      the largest unit pulls at rest.
    - `dt`: the simulation's step [s].
    - `sample_time`: how often it acts [s], whole steps; left out, at each.
    - `delay`: of what it measures [s], whole steps.
    - `highest_pressure`: that it asks for [Pa]; left out, the supply's.
    - `flow_limit`: share of a valve's opening that it uses [-].
    - `compensate`: whether it feeds the plant's own friction forward [-].
    - `co_contraction`: of a joint's bundles, each [N].

    **Returns:** the controller [-].

    **Raises:** `ValueError`, one line, for what can't be.
    """
    make = POLICIES[check_choice(policy, POLICIES, "policy")]
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
    interval = _steps(
        check_positive(step if sample_time is None else sample_time, "sample_time", "s"),
        step,
        "sample_time",
    )
    late = check_interval(delay, 0.0, np.inf, "delay", "s", closed=closed)
    waits = _steps(late, step, "delay") if late else 0
    supply = plant.supply_pressure
    highest = supply
    if highest_pressure is not None:
        why = "of the supply"
        highest = float(
            check_interval(
                highest_pressure, 0.0, supply, "highest_pressure", "Pa", why, (False, True)
            )
        )
    limit = check_interval(flow_limit, 0.0, 1.0, "flow_limit", "-", closed=(False, True))
    units = tuple(Units.of(plant, side) for side in range(len(plant.bundles)))
    if band is None:
        band = _BAND * max(
            float(
                np.max(
                    bundle.counts
                    * bundle.branches.force(np.full(bundle.many, supply), np.zeros(bundle.many))
                )
            )
            for bundle in units
        )
    policies = tuple(make(band) for _ in units)
    for rule, bundle in zip(policies, units, strict=True):
        rule.begin(bundle)
    derived = gains.pressure_time is None
    settles = FASTEST if derived else gains.pressure_time
    settles = check_positive(settles, "pressure_time", "s")
    gains = Gains(*map(np.float64, gains._replace(pressure_time=settles)))
    controller = Cascade(
        plant, units, policies, gains, np.float64(highest), np.float64(limit),
        plant.hysteresis if compensate else None,
        np.float64(
            check_interval(co_contraction, 0.0, np.inf, "co_contraction", "N", closed=closed)
        ),
        np.float64(step), of, waits, interval,
    )  # fmt: skip
    if derived:
        settles = np.float64(max(FASTEST, DAMPED * controller.lateness))
        return replace(controller, gains=gains._replace(pressure_time=settles))
    for warning in controller.warnings:
        warnings.warn(f"{warning}.", stacklevel=2)
    return controller


def _steps(value: Any, dt: float, name: str) -> int:
    steps = round(float(value) / dt)
    if steps < 1 or abs(steps - float(value) / dt) > 1e-6 * steps:
        rule = f"must be whole steps of {dt:g} s"
        raise InvalidInputError(name, rule, float(value), shown=f"{float(value):g} s")
    return steps

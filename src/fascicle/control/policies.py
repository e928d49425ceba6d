r"""Policies by name, controllers with them, and the selection of a policy for a task.

A dip of length $t_c$ hardly moves a load of mass $M$ on its muscles' stiffness $k$ while
$t_c \sqrt{k/M} \ll 1$; derived here.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..bundle.bundle import Bundle
from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_choice, check_interval, check_positive
from ..dynamics import Plant, PrescribedMotion
from .cascade import DAMPED, FASTEST, OBSERVER, Cascade, Gains, valve_lag
from .confidence import CONFIDENCE
from .crossing import Crossing, Path, crossing, hand_over_time
from .sequential_policies import fast_cross, hand_over, orderly, pre_charge, threshold
from .simultaneous_policies import batch, energy_aware
from .uncertainty import draw_bundles
from .units import ControlledUnits


POLICIES: Mapping[str, Callable[[Any], Any]] = MappingProxyType({
    "orderly": orderly,
    "batch": batch,
    "threshold": threshold,
    "energy_aware": energy_aware,
    "hand_over": hand_over,
    "pre_charge": pre_charge,
    "fast_cross": fast_cross,
})  # fmt: skip
OF = ("force", "position")  # values of the argument `of`
_BAND = 0.02  # of the largest unit's force at rest: more than noise
_DRAWS = 20  # of bundles: each takes a quarter of a second
_HARMLESS = (
    0.2  # of t_c √(k/M): below it a dip moves the load by 2 % of a lasting dip's way at most
)


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
    policy_with_band = POLICIES[check_choice(policy, POLICIES, "policy")]
    check_choice(of, OF, "of")
    if plant.commands != plant.units:
        rule = "must have one command for each motor unit"
        raise InvalidInputError("spool", rule, plant.commands, "take Direct or Servovalve")
    if of == "position" and isinstance(plant.load, PrescribedMotion):
        raise InvalidInputError("of", "must be force where the motion is given", of)
    closed = (True, False)
    for name, value in gains._asdict().items():
        if name not in ("pressure_time", "observer_time"):
            check_interval(value, 0.0, np.inf, f"{name} gain", "SI", closed=closed)
    step = float(check_positive(dt, "dt", "s", "such as 0.001"))
    period = check_positive(step if sample_time is None else sample_time, "sample_time", "s")
    period_steps = _whole_steps(period, step, "sample_time")
    lateness = check_interval(delay, 0.0, np.inf, "delay", "s", closed=closed)
    delay_steps = _whole_steps(lateness, step, "delay") if lateness else 0
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
        observer = OBSERVER if policy in ("hand_over", "pre_charge") else np.inf
    observer = check_interval(observer, 0.0, np.inf, "observer_time", "s", closed=(False, True))
    gains = gains._replace(pressure_time=pressure_time, observer_time=observer)
    gains = Gains(*map(np.float64, gains))
    tension = check_interval(co_contraction, 0.0, np.inf, "co_contraction", "N", closed=closed)
    controller = Cascade(
        plant, units, policies, gains, np.float64(highest), np.float64(limit),
        plant.hysteresis if compensate else None, np.float64(tension), np.float64(step), of,
        delay_steps, period_steps,
    )  # fmt: skip
    if derived:
        pressure_time = np.float64(max(FASTEST, DAMPED * controller.lateness))
        return replace(controller, gains=gains._replace(pressure_time=pressure_time))
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


class PolicyChoice(NamedTuple):
    """A `policy`, the reason for it, `why`, and the `crossings` that it depends on; `share`: of
    bundles drawn around the model, those that have all of them [-], counted until it is below
    `CONFIDENCE`; nan if the model itself doesn't have them, or needs none.
    """

    policy: str
    why: str
    crossings: tuple[Crossing, ...]
    share: float = np.nan


def select_policy(
    plant: Plant,
    reference: Values,
    dt: float,
    of: str,
    delay: float = 0.0,
    draws: Sequence[Bundle] | None = None,
) -> PolicyChoice:
    """Select a policy for a plant and its reference.

    **Arguments:**

    - `plant`: of one bundle or two.
    - `reference`: one for each step [SI].
    - `dt`: the step [s].
    - `of`: quantity of the reference, "force" or "position".
    - `delay`: of measurements [s]; the lag of valves is the plant's.
    - `draws`: bundles that the plant's could be, such as those of a calibration; left out, 20 by
      `draw_bundles`. A crossing counts if 95 % of them have it.

    **Raises:** `InvalidInputError` as `crossing` does.
    """
    if plant.units == 1:
        return PolicyChoice("orderly", "there is one motor unit, nothing is handed over", ())
    if max(plant.sides) > 0:
        why = "each of two bundles has a demand of its own, which is not known beforehand"
        return PolicyChoice("hand_over", why, ())
    path = _path(plant, np.asarray(reference, float), dt, of)
    bundle, supply = plant.bundles[0], plant.supply_pressure
    units = range(2, plant.units + 1)
    lag = DAMPED * (valve_lag(plant) + delay)  # of pressures, (K3a)
    crossings = tuple(crossing(bundle, path, plant, unit, supply, lag=lag) for unit in units)
    share = np.nan
    is_needed = any(entry.deadline is not None for entry in crossings)
    if is_needed and all(entry.is_resolved for entry in crossings):
        draws = draw_bundles(bundle, _DRAWS) if draws is None else draws
        failures = 0
        for draw in draws:
            failures += not all(
                crossing(draw, path, plant, unit, supply, lag=lag).is_resolved for unit in units
            )
            share = 1 - failures / len(draws)
            if share < CONFIDENCE:  # the remaining draws, seconds each, can't change the choice
                break
    return PolicyChoice(*_select_by_crossings(plant, path, crossings, share), crossings, share)


def _select_by_crossings(
    plant: Plant, path: Path, crossings: tuple[Crossing, ...], share: float
) -> tuple[str, str]:
    """Policy for a plant of one bundle by its `crossings`, and the reason for it."""
    needed = [entry for entry in crossings if entry.deadline is not None]
    if not needed:
        return "threshold", f"no crossing is needed: {crossings[0].reason}"
    infeasible = next((entry.reason for entry in needed if not entry.exists), "")
    if share < CONFIDENCE:
        infeasible = (
            f"fewer than {100 * CONFIDENCE:.0f} % of bundles drawn around the model have a crossing"
            " without a dip"
        )
    if infeasible:
        ratio = np.inf
        if not plant.load.prescribed:  # the unit's valve wide open, at the path's middle strain
            eps = float(np.median(path.strain))
            supply, units = plant.supply_pressure, plant.units
            time = float(hand_over_time(plant.bundles[0], eps, plant, 2, supply))
            muscles = plant.muscles.at(np.full(units, supply / 2), np.full(units, eps))
            stiffness = plant.counts * plant.lengths * plant.gains**2 * muscles.force_by_strain
            ratio = time * float(np.sqrt(max(-np.sum(stiffness), 0.0) / float(plant.load.inertia)))
        if ratio < _HARMLESS:
            why = f"{infeasible}; the load hardly follows, t_c √(k/M) is {ratio:.2g}"
            return "fast_cross", why
        return "hand_over", f"{infeasible}; it keeps the dip as small as it can be"
    wait = max(
        (entry.deadline or 0.0) - (entry.end or 0.0) - (entry.fill_time or 0.0) for entry in needed
    )
    if wait > 0 and np.ptp(path.strain) > 1e-6:  # a held strain changes by rounding only
        why = f"the last crossing ends {wait:.3g} s before the unit is needed: {needed[0]}"
        return "pre_charge", why
    return "hand_over", (
        f"{100 * share:.0f} % of bundles drawn around the model have a crossing without a dip,"
        f" {needed[0]}"
    )


def _path(plant: Plant, reference: np.ndarray, dt: float, of: str) -> Path:
    """Demand and strain of the quasi-static motion along a `reference` [SI]."""
    steps = np.unique(np.linspace(0, len(reference) - 1, 401).astype(int))
    time, target = dt * steps, reference[steps]
    low, high = plant.stroke
    if of == "position":
        q = np.clip(target, low, high)
        return Path.of(time, -np.asarray(plant.load.force(q)), plant.strains(q[:, None])[:, 0])
    q = float(plant.load.motion_at(0.0, 0.0, 0.0)[0])
    return Path.of(time, target, float(np.atleast_1d(plant.strains(q))[0]))

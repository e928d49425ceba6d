"""From the tables of a scenario that is controlled to its controller and its reference."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..control import POLICIES, Cascade, Gains, PolicyChoice, cascade, select_policy
from ..core.errors import InvalidInputError
from ..core.validation import check_choice
from ..dynamics import Plant
from .places import Place


_GAINS = ("position_gain", "velocity_gain", "force_gain", "pressure_time")


class Controlled(NamedTuple):
    """A `controller`, its `reference`, one for each step [SI], and where the policy was chosen, by
    `auto`, the `choice` [-]. `policy`: its name [-]; `options`: all else that it was made with.
    """

    controller: Cascade
    reference: np.ndarray
    choice: PolicyChoice | None
    policy: str
    options: Mapping[str, Any]

    @property
    def notes(self) -> tuple[str, ...]:
        """Which policy `auto` took, and why, and what is likely to be unstable, in words [-]."""
        doubts = tuple(f"{warning}." for warning in self.controller.warnings)
        if self.choice is None:
            return doubts
        return (f"auto took {self.choice.policy}: {self.choice.why}.", *doubts)

    def taking(self, policy: str | None = None, compensate: bool | None = None) -> "Controlled":
        """The same with another `policy` [-], `auto` or one of `control.POLICIES`, or where
        friction is, or isn't, fed forward: `compensate` [-].
        """
        if compensate is not None:
            again = self._replace(options={**self.options, "compensate": compensate})
            return again.taking(policy or self.policy)
        if policy is None:
            return self
        plant, of = self.controller.plant, self.controller.of
        if policy != "auto":
            check_choice(policy, (*POLICIES, "auto"), "policy")
        chosen = None
        if policy == "auto":
            chosen = select_policy(plant, self.reference, self.options["dt"], of)
            policy = chosen.policy
        made = cascade(plant, policy, of, **self.options)
        return Controlled(made, self.reference, chosen, policy, self.options)


def controlled(file: Any, plant: Plant, dt: float, duration: float, place: Place) -> Controlled:
    """The controller of a scenario `file` [-] for a `plant` [-], in steps of `dt` [s] for a
    `duration` [s]; `place` of the file [-].
    """
    of, reference = _reference(file, dt, duration, place)
    given = {
        name: x
        for name in type(file.control).model_fields
        if (x := getattr(file.control, name)) is not None
    }
    policy = given.pop("policy")
    at = place.inner("control", kind="part")
    if given.get("delay", 0.0) > duration:
        rule = f"must be at most the run's {duration:g} s, in which nothing would be measured."
        raise at.refuse(("delay",), rule)
    options = {"gains": _gains(given, at), "dt": dt, **given}
    with at.naming():
        plain = cascade(plant, "orderly", of, **options)
        return Controlled(plain, reference, None, "orderly", options).taking(policy)


def _gains(given: dict[str, Any], place: Place) -> Gains:
    for name in _GAINS[:3]:
        if given.get(name, 0.0) < 0:
            raise place.refuse((name,), "must not be below zero.")
    for name in ("integral_time", "force_integral_time", "pressure_time"):
        if given.get(name, 1.0) <= 0:
            raise place.refuse((name,), "must be positive; leave it out for none.")
    usual = Gains()
    stiff = given.pop("position_gain", 0.0)
    slow = given.pop("integral_time", np.inf)
    force_slow = given.pop("force_integral_time", 1 / usual.force_integral)
    return Gains(
        stiff, stiff / slow, given.pop("velocity_gain", 0.0), given.pop("force_gain", usual.force),
        1 / force_slow, given.pop("pressure_time", usual.pressure_time),
    )  # fmt: skip


def _reference(file: Any, dt: float, duration: float, place: Place) -> tuple[str, np.ndarray]:
    """What is demanded, "force" or "position", and how much at each step [SI]."""
    time = dt * np.arange(round(duration / dt))
    if (file.demand is None) == (file.sine is None):
        rule = "write [[demand]] with time and force or position, or [sine], one of both."
        raise place.refuse(("demand",), rule)
    if file.sine is not None:
        if file.sine.frequency <= 0:
            raise place.refuse(("sine", "frequency"), "must be positive.")
        turn = 2 * np.pi * file.sine.frequency * time
        return "position", file.sine.mean + file.sine.amplitude * np.sin(turn)
    if not file.demand:
        raise place.refuse(("demand",), "is empty: write [[demand]] with time and force.")
    first = file.demand[0]
    of = "force" if first.force is not None else "position"
    times, values = [], []
    for k, row in enumerate(file.demand):
        at = place.inner("demand", k, kind="schedule")
        if (row.force is None) == (row.position is None) or getattr(row, of) is None:
            raise at.refuse((of,), "write `force` in each row, or `position` in each.")
        if (not times and row.time != 0) or (times and row.time <= times[-1]):
            raise at.refuse(("time",), "times must begin at 0 s and rise.")
        times.append(row.time)
        values.append(getattr(row, of))
    return of, np.interp(time, times, values)


def checked_start(pressures: Any, plant: Plant, place: Place) -> None:
    """Refuse `pressures` [Pa] to begin with above the supply's of a `plant` [-], at their `place`
    [-].
    """
    supply = plant.supply_pressure
    if pressures is not None and np.max(pressures) > supply:
        with place.naming():
            raise InvalidInputError(
                "pressures", f"must be at most the supply's {supply:g} Pa",
                float(np.max(pressures)), shown=f"{np.max(pressures):g} Pa",
            )  # fmt: skip

"""Limits on objectives, and the one that every search has: to reach the task.

All points must be reached. `not_reached`, limited, is the share of the task that may be missed;
it is counted by weight *and* by points, so that a peak load that counts a thirtieth can't be
lost among the others: with a tenth to miss, one of nine points is too many.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Bool, Float
from ..core.validation import check_choice
from .objectives import OBJECTIVES, known
from .outcome import MET


_ROUNDING = 1e-12  # of a limit, or of 1 in its unit: sums of shares don't end in round numbers


class Limit(NamedTuple):
    """The least and the largest that an objective may be, in its own unit [SI]."""

    least: float = -np.inf
    most: float = np.inf

    def holds(self, values: Any) -> Any:
        """Whether `values` [SI], of any shape, are within [-], up to rounding; a NaN isn't."""
        return (values >= self.least - _hair(self.least)) & (values <= self.most + _hair(self.most))

    def excess(self, values: Float[np.ndarray, "*any"]) -> Float[np.ndarray, "*any"]:
        """How far `values` [SI] are outside [SI]; not positive within."""
        below = self.least - _hair(self.least) - values
        return np.maximum(below, values - self.most - _hair(self.most))


Limits = Mapping[str, Limit]
Values = Mapping[str, Float[np.ndarray, " design"]]


def within_limits(values: Values, limits: Limits) -> Bool[np.ndarray, " design"]:
    """Which designs keep all limits; `values` [SI] and `limits` [SI] by objective."""
    kept = np.ones(len(next(iter(values.values()))), bool)
    for name, limit in limits.items():
        kept &= limit.holds(values[name])
    return kept


def checked(senses: Mapping[str, str], limits: Limits) -> None:
    """Refuse senses and limits that can't be; both by objective [-]."""
    if not senses:
        raise InvalidInputError("objectives", "must name at least one", None, shown="none")
    for name, sense in senses.items():
        check_choice(sense, ("min", "max"), name)
    for name, limit in limits.items():
        if not limit.least <= limit.most:
            unit = OBJECTIVES[name].unit
            raise InvalidInputError(
                name,
                f"is limited to at least {limit.least:g} and at most {limit.most:g} {unit}",
                None,
                "nothing can be both",
            )


def _hair(end: Any) -> float:
    return _ROUNDING * max(1.0, abs(end)) if np.isfinite(end) else 0.0


BY_WEIGHT, BY_POINTS = "not_reached", "points_not_reached"
SHARES = (BY_WEIGHT, BY_POINTS)
# what tells how far a design is from the task, and which of two is cheaper, whatever is asked
ALWAYS = (
    *SHARES, "margin", "relative_margin", "relative_shortfall", "valves", "mean_energy",
)  # fmt: skip


def demanding(limits: Limits | None) -> dict[str, Limit]:
    """Limits with what must be reached.

    **Arguments:** `limits`: on objectives, by name [SI].

    **Returns:** them, with the shares of the task that may be missed [-]: none, or as much as
    `not_reached` was limited to, by weight and by points.
    """
    given = dict(limits or {})
    share, points = given.get(BY_WEIGHT, Limit()), given.get(BY_POINTS, Limit())
    missed = share.most if np.isfinite(share.most) else 0.0
    return given | {
        BY_WEIGHT: Limit(share.least, missed),
        BY_POINTS: Limit(points.least, min(points.most, missed)),
    }


def may_miss(limits: Limits) -> float:
    """The share of the task that may be missed [-], by `limits` [SI] as of `demanding`."""
    return float(np.clip(limits[BY_WEIGHT].most, 0.0, 1.0))


def recorded(
    senses: Mapping[str, str], limits: Limits, extra: tuple[str, ...] = ()
) -> tuple[str, ...]:
    """Objectives that a search computes [-]: those of its `senses` [-], of its `limits` [SI], the
    `extra` ones [-], and those that every search needs.
    """
    return known([*senses, *limits, *extra, *ALWAYS])


def reaching(values: Values, limits: Limits) -> Bool[np.ndarray, " design"]:
    """Which designs reach what must be, whatever else they break; `values` and `limits` [SI]."""
    return within_limits(values, {name: limits[name] for name in SHARES})


def others(limits: Limits) -> dict[str, Limit]:
    """The `limits` [SI] that aren't about what is reached."""
    return {name: limit for name, limit in limits.items() if name not in SHARES}


def enough(
    spare: Float[np.ndarray, "*any point"], weight: Float[np.ndarray, " point"], may_miss: float
) -> Any:
    """Whether what is reached is enough.

    **Arguments:**

    - `spare`: force to spare at each point [N], negative where it isn't reached.
    - `weight`: of the points [-].
    - `may_miss`: share of the task that may be missed [-].

    **Returns:** whether no more is missed, by weight and by points.
    """
    missed, limit = spare < -MET, Limit(most=may_miss)
    by_weight = np.sum(missed * weight, axis=-1) / np.sum(weight)
    return limit.holds(missed.mean(axis=-1)) & limit.holds(by_weight)

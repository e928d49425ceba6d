"""What every search holds to: a design reaches the whole task, or as much as the user lets go.

All points must be reached. `not_reached`, limited, is the share of the task that may be missed;
it is counted by weight *and* by points, so that a peak load that counts a thirtieth can't be
lost among the others: with a tenth to miss, one of nine points is too many.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...core.types import Bool, Float
from .allowed import Limit, Limits, Values, within_limits
from .objectives import known
from .outcome import MET


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

"""Limits on objectives: the least and the largest that each may be."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...core.errors import InvalidInputError
from ...core.types import Bool, Float
from ...core.validation import check_choice
from .objectives import OBJECTIVES


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

r"""Torque and angle of a joint as force and contraction of the muscle that moves it.

A muscle with the moment arm $r(\theta)$ about a joint shortens by $dx = r\,d\theta$ in a small turn
$d\theta$. Its work $F\,dx$ is the joint's, $\tau\,d\theta$, whatever the route; so

$$F = \frac{\tau}{r(\theta)}, \qquad
  \varepsilon = \frac{1}{L} \int_{\theta_0}^{\theta} r(\vartheta)\,d\vartheta, \tag{J1}$$

with the rest length $L$ at the angle $\theta_0$. Between the angles of a table the arm is linear;
its integral is exact then, and is the trapezoidal rule at the table's angles.

**Assumes** that the torque is the muscle's alone: the weight of the limb and other muscles are
subtracted before. An error of the torque is one of the force over $r$, so readings where the arm
nearly vanishes are left out.

**Source:** virtual work; for tendons An et al. (1984), J. Biomech. Eng. 106(3), 280.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.findings import Finding
from ..units import parse, parse_list, pretty
from .record import warning


_LEAST_ARM = 0.1  # of the largest: below it an error of the torque counts tenfold in the force
_MARGIN = 0.02  # of a table's range of angles: noise of an angle may exceed its ends by that
_GROUPS = 50  # of angles: in each, the arm of a joint is nearly constant
_MAX_SCATTER = 0.1  # of the largest arm: more within a group is no function of the angle


class ArmTable(NamedTuple):
    """Moment arm of a muscle, linear between rising angles.

    - `angle`: [rad]; `arm`: [m], positive where the muscle shortens as the angle grows.
    """

    angle: np.ndarray
    arm: np.ndarray

    def excess(self, angle: np.ndarray) -> np.ndarray:
        """Distance of each `angle` from the table beyond a margin for noise [rad]; 0 inside."""
        margin = _MARGIN * (self.angle[-1] - self.angle[0])
        outside = np.maximum(self.angle[0] - angle, angle - self.angle[-1])
        return np.maximum(outside - margin, 0.0)

    @property
    def outside_text(self) -> str:
        """End of an error on an angle outside the table."""
        low, high = (pretty(float(x), "angle") for x in (self.angle[0], self.angle[-1]))
        return f"lies beyond the angles of the moment arms, {low} to {high}"

    def arm_at(self, angle: np.ndarray) -> np.ndarray:
        """Arm at each `angle` [m]."""
        return np.asarray(self._spline()(angle))

    def shortening(self, angle: np.ndarray, rest_angle: float) -> np.ndarray:
        """Shortening of the muscle from the angle `rest_angle` [rad] to each `angle` [m], (J1)."""
        integral = self._spline().antiderivative()
        return np.asarray(integral(angle) - integral(rest_angle))

    def _spline(self) -> Any:
        from scipy.interpolate import make_interp_spline

        return make_interp_spline(*self, k=1)


def read_arm_table(table: Mapping[str, Any], *, bare: bool = True) -> ArmTable:
    """Moment arms by angle, sorted, from a `table` of `angle` and `arm`, lists or text such as
    `"0deg:90deg:10deg"`. `bare`: numbers are [rad] and [m].
    """
    if set(table) != {"angle", "arm"}:
        keys = ", ".join(sorted(table)) or "none"
        remedy = 'write angle = "0deg:90deg:45deg", arm = "20mm,25mm,22mm"'
        raise _invalid_arms("must have the keys angle and arm", remedy, keys)
    columns = []
    for key, dimension in (("angle", "angle"), ("arm", "length")):
        entries, values = table[key], list[float]()
        if not isinstance(entries, str | list | tuple | np.ndarray):
            raise _invalid_arms(f"must have a list or a range as {key}", "", f"{entries!r}")
        for entry in [entries] if isinstance(entries, str) else entries:
            if isinstance(entry, str):
                values += parse_list(entry, dimension, key)
            else:
                values.append(float(entry) if bare else parse(entry, dimension, key))
        columns.append(np.array(values))
    angle, arm = columns
    if angle.size != arm.size or angle.size < 2:
        text = f"{angle.size} and {arm.size}"
        raise _invalid_arms("must have as many arms as angles, at least 2", "", text)
    if not (np.isfinite(angle).all() and np.isfinite(arm).all() and np.any(arm)):
        raise _invalid_arms("must have finite angles and arms that aren't all 0", "", "others")
    order = np.argsort(angle, kind="stable")
    if np.any(np.diff(angle[order]) == 0):
        raise _invalid_arms("must have each angle once", "", "one twice")
    return ArmTable(angle[order], arm[order])


def sampled_arms(angle: np.ndarray, arm: np.ndarray) -> ArmTable:
    """Table of the arms [m] read beside the angles [rad]; of one angle their mean.

    Raises a `ValueError` of a few words for arms that are no function of the angle.
    """
    angles, entry, count = np.unique(angle, return_inverse=True, return_counts=True)
    if angles.size < 2:
        raise ValueError("all readings are at one angle: give moment_arm, a constant or a table")
    group = np.minimum(_GROUPS * (angle - angles[0]) / (angles[-1] - angles[0]), _GROUPS - 1)
    group = group.astype(int)
    total, size = np.bincount(group, arm), np.maximum(np.bincount(group), 1)
    scatter = np.sqrt(np.mean((arm - (total / size)[group]) ** 2))
    if scatter > _MAX_SCATTER * np.max(np.abs(arm)):
        raise ValueError("the moment arm is no function of the angle: check both columns")
    return ArmTable(angles, np.bincount(entry, arm) / count)


def usable_arms(arm: np.ndarray) -> tuple[np.ndarray, list[Finding]]:
    """Mask of the readings whose `arm` [m] gives a force, and a finding on the others."""
    largest = float(np.max(np.abs(arm)))
    mask = np.abs(arm) > _LEAST_ARM * largest
    count = int(np.sum(~mask))
    found = [warning("short_arms", count=count, least=_LEAST_ARM, largest=largest)]
    return mask, found[: count > 0]


def _invalid_arms(rule: str, remedy: str, text: str) -> InvalidInputError:
    return InvalidInputError("moment_arm", rule, None, remedy, shown=text)

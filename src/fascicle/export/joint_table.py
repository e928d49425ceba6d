"""An antagonistic joint in C: constants of its inverse, (K9), and the error of its stiffness.

The inverse follows the curve of one torque as `Joint.pressures` does, on the muscles' tables: at
one angle the force and the stiffness of both sides are a cubic in each cell.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..control import Joint
from ..control.joint import EDGE, NODES
from ..fluid.fields import ROOM_PRESSURE
from ..muscle import Muscle
from .c_files import c_array


if TYPE_CHECKING:
    from .c_table import BundleTables


_EVERY = 4  # pressure of the other side in the quantiles: a quarter of all pairs
_POINTS = 4, 8  # in each cell of pressure and of strain
# of a thick muscle's joint the largest errors, beside kinks, were up to 9.5 % larger at 16 points
_BETWEEN = 1.1


class JointErrors(NamedTuple):
    """Largest errors of a joint's torque [N·m] and stiffness [N·m/rad], each in the inner half of
    the angles and at all; median and 99 % of the stiffness's.
    """

    torque: tuple[float, float]
    stiffness: tuple[float, float]
    median: float
    most: float


def joint_values(joint: Joint, number: Callable[[float], str]) -> dict[str, Any]:
    """Values of the templates of a `joint` in C; `number` formats one."""
    lengths = [float(bundle.length) for bundle in (joint.agonist, joint.antagonist)]
    return {
        "arm": f"{joint.moment_arm:.6g}",
        "rest": f"{joint.strain:.6g}",
        "parts": NODES - 1,
        "split": len(joint.agonist.motor_units),
        "moment_arm": number(joint.moment_arm),
        "rest_strain": number(joint.strain),
        "side_lengths": c_array(lengths, number),
        "edge": number(EDGE),
        "room": number(ROOM_PRESSURE),
    }


def joint_errors(tables: "BundleTables", joint: Joint, muscles: Sequence[Muscle]) -> JointErrors:
    """Errors of a `joint` on its `tables`, of any two pressures; `muscles`: of its surfaces."""
    surface = tables.surfaces[0]
    lines, columns = (n * k for n, k in zip(surface.coefficients.shape, _POINTS, strict=False))
    P = float(surface.highest_pressure) * np.linspace(0, 1, lines + 1)[:, None] ** 2
    angles = np.linspace(-1, 1, columns + 1)
    low, high = tables.strains
    strains = tables.unit_strains(low + (high - low) * (angles + 1) / 2)
    split, arm = len(joint.agonist.motor_units), joint.moment_arm
    sides = np.zeros((2, 2, lines + 1, columns + 1))  # agonist, antagonist; torque, stiffness
    for unit, (kind, count) in enumerate(zip(tables.kinds, tables.counts, strict=True)):
        muscle, eps = muscles[kind], strains[unit]
        point, lever = tables.surfaces[kind].lookup_at(P, eps), arm / float(muscle.length)
        with np.errstate(all="ignore"):  # of branches that aren't taken
            force, slope = muscle.law.at(P).force_and_slope(eps)
        errors = np.stack([point.force - force, lever * (point.force_by_strain - slope)])
        sides[int(unit >= split)] += int(count) * arm * errors
    # pressures are any: at each angle the largest errors of both sides may add up
    largest = _BETWEEN * np.sum(np.max(np.abs(sides), axis=2), axis=0)
    inner = np.max(largest[:, np.abs(angles) <= 0.5], axis=1)
    torque, stiffness = np.stack([inner, np.max(largest, axis=1)], axis=1).tolist()
    first, second = sides[:, 1, 1::2, 1::4]  # beside the nodes, where errors are least
    both = np.abs(first[:, None] + second[None, ::_EVERY])
    return JointErrors(torque, stiffness, *np.quantile(both, (0.5, 0.99)).tolist())


def stiffness_rounding(tables: "BundleTables", joint: Joint) -> float:
    """Error of single precision in the `joint`'s stiffness [N·m/rad]."""
    error = 0.0
    for kind, rounding in zip(tables.kinds, tables.roundings, strict=True):
        surface = tables.surfaces[kind]
        low, high = surface.strains
        cell = float(high - low) / surface.coefficients.shape[1] * float(surface.rest_length)
        # Hermite's second derivatives are up to 6, four times their first ones' 1.5
        error += 4 * rounding / cell
    return joint.moment_arm**2 * error

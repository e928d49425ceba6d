"""An antagonistic joint in C: constants of its inverse, (K9), and the error of its stiffness.

The inverse follows the curve of one torque as `Joint.pressures` does, on the muscles' tables: at
one angle the force and the stiffness of both sides are a cubic in each cell.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..control import Joint
from ..control.joint import EDGE, NODES
from ..fluid.fields import ROOM_PRESSURE
from ..muscle import Muscle
from ..muscle.table import slope_errors
from .c_files import c_array


if TYPE_CHECKING:
    from .c_table import BundleTables


_EVERY = 4  # pressure of the other side in the quantiles: a quarter of all pairs


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


def stiffness_errors(
    tables: "BundleTables", joint: Joint, muscles: Sequence[Muscle]
) -> tuple[float, float, float]:
    """Median, 99 % and largest error of a `joint`'s stiffness [N·m/rad] between the nodes of its
    `tables`, of any two pressures; `muscles`: of the different tables.
    """
    columns = tables.surfaces[0].coefficients.shape[1]
    strains = tables.unit_strains(np.linspace(*tables.strains, 2 * columns + 1))
    errors = []
    for kind, count, unit_strains in zip(tables.kinds, tables.counts, strains, strict=True):
        law, length = muscles[kind].law, float(muscles[kind].length)
        errors.append(count / length * slope_errors(tables.surfaces[kind], law, unit_strains))
    split = len(joint.agonist.motor_units)
    first, second = np.sum(errors[:split], axis=0), np.sum(errors[split:], axis=0)
    both = joint.moment_arm**2 * np.abs(first[:, None] + second[None, ::_EVERY])
    largest = np.max(np.max(np.abs(first), axis=0) + np.max(np.abs(second), axis=0))
    median, most = np.quantile(both, (0.5, 0.99))
    return float(median), float(most), float(joint.moment_arm**2 * largest)


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

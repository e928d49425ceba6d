r"""What can't be bettered: the non-dominated set, and the volume that it dominates.

A design dominates another if it is at least as good in every objective and better in one.
The front is the set that none dominates. Its *hypervolume* is that of the points which the
front dominates, up to a reference point that is worse than all: it falls if any part of the
front is missing, and so compares two searches by one number.

Here smaller is better; `directed` turns objectives around.

Both are computed by moocore (López-Ibáñez and others).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ...core.errors import InvalidInputError
from ...core.types import Bool, Float


Matrix = Float[np.ndarray, "design objective"]


def directed(
    values: Mapping[str, Float[np.ndarray, " design"]], senses: Mapping[str, str]
) -> Matrix:
    """Objectives as columns in which smaller is better.

    **Arguments:**

    - `values`: an array for each objective [SI].
    - `senses`: "min" or "max" by name [-]; only these objectives are taken.

    **Returns:** a row for each design [SI].

    **Raises:** `ValueError` for an unknown sense.
    """
    for name, sense in senses.items():
        if sense not in ("min", "max"):
            raise InvalidInputError(name, "must be 'min' or 'max'", sense)
    columns = [values[name] if sense == "min" else -values[name] for name, sense in senses.items()]
    return np.stack(columns, axis=1) + 0.0


def non_dominated(points: Matrix) -> Bool[np.ndarray, " design"]:
    """Which points none dominates.

    **Arguments:** `points`: smaller is better [-], a row each; a NaN is worse than all.

    **Returns:** a mask [-]; of equal points all are kept.
    """
    import moocore

    kept = ~np.any(np.isnan(points), axis=1)
    kept[kept] = moocore.is_nondominated(points[kept], keep_weakly=True)
    return kept


def hypervolume(points: Matrix, reference: Sequence[float] | np.ndarray) -> float:
    """Volume dominated by points, up to a reference.

    **Arguments:**

    - `points`: smaller is better [-], a row each; those beyond the reference don't count.
    - `reference`: worse than what counts [-], one number for each objective.

    **Returns:** the volume [-], product of the objectives' units.
    """
    import moocore

    return float(moocore.hypervolume(points, ref=np.asarray(reference, float)))

"""The last step of finding a fit, where a record shows what resists: all readings, all of the model."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..muscle import Muscle
from .calibration import Calibration, largest_force, root_mean_square
from .choosing import TUNING, Candidate, chosen
from .fitting import Prior, Search, fitted
from .leaving_out import left_out_errors
from .parameters import FACTORS
from .taking import Taken


FACTOR_NAMES = tuple(one.name for one in FACTORS)
_AND = "and the factors on what resists"


def resisting(
    of: Taken,
    muscle: Muscle,
    given: Mapping[str, Prior],
    search: Search,
    names: tuple[str, ...],
) -> tuple[list[Candidate], list[Calibration]]:
    """The fits of all that was measured: the paper's tuning; the constants `names` [-] that are
    best where the muscle pulls, with the factors on what resists and without; and these factors
    alone. Arguments as `finding.find`; the fits [-], and what they are called.
    """
    # one compiled function for all: it knows every constant that one of them frees
    search = replace(search, among=tuple(dict.fromkeys([*names, *FACTOR_NAMES])))
    tried = (
        (TUNING, FACTOR_NAMES, True),
        (f"{', '.join(names)} {_AND}", (*names, *FACTOR_NAMES), False),
        (", ".join(names), names, False),
        (f"the muscle as given {_AND}", FACTOR_NAMES, False),
    )
    if set(given) - set(FACTOR_NAMES):  # a tuning has no place for what is known of constants
        tried = tried[1:3]
    rows, fits = [], []
    near: dict[str, float] = {}
    for label, free, tune in tried:
        priors = {name: prior for name, prior in given.items() if name in free}
        made = fitted(of, muscle, free, priors, replace(search, tune=tune, near=dict(near)))
        near.update(zip(made.names, made.coordinates.tolist(), strict=True))
        rows.append(_row(label, free, made))
        fits.append(made)
    return rows, fits


def _row(label: str, names: tuple[str, ...], made: Calibration) -> Candidate:
    count = np.asarray(made.data.count)
    rmse = root_mean_square(made.residual, count)
    unseen = left_out_errors(made)
    left = float("nan")
    if np.array_equal(np.isfinite(unseen), np.isfinite(made.residual)):
        left = root_mean_square(unseen, count)
        if made.problem.loss != "linear":  # what a robust fit plays down must not decide
            left = 1.4826 * float(np.nanmedian(np.abs(unseen)))
    constants = len(names) + (0 if made.readings is None else made.readings.order + 3)
    top = largest_force(made.record)
    return Candidate(
        label, names, made.method, constants, rmse, left, rmse / top, left / top, "all"
    )

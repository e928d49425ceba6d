"""The last step of finding a fit, where a record shows what resists: all of it, by all of the
model.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...muscle import Muscle
from ..after.calibration import Calibration, largest_force
from ..after.leaving_out import left_out_force
from ..data.grid import trimmed
from ..data.taking import Taken
from ..problem.beginning import Prior, Search
from ..problem.parameters import FACTORS
from .candidates import ACTIVE
from .choosing import AS_GIVEN, TUNING, Trial, too_long, trial
from .fitting import fitted


FACTOR_NAMES = tuple(one.name for one in FACTORS)
_STARTS = 2
_AND = "and the factors on what resists"


def resisting(
    of: Taken,
    muscle: Muscle,
    given: Mapping[str, Prior],
    search: Search,
    names: tuple[str, ...],
) -> tuple[list[Trial], list[Calibration]]:
    """The fits of all that was measured: the paper's tuning; the constants `names` [-] that are
    best where the muscle pulls, with the factors on what resists and without; and these factors
    alone. Arguments as `finding.find`; the fits [-], and what they are called.
    """
    # one compiled function for all: it knows every constant that one of them frees
    search = replace(search, among=tuple(dict.fromkeys([*names, *FACTOR_NAMES])))
    tried: list[tuple[str, tuple[str, ...], bool]] = [(TUNING, FACTOR_NAMES, True)]
    if names:
        label = ", ".join(names)
        tried += [(f"{label} {_AND}", (*names, *FACTOR_NAMES), False), (label, names, False)]
    tried.append((f"{AS_GIVEN} {_AND}", FACTOR_NAMES, False))
    if not names:
        tried.append((AS_GIVEN, (), False))
    if set(given) - set(FACTOR_NAMES):  # a tuning has no place for what is known of constants
        tried = tried[1:3]
    trials, fits = [], []
    near: dict[str, float] = {}
    for label, free, tune in tried:
        priors = {name: prior for name, prior in given.items() if name in free}
        made = fitted(of, muscle, free, priors, replace(search, tune=tune, near=dict(near)))
        # the next begin where this one ended: few other places are enough
        search = replace(search, starts=min(search.starts, _STARTS))
        near.update(zip(made.names, made.coordinates.tolist(), strict=True))
        wrong = ""
        if ACTIVE in free and ACTIVE not in given:
            rest = of.record.rest_length or float(muscle.length)
            wrong = too_long(float(made.muscle.length), rest)
        trials.append(_trial(label, free, made, wrong))
        fits.append(made)
    if all(one.impossible for one in trials):  # nothing else to take: the fit's warnings say it
        trials = [replace(one, impossible="") for one in trials]
    return trials, fits


def _trial(label: str, names: tuple[str, ...], made: Calibration, wrong: str) -> Trial:
    of = made.taken
    unseen = of.errors(left_out_force(made), np.asarray(trimmed(of.data).strain))
    constants = len(names) + (0 if made.readings is None else made.readings.order + 3)
    return trial(
        label, names, made.method, constants, made.errors, unseen,
        made.problem.loss, largest_force(made.record), "all", wrong,
    )  # fmt: skip

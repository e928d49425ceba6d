"""What kind of cause would leave such residuals.

Each cause that is known changes the force in its own way over strain and pressure. How much of
the residuals' squares such a change would take up, beside what was fitted, is computed to first
order: a hint where to look, and no fit.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc

from ..problem.linear import linear
from ..problem.parameters import FACTORS
from ..problem.residuals import Problem
from ..problem.uncertainty import KNOWN
from .remainder import Remainder, beside
from .trends import ALPHA, Looked


_WORTH = 0.2  # of the residuals' squares, below which a cause isn't named
_NEXT = 0.8  # of the best cause's share: others are named too
_MOST = 3
_STEP = 1e-6  # of strain, for the force's slope: errors of rounding and of the step are alike


@dataclass(frozen=True)
class Cause:
    """A kind of cause: `name`, what `to do` about it, and the `share` of the residuals' squares
    that it would explain [-].
    """

    name: str
    remedy: str
    share: float


# a cause's name, and what to do; first of the constants that a fit may free, where their own words
# don't name it
_CONSTANTS = {
    "dead_band": ("a dead band, or the transducer's zero", "free dead_band"),
    "active_length": (
        "an end effect: a part of the length that doesn't work",
        "free active_length",
    ),
    "wall_thickness": ("another wall", "free wall_thickness"),
    "end_compliance": ("an end effect: fibers or fittings that give", "free end_compliance"),
    "inactive_length": (
        "an end effect: a part of the length that doesn't work",
        "free inactive_length",
    ),
    "c10": ("the rubber's modulus", "free c10"),
    "c01": ("the rubber's modulus", "free c01"),
    "braid_angle": ("another braid angle", "free braid_angle"),
    "outer_radius": ("another radius", "free outer_radius"),
}
_COMPLIANCE = (
    "an end effect: fibers or fittings that give",
    "free end_compliance",
)
_ENDS = (
    "an end effect: ends that don't swell",
    "compare tension laws: tondu_lopez scales the strain",
)
_LENGTH = ("the zero of the length", "check the rest length")
_ZERO = ("the load cell's zero", "take it off")
_RUBBER = (
    "the bladder's elasticity: a force that goes with contraction, whatever the pressure",
    "C10 and C01 can't follow it: trust strains that were measured, not those between or beyond",
)
_FRICTION = ("friction: a hysteresis loop", "its width is part of the muscle's error in use")
_DRIFT = ("a drift in time", "measure the first pressure again at the end")


def causes(
    problem: Problem, coordinates: np.ndarray, left: Remainder, seen: Looked
) -> tuple[Cause, ...]:
    """Causes that would explain much of what a fit left, the likeliest first.

    **Arguments:**

    - `problem`: of the fit [-].
    - `coordinates`: of all its parameters at the minimum [-].
    - `left`: what the fit left [-].
    - `seen`: what was found in it [-].

    **Returns:** the causes [-]; none where residuals could be noise.
    """
    if seen.noisy or not np.isfinite(seen.noise):
        return ()
    free = float(np.sum(left.read)) - left.slopes.shape[1]
    out: dict[str, Cause] = {}
    for (name, remedy), columns in _directions(problem, coordinates, left):
        Q = left.beyond(left.taken, left.rows(columns))
        if not Q.shape[1]:
            continue
        explained = float(np.sum((Q.T @ left.residual) ** 2))
        chance = fdtrc(Q.shape[1], free, explained / Q.shape[1] / seen.noise**2)
        share = min(explained / left.squares, 1.0)
        if share >= _WORTH and chance < ALPHA and share > getattr(out.get(name), "share", 0.0):
            out[name] = Cause(name, remedy, share)
    likely = sorted(out.values(), key=lambda one: -one.share)[:_MOST]
    return tuple(one for one in likely if one.share >= _NEXT * likely[0].share)


def untold(problem: Problem, coordinates: np.ndarray, left: Remainder) -> tuple[str, ...]:
    """Constants that weren't fitted and that the data could not tell beside those that were.

    **Arguments:** as `causes` [-].

    **Returns:** their names [-].
    """
    out = []
    for name, columns in _held(problem, coordinates, left):
        known = float(np.sum(beside(left.taken, left.rows(columns)) ** 2))
        if name != "dead_band" and known * KNOWN**2 < float(problem.noise) ** 2:
            out.append(name)
    return tuple(out)


def _held(
    problem: Problem, coordinates: np.ndarray, left: Remainder
) -> Iterator[tuple[str, np.ndarray]]:
    """Constants that weren't free, and how each changes the force [N] by its coordinate."""
    held = sorted(set(range(len(problem.parameters))) - set(problem.chosen.tolist()))
    if not held:
        return
    # all of them free: the same function, another argument
    freed = replace(problem, free=np.ones(len(problem.parameters), dtype=bool))
    slopes = linear(freed, coordinates).force_slopes[problem.data.uncensored]
    priors = left.weight.size - len(slopes)
    for i in held:
        if problem.parameters[i] not in FACTORS and np.all(np.isfinite(slopes[:, i])):
            yield problem.parameters[i].name, np.pad(slopes[:, i], (0, priors))


def _directions(
    problem: Problem, coordinates: np.ndarray, left: Remainder
) -> Iterator[tuple[tuple[str, str], np.ndarray]]:
    """How each cause changes the force [N], to any scale, at the remainder's rows."""
    used = np.asarray(problem.data.uncensored)
    priors = left.weight.size - int(np.sum(used))

    about = {one.name: one.about for one in problem.parameters}
    for name, columns in _held(problem, coordinates, left):
        yield _CONSTANTS.get(name, (f"{name}, {about[name]}", f"free {name}")), columns
    away = np.asarray(problem.data.strain) + _STEP
    stretched = replace(problem.data, strain=away)
    moved = linear(replace(problem, data=stretched), coordinates).force
    slope = (np.pad(moved[used], (0, priors)) - left.force) / _STEP
    yield _COMPLIANCE, slope * left.force
    yield _ENDS, slope * left.strain
    yield _LENGTH, slope
    yield _ZERO, np.ones(left.force.size)
    yield _RUBBER, np.stack([left.strain, left.strain**2, left.strain**3], axis=-1)
    if {1, -1} <= set(np.unique(left.branch[left.read])):
        yield _FRICTION, np.stack([left.branch, left.branch * left.pressure], axis=-1)
    if np.all(np.isfinite(left.time[left.read])):
        yield _DRIFT, np.nan_to_num(left.time)

"""Choosing among what was tried on a record, and saying why."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import InvalidInputError
from ...units import pretty


ALIKE = 0.02  # of the least left-out error beyond noise: candidates that near it are as good
_DEVIATIONS = 1.0  # of a difference: the one-standard-error rule, Breiman et al. (1984)
_OUTLIER = 3.0  # of the usual error: what a robust fit leaves counts no more
_LONGER = 1.02  # of the length between the fittings: a ruler's error, generously
TUNING = "the paper's tuning"
AS_GIVEN = "the muscle as given"
JUDGED = (
    "Judged by the error at {parts} that the fit did not see, each left out in turn: of all that"
    f" err no more than the least by one standard error, by {100 * ALIKE:g} % or by a reading's"
    " share of the squares, the one with the fewest numbers."
)
_WORDS = {"dead_band": "A dead band", "active_length": "Another active length",
          "end_compliance": "Ends that give"}  # fmt: skip


@dataclass(frozen=True)
class Candidate:
    """What was tried on a record.

    - `label`: what was free [-]; `names`: of these constants [-].
    - `method`: "tuning" or "constants" [-].
    - `constants`: how many numbers were fitted [-], with those of a tuning's curves.
    - `rmse`, `left_out_rmse`: error [N] where it was fitted, and at pressures that it wasn't.
    - `relative_rmse`, `relative_left_out_rmse`: over the largest force [-].
    - `readings`: which were compared [-]: "pulling", where the muscle pulls, or "all".
    - `chosen`: whether it was taken [-].
    """

    label: str
    names: tuple[str, ...]
    method: str
    constants: int
    rmse: float
    left_out_rmse: float
    relative_rmse: float
    relative_left_out_rmse: float
    readings: str = "pulling"
    chosen: bool = False


@dataclass(frozen=True, eq=False)
class Trial:
    """A `candidate` and its errors where it was left out, reading by reading [N]; NaN for those
    that are clipped. `impossible`: why no muscle can be so [-], empty where one can.
    """

    candidate: Candidate
    unseen: np.ndarray
    impossible: str = ""

    @property
    def judged(self) -> bool:
        """Whether it can be chosen [-]: a muscle can be so, and its left-out error is known."""
        return bool(np.isfinite(self.candidate.left_out_rmse)) and not self.impossible


def trial(
    label: str,
    names: tuple[str, ...],
    method: str,
    constants: int,
    errors: np.ndarray,
    unseen: np.ndarray,
    loss: str,
    top: float,
    readings: str = "pulling",
    impossible: str = "",
) -> Trial:
    """What was tried, with the size of its errors.

    **Arguments:**

    - `label`, `names`, `method`, `constants`, `readings`: as `Candidate` [-].
    - `impossible`: as `Trial` [-].
    - `errors`: where it was fitted, reading by reading [N]; NaN for clipped ones.
    - `unseen`: where it was left out, in the same way [N].
    - `loss`: of the fits [-].
    - `top`: the largest force measured [N].

    **Returns:** it [-].
    """
    rmse, left = judged(errors, loss), judged(unseen, loss)
    # others are compared on every reading: one that has no answer for some can't be among them
    left = left if np.all(np.isfinite(unseen) | ~np.isfinite(errors)) else float("nan")
    of = Candidate(label, names, method, constants, rmse, left, rmse / top, left / top, readings)
    return Trial(of, unseen, impossible)


def too_long(active: float, rest: float) -> str:
    """Why no muscle of the length `rest` [m] between its fittings has such an `active` one [m];
    empty where it can [-].
    """
    if active <= _LONGER * rest:
        return ""
    found, whole = pretty(active, "length"), pretty(rest, "length")
    return f"an active length of {found} in a muscle of {whole}"


def chosen(trials: Sequence[Trial], noise: float, loss: str) -> Trial:
    """Of those that are no worse than the best, the one with fewest constants.

    No worse is one whose squared errors exceed the best one's by no more than a standard error of
    their sum; or by 2 % of what the best one errs beyond the noise; or by what one reading has of
    them on average, since a constant may follow that much of any noise.

    **Arguments:**

    - `trials`: compared on the same readings [-].
    - `noise`: of a reading [N], as far as it is known.
    - `loss`: of the fits [-].

    **Returns:** one of them [-].

    **Raises:** `ValueError` where none could be judged.
    """
    tried = [one for one in trials if one.judged]
    if not any(one.candidate.constants for one in tried):  # the muscle as given needs no fit
        raise InvalidInputError(
            "record",
            "is too short to leave readings out",
            None,
            "name what to fit, such as c10, c01",
        )
    best = min(tried, key=lambda one: one.candidate.left_out_rmse)
    far = _OUTLIER * best.candidate.left_out_rmse if loss != "linear" else np.inf
    squares = [np.minimum(one.unseen[np.isfinite(one.unseen)] ** 2, far**2) for one in tried]
    least = squares[tried.index(best)]
    own = max(float(np.mean(least)) - noise**2, 0.0)
    good = []
    for one, square in zip(tried, squares, strict=True):
        worse = square - least
        chance = _DEVIATIONS * float(np.std(worse)) / np.sqrt(worse.size)
        share = float(np.mean(least)) / worse.size
        if float(np.mean(worse)) <= max(chance, ((1 + ALIKE) ** 2 - 1) * own, share):
            good.append(one)
    return min(good, key=lambda one: (one.candidate.constants, one.candidate.left_out_rmse))


def judged(errors: np.ndarray, loss: str) -> float:
    """The size of `errors` [N], NaN for clipped readings: their root mean square, or with a robust
    `loss` [-] what that is of most of them, so that outliers don't decide.
    """
    seen = errors[np.isfinite(errors)]
    if not seen.size:
        return float("nan")
    if loss != "linear":
        return 1.4826 * float(np.median(np.abs(seen)))
    return float(np.sqrt(np.mean(seen**2)))


def marked(trials: Sequence[Trial], best: Trial) -> tuple[Candidate, ...]:
    """The candidates of `trials` [-], the `best` one's [-] marked as chosen."""
    return tuple(replace(one.candidate, chosen=one is best) for one in trials)


def reasons(trials: Sequence[Trial], best: Trial, parts: str = "pressures") -> tuple[str, ...]:
    """Why the `best` [-] of `trials` [-] was taken, a line each; `parts` are what was left out."""
    tried = [one.candidate for one in trials if one.judged]
    all_can = not any(one.impossible for one in trials)
    first, second, *more = _reasons(tried, best.candidate, "" if all_can else " and can be")
    so = JUDGED.format(parts=parts)
    return (first, second, *differences(trials, best), *impossible(trials), *more, so)


def impossible(trials: Sequence[Trial]) -> Iterator[str]:
    """What of the `trials` [-] couldn't be taken, though it may err less, a line each."""
    for one in trials:
        if one.impossible:
            yield f"Not taken: {one.candidate.label}: {one.impossible} can't be."


def differences(trials: Sequence[Trial], best: Trial) -> Iterator[str]:
    """What each further constant is worth beside the `best` [-] of `trials` [-]: those that it
    could do without, and those that it does without.
    """
    by_names = {
        frozenset(one.candidate.names): one.candidate
        for one in trials
        if one.judged and one.candidate.method == "constants"
    }
    for name in dict.fromkeys(name for one in trials for name in one.candidate.names):
        yield from _difference(by_names, best.candidate, name, _WORDS.get(name, f"`{name}`"))


def _reasons(tried: Sequence[Candidate], best: Candidate, can: str) -> Iterator[str]:
    least = min(tried, key=lambda one: one.left_out_rmse)
    yield (
        f"Taken: {best.label} ({_numbers(best)}), wrong by {_share(best)} of the largest force"
        " where it was left out."
    )
    if least is best:
        yield f"None of the {len(tried)} that were fitted{can} is better there."
    else:
        yield (
            f"Least is {_share(least)}, with {least.label} ({_numbers(least)}): no better than"
            f" chance or {100 * ALIKE:g} % make it, so the fewest numbers are taken."
        )
    other = next((one for one in tried if one.label == TUNING and one is not best), None)
    if other is not None:
        yield f"The paper's tuning ({_numbers(other)}) is wrong by {_share(other)} there."


def _difference(
    by_names: Mapping[frozenset[str], Candidate], best: Candidate, name: str, what: str
) -> Iterator[str]:
    if best.method != "constants":
        return
    if name in best.names:
        less = by_names.get(frozenset(best.names) - {name})
        if less is not None:
            yield f"{what} takes it from {_share(less)} to {_share(best)}."
        return
    more = by_names.get(frozenset(best.names) | {name})
    if more is not None:
        yield f"{what} beside them would make it {_share(more)}, which doesn't pay."


def _share(one: Candidate) -> str:
    return f"{100 * one.relative_left_out_rmse:.3g} %"


def _numbers(one: Candidate) -> str:
    return f"{one.constants} number{'' if one.constants == 1 else 's'}"

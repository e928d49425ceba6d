"""Choosing among what was tried on a record, and saying why."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .candidates import BAND, LENGTH


ALIKE = 0.02  # of the least left-out error: candidates that near it are as good
TUNING = "the paper's tuning"
AS_GIVEN = "the muscle as given"


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


def chosen(rows: Sequence[Candidate]) -> Candidate:
    """Of those within 2 % of the least left-out error the one with fewest constants.

    **Arguments:** `rows`: compared on the same readings; those in which nothing is fitted are
    only there to compare [-].

    **Returns:** one of them [-].

    **Raises:** `ValueError` where none could be judged.
    """
    tried = [one for one in rows if one.constants and np.isfinite(one.left_out_rmse)]
    if not tried:
        raise ValueError(
            "`record` is too short to leave readings out: name what to fit, such as c10, c01."
        )
    least = min(one.left_out_rmse for one in tried)
    good = [one for one in tried if one.left_out_rmse <= (1 + ALIKE) * least]
    return min(good, key=lambda one: (one.constants, one.left_out_rmse))


def marked(rows: Sequence[Candidate], best: Candidate) -> tuple[Candidate, ...]:
    """`rows` [-] with the `best` [-] marked as chosen."""
    return tuple(replace(one, chosen=one is best) for one in rows)


def reasons(rows: Sequence[Candidate], best: Candidate) -> tuple[str, ...]:
    """Why the `best` [-] of `rows` [-] was taken, a line each."""
    return tuple(_reasons(rows, best))


def _reasons(rows: Sequence[Candidate], best: Candidate) -> Iterator[str]:
    tried = [one for one in rows if one.constants and np.isfinite(one.left_out_rmse)]
    least = min(tried, key=lambda one: one.left_out_rmse)
    yield (
        f"Taken: {best.label} ({_numbers(best)}), wrong by {_share(best)} of the largest force where"
        " it was left out."
    )
    if least is best:
        yield f"None of the {len(tried)} that were fitted is better there."
    else:
        yield (
            f"Least is {_share(least)}, with {least.label} ({_numbers(least)}): within"
            f" {ALIKE:.0%} of it the fewest numbers are taken."
        )
    by_names = {one.names: one for one in tried if one.method == "constants"}
    for name, what in ((BAND, "A dead band"), (LENGTH, "Another active length")):
        yield from _difference(by_names, best, name, what)
    other = next((one for one in tried if one.label == TUNING and one is not best), None)
    if other is not None:
        yield f"The paper's tuning ({_numbers(other)}) is wrong by {_share(other)} there."


def _difference(
    by_names: dict[tuple[str, ...], Candidate], best: Candidate, name: str, what: str
) -> Iterator[str]:
    if best.method != "constants":
        return
    if name in best.names:
        less = by_names.get(tuple(one for one in best.names if one != name))
        if less is not None:
            yield f"{what} takes it from {_share(less)} to {_share(best)}."
        return
    more = [one for names, one in by_names.items() if set(names) == {*best.names, name}]
    if more:
        yield f"{what} beside them doesn't pay: {_share(more[0])}."


def _share(one: Candidate) -> str:
    return f"{100 * one.relative_left_out_rmse:.3g} %"


def _numbers(one: Candidate) -> str:
    return f"{one.constants} number{'' if one.constants == 1 else 's'}"

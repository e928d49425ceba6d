"""Claims and comparisons with measured records on the terminal: a summary, and tables."""

import os
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fascicle.cli.errors import INCOMPLETE, user_errors
from fascicle.cli.terminal import print_line, status
from fascicle.io import atomic

from .claims import Claim, failed, summary


if TYPE_CHECKING:
    from .measurements import RecordComparison

__all__ = [
    "failed",
    "kim2021",
    "measurements",
    "print_claims",
    "print_comparisons",
    "verdict_lines",
]


_MAX_NAMES = 2  # files of a kind that are named; more are counted


def print_written(folder: Path, names: Sequence[str]) -> None:
    """Print a `folder` and the `names` of the files written into it, or how many of a kind."""
    kinds = Counter(Path(name).suffix for name in names)
    pages = [name for name in names if kinds[Path(name).suffix] <= _MAX_NAMES]
    groups = [f"{kinds[kind]} {kind[1:]}" for kind in kinds if kinds[kind] > _MAX_NAMES]
    print_line(f"wrote {folder}{os.sep}: {', '.join([*pages, *groups])}")


def measurements(folder: Path, overwrite: bool) -> int:
    """Compare every law with every measured record that is available; returns the exit code."""
    from . import measurements

    with status("reading the records"):
        records = measurements.measured_records()
    omitted: dict[str, list[str]] = {}  # names by reason
    for record in records:
        if record.left_out:
            omitted.setdefault(record.left_out, []).append(record.name)
    if is_measured := any(not record.left_out for record in records):
        comparisons, names = _write(
            folder, overwrite, lambda draft, update: measurements.run(draft, records, update)
        )
        print_comparisons(comparisons)
        print_line(measurements.UNTESTED[0])
        print_written(folder, names)
    for reason, names in omitted.items():
        print_line(f"omitted, {reason}: {', '.join(names)}")
    if not is_measured:
        print_line(measurements.no_records_message())
    return INCOMPLETE if omitted else 0


def kim2021(folder: Path, overwrite: bool) -> int:
    """Draw the paper's figures, and check its claims; returns the exit code."""
    from .kim2021 import reproduction

    def run(draft: Path, update: Callable[[str], None]) -> list[Claim]:
        def show(done: int, total: int, figure: str) -> None:
            update(f"{figure}, {done} of {total}")

        return reproduction.run(draft, show)

    claims, names = _write(folder, overwrite, run)
    print_claims(claims)
    print_written(folder, names)
    return 1 if failed(claims) else 0


def _write(
    folder: Path, overwrite: bool, run: Callable[[Path, Callable[[str], None]], list[Any]]
) -> tuple[list[Any], list[str]]:
    """Results of a `run`, and the names of the files that it wrote into the folder."""
    results: list[Any] = []
    with user_errors("--out "), status("computing") as update:

        def fill(draft: Path) -> None:
            results.extend(run(draft, update))

        return results, atomic.write_folder(folder, fill, overwrite)


def verdict_lines(claims: Sequence[Claim]) -> list[str]:
    """Verdict on a paper's `claims`: the counts, then claims that fail, differ, or depend on how
    the paper is read.
    """
    failures = failed(claims)
    differing = [claim for claim in claims if claim.verdict == "differs"]
    depending = [claim for claim in claims if claim.opposite_readings]
    close = [claim for claim in claims if any(number.close for number in claim.criteria)]
    counts = f"{len(failures)} claim{'s fail' if len(failures) > 1 else ' fails'}"
    groups = {
        "Fail": failures,
        "Differ, for a reason that the report gives": differing,
        "Depend on how the paper is read": depending,
        "Decided by a limit that the paper does not give": close,
    }
    return [
        f"Verdict: {counts if failures else 'no claim fails'}. {summary(claims)}",
        *(
            f"{title}: {', '.join(f'{claim.key} ({claim.place})' for claim in group)}."
            for title, group in groups.items()
            if group
        ),
    ]


def print_claims(claims: Sequence[Claim]) -> None:
    """Print the verdict; the report has each claim with the numbers that decide on it."""
    for line in verdict_lines(claims):
        print_line(line)


def print_comparisons(comparisons: "Sequence[RecordComparison]") -> None:
    """Print each measured record's best law, its error and what it misses."""
    for comparison in comparisons:
        name, best = comparison.measured.name, comparison.laws[0]
        print_line(
            f"{name}: best of {len(comparison.laws)} fits: {best.row.label}, error"
            f" {best.row.relative_rmse:.2%} of the largest force,"
            f" {best.row.relative_left_out_rmse:.2%} at readings left out of the fit;"
            f" {best.misses}"
        )

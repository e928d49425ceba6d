"""The whole reproduction: every figure computed, drawn, written, and its claims reported."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from fascicle.io.atomic import write_text

from ..claims import Claim, Reading
from ..reproduced import Record, Written, write_record
from . import (
    alternatives,
    figure_02,
    figure_03,
    figure_04,
    figure_05,
    figure_06,
    figure_07,
    figure_08,
    figure_09,
    figure_10,
    figure_12,
    figure_12_calibrated,
    figure_13,
    figure_14,
    setting,
)
from .report import claims_file, report


Progress = Callable[[int, int, str], object]
Compute = Callable[[], Record]

FIGURES: tuple[Compute, ...] = tuple(
    module.compute
    for module in (
        figure_02, figure_03, figure_04, figure_05, figure_06, figure_07, figure_08, figure_09,
        figure_10, figure_12, figure_12_calibrated, figure_13, figure_14,
    )
)  # fmt: skip
# calibrated records are no claims of the paper, and take longest
CLAIMING: tuple[Compute, ...] = tuple(
    one for one in FIGURES if one is not figure_12_calibrated.compute
)
ALTERNATIVES: tuple[Compute, ...] = alternatives.RECORDS


def by_readings() -> dict[str, dict[str, Claim]]:
    """Claims by their keys, by each of the paper's other readings."""
    _, *others = setting.READINGS  # the first is that of every figure
    found = {}
    for name in others:
        with setting.reading(name):
            found[name] = {claim.key: claim for one in CLAIMING for claim in one().claims}
    return found


def with_readings(
    claims: Iterable[Claim], readings: Mapping[str, Mapping[str, Claim]]
) -> tuple[Claim, ...]:
    """Claims with what the other `readings` [-] say of each, of those that have it."""
    return tuple(
        replace(
            claim,
            readings=tuple(
                Reading(name, other.holds, tuple(one.text for one in other.criteria))
                for name, others in readings.items()
                if (other := others.get(claim.key)) is not None
            ),
        )
        for claim in claims
    )


def run(out: Path, progress: Progress | None = None) -> list[Claim]:
    """Make everything in folder `out`; see `fascicle.reproduce.kim2021.run`."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    told = progress or (lambda _done, _total, _what: None)
    steps = (*FIGURES, *ALTERNATIVES)
    written: dict[Compute, Written] = {}
    told(0, len(steps), "computing")
    readings = by_readings()
    for compute in steps:
        record = compute()
        record = replace(record, claims=with_readings(record.claims, readings))
        told(len(written), len(steps), record.name)
        written[compute] = write_record(record, folder)
    figures = [written[compute] for compute in FIGURES]
    second = [written[compute] for compute in ALTERNATIVES]
    claims = [claim for one in figures for claim in one.record.claims]
    write_text(folder / "claims.json", claims_file(claims))
    write_text(folder / "report.html", report(figures, second))
    told(len(steps), len(steps), "done")
    return claims

"""The whole reproduction: every figure computed, drawn and written, its claims reported."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from fascicle.io.atomic import write_text

from ..claims import Claim, Reading
from ..figures import PaperFigure, WrittenFigure, write_figure
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


Compute = Callable[[], PaperFigure]

FIGURES: tuple[Compute, ...] = tuple(
    module.compute
    for module in (
        figure_02, figure_03, figure_04, figure_05, figure_06, figure_07, figure_08, figure_09,
        figure_10, figure_12, figure_12_calibrated, figure_13, figure_14,
    )
)  # fmt: skip
# calibrated records are no claims of the paper, and take longest
CLAIMING: tuple[Compute, ...] = tuple(c for c in FIGURES if c is not figure_12_calibrated.compute)
ALTERNATIVES: tuple[Compute, ...] = alternatives.FIGURES


def run(out: Path, progress: Callable[[int, int, str], object] | None = None) -> list[Claim]:
    """Make every figure, its data, the claims as `claims.json`, and the report.

    **Arguments:**

    - `out`: the folder, which is made if it isn't there; files in it are replaced.
    - `progress`: called with the steps done, their number, and the name of the present one.

    **Returns:** the claims, in the order of the figures.

    **Raises:** `OSError` where something can't be written.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    show = progress or (lambda _done, _total, _name: None)
    steps = (*FIGURES, *ALTERNATIVES)
    written: list[WrittenFigure] = []
    show(0, len(steps), "computing")
    readings = claims_by_reading()
    for compute in steps:
        figure = compute()
        figure = replace(figure, claims=add_readings(figure.claims, readings))
        show(len(written), len(steps), figure.name)
        written.append(write_figure(figure, folder))
    figures, others = written[: len(FIGURES)], written[len(FIGURES) :]
    claims = [claim for entry in figures for claim in entry.figure.claims]
    write_text(folder / "claims.json", claims_file(claims))
    write_text(folder / "report.html", report(figures, others))
    show(len(steps), len(steps), "done")
    return claims


def claims_by_reading() -> dict[str, dict[str, Claim]]:
    """Claims by their keys, by each of the paper's other readings."""
    _, *others = setting.READINGS  # first that of every figure
    claims = {}
    for name in others:
        with setting.reading(name):
            claims[name] = {claim.key: claim for compute in CLAIMING for claim in compute().claims}
    return claims


def add_readings(
    claims: Iterable[Claim], readings: Mapping[str, Mapping[str, Claim]]
) -> tuple[Claim, ...]:
    """Add to each claim its verdict by the other `readings`."""
    return tuple(
        replace(
            claim,
            readings=tuple(
                Reading(
                    name,
                    setting.READINGS[name].condition,
                    other.holds,
                    tuple(number.text for number in other.criteria),
                )
                for name, others in readings.items()
                if (other := others.get(claim.key)) is not None
            ),
        )
        for claim in claims
    )

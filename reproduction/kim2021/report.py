"""The report: each figure with its conditions, the claims about it, and what came out.

It is one file that holds its pictures and its data: it can be sent as it is.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fascicle.plot.theme import DOUBLE
from fascicle.report.page import Picture, data_uri, downloads, render, screen_width

from ..claims import KINDS, Claim, claims_data, remarks, summary
from ..figures import WrittenFigure
from . import alternatives, setting


PAPER = (
    "J. Y. Kim, N. Mazzoleni, M. Bryant: Modeling of Resistive Forces and Buckling Behavior in "
    "Variable Recruitment Fluidic Artificial Muscle Bundles. Actuators 10, 42 (2021), "
    "doi 10.3390/act10030042, CC BY."
)


def report(figures: Sequence[WrittenFigure], others: Sequence[WrittenFigure] = ()) -> str:
    """The page: every figure and every claim, then the `others`, of other laws and readings."""
    claims = [claim for entry in figures for claim in entry.figure.claims]
    compared: dict[str, Any] = {}
    if others:
        compared = {
            "sizes": setting.sizes(setting.muscle("figure_6")),
            "variants": [label for label, _ in alternatives.VARIANTS.values()],
            "comparison": alternatives.comparison(),
            "conclusions": alternatives.conclusions(),
        }
    return render(
        "report.html", Path(__file__).parent, title="Kim, Mazzoleni and Bryant 2021, reproduced",
        footer=PAPER + " Pictures, data and claims computed by fascicle.",
        summary=summary(claims), remarks=remarks(claims), kinds=KINDS, claims=claims,
        differing=[claim for claim in claims if claim.verdict in ("differs", "fails")],
        numbers={claim.key: number for number, claim in enumerate(claims, start=1)},
        sections={claim.key: entry.figure.key for entry in figures for claim in
                  entry.figure.claims},
        figures=[_entry(figure) for figure in figures], others=[_entry(other) for other in others],
        files=downloads({"claims.json": claims_file(claims).encode()}), **compared,
    )  # fmt: skip


def claims_file(claims: Sequence[Claim]) -> str:
    """The `claims` with their numbers, as JSON."""
    data = {"paper": PAPER, **claims_data(claims)}
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _entry(written: WrittenFigure) -> dict[str, Any]:
    width = screen_width(min(written.width, DOUBLE))
    return {
        "figure": written.figure,
        "picture": Picture(data_uri(written.svg, "svg"), width),
        "downloads": downloads(written.tables),
    }

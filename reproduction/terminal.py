"""Claims and comparisons with measured records, as tables on the terminal."""

import sys
from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from fascicle.cli.outputs import print_line, print_table

from .claims import KINDS, Claim, failed, of_kind, remarks, summary


if TYPE_CHECKING:
    from .measurements import RecordComparison

__all__ = ["failed", "print_claims", "print_comparisons"]

_STYLES = {
    "holds": "green", "chosen": "", "by definition": "", "differs": "yellow", "fails": "bold red",
}  # fmt: skip
_WIDEST = 40  # characters of a law's label in a line


def print_claims(claims: Sequence[Claim]) -> None:
    """Print each claim with the number that decides, kind by kind; what differs; and the sum."""
    console = Console(file=sys.stdout, highlight=False)
    for kind, about in KINDS.items():
        chosen = of_kind(claims, kind)
        if not chosen:
            continue
        console.print(Text(f"{kind.capitalize()}s: {about}", style="bold"))
        table = Table(box=SIMPLE_HEAD, pad_edge=False)
        for head in ("where", "verdict", "claim, and the paper's words", "criterion"):
            table.add_column(head)
        for claim in chosen:
            verdict = Text(claim.verdict, style=_STYLES[claim.verdict])
            words = Text.assemble(claim.text, (f" “{claim.quote}”", "dim"))
            table.add_row(Text(claim.place), verdict, words, Text(_criteria(claim)))
        console.print(table)
    for claim in claims:
        if not claim.holds:
            text = f"{claim.verdict}: {claim.text} {claim.outcome} {claim.explanation}".rstrip()
            console.print(Text(text, style=_STYLES[claim.verdict]), soft_wrap=False)
    for sentence in (*remarks(claims), summary(claims)):
        console.print(Text(sentence), soft_wrap=True)


def _criteria(claim: Claim) -> str:
    lines = [f"{criterion.text}{criterion.limit_note}" for criterion in claim.criteria]
    if claim.choice and claim.holds:
        lines.append(f"chosen: {claim.choice}")
    return "; ".join(lines)


def print_comparisons(comparisons: "Sequence[RecordComparison]") -> None:
    """Print every law's errors for each measured record, and what the best law misses."""
    heads = ["", "free", "rmse", "left out", "along pressure", "along strain"]
    for comparison in comparisons:
        rows = [
            [fill(law.row.label, _WIDEST), str(law.row.free), f"{law.row.relative_rmse:.2%}",
             f"{law.row.relative_left_out_rmse:.2%}",
             *(f"{low:+.3g} to {high:+.3g} N" for low, high in
               (law.along_pressure, law.along_strain))]
            for law in comparison.laws
        ]  # fmt: skip
        name = comparison.measured.name
        print_table(f"{name}: error over the largest force, mean residuals", heads, rows)
        best = comparison.laws[0]
        print_line(f"{best.row.label}: {best.misses or 'six numbers without physics'}")

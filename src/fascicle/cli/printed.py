"""Tables for a reader: numbers to four figures, as many columns as the terminal takes."""

import math
import sys
from collections.abc import Sequence
from typing import Any

from ..core.visible import visible


def show(
    title: str, heads: Sequence[str], rows: Sequence[Sequence[str]], caption: str = ""
) -> None:
    """Print a table; columns that don't fit follow below, beside the first one again.

    **Arguments:**

    - `title`: what it shows, with the unit [-].
    - `heads`: the columns' names [-].
    - `rows`: their entries [-], of a line or a few.
    - `caption`: what its marks mean [-].
    """
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(file=sys.stdout, highlight=False, markup=False)
    # each column's text, with the space and the line between it and the next
    widths = [
        max(len(line) for entry in column for line in entry.split("\n")) + 3
        for column in zip(heads, *rows, strict=True)
    ]
    for columns in _blocks(widths, console.width - 2):
        console.print(Text(title, style="bold"))
        table = Table(box=SIMPLE_HEAD, pad_edge=False)
        for index in columns:
            table.add_column(Text(heads[index]), justify="right", no_wrap=True)
        for row in rows:
            table.add_row(*(Text(_seen(row[index])) for index in columns))
        console.print(table)
    if caption:
        console.print(Text(caption))


def _seen(entry: str) -> str:
    """An entry of which every sign can be seen, line by line."""
    return "\n".join(visible(line) for line in entry.split("\n"))


def decimals(values: Any) -> int:
    """How many decimals [-] show the largest of `values` [any unit] to four figures."""
    finite = (abs(float(value)) for value in values if math.isfinite(value))
    largest = max(finite, default=1.0)
    return min(max(3 - math.floor(math.log10(largest or 1.0)), 0), 9)


def number(value: float, places: int) -> str:
    """`value` [any unit] with `places` decimals [-]; "-" where there is none."""
    if not math.isfinite(value):
        return "-"
    return f"{round(float(value), places) + 0.0:.{places}f}"  # + 0.0: no minus before a zero


def _blocks(widths: Sequence[int], room: int) -> list[list[int]]:
    """Columns in groups that fit, each with the first one, which names the rows."""
    blocks, used = [[0]], widths[0]
    for index, width in enumerate(widths[1:], start=1):
        if used + width > room and len(blocks[-1]) > 1:
            blocks.append([0])
            used = widths[0]
        blocks[-1].append(index)
        used += width
    return blocks

"""Tables for a reader: numbers to four figures, as many columns as the terminal takes."""

import math
import os
import sys
from collections.abc import Sequence
from typing import Any

from ..io.sanitize import escape_invisible, sanitize_line


_LONGEST = 2000  # characters of a line that holds words of others


def show(
    title: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    caption: str = "",
    keys: int = 1,
) -> None:
    """Print a table; columns that don't fit follow below, beside the first ones again.

    **Arguments:**

    - `title`: what it shows, with the unit [-].
    - `heads`: the columns' names [-].
    - `rows`: their entries [-], of a line or a few.
    - `caption`: what its marks mean [-].
    - `keys`: how many first columns name a row [-].
    """
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    title, caption = sanitize_line(title, _LONGEST), sanitize_line(caption, _LONGEST)
    heads = [escape_invisible(head) for head in heads]
    console = Console(file=sys.stdout, highlight=False, markup=False)
    spaces = 3  # between two columns
    widths = _widths(heads, rows)
    if not console.is_terminal and not os.environ.get("COLUMNS"):
        console.width = max(console.width, sum(widths) + spaces * len(widths) + 2)
    if sum(widths) + spaces * len(widths) > console.width - 2:  # narrow: heads of two lines
        heads, spaces = [_folded(head) for head in heads], 1
        widths = _widths(heads, rows)
    if sum(widths) + spaces * len(widths) > console.width - 1:  # narrower: marks at their number
        heads, *rows = _closer([heads, *rows])
        widths = _widths(heads, rows)
    for columns in _blocks([width + spaces for width in widths], console.width - 1, keys):
        console.print(Text(title, style="bold"))
        table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, spaces // 2, 0, spaces // 2))
        for index in columns:
            table.add_column(Text(heads[index]), justify="right", no_wrap=True)
        for row in rows:
            table.add_row(*(Text(_seen(row[index])) for index in columns))
        console.print(table)
    if caption:
        console.print(Text(caption))


def listed(text: str) -> str:
    """A `text` [-] as an entry of a list, on a terminal as wide as it and drawn in."""
    import shutil
    from textwrap import wrap

    width = shutil.get_terminal_size().columns - 3 if sys.stdout.isatty() else 10**6
    return "- " + "\n  ".join(
        wrap(sanitize_line(text, _LONGEST), max(width, 20), break_long_words=False)
    )


def _folded(head: str) -> str:
    """A head's words below one another; spaces at its end, which keep a place, stay at each."""
    end = " " * (len(head) - len(head.rstrip()))
    return "\n".join(word + end for word in head.split())


def _closer(table: Sequence[Sequence[str]]) -> list[list[str]]:
    """A table whose marks, where all of a column have room for one, stand right at the number."""
    columns = []
    for column in zip(*table, strict=True):
        lines = [line for entry in column for line in entry.split("\n")]
        apart = all(line[-2:-1] == " " for line in lines)
        columns.append([_drawn_up(entry) if apart else entry for entry in column])
    return [list(row) for row in zip(*columns, strict=True)]


def _drawn_up(entry: str) -> str:
    """An entry's lines without the space before their last sign."""
    return "\n".join(line[:-2] + line[-1:] for line in entry.split("\n"))


def _widths(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int]:
    """The longest line of each column."""
    return [
        max(len(line) for entry in column for line in entry.split("\n"))
        for column in zip(heads, *rows, strict=True)
    ]


def _seen(entry: str) -> str:
    """An entry of which every sign can be seen, line by line."""
    return "\n".join(sanitize_line(line) for line in entry.split("\n"))


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


def _blocks(widths: Sequence[int], room: int, keys: int) -> list[list[int]]:
    """Columns in groups that fit, each with the first ones, which name the rows."""
    first, own = [*range(keys)], sum(widths[:keys])
    blocks, used = [first[:]], own
    for index, width in enumerate(widths[keys:], start=keys):
        if used + width > room and len(blocks[-1]) > keys:
            blocks.append(first[:])
            used = own
        blocks[-1].append(index)
        used += width
    return blocks

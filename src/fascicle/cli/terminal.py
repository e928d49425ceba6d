"""Output of commands: lines, tables for readers, numbers, and progress."""

import contextlib
import math
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ..io.sanitize import escape_invisible, sanitize_line


if TYPE_CHECKING:
    import numpy as np
    from rich.console import Console

_MAX_LINE = 2000  # characters of a line with foreign text, such as file names
_USUAL_WIDTH = 80
_MAX_WIDTH = 10**5  # characters of a table's line in a file: no limit in practice


def print_line(line: str, error: bool = False) -> None:
    """Print a line with foreign text, such as file names, to standard output or error."""
    print(sanitize_line(line, _MAX_LINE), file=sys.stderr if error else sys.stdout)


def print_text(text: str, style: str = "") -> None:
    """Print a paragraph, wrapped at words on a narrow terminal."""
    from rich.text import Text

    _console().print(Text(sanitize_line(text, _MAX_LINE), style=style))


def _console() -> "Console":
    """Console of standard output, without a limit of width in a file."""
    from rich.console import Console

    console = Console(file=sys.stdout, highlight=False, markup=False)
    if not console.is_terminal and not os.environ.get("COLUMNS"):
        console.width = _MAX_WIDTH
    if console.width < 1:  # a terminal that doesn't know
        console.width = _USUAL_WIDTH
    return console


def print_table(
    title: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    caption: str = "",
    keys: int = 1,
) -> None:
    """Print a table; columns that don't fit follow below, with the first `keys` columns again.

    Cells have one line or several.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    console = _console()
    unlimited = console.options.update(max_width=_MAX_WIDTH)
    labels = [escape_invisible(head) for head in heads]
    texts = [["\n".join(map(sanitize_line, cell.split("\n"))) for cell in row] for row in rows]
    first, columns = [*range(keys)], [*range(keys, len(heads))]

    def build(columns: Sequence[int], narrow: bool) -> Table:
        """Table of some columns; a narrow one has heads broken at spaces, and no padding."""
        table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 0 if narrow else 1))
        for column in columns:
            label = labels[column].replace(" ", "\n") if narrow else labels[column]
            table.add_column(Text(label), justify="right", no_wrap=True)
        for row in texts:
            table.add_row(*(Text(row[column]) for column in columns))
        return table

    def width(columns: Sequence[int], narrow: bool) -> int:
        return build(columns, narrow).__rich_measure__(console, unlimited).maximum

    parts = [columns]
    if narrow := width([*first, *columns], False) >= console.width:
        parts, room = [], 0
        for column in columns:
            needed = width([column], True) - 1  # without the left edge
            if needed > room:
                parts, room = [*parts, []], console.width - width(first, True)
            parts[-1].append(column)
            room -= needed
    for index, part in enumerate(parts):
        print_text(f"{title}{' (continued)' if index else ''}", "bold")
        console.print(build([*first, *part], narrow))
    if caption:
        print_text(caption)


def count_decimals(values: Any) -> int:
    """Decimals that show the largest of `values` to four figures."""
    largest = max((abs(float(x)) for x in values if math.isfinite(x)), default=1.0)
    return min(max(3 - math.floor(math.log10(largest or 1.0)), 0), 9)


def grid(values: "np.ndarray", decimals: int | None = None) -> list[list[str]]:
    """Texts of a matrix, all with the same decimals; default: four figures of the largest."""
    count = count_decimals(values.ravel()) if decimals is None else decimals
    return [[number(value, count) for value in row] for row in values]


def kpa(pressure: float) -> str:
    """A pressure [Pa] in kPa."""
    return f"{pressure / 1e3:.6g}"


def number(value: float, decimals: int) -> str:
    """A value with so many decimals; "-" if it is not finite."""
    if not math.isfinite(value):
        return "-"
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"  # + 0.0: no minus before a zero


@contextlib.contextmanager
def status(text: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal what is being done, and for how long; gives a function that updates it."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    console = Console(stderr=True, markup=False)
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(sanitize_line(text), total=None)
        yield lambda text: progress.update(task, description=sanitize_line(text), refresh=True)

"""Tables that objects print: a title, sizes and laws, a small table.

`print(muscle)` prints the text, and a notebook shows it. Numbers have their units; a long table
shows its ends. Traced objects, under `jax.jit`, have no numbers: Python's own text replaces the
table.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .core.validation import is_concrete
from .units import format_digits


_MAX_ROWS = 12  # as many as fit on a screen beside the code


class ReprTable(NamedTuple):
    """A `title`, `facts` by name, a table of `rows` under `heads`, and `notes`."""

    title: str
    facts: Sequence[tuple[str, str]] = ()
    heads: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()

    def text(self) -> str:
        """Table as lines of text."""
        width = max((len(name) for name, _ in self.facts), default=0)
        blocks = [[self.title, *(f"  {name:<{width}}  {value}" for name, value in self.facts)]]
        if self.rows:
            table = [self.heads, *_ends(self.rows)]
            widths = [max(map(len, column)) for column in zip(*table, strict=True)]
            blocks.append(["  " + "  ".join(map(str.rjust, row, widths)).rstrip() for row in table])
        if self.notes:
            blocks.append([f"  {note}" for note in self.notes])
        return "\n\n".join("\n".join(block) for block in blocks)


def with_table_repr(
    table: Callable[[Any], ReprTable], line: Callable[[Any], str] | None = None
) -> Callable:
    """Class decorator: `print` and notebooks show a text table, `repr` one line. `table`, `line`:
    functions of an object that return them; default of `line`: Python's `repr`.
    """

    def decorate(kind: Any) -> Any:
        default, short = kind.__repr__, line or kind.__repr__
        kind.__repr__ = lambda obj: short(obj) if is_concrete(obj) else default(obj)
        kind.__str__ = lambda obj: table(obj).text() if is_concrete(obj) else default(obj)
        kind._repr_pretty_ = lambda obj, printer, _: printer.text(str(obj))
        return kind

    return decorate


def format_range(values: Any, show: Callable[[float], str]) -> str:
    """Text of one number, or of the range and count of several."""
    x = np.asarray(values, float)
    if x.ndim == 0:
        return show(float(x))
    if not x.size:
        return "none"
    return f"{show(float(x.min()))} to {show(float(x.max()))}, {x.size} of them"


def title_with_shape(title: str, points: Any) -> str:
    """A title with the shape of an array of `points`, unless it is a single one."""
    shape = np.shape(points)
    if shape == ():
        return title
    order = ", the last axis runs first" if len(shape) > 1 else ""
    return f"{title}, {' × '.join(map(str, shape))} points{order}"


def format_number(value: float, digits: int = 4) -> str:
    """A number in a table: four digits, "-" for NaN."""
    # adding zero turns -0 into 0
    return "-" if np.isnan(value) else format_digits(float(value) + 0.0, digits)


def _ends(rows: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """Rows of a table; of a long one the first and the last."""
    if len(rows) <= _MAX_ROWS:
        return list(rows)
    half = _MAX_ROWS // 2
    omission = f"… {len(rows) - 2 * half} more"
    return [*rows[:half], [omission, *[""] * (len(rows[0]) - 1)], *rows[-half:]]

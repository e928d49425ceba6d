"""Tables that objects print: a title, sizes and laws, a small table; in notebooks too.

`print(muscle)` prints the text, and a notebook shows the HTML. Numbers have their units; a long
table shows its ends. Traced objects, under `jax.jit`, have no numbers: Python's own text replaces
the table.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

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
            blocks.append(_aligned_lines(self.heads, _ends(self.rows)))
        if self.notes:
            blocks.append([f"  {note}" for note in self.notes])
        return "\n\n".join("\n".join(block) for block in blocks)

    def html(self) -> str:
        """Table as a piece of HTML."""
        facts = "".join(
            f'<tr><th style="text-align:left;padding-right:1em">{_escape_html(name)}</th>'
            f'<td style="text-align:left">{_escape_html(value)}</td></tr>'
            for name, value in self.facts
        )
        # digits are aligned, also on a page without a style for tables
        style = 'style="text-align:right;padding:0 0.6em;font-variant-numeric:tabular-nums"'
        heads = "".join(f"<th {style}>{_escape_html(head)}</th>" for head in self.heads)
        rows = "".join(
            "<tr>" + "".join(f"<td {style}>{_escape_html(entry)}</td>" for entry in row) + "</tr>"
            for row in _ends(self.rows)
        )
        table = f"<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
        return (
            f"<div><strong>{_escape_html(self.title)}</strong>"
            + (f"<table><tbody>{facts}</tbody></table>" if facts else "")
            + (table if rows else "")
            + "".join(f"<p>{_escape_html(note)}</p>" for note in self.notes)
            + "</div>"
        )


def with_table_repr(
    table: Callable[[Any], ReprTable], line: Callable[[Any], str] | None = None
) -> Callable:
    """Decorator of a class whose objects print as a table. `table`: function of an object that
    returns its table; `line`: that returns its `repr`, default: Python's.
    """

    def decorate(kind: Any) -> Any:
        default = kind.__repr__
        if line is not None:
            kind.__repr__ = _if_concrete(line, default)
        kind.__str__ = _if_concrete(lambda obj: table(obj).text(), default)
        kind._repr_html_ = _if_concrete(
            lambda obj: table(obj).html(), lambda obj: f"<pre>{_escape_html(default(obj))}</pre>"
        )
        kind._repr_pretty_ = lambda obj, printer, _: printer.text(str(obj))
        return kind

    return decorate


def format_range(values: Any, show: Callable[[float], str]) -> str:
    """Text of one number, or of the range and count of several."""
    import numpy as np

    x = np.asarray(values, float)
    if x.ndim == 0:
        return show(float(x))
    if not x.size:
        return "none"
    return f"{show(float(x.min()))} to {show(float(x.max()))}, {x.size} of them"


def title_with_shape(title: str, points: Any) -> str:
    """A title with the shape of an array of `points`, unless it is a single one."""
    shape = points.shape if hasattr(points, "shape") else ()
    if shape == ():
        return title
    order = ", the last axis runs first" if len(shape) > 1 else ""
    return f"{title}, {' × '.join(map(str, shape))} points{order}"


def format_number(value: float, digits: int = 4) -> str:
    """A number in a table: four digits, "-" for NaN."""
    value = float(value)
    return "-" if value != value else format_digits(value + 0.0, digits)  # noqa: PLR0124 NaN


def _if_concrete(concrete: Callable[[Any], str], traced: Callable[[Any], str]) -> Callable:
    return lambda obj: concrete(obj) if is_concrete(obj) else traced(obj)


def _ends(rows: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """Rows of a table; of a long one the first and the last."""
    if len(rows) <= _MAX_ROWS:
        return list(rows)
    half = _MAX_ROWS // 2
    omission = f"… {len(rows) - 2 * half} more"
    return [*rows[:half], [omission, *[""] * (len(rows[0]) - 1)], *rows[-half:]]


def _aligned_lines(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    table = [heads, *rows]
    widths = [max(len(row[i]) for row in table) for i in range(len(heads))]
    return [
        "  " + "  ".join(f"{entry:>{w}}" for entry, w in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]


def _escape_html(text: str) -> str:
    import html  # rarely needed

    return html.escape(text)

"""Printed objects: a title, its sizes and laws in words, a small table; in notebooks too.

`print(muscle)` shows it, and a notebook shows it as a table of its own. Numbers stand with their
units, and a long table shows its ends. Under `jax.jit` there are no numbers to show: Python's own
words stand there.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from .core.validation import is_concrete
from .units import figures


_MOST_ROWS = 12


class ReprTable(NamedTuple):
    """A `title`, `facts` by name, a table of `rows` under `heads`, and what to `notes`."""

    title: str
    facts: Sequence[tuple[str, str]] = ()
    heads: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()

    def text(self) -> str:
        """Table as lines of text."""
        width = max((len(name) for name, _ in self.facts), default=0)
        parts = [[self.title, *(f"  {name:<{width}}  {value}" for name, value in self.facts)]]
        if self.rows:
            parts.append(_lines(self.heads, _ends(self.rows)))
        if self.notes:
            parts.append([f"  {note}" for note in self.notes])
        return "\n\n".join("\n".join(part) for part in parts)

    def html(self) -> str:
        """Table as a piece of HTML."""
        facts = "".join(
            f'<tr><th style="text-align:left;padding-right:1em">{_safe(name)}</th>'
            f'<td style="text-align:left">{_safe(value)}</td></tr>'
            for name, value in self.facts
        )
        # numbers under one another, also where a page has no style of its own for tables
        room = 'style="text-align:right;padding:0 0.6em;font-variant-numeric:tabular-nums"'
        heads = "".join(f"<th {room}>{_safe(head)}</th>" for head in self.heads)
        rows = "".join(
            "<tr>" + "".join(f"<td {room}>{_safe(entry)}</td>" for entry in row) + "</tr>"
            for row in _ends(self.rows)
        )
        table = f"<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
        return (
            f"<div><strong>{_safe(self.title)}</strong>"
            + (f"<table><tbody>{facts}</tbody></table>" if facts else "")
            + (table if rows else "")
            + "".join(f"<p>{_safe(note)}</p>" for note in self.notes)
            + "</div>"
        )


def with_table_repr(
    sheet: Callable[[Any], ReprTable], line: Callable[[Any], str] | None = None
) -> Callable:
    """A decorator of a class whose objects print as a sheet.

    **Arguments:**

    - `sheet`: makes it of an object.
    - `line`: says it in one line, for `repr`; left out, Python's own words.

    **Returns:** the decorator.
    """

    def of(kind: Any) -> Any:
        own = kind.__repr__
        if line is not None:
            kind.__repr__ = _if_concrete(line, own)
        kind.__str__ = _if_concrete(lambda thing: sheet(thing).text(), own)
        kind._repr_html_ = _if_concrete(
            lambda thing: sheet(thing).html(), lambda thing: f"<pre>{_safe(own(thing))}</pre>"
        )
        kind._repr_pretty_ = lambda thing, printer, _: printer.text(str(thing))
        return kind

    return of


def format_range(values: Any, show: Callable[[float], str]) -> str:
    """One number as `show` writes it, or how far several reach and how many there are."""
    import numpy as np

    x = np.asarray(values, float)
    if x.ndim == 0:
        return show(float(x))
    if not x.size:
        return "none"
    return f"{show(float(x.min()))} to {show(float(x.max()))}, {x.size} of them"


def title_with_shape(title: str, points: Any) -> str:
    """A `title` with how many `points` there are, where it isn't one."""
    shape = points.shape if hasattr(points, "shape") else ()
    if shape == ():
        return title
    order = ", the last axis runs first" if len(shape) > 1 else ""
    return f"{title}, {' × '.join(map(str, shape))} points{order}"


def format_number(value: float, digits: int = 4) -> str:
    """A number as a table shows it: four figures, "-" where there is none."""
    value = float(value)
    return "-" if value != value else figures(value + 0.0, digits)  # noqa: PLR0124 NaN


def _if_concrete(shown: Callable[[Any], str], otherwise: Callable[[Any], str]) -> Callable:
    return lambda thing: shown(thing) if is_concrete(thing) else otherwise(thing)


def _ends(rows: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """The rows, those in the middle of many left out."""
    if len(rows) <= _MOST_ROWS:
        return list(rows)
    half = _MOST_ROWS // 2
    left_out = f"… {len(rows) - 2 * half} more"
    return [*rows[:half], [left_out, *[""] * (len(rows[0]) - 1)], *rows[-half:]]


def _lines(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    table = [heads, *rows]
    widths = [max(len(row[i]) for row in table) for i in range(len(heads))]
    return [
        "  " + "  ".join(f"{entry:>{w}}" for entry, w in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]


def _safe(text: str) -> str:
    import html  # which nobody needs who prints no page

    return html.escape(text)

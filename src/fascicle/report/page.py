"""Self-contained HTML pages from templates: one file each, which opens offline and prints well.

A page loads nothing from outside: the style is in its head, pictures and files are in their
addresses. Links lead to places on the page or to files beside it. `templates/page.html` is the
frame of all pages.
"""

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from ..io.sanitize import escape_invisible
from ..plot.theme import LIGHT, css, to_bytes


if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TEMPLATES = Path(__file__).with_name("templates")
_MILLIMETERS = 25.4 * 1.35  # of an inch in print: a screen is read from further away than a page
_MEDIA = {"svg": "image/svg+xml", "png": "image/png", "csv": "text/csv", "json": "application/json"}
_VERDICTS = {
    "holds": ("holds", "✓"),
    "chosen": ("chosen", "←"),
    "by definition": ("defined", "≡"),
    "not testable here": ("defined", "–"),
    "differs": ("differs", "≠"),
    "fails": ("fails", "✗"),
}
_MARK = Markup('<span class="{}">{}\u00a0{}</span>')


class Picture(NamedTuple):
    """A picture on a page: the `address` that contains it, and its `width` on the screen [mm]."""

    address: str
    width: int


def render(template: str, folder: Path = _TEMPLATES, **values: Any) -> str:
    """Fill a `template` of a `folder` with `values`; invisible characters are escaped.

    A template of another folder may extend those of fascicle. Text is escaped, Markup isn't.
    """
    from .. import __version__

    frame = {
        "version": __version__,
        "colors": Markup(css(LIGHT)),  # noqa: S704 fascicle's own
        "footer": "",
        "date": "",
        "body": "",
    }
    return escape_invisible(_environment(folder).get_template(template).render(frame | values))


def _environment(folder: Path) -> Environment:
    environment = Environment(
        loader=FileSystemLoader([folder, _TEMPLATES]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"prose": prose, "sentence": sentence}
    environment.globals |= {"verdict": verdict, "mark": mark}
    return environment


def data_uri(content: bytes, kind: str) -> str:
    """Address that contains a file's bytes, of `kind` "svg", "png", "csv" or "json"."""
    return f"data:{_MEDIA[kind]};base64,{base64.b64encode(content).decode('ascii')}"


def downloads(files: Mapping[str, bytes]) -> dict[str, str]:
    """Addresses that contain `files`, by name: they stay with the page when it is sent."""
    return {name: data_uri(content, name.rsplit(".", 1)[-1]) for name, content in files.items()}


def picture(figure: "Figure", svg: bytes | None = None) -> Picture:
    """Picture of a figure; `svg` is the figure as it was drawn before."""
    content = to_bytes(figure, "svg") if svg is None else svg
    return Picture(data_uri(content, "svg"), screen_width(figure.get_figwidth()))


def screen_width(inches: float) -> int:
    """Width on a screen [mm] of a picture of so many `inches` in print."""
    return round(inches * _MILLIMETERS)


def prose(text: str) -> Markup:
    """Plain text as HTML, with `names` between backticks set as code."""
    pieces = str(escape(text)).split("`")
    if len(pieces) % 2 == 0:  # a lone backtick is only itself
        return escape(text)
    return Markup("").join(
        Markup(f"<code>{piece}</code>" if i % 2 else piece)  # noqa: S704 escaped above
        for i, piece in enumerate(pieces)
    )


def sentence(text: str) -> str:
    """Text with its first letter in upper case, the rest unchanged."""
    return f"{text[:1].upper()}{text[1:]}"


def verdict(word: str) -> Markup:
    """Verdict, a key of `_VERDICTS`, as HTML."""
    return _MARK.format(*_VERDICTS[word], word)


def mark(good: bool, yes: str, no: str, bad: str = "differs") -> Markup:
    """Check mark or cross with a word, as HTML; empty for an empty word."""
    word = yes if good else no
    return _MARK.format(*(("holds", "✓") if good else (bad, "✗")), word) if word else Markup()


def lines(texts: Sequence[str]) -> Markup:
    """Lines of a table's cell, one below the other, as HTML."""
    return Markup("<br>").join(texts)

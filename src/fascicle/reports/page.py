"""Self-contained HTML pages from templates: one file each, which opens offline and prints well.

Nothing on a page asks for anything outside it: the style is in its head, pictures and files are in
their addresses. Links lead to places on the page or to files beside it. `templates/page.html` is
the frame of all pages.
"""

import base64
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from ..io.sanitize import escape_invisible
from ..plot.theme import LIGHT, css, to_bytes


if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TEMPLATES = Path(__file__).with_name("templates")
_INCH = 25.4  # mm
_ENLARGED = 1.35  # a screen is read from further away than a page
_MEDIA = {
    "svg": "image/svg+xml", "png": "image/png", "csv": "text/csv", "json": "application/json",
}  # fmt: skip
_VERDICTS = {
    "holds": ("holds", "✓"), "chosen": ("chosen", "←"), "by definition": ("defined", "≡"),
    "differs": ("differs", "≠"), "fails": ("fails", "✗"),
}  # fmt: skip


class Picture(NamedTuple):
    """A picture on a page: the `address` that holds it, and its `width` on the screen [mm]."""

    address: str
    width: int


def render(template: str, folder: Path = _TEMPLATES, **values: Any) -> str:
    """Fill a `template` of a `folder` with `values`; every sign of the page can be seen.

    A template of another folder may extend those of fascicle's own. Text is escaped, Markup isn't.
    """
    from .. import __version__

    frame = {
        "version": __version__,
        "colors": Markup(css(LIGHT)),  # noqa: S704 our own
        "footer": "",
        "date": "",
        "body": "",
    }
    return escape_invisible(_environment(folder).get_template(template).render(frame | values))


@cache
def _environment(folder: Path) -> Environment:
    environment = Environment(
        loader=FileSystemLoader([folder, _TEMPLATES]), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.filters |= {"prose": prose, "sentence": sentence}
    environment.globals |= {"verdict": verdict, "mark": mark}
    return environment


def data_uri(content: bytes, kind: str) -> str:
    """Address that holds a file's bytes, of `kind` "svg", "png", "csv" or "json"."""
    return f"data:{_MEDIA[kind]};base64,{base64.b64encode(content).decode('ascii')}"


def downloads(files: Mapping[str, bytes]) -> dict[str, str]:
    """Addresses that hold `files`, by name: they survive the page's being sent."""
    return {name: data_uri(content, name.rsplit(".", 1)[-1]) for name, content in files.items()}


def picture(figure: "Figure", svg: bytes | None = None) -> Picture:
    """A figure as a picture of a page; `svg` is the figure where it was drawn already."""
    content = to_bytes(figure, "svg") if svg is None else svg
    return Picture(data_uri(content, "svg"), screen_width(figure.get_figwidth()))


def screen_width(inches: float) -> int:
    """Width on a screen [mm] of a picture of so many `inches` in print."""
    return round(inches * _INCH * _ENLARGED)


def prose(text: str) -> Markup:
    """Plain text as HTML, with `names` between backticks set as code."""
    parts = str(escape(text)).split("`")
    if len(parts) % 2 == 0:  # a lone backtick is only itself
        return escape(text)
    return Markup("").join(
        Markup(f"<code>{part}</code>" if i % 2 else part)  # noqa: S704 escaped above
        for i, part in enumerate(parts)
    )


def sentence(text: str) -> str:
    """Text with its first letter in upper case, the others as they are."""
    return f"{text[:1].upper()}{text[1:]}"


def verdict(word: str) -> Markup:
    """A claim's verdict as HTML: "holds", "chosen", "by definition", "differs" or "fails"."""
    style, sign = _VERDICTS[word]
    return Markup('<span class="{}">{}\u00a0{}</span>').format(style, sign, word)


def mark(good: bool, yes: str, no: str, bad: str = "differs") -> Markup:
    """A check or a cross with a word, as HTML; nothing where the word is empty."""
    word = yes if good else no
    style, sign = ("holds", "✓") if good else (bad, "✗")
    return (
        Markup('<span class="{}">{}\u00a0{}</span>').format(style, sign, word) if word else Markup()
    )


def quotation(text: str) -> Markup:
    """Somebody else's words as HTML."""
    return Markup("<q>{}</q>").format(text)


def lines(texts: Sequence[str]) -> Markup:
    """Lines of a table's cell, one below the other, as HTML."""
    return Markup("<br>").join(texts)


class Page:
    """A page that is filled from top to bottom, then taken as text. Text is escaped, `Markup` is
    not.
    """

    def __init__(self, title: str):
        """**Arguments:** `title`: of the window and of the first heading."""
        self.title = title
        self._parts: list[Markup] = []

    def heading(self, text: str, anchor: str = "", level: int = 2) -> None:
        """Add a heading of `level` 2 or 3; links lead to the `anchor`."""
        name = Markup(' id="{}"').format(anchor) if anchor else ""
        self.html(Markup("<h{0}{1}>{2}</h{0}>").format(level, name, text))

    def paragraph(self, text: str, kind: str = "") -> None:
        """Add a paragraph; `kind` is "", "lead", "note" or "warning"."""
        style = Markup(' class="{}"').format(kind) if kind else ""
        self.html(Markup("<p{}>{}</p>").format(style, prose(text)))

    def points(self, texts: Iterable[str]) -> None:
        """Add a list."""
        self._macro("points", list(texts))

    def links(self, titled: Mapping[str, str]) -> None:
        """Add a row of links: addresses on this page or beside it, by text."""
        links = (Markup('<a href="{}">{}</a>').format(to, text) for text, to in titled.items())
        self.html(Markup("<nav>{}</nav>").format(Markup("").join(links)))

    def files(self, names: Sequence[str]) -> None:
        """Add links to files beside the page."""
        links = (Markup('<a href="{0}">{0}</a>').format(name) for name in names)
        self.html(Markup('<p class="files">{}</p>').format(Markup(", ").join(links)))

    def downloads(self, files: Mapping[str, bytes]) -> None:
        """Add links that save `files`, which the page holds."""
        self._macro("downloads", downloads(files))

    def picture(self, content: bytes, kind: str, alternative: str, width: float) -> None:
        """Add a picture of `kind` "svg" or "png", at most `width` [m] wide when printed."""
        drawn = Picture(data_uri(content, kind), screen_width(width / 0.0254))
        self._macro("picture", drawn, alternative)

    def table(self, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """Add a table; its cells are HTML."""
        self._macro("table", heads, [[Markup(cell) for cell in row] for row in rows])  # noqa: S704

    def html(self, text: str) -> None:
        """Add HTML."""
        self._parts.append(Markup(text))  # noqa: S704 HTML already

    def text(self, footer: str) -> str:
        """Fill the frame; `footer` comes last."""
        return render(
            "page.html", title=self.title, body=Markup("\n").join(self._parts), footer=footer
        )

    def _macro(self, name: str, *arguments: Any) -> None:
        macros = _environment(_TEMPLATES).get_template("macros.html").module
        self.html(getattr(macros, name)(*arguments))

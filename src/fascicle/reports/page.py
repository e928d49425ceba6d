"""A page built from headings, paragraphs, tables and pictures, with everything inside.

Nothing on a page asks for anything outside it: the style is in its head, pictures and files
are in their addresses. Links lead to places on the page or to files beside it.
"""

import base64
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from ..io.sanitize import escape_invisible
from ..plot.theme import LIGHT, css


_STYLE = (
    f":root {{ color-scheme: light; {css(LIGHT)} }}"
    """
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2.5rem 1.5rem 4rem; max-width: 62rem; color: var(--ink);
  background: var(--paper); font: 16px/1.55 var(--sans); }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.3rem; margin: 3rem 0 .6rem; padding-top: .8rem;
  border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.4rem 0 .3rem; }
p, ul { margin: .5rem 0; max-width: 48rem; }
ul { padding-left: 1.2rem; }
.lead { font-size: 1.05rem; }
.note, figcaption, .files, footer { color: var(--soft); font-size: .9rem; }
nav { display: flex; flex-wrap: wrap; gap: .3rem 1rem; margin: 1rem 0; font-size: .95rem; }
a { color: var(--accent); text-decoration-thickness: 1px; text-underline-offset: 2px; }
figure { margin: 1rem 0; }
img { display: block; max-width: 100%; height: auto; }
table { border-collapse: collapse; width: 100%; margin: .8rem 0; font-size: .93rem; }
th, td { text-align: left; vertical-align: top; padding: .45rem .7rem .45rem 0;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; border-bottom-color: var(--soft); }
td { font-variant-numeric: tabular-nums; }
.holds, .differs, .fails, .chosen, .defined { font-weight: 600; white-space: nowrap; }
.chosen, .defined, q { color: var(--soft); }
.where { white-space: nowrap; }
code { font: .92em var(--mono); }
.warning { color: var(--bad); font-weight: 600; }
.holds { color: var(--good); } .differs { color: var(--odd); } .fails { color: var(--bad); }
footer { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: .8rem; }
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  nav, .files { display: none; }
  h2 { break-after: avoid; } figure, tr { break-inside: avoid; }
  a { color: inherit; text-decoration: none; }
}
"""
)


def data_uri(content: bytes, kind: str) -> str:
    """A file's bytes, of `kind` "svg", "png", "csv" or "json", as an address that holds them."""
    return f"data:{_MEDIA[kind]};base64,{base64.b64encode(content).decode('ascii')}"


class Page:
    """A page that is filled from top to bottom, then taken as text. Text is escaped, save
    where a method says that it takes HTML.
    """

    def __init__(self, title: str):
        """**Arguments:** `title`: of the window and of the first heading [-]."""
        self.title = title
        self._parts = [f"<h1>{escape(title)}</h1>"]

    def heading(self, text: str, anchor: str = "", level: int = 2) -> None:
        """A heading of `level` 2 or 3; `anchor` is where links lead."""
        mark = f' id="{escape(anchor)}"' if anchor else ""
        self._parts.append(f"<h{level}{mark}>{escape(text)}</h{level}>")

    def paragraph(self, text: str, kind: str = "") -> None:
        """A paragraph; `kind` is "", "lead", "note" or "warning"."""
        self.html(f"<p{_class(kind)}>{prose(text)}</p>")

    def points(self, texts: Iterable[str]) -> None:
        """A list."""
        items = "".join(f"<li>{prose(text)}</li>" for text in texts)
        self.html(f"<ul>{items}</ul>")

    def several(self, lists: Mapping[str, Iterable[str]]) -> None:
        """A list for each of what they are about."""
        for about, texts in lists.items():
            self.paragraph(f"{about[0].upper()}{about[1:]}:")
            self.points(texts)

    def links(self, titled: dict[str, str]) -> None:
        """A row of links: addresses on this page or beside it, by text."""
        inside = "".join(
            f'<a href="{escape(to)}">{escape(text)}</a>' for text, to in titled.items()
        )
        self.html(f"<nav>{inside}</nav>")

    def files(self, names: Sequence[str]) -> None:
        """Links to files beside the page."""
        inside = ", ".join(f'<a href="{escape(name)}">{escape(name)}</a>' for name in names)
        self.html(f'<p class="files">{inside}</p>')

    def downloads(self, files: Mapping[str, bytes]) -> None:
        """Links that save `files`, which the page holds: they survive its being sent."""
        inside = ", ".join(
            f'<a download="{escape(name)}" href="{data_uri(content, name.rsplit(".", 1)[-1])}">'
            f"{escape(name)}</a>"
            for name, content in files.items()
        )
        self.html(f'<p class="files">{inside}</p>')

    def picture(self, content: bytes, kind: str, alternative: str, width: float) -> None:
        """A picture of `kind` "svg" or "png", at most `width` [m] wide when printed."""
        self.html(
            f'<figure><img src="{data_uri(content, kind)}" alt="{escape(alternative)}" '
            f'style="width:{1e3 * width * _ENLARGED:.0f}mm"></figure>'
        )

    def table(self, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """A table; its cells are HTML, so that they may hold `verdict`s."""
        head = "".join(f"<th>{escape(text)}</th>" for text in heads)
        body = "".join(
            "<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows
        )
        self.html(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")

    def html(self, text: str) -> None:
        """Something that is HTML already."""
        self._parts.append(text)

    def text(self, footer: str) -> str:
        """The whole page, `footer` last; of what it says, every sign can be seen."""
        body = "\n".join(self._parts)
        return escape_invisible(
            '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            '<link rel="icon" href="data:,">\n'  # else browsers ask for one
            f"<title>{escape(self.title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
            f"{body}\n<footer>{escape(footer)}</footer>\n</body>\n</html>\n"
        )


_MEDIA = {
    "svg": "image/svg+xml", "png": "image/png", "csv": "text/csv", "json": "application/json",
}  # fmt: skip
_VERDICTS = {
    "holds": ("holds", "✓"), "chosen": ("chosen", "←"), "by definition": ("defined", "≡"),
    "differs": ("differs", "≠"), "fails": ("fails", "✗"),
}  # fmt: skip
_ENLARGED = 1.35  # a screen is read from further away than a page


def prose(text: str) -> str:
    """Plain text as HTML, with `names` between backticks set as code."""
    parts = escape(text).split("`")
    if len(parts) % 2 == 0:  # a lone backtick is only itself
        return escape(text)
    return "".join(f"<code>{part}</code>" if i % 2 else part for i, part in enumerate(parts))


def verdict(word: str) -> str:
    """A claim's verdict as HTML: "holds", "chosen", "by definition", "differs" or "fails"."""
    style, sign = _VERDICTS[word]
    return f'<span class="{style}">{sign}\u00a0{word}</span>'


def quotation(text: str) -> str:
    """Somebody else's words as HTML."""
    return f"<q>{escape(text)}</q>"


def _class(kind: str) -> str:
    return f' class="{escape(kind)}"' if kind else ""

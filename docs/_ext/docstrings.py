r"""Docstrings in Markdown, and the way back from a function to its equations.

The package's docstrings are Markdown with TeX; autodoc reads reStructuredText. What they use is
little and is translated: `code`, $math$, $$display$$, and [R1] for a misprint. A theory page marks
an equation with a label and names its functions on the line below it:

    (eq-2)=
    $$r = \dots \tag{2}$$

    *In code:* {py:meth}`~fascicle.muscle.braid.Braid.radius_at`

These lines are read here once, so that each function's entry links to its equations, too.
"""

import re
from collections import defaultdict
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx


EQUATION = re.compile(
    r"^\((?P<label>eq-[\w-]+)\)=\n\$\$(?P<body>.*?)\$\$\n\n\*In code:\* (?P<code>.*?)(?:\n\n|\Z)",
    re.MULTILINE | re.DOTALL,
)
TAG = re.compile(r"\\tag\{([^}]*)\}")
TARGET = re.compile(r"\{py:\w+\}`~?([\w.]+)`")
DISPLAY = re.compile(r"\$\$(.+?)\$\$", re.DOTALL)
INLINE = re.compile(r"\$([^$]+?)\$")
CODE = re.compile(r"(?<![`:\w])`([^`\n]+)`(?![`_])")
MISPRINT = re.compile(r"\[(R\d+)\]")
REFERENCE = re.compile(r"\((?P<tag>[A-Z]{1,2}[1-9]\d*[a-z]?)\)")
# what a reference can't stand in comes first: fenced and inline code, formulas, and links
LITERAL_OR_REFERENCE = re.compile(
    r"^```.*?^```|`[^`\n]+`|\$\$.*?\$\$|\$[^$]+?\$|\[[^\]\n]*\]\([^)\n]*\)|" + REFERENCE.pattern,
    re.MULTILINE | re.DOTALL,
)
LINK = re.compile(r"\[([^\]\n]+)\]\[[^\]\n]*\]")


def equations(folder: Path) -> dict[str, list[tuple[str, str]]]:
    """Full name of each function on a theory page → tags and labels of its equations."""
    found: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for page in sorted(folder.glob("*.md")):
        for match in EQUATION.finditer(page.read_text(encoding="utf-8")):
            tags = TAG.findall(match["body"])
            for name in TARGET.findall(match["code"]):
                found[name].append((", ".join(tags), match["label"]))
    return dict(found)


def labels(folder: Path) -> dict[str, str]:
    """Tag of each labelled equation of the theory pages → its label."""
    found = {}
    for page in sorted(folder.glob("*.md")):
        for match in EQUATION.finditer(page.read_text(encoding="utf-8")):
            for tag in ", ".join(TAG.findall(match["body"])).split(", "):
                found[tag] = match["label"]
    return found


def link_references(text: str, known: dict[str, str]) -> str:
    """A page's Markdown with each reference to a tag, such as (F4), as a link to its equation."""

    def link(match: re.Match[str]) -> str:
        label = known.get(match["tag"] or "")
        return f"[({match['tag']})](#{label})" if label else match[0]

    return LITERAL_OR_REFERENCE.sub(link, text)


def to_rst(text: str, known: dict[str, str] | None = None) -> str:
    """The docstrings' Markdown as reStructuredText; `known`: labels of equations by tag."""
    blocks: list[str] = []

    def keep(rst: str) -> str:
        blocks.append(rst)
        return f"\x00{len(blocks) - 1}\x00"

    def display(match: re.Match[str]) -> str:
        body = "\n".join("   " + line.strip() for line in match[1].strip().splitlines())
        start, end = r"   \begin{equation*}", r"   \end{equation*}"
        return keep(f"\n\n.. math::\n   :no-wrap:\n\n{start}\n{body}\n{end}\n\n")

    text = DISPLAY.sub(display, text)
    text = CODE.sub(lambda m: keep(f"``{m[1]}``"), text)
    text = INLINE.sub(lambda m: keep(f"\\ :math:`{' '.join(m[1].split())}`\\ "), text)
    text = REFERENCE.sub(
        lambda m: (
            keep(f":ref:`{m[0]} <{known[m['tag']]}>`") if known and m["tag"] in known else m[0]
        ),
        text,
    )
    text = MISPRINT.sub(lambda m: keep(f"\\ :ref:`[{m[1]}] <{m[1].lower()}>`\\ "), text)
    text = LINK.sub(r"\1", text).replace("|", r"\|")
    return re.sub(r"\x00(\d+)\x00", lambda m: blocks[int(m[1])], text)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    known = equations(Path(app.srcdir) / "theory")
    by_tag = labels(Path(app.srcdir) / "theory")

    def read(_: Sphinx, __: str, source: list[str]) -> None:
        source[0] = link_references(source[0], by_tag)

    def translate(_: Sphinx, __: str, name: str, ___: Any, ____: Any, lines: list[str]) -> None:
        rst = to_rst("\n".join(lines), by_tag)
        # one tagged equation may stand for a function on several pages
        links = [f":ref:`({tag}) <{label}>`" for tag, label in known.get(name, [])]
        if links:
            rst += "\n\n*Derived in:* " + ", ".join(links) + "\n"
        lines[:] = rst.splitlines()

    app.connect("autodoc-process-docstring", translate)
    app.connect("source-read", read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

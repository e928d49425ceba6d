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


def to_rst(text: str) -> str:
    """The docstrings' Markdown as reStructuredText."""
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
    text = MISPRINT.sub(lambda m: keep(f"\\ :ref:`[{m[1]}] <{m[1].lower()}>`\\ "), text)
    text = LINK.sub(r"\1", text).replace("|", r"\|")
    return re.sub(r"\x00(\d+)\x00", lambda m: blocks[int(m[1])], text)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    known = equations(Path(app.srcdir) / "theory")

    def translate(_: Sphinx, __: str, name: str, ___: Any, ____: Any, lines: list[str]) -> None:
        rst = to_rst("\n".join(lines))
        # one tagged equation may stand for a function on several pages
        links = [f":ref:`({tag}) <{label}>`" for tag, label in known.get(name, [])]
        if links:
            rst += "\n\n*Derived in:* " + ", ".join(links) + "\n"
        lines[:] = rst.splitlines()

    app.connect("autodoc-process-docstring", translate)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

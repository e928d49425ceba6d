"""Fails the build where a page would ask another server for a script, style, font or picture."""

import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError


# a link that a reader may follow (<a href>) is no request, nor are the page's own addresses
REQUEST = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|embed)\b[^>]*\bsrc\s*=\s*["'](?:https?:)?//[^"']+"""
    r"""|<link\b(?![^>]*\brel\s*=\s*["'](?:canonical|license|author|search)["'])"""
    r"""[^>]*\bhref\s*=\s*["'](?:https?:)?//[^"']+"""
    r"""|@import\s+(?:url\()?["']?(?:https?:)?//[^"')]+"""
    r"""|url\(\s*["']?(?:https?:)?//[^"')]+""",
    re.IGNORECASE,
)


def requests(text: str) -> list[str]:
    """What a page or a style sheet would ask of another server."""
    return [match.group() for match in REQUEST.finditer(text)]


def refuse_outside_requests(app: Sphinx, exception: Exception | None) -> None:
    """Read the built site, and raise on the first outside request."""
    if exception is not None or app.builder.name != "html":
        return
    for path in sorted(Path(app.outdir).rglob("*")):
        if path.suffix in {".html", ".css"} and (found := requests(path.read_text("utf-8"))):
            raise ExtensionError(f"{path.name} asks another server: {found[0]}")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("build-finished", refuse_outside_requests)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

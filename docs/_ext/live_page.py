"""The live page of `index.md`, written by the code into the built site."""

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx


FILE = "bundle.html"  # as the page's frame names it
EXAMPLE, TITLE = "kim2021_bundle_1_4", "One muscle and four"
PRESSURES = [1e3 * pressure for pressure in (0, 100, 200, 300, 400)]  # Pa


def write(app: Sphinx, exception: Exception | None) -> None:
    """Write the page beside `index.html`."""
    if exception is not None or app.builder.name != "html":
        return
    import fascicle as fs
    from fascicle.export import write_page

    write_page(fs.example(EXAMPLE), Path(app.outdir) / FILE, TITLE, PRESSURES)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("build-finished", write, priority=400)  # before `offline` reads the site
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Sections of the measured muscles, made from their files: the page `catalog` takes them in place
of the line `% sections of the catalog`, as headings of its own, each with a cell that draws it.
"""

from typing import Any

from sphinx.application import Sphinx


MARK = "% sections of the catalog\n"


def section(name: str) -> str:
    """Section of the entry with a `name`, as Markdown."""
    import fascicle as fs

    entry = fs.catalog[name]
    rows = {
        "maker": entry.maker,
        "published sizes": entry.sizes,
        "measured": entry.measured,
        "basis": entry.basis,
        "error": entry.error,
        "range": entry.range,
        "length of the model": f"{1e3 * float(entry.muscle.length):.1f} mm",
        "tension law": f"`{entry.muscle.tension.name}`",
        "source": f"{entry.source}, <{entry.url}>",
        "license of the numbers": entry.license,
    }
    table = "\n".join(f"| {key} | {value} |" for key, value in rows.items())
    assumed = "\n".join(f"- {text}" for text in entry.assumed)
    cell = f'```{{code-cell}} python\n:tags: [remove-input]\nfs.catalog["{name}"].plot()\n```'
    head = f"### {name}\n\n{entry.title}\n\n| | |\n|---|---|\n{table}"
    return f"{head}\n\nAssumed:\n\n{assumed}\n\n{cell}\n"


def insert_sections(_: Sphinx, page: str, source: list[str]) -> None:
    """Replace the mark in the source of the page."""
    if page == "catalog":
        import fascicle as fs

        if MARK not in source[0]:
            raise ValueError(f"catalog.md lacks the line {MARK!r}")
        source[0] = source[0].replace(MARK, "\n".join(map(section, fs.catalog)))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("source-read", insert_sections)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""The README's lines are run, and print what stands below them."""

import contextlib
import io
import json
import re
from pathlib import Path


README = Path(__file__).parents[2] / "README.md"
CLAIMS = README.parent / "docs" / "_static" / "claims.json"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def test_the_python_block_prints_what_the_readme_shows():
    blocks = BLOCK.findall(README.read_text(encoding="utf-8"))
    first = next((i for i, (language, _) in enumerate(blocks) if language == "python"), None)
    assert first is not None, "the README shows no Python"
    assert first + 1 < len(blocks), "no output stands below the README's Python"
    language, shown = blocks[first + 1]
    assert language == "text", "the block below the README's Python is its output, as ```text"
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(blocks[first][1], "README.md", "exec"), {"__name__": "__main__"})  # noqa: S102 the README is ours
    assert printed.getvalue().strip() == shown.strip()
    assert printed.getvalue().strip()


def test_the_claims_are_counted_as_the_reproduction_counts_them():
    counted = json.loads(CLAIMS.read_text(encoding="utf-8"))["summary"]
    assert counted in " ".join(README.read_text(encoding="utf-8").split())


def test_no_page_counts_claims_by_hand():
    """Docs read the file of claims: a count that is written out is that of another day."""
    pages = [*(README.parent / "docs").rglob("*.md")]
    assert pages
    for page in pages:
        assert not re.search(r"\d+ of \d+\s+predictions", page.read_text(encoding="utf-8")), page

"""What the report quotes stands in the paper, word for word, where it says."""

import json
import os
import re
from pathlib import Path

import pytest


CHECKOUT = Path(__file__).parents[2]
CLAIMS = json.loads((CHECKOUT / "docs" / "_static" / "claims.json").read_text(encoding="utf-8"))
HEADING = re.compile(r"^(\d(?:\.\d)?)\. [A-Z]", re.MULTILINE)


@pytest.fixture(scope="module")
def sections():
    """The paper's text by section, its first words under 0."""
    folder = Path(os.environ.get("FASCICLE_PAPER") or CHECKOUT.parent / "shared" / "paper")
    path = folder / "kim-2021-resistive-forces.txt"
    if not path.is_file():
        pytest.skip(f"no {path.name} in FASCICLE_PAPER or beside the checkout")
    body = path.read_text(encoding="utf-8").split("\nReferences\n")[0]
    first, *rest = HEADING.split(body)
    found, last = {"0": first}, "0"
    for number, text in zip(rest[::2], rest[1::2], strict=True):
        if number > last:  # else an item of a numbered list
            found[last := number] = ""
        found[last] += text
    return {number: plain(text) for number, text in found.items()}


def plain(text):
    """Without line breaks, emphasis and curled quotes."""
    text = text.translate(str.maketrans({"’": "'", "“": '"', "”": '"', "*": "", "$": ""}))
    return " ".join(text.split())


@pytest.mark.parametrize("claim", CLAIMS["claims"], ids=lambda claim: claim["key"])
def test_the_papers_words_are_its_own(claim, sections):
    section = re.match(r"section ([\d.]+)", claim["where"])
    assert section, claim["where"]
    assert plain(claim["paper"]) in sections[section[1]]


def test_what_the_paper_does_not_say_is_not_there(sections):
    """Words that an earlier report had, which would pass if the search were too generous."""
    whole = " ".join(sections.values())
    assert "under 2 %" not in whole
    assert "far more resistance" not in whole

"""Equations lead to functions and back, and the built site asks nobody for anything."""

import importlib.util
import inspect
import pydoc
import re
from pathlib import Path

import pytest


DOCS = Path(__file__).parents[2] / "docs"
THEORY = sorted((DOCS / "theory").glob("*.md"))
PAPER = DOCS / "paper-and-misprints.md"
# a display equation of a theory page: its label above it, its functions below
DISPLAY = re.compile(r"^\$\$(.*?)\$\$", re.MULTILINE | re.DOTALL)


def extension(name: str):
    spec = importlib.util.spec_from_file_location(f"docs_{name}", DOCS / "_ext" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


EQUATIONS = extension("docstrings").equations(DOCS / "theory")


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_every_equation_has_a_tag_a_label_and_its_functions(page):
    text = page.read_text(encoding="utf-8")
    shown = DISPLAY.findall(text)
    assert all(r"\tag{" in body for body in shown)
    # Sphinx puts rows into a split environment, where MathJax allows no tag; `\cr` avoids that
    assert not any(r"\\" in body for body in shown)
    linked = extension("docstrings").EQUATION.findall(text)
    assert len(linked) == len(shown)
    assert shown or page.stem == "symbols"


def test_the_functions_named_beside_equations_exist_and_are_documented():
    assert len(EQUATIONS) > 100
    found = {name: pydoc.locate(name) for name in EQUATIONS}
    # an overriding method has its base's docstring
    assert [name for name, thing in found.items() if not (thing and inspect.getdoc(thing))] == []


def test_the_papers_equations_are_all_there():
    tags = ", ".join(tag for found in EQUATIONS.values() for tag, _ in found)
    numbers = {int(n) for n in re.findall(r"\b(\d+)\b", tags)}
    for first, last in re.findall(r"\b(\d+)–(\d+)\b", tags):
        numbers |= set(range(int(first), int(last) + 1))
    assert numbers >= set(range(1, 36))


PAGES = sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts)
TAGS = [
    tag.strip()
    for page in PAGES
    for tags in re.findall(r"\\tag\{([^}]*)\}", page.read_text(encoding="utf-8"))
    for tag in tags.split(",")
]
SOURCES = sorted((DOCS.parent / "src").rglob("*.py"))


def numbers(tags: str) -> list[str]:
    """Single tags of a docstring's, which may be a list or a range of the paper's."""
    if span := re.fullmatch(r"(\d+)-(\d+)", tags):
        return [str(n) for n in range(int(span[1]), int(span[2]) + 1)]
    return [tag.strip() for tag in tags.split(",")]


def test_every_tag_stands_on_one_page_once():
    twice = sorted({tag for tag in TAGS if TAGS.count(tag) > 1})
    assert twice == []


def test_tags_and_references_in_docstrings_lead_to_an_equation_of_a_page():
    whole = {
        n for tag in TAGS for n in ([tag] if "–" not in tag else numbers(tag.replace("–", "-")))
    }
    missing = {}
    for source in SOURCES:
        text = source.read_text(encoding="utf-8")
        named = {n for tags in re.findall(r"\\tag\{([^}]*)\}", text) for n in numbers(tags)}
        named |= set(re.findall(r"\(([A-Z]{1,2}[1-9]\d*[a-z]?)\)", text))
        if named - whole:
            missing[source.name] = named - whole
    assert missing == {}


def test_references_become_links_where_they_are_words():
    known = {"F4": "eq-flow"}
    links = extension("docstrings").link_references
    assert links("by (F4), and `(F4)` of $x (F4)$, (Z9)", known) == (
        "by [(F4)](#eq-flow), and `(F4)` of $x (F4)$, (Z9)"
    )


def test_every_misprint_has_its_section():
    sections = re.findall(r"^### R(\d+)$", PAPER.read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(map(int, sections)) == list(range(1, 22))


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ('<script src="https://cdn.example/x.js"></script>', True),
        ('<link rel="stylesheet" href="//fonts.example/css">', True),
        ("<style>@import url(https://fonts.example/css);</style>", True),
        ("body { background: url('https://example.org/a.png') }", True),
        ('<a href="https://doi.org/10.3390/act10030042">paper</a>', False),
        ('<script src="_static/a.js"></script>', False),
        ('<link rel="canonical" href="https://example.org/">', False),
    ],
)
def test_outside_requests_are_told_from_links(text, asks):
    assert bool(extension("offline").requests(text)) is asks

"""Equations lead to functions and back, and the built site asks nobody for anything."""

import importlib
import importlib.util
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
    linked = extension("docstrings").EQUATION.findall(text)
    assert len(linked) == len(shown)
    assert shown or page.stem == "symbols"


@pytest.mark.parametrize("name", sorted(EQUATIONS))
def test_the_functions_named_beside_equations_exist(name):
    parts = name.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[cut:]:
            found = getattr(found, attribute)
        assert found.__doc__
        return
    pytest.fail(f"no module holds {name}")


def test_the_papers_equations_are_all_there():
    tags = ", ".join(tag for found in EQUATIONS.values() for tag, _ in found)
    numbers = {int(n) for n in re.findall(r"\b(\d+)\b", tags)}
    for first, last in re.findall(r"\b(\d+)–(\d+)\b", tags):
        numbers |= set(range(int(first), int(last) + 1))
    assert numbers >= set(range(1, 36))


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

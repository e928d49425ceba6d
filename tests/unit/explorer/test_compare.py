"""Pinned curves: their table has the library's numbers."""

import math
import re
from dataclasses import replace

import pytest

import fascicle as fs
from fascicle.core.errors import InvalidInputError
from fascicle.explorer.compare_tab import (
    MOST_PINS,
    CompareView,
    add_pin,
    difference_text,
)
from fascicle.explorer.state import Pin, Session, view_of
from fascicle.plot.theme import LIGHT


SIX = fs.example("kim2021_figure_6")
STEEP = SIX.replace(braid_angle=math.radians(28))
RIGID = fs.example("festo-dmsp-20-300")
P = 137.9e3
PINS = (Pin("33 deg", SIX, P), Pin("28 deg", STEEP, P), Pin("Festo, =1 <b>", RIGID, 3e5))
VIEW = replace(view_of(SIX, "kim2021_figure_6"), tab="compare", pins=PINS, strain=0.15)


def cells_of(view):
    """Cells of the tab's table, by name of the curve."""
    tab = CompareView(Session(view), LIGHT)
    tab.refresh()
    rows = re.findall(r"<tr>(.*?)</tr>", tab._table.object)
    names, *rows = (re.findall(r"<t[hd]>(?:<svg.*?</svg> )?(.*?)</t[hd]>", row) for row in rows)
    return {row[0]: dict(zip(names[1:], row[1:], strict=True)) for row in rows}


def test_the_table_has_the_librarys_numbers_and_differences():
    laws = {
        "Blocked force [N]": lambda m, P: float(m.force(P, 0.0)),
        "Free strain [–]": lambda m, P: float(m.free_strain(P)),
        "Collapse strain [–]": lambda m, P: float(m.collapse_strain(P)),
        "Force at ε = 0.15 [N]": lambda m, P: float(m.force(P, 0.15)),
    }
    rows = cells_of(VIEW)
    assert "Festo, =1 &lt;b&gt;" in rows  # names are no HTML
    for cells, pin in zip(rows.values(), PINS, strict=True):
        assert list(cells) == list(laws)
        for head, law in laws.items():
            value, reference = law(pin.muscle, pin.pressure), law(SIX, P)
            text, _, percent = cells[head].replace("−", "-").partition(" (")
            # as many digits as the table has
            assert float(text) == pytest.approx(value, rel=5e-4)
            if pin is PINS[0]:
                assert not percent
                continue
            difference = 100 * (value - reference) / abs(reference)
            assert float(percent.removesuffix(" %)")) == pytest.approx(difference, abs=0.05)


@pytest.mark.parametrize(
    ("value", "reference", "text"),
    [
        (math.inf, 1.0, "never"),
        (0.25, math.inf, "0.25"),
        (1.0, 1e-9, "1"),  # a reference of rounding has no percentage
        (-8.0, -4.0, "−8 (−100.0 %)"),  # of a push, of its size
        (2.0, 2.0, "2"),
    ],
)
def test_a_difference_is_of_the_references_size(value, reference, text):
    assert difference_text(value, reference, ".4g") == text


def test_pins_are_limited_and_their_names_differ():
    pins = ()
    for i in range(MOST_PINS):
        pins = add_pin(pins, "a", SIX, 1e5 + 0.001 * i)
    assert len({pin.name for pin in pins}) == MOST_PINS
    with pytest.raises(InvalidInputError):
        add_pin(pins, "a", STEEP, 1e5)
    for name in ("", "=1+1", "x" * 90):
        (pin,) = add_pin((), name, SIX, 1e5)
        assert pin.name[0].isalnum() and len(pin.name) < 60

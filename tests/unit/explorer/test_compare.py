"""Pinned curves: their table has the library's numbers, their downloads run, a link keeps them."""

import csv
import io
import json
import math
import re
import runpy
from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.explorer.compare_tab import CompareView
from fascicle.explorer.exports import comparison_downloads
from fascicle.explorer.link import LONGEST, from_query, linked_pins, pack, to_query
from fascicle.explorer.pins import (
    MOST_PINS,
    PinQuantity,
    add_pin,
    parse_pins,
    pins_text,
    quantities,
    quantity_texts,
    rename_pin,
)
from fascicle.explorer.state import Pin, Session, view_of
from fascicle.plot.theme import LIGHT


SIX = fs.example("kim2021_figure_6")
STEEP = SIX.replace(braid_angle=math.radians(28))
RIGID = fs.example("festo-dmsp-20-300")
P = 137.9e3
PINS = (Pin("33 deg", SIX, P), Pin("28 deg", STEEP, P), Pin("Festo, =1 <b>", RIGID, 3e5))
VIEW = replace(view_of(SIX, "kim2021_figure_6"), tab="compare", pins=PINS, strain=0.15)


def tables_of(view):
    """Cells of the tab's tables, by caption and name of the curve."""
    tab = CompareView(Session(view), LIGHT)
    tab.refresh()
    text = tab._table.object
    tables = re.findall(r"<caption>(.*?)</caption>(.*?)</table>", text)
    row = r"<span>([^<]*)</span></div></th><td>(.*?)</td><td>(.*?)</td><td>(.*?)</td>"
    return {
        caption: {name: cells for name, *cells in re.findall(row, body)} for caption, body in tables
    }


def test_the_table_has_the_librarys_numbers_and_differences():
    tables = tables_of(VIEW)
    laws = {
        "Blocked force [N]": lambda m, P: float(m.force(P, 0.0)),
        "Free strain [–]": lambda m, P: float(m.free_strain(P)),
        "Collapse strain [–]": lambda m, P: float(m.collapse_strain(P)),
        "Force at ε = 0.15 [N]": lambda m, P: float(m.force(P, 0.15)),
    }
    assert list(tables) == list(laws)
    for caption, law in laws.items():
        (_, first), *others = tables[caption].items()
        reference = law(SIX, P)
        assert first[1:] == ["reference", ""]
        for cells, pin in zip((first, *(cells for _, cells in others)), PINS, strict=True):
            value = law(pin.muscle, pin.pressure)
            texts = [cell.replace("−", "-") for cell in cells]
            # as many digits as the table has
            assert float(texts[0]) == pytest.approx(value, rel=5e-4)
            if pin is PINS[0]:
                continue
            assert float(texts[1]) == pytest.approx(value - reference, rel=5e-4, abs=5e-5)
            percent = 100 * (value - reference) / abs(reference)
            assert float(texts[2].removesuffix(" %")) == pytest.approx(percent, abs=0.05)


def test_the_percentage_of_a_push_is_of_its_size():
    """A muscle that pushes harder than the reference has a negative difference and percentage."""
    strain = 0.25  # both push there
    (_, _, _, force) = quantities((PINS[0], Pin("low", SIX, 100e3)), strain)
    first, second = (float(SIX.force(pressure, strain)) for pressure in (P, 100e3))
    assert first < 0 and second < 0
    assert force.differences[1] == pytest.approx((second - first, (second - first) / -first))


def test_no_difference_to_a_muscle_that_never_collapses_or_has_no_force():
    blocked, *_ = quantities((Pin("empty", SIX, 0.0), Pin("full", SIX, P)), 0.1)
    assert abs(blocked.values[0]) < 1e-6  # zero but for rounding
    assert quantity_texts(blocked, "N")[1][2] == "–"
    collapse = PinQuantity("Collapse strain", "strain", (math.inf, 0.25))
    assert quantity_texts(collapse, "") == [("never", "reference", ""), ("0.2500", "–", "–")]


def test_pins_are_limited_and_their_names_differ():
    pins = ()
    for i in range(MOST_PINS):
        pins = add_pin(pins, "a", SIX, 1e5 + 0.001 * i, "kPa")
    assert len({pin.name for pin in pins}) == MOST_PINS
    with pytest.raises(ValueError, match=str(MOST_PINS)):
        add_pin(pins, "a", STEEP, 1e5, "kPa")
    for name in (pins[0].name, "", "=1+1", "x" * 41):
        with pytest.raises(ValueError):  # noqa: PT011 in words
            rename_pin(pins, 1, name)
    assert rename_pin(pins, 1, " new  name ")[1] == replace(pins[1], name="new name")


def test_names_are_no_html():
    tab = CompareView(Session(VIEW), LIGHT)
    tab.refresh()
    assert "<b>" not in tab._table.object + tab._legend.object
    assert "&lt;b&gt;" in tab._table.object


def test_pins_come_back_from_a_link():
    view, errors = from_query(to_query(VIEW), view_of(SIX, "kim2021_figure_6"))
    assert not errors
    assert view.pins == VIEW.pins


def packed(**changes):
    item = {"name": "a", "pressure": "100 kPa", "example": "kim2021_figure_6"} | changes
    return pack(json.dumps([item]))


@pytest.mark.parametrize(
    "text",
    ["x", pack("[" * 10_000), pack("{}"), pack('[{"name": 1}]'), packed(pressure="9 MPa"),
     packed(name="=cmd"), packed(example="../../etc/passwd"), packed(file="import os"),
     "A" * (LONGEST + 1)],
)  # fmt: skip
def test_wrong_pins_of_a_link_are_left_out(text):
    view, errors = from_query({"pins": text, "path": "isotonic"}, VIEW)
    assert len(errors) == 1 and "\n" not in errors[0]
    assert view.pins == VIEW.pins and view.path == "isotonic"


def test_pins_that_a_link_has_no_room_for_are_left_out_and_counted():
    # rows of a tuning that don't deflate
    rng = np.random.default_rng(0)
    tuning = fs.Tuning(pressures=np.sort(rng.uniform(1e3, 9e5, 180)), c1=rng.uniform(1, 2, 180),
                       c2=rng.uniform(1, 2, 180))  # fmt: skip
    large = tuple(Pin(f"curve {i}", SIX.replace(tuning=tuning), 1e5 + i) for i in range(3))
    view = replace(VIEW, pins=large)
    number = linked_pins(view)
    assert 0 < number < 3
    query = to_query(view)
    assert sum(map(len, query.values())) < LONGEST + 500
    result, errors = from_query(query, VIEW)
    assert not errors and len(result.pins) == number


def test_the_python_makes_the_same_data(tmp_path, monkeypatch):
    export = comparison_downloads(replace(VIEW, pins=(*PINS, Pin("cost $1$ \\alpha", STEEP, 2e5))))
    script = tmp_path / "script.py"
    script.write_bytes(export.content("py"))
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    assert (tmp_path / f"{export.stem}.csv").read_bytes() == export.content("csv")
    assert (tmp_path / f"{export.stem}.svg").stat().st_size > 1000
    rows = list(csv.DictReader(io.StringIO(export.content("csv").decode())))
    last = rows[-1]
    force = float(STEEP.force(2e5, float(last["strain [-]"])))
    assert float(last["force [N]"]) == pytest.approx(force, abs=1e-9)
    assert last["curve [-]"] == "cost $1$ \\alpha"
    assert export.content("png").startswith(b"\x89PNG") and export.content("nc")[1:4] == b"HDF"


def test_a_pressure_comes_back_exactly():
    odd = Pin("odd", SIX, 123456.78901234567)
    (back,) = parse_pins(pins_text((odd,)))
    assert back.pressure == odd.pressure

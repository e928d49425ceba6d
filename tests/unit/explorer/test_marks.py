"""Marks' names: none runs out of the picture, none over another."""

from dataclasses import replace

import pytest

import fascicle as fs
from fascicle.explorer.muscle_curves import curve_marks, muscle_curves, strain_limit
from fascicle.explorer.muscle_tab import MuscleView
from fascicle.explorer.state import Session, view_of
from fascicle.explorer.theme import LIGHT


SIX = fs.example("kim2021_figure_6")
SUPPLY = 413.7e3
WIDE, HIGH = 285, 420  # pixels of the plot on a phone
LETTER = 7.4  # pixels, of 12 px DejaVu Sans
LINE = 14


def boxes(pressure):
    """Where each name stands in pixels: left, right, bottom, top; and the names."""
    top = strain_limit(SIX, SUPPLY)
    found = muscle_curves(SIX, pressure, 0.1, SUPPLY, top)
    shown = curve_marks(found, top, 1.0, "N")
    per_newton = HIGH / (1.24 * float(found.force[:-1].max() - found.force[:-1].min()))
    out = []
    for x, y, label, above, beside, align in zip(*shown.values(), strict=True):
        at, long = x / top * WIDE + beside, LETTER * len(label)
        left = at - long if align == "right" else at
        out.append((left, left + long, y * per_newton + above, y * per_newton + above + LINE))
    return out, shown["label"]


@pytest.mark.parametrize("pressure", [0.0, 1.0, 2e3, 10e3, 20e3, 30e3, 69e3, 137.9e3, 3e5, SUPPLY])
def test_names_stay_in_the_picture_and_apart(pressure):
    found, names = boxes(pressure)
    assert len(names) == 3
    for k, (left, right, bottom, top) in enumerate(found):
        assert left >= 0 and right <= WIDE + 18, names[k]  # and the figure's border
        for other in found[k + 1 :]:
            apart = right <= other[0] or other[1] <= left or top <= other[2] or other[3] <= bottom
            assert apart, (names, found)


def test_the_forces_parts_are_in_the_picture_of_a_long_muscle():
    muscle = SIX.replace(length=10.0)
    tab = MuscleView(Session(view_of(muscle, "long")), LIGHT)
    tab.refresh()
    shown = tab.chart.figure.y_range
    for part in ("force", "mesh", "bladder", "bending"):
        assert shown.start <= min(tab.chosen.data[part]) <= max(tab.chosen.data[part]) <= shown.end


@pytest.mark.parametrize("pressure", [0.0, 69e3, 137.9e3, SUPPLY])
def test_regions_names_fit_into_their_strips(pressure):
    view = replace(view_of(SIX, "six"), pressure=pressure)
    tab = MuscleView(Session(view), LIGHT)
    tab.refresh()
    strips, names = tab.strips.data, tab.region_names.data["label"]
    assert any(names)
    for left, right, name in zip(strips["left"], strips["right"], names, strict=True):
        assert (right - left) / tab.top * WIDE >= 6.9 * len(name)  # in gray, it is no wider

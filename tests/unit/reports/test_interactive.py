"""Pictures that tell about their marks: what is drawn is where the numbers are."""

import re

import numpy as np
import pytest

from fascicle.reports.interactive import Axis, parallel, scaled, scatter


def places(svg, kind="circle"):
    found = re.findall(rf'<{kind} class="mark[^"]*" data-place="(\d+)" data-text="([^"]*)"', svg)
    return {int(place): text for place, text in found}


def test_marks_lie_in_order_and_tell_their_text():
    values = np.array([1.0, 3.0, 2.0])
    svg = scatter(Axis("a [mm]", values), Axis("b", -values), ["x", "<y>", 'z"'], chosen=1)
    assert places(svg) == {0: "x", 1: "&lt;y&gt;", 2: "z&quot;"}
    across = dict(re.findall(r'data-place="(\d)"[^>]*cx="([\d.]+)"', svg))
    up = dict(re.findall(r'data-place="(\d)"[^>]*cy="([\d.]+)"', svg))
    assert float(across["0"]) < float(across["2"]) < float(across["1"])
    # downward is larger in a picture
    assert float(up["0"]) < float(up["2"]) < float(up["1"])
    # the chosen one lies on top
    assert svg.count("mark chosen") == 1 and svg.rindex('data-place="1"') == svg.rindex(
        "data-place"
    )


def test_two_marks_are_emphasized_the_chosen_one_on_top():
    values = np.array([1.0, 3.0, 2.0])
    axes = Axis("a", values), Axis("b", values)
    for svg in (scatter(*axes, ["x", "y", "z"], 1, None, 0), parallel(axes, ["x", "y", "z"], 1, 0)):
        assert svg.count("mark chosen") == 1 and svg.count("mark second") == 1
        order = [int(place) for place in re.findall(r'data-place="(\d)"', svg)]
        assert order == [2, 0, 1]
    both = scatter(*axes, ["x", "y", "z"], 1, None, 1)
    assert both.count('class="mark chosen second"') == 1


@pytest.mark.parametrize("value", [0.0, 2.5, -1.0])
def test_one_value_is_no_range(value):
    one = np.array([value, value])
    svg = parallel([Axis("a", one), Axis("b", np.array([0.0, 1.0]))], ["x", "y"], chosen=None)
    assert len(places(svg, "path")) == 2
    assert svg.count(f">{value:.4g}<") >= 1 and "nan" not in svg


def test_others_lie_behind():
    others = (np.array([0.0, 9.0]), np.array([0.0, 9.0]))
    svg = scatter(Axis("a", np.ones(1)), Axis("b", np.ones(1)), ["x"], None, others)
    assert svg.count('class="other"') == 2
    assert svg.rindex('class="other"') < svg.index('class="mark"')


def test_lengths_are_shown_in_millimeters():
    axis = scaled({"envelope": np.array([0.05])}, "envelope", "m")
    assert axis.label == "envelope [mm]" and axis.values[0] == 50.0

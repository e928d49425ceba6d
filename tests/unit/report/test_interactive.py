"""Pictures with a text at each mark: marks are drawn where the numbers are."""

import re

import numpy as np
import pytest

from fascicle.report.interactive import Axis, parallel_coordinates, scatter


VALUES = np.array([1.0, 3.0, 2.0])


def indices(svg, tag="circle"):
    pairs = re.findall(rf'<{tag} class="mark[^"]*" data-index="(\d+)" data-text="([^"]*)"', svg)
    return {int(index): text for index, text in pairs}


def test_marks_lie_in_order_and_have_their_text():
    svg = scatter(Axis("a [mm]", VALUES), Axis("b", -VALUES), ["x", "<y>", 'z"'], chosen=1)
    assert indices(svg) == {0: "x", 1: "&lt;y&gt;", 2: "z&#34;"}
    across = dict(re.findall(r'data-index="(\d)"[^>]*cx="([\d.]+)"', svg))
    up = dict(re.findall(r'data-index="(\d)"[^>]*cy="([\d.]+)"', svg))
    assert float(across["0"]) < float(across["2"]) < float(across["1"])
    # downward is larger in a picture
    assert float(up["0"]) < float(up["2"]) < float(up["1"])


def test_two_marks_are_emphasized_the_chosen_one_on_top():
    axes, texts = (Axis("a", VALUES), Axis("b", VALUES)), ["x", "y", "z"]
    for svg in (scatter(*axes, texts, 1, None, 0), parallel_coordinates(axes, texts, 1, 0)):
        assert svg.count("mark chosen") == 1 and svg.count("mark second") == 1
        assert re.findall(r'data-index="(\d)"', svg) == ["2", "0", "1"]
    assert scatter(*axes, texts, 1, None, 1).count('class="mark chosen second"') == 1


@pytest.mark.parametrize("value", [0.0, 2.5, -1.0])
def test_equal_values_are_no_range(value):
    flat = Axis("a", np.array([value, value]))
    svg = parallel_coordinates([flat, Axis("b", np.array([0.0, 1.0]))], ["x", "y"], chosen=None)
    assert len(indices(svg, "path")) == 2
    assert svg.count(f">{value:.4g}<") >= 1 and "nan" not in svg


def test_the_background_lies_behind_and_stretches_the_axes():
    background = (np.array([0.0, 9.0]), np.array([0.0, 9.0]))
    svg = scatter(Axis("a", np.ones(1)), Axis("b", np.ones(1)), ["x"], None, background)
    assert svg.count('class="background"') == 2
    assert svg.rindex('class="background"') < svg.index('class="mark"')
    assert {">0<", ">8<"} <= set(re.findall(r">\d<", svg))

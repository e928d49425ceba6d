"""Sizes bettered by gradients."""

import numpy as np
import pytest

from fascicle.design import Designs, Task, evaluate
from fascicle.design.refine import refine_sizes


pytest.importorskip("optax", reason="needs the extra `design`")


def test_refined_sizes_are_better_within_bounds(muscle):
    task = Task.of([60.0, 180.0, 300.0], [0.16, 0.1, 0.05], 413.7e3)
    designs = Designs.of(muscle, [(1, 2)])
    bounds = {"radius": (4e-3, 8e-3), "angle": (0.45, 0.65)}
    refined, cost = refine_sizes(
        designs, 0, task, "mean_energy", bounds, steps=25, starts=2, seed=1
    )
    before = evaluate(designs, task, ["mean_energy", "shortfall"])
    after = evaluate(refined, task, ["mean_energy", "shortfall"])
    best = int(np.argmin(cost))
    # less fluid, and nothing lost
    assert after["mean_energy"][best] < 0.95 * before["mean_energy"][0]
    assert after["shortfall"][best] <= before["shortfall"][0] + 1e-6
    there = refined.counts > 0
    assert np.all((refined.radius[there] >= 4e-3) & (refined.radius[there] <= 8e-3))
    assert np.all((refined.angle[there] >= 0.45) & (refined.angle[there] <= 0.65))
    assert np.all(refined.length == designs.length)
    assert np.all(
        np.isclose(refined.wall / refined.radius, designs.wall[0, 0] / designs.radius[0, 0])
    )


@pytest.mark.slow
def test_peak_of_zero_weight_is_reached(muscle):
    """By its mean energy alone it would give the peak up, which counts a millionth."""
    task = Task.of([60.0, 180.0, 330.0], [0.16, 0.1, 0.05], 413.7e3, [1.0, 1.0, 1e-6])
    designs = Designs.of(muscle, [(1, 2)])
    assert evaluate(designs, task, ["margin"])["margin"][0] > 0
    refined, cost = refine_sizes(
        designs, 0, task, "mean_energy", {"radius": (4e-3, 8e-3)}, steps=25, starts=2, seed=1
    )
    after = evaluate(refined, task, ["margin", "mean_energy"])
    assert np.all((after["margin"] >= -1e-9) == np.isfinite(cost))
    assert np.isfinite(cost[0]) and cost[0] <= 1.0


@pytest.mark.slow
def test_unreachable_task_gives_infinite_cost(muscle):
    designs = Designs.of(muscle, [(1, 2)])
    task = Task.of([60.0, 5000.0], [0.16, 0.05], 413.7e3, [1.0, 1e-6])
    bounds = {"radius": (4e-3, 8e-3)}
    refined, cost = refine_sizes(designs, 0, task, "mean_energy", bounds, steps=8, starts=2)
    assert np.all(np.isinf(cost)) and len(refined) == 2
    # nearer than what it began with
    before, after = (
        evaluate(which, task, ["relative_shortfall"])["relative_shortfall"]
        for which in (designs, refined)
    )
    assert after[0] < before[0]
    # half of the points may be missed, and half of the weight
    _, cost = refine_sizes(designs, 0, task, "mean_energy", bounds, steps=2, starts=2, may_miss=0.5)
    assert np.isfinite(cost[0])


def test_bounds_must_include_the_design(muscle):
    task = Task.of([60.0], [0.1], 413.7e3)
    designs = Designs.of(muscle, [(1, 2)])
    with pytest.raises(ValueError, match="`bounds` of radius must hold the design"):
        refine_sizes(designs, 0, task, "mean_energy", {"radius": (7e-3, 8e-3)})
    with pytest.raises(ValueError, match="`bounds` 'radii' is unknown"):
        refine_sizes(designs, 0, task, "mean_energy", {"radii": (7e-3, 8e-3)})

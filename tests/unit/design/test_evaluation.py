"""Objectives of whole batches: of one design, and of different units."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.design import OBJECTIVES, Designs, evaluate
from fascicle.design.space import compositions
from refusing import refuses


NAMES = tuple(OBJECTIVES)


@pytest.fixture(scope="module")
def five(muscle):
    return Designs.of(muscle, compositions(5))


@pytest.fixture(scope="module")
def values(five, task):
    return evaluate(five, task, NAMES)


def test_single_design_equals_the_same_design_in_a_batch(five, task, values):
    alone = evaluate(five.take(np.array([9])), task, NAMES)
    for name in NAMES:
        assert_allclose(alone[name][0], values[name][9], rtol=1e-12, atol=1e-12)


def test_different_units(muscle, task):
    """One unit of two sizes is what two muscles of these sizes are."""
    names = ("largest_force", "envelope", "valves", "mean_efficiency", "not_reached")
    same = Designs.of(muscle, [(1, 1)])
    radius = same.radius * np.array([[1.0, 1.2]])
    other = replace(same, radius=radius, wall=0.25 * radius)
    assert not other.uniform[0]
    values = evaluate(other, task, names)
    bundle = other.bundle(0, task)
    supply = np.full(2, task.supply_pressure)
    assert_allclose(values["largest_force"], bundle.force(supply, 0.0), rtol=1e-9)
    assert values["valves"] == [2]
    solution = fs.recruitment.recruit(bundle, task.force, task.strain)
    reached = solution.status == 0
    assert reached.tolist() == [True, True, True, False]
    assert_allclose(values["not_reached"], (task.weight * ~reached).sum() / task.weight.sum())
    fed = np.arange(2) < solution.state[:, None]
    taken = (fed * fs.energetics.unit_volume_change(bundle, task.strain)).sum(axis=1)
    work = task.force * task.strain * float(bundle.length)
    share = np.where(reached, work / (task.supply_pressure * taken), 0.0)
    assert_allclose(values["mean_efficiency"], np.average(share, weights=task.weight), rtol=1e-9)
    # two side by side, at the task's largest strain, and the deeper bow of either up to there
    muscles, steps = [unit.muscle for unit in bundle.motor_units], np.linspace(0, 0.2, 401)
    width = sum(float(muscle.braid.radius_at(0.2)) for muscle in muscles)
    bow = max(float(muscle.deflection(0.0, steps).max()) for muscle in muscles)
    assert_allclose(values["envelope"], 2 * (width + bow), rtol=1e-3)


def test_unknown_objectives_and_invalid_designs_are_refused(five, task):
    with refuses("objectives"):
        evaluate(five, task, ["mean_eficiency"])
    with refuses("wall_thickness"):
        evaluate(replace(five, wall=five.radius), task, ["valves"])

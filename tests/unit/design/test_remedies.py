"""What would reach a task: solved for, and checked by judging the changed design."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.design import Designs, Limit, Product, Task, evaluate
from fascicle.design.objectives import with_reach_limits
from fascicle.design.remedies import remedies


SUPPLY = 300e3
NONE = with_reach_limits(None)


@pytest.fixture(scope="module")
def designs(muscle):
    return Designs.of(muscle, [(1, 2)])


def margin(designs, task):
    return evaluate(designs, task, ["margin"])["margin"][0]


def by_name(*arguments):
    return {remedy.what: remedy for remedy in remedies(*arguments)}


@pytest.mark.parametrize("scheme", ["orderly", "batch"])
def test_each_remedy_is_just_enough(designs, scheme):
    task = Task.of([100.0, 600.0], [0.12, 0.04], SUPPLY, [1.0, 1e-9], scheme)
    assert margin(designs, task) < 0
    changes = by_name(designs, 0, task, 0.0, NONE)
    assert list(changes) == ["supply_pressure", "muscles", "radius"]
    P = changes["supply_pressure"].value
    for value, enough in ((P, True), (0.9999 * P, False)):
        assert bool(margin(designs, replace(task, supply_pressure=value)) >= -1e-9) is enough
    n = round(changes["muscles"].value)
    for value, enough in ((n, True), (n - 1, False)):
        changed = replace(designs, counts=np.array([[1, value - 1]]))
        assert bool(margin(changed, task) >= -1e-9) is enough
    r = changes["radius"].value
    for value, enough in ((r, True), (0.9999 * r, False)):
        by = value / designs.radius[0, 0]
        wider = replace(designs, radius=designs.radius * by, wall=designs.wall * by)
        assert bool(margin(wider, task) >= -1e-9) is enough


def test_radius_follows_similarity(designs):
    """Forces grow with the radius squared, the walls in proportion, where the muscle pulls."""
    task = Task.of([600.0], [0.04], SUPPLY)
    largest = 600.0 + margin(designs, task)
    radius = by_name(designs, 0, task, 0.0, NONE)["radius"].value
    assert_allclose(radius, designs.radius[0, 0] * np.sqrt(600.0 / largest), rtol=2e-6)


def test_insufficient_single_changes(designs):
    """At a third of its length this braid pushes, however many and at any pressure."""
    task = Task.of([10.0], [0.33], SUPPLY)
    changes = by_name(designs, 0, task, 0.0, NONE)
    for remedy in changes.values():
        assert remedy.value is None and remedy.short > 10.0 and remedy.largest < 0
        assert 0.2 < remedy.free_strain < 0.3116  # of 33°, ideally
    assert changes["supply_pressure"].most == 1e6
    assert changes["supply_pressure"].free_strain > changes["muscles"].free_strain


def test_a_stroke_is_reached_by_longer_muscles(designs):
    task = Task.of([50.0], None, SUPPLY, stroke=[0.05])
    changes = by_name(designs, 0, task, 0.0, NONE)
    assert list(changes) == ["supply_pressure", "muscles", "radius", "length"]
    L = changes["length"].value
    assert changes["muscles"].value is None
    for value, enough in ((L, True), (0.9999 * L, False)):
        assert bool(margin(replace(designs, length=np.array([value])), task) >= -1e-9) is enough


def test_remedies_allow_a_missed_share(designs):
    task = Task.of([100.0, 600.0, 5000.0], [0.12, 0.04, 0.05], SUPPLY)
    all_of_it = by_name(designs, 0, task, 0.0, NONE)["muscles"].value
    partial = by_name(designs, 0, task, 0.34, with_reach_limits({"not_reached": Limit(most=0.34)}))
    without = Task.of([100.0, 600.0], [0.12, 0.04], SUPPLY)
    assert partial["muscles"].value == by_name(designs, 0, without, 0.0, NONE)["muscles"].value
    assert all_of_it > partial["muscles"].value


def test_remedies_name_broken_limits(designs):
    task = Task.of([600.0], [0.04], SUPPLY)
    now = evaluate(designs, task, ["envelope"])["envelope"][0]
    limits = with_reach_limits({"envelope": Limit(most=now + 1e-6), "valves": Limit(most=2)})
    changes = by_name(designs, 0, task, 0.0, limits)
    assert changes["supply_pressure"].breaks == ()
    for what in ("radius", "muscles"):
        ((name, value),) = changes[what].breaks
        assert name == "envelope" and value > now


def test_product_radius_is_fixed(designs):
    task = Task.of([600.0], [0.04], SUPPLY)
    changes = by_name(designs, 0, task, 0.0, NONE, Product("p", largest_pressure=320e3))
    assert list(changes) == ["supply_pressure", "muscles"]
    assert changes["supply_pressure"].value is None and changes["supply_pressure"].most == 320e3


def test_thousands_of_points(designs):
    """The hardest is looked at first; it is another one at another pressure."""
    generator = np.random.default_rng(2)
    strain = generator.uniform(0.01, 0.15, 2000)
    force = generator.uniform(0, 1, 2000) * 900 * (1 - strain / 0.2)
    task = Task.of(force, strain, SUPPLY)
    for what, remedy in by_name(designs, 0, task, 0.0, NONE).items():
        assert remedy.value is not None, what
    P = remedies(designs, 0, task, 0.0, NONE)[0].value
    assert margin(designs, replace(task, supply_pressure=P)) >= -1e-9
    assert margin(designs, replace(task, supply_pressure=0.9999 * P)) < 0

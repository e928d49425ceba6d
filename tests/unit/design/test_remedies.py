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
    return {one.what: one for one in remedies(*arguments)}


@pytest.mark.parametrize("scheme", ["orderly", "batch"])
def test_each_is_just_enough(designs, scheme):
    task = Task.of([100.0, 600.0], [0.12, 0.04], SUPPLY, [1.0, 1e-9], scheme)
    assert margin(designs, task) < 0
    found = by_name(designs, 0, task, 0.0, NONE)
    assert list(found) == ["supply_pressure", "muscles", "radius"]
    P = found["supply_pressure"].value
    for value, enough in ((P, True), (0.9999 * P, False)):
        assert bool(margin(designs, replace(task, supply_pressure=value)) >= -1e-9) is enough
    n = round(found["muscles"].value)
    for value, enough in ((n, True), (n - 1, False)):
        more = replace(designs, counts=np.array([[1, value - 1]]))
        assert bool(margin(more, task) >= -1e-9) is enough
    r = found["radius"].value
    for value, enough in ((r, True), (0.9999 * r, False)):
        by = value / designs.radius[0, 0]
        wider = replace(designs, radius=designs.radius * by, wall=designs.wall * by)
        assert bool(margin(wider, task) >= -1e-9) is enough


def test_the_radius_is_what_similarity_says(designs):
    """Forces grow with the radius squared, the walls in proportion, where the muscle pulls."""
    task = Task.of([600.0], [0.04], SUPPLY)
    largest = 600.0 + margin(designs, task)
    radius = by_name(designs, 0, task, 0.0, NONE)["radius"].value
    assert_allclose(radius, designs.radius[0, 0] * np.sqrt(600.0 / largest), rtol=2e-6)


def test_what_one_alone_can_not(designs):
    """At a third of its length this braid pushes, however many and at any pressure."""
    task = Task.of([10.0], [0.33], SUPPLY)
    found = by_name(designs, 0, task, 0.0, NONE)
    for one in found.values():
        assert one.value is None and one.short > 10.0 and one.largest < 0
        assert 0.2 < one.free_strain < 0.3116  # of 33°, ideally
    assert found["supply_pressure"].most == 1e6
    assert found["supply_pressure"].free_strain > found["muscles"].free_strain


def test_a_pressure_that_is_beyond_the_models(designs):
    task = Task.of([5000.0], [0.05], SUPPLY)
    found = by_name(designs, 0, task, 0.0, NONE)
    assert found["supply_pressure"].value is None and found["supply_pressure"].largest > 0
    assert found["muscles"].value is not None and found["radius"].value is not None


def test_a_stroke_is_reached_by_longer_muscles(designs):
    task = Task.of([50.0], None, SUPPLY, stroke=[0.05])
    found = by_name(designs, 0, task, 0.0, NONE)
    assert list(found) == ["supply_pressure", "muscles", "radius", "length"]
    L = found["length"].value
    assert found["muscles"].value is None
    for value, enough in ((L, True), (0.9999 * L, False)):
        assert bool(margin(replace(designs, length=np.array([value])), task) >= -1e-9) is enough


def test_what_may_be_missed_need_not_be_reached(designs):
    task = Task.of([100.0, 600.0, 5000.0], [0.12, 0.04, 0.05], SUPPLY)
    all_of_it = by_name(designs, 0, task, 0.0, NONE)["muscles"].value
    some = by_name(designs, 0, task, 0.34, with_reach_limits({"not_reached": Limit(most=0.34)}))
    without = Task.of([100.0, 600.0], [0.12, 0.04], SUPPLY)
    assert some["muscles"].value == by_name(designs, 0, without, 0.0, NONE)["muscles"].value
    assert all_of_it > some["muscles"].value


def test_limits_that_a_change_breaks_are_told(designs):
    task = Task.of([600.0], [0.04], SUPPLY)
    now = evaluate(designs, task, ["envelope"])["envelope"][0]
    limits = with_reach_limits({"envelope": Limit(most=now + 1e-6), "valves": Limit(most=2)})
    found = by_name(designs, 0, task, 0.0, limits)
    assert found["supply_pressure"].breaks == ()
    for what in ("radius", "muscles"):
        ((name, value),) = found[what].breaks
        assert name == "envelope" and value > now


def test_a_product_is_bought_as_it_is(designs):
    task = Task.of([600.0], [0.04], SUPPLY)
    found = by_name(designs, 0, task, 0.0, NONE, Product("p", largest_pressure=320e3))
    assert list(found) == ["supply_pressure", "muscles"]
    assert found["supply_pressure"].value is None and found["supply_pressure"].most == 320e3


def test_thousands_of_points(designs):
    """The hardest is looked at first; it is another one at another pressure."""
    generator = np.random.default_rng(2)
    strain = generator.uniform(0.01, 0.15, 2000)
    force = generator.uniform(0, 1, 2000) * 900 * (1 - strain / 0.2)
    task = Task.of(force, strain, SUPPLY)
    for what, one in by_name(designs, 0, task, 0.0, NONE).items():
        assert one.value is not None, what
    P = remedies(designs, 0, task, 0.0, NONE)[0].value
    assert margin(designs, replace(task, supply_pressure=P)) >= -1e-9
    assert margin(designs, replace(task, supply_pressure=0.9999 * P)) < 0

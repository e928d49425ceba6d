"""What would hold a task: solved for, and checked by judging the changed design."""

from dataclasses import replace

import numpy as np
import pytest

from fascicle.design import Designs, DesignScatter, Limit, Product, Task, Uncertainty, evaluate
from fascicle.design.answer import remedies
from fascicle.design.objectives import with_reach_limits
from fascicle.design.scatter import spread


SUPPLY = 300e3
NONE = with_reach_limits(None)


@pytest.fixture(scope="module")
def designs(muscle):
    return Designs.of(muscle, [(1, 2)])


def margin(designs, task):
    return evaluate(designs, task, ["margin"])["margin"][0]


def by_name(*arguments):
    return {remedy.what: remedy for remedy in remedies(*arguments)}


def changed(designs, task, what, value):
    """The design and its task with a value, by its definition."""
    if what == "supply_pressure":
        return designs, replace(task, supply_pressure=value)
    if what == "muscles":
        return replace(designs, counts=np.array([[1, round(value) - 1]])), task
    if what == "radius":
        by = value / designs.radius[0, 0]
        return replace(designs, radius=designs.radius * by, wall=designs.wall * by), task
    if what == "braid_angle":
        return replace(designs, angle=0 * designs.angle + value), task
    return replace(designs, length=np.array([value])), task


@pytest.mark.parametrize("scheme", ["orderly", "batch"])
@pytest.mark.parametrize("stroke", [False, True])
def test_each_change_is_just_enough(designs, scheme, stroke):
    strain = [0.12, 0.04]
    task = Task.of([100.0, 600.0], strain, SUPPLY, [1.0, 1e-9], scheme)
    if stroke:
        lengths = [0.127 * x for x in strain]
        task = Task.of([100.0, 500.0], None, SUPPLY, scheme=scheme, stroke=lengths)
    assert margin(designs, task) < 0
    changes = by_name(designs, task, NONE)
    length = ["length"] if stroke else []
    assert list(changes) == ["supply_pressure", "muscles", "radius", "braid_angle", *length]
    for what, remedy in changes.items():
        value = remedy.value
        if value is None:
            assert what == "length"
            continue
        less = value - 1 if what == "muscles" else value + 1e-4 * (remedy.now - value)
        for x, enough in ((value, True), (less, False)):
            assert bool(margin(*changed(designs, task, what, x)) >= -1e-9) is enough, what


def test_changes_are_safe_in_draws(designs):
    task = Task.of([400.0], [0.05], SUPPLY)
    judged = Uncertainty(DesignScatter(0.01, 0.02, 0.05, 0.15), draws=500)
    for what, remedy in by_name(designs, task, NONE, None, judged).items():
        draws = spread(*changed(designs, task, what, remedy.value), (), NONE, judged.scatter,
                       draws=500)  # fmt: skip
        assert 0.95 <= draws.probability[0] <= (1.0 if what == "muscles" else 0.97), what


def test_insufficient_single_changes(designs):
    """At a third of its length this braid pushes, however many and at any pressure."""
    changes = by_name(designs, Task.of([10.0], [0.33], SUPPLY), NONE)
    assert changes["supply_pressure"].most == 1e6
    for what in ("supply_pressure", "muscles", "radius"):
        assert changes[what].value is None and not changes[what].reaches
    assert changes["braid_angle"].value < np.radians(33)


def test_no_change_breaks_a_limit(designs):
    task = Task.of([600.0], [0.04], SUPPLY)
    now = evaluate(designs, task, ["envelope"])["envelope"][0]
    limits = with_reach_limits({"envelope": Limit(most=now + 1e-6), "valves": Limit(most=2)})
    changes = by_name(designs, task, limits)
    assert changes["supply_pressure"].value is not None
    for what in ("radius", "muscles"):
        assert changes[what].value is None and changes[what].reaches


def test_a_product_has_its_own_sizes(designs):
    task = Task.of([600.0], [0.04], SUPPLY)
    changes = by_name(designs, task, NONE, Product("p", largest_pressure=320e3))
    assert list(changes) == ["supply_pressure", "muscles"]
    assert changes["supply_pressure"].value is None and changes["supply_pressure"].most == 320e3

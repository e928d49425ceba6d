import numpy as np
import pytest

from fascicle.design import Limit, Space, Task, search
from fascicle.design.exhaustive_search import as_minimization


SENSES = {"mean_efficiency": "max", "valves": "min", "reversal_depth": "min"}
# one of the task's four points is beyond any of them
LIMITS = {"valves": Limit(most=4), "not_reached": Limit(most=0.25)}


@pytest.fixture(scope="module")
def found(muscle, task):
    return search(Space({"m": muscle}, (5,)), task, SENSES, LIMITS)


def test_nothing_on_the_front_is_bettered(found):
    points = as_minimization(found.values, SENSES)
    assert 1 < len(found.front) < np.sum(found.allowed)
    for place in np.flatnonzero(found.allowed):
        better = [
            other
            for other in np.flatnonzero(found.allowed)
            if np.all(points[other] <= points[place]) and np.any(points[other] < points[place])
        ]
        assert (place in found.front) == (not better)


def test_limits_are_kept(found):
    assert np.all(found.values["valves"][found.front] <= 4)
    assert not np.all(found.allowed) and len(found.index) == 16


def test_the_first_objective_leads(found):
    assert np.all(np.diff(found.values["mean_efficiency"][found.front]) <= 0)


def test_the_compromise_is_least_bad(found):
    points = found.points
    share = (points - points.min(axis=0)) / np.ptp(points, axis=0)
    assert share.max(axis=1)[found.compromise] == share.max(axis=1).min()


def test_the_recommended_one_is_the_cheapest(found):
    assert found.designs.labels[found.recommended] == "5"


def test_the_cheapest_is_told_though_it_isnt_on_the_front(muscle):
    task = Task.of([40.0, 150.0], [0.2, 0.1], 413.7e3)
    found = search(Space({"m": muscle}, (2, 3)), task, {"largest_force": "max"})
    assert "2" not in found.designs.labels[:-1]
    assert found.designs.labels[found.recommended] == "2"
    assert found.recommended == len(found.front) and found.compromise == 0


def test_all_must_be_reached_unless_it_is_said(muscle, task):
    space = Space({"m": muscle}, (5,))
    found = search(space, task, SENSES)
    assert not found.front.size and found.recommended is None and found.compromise is None
    assert found.nearest is not None and len(found.designs) == 0
    # a fifth of the weight is missed, and a quarter of the points: both count
    assert search(space, task, SENSES, {"not_reached": Limit(most=0.2)}).recommended is None
    assert search(space, task, SENSES, {"not_reached": Limit(most=0.25)}).recommended is not None


def test_a_peak_load_is_not_hidden_by_its_weight(muscle):
    hardly = Task.of([40.0] * 9 + [900.0], [0.1] * 10, 413.7e3, [1.0] * 9 + [1e-9])
    space = Space({"m": muscle}, (5, 9))
    found = search(space, hardly, {"valves": "min"}, {"valves": Limit(most=1)})
    assert found.designs.labels == ["9"]
    # a tenth of the points is that one
    some = {"valves": Limit(most=1), "not_reached": Limit(most=0.1)}
    assert search(space, hardly, {"valves": "min"}, some).designs.labels[0] == "5"
    fewer = some | {"not_reached": Limit(most=0.09)}
    assert search(space, hardly, {"valves": "min"}, fewer).designs.labels == ["9"]


def test_of_all_designs_one_reaches_the_task(muscle):
    space = Space({"m": muscle}, splits=((4,),), radius=(5e-3, 6e-3, 7e-3))
    strong = search(space, Task.of([100.0], [0.05], 413.7e3), {"margin": "max"})
    *_, second, best = np.sort(strong.values["margin"])
    found = search(
        space, Task.of([100.0 + 0.5 * (best + second)], [0.05], 413.7e3), {"envelope": "min"}
    )
    assert found.allowed.tolist() == [False, False, True]
    assert found.recommended == 0 and found.designs.radius[0, 0] == 7e-3
    assert found.values["margin"][2] == pytest.approx(0.5 * (best - second), rel=1e-9)
    # it gives all that it can
    last = search(space, Task.of([100.0 + best], [0.05], 413.7e3), {"envelope": "min"})
    assert last.allowed.tolist() == [False, False, True]
    none = search(space, Task.of([100.0 + best + 1e-6], [0.05], 413.7e3), {"envelope": "min"})
    assert none.recommended is None and none.nearest == 2


def test_the_nearest_misses_the_smallest_share_of_its_worst_point(muscle, task):
    found = search(Space({"m": muscle}, (4, 5)), task, SENSES, {"valves": Limit(most=2)})
    kept = found.values["valves"] <= 2
    least = found.values["relative_shortfall"][kept].min()
    assert found.values["relative_shortfall"][found.nearest] == pytest.approx(least, rel=1e-9)
    # it keeps the other limits; of equals it has the fewest valves
    assert found.values["valves"][found.nearest] == 1
    assert found.all_designs(np.array([found.nearest])).labels == ["5"]


def test_a_stroke_is_another_strain_for_each_length(muscle):
    stroke = Task.of([100.0], None, 413.7e3, stroke=[0.02])
    space = Space({"m": muscle}, splits=((3,),), length=(0.12, 0.15, 0.03))
    found = search(space, stroke, {"margin": "max"}, {"not_reached": Limit(most=1.0)})
    for length, margin in zip((0.12, 0.15), found.values["margin"], strict=False):
        alone = search(
            Space({"m": muscle}, splits=((3,),), length=(length,)),
            Task.of([100.0], [0.02 / length], 413.7e3), {"margin": "max"},
            {"not_reached": Limit(most=1.0)},
        )  # fmt: skip
        np.testing.assert_allclose(margin, alone.values["margin"][0], rtol=1e-9)
    # 20 of 30 mm: no muscle does that, nor do the laws reach so far
    assert found.values["margin"][2] <= -100.0
    assert found.values["not_reached"].tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("force", [0.0, 50.0])
def test_no_muscle_contracts_so_far(muscle, force):
    """At half its length a muscle of 33° pushes, whatever the pressure, with no load too."""
    task = Task.of([10.0, force], [0.1, 0.5], 413.7e3, [1.0, 1e-6])
    found = search(Space({"m": muscle}, (5,)), task, SENSES)
    assert found.recommended is None
    assert np.all(found.values["points_not_reached"] == 0.5)


def test_no_design_left(muscle, task):
    found = search(
        Space({"m": muscle}, (5,)), task, {"valves": "min"}, {"largest_force": Limit(least=1e6)}
    )
    assert found.nearest is not None
    assert found.front.size == 0 and found.recommended is None and len(found.designs) == 0


@pytest.mark.parametrize(
    ("senses", "limits", "message"),
    [
        ({}, {}, "`objectives` must name"),
        ({"valve": "min"}, {}, "did you mean 'valves'"),
        ({"valves": "least"}, {}, "`valves` 'least' is unknown"),
        ({"valves": "min"}, {"envelope": Limit(2.0, 1.0)}, "nothing can be both"),
        ({"valves": "min"}, {"not_reached": Limit(least=0.5)}, "nothing can be both"),
    ],
)
def test_what_can_not_be_searched_for(muscle, task, senses, limits, message):
    with pytest.raises(ValueError, match=message):
        search(Space({"m": muscle}, (2,)), task, senses, limits)

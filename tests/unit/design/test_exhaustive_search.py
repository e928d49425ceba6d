import numpy as np
import pytest

from fascicle.design import Catalog, Limit, Space, Task, search
from fascicle.design.objectives import as_minimization


SENSES = {"mean_efficiency": "max", "valves": "min", "reversal_depth": "min"}
# one of the task's four points is beyond any of them
LIMITS = {"valves": Limit(most=4), "not_reached": Limit(most=0.25)}


@pytest.fixture(scope="module")
def result(muscle, task):
    return search(Space({"m": muscle}, (5,)), task, SENSES, LIMITS)


def test_front_is_not_dominated(result):
    points = as_minimization(result.values, SENSES)
    assert 1 < len(result.front) < np.sum(result.allowed)
    for place in np.flatnonzero(result.allowed):
        better = [
            other
            for other in np.flatnonzero(result.allowed)
            if np.all(points[other] <= points[place]) and np.any(points[other] < points[place])
        ]
        assert (place in result.front) == (not better)


def test_limits_are_kept(result):
    assert np.all(result.values["valves"][result.front] <= 4)
    assert not np.all(result.allowed) and len(result.index) == 16


def test_compromise_has_the_least_worst_objective(result):
    points = result.points
    share = (points - points.min(axis=0)) / np.ptp(points, axis=0)
    assert share.max(axis=1)[result.offers["compromise"]] == share.max(axis=1).min()


def test_offers_are_on_the_front_and_best_in_their_way(result):
    assert list(result.offers) == ["compromise", "simplest", "most efficient"]
    assert (
        result.recommended == result.offers["compromise"]
        and result.best == result.front[result.offers["compromise"]]
    )
    values = {name: result.values[name][result.front] for name in SENSES}
    assert values["valves"][result.offers["simplest"]] == values["valves"].min()
    efficient = result.offers["most efficient"]
    assert values["mean_efficiency"][efficient] == values["mean_efficiency"].max()


def test_the_simplest_of_one_cross_section_has_fewest_muscles(muscle):
    space = Space({"m": muscle}, (4, 2), radius=(0.014,), radius_rule="cross_section")
    prices = Catalog({}, "EUR", valve=1.0, muscle=1.0)
    result = search(space, Task.of([100.0], [0.05], 413.7e3), catalog=prices)
    assert {"2", "4"} <= set(result.designs.labels)
    assert result.designs.labels[result.offers["simplest"]] == "2"


def test_a_cheaper_design_that_is_dominated_is_not_recommended(muscle):
    task = Task.of([40.0, 150.0], [0.2, 0.1], 413.7e3)
    result = search(Space({"m": muscle}, (2, 3)), task, {"largest_force": "max"})
    assert result.allowed[result.all_designs(np.arange(len(result.index))).labels.index("2")]
    assert result.designs.labels[result.recommended] == "3"


def test_whole_task_is_required_by_default(muscle, task):
    space = Space({"m": muscle}, (5,))
    result = search(space, task, SENSES)
    assert not result.front.size and result.recommended is None and not result.offers
    assert result.nearest is not None and len(result.designs) == 0
    # a fifth of the weight is missed, and a quarter of the points: both count
    assert search(space, task, SENSES, {"not_reached": Limit(most=0.2)}).recommended is None
    assert search(space, task, SENSES, {"not_reached": Limit(most=0.25)}).recommended is not None


def test_peak_load_of_small_weight_counts(muscle):
    hardly = Task.of([40.0] * 9 + [900.0], [0.1] * 10, 413.7e3, [1.0] * 9 + [1e-9])
    space = Space({"m": muscle}, (5, 9))
    result = search(space, hardly, {"valves": "min"}, {"valves": Limit(most=1)})
    assert result.designs.labels == ["9"]
    # a tenth of the points is that one
    limits = {"valves": Limit(most=1), "not_reached": Limit(most=0.1)}
    assert search(space, hardly, {"valves": "min"}, limits).designs.labels[0] == "5"
    fewer = limits | {"not_reached": Limit(most=0.09)}
    assert search(space, hardly, {"valves": "min"}, fewer).designs.labels == ["9"]


def test_of_all_designs_one_reaches_the_task(muscle):
    space = Space({"m": muscle}, splits=((4,),), radius=(5e-3, 6e-3, 7e-3))
    strong = search(space, Task.of([100.0], [0.05], 413.7e3), {"margin": "max"})
    *_, second, best = np.sort(strong.values["margin"])
    result = search(
        space, Task.of([100.0 + 0.5 * (best + second)], [0.05], 413.7e3), {"envelope": "min"}
    )
    assert result.allowed.tolist() == [False, False, True]
    assert result.recommended == 0 and result.designs.radius[0, 0] == 7e-3
    assert result.values["margin"][2] == pytest.approx(0.5 * (best - second), rel=1e-9)
    # it gives all that it can
    last = search(space, Task.of([100.0 + best], [0.05], 413.7e3), {"envelope": "min"})
    assert last.allowed.tolist() == [False, False, True]
    none = search(space, Task.of([100.0 + best + 1e-6], [0.05], 413.7e3), {"envelope": "min"})
    assert none.recommended is None and none.nearest == 2


def test_nearest_design_misses_the_smallest_share(muscle, task):
    result = search(Space({"m": muscle}, (4, 5)), task, SENSES, {"valves": Limit(most=2)})
    allowed = result.values["valves"] <= 2
    least = result.values["relative_shortfall"][allowed].min()
    assert result.values["relative_shortfall"][result.nearest] == pytest.approx(least, rel=1e-9)
    # it keeps the other limits; of equals it has the fewest valves
    assert result.values["valves"][result.nearest] == 1
    assert result.all_designs(np.array([result.nearest])).labels == ["5"]


def test_stroke_gives_a_strain_for_each_length(muscle):
    stroke = Task.of([100.0], None, 413.7e3, stroke=[0.02])
    space = Space({"m": muscle}, splits=((3,),), length=(0.12, 0.15, 0.03))
    result = search(space, stroke, {"margin": "max"}, {"not_reached": Limit(most=1.0)})
    for length, margin in zip((0.12, 0.15), result.values["margin"], strict=False):
        alone = search(
            Space({"m": muscle}, splits=((3,),), length=(length,)),
            Task.of([100.0], [0.02 / length], 413.7e3), {"margin": "max"},
            {"not_reached": Limit(most=1.0)},
        )  # fmt: skip
        np.testing.assert_allclose(margin, alone.values["margin"][0], rtol=1e-9)
    # 20 of 30 mm: no muscle does that, nor do the laws reach so far
    assert result.values["margin"][2] <= -100.0
    assert result.values["not_reached"].tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("force", [0.0, 50.0])
def test_contraction_beyond_every_muscle(muscle, force):
    """At half its length a muscle of 33° pushes, whatever the pressure, with no load too."""
    task = Task.of([10.0, force], [0.1, 0.5], 413.7e3, [1.0, 1e-6])
    result = search(Space({"m": muscle}, (5,)), task, SENSES)
    assert result.recommended is None
    assert np.all(result.values["points_not_reached"] == 0.5)

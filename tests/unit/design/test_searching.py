import numpy as np
import pytest

from fascicle.design import Limit, Space, search
from fascicle.design.pareto import directed


SENSES = {"mean_efficiency": "max", "valves": "min", "reversal_depth": "min"}


@pytest.fixture(scope="module")
def found(muscle, task):
    return search(Space({"m": muscle}, (5,)), task, SENSES, {"valves": Limit(most=4)})


def test_nothing_on_the_front_is_bettered(found):
    points = directed(found.values, SENSES)
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


def test_the_recommended_one_is_least_bad(found):
    points = found.points
    share = (points - points.min(axis=0)) / np.ptp(points, axis=0)
    assert share.max(axis=1)[found.recommended] == share.max(axis=1).min()


def test_no_design_left(muscle, task):
    found = search(
        Space({"m": muscle}, (5,)), task, {"valves": "min"}, {"largest_force": Limit(least=1e6)}
    )
    assert found.front.size == 0 and found.recommended is None and len(found.designs) == 0


@pytest.mark.parametrize(
    ("senses", "limits", "message"),
    [
        ({}, {}, "`objectives` must name"),
        ({"valve": "min"}, {}, "did you mean 'valves'"),
        ({"valves": "least"}, {}, "`valves` 'least' is unknown"),
        ({"valves": "min"}, {"envelope": Limit(2.0, 1.0)}, "nothing can be both"),
    ],
)
def test_what_can_not_be_searched_for(muscle, task, senses, limits, message):
    with pytest.raises(ValueError, match=message):
        search(Space({"m": muscle}, (2,)), task, senses, limits)

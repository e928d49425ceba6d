"""What must be reached is a limit like any other, and counted by points as well as by weight."""

import numpy as np
import pytest

from fascicle.design import Limit, non_dominated
from fascicle.design.objectives import reaches_task, with_reach_limits, within_limits


@pytest.mark.parametrize(
    ("missed", "weight", "share", "expected"),
    [
        ([0, 0, 0], [1, 1, 1], 0.0, True),
        ([0, 0, 1], [1, 1, 1e-12], 0.0, False),
        ([0, 0, 1], [1, 1, 0.0], 0.0, False),
        ([0, 0, 1], [1, 1, 1e-12], 0.34, True),
        ([0, 0, 1], [1, 1, 1e-12], 0.33, False),
        ([0, 0, 1], [1, 1, 8], 0.34, False),
        ([1, 0, 0, 0, 0, 0, 0, 0, 0, 0], [0.1] * 10, 0.1, True),
    ],
)
def test_both_shares_must_be_small(missed, weight, share, expected):
    values = {
        "not_reached": np.array([np.average(missed, weights=weight)]),
        "points_not_reached": np.array([np.mean(missed)]),
    }
    limits = with_reach_limits({"not_reached": Limit(most=share)})
    assert bool(reaches_task(values, limits)[0]) is expected


def test_rounding_breaks_no_limit():
    third = np.array([0.1 + 0.2])
    assert within_limits({"not_reached": third}, {"not_reached": Limit(most=0.3)})[0]
    assert not within_limits({"not_reached": third + 1e-9}, {"not_reached": Limit(most=0.3)})[0]
    assert not within_limits({"margin": np.array([np.nan])}, {"margin": Limit(least=0.0)})[0]
    assert Limit(1.0, 2.0).excess(np.array([0.5, 1.5, 3.0])) == pytest.approx([0.5, -0.5, 1.0])


def plain_front(points):
    """By the definition, one by one."""
    return [
        not any(np.all(b <= a) and np.any(b < a) for b in points) and not np.any(np.isnan(a))
        for a in points
    ]


@pytest.mark.parametrize("objectives", [1, 2, 3, 5])
def test_front_matches_the_definition(objectives):
    rng = np.random.default_rng(objectives)
    # whole numbers: many ties and equal points
    points = rng.integers(0, 6, (700, objectives)).astype(float)
    assert non_dominated(points).tolist() == plain_front(points)

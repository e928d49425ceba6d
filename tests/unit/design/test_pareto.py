import numpy as np
import pytest

from fascicle.design.exhaustive_search import hypervolume, non_dominated


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


def test_hypervolume_of_boxes():
    assert hypervolume(np.array([[1.0, 1.0]]), (3.0, 2.0)) == 2.0
    # two boxes that overlap in a unit square
    assert hypervolume(np.array([[0.0, 1.0], [1.0, 0.0]]), (2.0, 2.0)) == 3.0
    assert hypervolume(np.array([[5.0, 0.0]]), (2.0, 2.0)) == 0.0


def test_nan_adds_no_hypervolume():
    points = np.array([[np.nan, 0.0], [1.0, np.nan], [1.0, 1.0]])
    assert hypervolume(points, (3.0, 2.0)) == 2.0
    assert hypervolume(points[:2], (3.0, 2.0)) == hypervolume(points[:0], (3.0, 2.0)) == 0.0


@pytest.mark.parametrize("objectives", [2, 3, 4, 6])
def test_hypervolume_against_counting(objectives):
    rng = np.random.default_rng(objectives)
    points = rng.uniform(size=(12, objectives))
    tried = rng.uniform(size=(200_000, objectives))
    dominated = np.zeros(len(tried), bool)
    for point in points:
        dominated |= np.all(tried >= point, axis=1)
    # five deviations of a share of 200 000 draws are 0.0056
    assert hypervolume(points, np.ones(objectives)) == pytest.approx(dominated.mean(), abs=6e-3)

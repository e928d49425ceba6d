import numpy as np
import pytest

from fascicle.design.objectives import non_dominated


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

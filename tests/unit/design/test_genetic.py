"""NSGA-II against the exhaustive front, and its seed."""

import moocore
import numpy as np
import pytest

from fascicle.design import Limit, Space, Task, search
from refusing import refuses


pytest.importorskip("pymoo", reason="needs the extra `design`")
from fascicle.design.genetic import GenomeDecoder, evolve


SENSES = {"mean_efficiency": "max", "envelope": "min", "valves": "min"}
LIMITS = {"not_reached": Limit(most=0.5)}


@pytest.fixture(scope="module")
def space(muscle):
    return Space(
        {"m": muscle}, (3, 4, 5), length=(0.11, 0.127, 0.15), radius=(0.011, 0.014),
        radius_rule="cross_section",
    )  # fmt: skip


@pytest.fixture(scope="module")
def evolved(space, task):
    return evolve(space, task, SENSES, LIMITS, 32, 25, seed=1, continuous=False)


@pytest.mark.slow
def test_evolution_finds_the_exhaustive_front(muscle, task):
    """Of 38 448 designs it judges 10 000."""
    space = Space(
        {"m": muscle}, (6, 8, 10), length=(0.1, 0.11, 0.127, 0.15), radius=(0.016, 0.018, 0.02),
        radius_rule="cross_section", wall_ratio=(0.2, 0.25), braid_angle=(0.5, 0.55, 0.6),
        most_units=6,
    )  # fmt: skip
    evolved = evolve(space, task, SENSES, LIMITS, 100, 100, seed=0, continuous=False)
    exhaustive = search(space, task, SENSES, LIMITS)
    assert evolved.judged < 0.3 * len(space)
    points = exhaustive.points
    # a little worse than the worst of the front in each
    limit = points.max(axis=0) + 0.1 * np.ptp(points, axis=0)
    whole = moocore.hypervolume(points, ref=limit)
    result = moocore.hypervolume(evolved.points, ref=limit)
    # no more than all of it, up to rounding of a design in two batches
    assert 0.99 * whole <= result <= whole * (1 + 1e-9)
    assert np.all(evolved.values["not_reached"] <= 0.5)


def test_same_seed_gives_same_front(space, task, evolved):
    again = evolve(space, task, SENSES, LIMITS, 32, 25, seed=1, continuous=False)
    assert again.judged == evolved.judged == 25 * 32
    for name, column in evolved.values.items():
        assert np.array_equal(column, again.values[name])


def test_whole_task_is_required_by_default(space, task, evolved):
    """The task's last point is beyond all of them: the nearest is told, and nothing else."""
    result = evolve(space, task, SENSES, None, 32, 6, seed=1, continuous=False)
    assert result.recommended is None and not result.front.size
    assert result.judged == 6 * 32
    miss = result.values["relative_shortfall"][result.nearest]
    exhaustive = search(space, task, SENSES)
    least = exhaustive.values["relative_shortfall"].min()
    # a design at random is 0.05 to 0.4 worse than the nearest of all
    assert least - 1e-9 <= miss <= least + 0.02
    # half of the task may be missed: all designs of its front reach as much
    assert np.all(evolved.values["points_not_reached"] <= 0.5)


def test_search_finds_rare_design_that_reaches_the_task(muscle):
    """A peak that one in forty of the space's designs reaches, and that counts a millionth."""
    space = Space({"m": muscle}, (2, 3, 4, 5), radius=(4e-3, 9e-3), length=(0.11, 0.15))
    peak = Task.of([60.0, 1450.0], [0.1, 0.03], 413.7e3, [1.0, 1e-6])
    result = evolve(space, peak, SENSES, None, 32, 12, seed=3)
    assert result.recommended is not None
    assert np.all(result.values["margin"][result.allowed] >= -1e-9)


def test_unsupported_spaces_are_refused(muscle):
    with refuses("drawings"):
        GenomeDecoder(Space({"a": muscle, "b": muscle}, (2,)), continuous=True)
    with refuses("splits"):
        GenomeDecoder(Space({"a": muscle}, (2,), splits="partitions"), continuous=True)

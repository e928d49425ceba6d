"""Objectives under scatter and uncertain constants."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.design import Designs, Limit, Task, evaluate
from fascicle.design.scatter import spread
from fascicle.records.dynamometer import Scatter


NAMES = ("mean_efficiency", "largest_force")


@pytest.fixture(scope="module")
def designs(muscle):
    return Designs.of(muscle, [(1, 2), (1, 1, 1)])


@pytest.fixture(scope="module")
def reachable():
    return Task.of([40.0, 150.0, 300.0], [0.2, 0.1, 0.05], 413.7e3)


@pytest.fixture(scope="module")
def scattered(designs, reachable):
    limits = {"largest_force": Limit(least=560.0)}
    return spread(designs, reachable, NAMES, limits, Scatter(0.01, 0.02), draws=64, seed=3)


def test_no_scatter_gives_no_spread(designs, reachable):
    result = spread(designs, reachable, NAMES, draws=64)
    exact = evaluate(designs, reachable, NAMES)
    for name in NAMES:
        assert np.ptp(result.values[name], axis=1).max() == 0
        # edges over 33 levels, not 257: no demanded point is near one
        assert_allclose(result.values[name][:, 0], exact[name], rtol=1e-9)
    assert set(result.probability) <= {0.0, 1.0}


def test_draw_must_reach_the_whole_task_by_default(designs):
    peak = Task.of([40.0, 5000.0], [0.1, 0.02], 413.7e3, [1.0, 1e-9])
    assert not spread(designs, peak, NAMES, draws=64).met.any()
    half = {"not_reached": Limit(most=0.5)}
    assert spread(designs, peak, NAMES, half, draws=64).met.all()


def test_probability_and_quantiles(scattered):
    forces = scattered.values["largest_force"]
    reached = scattered.values["not_reached"] == 0
    assert_allclose(scattered.probability, np.mean((forces >= 560) & reached, axis=1))
    assert np.all((scattered.probability > 0) & (scattered.probability < 1))
    low, high = scattered.quantile(0.1), scattered.quantile(0.9)
    assert np.all(low["largest_force"] < high["largest_force"])


def test_blocked_force_spreads_with_the_angle(muscle, designs, reachable):
    """Linearly: dF/dα of a muscle, times their number and the deviation that they share."""
    result = spread(designs, reachable, ("largest_force",), None, Scatter(0.0, 1e-4), draws=64)
    h = 1e-5

    def blocked(angle):
        moved = eqx.tree_at(lambda m: m.braid_angle, muscle, jnp.asarray(angle))
        return float(moved.blocked_force(reachable.supply_pressure))

    angle = float(muscle.braid_angle)
    slope = (blocked(angle + h) - blocked(angle - h)) / (2 * h)
    expected = abs(slope) * 1e-4 * np.array([3, 3])
    got = result.values["largest_force"].std(axis=1)
    # a deviation of 64 draws scatters by 9 %; three of these
    assert_allclose(got, expected, rtol=0.27)


@pytest.mark.slow
def test_draws_of_a_calibrated_muscle(muscle, designs, reachable):
    draws = eqx.tree_at(
        lambda m: m.outer_radius, muscle, muscle.outer_radius * jnp.array([0.9, 1.1])
    )
    draws = eqx.tree_at(lambda m: m.wall_thickness, draws, muscle.wall_thickness * jnp.ones(2))
    result = spread(designs, reachable, ("largest_force",), muscles=draws, draws=64, seed=1)
    # two kinds of draws, two values
    assert len(np.unique(np.round(result.values["largest_force"][0], 6))) == 2

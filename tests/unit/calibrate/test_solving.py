from dataclasses import dataclass, fields

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle.calibrate import least_squares
from fascicle.calibrate.data import Grid
from fascicle.calibrate.least_squares import (
    BROKE,
    CONVERGED,
    STOPPED,
    Problem,
    SearchEnds,
    _remaining,
    solve,
    starts_around,
)
from fascicle.calibrate.messages import end_messages


@dataclass(frozen=True, eq=False)
class Given(Problem):
    """Rosenbrock's valley, no numbers beyond a wall, and the ways to be caught by either: forces
    that are to be zero, two of them, of two coordinates without priors to speak of.
    """

    wall: float = 1e9
    winding: bool = False

    def force(self, point):
        """Of the valley, or of a valley too winding to walk."""
        x, y = point
        r = np.stack([10 * (y - x**2), 1 - x])
        if self.winding:
            r = np.stack([1e6 * (y - np.sin(20 * x)), 10 - x])
        r = np.where(x < self.wall, r, np.nan)
        return np.moveaxis(r, 0, -1)[..., None, :] if point.ndim > 1 else r[None]


@pytest.fixture
def given(straight):
    old = straight().problem
    values = {field.name: getattr(old, field.name) for field in fields(Problem)}
    zero, one = np.zeros((1, 2)), np.ones((1, 2))
    values["grid"] = Grid(np.zeros((1, 1)), zero, zero, one, zero > 1)
    values |= {"weight": one, "noise": 1.0, "deviation": np.full(2, 1e9)}

    def make(**more):
        return Given(**values, **more)

    return make


def ends(cost, status, steps=3):
    n = len(cost)
    return SearchEnds(
        np.arange(2.0 * n).reshape(n, 2),
        np.asarray(cost, dtype=float),
        np.asarray(status),
        np.full(n, steps),
    )


def test_it_finds_a_minimum_along_a_valley(given):
    found = solve(given(), np.array([[-1.2, 1.0], [0.5, 2.0]]))
    assert_array_equal(found.status, CONVERGED)
    assert_allclose(found.points, 1.0, atol=1e-6)
    assert_allclose(found.cost, 0.0, atol=1e-12)
    assert all("converged" in line and "best minimum" in line for line in end_messages(found))


def test_a_start_without_numbers_is_said_to_have_broken(given):
    found = solve(given(wall=2.0), np.array([[3.0, 1.0], [0.5, 0.5]]))
    assert_array_equal(found.status, [BROKE, CONVERGED])
    assert int(found.best) == 1
    first, second = end_messages(found)
    assert first.startswith("start 1: stopped because")
    assert "minimum" not in first
    assert second.startswith("start 2: converged")


def test_a_search_that_does_not_end_is_said_to_have_stopped(given):
    found = solve(given(winding=True), np.array([[0.0, 0.0]]))
    assert found.cost[0] > 1
    assert_array_equal(found.status, [STOPPED])
    assert end_messages(found)[0].startswith("start 1: stopped after 200 steps")


def test_a_search_out_of_steps_with_nothing_left_remaining_has_settled(given, monkeypatch):
    monkeypatch.setattr(least_squares, "_MAX_STEPS", 2)
    near, far = solve(given(), np.array([[1.0, 1.0], [-1.2, 1.0]]) + 1e-5).status
    assert (near, far) == (CONVERGED, STOPPED)


def test_what_is_left_remaining_is_a_whole_gauss_newton_step():
    rng = np.random.default_rng(0)
    J, r = rng.normal(size=(20, 3)), rng.normal(size=20)
    away = r - J @ np.linalg.lstsq(J, r)[0]
    assert_allclose(_remaining(r, J), 0.5 * (r @ r - away @ away), rtol=1e-12)
    assert_allclose(_remaining(away, J), 0.0, atol=1e-12)
    # a direction that nothing changes wins nothing
    assert_allclose(_remaining(r, np.c_[J, np.zeros(20)]), _remaining(r, J), rtol=1e-12)


def test_only_what_moves_is_moved(given):
    found = solve(given(), np.array([[0.5, 2.0]]), np.array([1]))
    assert_allclose(found.points, [[0.5, 0.25]], atol=1e-6)
    none = solve(given(), np.array([[0.5, 2.0]]), np.zeros(0, int))
    assert_array_equal(none.points, [[0.5, 2.0]])
    assert_allclose(none.cost, 0.5 * (17.5**2 + 0.5**2), rtol=1e-9)


def test_least_squares_of_a_straight_law_are_the_normal_equations(straight):
    made = straight(prior=0.5)
    problem = made.problem
    X = np.asarray(problem.design).reshape(-1, 2) / 0.3
    y = np.asarray(problem.grid.force).reshape(-1) / 0.3
    A = X.T @ X + np.eye(2) / 0.5**2
    # the solver ends when a step moves nothing by more than 1e-8
    assert_allclose(made.coordinates, np.linalg.solve(A, X.T @ y), rtol=1e-7)
    r = np.concatenate([y - X @ made.coordinates, made.coordinates / 0.5])
    assert_allclose(made.solutions.cost, [0.5 * r @ r], rtol=1e-12)


def test_words_tell_minima_apart():
    lines = end_messages(ends([5.0, 5.01, 5.05, np.nan], [CONVERGED, STOPPED, CONVERGED, BROKE]))
    assert lines[0] == "start 1: converged (3 steps), at the best minimum"
    assert lines[1].endswith("before convergence (3 steps), at the best minimum")
    assert lines[2] == "start 3: converged (3 steps), at a worse minimum (cost 5.05)"
    assert lines[3] == "start 4: stopped because the solver could not continue (3 steps)"


def test_no_number_is_never_the_best():
    found = ends([np.nan, 3.0, 2.0, np.inf], [BROKE, CONVERGED, CONVERGED, BROKE])
    assert int(found.best) == 2


def test_starts_are_within_a_factor_of_two_and_seeded():
    center = np.array([1.0, -2.0, 0.0])
    places = starts_around(center, 500, seed=3)
    assert_array_equal(places[0], center)
    away = np.abs(places - center)
    assert away.max() <= np.log(2)
    assert np.all(away.max(axis=0) > 0.9 * np.log(2))
    assert_array_equal(places, starts_around(center, 500, seed=3))
    assert not np.array_equal(places, starts_around(center, 500, seed=4))
    assert_array_equal(starts_around(center, 1), center[None])


def test_second_starts_follow_the_covariance_and_no_further_than_they_may():
    C = np.array([[0.04, 0.018], [0.018, 0.01]])
    places = starts_around(np.array([1.0, 2.0]), 20001, 1, C)
    assert_array_equal(places[0], [1.0, 2.0])
    # 20 000 draws know a variance to 1 %; five of these
    assert_allclose(np.cov(places[1:].T), 4 * C, rtol=0.05)
    # where nothing is known: twice a deviation of 1
    wide = starts_around(np.zeros(2), 20001, 1, np.diag([1e6, 1e-4]))
    assert_allclose(wide[1:].std(axis=0), [2.0, 0.02], rtol=0.025)
    assert np.all(np.isfinite(starts_around(np.zeros(2), 5, 0, np.full((2, 2), np.nan))))

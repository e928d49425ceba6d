from dataclasses import dataclass, fields

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle.calibrate.data import Grid
from fascicle.calibrate.least_squares import BROKE, CONVERGED, STOPPED, Problem, solve


@dataclass(frozen=True, eq=False)
class Given(Problem):
    """Rosenbrock's valley, no numbers beyond a wall, and the ways to be caught by either: forces
    that are to be zero, two of them, of two coordinates without priors to speak of.
    """

    wall: float = 1e9
    winding: bool = False

    def reading_forces(self, point):
        """Of the valley, or of a valley too winding to walk."""
        x, y = point
        r = np.stack([10 * (y - x**2), 1 - x])
        if self.winding:
            r = np.stack([1e6 * (y - np.sin(20 * x)), 10 - x])
        r = np.where(x < self.wall, r, np.nan)
        return r.T


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


def test_it_finds_a_minimum_along_a_valley(given):
    found = solve(given(), np.array([[-1.2, 1.0], [0.5, 2.0]]))
    assert_array_equal(found.status, CONVERGED)
    assert_allclose(found.points, 1.0, atol=1e-6)
    assert_allclose(found.cost, 0.0, atol=1e-12)


def test_a_start_without_numbers_is_said_to_have_broken(given):
    found = solve(given(wall=2.0), np.array([[3.0, 1.0], [0.5, 0.5]]))
    assert_array_equal(found.status, [BROKE, CONVERGED])
    assert int(found.best) == 1


def test_a_search_that_does_not_end_is_said_to_have_stopped(given):
    found = solve(given(winding=True), np.array([[0.0, 0.0]]))
    assert found.cost[0] > 1
    assert_array_equal(found.status, [STOPPED])


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

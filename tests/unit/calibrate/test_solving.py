import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle.calibrate.data.grid import Grid
from fascicle.calibrate.problem import solving
from fascicle.calibrate.problem.residuals import Problem
from fascicle.calibrate.problem.solving import (
    BROKE,
    CONVERGED,
    STEPS,
    STOPPED,
    Solutions,
    _to_win,
    around,
    in_words,
    joined,
    least,
    scattered,
    solve,
)


class Given(Problem):
    """Rosenbrock's valley, no numbers beyond a wall, and the ways to be caught by either: forces
    that are to be zero, two of them, of two coordinates without priors to speak of.
    """

    wall: float = 1e9
    winding: bool = eqx.field(static=True, default=False)

    def force(self, coordinates):
        """Of the valley, or of a valley too winding to walk."""
        x, y = coordinates
        r = jnp.stack([10 * (y - x**2), 1 - x])
        if self.winding:
            r = jnp.stack([1e6 * (y - jnp.sin(20 * x)), 10 - x])
        return jnp.where(x < self.wall, r, jnp.nan)[None]


@pytest.fixture
def given(straight):
    old = straight().problem
    fields = {name: getattr(old, name) for name in Problem.__dataclass_fields__}
    zero, one = jnp.zeros((1, 2)), jnp.ones((1, 2))
    fields["data"] = Grid(jnp.zeros((1, 1)), zero, zero, one, zero > 1)
    fields |= {"weight": one, "noise": jnp.asarray(1.0), "deviation": jnp.full(2, 1e9)}

    def make(**more):
        return Given(**fields, **more)

    return make


def ends(cost, status, steps=3):
    n = len(cost)
    return Solutions(
        np.arange(2.0 * n).reshape(n, 2),
        np.asarray(cost, dtype=float),
        np.asarray(status),
        np.full(n, steps),
    )


def test_it_finds_a_minimum_along_a_valley(given):
    found = solve(given(), np.array([[-1.2, 1.0], [0.5, 2.0]]))
    assert_array_equal(found.status, CONVERGED)
    assert_allclose(found.coordinates, 1.0, atol=1e-6)
    assert_allclose(found.cost, 0.0, atol=1e-12)
    assert all("converged" in line and "best minimum" in line for line in in_words(found))


def test_a_start_without_numbers_is_said_to_have_broken(given):
    found = solve(given(wall=2.0), np.array([[3.0, 1.0], [0.5, 0.5]]))
    assert_array_equal(found.status, [BROKE, CONVERGED])
    assert int(found.best) == 1
    first, second = in_words(found)
    assert first.startswith("start 1: stopped where the solver could not go on")
    assert "minimum" not in first
    assert second.startswith("start 2: converged")
    assert np.isfinite(least(found))


def test_a_search_that_does_not_end_is_said_to_have_stopped(given):
    found = solve(given(winding=True), np.array([[0.0, 0.0]]))
    assert found.cost[0] > 1
    assert_array_equal(found.status, [STOPPED])
    assert in_words(found)[0].startswith(f"start 1: stopped after {STEPS} steps, before it settled")


def test_a_search_out_of_steps_with_nothing_left_to_win_has_settled(given, monkeypatch):
    monkeypatch.setattr(solving, "STEPS", 2)
    near, far = solve(given(), np.array([[1.0, 1.0], [-1.2, 1.0]]) + 1e-5).status
    assert (near, far) == (CONVERGED, STOPPED)


def test_what_is_left_to_win_is_a_whole_gauss_newton_step():
    rng = np.random.default_rng(0)
    J, r = rng.normal(size=(20, 3)), rng.normal(size=20)
    away = r - J @ np.linalg.lstsq(J, r)[0]
    assert_allclose(_to_win(r, J), 0.5 * (r @ r - away @ away), rtol=1e-12)
    assert_allclose(_to_win(away, J), 0.0, atol=1e-12)
    # a direction that nothing changes wins nothing
    assert_allclose(_to_win(r, np.c_[J, np.zeros(20)]), _to_win(r, J), rtol=1e-12)


def test_only_what_moves_is_moved(given):
    found = solve(given(), np.array([[0.5, 2.0]]), np.array([1]))
    assert_allclose(found.coordinates, [[0.5, 0.25]], atol=1e-6)
    none = solve(given(), np.array([[0.5, 2.0]]), np.zeros(0, int))
    assert_array_equal(none.coordinates, [[0.5, 2.0]])
    assert_allclose(none.cost, 0.5 * (17.5**2 + 0.5**2), rtol=1e-9)


def test_least_squares_of_a_straight_law_are_the_normal_equations(straight):
    made = straight(prior=0.5)
    problem = made.problem
    X = np.asarray(problem.design).reshape(-1, 2) / 0.3
    y = np.asarray(problem.data.force).reshape(-1) / 0.3
    A = X.T @ X + np.eye(2) / 0.5**2
    # the solver ends when a step moves nothing by more than 1e-8
    assert_allclose(made.coordinates, np.linalg.solve(A, X.T @ y), rtol=1e-7)
    r = np.concatenate([y - X @ made.coordinates, made.coordinates / 0.5])
    assert_allclose(made.solutions.cost, [0.5 * r @ r], rtol=1e-12)


def test_words_tell_minima_apart():
    lines = in_words(ends([5.0, 5.01, 5.05, np.nan], [CONVERGED, STOPPED, CONVERGED, BROKE]))
    assert lines[0] == "start 1: converged (3 steps), at the best minimum"
    assert lines[1].endswith("before it settled (3 steps), at the best minimum")
    assert lines[2] == "start 3: converged (3 steps), at a worse one (cost 5.05)"
    assert lines[3] == "start 4: stopped where the solver could not go on (3 steps)"


def test_no_number_is_never_the_best():
    found = ends([np.nan, 3.0, 2.0, np.inf], [BROKE, CONVERGED, CONVERGED, BROKE])
    assert int(found.best) == 2
    assert least(found) == 2.0
    assert least(ends([np.nan], [BROKE])) == np.inf
    both = joined(found, ends([1.0], [CONVERGED]))
    assert both.cost.shape == (5,) and int(both.best) == 4


def test_starts_are_within_a_factor_of_two_and_seeded():
    center = np.array([1.0, -2.0, 0.0])
    places = scattered(center, 500, seed=3)
    assert_array_equal(places[0], center)
    away = np.abs(places - center)
    assert away.max() <= np.log(2)
    assert np.all(away.max(axis=0) > 0.9 * np.log(2))
    assert_array_equal(places, scattered(center, 500, seed=3))
    assert not np.array_equal(places, scattered(center, 500, seed=4))
    assert_array_equal(scattered(center, 1), center[None])


def test_second_starts_follow_the_covariance_and_no_further_than_they_may():
    C = np.array([[0.04, 0.018], [0.018, 0.01]])
    places = around(np.array([1.0, 2.0]), C, 20001, seed=1)
    assert_array_equal(places[0], [1.0, 2.0])
    # 20 000 draws know a variance to 1 %; five of these
    assert_allclose(np.cov(places[1:].T), 4 * C, rtol=0.05)
    # where nothing is known: twice a deviation of 1
    wide = around(np.zeros(2), np.diag([1e6, 1e-4]), 20001, seed=1)
    assert_allclose(wide[1:].std(axis=0), [2.0, 0.02], rtol=0.025)
    assert np.all(np.isfinite(around(np.zeros(2), np.full((2, 2), np.nan), 5)))

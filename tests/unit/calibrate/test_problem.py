import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import least_squares
from scipy.stats import norm

import fascicle as fs
from fascicle.calibrate.data import Grid
from fascicle.calibrate.least_squares import LOSSES, Problem
from fascicle.calibrate.parameters import select_parameters


muscle = fs.Muscle(0.127, 6.35e-3, 1.6e-3, np.radians(33))
SIGMA = 0.7


def problem(force, censored=False, count=1.0, loss="linear"):
    """A problem of one level with these forces."""
    F = np.atleast_2d(force)
    one = np.ones(F.shape)
    grid = Grid(np.full((1, 1), 1e5), 0.1 * one, F, count * one, np.full(F.shape, censored))
    free = select_parameters(["braid_angle"], muscle)
    return Problem(muscle, grid, one, SIGMA, np.zeros(1), np.full(1, 3.0), free, loss=loss)


# in deviations, from "as sure as can be" to far where the model pulls and nothing was seen
SCALED = np.array([-29.0, -10.0, -3.0, -1.0, 0.0, 0.5, 2.0, 6.0, 20.0, 60.0, 300.0])


@pytest.mark.parametrize("count", [1.0, 4.0])
def test_a_clipped_reading_says_not_above(count):
    mu = SCALED * SIGMA / np.sqrt(count)
    made = problem(np.zeros(mu.size), censored=True, count=count)
    r = made.misfits(np.atleast_2d(mu))[0][0]
    # half the square is the negative logarithm of the chance of a force below zero
    # jax's log_ndtr keeps ten digits between its series, scipy's 14
    assert_allclose(0.5 * r**2, -norm.logcdf(-SCALED), rtol=1e-9)
    # far on the pulling side it is as much as any other deviation
    assert_allclose(r[-1] / SCALED[-1], 1, rtol=1e-3)


def test_slopes_of_a_clipped_reading_are_finite_and_right():
    made = problem(np.zeros(SCALED.size), censored=True)
    mu = SCALED * SIGMA
    (r, slope), (above, _), (below, _) = (
        made.misfits((mu + step)[None]) for step in (0.0, 1e-6, -1e-6)
    )
    # d(r²/2)/dmu = phi/Phi /sigma, the inverse Mills ratio
    mills = np.exp(norm.logpdf(SCALED) - norm.logcdf(-SCALED)) / SIGMA
    assert_allclose((r * slope)[0], mills, rtol=1e-9)
    assert_allclose(slope, (above - below) / 2e-6, rtol=1e-6, atol=1e-9)
    # beyond, to a million deviations either way
    far = SIGMA * np.array([-1e6, -1e3, -40.0, -31.0, -30.0, 1e3, 1e4, 1e5, 1e6, 1e6, 1e6])
    r, slope = (x[0] for x in made.misfits(far[None]))
    assert np.all(np.isfinite(r)) and np.all(np.isfinite(slope))
    assert_allclose(r[:5], 0, atol=1e-90)
    assert_allclose(r[5:], far[5:] / SIGMA, rtol=1e-4)
    assert_allclose(slope[5:], 1 / SIGMA, rtol=1e-4)


R = np.concatenate([[0.0], np.geomspace(1e-12, 1e4, 65), -np.geomspace(1e-12, 1e4, 65)])


@pytest.mark.parametrize("loss", [loss for loss in LOSSES if loss != "linear"])
def test_losses_are_scipys(loss):
    made = problem(R * SIGMA, loss=loss)
    r = made.residuals(np.zeros(1), np.zeros((1, R.size)))[:-1]
    for mine, plain in zip(r, R, strict=True):
        # scipy's cost at a residual that doesn't move is rho/2
        rho = 2 * least_squares(lambda _, x=plain: [x], [0.0], loss=loss, max_nfev=1).cost
        # scipy's soft_l1 loses to cancellation what (1 + r²)^1/2 - 1 leaves of 1: eps absolute
        assert_allclose(mine**2, rho, rtol=1e-9, atol=1e-15)
    assert_array_equal(np.sign(r), np.sign(R))


@pytest.mark.parametrize("loss", LOSSES)
def test_losses_are_smooth_through_zero(loss):
    made = problem(np.zeros(6), loss=loss)

    def of(mu):
        F, ones = mu[None], np.ones((1, mu.size, 1))
        slopes = made.slopes(F, ones, np.arange(1))
        return made.residuals(np.zeros(1), F)[:-1], slopes[:-1, 0]

    mu = np.array([0.0, 1e-9, -1e-6, 1.1e-6, 0.5, -30.0]) * SIGMA
    r, slope = of(mu)
    # all losses begin as r itself: the slope differs from it by r²
    assert_allclose(slope[:4], -1 / SIGMA, rtol=1e-11)
    assert_allclose(2 * (r * slope)[:4], 2 * mu[:4] / SIGMA**2, rtol=1e-9)
    # and everywhere it is the difference's
    assert_allclose(slope, (of(mu + 1e-6)[0] - of(mu - 1e-6)[0]) / 2e-6, rtol=1e-7)

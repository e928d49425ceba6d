import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import least_squares
from scipy.stats import norm

import fascicle as fs
from fascicle.calibrate.data import Grid
from fascicle.calibrate.least_squares import LOSSES, Problem, starts_beside
from fascicle.calibrate.parameters import select_parameters


muscle = fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, np.radians(33))
SIGMA = 0.7


def problem(force, censored=False, count=1.0, weight=1.0, loss="linear", **more):
    """A problem of one level with these forces."""
    F = np.atleast_2d(np.asarray(force, dtype=float))
    full = {
        "rest_length": None,
        "parameters": select_parameters(["braid_angle"], muscle),
        "center": np.zeros(1),
        "deviation": np.full(1, 3.0),
    } | more
    return Problem(
        muscle, Grid(
            np.full((F.shape[0], 1), 1e5), np.full(F.shape, 0.1), F,
            np.full(F.shape, count), np.full(F.shape, censored),
        ),
        np.full(F.shape, weight), SIGMA, full["center"], full["deviation"],
        full["parameters"], full["rest_length"], loss=loss,
    )  # fmt: skip


def test_a_measured_force_misses_by_its_deviations():
    F, mu = np.array([3.0, -1.0, 0.0]), np.array([2.0, 1.0, 0.0])
    r = problem(F).misfits(np.atleast_2d(mu))[0]
    assert_allclose(r[0], (F - mu) / SIGMA, rtol=1e-15)
    # the mean of n readings scatters by sigma/sqrt(n); a weight stands before it all
    r = problem(F, count=9.0, weight=0.5).misfits(np.atleast_2d(mu))[0]
    assert_allclose(r[0], 0.5 * 3 * (F - mu) / SIGMA, rtol=1e-15)


def test_a_place_that_is_filled_up_says_nothing():
    mu = np.array([[5.0, -8.0]])
    assert_array_equal(problem([1.0, 2.0], count=0.0).misfits(mu)[0], 0)


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


def test_the_prior_closes_the_residuals_and_no_loss_touches_it():
    made = problem([0.0], loss="cauchy", center=np.asarray([1.0]), deviation=np.asarray([0.01]))
    r = made.residuals(np.array([1.2]), np.zeros((1, 1)))
    assert_allclose(r, [0.0, 20.0], rtol=1e-13, atol=1e-15)


def test_strains_refer_to_the_length_they_were_measured_on():
    free = select_parameters(["active_length"], muscle)
    made = problem([0.0], parameters=free, rest_length=np.asarray(0.15))
    half = made.muscle_at(np.log(np.asarray([0.075])))
    assert_allclose(made.strain(half), 0.2, rtol=1e-14)
    assert_allclose(problem([0.0], parameters=free).strain(half), 0.1, rtol=0)


def test_starts_lie_beside_a_point_along_what_the_data_do_not_determine():
    free = select_parameters(["hinge_stiffness_slope", "transition_rate", "c10"], muscle)
    made, point = problem([0.0], parameters=free), np.array([0.5, 1.0, 2.0])
    # a unit of the slope's coordinate is ten of the others', which are logarithms
    starts = starts_beside(made, point, np.diag([101.0, 0.9, 4.0]))
    steps = [[10, 0, 0], [0, 0, 1], [-10, 0, 0], [0, 0, -1]]
    assert_array_equal(starts, point + steps)
    assert len(starts_beside(made, point, np.diag([99.0, 0.9, 0.9]))) == 0

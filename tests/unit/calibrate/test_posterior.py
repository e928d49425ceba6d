import sys
from dataclasses import replace

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate.least_squares import linearize
from fascicle.calibrate.posterior import _Target, sample
from fascicle.core.errors import MissingExtraError


pytest.importorskip("numpyro")


@pytest.fixture(scope="module")
def made(straight):
    return straight(levels=5, readings=40)


@pytest.fixture(scope="module")
def drawn(made):
    return sample(made, draws=400, warmup=200, chains=2, seed=0)


def test_chains_agree(drawn):
    assert drawn.values.shape == drawn.coordinates.shape == (800, 2)
    assert drawn.divergences == 0
    assert drawn.agrees
    assert np.all(np.abs(drawn.r_hat - 1) < 0.01)


def test_it_is_the_normal_approximation_where_that_is_exact(made, drawn):
    # a straight law with 200 readings: normal but for the noise's uncertainty, 5 %, whose
    # square widens the variance by 1 in 100
    ess = drawn.ess.min()
    sigma = float(np.sqrt(np.mean(made.residual**2) / made.problem.noise**2))
    covariance = made.covariance * sigma**2
    deviation = np.sqrt(np.diag(covariance))
    error = (drawn.coordinates.mean(axis=0) - made.coordinates) / deviation
    # a mean of so many draws is off by 1/sqrt(ess) deviations; four of these
    assert np.all(np.abs(error) < 4 / np.sqrt(ess))
    # a standard deviation by 1/sqrt(2 ess)
    assert_allclose(drawn.coordinates.std(axis=0), deviation, rtol=4 / np.sqrt(2 * ess) + 0.01)
    found = np.corrcoef(drawn.coordinates.T)[0, 1]
    assert abs(found - made.correlation[0, 1]) < 4 / np.sqrt(ess)


def test_the_noise_is_drawn_too(made, drawn):
    usual = np.sqrt(np.mean(made.residual**2))
    n = 200
    # known to 1/sqrt(2n), five percent; its mean lies off the usual by a fraction of that
    assert_allclose(drawn.noise.std() / usual, 1 / np.sqrt(2 * n), rtol=0.15)
    assert_allclose(np.median(drawn.noise), usual, rtol=0.02)


def test_values_and_intervals_are_those_of_the_coordinates(drawn):
    assert drawn.names == ("youngs_modulus_factor", "collapse_moment_factor")
    assert_allclose(drawn.values, np.exp(drawn.coordinates), rtol=1e-12)
    low, high = np.quantile(drawn.values, [0.25, 0.75], axis=0)
    assert_allclose(drawn.interval(0.5), np.stack([low, high], axis=1), rtol=1e-12)
    assert np.all((drawn.values > drawn.interval()[:, 0]).mean(axis=0) > 0.94)


def test_the_density_is_what_least_squares_minimize(straight):
    # weights other than 1 and clipped readings among them
    censored, weight = np.zeros((3, 6), bool), np.ones((3, 6))
    censored[:, ::2], weight[1], weight[2, :2] = True, 2.0, 0.0
    made = straight(levels=3, readings=6, censored=censored, weight=weight, prior=0.7)
    target = _Target(made)

    def squares(u):
        z, _, _ = target.unpack(u)
        return -0.5 * float(np.sum(linearize(target.problem, np.asarray(z)).residuals ** 2))

    density = jax.jit(target.log_density)
    here, there = np.zeros(3), np.array([0.8, -1.3, 0.0])
    # at one noise they differ by a constant, up to the sums' rounding
    rise = float(density(there)) - float(density(here))
    assert_allclose(rise, squares(there) - squares(here), rtol=1e-11)


def test_a_robust_loss_has_no_posterior(made):
    robust = replace(made, problem=replace(made.problem, loss="soft_l1"))
    with pytest.raises(fs.InvalidInputError) as error:
        sample(robust)
    assert error.value.argument == "loss"


def test_without_numpyro_it_says_what_to_install(made, monkeypatch):
    monkeypatch.setitem(sys.modules, "numpyro", None)
    with pytest.raises(MissingExtraError) as error:
        sample(made)
    assert error.value.name == "numpyro"

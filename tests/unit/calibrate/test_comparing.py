from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import norm

import fascicle as fs
from fascicle.calibrate import Prior, compare, compare_tension, fit
from fascicle.calibrate.comparison import comparison_row
from fascicle.calibrate.model_selection import left_out_force
from fascicle.muscle.collapse import Kim2021Collapse
from fascicle.records.record import Record


@pytest.fixture(scope="module")
def made(straight):
    censored = np.zeros((4, 10), bool)
    censored[1, :3] = True
    return straight(censored=censored, sigma=0.3)


@pytest.fixture(scope="module")
def errors(made):
    return np.where(made.grid.measured, made.grid.force - left_out_force(made), np.nan)


def test_left_out_errors_are_those_of_refits_by_hand(straight):
    made = straight(prior=1.0)
    X, F = np.asarray(made.problem.design), np.asarray(made.grid.force)
    errors = np.where(made.grid.measured, made.grid.force - left_out_force(made), np.nan)
    for level in range(4):
        seen = np.arange(4) != level
        A, y = X[seen].reshape(-1, 2) / 0.3, F[seen].reshape(-1) / 0.3
        z = np.linalg.solve(A.T @ A + np.eye(2), A.T @ y)
        # the search ends when nothing moves by more than 1e-8
        assert_allclose(errors[level], F[level] - X[level] @ z, atol=1e-6)
    # what was fitted was seen, and is nearer
    assert np.sqrt(np.mean(errors**2)) > made.rmse


def test_clipped_readings_have_no_error(made, errors):
    assert_array_equal(np.isnan(errors), np.asarray(made.grid.censored))


def likelihood_by_hand(measured, law, at_clipped):
    """-2 ln L at the best of many noises, from the distributions themselves: an independent way."""

    def cost(noise):
        seen = norm.logpdf(measured, law, noise).sum() + norm.logcdf(0.0, at_clipped, noise).sum()
        return -2 * seen - measured.size * np.log(2 * np.pi)

    noises = np.geomspace(1e-3, 1e3, 200)
    near = noises[np.argmin([cost(noise) for noise in noises])]
    for width in (0.1, 1e-3, 1e-5):
        noises = near * (1 + width * np.linspace(-1, 1, 401))
        near = noises[np.argmin([cost(noise) for noise in noises])]
    return cost(near)


def test_criteria_by_hand(made, errors):
    found = comparison_row("a law", made)
    F, mu = np.asarray(made.grid.force), np.asarray(made.force)
    measured = ~np.asarray(made.grid.censored)
    n, k = 37, 2
    assert n == measured.sum()
    cost = likelihood_by_hand(F[measured], mu[measured], mu[~measured]) - n
    # the noise is found to 1e-10, and the cost is flat there
    assert_allclose(found.aic, cost + 2 * k, rtol=1e-9)
    assert_allclose(found.bic, cost + k * np.log(n + 3), rtol=1e-9)
    spread = n * np.log(np.mean((F - mu)[measured] ** 2))
    assert_allclose(found.rmse, np.exp(spread / n / 2), rtol=1e-12)
    assert_allclose(found.clipped_pull, max(mu[~measured].max(), 0.0), rtol=1e-12)
    assert_allclose(found.left_out_rmse, np.sqrt(np.nanmean(errors**2)), rtol=1e-12)
    top = F[measured].max()
    assert_allclose(found.relative_rmse * top, found.rmse, rtol=1e-12)
    assert_allclose(found.relative_left_out_rmse * top, found.left_out_rmse, rtol=1e-12)
    assert (found.label, found.free) == ("a law", 2)
    assert found.status.startswith("converged")


def test_an_average_counts_as_what_it_averages(made):
    data = made.grid
    count = np.asarray(data.count).copy()
    count[0, 0] = 9.0
    heavy = replace(made.problem, grid=replace(data, count=count))
    found = comparison_row("", replace(made, problem=heavy))
    r = (np.asarray(data.force) - made.force)[~np.asarray(data.censored)]
    assert_allclose(found.rmse, np.sqrt((np.sum(r**2) + 8 * r[0] ** 2) / 45), rtol=1e-12)


def test_published_laws_are_compared_as_published(spoiled):
    rows = {row.label: row for row in compare_tension(spoiled, nominal(), NAMES, whole=False).rows}
    (published,) = (rows[label] for label in rows if "DMSP-20-200N" in label)
    law = nominal().replace(tension="sarosi")
    errors = spoiled.force - np.asarray(law.force(spoiled.pressure, spoiled.strain))
    assert published.free == 0 and published.left_out_rmse == published.rmse
    assert_allclose(published.rmse, np.sqrt(np.mean(errors**2)), rtol=1e-6)


HOW = {"loss": "soft_l1", "starts": 2, "seed": 3}
NAMES = ["braid_angle", "outer_radius"]
PRIORS = {"outer_radius": Prior(10.6e-3, 0.02e-3)}


def nominal(tension="klute_hannaford"):
    return fs.Muscle(0.2, 10e-3, 2e-3, np.radians(29), "latex", tension=tension)


@pytest.fixture(scope="module")
def spoiled():
    """Readings that a robust loss plays down, and of which one level has fewer."""
    true = fs.Muscle(0.2, 11e-3, 2e-3, np.radians(27), "latex")
    P, strain = np.linspace(1.5e5, 6e5, 5)[:, None], np.linspace(0.0, 0.1, 8)
    force = np.asarray(true.force(P, strain))
    force = force + 2.0 * np.random.default_rng(0).normal(size=force.shape)
    force[2, ::3] += 60.0
    there = np.ones(force.size, bool)
    there[9:15] = False
    return Record.of(P, strain, force, rest_length=0.2).only(there)


def test_a_comparison_fits_as_separate_fits_do(spoiled):
    how = {**HOW, "whole": False}
    compared = compare_tension(spoiled, nominal(), NAMES, PRIORS, **how)
    rmse = {row.label: row.rmse for row in compared.rows}
    alone = missed(fit(spoiled, nominal(), NAMES, PRIORS, **how))
    assert_allclose(rmse["Klute-Hannaford: braid_angle, outer_radius"], alone, rtol=1e-6)
    other = missed(fit(spoiled, nominal("ideal"), NAMES, PRIORS, **how))
    assert_allclose(rmse["ideal: braid_angle, outer_radius"], other, rtol=1e-6)
    # what would be lost is seen in the error
    without = missed(fit(spoiled, nominal(), NAMES, PRIORS, **{**how, "loss": "linear"}))
    assert abs(without / alone - 1) > 1e-4  # a hundred times what is told apart
    assert abs(missed(fit(spoiled, nominal(), NAMES, **how)) / alone - 1) > 1e-3


@pytest.mark.slow
def test_a_law_of_collapse_is_compared_with_its_factor():
    muscle = fs.Muscle(
        0.127, 6.35e-3, 1.6e-3, np.radians(33), "silicone_kim2021", collapse=Kim2021Collapse(0.4)
    )
    P = np.linspace(1e5, 3e5, 4)[:, None]
    strain = np.linspace(0.0, 0.34, 14)
    force = np.asarray(muscle.force(P, strain))
    force = force + 0.2 * np.random.default_rng(0).normal(size=force.shape)
    record = Record.of(P, strain, force, rest_length=0.127)
    names = ["youngs_modulus_factor"]
    found = compare(record, muscle, names, None, **HOW)
    rows = {one.label: one.rmse for one in found.rows}
    alone = missed(fit(record, muscle, names, **HOW))
    assert_allclose(rows["kim2021, kim2021, derived"], alone, rtol=1e-6)
    # the factor is that law's own, and matters
    assert np.any(np.abs(muscle.replace(collapse="kim2021").force(P, strain) - force) > 10 * alone)
    other = missed(fit(record, muscle.replace(collapse="wood1958"), names, **HOW))
    assert_allclose(rows["kim2021, wood1958, derived"], other, rtol=1e-6)


def missed(made):
    return float(np.sqrt(np.nanmean(made.residual**2)))

"""Tests of residuals: that noise is let pass, and that nothing else is."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import binom, f

from fascicle.calibrate.diagnostics import ALPHA, Residuals, find_trends


K = 4
PRESSURES = np.linspace(50e3, 700e3, 21)
TABLE = np.array([0.013, 0.06, 0.11, 0.167, 0.21, 0.26])


def layout(name):
    """Pressure, strain, branch and time of a record's readings."""
    if name == "table":  # of which the lower pressures pull at small strains only
        P, strain = np.broadcast_arrays(PRESSURES[:, None], TABLE)
        pulls = strain < 0.26 * (P / 700e3) ** 0.5
        P, strain = P[pulls], strain[pulls]
        return P, strain, np.zeros(P.size), np.full(P.size, np.nan)
    levels, n = (12, 40) if name == "sweeps" else (5, 30)
    strain = np.concatenate([np.linspace(0, 0.2, n), np.linspace(0.2, 0, n)])
    P = np.repeat(PRESSURES[:levels], 2 * n)
    strain, branch = np.tile(strain, levels), np.tile(np.repeat([1.0, -1.0], n), levels)
    return P, strain, branch, np.arange(P.size, dtype=float)


def slopes_of(P, strain):
    """A Jacobian like that of a muscle's constants."""
    p = P / 7e5
    return 100 * np.stack([p * (1 - strain) ** 2, p, strain, strain**2], axis=-1)


def remainder(name, errors, priors=1e-5, weight=1.0):
    """What a least-squares fit leaves of `errors`, its constants held by `priors`."""
    P, strain, branch, time = layout(name)
    J = weight * slopes_of(P, strain)
    held = priors * np.eye(K)
    A, y = np.vstack([J, held]), np.concatenate([weight * errors, np.zeros(K)])
    z = np.linalg.lstsq(A, y)[0]
    none = np.zeros(K)

    def rows(values):
        return np.concatenate([values, none])

    level = np.unique(P, return_inverse=True)[1]
    return Residuals(
        y - A @ z, -A, rows(np.broadcast_to(weight, P.shape)), rows(strain), rows(P), rows(branch),
        rows(time), rows(100 * P / 7e5), rows(level),
    )  # fmt: skip


def size(name):
    return layout(name)[0].size


@pytest.mark.parametrize("name", ["table", "sweeps", "loops"])
def test_noise_is_called_a_trend_as_rarely_as_is_said(name):
    rng, count = np.random.default_rng(1), 100
    seen = [find_trends(remainder(name, rng.normal(size=size(name)))) for _ in range(count)]
    alarms = sum(not one.is_white_noise for one in seen)
    # no more than the binomial's 99.9 % quantile; and the test is no formality
    assert alarms <= binom.ppf(0.999, count, ALPHA)
    # the noise about fit and trends is the noise: 3 % of 600 times 40 degrees of freedom or more
    known = 0.03 * np.sqrt(600 / count)
    assert_allclose(np.mean([one.noise**2 for one in seen]), 1.0, rtol=known)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["table", "sweeps", "loops"])
@pytest.mark.parametrize("kind", ["normal", "laplace", "growing", "rounded"])
def test_noise_of_other_kinds_is_let_pass_too(name, kind):
    rng, count = np.random.default_rng(2), 5000
    P, _, _, _ = layout(name)
    alarms = 0
    for _ in range(count):
        e = rng.laplace(size=P.size) if kind == "laplace" else rng.normal(size=P.size)
        if kind == "growing":  # a load cell whose noise goes with pressure, threefold
            e = e * (0.5 + P / 7e5)
        if kind == "rounded":  # by a step as large as the noise
            e = np.round(e)
        alarms += not find_trends(remainder(name, e)).is_white_noise
    # normal noise is what the tests assume; others may double the rate, no more
    least = 0.25 * ALPHA * count if kind == "normal" else 0
    most = binom.ppf(0.999, count, ALPHA * (1 if kind == "normal" else 2))
    assert least <= alarms <= most, alarms / count


def shapes(P, strain, branch, _):
    return {
        "strain": np.sin(2 * np.pi * strain / 0.13),
        "pressure": np.sin(2 * np.pi * P / 4e5),
        "branch": branch * (0.5 + P / 7e5),
    }


@pytest.mark.parametrize("along", ["strain", "pressure", "branch"])
def test_what_isnt_noise_shows(along):
    rng, name = np.random.default_rng(3), "sweeps"
    shape = shapes(*layout(name))[along]
    for _ in range(20):
        seen = find_trends(remainder(name, shape + rng.normal(size=shape.size)))
        assert seen.significant[0].along == along
        # half of the squares are the trend's, save what the constants took up
        assert 0.05 < seen.significant[0].share < 0.6
        assert seen.significant[0].chance < 1e-6
        assert_allclose(seen.noise, 1.0, rtol=0.15)


def test_a_trend_of_both_shows_where_neither_alone_has_one():
    P, strain, _, _ = layout("sweeps")
    twist = 2 * np.sign(strain - 0.1) * np.sign(P - np.median(P))
    noise = np.random.default_rng(4).normal(size=P.size)
    seen = find_trends(remainder("sweeps", twist + noise))
    assert "strain and pressure" in [one.along for one in seen.significant]


def test_the_chance_is_fishers():
    name = "table"
    left = remainder(name, np.random.default_rng(5).normal(size=size(name)))
    seen = find_trends(left)
    n = size(name)
    names = [one.along for one in seen.trends]
    assert sorted(names) == ["pressure", "strain", "strain and pressure"]
    # priors are as good as none here: plain least squares on the readings
    J, y = left.slopes[:n], left.residual[:n]
    every = np.hstack([J, *(one.columns[:n] for one in seen.trends)])
    free = n - np.linalg.matrix_rank(every)
    noise = np.sum((y - every @ np.linalg.lstsq(every, y)[0]) ** 2) / free
    assert_allclose(seen.noise, np.sqrt(noise), rtol=1e-6)
    for one in seen.trends:
        assert not one.found
        both = np.hstack([J, one.columns[:n]])
        squares = np.sum(y**2) - np.sum((y - both @ np.linalg.lstsq(both, y)[0]) ** 2)
        orders = np.linalg.matrix_rank(both) - K
        chance = f.sf(squares / orders / noise, orders, free)
        assert_allclose(one.chance, chance, rtol=1e-6)
        assert_allclose(one.share, squares / np.sum(y**2), rtol=1e-6)


def test_what_a_prior_holds_has_taken_nothing_up():
    # the second constant could follow the trend, but is held where it is
    P, strain, _, _ = layout("table")
    trend = slopes_of(P, strain)[:, 3]
    noise = 0.1 * np.random.default_rng(6).normal(size=P.size)
    held = find_trends(remainder("table", trend + noise, priors=1e4))
    free = find_trends(remainder("table", trend + noise))
    assert held.significant and held.significant[0].along == "strain"
    assert free.is_white_noise


def test_runs_are_counted_along_strain_and_along_pressure():
    P, strain, _, _ = layout("table")
    # all negative at the second strain, positive at the others: as such a record was seen
    errors = np.where(np.isclose(strain, 0.06), -1.0, 0.5)
    left = remainder("table", errors, priors=1e6)
    seen = find_trends(left)
    runs = {one.along: one for one in seen.runs}
    assert runs["pressure"].changes == 0 and runs["pressure"].found
    count = sum(max(np.sum(np.isclose(strain, x)) - 1, 0) for x in TABLE)
    assert runs["pressure"].pairs == count
    assert_allclose(runs["pressure"].chance, 0.5**count, rtol=1e-9)
    # along strain each changes where it comes to the second strain and where it leaves it
    changes = sum(
        np.sum(np.diff(np.sign(errors[there][np.argsort(strain[there])])) != 0)
        for there in (p == P for p in np.unique(P))
    )
    assert runs["strain"].changes == changes and not runs["strain"].found


def test_too_few_readings_tell_nothing():
    left = remainder("table", np.random.default_rng(7).normal(size=size("table")))
    few = np.concatenate([np.arange(9), np.arange(size("table"), size("table") + K)])
    names = Residuals.__dataclass_fields__
    seen = find_trends(Residuals(*(getattr(left, name)[few] for name in names)))
    assert np.isnan(seen.noise) and not seen.trends


def test_an_average_weighs_what_it_averages():
    noise = np.random.default_rng(8).normal(size=size("sweeps"))
    one, nine = (find_trends(remainder("sweeps", noise, weight=w)) for w in (1.0, 3.0))
    # nine readings each: their mean scatters by as much, so a reading by three times that
    assert_allclose(nine.noise, 3 * one.noise, rtol=1e-6)
    for a, b in zip(one.trends, nine.trends, strict=True):
        assert_allclose(a.chance, b.chance, rtol=1e-4)

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import binom

import fascicle as fs
from fascicle.calibrate.data import Grid
from fascicle.calibrate.readings import SmoothCurves, read_curves


SIZES = (0.127, 6.35e-3, 1.6e-3, np.radians(33))
muscle = fs.Muscle(*SIZES)
P = np.array([0.0, 50e3, 100e3, 150e3, 200e3, 250e3, 300e3, 350e3])
STRAIN = np.linspace(0.0, 0.25, 26)
SEEDS, SIGMA = [50, pytest.param(200, marks=pytest.mark.slow)], 0.5

bladder, law = muscle.bladder, muscle.tension
UNTUNED_FREE = np.asarray(muscle.free_strain(P))


def untuned(pressure, strain):
    """The untuned law's force [N]; goes on past the free strain."""
    mesh, held = law.components(bladder, np.asarray(pressure), np.asarray(strain))
    return np.asarray(mesh + held)


def measured(quotient, stronger, strain=STRAIN):
    """Forces of a muscle whose free strain is `quotient` times the law's, and whose blocked
    force `stronger` times; free strains and blocked forces.
    """
    free = UNTUNED_FREE * quotient
    T, T0 = untuned(P[:, None], strain), untuned(P, np.zeros(P.size))
    C1 = np.where(P > 0, untuned(P, free), 0.0)
    blocked = stronger * T0
    C2 = np.where(P > 0, blocked / np.where(P > 0, T0 - C1, 1.0), 1.0)
    return C2[:, None] * (T - C1[:, None]), free, blocked


def gridded(force, censored=False, strain=STRAIN, count=1.0):
    strain, censored, count = (np.broadcast_to(x, force.shape) for x in (strain, censored, count))
    return Grid(P[:, None], strain, force, count, censored)


def read_many(data, forces):
    """Readings of many forces, each of their fields stacked; and the smooth free strains."""
    found = [read_curves(muscle, replace(data, force=np.asarray(force))) for force in forces]
    stacked = SimpleNamespace(**{
        field.name: np.stack([getattr(one, field.name) for one in found])
        for field in fields(found[0])
    })  # fmt: skip
    curves = SmoothCurves(muscle, P, P.max())
    return stacked, np.stack([curves.free_strain(one.coefficients) for one in found])


@pytest.fixture(scope="module", params=SEEDS)
def noisy(request):
    """Readings of as many synthetic records, untuned law and noise; truths."""
    force, free, blocked = measured(1.0, 1.0)
    noise = np.random.default_rng(0).normal(scale=SIGMA, size=(request.param, *force.shape))
    found, smooth = read_many(gridded(force), force + noise)
    return found, smooth, free, blocked


def check_deviations(z, more=0.1):
    """n seeds: a mean scatters by 1/√n, a deviation by 1/√2n; four of these, over seven levels,
    and 0.1 for where a reading ends to pull, which the noise itself decides.
    """
    assert np.all(np.abs(z.mean(axis=0)) < 4 / np.sqrt(len(z)) + 0.1)
    assert np.all(np.abs(z.std(axis=0) - 1) < 4 / np.sqrt(2 * len(z)) + more)


def test_without_noise_they_are_what_made_the_data():
    force, free, blocked = measured(0.9 + 0.1 * P / P.max(), 0.95)
    found = read_curves(muscle, gridded(force))
    assert_array_equal(found.valid, P > 0)
    # forces are straight in the law's own here; what is left is the root's and sums' rounding
    assert_allclose(found.free_strain[1:], free[1:], rtol=1e-10)
    assert_allclose(found.blocked_force[1:], blocked[1:], rtol=1e-10)
    # their curves are straight too: a quotient of order 1, a force linear in pressure
    assert int(found.order) == 1
    assert_allclose(found.coefficients[:2], [0.9, 0.1], rtol=1e-6)
    assert_allclose(found.misfit, 1.0)
    # tables give back blocked force and free strain
    c1, c2 = SmoothCurves(muscle, P, P.max()).corrections(found.coefficients)
    assert (c1[0], c2[0]) == (0.0, 1.0)
    tuned = fs.Muscle(*SIZES, tuning=fs.Tuning(P[1:], c1[1:], c2[1:]))
    assert_allclose(tuned.free_strain(P)[1:], free[1:], rtol=1e-6)
    assert_allclose(tuned.blocked_force(P)[1:], blocked[1:], rtol=1e-6)
    # between the measured pressures, over the same highest one
    curves = SmoothCurves(muscle, np.array([75e3]), P.max())
    half, _ = curves.corrections(found.coefficients)
    middle = curves.free_strain(found.coefficients)
    assert_allclose(half, untuned(curves.pressure, middle), rtol=1e-9)


def test_a_dead_band_is_no_correction():
    # a muscle with a dead band that measures as its own law says needs none
    banded = fs.Muscle(*SIZES, tuning=fs.Tuning(dead_band=20e3))
    strain = 0.9 * np.asarray(banded.free_strain(P))[:, None] * np.linspace(0, 1, 9)
    force = np.asarray(banded.force(P[:, None], strain))
    found = read_curves(banded, gridded(force, strain=strain))
    c1, c2 = SmoothCurves(banded, P, P.max()).corrections(found.coefficients)
    assert_allclose(c1, 0, atol=1e-6 * force.max())
    assert_allclose(c2, 1, rtol=1e-6)


def test_deviations_hold_over_seeds(noisy):
    found, _, free, blocked = noisy
    assert np.all(np.asarray(found.valid)[:, 1:])
    for value, deviation, truth in (
        (found.free_strain, found.free_strain_deviation, free),
        (found.blocked_force, found.blocked_force_deviation, blocked),
    ):
        check_deviations(((value - truth) / deviation)[:, 1:])
    # over 26 * 7 readings at most, some half of which pull: 0.08 of it each, 0.006 the mean
    assert_allclose(np.mean(found.noise), SIGMA, rtol=0.03)


def test_curves_hold_over_seeds(noisy):
    found, smooth, free, blocked = noisy
    share = P[1:] / P.max()
    basis = np.stack([np.ones_like(share), share])
    C, force = found.covariance[:, 4:, 4:], found.coefficients[:, 4:] @ basis
    deviation = np.sqrt(np.einsum("il,sij,jl->sl", basis, C, basis))
    check_deviations((force - blocked[1:]) / deviation)
    # the order is chosen by what is seen, which adds a little to what was reckoned with
    basis = np.stack([share**power for power in range(4)])
    C = found.covariance[:, :4, :4]
    deviation = np.sqrt(np.einsum("il,sij,jl->sl", basis, C, basis)) * UNTUNED_FREE[1:]
    check_deviations((smooth[:, 1:] - free[1:]) / deviation, more=0.3)
    # a curve through seven levels knows more than each of them
    assert deviation.mean() < 0.7 * np.mean(np.asarray(found.free_strain_deviation)[:, 1:])


def test_the_order_is_no_higher_than_the_data_ask(noisy):
    # Schwarz: a term that isn't there is taken with the chance of chi² > ln 8, 15 % each
    assert np.mean(np.asarray(noisy[0].order) == 0) > 0.75


# `test_without_noise_they_are_what_made_the_data` has order 1
@pytest.mark.parametrize("order", [pytest.param(1, marks=pytest.mark.slow), 2])
@pytest.mark.parametrize("seeds", SEEDS)
def test_the_order_is_as_high_as_the_data_ask(order, seeds):
    x = P / P.max()
    quotient = {1: 0.85 + 0.15 * x, 2: 0.8 + 0.5 * x - 0.35 * x**2}[order]
    force, free, _ = measured(quotient, 0.95)
    noise = np.random.default_rng(1).normal(scale=0.1, size=(seeds, *force.shape))
    found, smooth = read_many(gridded(force), force + noise)
    assert np.all(found.order >= order)
    # in three of four, within the binomial's 0.1 % quantile
    assert np.sum(found.order == order) >= binom.ppf(0.001, seeds, 0.75)
    assert_allclose(smooth.mean(axis=0)[1:], free[1:], rtol=1e-3)


def test_two_readings_that_pull_are_enough():
    strain = np.array([0.0, 0.03])
    force, free, blocked = measured(np.ones(P.size), 0.9, strain)
    found = read_curves(muscle, gridded(force, strain=strain))
    assert_array_equal(found.valid, P > 0)
    # two points and a line: exact without noise
    assert_allclose(found.blocked_force[1:], blocked[1:], rtol=1e-9)
    assert_allclose(found.free_strain[1:], free[1:], rtol=1e-7)
    # too few to see any scatter: a hundredth of the largest force is taken, and never none
    assert_allclose(found.noise, 0.01 * force.max(), rtol=1e-12)
    assert np.all(np.asarray(found.free_strain_deviation)[1:] > 0)


def test_one_reading_that_pulls_is_not_enough():
    strain = np.array([0.0, 0.03])
    force, _, _ = measured(np.ones(P.size), 0.9, strain)
    count = np.ones(force.shape)
    count[3, 1] = 0.0
    found = read_curves(muscle, gridded(force, strain=strain, count=count))
    assert_array_equal(found.valid, (P > 0) & (np.arange(P.size) != 3))
    # the others' curves go through its place
    smooth = SmoothCurves(muscle, P, P.max()).free_strain(found.coefficients)
    assert_allclose(smooth[3], UNTUNED_FREE[3], rtol=1e-4)


def test_clipped_readings_are_not_read():
    force, free, blocked = measured(np.ones(P.size), 0.95)
    # also where the muscle pulls, as by a gauge that slipped there
    clipped = (force < 0) | (np.arange(STRAIN.size) == 3)
    found = read_curves(muscle, gridded(np.where(clipped, 0.0, force), clipped))
    assert_allclose(found.free_strain[1:], free[1:], rtol=1e-8)
    assert_allclose(found.blocked_force[1:], blocked[1:], rtol=1e-8)


def test_averages_weigh_what_they_average():
    # nine readings in one place are three times as sure
    force, _, _ = measured(np.ones(P.size), 0.95)
    force = force + np.random.default_rng(2).normal(scale=SIGMA, size=force.shape)
    one = read_curves(muscle, gridded(force))
    nine = read_curves(muscle, gridded(force, count=np.full(force.shape, 9.0)))
    assert_allclose(nine.free_strain[1:], one.free_strain[1:], rtol=1e-9)
    assert_allclose(nine.noise, 3 * one.noise, rtol=1e-6)
    assert_allclose(nine.blocked_force_deviation[1:], one.blocked_force_deviation[1:], rtol=1e-6)


def test_a_curve_that_misses_its_readings_is_widened():
    # a step in free strain is no polynomial of order 3 or less
    quotient = np.where(P > 180e3, 1.0, 0.8)
    force, _, _ = measured(quotient, 0.95)
    force = force + np.random.default_rng(3).normal(scale=0.05, size=force.shape)
    found = read_curves(muscle, gridded(force))
    assert found.misfit[0] > 10
    assert found.misfit[1] < 2

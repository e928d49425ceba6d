"""A muscle as a table of its co-energy: one potential, its error, its ends."""

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs


SIX = fs.example("kim2021_figure_6")
TOP = 413.7e3


@pytest.fixture(scope="module")
def table():
    return SIX.table(TOP)


@pytest.fixture(scope="module")
def points(table):
    rng = np.random.default_rng(5)
    return rng.uniform(-2e4, TOP, 2000), rng.uniform(*map(float, table.strains), 2000)


def test_force_and_volume_are_slopes_of_one_potential(table, points):
    P, eps = points
    here = table.lookup_at(P, eps)
    h, step = 1.0, 1e-6
    up, down = table.lookup_at(P + h, eps), table.lookup_at(P - h, eps)
    # of differences: the polynomials' third derivatives leave 1e-7, a line between leaves more
    assert_allclose((up.coenergy - down.coenergy) / (2 * h), here.volume, rtol=1e-6, atol=1e-12)
    right, left = table.lookup_at(P, eps + step), table.lookup_at(P, eps - step)
    force = (right.coenergy - left.coenergy) / (2 * step * SIX.length)
    assert_allclose(force, here.force, rtol=1e-5, atol=1e-3)
    # Maxwell's relation, exactly: both are the same mixed slope
    mixed = (right.volume - left.volume) / (2 * step * SIX.length)
    assert_allclose(mixed, here.force_by_pressure, rtol=1e-4, atol=1e-8)
    assert_allclose((up.force - down.force) / (2 * h), here.force_by_pressure, rtol=1e-4, atol=1e-8)


def test_its_error_is_as_small_as_it_says(table, points):
    P, eps = points
    inside = (P > 0) & (eps > 0) & (eps < 0.31)
    off = np.abs(table.force(P, eps) - SIX.force(np.maximum(P, 0), eps))[inside]
    median, most, largest = np.quantile(off, (0.5, 0.99, 1))
    # the figures for a table of this many nodes
    assert median < 1e-5 and most < 0.01 and largest < 0.14
    # stated at a quarter of each cell, where the slopes' error is largest, and at the kinks
    assert all(a <= b for a, b in zip(table.errors, (1e-5, 0.05, 0.3), strict=True))


@pytest.mark.parametrize("seed", range(6))
def test_no_point_of_a_random_muscle_is_much_farther_off_than_the_table_states(seed):
    rng = np.random.default_rng(seed)
    radius = rng.uniform(4e-3, 12e-3)
    muscle = fs.Muscle(
        rng.uniform(14, 30) * radius, radius, rng.uniform(0.12, 0.3) * radius,
        np.radians(rng.uniform(20, 42)), buckling="elastica" if seed == 5 else "kim2021",
    )  # fmt: skip
    table = muscle.table(4e5, shape=(65, 81))
    P = 4e5 * rng.uniform(0, 1, 300)[:, None] ** 2
    eps = np.sort(rng.uniform(*map(float, table.strains), 1000))
    off = np.max(np.abs(table.force(P, eps) - muscle.force(P, eps)))
    # a quarter of a cell is not quite where a polynomial is farthest from the law
    assert off <= 1.1 * table.errors[2]


def test_deflection_and_kinks_are_the_laws(table):
    rng = np.random.default_rng(2)
    P, eps = rng.uniform(1e3, TOP, 3000), rng.uniform(0.0, 0.35, 3000)
    for kink in ("free_strain", "collapse_strain"):
        found, exact = getattr(table, kink)(P), getattr(SIX, kink)(P)
        # the kinks are linear between 160 lines
        assert_allclose(found, exact, atol=3e-4)
    assert_allclose(table.onset(P), SIX.at(P).onset, atol=3e-4)
    near = np.abs(eps - SIX.collapse_strain(P)) < 3e-4  # where a deflection jumps
    off = np.abs(table.deflection(P, eps) - SIX.deflection(P, eps))[~near]
    # past the onset it grows as a root, of which 1e-4 of strain is 0.7 mm of 127
    assert np.quantile(off, 0.95) < 2e-5 and np.max(off) < 1e-3
    assert table.deflection(1e5, 0.0) == 0.0


def test_its_volume_is_the_conjugate_one(table, points):
    P, eps = points
    inside = P > 100
    exact = SIX.conjugate_volume(P[inside], eps[inside])
    off = np.abs(table.conjugate_volume(P, eps)[inside] / exact - 1)
    assert np.quantile(off, 0.5) < 1e-6 and np.max(off) < 0.02  # the largest beside kinks


def test_its_slopes_at_the_ends_of_pressure_are_the_laws(table):
    eps = np.linspace(*map(float, table.strains), table.coefficients.shape[1] + 1)
    for P in (0.0, float(table.root_step) ** 2, float(table.highest_pressure)):
        here, exact = table.lookup_at(P, eps), SIX.conjugate_volume(P, eps)
        # differences leave 1e-9 of the largest volume, 3e-5 m³
        assert_allclose(here.volume, exact, rtol=1e-8, atol=1e-13)


def test_bends_in_pressure_are_continuous(table):
    # from the second line on, where an integrator would see a jump of the volume's slope
    lines = (float(table.root_step) * np.arange(2, 160)) ** 2
    eps = np.linspace(0, 0.3, 31)[:, None]
    low, high = (table.lookup_at(lines * (1 + d), eps).volume_by_pressure for d in (-1e-9, 1e-9))
    assert_allclose(low, high, atol=1e-6 * np.max(np.abs(low)))


def test_below_and_above_it_goes_on_linearly(table):
    eps = np.linspace(-0.05, 0.3, 15)
    empty = table.lookup_at(0.0, eps)
    sucked = table.lookup_at(-28e3, eps)
    assert_allclose(sucked.force, empty.force - 28e3 * empty.force_by_pressure, rtol=1e-12)
    assert_allclose(sucked.volume, empty.volume, rtol=1e-12)
    end = float(table.highest_pressure)
    full, more = table.lookup_at(end, eps), table.lookup_at(end + 1e4, eps)
    assert_allclose(more.volume, full.volume, rtol=1e-12)
    assert_allclose(more.force - full.force, 1e4 * full.force_by_pressure, rtol=1e-9, atol=1e-12)


def test_a_pressure_of_zero_but_for_rounding_has_the_slope_at_zero(table):
    at, before = table.lookup_at(np.array([0.0, -1e-11, -1.0]), 0.1), table.lookup_at(1e-3, 0.1)
    assert at.volume_by_pressure[1] == at.volume_by_pressure[0] > 0
    assert_allclose(at.volume_by_pressure[0], before.volume_by_pressure, rtol=1e-5)
    assert at.volume_by_pressure[2] == 0  # the volume stays below zero


def test_jax_agrees_and_is_differentiated(table, points):
    P, eps = points
    force = jax.jit(table.force)(P, eps)
    assert_allclose(force, table.force(P, eps), rtol=1e-12, atol=1e-12)
    slope = jax.jit(jax.vmap(jax.grad(lambda p, e: table.lookup_at(p, e).force)))(P, eps)
    assert_allclose(slope, table.lookup_at(P, eps).force_by_pressure, rtol=1e-9, atol=1e-12)
    assert np.all(
        np.isfinite(jax.jit(jax.vmap(jax.grad(lambda p: table.lookup_at(p, 0.1).volume)))(P))
    )
    assert np.isfinite(jax.jit(jax.grad(lambda p: table.lookup_at(p, 0.1).coenergy))(0.0))


@pytest.mark.parametrize(("argument", "P", "eps"), [("strain", 1e5, 0.5), ("pressure", 5e5, 0.1)])
def test_what_it_can_t_say_is_refused(table, argument, P, eps):
    with pytest.raises(fs.InvalidInputError) as error:
        table.force(P, eps)
    assert error.value.argument == argument

"""The volume that goes with the force: against an oracle, round cycles, at jumps."""

import math
import subprocess
import sys
from itertools import pairwise

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs


SIX = fs.example("kim2021_figure_6")
ROUNDING = 2e-14  # m³, of NumPy's: a difference of co-energies of some 8 J over 0.5 Pa
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def round_trip(muscle, volume, top, end):
    """Work of the fluid and of the ends [J]: filled at rest, contracted, vented, stretched."""
    P, eps = top / 2 * (1 + NODES), end / 2 * (1 + NODES)
    # P dV round the loop is -V dP round it
    fluid = sum(WEIGHTS * (volume(P, end + 0 * P) - volume(P, 0 * P))) * top / 2
    ends = sum(WEIGHTS * (muscle.force(top, eps) - muscle.force(0.0, eps))) * end / 2
    return fluid, ends * muscle.length


@pytest.mark.parametrize("buckling", ["kim2021", "elastica"])
def test_empty_arrays(buckling):
    muscle = SIX.replace(buckling=buckling)
    assert muscle.conjugate_volume(np.zeros(0), 0.1).shape == (0,)
    assert muscle.conjugate_volume(np.zeros((3, 1)), np.zeros(0)).shape == (3, 0)


def test_it_is_the_braid_s_up_to_the_free_strain():
    P = np.array([34.5e3, 137.9e3, 413.7e3])[:, None]
    eps = SIX.free_strain(P) * np.linspace(-0.5, 1, 7)
    by_jax = jax.jit(SIX.conjugate_volume)(P, eps)
    assert_allclose(by_jax, SIX.volume(eps), rtol=1e-12)
    assert_allclose(SIX.conjugate_volume(P, eps), SIX.volume(eps), rtol=0, atol=ROUNDING)


def test_neither_it_nor_a_table_needs_jax():
    code = (
        "import sys, fascicle as fs; sys.modules['jax'] = None;"
        "six = fs.example('kim2021_figure_6'); six.table(4e5);"
        "print(six.conjugate_volume(3e4, 0.1))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    by_jax = jax.jit(SIX.conjugate_volume)(3e4, 0.1)
    assert_allclose(float(done.stdout), by_jax, rtol=0, atol=ROUNDING)


def test_no_cycle_makes_energy():
    fluid, ends = round_trip(SIX, SIX.conjugate_volume, 50e3, 0.2)
    # kinks cross the rectangle, and Gauss's rule over them leaves some 1e-5 of the work
    assert_allclose(fluid, ends, rtol=1e-4)
    assert_allclose(fluid, 0.108, atol=0.0005)
    straight, _ = round_trip(SIX, lambda _, eps: SIX.volume(eps), 50e3, 0.2)
    assert_allclose(straight, 0.388, atol=0.0005)  # energy from nothing, backwards


@pytest.mark.parametrize("buckling", ["kim2021", pytest.param("elastica", marks=pytest.mark.slow)])
@pytest.mark.parametrize("tension", ["klute_hannaford", "meller2014", "kothera2009"])
def test_it_is_the_slope_of_the_work(buckling, tension):
    tuning = fs.Tuning([2e5, 4e5], [1.0, 2.0], [0.9, 1.1], youngs_modulus_factor=1.2)
    muscle = SIX.replace(buckling=buckling, tension=tension, tuning=tuning)
    rng = np.random.default_rng(3)
    P, eps = rng.uniform(1e3, 4e5, 40), rng.uniform(-0.1, 0.4, 40)

    def work(P):
        at = muscle.at(P)
        kinks = np.stack([at.free_strain, at.onset, at.collapse_strain])
        stops = np.sort(
            np.vstack([0 * eps, eps, np.clip(kinks, *np.sort([0 * eps, eps], axis=0))]), axis=0
        )
        total = 0.0
        for a, b in pairwise(stops):
            x = (a + b) / 2 + (b - a) / 2 * NODES[:, None]
            total = total + np.sum(WEIGHTS[:, None] * muscle.force(P, x), axis=0) * (b - a) / 2
        return muscle.length * total * np.sign(eps)

    h = 2.0  # Pa: a difference's own error is some (h/P)² or, by rounding, 1e-16 J/h
    swept = (work(P + h) - work(P - h)) / (2 * h)
    assert_allclose(
        muscle.conjugate_volume(P, eps) - muscle.volume(0.0), swept, rtol=1e-5, atol=2e-12
    )


def test_it_holds_the_share_of_a_jump():
    # just at the onset that turns back, which moves by a strain of 1e-4 for a pascal
    muscle = fs.Muscle(
        45.5411e-3, 10e-3, 2.5e-3, math.radians(22), buckling="elastica",
        tuning=fs.Tuning(collapse_moment_factor=1e6),
    )  # fmt: skip
    bundle = fs.Bundle([fs.MotorUnit(muscle)])
    work = [fs.energetics.work(bundle, [20e3 + h], 0.13095) for h in (-0.5, 0.5)]
    swept = float(work[1] - work[0])
    found = muscle.conjugate_volume(20e3, 0.13095)
    assert_allclose(found, muscle.volume(0.0) + swept, rtol=1e-3)
    straight = muscle.conjugate_volume(20e3, 0.1)
    assert found < 0.8 * straight  # without the jump's share it would be 0.95 of it


def test_with_elastica_it_never_falls_with_pressure_but_the_paper_s_law_does():
    P, eps = np.meshgrid(np.linspace(0, 413.7e3, 41), np.linspace(0, 0.31, 32), indexing="ij")

    def falls(muscle):
        return np.diff(muscle.conjugate_volume(P, eps), axis=0) / np.diff(P, axis=0)

    assert np.min(falls(SIX.replace(buckling="elastica"))) > -2 * ROUNDING / 10e3
    assert np.min(falls(SIX)) < -1e-12


def test_jax_agrees_and_slopes_are_finite():
    P, eps = np.array([0.0, 34.5e3, 0.0, 137.9e3]), np.array([0.1, 0.15, 0.0, 0.1])
    # compiled: each of its operations alone would be compiled too, in six times as long
    value, slopes = jax.jit(jax.vmap(jax.value_and_grad(SIX.conjugate_volume, (0, 1))))(P, eps)
    assert_allclose(value, SIX.conjugate_volume(P, eps), rtol=0, atol=ROUNDING)
    by_pressure, by_strain = slopes
    assert np.all(np.isfinite(by_pressure))
    # Maxwell: the volume moves with strain as the force does with pressure
    force = jax.jit(jax.vmap(jax.grad(SIX.force)))(P, eps)
    assert_allclose(by_strain, SIX.length * force, rtol=1e-9, atol=1e-15)

"""Muscles of unlike length: the plates share a distance, not a strain."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import energetics
from refusing import refuses


PLATES, SHORT, LONG = 0.127, 0.124, 0.131
FULL = 344.7e3


def built(length, **more):
    sizes = (length, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")
    return fs.Muscle(*sizes, **more)


short, long = built(SHORT), built(LONG)
bundle = fs.Bundle([fs.MotorUnit(short), fs.MotorUnit(long, 2)], FULL, length=PLATES)
even = fs.Bundle([fs.MotorUnit(short), fs.MotorUnit(short, 2)], FULL)


def strains(eps):
    """Of the short and of the long muscle, from their lengths."""
    here = PLATES * (1 - np.asarray(eps))
    return (SHORT - here) / SHORT, (LONG - here) / LONG


def total(P, eps):
    of_short, of_long = strains(eps)
    return short.force(P[0], of_short) + 2 * long.force(P[1], of_long)


def test_force_is_the_sum_at_each_muscle_s_own_strain():
    P, eps = [FULL, 50e3], np.linspace(-0.05, 0.35, 9)
    # the same sums, strains rounded another way: 1e-16 of strain on some 1e4 N
    assert_allclose(bundle.force(P, eps), total(P, eps), rtol=1e-11, atol=1e-11)
    pulls = np.maximum(short.force(P[0], strains(eps)[0]), 0)
    assert_allclose(bundle.unit_forces(P, eps, resistance=False)[:, 0], pulls, atol=1e-10)


@pytest.mark.parametrize("P", [[FULL, 0.0], [FULL, 69e3], [0.0, FULL], [0.0, 0.0]])
def test_free_strain_is_the_first_zero_of_that_sum(P):
    grid = np.linspace(-0.05, 0.3, 3501)
    signs = np.asarray(total(P, grid)) > 0
    first = grid[1:][signs[1:] != signs[:-1]][0]
    # to the grid's step
    assert_allclose(bundle.free_strain(P), first, atol=1.01e-4)
    zeros = bundle.equilibria(P)
    assert_allclose(bundle.free_strain(P), zeros.strain[0], atol=1e-12)
    # a slope of some 1e3 N turns a root's 1e-14 into 1e-11 N
    assert_allclose(bundle.force(P, zeros.strain[: int(zeros.count)]), 0, atol=1e-9)


def test_without_resistance_the_longest_free_strain_counts():
    P = [FULL, 300e3]
    ends = [
        1 - (1 - float(one.free_strain(p))) * one.length / PLATES
        for one, p in zip((short, long), P, strict=True)
    ]
    assert_allclose(bundle.free_strain(P, resistance=False), max(ends), rtol=1e-12)


@pytest.mark.parametrize("resistance", [True, False])
@pytest.mark.parametrize("end", [0.2, 0.32, -0.04])
def test_work_is_the_area_under_the_sum(end, resistance):
    P = [FULL, 69e3]
    eps = np.linspace(0, end, 20001)
    area = np.trapezoid(np.asarray(bundle.force(P, eps, resistance)), eps)
    # the trapezoid's error at kinks of 1e4 N per strain over steps of 2e-5
    assert_allclose(energetics.work(bundle, P, end, resistance), PLATES * area, atol=1e-6)


def test_ideal_muscles_turn_all_fluid_energy_into_work():
    pair = fs.Bundle(
        [fs.MotorUnit(built(L, tension="ideal")) for L in (SHORT, LONG)], FULL, length=PLATES
    )
    # both pull throughout: W = P ΔV, the volumes those at each muscle's own strains
    work = energetics.work(pair, [FULL, FULL], 0.2)
    assert_allclose(energetics.fluid_energy(pair, 0.2, FULL, [1, 1]), work, rtol=1e-12)


def test_states_and_onset_are_those_of_the_sum():
    space = fs.recruitment.workspace(bundle, levels=[50e3], strain=[0.1, 0.2])
    expected = [total([50e3, 0.0], [0.1, 0.2]), total([FULL, 50e3], [0.1, 0.2])]
    assert_allclose(space.force[:, 0], expected, rtol=1e-11)
    onset = fs.reversal.onset_pressure(bundle, 0.2)
    at = [float(total([FULL, p], 0.2)) for p in (0.0, 0.999 * onset, 1.001 * onset)]
    assert 0 < onset < FULL and at[1] < at[0] < at[2]


def test_a_file_holds_the_plates_distance(tmp_path):
    fs.save(bundle, tmp_path / "b.toml")
    text = (tmp_path / "b.toml").read_text()
    assert 'length = "127 mm"' in text.split("[bundle]")[1]
    again = fs.load(tmp_path / "b.toml")
    assert_allclose(again.ratios, bundle.ratios, rtol=1e-15)
    (tmp_path / "b.toml").write_text(text.replace('length = "127 mm"\n', ""))
    with refuses("bundle.motor_unit"):
        fs.load(tmp_path / "b.toml")
    fs.save(even, tmp_path / "even.toml")
    assert "length" not in (tmp_path / "even.toml").read_text().split("[bundle]")[1]


def test_plates_at_another_distance_stretch_all_muscles():
    apart = fs.Bundle([fs.MotorUnit(short)], length=PLATES)
    assert_allclose(apart.force([FULL], 0.1), short.force(FULL, strains(0.1)[0]), rtol=1e-12)
    assert float(apart.force([0.0], 0.0)) > 0


@pytest.mark.slow
def test_free_strain_differentiates_by_a_length():
    def free(length):
        units = [fs.MotorUnit(short), fs.MotorUnit(built(length))]
        return fs.Bundle(units, length=PLATES).free_strain(jnp.array([FULL, 40e3]))

    both, step = jax.jit(jax.value_and_grad(free)), 1e-6
    numeric = (both(LONG + step)[0] - both(LONG - step)[0]) / (2 * step)
    # a root's 1e-13 over a step of 1e-6
    assert_allclose(both(LONG)[1], numeric, rtol=1e-5)

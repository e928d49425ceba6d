"""A column that shears: its load, and what it pushes with when it is bowed."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle_shear import load, push, volume_of_slices

import fascicle as fs
from fascicle.muscle.buckling import Elastica, Kim2021
from refusing import warns


SIX = fs.example("kim2021_figure_6")
E, NU, R0, RI = 1.78e6, 0.5, 6.35e-3, 4.75e-3  # of Fig. 6's muscle


def shear_stiffness(muscle, pressure):
    """κGA of a thin tube, and a pressure on the section at free strain, by hand."""
    r = muscle.radius(muscle.free_strain(pressure))
    section = math.pi * (R0**2 - RI**2)
    return 0.5 * E / (2 * (1 + NU)) * section + pressure * math.pi * r**2


def test_a_pressure_resists_shear_by_its_section():
    # P times the volume that is lost: ½ P π r² L γ², of which the slope is a shear stiffness
    P, r, L, gamma = 1e5, 7e-3, 0.1, 1e-3
    work = P * (math.pi * r**2 * L - volume_of_slices(math.pi * r**2, L, gamma))
    # 1 − cos γ is known to 1e-16/γ²
    assert_allclose(work, 0.5 * P * math.pi * r**2 * L * gamma**2, rtol=1e-6)


@pytest.mark.oracle
@pytest.mark.parametrize("length", [0.127, 0.06])
@pytest.mark.parametrize("pressure", [0.0, 34.5e3, 137.9e3])
def test_it_gives_way_at_the_oracle_s_load(pressure, length):
    muscle = SIX.replace(length=length, buckling=Elastica(shear="engesser"))
    onset = float(muscle.at(pressure).onset)
    free_length = length * (1 - float(muscle.free_strain(pressure)))
    EI = E * math.pi / 4 * (R0**4 - RI**4)
    found = load(EI, shear_stiffness(muscle, pressure), free_length)
    # the arc's own length is shorter than that at free strain, on which shear and turns are counted
    arc = length * (1 - onset)
    thrust = -float(muscle.law.tension.force(pressure, onset))
    # 400 pieces leave (π/200)² of it
    assert_allclose(thrust * arc / free_length, found, rtol=2e-4)


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("over", "within"),
    [
        *(pytest.param(*more, marks=pytest.mark.slow) for more in ((0.2, 0.003), (0.5, 0.006))),
        (1.0, 0.011),
    ],
)
def test_bowed_it_pushes_as_a_column_that_shears(over, within):
    # the softer elastica is exact as the bow vanishes; at a third of the length it is not, quite
    EI, L = 1.56e-3, 0.12
    euler = 4 * math.pi**2 * EI / L**2
    for shortening, share in ((0.1, 0.1), (0.3, 1.0)):
        softer = push(EI / (1 + over), 1e9 * euler, L, shortening)
        off = softer / push(EI, euler / over, L, shortening) - 1
        assert 0 < off < share * within


@pytest.mark.parametrize("law", [Kim2021, Elastica])
def test_no_shear_is_today_s_to_the_bit(law):
    P, eps = np.linspace(0, 4e5, 5)[:, None], np.linspace(-0.1, 0.6, 30)
    one, other = (SIX.replace(buckling=law(*given)).force(P, eps) for given in ((), (0.0, "none")))
    assert np.array_equal(one, other)
    softer = SIX.replace(buckling=law(shear="engesser"))
    free = softer.free_strain(P)
    pulls = eps <= free
    assert np.array_equal(softer.force(P, eps)[pulls], one[pulls])
    assert np.any(softer.force(P, eps)[~pulls] != one[~pulls])


def test_slender_muscles_hardly_shear():
    long = SIX.replace(length=20 * 0.127, buckling=Elastica(shear="engesser"))
    plain = long.replace(buckling="elastica")
    eps = long.free_strain(1e5) + 0.01
    # N_E/S falls with the square of the length: 0.17/400 at 100 kPa
    assert_allclose(long.force(1e5, eps), plain.force(1e5, eps), rtol=2e-3)


def test_it_is_named_in_files(tmp_path):
    muscle = SIX.replace(buckling=Elastica(shear="engesser"))
    fs.save(muscle, tmp_path / "muscle.toml")
    assert 'shear = "engesser"' in (tmp_path / "muscle.toml").read_text(encoding="utf-8")
    assert fs.load(tmp_path / "muscle.toml") == muscle


def test_stubby_muscles_are_warned_of():
    with warns():
        SIX.replace(length=6 * 6.35e-3)

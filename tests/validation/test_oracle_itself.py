"""The oracle held to the equations by another way: springs, energies and mpmath."""

import math
from dataclasses import replace
from pathlib import Path

import mpmath as mp
import oracle_force
import pytest
from oracle_buckling import elastica, kim2021
from oracle_muscle import (
    SILICONE,
    Muscle,
    area,
    bladder_untuned,
    collapse_moment,
    free_strain,
    modulus,
    second_moment,
    tension,
)
from scipy.integrate import quad


MUSCLE = Muscle(material=SILICONE)


@pytest.mark.parametrize("strain", [-0.05, 0.01, 0.2, 0.5])
def test_bladder_is_the_derivative_of_its_energy(strain):
    a0 = MUSCLE.braid_angle

    def energy(lam):
        one = lam**2
        two = (1 - mp.cos(a0) ** 2 * lam**2) / mp.sin(a0) ** 2
        three = 1 / (one * two)
        I1, I2 = one + two + three, one * two + two * three + three * one
        return MUSCLE.material.c10 * (I1 - 3) + MUSCLE.material.c01 * (I2 - 3)

    expected = area(MUSCLE) * mp.diff(energy, mp.mpf(1 - strain))
    # mpmath's derivative is good to 1e-8 or so at its default precision
    assert bladder_untuned(MUSCLE, strain) == pytest.approx(float(expected), rel=1e-7)


@pytest.mark.parametrize("strain", [0.065, 0.1, 0.3, 0.55])
def test_spring_equations_hold_as_printed(strain):
    P = 34.5e3
    state = kim2021(MUSCLE, P, strain)
    e_f = free_strain(MUSCLE, P)
    L_fs = MUSCLE.length * (1 - e_f)
    x = (strain - e_f) * MUSCLE.length
    two_l = (state.arc_strain - e_f) * MUSCLE.length
    EI = modulus(MUSCLE) * second_moment(MUSCLE)
    F_b = 4 * EI * math.pi**2 * (L_fs + x) / (L_fs - x) ** 3
    y_max = math.sqrt(4 * x * (L_fs - x)) / math.pi
    theta = math.acos((L_fs - x) / L_fs)
    theta_short = math.acos((L_fs - x) / (L_fs - two_l))
    k1 = 2 * F_b / (y_max * math.sin(theta) * math.cos(theta))  # (13)
    k2 = modulus(MUSCLE) * area(MUSCLE) / L_fs
    y_short = state.deflection
    # (15) and both forms of (16); two_l is read back from a strain, which costs digits
    assert y_short == pytest.approx(k2 / k1 * 2 * two_l / math.sin(theta_short), rel=1e-8)
    F = k1 * y_short * math.sin(theta_short) * math.cos(theta_short) / 2
    assert -state.bending == pytest.approx(F, rel=1e-8)
    ratio = y_short * math.sin(2 * theta_short) / (y_max * math.sin(2 * theta))
    assert -state.bending == pytest.approx(ratio * F_b, rel=1e-8)


@pytest.mark.parametrize("strain", [0.095, 0.12, 0.3, 0.55])
def test_elastica_is_stationary_and_its_force_is_the_energys_slope(strain):
    muscle, P = replace(MUSCLE, buckling="elastica"), 34.5e3
    curve = elastica(muscle, P)
    L_fs = muscle.length * (1 - curve.free_strain)

    def total(arc, at):
        """Pi, from the definition: the work of compression and of bending."""
        work = quad(lambda e: -tension(muscle, P, e), curve.free_strain, arc, epsabs=1e-14)[0]
        ratio = (1 - at) / (1 - arc)
        m = mp.findroot(lambda m: 2 * mp.ellipe(m) / mp.ellipk(m) - 1 - ratio, (1e-6, 0.8))
        K, E = mp.ellipk(m), mp.ellipe(m)
        bend = modulus(muscle) * second_moment(muscle) / L_fs * 32 * K**2 * (E / K - 1 + m)
        return work * muscle.length + float(bend)

    state = curve.state(strain)
    h = 1e-6
    in_arc = (total(state.arc_strain + h, strain) - total(state.arc_strain - h, strain)) / (2 * h)
    slope = (total(state.arc_strain, strain + h) - total(state.arc_strain, strain - h)) / (2 * h)
    # energies near 0.1 J differenced over 2e-6 are good to 1e-8 J; forces to 1e-7 of a newton
    assert abs(in_arc) < 1e-6
    assert -slope / muscle.length == pytest.approx(state.force, rel=1e-5)


def stubby(length, degrees):
    """A stubby, steep-fibered muscle, where the bent branch turns back on itself."""
    return Muscle(
        length=length,
        outer_radius=10e-3,
        wall_thickness=2.5e-3,
        braid_angle=math.radians(degrees),
        buckling="elastica",
        collapse_factor=1e6,
    )


def test_a_fold_is_followed_to_its_end_and_jumped():
    muscle, P = stubby(50e-3, 24), 20e3
    curve = elastica(muscle, P)
    fold = float(curve.reached[curve.chord_strain.argmin()])
    assert curve.onset < fold < 0.6
    assert curve.chord_strain.min() < curve.onset < fold
    assert curve.count(fold - 0.01) == 3
    before = oracle_force.response(muscle, P, fold - 1e-4)
    after = oracle_force.response(muscle, P, fold + 1e-4)
    assert before.region == after.region == oracle_force.POST_BUCKLING
    assert after.force > before.force + 1  # it snaps, and pushes back less


def test_a_branch_that_leaves_the_onset_backward():
    # phi tops the buckling load by 0.02 %: at the onset it hardly rises any more
    muscle, P = stubby(45.5411e-3, 22), 20e3
    curve = elastica(muscle, P)
    assert curve.chord_strain[1] < curve.chord_strain[0] == curve.onset
    assert curve.count(curve.onset - 0.002) == 3
    before = oracle_force.response(muscle, P, curve.onset - 1e-9)
    after = oracle_force.response(muscle, P, curve.onset + 1e-9)
    assert before.region == oracle_force.STRAIGHT
    assert after.region == oracle_force.POST_BUCKLING
    assert after.force > before.force + 1
    # a collapse that the snap jumps over takes place at the onset, from the straight side
    jumped = curve.state(curve.onset + 1e-9).moment
    factor = 0.5 * jumped / collapse_moment(replace(muscle, collapse_factor=1.0), P)
    e_c, at = oracle_force.collapse(replace(muscle, collapse_factor=factor), P)
    assert e_c == curve.onset
    assert at is not None
    assert at.force == pytest.approx(tension(muscle, P, e_c), rel=1e-14)


def test_the_oracle_never_imports_the_library():
    files = sorted(Path(__file__).parent.glob("oracle_*.py"))
    assert len(files) >= 5
    for file in files:
        assert "import fascicle" not in file.read_text()
        assert "from fascicle" not in file.read_text()

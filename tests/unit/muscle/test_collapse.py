import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

import fascicle as fs
from fascicle.muscle.collapse import COLLAPSE_LAWS
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS, hinge_moment


L0, R0, T0 = 0.127, 6.35e-3, 1.6e-3
SIZES = (L0, R0, T0, math.radians(33), "silicone_kim2021")
E = 1.78e6
muscle = fs.Muscle(*SIZES)
P = np.array([0.0, 34.5e3, 1e6])


@pytest.mark.parametrize("name", COLLAPSE_LAWS)
def test_moment_has_a_slope_in_pressure(name):
    made = fs.Muscle(*SIZES, collapse=name)
    slope = jax.vmap(jax.grad(made.collapse_moment))(jnp.asarray(P))
    step = 10.0  # Pa
    high = made.collapse_moment(P[1:2] + step)
    assert_allclose(slope[1], (high[0] - made.collapse_moment(P[1] - step)) / (2 * step), rtol=1e-6)
    assert np.all(np.isfinite(slope))


def test_hinge_moment():
    # k_r 2θ_r = E I_r/t0 with I_r = πr0t0³/4
    assert_allclose(hinge_moment(muscle.bladder, E), E * math.pi * R0 * T0**3 / 4 / T0, rtol=1e-15)
    assert_allclose(muscle.moment(0.0, 0.3), math.pi * E * R0 * T0**2 / 4, rtol=1e-14)


def state(x):
    column = muscle.law.at(jnp.asarray(34.5e3)).column
    eps = column.free_strain + x / L0
    return column, eps, float(column.free_length), float(column.bending_stiffness)


@pytest.mark.parametrize(("name", "slope"), [("derived", 1.0), ("consistent", 2.0)])
def test_force_is_the_derivative_of_the_energy(name, slope):
    """U = 2 ∫ EI/2 κ² over a half + 2θ M_h with tan θ = √(x/(L − x)), for [R11]'s moment."""
    column, _, L, EI = state(0.0)
    M_h = 0.02

    def energy(x):
        chord = L - x
        top = slope / math.pi * math.sqrt(x * chord)

        def curvature(z):
            return top * (math.pi / chord) ** 2 * math.cos(math.pi * z / chord)

        half = quad(lambda z: EI / 2 * curvature(z) ** 2, 0, chord / 2, epsabs=0, epsrel=1e-12)[0]
        return 2 * half + 2 * math.atan(math.sqrt(x / chord)) * M_h

    law = POST_COLLAPSE_LAWS[name]()
    for x in (0.003, 0.02, 0.06):
        eps = column.free_strain + x / L0
        step = 1e-6
        expected = (energy(x + step) - energy(x - step)) / (2 * step)
        # the central difference errs by step²/x², some 1e-7 at the smallest x
        assert_allclose(law.push(column, M_h, x)[0], expected, rtol=1e-6)
        assert_allclose(law.deflection(column, eps), slope / math.pi * math.sqrt(x * (L - x)))


def test_printed_reading():
    column, _, L, EI = state(0.02)
    expected = EI * math.pi**2 * L / (4 * (L - 0.02) ** 2) + 0.02 / math.sqrt(0.02 * (L - 0.02))
    force, _ = POST_COLLAPSE_LAWS["printed"]().push(column, 0.02, 0.02)
    assert_allclose(force, expected, rtol=1e-13)


@pytest.mark.parametrize(
    ("name", "share"), [("derived", 1 / 4), ("consistent", 1.0), ("printed", 1 / 4)]
)
def test_shape_keeps_its_arc_to_second_order(name, share):
    """The chord and ½∫y'² make L_fs if the halves are inextensible.

    `derived` has half the slope that takes, so a quarter of the shortening.
    """
    made = fs.Muscle(*SIZES, post_collapse=name)
    P, eps = 34.5e3, np.array([0.2, 0.3, 0.5])
    L = L0 * (1 - float(made.free_strain(P)))
    line = made.shape(P, eps, 4001)
    z, y = np.asarray(line.z), np.asarray(line.y)
    dz = z[:, 1] - z[:, 0]
    slopes = np.diff(y, axis=1) / dz[:, None]
    second_order = 0.5 * np.sum(slopes**2, axis=1) * dz
    x = eps * L0 - (L0 - L)
    assert_allclose(z[:, -1], L - x, rtol=1e-13)
    assert_allclose(second_order, share * x, rtol=1e-6)  # differences of 4000 steps: 1e-7
    assert_allclose(-y.min(axis=1), made.deflection(P, eps), rtol=1e-12)


def test_shape_is_clamped_and_hinged():
    line = muscle.shape(34.5e3, 0.3, 2001)
    z, y = np.asarray(line.z), np.asarray(line.y)
    slope = np.gradient(y, z)
    x = 0.3 * L0 - float(muscle.free_strain(34.5e3)) * L0
    assert y[0] == 0 and abs(y[-1]) < 1e-18
    assert abs(slope[0]) < 2e-3 and abs(slope[-1]) < 2e-3  # clamped: one step's worth of slope
    # (24): the slope next to the hinge is √(x/(L_fs − x)), on either side
    expected = math.sqrt(x / (L0 * 0.7))
    assert_allclose([-slope[990], slope[1010]], expected, rtol=1e-3)
    assert_allclose(y, y[::-1], atol=1e-17)

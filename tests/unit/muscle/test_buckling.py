import math
from types import SimpleNamespace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

import fascicle as fs
from fascicle.muscle.buckling import Kim2021
from fascicle.muscle.buckling.kim2021 import bow_ratio


L0 = 0.127
muscle = fs.Muscle(L0, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")
law = Kim2021()
P = 34.5e3
column = muscle.law.at(P).column
EPS_F, L = float(column.free_strain), float(column.free_length)
EI, EA = float(column.bending_stiffness), float(column.axial_stiffness)


def state_of(law, column, eps):
    push, (deflection, moment) = law.push(column, eps), law.bow(column, eps)
    return SimpleNamespace(**push._asdict(), deflection=deflection, moment=moment)


def buckled(eps):
    with np.errstate(all="ignore"):  # of branches that aren't taken
        return state_of(law, column, eps)


def test_bending_starts_as_an_axial_spring():
    # w → 1 and F'_b → k2 x: continuous with tension, with k2 = EA/L_fs
    x = 1e-7
    state = buckled(EPS_F + x / L0)
    assert_allclose(-state.bending, EA / L * x, rtol=1e-4)  # the next term is x·EA L/(EI) ~ 2e-5
    at = buckled(EPS_F)
    assert at.bending == 0 and at.deflection == 0 and at.moment == 0
    # the deflection is linear in x there, with no infinite slope
    assert_allclose(
        state.deflection / (x / L0), jax.grad(lambda e: buckled(e).deflection)(EPS_F), rtol=1e-3
    )


def test_a_stiff_axis_keeps_its_length():
    # with EA → ∞ the law is (10) and (12), whose force is the derivative of (11)
    # the share w that remains is some 1e-8, and rounding takes 1e-16 of 1 off it
    rigid = eqx.tree_at(lambda c: c.axial_stiffness, column, jnp.asarray(1e8 * EA))
    for strain in (0.1, 0.3):
        x = (strain - EPS_F) * L0
        state = state_of(law, rigid, strain)

        def energy(x):  # (6) with (8) and (10)
            chord, top = L - x, math.sqrt(4 * x * (L - x)) / math.pi

            def curvature(z):
                return top / 2 * (2 * math.pi / chord) ** 2 * math.cos(2 * math.pi * z / chord)

            return quad(lambda z: EI / 2 * curvature(z) ** 2, 0, chord, epsabs=0, epsrel=1e-12)[0]

        step = 1e-6
        F_b = (energy(x + step) - energy(x - step)) / (2 * step)
        assert_allclose(-state.bending, F_b, rtol=1e-7)
        assert_allclose(state.deflection, math.sqrt(4 * x * (L - x)) / math.pi, rtol=1e-7)
        assert_allclose(state.arc_strain, EPS_F, rtol=1e-7)


@pytest.mark.parametrize("what", ["bending", "moment"])
def test_first_and_second_derivative_in_strain(what):
    # fourth-order differences of steps of 1e-4: good to 1e-10
    def value(eps):
        return getattr(buckled(eps), what)

    step = 1e-4
    for function in (value, jax.jit(jax.grad(value))):
        near = function(0.2 + step) - function(0.2 - step)
        far = function(0.2 + 2 * step) - function(0.2 - 2 * step)
        assert_allclose(jax.jit(jax.grad(function))(0.2), (8 * near - far) / (12 * step), rtol=1e-8)


def test_shape_is_the_first_mode_and_keeps_its_arc_to_second_order():
    strains = np.array([0.07, 0.12, 0.4])
    line, state = law.shape(column, strains, 201), buckled(strains)
    z, y = np.asarray(line.z), np.asarray(line.y)
    assert z.shape == y.shape == (3, 201)
    top, chord = np.asarray(state.deflection)[:, None], z[:, -1:]
    assert_allclose(chord[:, 0], L0 * (1 - strains), rtol=1e-14)
    assert_allclose(y, top / 2 * (np.cos(2 * np.pi * z / chord) - 1), atol=1e-15)
    # a trapezoid sum of a full period of sin² is exact: chord + ½∫y'² = L_fs − 2l
    slope = -np.pi * top / chord * np.sin(2 * np.pi * z / chord)
    shortening = 0.5 * np.trapezoid(slope**2, z, axis=1)
    assert_allclose(chord[:, 0] + shortening, L0 * (1 - np.asarray(state.arc_strain)), rtol=1e-12)


@pytest.mark.parametrize("slender", [10.0, 100.0, 1e3, 1e5])  # as above
def test_moment_has_one_peak(slender):
    # the collapse strain is bracketed by it; xi alone counts, and the one slenderness
    xi = jnp.linspace(0, 1 - 1e-6, 2001)
    heights = np.asarray(xi * jnp.sqrt(bow_ratio(slender / (4 * np.pi**2), xi) / (1 - xi) ** 3))
    rising = np.diff(heights) > 0
    assert rising[0] and np.count_nonzero(rising[1:] != rising[:-1]) == 1

"""Work and energy: each force against its own potential, integrated independently."""

import math
import warnings

import attrs
import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipe, ellipj, ellipk

import fascicle as fs
from fascicle.muscle.tension import TENSION_LAWS, Kothera2009


NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)


def integral(values, low, high):
    """Gauss-Legendre over the last axis, of values at the nodes between low and high."""
    return np.sum(np.asarray(values) * WEIGHTS, axis=-1) * (high - low) / 2


def nodes(low, high):
    return (low + high)[..., None] / 2 + (high - low)[..., None] / 2 * NODES


def at(muscles, pressure, strain=None):
    """Response at strains [-], a row for each muscle; without them the free strains [-]."""
    with np.errstate(all="ignore"):  # of branches that aren't taken
        if strain is None:
            return muscles.law.at(np.asarray(pressure)).kinks[0]
        rows = jax.tree.map(lambda x: np.asarray(x)[:, None], muscles)
        return rows.law.at(np.asarray(pressure)).response(strain)


LAWS = [*(law() for law in TENSION_LAWS.values()), Kothera2009("ideal")]


@pytest.mark.parametrize("tension", LAWS, ids=lambda law: law.name)
@pytest.mark.filterwarnings("ignore:.* was fitted to")  # here to any muscle
def test_mesh_works_as_much_as_the_pressure_does_if_a_law_says_so(tension, random_muscles):
    # off the defaults, at which some corrections are none
    scales = {one.name: one.transform for one in tension.constants() if one.transform}
    moved = {k: s.value(s.coordinate(getattr(tension, k)) + 0.2) for k, s in scales.items()}
    muscles = random_muscles(21, 300, tension=attrs.evolve(tension, **moved))
    low, high = np.full(300, -0.05), at(muscles, 3e5)
    work = integral(at(muscles, 3e5, nodes(low, high)).mesh, low, high) * muscles.length
    swept = muscles.volume(high) - muscles.volume(low)
    # the integrand of the first is a parabola, exact but for rounding
    assert tension.conservative == np.allclose(work, 3e5 * swept, rtol=1e-12, atol=0)


def test_bladder_stores_the_work_done_on_it(random_muscles):
    muscles = random_muscles(22, 300)
    # down to half the stretch that straightens the fibers, up to the free strain
    low = np.asarray(0.5 * (1 - 1 / np.cos(muscles.braid_angle)))
    high = at(muscles, 1e6)
    work = -integral(at(muscles, 1e6, nodes(low, high)).bladder, low, high) * muscles.length
    energy = muscles.bladder.energy(low)
    stored = muscles.bladder.energy(high) - energy
    # the two ends may nearly cancel: of the larger
    assert np.all(np.abs(work - stored) < 1e-11 * (np.abs(work) + energy))
    assert np.all(energy > 0)


class Potential:
    """Total energy Π(ε) of a muscle as `elastica` sees it, from SciPy and the equations alone."""

    def __init__(self, muscle, pressure):
        number = lambda x: float(np.asarray(x))  # noqa: E731
        self.L0, self.r0 = number(muscle.length), number(muscle.outer_radius)
        self.t0, self.a = number(muscle.wall_thickness), number(muscle.braid_angle)
        self.c10, self.c01 = number(muscle.material.c10), number(muscle.material.c01)
        ri = self.r0 - self.t0
        self.A = math.pi * (self.r0**2 - ri**2)
        self.EI = number(muscle.material.youngs_modulus) * math.pi / 4 * (self.r0**4 - ri**4)
        self.P = pressure
        self.free = brentq(self.slack, -0.01, 0.8, xtol=1e-15)
        self.L_fs = self.L0 * (1 - self.free)

    def stored(self, eps):
        """Energy of wall and pressure at a strain of the axis: V_b W − P V."""
        lam, c, s = 1 - eps, math.cos(self.a), math.sin(self.a)
        p, q = lam**2, (1 - c**2 * lam**2) / s**2
        I1, I2 = p + q + 1 / (p * q), 1 / p + 1 / q + p * q
        wall = self.A * self.L0 * (self.c10 * (I1 - 3) + self.c01 * (I2 - 3))
        return wall - self.P * math.pi * self.r0**2 * q * self.L0 * lam

    def slack(self, eps):
        """Its slope in strain: −L0 T."""
        step = 1e-5  # a fourth-order difference: good to 1e-13
        f = self.stored
        near, far = f(eps + step) - f(eps - step), f(eps + 2 * step) - f(eps - 2 * step)
        return (8 * near - far) / (12 * step)

    def bending(self, chord):
        """∫ EI/2 κ² of an elastica with ends `chord` of its length apart, by quadrature."""
        if chord >= 1:
            return 0.0
        m = brentq(lambda m: 2 * ellipe(m) / ellipk(m) - 1 - chord, 0, 0.83, xtol=1e-16)
        K = ellipk(m)
        turn = quad(lambda t: (8 * math.sqrt(m) * K * ellipj(4 * K * t, m)[1]) ** 2, 0, 0.25)[0]
        return self.EI / (2 * self.L_fs) * 4 * turn

    def total(self, eps):
        """Π where it is least over the arc's strain."""

        def energy(arc):
            return self.stored(arc) + self.bending((1 - eps) / (1 - arc))

        return minimize_scalar(
            energy, bounds=(self.free, eps), method="bounded", options={"xatol": 1e-9}
        ).fun


@pytest.mark.parametrize("pressure", [0.0, 30e3, 300e3])
def test_elastica_force_is_the_derivative_of_its_energy(pressure, random_muscles):
    laws = {"buckling": "elastica", "collapse": fs.muscle.collapse.Kim2021Collapse(factor=1e4)}
    muscles = random_muscles(23, 12, **laws)
    # slender, so that the least energy is the only stationary one
    slender = np.asarray(muscles.length / muscles.outer_radius) > 12
    assert slender.sum() >= 6
    for share in (0.15, 0.6):
        free = at(muscles, pressure)
        eps = free + share * (0.6 - free)
        force = at(muscles, pressure, eps[:, None]).force[:, 0]
        for i in np.flatnonzero(slender)[:5]:
            muscle = jax.tree.map(lambda leaf, i=i: leaf[i], muscles)
            potential = Potential(muscle, pressure)
            assert_allclose(potential.free, free[i], atol=1e-9)
            step = 1e-4
            e = float(eps[i])
            near = potential.total(e + step) - potential.total(e - step)
            far = potential.total(e + 2 * step) - potential.total(e - 2 * step)
            slope = (8 * near - far) / (12 * step * potential.L0)
            # the minimum is good to 1e-14 J of 1e-1 J, over steps of 1e-4 × 0.1 m: 1e-6 N or so
            assert_allclose(force[i], -slope, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("tension", ["klute_hannaford", Kothera2009(), Kothera2009("ideal")])
def test_free_strain_rises_with_pressure(tension, random_muscles):
    muscles = random_muscles(24, 500, tension=tension)
    P = np.concatenate([[0.0], np.geomspace(1, 1e6, 40)])
    free = np.stack([at(muscles, one) for one in P], axis=1)
    assert np.all(free[:, 0] == 0) and np.all(np.diff(free, axis=1) > 0)
    # from below to the mesh's own; the pressure on a smaller bore alone would go further
    if not muscles.tension.conservative:
        return
    assert np.all(free[:, -1] < muscles.braid.ideal_free_strain)


@pytest.mark.parametrize(("degrees", "falls"), [(6, True), (12, False), (20, False)])
def test_free_strain_may_fall_again_where_fibers_are_nearly_straight(degrees, falls):
    rng, P, seen = np.random.default_rng(0), np.geomspace(1, 1e6, 60), 0
    for _ in range(60):
        wall, c10, c01 = (
            rng.uniform(0.05, 0.6),
            10 ** rng.uniform(4, 6.3),
            10 ** rng.uniform(3, 6.3),
        )
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".* is unusual")
            muscle = fs.Muscle(
                0.127, 6e-3, 6e-3 * wall, math.radians(degrees), fs.MooneyRivlin(c10, c01)
            )
        seen += bool(np.any(np.diff(muscle.free_strain(P)) < 0))
    assert (seen > 0) == falls


# one compiled function for each law; the dimensions are arguments, as for a user's sweep
def one_muscle(buckling):
    @jax.jit
    def ask(length, radius, wall, angle, pressure, strain):
        muscle = fs.Muscle(
            length, radius, wall * radius, angle, "silicone_kim2021", buckling=buckling
        )
        slopes = jax.grad(muscle.force, (0, 1))(pressure, strain)
        return muscle.response(pressure, strain), muscle.free_strain(pressure), slopes

    return ask


asked = {name: one_muscle(name) for name in ("kim2021", "elastica")}


@pytest.mark.parametrize("buckling", ["kim2021", pytest.param("elastica", marks=pytest.mark.slow)])
@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    radius=st.floats(3e-3, 15e-3),
    wall=st.floats(0.12, 0.35),
    length=st.floats(60e-3, 400e-3),
    degrees=st.floats(20, 42),
    pressure=st.floats(0, 1e6),
    share=st.floats(1e-6, 1),
)
def test_any_muscle_resists_past_its_free_strain(
    buckling, radius, wall, length, degrees, pressure, share
):
    low = 1 - 1 / math.cos(math.radians(degrees))
    strain = min(low + share * (0.6 - low), 0.6)
    sizes = (length, radius, wall, math.radians(degrees))
    response, free, slopes = asked[buckling](*sizes, pressure, strain)
    force = float(response.force)
    assert math.isfinite(force) and all(map(math.isfinite, slopes))
    assert force <= 0 if strain > free else force >= -1e-9
    parts = float(response.mesh + response.bladder + response.bending)
    assert math.isclose(parts, force, rel_tol=1e-12, abs_tol=1e-9)
    assert int(response.region) in {0, 1, 2, 3} and (int(response.region) == 0) == (strain <= free)


def test_stretched_muscles_have_finite_slopes():
    def slope(length, radius, angle, pressure, strain):
        muscle = fs.Muscle(
            length, radius, 0.2 * radius, angle, "silicone_kim2021", buckling="elastica"
        )
        return jax.grad(muscle.force)(pressure, strain)

    # straight at its free strain, an arc has a chord of 0 in some muscles, by rounding
    rng, n = np.random.default_rng(4), 3000
    angle = np.radians(rng.uniform(20, 42, n))
    sizes = rng.uniform(0.06, 0.4, n), rng.uniform(3e-3, 15e-3, n)
    pressure = rng.uniform(0, 1e6, n)
    strain = rng.uniform(0, 1, n) * (1 - 1 / np.cos(angle))
    slopes = jax.jit(jax.vmap(slope))(*sizes, angle, pressure, strain)
    assert np.all(np.isfinite(slopes))

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.buckling import BUCKLING_LAWS, Kim2021
from fascicle.muscle.collapse import Wood1958
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS, Derived
from fascicle.muscle.tension import Ideal


ANGLE = math.radians(33)
SIZES = {"length": 0.127, "outer_radius": 6.35e-3, "wall_thickness": 1.6e-3, "braid_angle": ANGLE}
LOWEST = 1 - 1 / math.cos(ANGLE)
table = fs.Muscle(**SIZES, material=fs.MooneyRivlin(118.4e3, 105.7e3, 1.78e6))
latex = fs.Muscle(**SIZES)
P, EPS = np.array([[0.0], [34.5e3], [137.9e3]]), np.linspace(0, 0.33, 12)


def test_plain_numbers_and_arrays_agree():
    one = table.force(34500, 0)
    assert one.shape == () and one.dtype == jnp.float64
    assert_allclose(one, 16.36, atol=5e-3)
    rows = table.force(P, EPS)
    for pressure, strain in [(P.tolist(), EPS.tolist()), (jnp.asarray(P), jnp.asarray(EPS))]:
        # a compiler orders sums otherwise: parts of some 100 N cancel
        assert_allclose(table.force(pressure, strain), rows, rtol=1e-12, atol=1e-12)
    single = table.force(np.float32(34.5e3), np.float32(0.25))  # float32 comes in exactly
    assert_allclose(single, table.force(34.5e3, 0.25), rtol=1e-14)


def test_broadcasting():
    shapes = [((3, 1), (4,), (3, 4)), ((), (4,), (4,)), ((2,), (), (2,)), ((0,), (), (0,))]
    for p, e, both in shapes:
        assert table.force(np.full(p, 1e5), np.full(e, 0.1)).shape == both
    with pytest.raises((ValueError, TypeError)):
        table.force(np.zeros(3), np.zeros(4))


def test_inside_jit_vmap_and_grad():
    expected = np.asarray(table.force(P, EPS))
    assert_allclose(jax.jit(table.force)(P, EPS), expected, rtol=1e-12, atol=1e-12)
    each = jax.jit(jax.vmap(jax.vmap(table.force, (None, 0)), (0, None)))(P[:, 0], EPS)
    assert_allclose(each, expected, rtol=1e-12, atol=1e-12)
    passed = eqx.filter_jit(lambda m, P, e: m.force(P, e))(table, P, EPS)
    assert_allclose(passed, expected, rtol=1e-12, atol=1e-12)


def test_a_stack_of_muscles():
    def made(length):
        return fs.Muscle(**SIZES | {"length": length})

    lengths = np.array([0.1, 0.127, 0.3])
    forces = jax.jit(jax.vmap(lambda m: m.force(34.5e3, 0.1)))(jax.vmap(made)(lengths))
    assert_allclose(forces, [made(L).force(34.5e3, 0.1) for L in lengths], rtol=1e-12)
    traced = jax.jit(jax.vmap(lambda L: made(L).force(34.5e3, 0.1)))(lengths)
    assert_allclose(forces, traced, rtol=1e-12)


@pytest.mark.parametrize("strain", [0.01, 0.1, 0.25])  # one in each region at 34.5 kPa
def test_gradients(strain):
    def force(kilopascal, strain, radius):
        moved = eqx.tree_at(lambda m: m.outer_radius, table, radius / 1e3)
        return moved.force(1e3 * kilopascal, strain)

    # of central differences, with steps scaled to kPa and mm
    check_grads(force, (34.5, strain, 6.35), order=1, modes="rev", rtol=1e-5)


def test_blocked_force_and_free_strain_are_the_ends_of_the_pull():
    # without pressure Sárosi's law has its free strain before rest length
    sarosi = fs.example("kim2021_figure_6").replace(tension="sarosi_10")
    for muscle in (table, sarosi):
        assert_allclose(muscle.blocked_force(P), muscle.force(P, 0.0), rtol=1e-14)
    assert_allclose(table.force(P, table.free_strain(P)), 0, atol=1e-10)
    assert table.force(0.0, 0.0) == 0


def test_a_stretched_muscle_pulls_without_pressure():
    eps = np.linspace(LOWEST * 0.99, -0.01, 12)
    force = np.asarray(table.force(0.0, eps))
    assert np.all(force > 0) and np.all(np.diff(force) < 0)


def test_volume_radius_and_slenderness():
    eps = np.array([-0.1, 0.0, 0.3])
    lam = 1 - eps
    assert table.slenderness == 10  # [R15]
    r = 6.35e-3 * np.sqrt(1 - math.cos(ANGLE) ** 2 * lam**2) / math.sin(ANGLE)
    assert_allclose(table.radius(eps), r, rtol=1e-13)
    # the bladder's own volume is not the fluid's
    solid = math.pi * 0.127 * (6.35e-3**2 - 4.75e-3**2)
    assert_allclose(table.volume(eps), math.pi * r**2 * 0.127 * lam - solid, rtol=1e-13)


def test_laws_by_name_object_or_class():
    named = fs.Muscle(**SIZES, tension="ideal", collapse="wood1958")
    made = fs.Muscle(**SIZES, tension=Ideal(), collapse=Wood1958(factor=0.5))
    assert type(named.tension) is type(made.tension)
    assert_allclose(made.collapse_moment(1e5), 0.5 * named.collapse_moment(1e5), rtol=1e-15)
    assert isinstance(named.buckling, Kim2021) and isinstance(named.post_collapse, Derived)
    silicone = fs.Muscle(**SIZES, material="silicone_kim2021")
    assert silicone.material is fs.materials.SILICONE_KIM2021


@pytest.mark.parametrize("buckling", BUCKLING_LAWS)
@pytest.mark.parametrize("law", POST_COLLAPSE_LAWS)
def test_a_shape_at_plain_numbers_is_the_arrays(buckling, law):
    muscle = latex.replace(braid_angle=math.radians(24), buckling=buckling, post_collapse=law)
    P, eps = np.meshgrid([0.0, 1e5], [0.0, 0.1, 0.3, 0.5])
    every = muscle.shape(P, eps, points=11)
    for place in np.ndindex(P.shape):
        one = muscle.shape(float(P[place]), float(eps[place]), points=11)
        assert one.z.shape == (11,)
        assert_allclose(one, (every.z[place], every.y[place]), atol=1e-12)


@pytest.mark.parametrize(
    ("argument", "pressure", "strain"),
    [
        ("pressure", -1.0, 0.1), ("pressure", 1.1e6, 0.1), ("pressure", math.nan, 0.1),
        ("pressure", "34.5 mm", 0.1), ("strain", 1e5, 0.61), ("strain", 1e5, LOWEST),
        ("strain", 1e5, [0.1, math.nan]),
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    "name", ["force", "response", "moment", "deflection", "shape", "conjugate_volume"]
)
def test_refuses_what_is_off_the_domain(name, argument, pressure, strain):
    with pytest.raises(fs.InvalidInputError) as error:
        getattr(latex, name)(pressure, strain)
    assert error.value.argument == argument

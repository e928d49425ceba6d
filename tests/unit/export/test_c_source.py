"""The C code, compiled as a controller's would be, gives the library's numbers."""

import ctypes
import math

import numpy as np
import pytest

import fascicle as fs
from fascicle.muscle.buckling import Kim2021
from fascicle.muscle.tension import ElasticBraid, Kothera2009, Meller2014, TonduLopez


pytest.importorskip("casadi", reason="CasADi writes the C code")
from fascicle.export import c_code, write_c


N = 10_000
TOLERANCE = 1e-10  # of a force and a newton, of slopes likewise: far below a controller's sensors
TUNED = fs.Tuning(
    [50e3, 200e3, 400e3], [1, 2, 3], [0.9, 1.1, 1.05], youngs_modulus_factor=1.2,
    hinge_stiffness_slope=1e-6, transition_rate=60.0, dead_band=10e3,
)  # fmt: skip
LAWS = {
    "kim2021": {},
    "tuned": {"tuning": TUNED},
    "kothera2009": {"tension": Kothera2009(), "collapse": "brazier1927"},
    "tondu_lopez": {"tension": TonduLopez(1.2, 0.15), "collapse": "wood1958",
                    "post_collapse": "printed"},
    "ideal": {"tension": "ideal", "collapse": "stein_hedgepeth1961", "post_collapse": "consistent"},
    "elastica": {"tension": Meller2014(1.1, 0.9), "buckling": "elastica"},
    "elastica_tuned": {"buckling": "elastica", "tuning": TUNED},
    "engesser": {"buckling": Kim2021(shear="engesser"), "tuning": TUNED},
    "elastic_braid": {"tension": ElasticBraid(1e8), "collapse": "wood1958"},
}  # fmt: skip
# half a megabyte of C each, and more with nested roots
SLOW = ("elastica", "elastica_tuned", "elastic_braid")
pytestmark = pytest.mark.filterwarnings("ignore:the tuning was measured up to")


def sample_points(muscle):
    """Random points, one in ten without pressure, and both sides of every kink."""
    rng = np.random.default_rng(1)
    P = rng.uniform(0, 1e6, N) * (rng.random(N) > 0.1)
    eps = rng.uniform(-0.19, 0.6, N)
    edge = N // 5
    free, collapse = np.asarray(muscle.free_strain(P[:edge])), muscle.collapse_strain(P[:edge])
    side = np.where(np.arange(edge) % 4 < 2, -1e-9, 1e-9)
    kink = np.where(np.arange(edge) % 2, free, np.where(np.isfinite(collapse), collapse, 0.3))
    eps[:edge] = np.clip(kink + side, -0.19, 0.6)
    return P, eps


def call(function, P, eps):
    """Force and slopes in C."""
    out = [ctypes.c_double() for _ in range(3)]
    results = np.empty((3, P.size))
    for i in range(P.size):
        point = ctypes.c_double(P[i]), ctypes.c_double(eps[i])
        assert function(*point, *map(ctypes.byref, out)) == 0
        results[:, i] = [x.value for x in out]
    return results


@pytest.mark.parametrize(
    "name", [pytest.param(key, marks=pytest.mark.slow if key in SLOW else ()) for key in LAWS]
)
def test_a_muscle_in_c_equals_the_library(name, make_muscle, compile_c, tmp_path):
    muscle = make_muscle(**LAWS[name])
    library = compile_c(write_c(muscle, tmp_path)[1], ["-O0"])
    P, eps = sample_points(muscle)
    force, _, by_strain = call(library.muscle_force, P, eps)
    expected = np.asarray(muscle.force(P, eps))
    slope = -np.asarray(muscle.stiffness(P, eps)) * float(muscle.length)
    assert np.all(np.abs(force - expected) <= TOLERANCE * (np.abs(expected) + 1))
    assert np.all(np.abs(by_strain - slope) <= TOLERANCE * (np.abs(slope) + 1))
    # by central differences, except at steps with a kink within
    h, subset = 1.0, slice(N // 5, N // 5 + 500)
    p, strain = np.clip(P[subset], 2 * h, 1e6 - h), eps[subset]
    by_pressure = call(library.muscle_force, p, strain)[1]
    ahead, middle, behind = (np.asarray(muscle.force(p + d, strain)) for d in (h, 0, -h))
    smooth = np.abs(ahead - 2 * middle + behind) < 1e-6 * (np.abs(middle) + 1)
    assert smooth.mean() > 0.9
    # of differences: rounding of 1e-14 and the third derivative
    bound = 1e-6 * (np.abs(by_pressure) + 1e-3)
    assert np.all((np.abs(by_pressure - (ahead - behind) / (2 * h)) < bound)[smooth])
    for kink in ("free_strain", "collapse_strain"):
        function = getattr(library, f"muscle_{kink}")
        function.restype = ctypes.c_double
        strains = [function(ctypes.c_double(p)) for p in P[:200]]
        np.testing.assert_allclose(strains, getattr(muscle, kink)(P[:200]), rtol=1e-12, atol=1e-15)


def test_outside_of_the_domain_it_returns_1(make_muscle, compile_c, tmp_path):
    library = compile_c(write_c(make_muscle(), tmp_path)[1], ["-O0"])
    for P, eps in ((-1.0, 0.1), (2e6, 0.1), (1e5, 0.61), (1e5, -0.3), (math.nan, 0.1)):
        force = ctypes.c_double(1.0)
        point = ctypes.c_double(P), ctypes.c_double(eps)
        assert library.muscle_force(*point, ctypes.byref(force), None, None) == 1
        assert math.isnan(force.value)


@pytest.mark.parametrize("plates", [pytest.param(None, marks=pytest.mark.slow), 0.13])
def test_a_bundle_in_c_equals_the_library(plates, make_muscle, compile_c, tmp_path):
    plain, tuned = make_muscle(), make_muscle(tuning=TUNED)
    larger = fs.Muscle.from_dimensions(0.135, 9e-3, 2.25e-3, math.radians(28))
    third = fs.MotorUnit(plain if plates is None else larger, 2)
    units = [fs.MotorUnit(plain, 1), fs.MotorUnit(tuned, 3), third]
    bundle = fs.Bundle(units, supply_pressure=4e5, length=plates)
    library = compile_c(write_c(bundle, tmp_path, "knee")[1], ["-O0"])
    array = ctypes.c_double * len(units)
    rng = np.random.default_rng(2)
    P = rng.uniform(0, 1e6, (N, 3)) * (rng.random((N, 3)) > 0.2)
    eps = rng.uniform(-0.1, 0.5, N)
    force, slope, by_pressure = ctypes.c_double(), ctypes.c_double(), array()
    results = np.empty((N, 2))
    for i in range(N):
        out = ctypes.byref(force), by_pressure, ctypes.byref(slope)
        assert library.knee_force(array(*P[i]), ctypes.c_double(eps[i]), *out) == 0
        results[i] = force.value, slope.value
    expected = np.asarray(bundle.force(P, eps))
    assert np.all(np.abs(results[:, 0] - expected) <= TOLERANCE * (np.abs(expected) + 1))
    h = 1e-7
    rise = (np.asarray(bundle.force(P, eps + h)) - np.asarray(bundle.force(P, eps - h))) / (2 * h)
    # the median: a few steps have a kink within
    assert np.median(np.abs(results[:, 1] - rise) / (np.abs(rise) + 1)) < 1e-7
    library.knee_free_strain.restype = ctypes.c_double
    strains = [library.knee_free_strain(array(*row)) for row in P[:1000]]
    np.testing.assert_allclose(
        strains, np.asarray(bundle.free_strain(P[:1000])), rtol=0, atol=1e-10
    )


def test_laws_without_c_are_refused(make_muscle):
    with pytest.raises(fs.InvalidInputError) as error:
        c_code(make_muscle(), "2 muscles")
    assert error.value.argument == "name"
    rows = fs.Muscle.from_dimensions(np.array([0.1, 0.2]), 6.35e-3, 1.6e-3, math.radians(33))
    with pytest.raises(fs.InvalidInputError) as error:
        c_code(rows)
    assert error.value.argument == "target"

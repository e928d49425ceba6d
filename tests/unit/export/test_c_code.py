"""The C that is written, compiled as a controller's would be, gives the library's numbers."""

import ctypes
import math
import shutil
import subprocess

import numpy as np
import pytest

import fascicle as fs
from fascicle.bundle import Bundle, MotorUnit
from fascicle.muscle.buckling import Kim2021
from fascicle.muscle.tension import ElasticBraid, Kothera2009, Meller2014, TonduLopez


ca = pytest.importorskip("casadi", reason="C is written by CasADi, which isn't here")
from fascicle.export import c_code, write_c  # noqa: E402 needs what was just looked for


COMPILER = shutil.which("gcc")
compiled = pytest.mark.skipif(COMPILER is None, reason="no gcc here to compile C with")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O0")
N = 10_000
# the bound for controllers: 1e-10 of a force and a newton, of slopes likewise
NEAR = 1e-10
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
# half a megabyte of C each, and more where a root lies in a root
SLOW = ("elastica", "elastica_tuned", "elastic_braid")


def muscle(**laws):
    return fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(33), **laws)


def library(target, folder, name="muscle"):
    """The C code as a shared library, which must pass without a warning."""
    _, source = write_c(target, folder, name)
    built = folder / f"{name}.so"
    command = [COMPILER, *STRICT, "-shared", "-fPIC", "-o", built, source, "-lm"]
    made = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert made.returncode == 0, made.stderr[:1000]
    return ctypes.CDLL(str(built))


def points(made, count=N):
    """Random points, one in ten without pressure, and both sides of every kink."""
    rng = np.random.default_rng(1)
    P = rng.uniform(0, 1e6, count) * (rng.random(count) > 0.1)
    eps = rng.uniform(-0.19, 0.6, count)
    edge = count // 5
    free, collapse = (
        np.asarray(kink(P[:edge])) for kink in (made.free_strain, made.collapse_strain)
    )
    side = np.where(np.arange(edge) % 4 < 2, -1e-9, 1e-9)
    kink = np.where(np.arange(edge) % 2, free, np.where(np.isfinite(collapse), collapse, 0.3))
    eps[:edge] = np.clip(kink + side, -0.19, 0.6)
    return P, eps


def called(function, P, eps):
    out = [ctypes.c_double() for _ in range(3)]
    got = np.empty((3, P.size))
    for i in range(P.size):
        assert (
            function(ctypes.c_double(P[i]), ctypes.c_double(eps[i]), *map(ctypes.byref, out)) == 0
        )
        got[:, i] = [one.value for one in out]
    return got


@compiled
@pytest.mark.filterwarnings("ignore:the tuning was measured up to")
@pytest.mark.parametrize(
    "name", [pytest.param(key, marks=pytest.mark.slow if key in SLOW else ()) for key in LAWS]
)
def test_a_muscle_in_c_gives_the_librarys_numbers(name, tmp_path):
    made = muscle(**LAWS[name])
    lib = library(made, tmp_path)
    P, eps = points(made)
    force, by_pressure, by_strain = called(lib.muscle_force, P, eps)
    expected = np.asarray(made.force(P, eps))
    slope = -np.asarray(made.stiffness(P, eps)) * float(made.length)
    assert np.all(np.abs(force - expected) <= NEAR * (np.abs(expected) + 1))
    assert np.all(np.abs(by_strain - slope) <= NEAR * (np.abs(slope) + 1))
    # by central differences where nothing has a kink within the step
    h, few = 1.0, slice(N // 5, N // 5 + 500)
    p = np.clip(P[few], 2 * h, 1e6 - h)
    there = called(lib.muscle_force, p, eps[few])
    ahead, behind = (np.asarray(made.force(p + d, eps[few])) for d in (h, -h))
    middle = np.asarray(made.force(p, eps[few]))
    smooth = np.abs(ahead - 2 * middle + behind) < 1e-6 * (np.abs(middle) + 1)
    assert smooth.mean() > 0.9
    # of differences: rounding of 1e-14 and the third derivative
    near = 1e-6 * (np.abs(there[1]) + 1e-3)
    assert np.all(np.abs(there[1] - (ahead - behind) / (2 * h))[smooth] < near[smooth])
    for kink in ("free_strain", "collapse_strain"):
        of = getattr(lib, f"muscle_{kink}")
        of.restype = ctypes.c_double
        found = [of(ctypes.c_double(p)) for p in P[:200]]
        np.testing.assert_allclose(found, getattr(made, kink)(P[:200]), rtol=1e-12, atol=1e-15)
    assert by_pressure.shape == (N,)


@compiled
def test_outside_of_the_domain_it_says_so(tmp_path):
    lib = library(muscle(), tmp_path)
    force = ctypes.c_double(1.0)
    for P, eps in ((-1.0, 0.1), (2e6, 0.1), (1e5, 0.61), (1e5, -0.3), (math.nan, 0.1)):
        force.value = 1.0
        code = lib.muscle_force(
            ctypes.c_double(P), ctypes.c_double(eps), ctypes.byref(force), None, None
        )
        assert code == 1 and math.isnan(force.value)


@compiled
@pytest.mark.filterwarnings("ignore:the tuning was measured up to")
@pytest.mark.parametrize("plates", [pytest.param(None, marks=pytest.mark.slow), 0.13])
def test_a_bundle_in_c_gives_the_librarys_numbers(plates, tmp_path):
    few, many = muscle(), muscle(tuning=TUNED)
    other = fs.Muscle.from_dimensions(0.135, 9e-3, 2.25e-3, math.radians(28))
    units = [MotorUnit(few, 1), MotorUnit(many, 3)]
    units += [MotorUnit(few, 2)] if plates is None else [MotorUnit(other, 2)]
    bundle = Bundle(units, supply_pressure=4e5, length=plates)
    lib = library(bundle, tmp_path, "knee")
    array = ctypes.c_double * len(units)
    rng = np.random.default_rng(2)
    P = rng.uniform(0, 1e6, (N, 3)) * (rng.random((N, 3)) > 0.2)
    eps = rng.uniform(-0.1, 0.5, N)
    force, slope, each = ctypes.c_double(), ctypes.c_double(), array()
    got = np.empty((N, 5))
    for i in range(N):
        strain = ctypes.c_double(eps[i])
        refs = ctypes.byref(force), each, ctypes.byref(slope)
        assert lib.knee_force(array(*P[i]), strain, *refs) == 0
        got[i] = (force.value, slope.value, *each)
    expected = np.asarray(bundle.force(P, eps))
    assert np.all(np.abs(got[:, 0] - expected) <= NEAR * (np.abs(expected) + 1))
    h = 1e-7
    rise = (np.asarray(bundle.force(P, eps + h)) - np.asarray(bundle.force(P, eps - h))) / (2 * h)
    # but for steps that have a kink within: few
    assert np.median(np.abs(got[:, 1] - rise) / (np.abs(rise) + 1)) < 1e-7
    lib.knee_free_strain.restype = ctypes.c_double
    some = P[:1000]
    found = [lib.knee_free_strain(array(*row)) for row in some]
    np.testing.assert_allclose(found, np.asarray(bundle.free_strain(some)), rtol=0, atol=1e-10)


def test_what_has_no_c_is_refused():
    with pytest.raises(ValueError, match="`name` must be a name in C"):
        c_code(muscle(), "2 muscles")
    rows = fs.Muscle.from_dimensions(np.array([0.1, 0.2]), 6.35e-3, 1.6e-3, math.radians(33))
    with pytest.raises(ValueError, match="must hold numbers, one for each size"):
        c_code(rows)

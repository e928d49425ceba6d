"""The table in C gives the numbers of the table's own polynomial, and says how far that is off."""

import ctypes
import math
import re

import numpy as np
import pytest

import fascicle as fs
from fascicle.export import table_code, write_table
from fascicle.muscle.surface import UnitSurface


TOP = 413.7e3
SHAPE = (17, 21)
# both evaluate one polynomial, whose co-energy of some 10 J is rounded at 1e-16 and divided by a
# cell's length of a millimeter
NEAR = 1e-12


def muscle(**laws):
    return fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(33), **laws)


def bicubic(table, P, eps):
    """Force [N] and volume [m³] of one muscle at one point, straight from (V3)."""
    c = table.coefficients
    lines, columns = c.shape[:2]
    h, (low, high) = float(table.root_step), map(float, table.strains)
    step = (high - low) / columns
    below, P = min(P, 0.0), max(P, 0.0)
    i = min(int(math.sqrt(P) / h), lines - 1)
    j = min(int((eps - low) / step), columns - 1)
    w = (eps - low) / step - j
    if i == 0:
        u, u_P = P / h**2, 1 / h**2
    else:
        u, u_P = math.sqrt(P) / h - i, 1 / (2 * math.sqrt(P) * h)
    F = V = V_w = 0.0
    for a in range(4):
        for b in range(4):
            F += c[i, j, a, b] * u**a * (b * w ** (b - 1) if b else 0.0)
            V += c[i, j, a, b] * (a * u ** (a - 1) if a else 0.0) * u_P * w**b
            if a and b:
                V_w += c[i, j, a, b] * a * u ** (a - 1) * u_P * b * w ** (b - 1)
    return (F + V_w * below) / (step * float(table.rest_length)), V


@pytest.fixture
def built(compiled, tmp_path):
    """The C of a target as a shared library."""

    def of(target, name="muscle", flags=("-O2",), **how):
        return compiled(write_table(target, tmp_path, name, **how)[1], flags)

    return of


def called(lib, name, units, P, eps, kind=ctypes.c_double):
    """Force, its slopes and volumes at each row of pressures."""
    array = kind * units
    force, slope, by, volumes = kind(), kind(), array(), array()
    force_at, volume_at = getattr(lib, f"{name}_force"), getattr(lib, f"{name}_volume")
    rows = []
    for row, strain in zip(P, eps, strict=True):
        at = array(*row)
        assert force_at(at, kind(strain), ctypes.byref(force), by, ctypes.byref(slope)) == 0
        assert volume_at(at, kind(strain), volumes) == 0
        rows.append([force.value, slope.value, *by, *volumes])
    return np.array(rows).T


def points(table, count=2000):
    """Random ones, in the first line and below no pressure, and on nodes and ends."""
    rng = np.random.default_rng(3)
    low, high = map(float, table.strains)
    P, eps = rng.uniform(0, TOP, count), rng.uniform(low, high, count)
    P[:200] = rng.uniform(0, 1.5 * float(table.root_step) ** 2, 200)
    P[200:300] = rng.uniform(-101325, 0, 100)
    lines = table.coefficients.shape[0]
    P[300:360] = (float(table.root_step) * rng.integers(0, lines, 60)) ** 2
    eps[360:420] = np.linspace(low, high, table.coefficients.shape[1] + 1)[rng.integers(0, 20, 60)]
    P[420:424], eps[420:424] = [0, 0, TOP, TOP], [low, high, low, high]
    return P, eps


@pytest.mark.parametrize("laws", [{}, {"tension": "ideal", "collapse": "wood1958"}])
def test_a_muscles_table_in_c_is_its_polynomial(laws, built):
    made = muscle(**laws)
    table = UnitSurface.tabulate(made, TOP, shape=SHAPE)
    P, eps = points(table)
    lib = built(made, highest_pressure=TOP, shape=SHAPE)
    force, slope, by_pressure, volume = called(lib, "muscle", 1, P[:, None], eps)
    expected = np.array([bicubic(table, *at) for at in zip(P, eps, strict=True)]).T
    assert np.all(np.abs(force - expected[0]) <= NEAR * (np.abs(expected[0]) + 1))
    rest = float(made.volume(0.0))  # at far stretches less than nothing is left in the bladder
    assert np.all(np.abs(volume - expected[1]) <= NEAR * rest)
    python = table.at(P, eps)
    assert np.all(np.abs(force - python.force) <= NEAR * (np.abs(python.force) + 1))
    assert np.all(np.abs(volume - python.volume) <= NEAR * rest)
    # slopes are of a cell's size more rounded; at its ends they jump
    inside = np.ones(len(P), bool)
    inside[300:424] = False
    for got, of in ((slope, python.force_by_strain), (by_pressure, python.force_by_pressure)):
        scale = np.max(np.abs(of))
        assert np.all(np.abs(got - of)[inside] <= 1e-11 * scale)


@pytest.mark.parametrize("plates", [None, 0.13])
def test_a_bundles_table_in_c_is_that_of_its_units(plates, built):
    few, other = muscle(), fs.Muscle.from_dimensions(0.135, 9e-3, 2.25e-3, math.radians(28))
    units = [fs.MotorUnit(few, 1), fs.MotorUnit(few, 3)]
    units += [] if plates is None else [fs.MotorUnit(other, 2)]
    bundle = fs.Bundle(units, supply_pressure=TOP, length=plates)
    lib = built(bundle, "knee", shape=SHAPE)
    rng = np.random.default_rng(5)
    P, eps = rng.uniform(-1e4, TOP, (500, len(units))), rng.uniform(-0.05, 0.3, 500)
    got = called(lib, "knee", len(units), P, eps)
    tables = [UnitSurface.tabulate(unit.muscle, TOP, shape=SHAPE) for unit in units]
    force = np.zeros(500)
    for i, unit in enumerate(units):
        ratio = float(bundle.length) / float(unit.muscle.length)
        at = tables[i].at(P[:, i], 1 - ratio * (1 - eps))
        force += int(unit.count) * at.force
        volume = int(unit.count) * at.volume
        assert np.all(np.abs(got[2 + len(units) + i] - volume) <= NEAR * volume)
    assert np.all(np.abs(got[0] - force) <= NEAR * (np.abs(force) + 1))


def test_single_precision_is_off_by_no_more_than_its_header_says(built):
    made = muscle()
    header, source = table_code(made, "muscle", highest_pressure=TOP, precision="float")
    rounding = float(re.search(r"rounding adds up to ([\d.e+-]+) N", header)[1])
    assert "double" not in source
    table = UnitSurface.tabulate(made, TOP, shape=(33, 41))
    P, eps = points(table)
    kept = (np.float32(P) <= np.float32(TOP) * (1 - 1e-6)) & (P > -101e3)
    low, high = map(float, table.strains)
    kept &= (eps > low + 1e-6) & (eps < high - 1e-6)
    P, eps = np.float32(P[kept]).astype(float), np.float32(eps[kept]).astype(float)
    lib = built(
        made, highest_pressure=TOP, precision="float",
        flags=("-O2", "-Wdouble-promotion", "-Wconversion"),
    )  # fmt: skip
    force, *_ = called(lib, "muscle", 1, P[:, None], eps, ctypes.c_float)
    off = np.abs(force - table.at(P, eps).force)
    assert 0 < off.max() <= rounding
    assert rounding < 50 * off.max()  # a bound that says something


def test_the_headers_error_is_the_tables():
    made = muscle()
    header, _ = table_code(made, "muscle", highest_pressure=TOP)
    table = UnitSurface.tabulate(made, TOP, shape=(65, 81))
    rng = np.random.default_rng(7)
    low, high = map(float, table.strains)
    P, eps = rng.uniform(0, TOP, 4000), rng.uniform(low, high, 4000)
    off = np.abs(table.at(P, eps).force - made.force(P, eps))
    said = [float(x) for x in re.search(
        r"force is off by ([\d.e+-]+) N .median., ([\d.e+-]+) N .99 %., ([\d.e+-]+) N", header
    ).groups()]  # fmt: skip
    # other points than those it was asked at: of the same order; printed with two digits
    assert said[0] / 5 < np.median(off) < 5 * said[0]
    assert off.max() < 3 * said[2]


def test_outside_of_the_table_it_says_so(built):
    lib = built(muscle(), highest_pressure=TOP, shape=SHAPE)
    array = ctypes.c_double * 1
    outside = (-2e5, 0.1), (2e6, 0.1), (1e5, 0.61), (1e5, -0.3), (math.nan, 0.1), (1e5, math.nan)
    for P, eps in outside:
        force, volume = ctypes.c_double(1.0), array(1.0)
        at = array(P), ctypes.c_double(eps)
        assert lib.muscle_force(*at, ctypes.byref(force), None, None) == 1
        assert math.isnan(force.value)
        assert lib.muscle_volume(*at, volume) == 1 and math.isnan(volume[0])


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"name": "2 muscles"}, "`name` must be a name in C"),
        ({"precision": "half"}, "`precision`"),
        ({"shape": (2, 9)}, "`shape` must be two whole numbers"),
        ({"highest_pressure": -1.0}, "`highest_pressure`"),
    ],
)
def test_what_can_not_be_is_refused(how, words):
    with pytest.raises(ValueError, match=words):
        table_code(muscle(), **how)

"""The table in C gives the numbers of the table's polynomial, and states its error."""

import ctypes
import math
import re

import numpy as np
import pytest

import fascicle as fs
from fascicle.export import table_code, write_table


TOP = 413.7e3
SHAPE = (17, 21)
# both evaluate one polynomial, whose co-energy of some 10 J is rounded at 1e-16 and divided by a
# cell's length of a millimeter
TOLERANCE = 1e-12


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
def build(compile_c, tmp_path):
    """The table of a target as a shared library."""

    def build_table(target, name="muscle", flags=("-O2",), **options):
        return compile_c(write_table(target, tmp_path, name, **options)[1], flags)

    return build_table


def call(library, name, units, P, eps, kind=ctypes.c_double):
    """Force, its slopes and volumes at each row of pressures."""
    array = kind * units
    force, slope, by_pressure, volumes = kind(), kind(), array(), array()
    force_at, volume_at = getattr(library, f"{name}_force"), getattr(library, f"{name}_volume")
    rows = []
    for row, strain in zip(P, eps, strict=True):
        point = array(*row), kind(strain)
        assert force_at(*point, ctypes.byref(force), by_pressure, ctypes.byref(slope)) == 0
        assert volume_at(*point, volumes) == 0
        rows.append([force.value, slope.value, *by_pressure, *volumes])
    return np.array(rows).T


def sample_points(table, count=2000):
    """Random points, in the first line and below zero pressure, and on nodes and corners."""
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
def test_a_muscle_table_in_c_equals_the_polynomial(laws, make_muscle, build):
    muscle = make_muscle(**laws)
    table = muscle.table(TOP, shape=SHAPE)
    P, eps = sample_points(table)
    library = build(muscle, highest_pressure=TOP, shape=SHAPE)
    force, slope, by_pressure, volume = call(library, "muscle", 1, P[:, None], eps)
    python = table.lookup_at(P, eps)
    largest = float(muscle.volume(0.0))  # far stretches empty the bladder
    reference = np.array([bicubic(table, *point) for point in zip(P, eps, strict=True)]).T
    for expected_force, expected_volume in (reference, (python.force, python.volume)):
        bound = TOLERANCE * (np.abs(expected_force) + 1)
        assert np.all(np.abs(force - expected_force) <= bound)
        assert np.all(np.abs(volume - expected_volume) <= TOLERANCE * largest)
    # slopes are rounded more, by a cell's size; at its ends they jump
    inside = np.ones(len(P), bool)
    inside[300:424] = False
    pairs = (slope, python.force_by_strain), (by_pressure, python.force_by_pressure)
    for value, expected in pairs:
        scale = np.max(np.abs(expected))
        assert np.all(np.abs(value - expected)[inside] <= 1e-11 * scale)


@pytest.mark.parametrize("plates", [None, 0.13])
def test_a_bundle_table_in_c_equals_the_sum_of_its_units(plates, make_muscle, build):
    larger = fs.Muscle(0.135, 9e-3, 2.25e-3, math.radians(28))
    units = [fs.MotorUnit(make_muscle(), 1), fs.MotorUnit(make_muscle(), 3)]
    units += [] if plates is None else [fs.MotorUnit(larger, 2)]
    bundle = fs.Bundle(units, supply_pressure=TOP, length=plates)
    rng = np.random.default_rng(5)
    P, eps = rng.uniform(-1e4, TOP, (500, len(units))), rng.uniform(-0.05, 0.3, 500)
    results = call(build(bundle, "knee", shape=SHAPE), "knee", len(units), P, eps)
    force = np.zeros(500)
    for i, unit in enumerate(units):
        ratio = float(bundle.length) / float(unit.muscle.length)
        table = unit.muscle.table(TOP, shape=SHAPE)
        point = table.lookup_at(P[:, i], 1 - ratio * (1 - eps))
        force += int(unit.count) * point.force
        volume = int(unit.count) * point.volume
        assert np.all(np.abs(results[2 + len(units) + i] - volume) <= TOLERANCE * volume)
    assert np.all(np.abs(results[0] - force) <= TOLERANCE * (np.abs(force) + 1))


def test_single_precision_is_off_by_no_more_than_its_header_states(make_muscle, build):
    options = {"highest_pressure": TOP, "precision": "float"}
    header, source = table_code(make_muscle(), "muscle", **options)
    rounding = float(re.search(r"rounding adds up to ([\d.e+-]+) N", header)[1])
    assert "double" not in source
    table = make_muscle().table(TOP, shape=(33, 41))
    P, eps = sample_points(table)
    low, high = map(float, table.strains)
    inside = (np.float32(P) <= np.float32(TOP) * (1 - 1e-6)) & (P > -101e3)
    inside &= (eps > low + 1e-6) & (eps < high - 1e-6)
    P, eps = np.float32(P[inside]).astype(float), np.float32(eps[inside]).astype(float)
    library = build(make_muscle(), flags=("-O2", "-Wdouble-promotion", "-Wconversion"), **options)
    force, *_ = call(library, "muscle", 1, P[:, None], eps, ctypes.c_float)
    error = np.abs(force - table.lookup_at(P, eps).force)
    assert 0 < error.max() <= rounding
    assert rounding < 50 * error.max()  # the bound is not far too large


def test_the_header_states_the_error_of_the_table(make_muscle):
    muscle = make_muscle()
    header, _ = table_code(muscle, "muscle", highest_pressure=TOP)
    table = muscle.table(TOP, shape=(65, 81))
    rng = np.random.default_rng(7)
    low, high = map(float, table.strains)
    P, eps = rng.uniform(0, TOP, 4000), rng.uniform(low, high, 4000)
    error = np.abs(table.lookup_at(P, eps).force - muscle.force(P, eps))
    pattern = r"force ([\d.e+-]+) N .median., ([\d.e+-]+) N .99th percentile., ([\d.e+-]+) N"
    median, _, largest = map(float, re.search(pattern, header).groups())
    # at other points than the header's: of the same order; printed with two digits
    assert median / 5 < np.median(error) < 5 * median
    assert error.max() < 1.1 * largest


@pytest.mark.parametrize("name", ["kim2021_bundle_1_4", "thick"])
def test_the_header_states_the_error_of_the_bundle(name):
    if name == "thick":  # its force is steepest beside the end that stretches the braid straight
        muscle = fs.Muscle(0.3, 20e-3, 2e-3, math.radians(25), "latex")
        bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)], 400e3)
    else:
        bundle = fs.example(name)
    header, _ = table_code(bundle, "knee")
    largest = float(re.search(r"All muscles together: force ([\d.e+-]+) N", header)[1])
    table = bundle.motor_units[0].muscle.table(bundle.supply_pressure, shape=(65, 81))
    rng = np.random.default_rng(7)
    supply, (low, high) = float(bundle.supply_pressure), map(float, table.strains)
    P = rng.uniform(0, supply, (40_000, 2))
    P[::2, 0] = supply  # as a state has them, the second one throttled
    P[::4, 1] = supply * rng.uniform(0, 1, 10_000) ** 4
    eps = rng.uniform(low, high, len(P))
    forces = sum(
        int(unit.count) * table.lookup_at(P[:, i], eps).force
        for i, unit in enumerate(bundle.motor_units)
    )
    error = np.abs(forces - bundle.force(P, eps)).max()
    one = np.abs(
        table.lookup_at(P[:, 1], eps).force - bundle.motor_units[0].muscle.force(P[:, 1], eps)
    )
    # the header's figure bounds it, and one muscle's doesn't
    assert one.max() < error < largest


def test_outside_of_the_table_it_returns_1(make_muscle, build):
    library = build(make_muscle(), highest_pressure=TOP, shape=SHAPE)
    array = ctypes.c_double * 1
    outside = (-2e5, 0.1), (2e6, 0.1), (1e5, 0.61), (1e5, -0.3), (math.nan, 0.1), (1e5, math.nan)
    for P, eps in outside:
        force, volume = ctypes.c_double(1.0), array(1.0)
        point = array(P), ctypes.c_double(eps)
        assert library.muscle_force(*point, ctypes.byref(force), None, None) == 1
        assert math.isnan(force.value)
        assert library.muscle_volume(*point, volume) == 1 and math.isnan(volume[0])


@pytest.mark.parametrize(
    "options",
    [{"name": "2 muscles"}, {"precision": "half"}, {"shape": (2, 9)}, {"highest_pressure": -1.0}],
)
def test_invalid_options_are_refused(options, make_muscle):
    with pytest.raises(fs.InvalidInputError) as error:
        table_code(make_muscle(), **options)
    assert error.value.argument in options

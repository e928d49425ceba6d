"""The inverse in C chooses as `recruit` does, on the table."""

import ctypes
import math
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import fascicle as fs
from fascicle.bundle.schemes import AbstractScheme, State
from fascicle.export import table_code, write_table

from .conftest import STRICT


SUPPLY = 413.7e3
SHAPE = (65, 81)
REACHED, ABOVE, BELOW, OUTSIDE = range(4)
MEETS = 2e-10  # N, in the header: a force this near to the demand meets it
ROUNDING = 1e-12  # of a sum of forces of some 100 N


class Backward(AbstractScheme):
    """The last unit first, by itself; then the first: states that aren't nested."""

    name = "backward"

    def states(self, units):
        return [State(full=(), throttled=(units - 1 - k,)) for k in range(units)]


@pytest.fixture(scope="module")
def make_bundle(make_muscle):
    """Bundles of a scheme: one muscle and four, or unlike muscles between plates."""
    larger = fs.Muscle(0.135, 9e-3, 2.25e-3, math.radians(28))

    def make(scheme="orderly", unlike=False):
        if unlike:
            units = [fs.MotorUnit(larger), fs.MotorUnit(make_muscle(), 2)]
            return fs.Bundle(units, SUPPLY, scheme=scheme, length=0.13)
        return fs.example("kim2021_bundle_1_4").replace(scheme=scheme)

    return make


def sample_demands(bundle, count, seed=1):
    """Random demands, half of them small, some of them unreachable."""
    rng = np.random.default_rng(seed)
    largest = float(bundle.force(np.full(len(bundle.motor_units), SUPPLY), 0.0))
    strain, force = rng.uniform(-0.02, 0.33, count), rng.uniform(-0.1, 1.1, count) * largest
    force[::2] = rng.uniform(-20, 30, len(force[::2]))
    force[:2], strain[:2] = 0, (0, 0.1)  # without any pressure
    return force, strain


def pressures_in_c(library, name, units, force, strain, supply=SUPPLY, kind=ctypes.c_double):
    """Status, state, reached force and pressures at each demand."""
    function, pressure = getattr(library, f"{name}_pressures"), (kind * units)()
    state, reached = ctypes.c_int(), kind()
    out = ctypes.byref(state), ctypes.byref(reached)
    force, strain = np.broadcast_arrays(force, strain)
    status, states, forces, rows = [], [], [], []
    for demand in zip(force, strain, strict=True):
        status.append(function(*map(kind, demand), kind(supply), pressure, *out))
        states.append(state.value)
        forces.append(reached.value)
        rows.append(list(pressure))
    return np.array(status), np.array(states), np.array(forces), np.array(rows)


def stated_errors(bundle):
    """99 % and largest error of the bundle's force [N], of the header."""
    pattern = r"([\d.e+-]+) N .99th percentile..*All muscles together: force ([\d.e+-]+) N"
    errors = re.search(pattern, table_code(bundle)[0], re.DOTALL)
    assert errors
    return float(errors[1]) * np.sum(bundle.counts), float(errors[2])


@pytest.mark.parametrize(
    ("scheme", "unlike", "count"),
    [("orderly", False, 10_000), ("batch", False, 2000), ("orderly", True, 2000)],
)
def test_by_the_table_it_differs_from_recruit_by_the_tables_error(
    scheme, unlike, count, make_bundle, compile_c, tmp_path
):
    """If the curve of each state is off by at most $e$, and demands less and more by $e$ have the
    same state, then this state is the table's, too; and the first crossing of the demand lies
    between those of demands less and more by $e$, if the curve doesn't begin that near to it.
    """
    bundle = make_bundle(scheme, unlike)
    library = compile_c(write_table(bundle, tmp_path, "knee")[1])
    force, strain = sample_demands(bundle, count)
    status, state, reached, P = pressures_in_c(library, "knee", 2, force, strain)
    most, largest = stated_errors(bundle)
    results = [bundle.recruit(force + e, strain) for e in (-largest, 0, largest)]
    below, expected, above = results
    decided = np.ones(count, bool)
    for result in results:
        decided &= (result.state == expected.state) & (result.status == expected.status)
    assert decided.mean() > 0.6
    np.testing.assert_array_equal(status[decided], expected.status[decided])
    met = status == REACHED
    np.testing.assert_array_equal(state[decided & met], expected.state[decided & met])
    # others are decided by far smaller errors
    assert np.mean((status == expected.status) & (state == expected.state)) > 0.995
    assert np.max(np.abs(reached - force)[met]) <= MEETS + ROUNDING * np.max(np.abs(force))
    miss = np.abs(bundle.force(P, strain) - force)[met]
    assert np.max(miss) <= largest and np.median(miss) <= most
    np.testing.assert_allclose(reached, expected.force, rtol=0, atol=2 * largest)
    low, high = (np.sort([below.pressures, above.pressures], axis=0))[:, decided & met]
    begins = bundle.force(np.where(low == P[decided & met], low, 0.0), strain[decided & met])
    clear = np.abs(begins - force[decided & met]) > largest
    inside = (P[decided & met] >= low - 1e-6) & (P[decided & met] <= high + 1e-6)
    assert clear.mean() > 0.5 and np.all(inside[clear])


@pytest.mark.parametrize("scheme", ["orderly", "batch", Backward()], ids=str)
def test_by_the_table_it_finds_the_first_pressure(scheme, make_bundle, compile_c, tmp_path):
    """Against all pressures of a fine grid, in the order of states, on the same table."""
    bundle = make_bundle(scheme)
    library = compile_c(write_table(bundle, tmp_path, "knee", shape=SHAPE)[1])
    force, strain = sample_demands(bundle, 400, seed=4)
    status, state, reached, P = pressures_in_c(library, "knee", 2, force, strain)
    table = bundle.motor_units[0].muscle.table(SUPPLY, shape=SHAPE)
    level = np.linspace(0, 1, 3001) ** 2 * SUPPLY
    counts = np.array([float(unit.count) for unit in bundle.motor_units])
    crossings = 0
    for i, (demand, eps) in enumerate(zip(force, strain, strict=True)):
        curve = table.lookup_at(level, eps + 0 * level).force
        best = None
        for k, (full, throttled) in enumerate(bundle.scheme.states(2)):
            total = sum(
                counts[u] * (curve if u in throttled else curve[-1] if u in full else curve[0])
                for u in range(2)
            )
            cost = sum(counts[u] for u in (*full, *throttled)) * max(eps, 0)
            change = np.flatnonzero(np.diff(total > demand))
            if len(change) and (best is None or cost < best[0]):
                best = cost, k, change[0], throttled
        if best is None:
            continue  # unreachable, or a crossing that the grid doesn't show
        crossings += 1
        _, k, cell, throttled = best
        assert status[i] == REACHED
        p = P[i, throttled[0]]
        if state[i] == k + 1 and level[cell] <= p <= level[cell + 1]:
            continue
        # else an earlier one is within a step of the grid: the demand is all but an extremum
        assert state[i] <= k + 1 and abs(reached[i] - demand) <= 1e-9
        near = table.lookup_at(np.array([max(p - 200, 0), p, p + 200]), np.full(3, eps)).force
        assert np.ptp(near) < 0.2
    assert crossings > 150


@pytest.mark.parametrize("supply", [1.0, 0.6])
def test_the_table_covers_the_workspace_of_unlike_units(supply, compile_c, tmp_path):
    """A unit of a wide braid stops pulling long before the other one, and resists from there on."""
    muscles = (fs.Muscle(0.13, 6e-3, 1e-3, math.radians(x)) for x in (22, 45))
    units = [fs.MotorUnit(muscle, count) for muscle, count in zip(muscles, (2, 1), strict=True)]
    bundle = fs.Bundle(units, SUPPLY)
    library = compile_c(write_table(bundle, tmp_path, "knee")[1])
    rng = np.random.default_rng(6)
    free_strain = float(bundle.free_strain([SUPPLY, SUPPLY], resistance=False))
    strain = rng.uniform(0.0, free_strain, 500)
    full = np.full(2, supply * SUPPLY)
    force = rng.uniform(0.0, 1.1, 500) * bundle.force(full, strain)
    status, _, reached, _ = pressures_in_c(library, "knee", 2, force, strain, full[0])
    expected = bundle.recruit(force, strain, full[0])
    assert np.all(status != OUTSIDE) and free_strain > 0.33
    assert np.mean(status == expected.status) > 0.99
    largest = stated_errors(bundle)[1]
    np.testing.assert_allclose(reached, expected.force, rtol=0, atol=2 * largest)


def test_units_of_free_pressures_choose_as_recruit(make_bundle, compile_c, tmp_path):
    bundle = make_bundle("free", True)
    library = compile_c(write_table(bundle, tmp_path, "knee")[1])
    force, strain = sample_demands(bundle, 2000)
    status, _, reached, P = pressures_in_c(library, "knee", 2, force, strain)
    expected = bundle.recruit(force, strain)
    largest = stated_errors(bundle)[1]
    assert np.mean(status == expected.status) > 0.995
    np.testing.assert_allclose(reached, expected.force, rtol=0, atol=2 * largest)
    assert np.max(np.abs(bundle.force(P, strain) - force)[status == REACHED]) <= largest
    same = (P > 0) == (expected.pressures > 0)  # the set of pressurized units
    assert np.mean(np.all(same, axis=1)) > 0.98


def test_single_precision_meets_demands_within_the_headers_rounding(
    make_bundle, compile_c, tmp_path
):
    bundle = make_bundle()
    paths = write_table(bundle, tmp_path, "knee", precision="float")
    stated = re.search(r"within ([\d.e+-]+) N of the\s+\* demand", paths[0].read_text())
    assert stated
    library = compile_c(paths[1], ("-O2", "-Wdouble-promotion", "-Wconversion"))
    force, strain = sample_demands(bundle, 2000)
    kind = ctypes.c_float
    status, state, reached, _ = pressures_in_c(library, "knee", 2, force, strain, SUPPLY, kind)
    expected = bundle.recruit(force, strain)
    assert np.mean((status == expected.status) & (state == expected.state)) > 0.99
    # one rounding of the search, one of the force that is reported
    assert np.max(np.abs(reached - force)[status == REACHED]) <= 2 * float(stated[1])


def test_what_is_unreachable_or_outside_has_a_status(make_bundle, compile_c, tmp_path):
    bundle = make_bundle()
    library = compile_c(write_table(bundle, tmp_path, "knee")[1], ["-O0"])

    def call(force, strain, supply=SUPPLY):
        status, state, reached, P = pressures_in_c(
            library, "knee", 2, np.array([force]), strain, supply
        )
        return status[0], state[0], reached[0], P[0]

    top = float(bundle.force([SUPPLY, SUPPLY], 0.1))
    status, state, reached, P = call(2 * top, 0.1)
    assert (status, state) == (ABOVE, 2) and list(P) == [SUPPLY, SUPPLY]
    assert reached == pytest.approx(top, rel=1e-3)  # the table's error there
    assert call(-1e4, 0.1)[0] == BELOW
    # a supply above the table's or the bundle's counts as that
    assert list(call(2 * top, 0.1, 2 * SUPPLY)[3]) == [SUPPLY, SUPPLY]
    half = call(2 * top, 0.1, SUPPLY / 2)
    assert half[0] == ABOVE and list(half[3]) == [SUPPLY / 2, SUPPLY / 2]
    outside = (50.0, 0.7), (50.0, -0.5), (math.nan, 0.1), (math.inf, 0.1), (50.0, math.nan)
    for demand in (*outside, (50.0, 0.1, 0.0), (50.0, 0.1, -1.0), (50.0, 0.1, math.nan)):
        status, state, reached, P = call(*demand)
        assert (status, state) == (OUTSIDE, 0) and math.isnan(reached) and np.all(np.isnan(P))
    # state and reached force may be left out
    pressure = (ctypes.c_double * 2)()
    demand = map(ctypes.c_double, (50.0, 0.1, SUPPLY))
    assert library.knee_pressures(*demand, pressure, None, None) == REACHED


def test_the_docs_example_compiles_and_prints_what_they_show(make_bundle, compile_c, tmp_path):
    text = (Path(__file__).parents[3] / "docs" / "export.md").read_text(encoding="utf-8")
    example = re.search(r"```c\n(.*?)```", text, re.DOTALL)
    shown = re.search(r"\$ ./pressures\n(.*?)```", text, re.DOTALL)
    assert example and shown
    source = write_table(make_bundle(), tmp_path, "arm")[1]
    compile_c(source)  # skips without gcc
    (tmp_path / "pressures.c").write_text(example[1])
    program = tmp_path / "pressures"
    command = ["gcc", *STRICT, "-O2", "-o", program, tmp_path / "pressures.c", source, "-lm"]
    subprocess.run(command, check=True)
    result = subprocess.run([program], capture_output=True, text=True, check=True)
    assert result.stdout == shown[1]
    # as Python has it
    solution = make_bundle().recruit([20.0, 150.0, 900.0], 0.1, "400 kPa")
    for line, state, P in zip(
        result.stdout.splitlines(), solution.state, solution.pressures, strict=True
    ):
        assert f"{P[0] / 1e3:3.0f} kPa, {P[1] / 1e3:3.0f} kPa, state {state}," in line


def test_the_docs_loop_in_python_gives_what_recruit_does(compile_c, tmp_path, monkeypatch):
    text = (Path(__file__).parents[3] / "docs" / "how-to" / "control-loop.md").read_text("utf-8")
    compile_c(write_table(fs.example("kim2021_figure_6"), tmp_path)[1])  # skips without gcc
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(re.search(r"```python\n(.*?)```", text, re.DOTALL)[1], names)  # noqa: S102 our own docs
    bundle = names["bundle"]
    error = stated_errors(bundle)[1]
    assert names["status"] == REACHED
    assert abs(bundle.force(list(names["pressures"]), 0.1) - 150.0) <= error

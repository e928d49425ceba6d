"""Each benchmark runs, at a size whose times mean nothing; no time is asserted."""

import importlib
import math
import sys
from pathlib import Path

import pytest


FOLDER = Path(__file__).parents[2] / "benchmarks"
# in the table, and alone
MODULES = [
    path.stem
    for path in sorted(FOLDER.glob("*.py"))
    if "\ndef rows(small: bool" in path.read_text(encoding="utf-8")
]


@pytest.fixture
def benchmark(monkeypatch):
    """A module of `benchmarks/`, imported as its scripts import one another."""
    monkeypatch.syspath_prepend(FOLDER)
    yield importlib.import_module
    for name in [path.stem for path in FOLDER.glob("*.py")]:
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=() if one == "one_point" else pytest.mark.slow) for one in MODULES],
)
def test_a_benchmark_runs(benchmark, name):
    rows = benchmark(name).rows(small=True)
    assert rows
    for row in rows:
        assert len(row.cells()) == 6
        if row.figure is None:
            assert row.limit  # why there is none
        else:
            numbers = (row.figure.low, row.figure.value, row.figure.high)
            assert all(math.isfinite(x) and x > 0 for x in numbers)
            assert row.figure.low <= row.figure.value <= row.figure.high


def test_the_table_holds_every_benchmark(benchmark):
    assert sorted(benchmark("run_all").MODULES) == MODULES


def test_a_reach_is_met_from_its_own_side(benchmark):
    timing = benchmark("timing")
    two = timing.Measured(2.0, 2.0, 2.0)
    assert timing.Row("rate", two, "×", reach=1.0, side="≥").met
    assert not timing.Row("rate", two, "×", reach=3.0, side="≥").met
    assert timing.Row("time", two, "s", reach=3.0, side="≤").met
    assert timing.Row("time", two, "s", reach=1.0, side="≤").shortfall == 2.0
    assert timing.Row("time", two, "s").met is None


def test_the_ratio_is_of_medians_and_its_spread_of_rounds(benchmark):
    timing = benchmark("timing")
    seconds = {"a": timing.np.array([2.0, 4.0, 6.0]), "b": timing.np.array([1.0, 2.0, 2.0])}
    ratio = timing.Times(seconds).ratio("a", "b")
    assert (ratio.value, ratio.low, ratio.high) == (2.0, 2.0, 2.5)

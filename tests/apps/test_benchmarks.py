"""Every benchmark runs, at a size whose times mean nothing; no time is asserted."""

import importlib
import math
import sys
from pathlib import Path

import pytest


FOLDER = Path(__file__).parents[2] / "benchmarks"
# those with rows; the others are studies that run alone
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
    [
        pytest.param(name, marks=() if name == "exported_c" else pytest.mark.slow)
        for name in MODULES
    ],
)
def test_benchmark_runs(benchmark, name):
    rows = benchmark(name).rows(small=True)
    assert rows
    for row in rows:
        assert len(row.cells()) == 6
        if row.figure is None:
            assert row.note  # the reason
        else:
            numbers = (row.figure.low, row.figure.median, row.figure.high)
            assert all(map(math.isfinite, numbers))
            assert list(numbers) == sorted(numbers)


def test_ratio_is_of_medians_and_its_quartiles_are_of_rounds(benchmark):
    timing = benchmark("timing")
    seconds = {"a": timing.np.array([2.0, 4.0, 6.0]), "b": timing.np.array([1.0, 2.0, 2.0])}
    ratio = timing.Times(seconds).ratio("a", "b")
    assert (ratio.median, ratio.low, ratio.high) == (2.0, 2.0, 2.5)
    difference = timing.Times(seconds).difference("a", "b")
    assert (difference.median, difference.low, difference.high) == (2.0, 1.5, 3.0)

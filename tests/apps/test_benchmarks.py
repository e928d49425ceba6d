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

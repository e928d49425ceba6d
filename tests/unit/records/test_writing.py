import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fascicle.records import Record, load, loads, write
from fascicle.records.record import Source, dumps


def random_record(seed=0, n=200, **more):
    rng = np.random.default_rng(seed)
    return Record.of(
        rng.uniform(0, 4e5, n), rng.uniform(-0.1, 0.8, n), rng.normal(0, 100, n), **more
    )


def same(a, b):
    for name in ("pressure", "strain", "force", "censored", "branch"):
        assert_array_equal(getattr(a, name), getattr(b, name))
        assert getattr(a, name).dtype == getattr(b, name).dtype
    assert (a.time is None) == (b.time is None)
    assert a.time is None or np.array_equal(a.time, b.time)
    assert (a.rest_length, a.synthetic) == (b.rest_length, b.synthetic)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"rest_length": 0.3},
        {"rest_length": 0.1 + 0.2, "synthetic": True},
        {"censored": np.arange(200) % 3 == 0, "branch": np.arange(200) % 3 - 1},
        {"time": np.arange(200) / 3},
    ],
)
def test_what_is_written_reads_back(tmp_path, more):
    record = random_record(**more)
    write(record, tmp_path / "r.csv")
    back = load(tmp_path / "r.csv")
    same(back, record)
    # and again
    assert dumps(back).splitlines()[-200:] == dumps(record).splitlines()[-200:]
    assert [p.name for p in tmp_path.iterdir()] == ["r.csv"]


def test_floats_at_the_ends_of_their_range():
    record = Record.of([5e-324, 2.2250738585072014e-308, 413.7e3], 0.1 + 0.2, [-0.0, 1e-300, 1 / 3])
    back = loads(dumps(record))
    same(back, record)
    assert np.signbit(back.force[0])


def test_sources_and_notes_go_along():
    source = Source("raw.csv", "ab" * 32)
    record = random_record(sources=(source,), notes=("a note\nof two lines", "another"))
    notes = loads(dumps(record), source="m.csv").notes
    for note in (f"source: raw.csv sha256 {'ab' * 32}", "note: a note of two lines"):
        assert f"m.csv: {note}" in notes

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fascicle.core.errors import InvalidInputError
from fascicle.records import Record, Source, join
from fascicle.records.record import note
from refusing import refuses, warns


ONE = Record.of(
    1e5, [0.0, 0.1], [50, 20], rest_length=0.3, sources=(Source("a", "1"),), notes=("n",)
)


def test_readings_broadcast_and_are_ones_own():
    strain = np.array([0.0, 0.1])
    record = Record.of(1e5, strain, 5.0)
    strain[0] = 9
    assert_array_equal(record.strain, [0, 0.1])
    assert_array_equal(record.pressure, [1e5, 1e5])
    assert (len(record), record.branch.dtype, record.censored.dtype) == (2, np.int8, bool)


def test_some_of_them():
    some = replace(ONE, time=np.array([0.0, 1.0])).only([False, True], note("last"))
    assert (some.strain, some.time, some.notes) == ([0.1], [1.0], ("n",))
    assert [finding.code for finding in some.findings] == ["record.last"]


def test_joined():
    of_b = {"synthetic": True, "sources": (Source("b", "2"),), "notes": ("n",)}
    strains_only = Record.of(2e5, 0.2, 30, **of_b)
    for records in ([ONE, strains_only], [strains_only, ONE]):
        both = join(records)
        # strains alone are taken to refer to the same length
        assert (len(both), both.rest_length, both.synthetic) == (3, 0.3, True)
        assert (both.time, both.notes) == (None, ("n",))
    assert [source.name for source in both.sources] == ["b", "a"]
    with refuses("records"):
        join([ONE, Record.of(1e5, 0.1, 5, rest_length=0.4)])


def test_the_same_readings_twice_are_told():
    copied = replace(ONE, sources=(Source("copy", "1"),), rest_length=None)
    with warns("a", "copy"):
        both = join([ONE, Record.of(2e5, 0.1, 5), copied])
    assert len(both) == 5
    assert [dict(x.data) for x in both.findings] == [{"first": "a", "second": "copy"}]
    with_noise = Record.of(1e5, [0.0, 0.1], [50, 20.1])
    assert not join([ONE, with_noise]).findings  # no warning: they are errors here


@pytest.mark.parametrize("force", [[1.0, np.nan], [1.0, np.inf], np.ma.masked_less([1.0, -9.0], 0)])
def test_readings_that_are_no_numbers_are_refused(force):
    with pytest.raises(InvalidInputError) as error:
        Record.of(1e5, [0.0, 0.1], force)
    assert error.value.argument == "force"

"""The table of a DMSP-20-300 that Martens and Boblan (2017), Actuators 6(4), 33, measured.

https://doi.org/10.3390/act6040033, table A1. Zeros mean "no tension".
"""

import numpy as np
import pytest
from measured import measured
from numpy.testing import assert_array_equal

from fascicle.calibrate.friction import fit_friction
from fascicle.records import load, runs
from refusing import refuses


NAME = "martens-boblan-2017/dmsp-20-300.csv"
SHA256 = "76147c5a010be8f9ba910d3119dafdd5d424eaf33d6af932a43f67b397f941c0"


@pytest.fixture
def record():
    return load(measured(NAME), rest_length=0.3)


def test_it_is_the_file_that_results_are_stated_on(record):
    assert [source.sha256 for source in record.sources] == [SHA256]


def test_what_is_in_it(record):
    assert len(record) == 126
    assert np.unique(record.pressure).size == 21
    assert (record.pressure.min(), record.pressure.max()) == (35e3, 675e3)
    assert record.rest_length == 0.3
    assert not record.synthetic
    assert record.time is None
    # lengths of 296 to 222 mm, at a nominal rest length of 300 mm
    np.testing.assert_allclose([record.strain.min(), record.strain.max()], [4 / 300, 78 / 300])


def test_zeros_are_clipped_and_nothing_else(record):
    assert np.count_nonzero(record.censored) == 66
    assert_array_equal(record.censored, record.force == 0)
    # the same, by the rule and without the flag
    assert np.all(record.force >= 0)


def test_its_levels_are_the_pressures(record):
    found = runs(record)
    assert [run.kind for run in found] == ["pressure"] * 21
    assert [run.points.size for run in found] == [6] * 21
    assert_array_equal([run.level for run in found], np.unique(record.pressure))
    # a table in order is no history
    assert {run.branch for run in found} == {0}
    # nor are its loops in it: one force for each length and pressure
    assert fit_friction(record, 0.3) is None


def test_it_needs_the_rest_length():
    with refuses("rest_length"):
        load(measured(NAME))

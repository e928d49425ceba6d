"""Measured muscles of the catalog against the records of Martens and Boblan (2017).

Table A1, of the DMSP-20-300, is not in the repository; table A2, of the DMSP-10-250, is.
"""

import math

import numpy as np
import pytest
from measured import measured
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate import select_model
from fascicle.records import load


NAME = "martens-boblan-2017/dmsp-20-300.csv"
LAW = "-martens2017"  # of the entries with the constants of the paper


@pytest.mark.parametrize("name", ["festo-dmsp-20-300", f"festo-dmsp-20-300{LAW}"])
def test_errors_are_those_of_table_a1(name):
    entry, record = fs.catalog[name], load(measured(NAME), rest_length=0.3)
    strain, pulls = record.strain * entry.strain_ratio, ~record.censored
    residuals = (record.force - entry.muscle.force(record.pressure, strain))[pulls]
    rmse, top = np.sqrt(np.mean(residuals**2)), record.force.max()
    assert_allclose([rmse, rmse / top], entry.error[:2], rtol=0.01)  # as many digits as written
    assert np.abs(residuals).max() / top <= entry.error.largest
    assert_allclose(entry.range.pressure, [record.pressure.min(), record.pressure.max()])
    assert_allclose(entry.range.strain, [strain.min(), strain.max()], atol=1e-4)


def test_table_a2_was_transcribed_well():
    # the paper's abstract: the law's largest error is below 4.4 %; a slip in a digit would show
    entry = fs.catalog[f"festo-dmsp-10-250{LAW}"]
    largest = np.abs(entry.residuals()).max() / entry.record.force.max()
    assert 0.04 < largest < 0.044
    assert entry.record.pressure.size == 17 * 5 and np.count_nonzero(entry.record.censored) == 45


@pytest.mark.slow
@pytest.mark.parametrize("name", ["festo-dmsp-20-300", "festo-dmsp-10-250"])
def test_the_plain_command_gives_the_muscle_again(name):
    entry = fs.catalog[name]
    record = entry.record or load(measured(NAME), rest_length=entry.rest_length)
    radius = float(name.split("-")[2]) / 2e3 + 1.8e-3  # nominal bore, and Martens and Boblan's wall
    start = fs.Muscle(entry.rest_length, radius, 1.8e-3, math.radians(28.6))
    choice = select_model(record, start)
    fit, error = choice.calibration, entry.error
    assert fit.relative_rmse <= 0.008
    assert_allclose(fit.rmse, error.rmse, rtol=1e-3)  # four digits are written
    assert_allclose(float(fit.muscle.length), float(entry.muscle.length), rtol=1e-3)
    forces = (
        muscle.force(record.pressure, record.strain * entry.rest_length / float(muscle.length))
        for muscle in (fit.muscle, entry.muscle)
    )
    # the file's constants are rounded to 1 % of the error
    assert_allclose(*forces, atol=0.02 * error.rmse, rtol=0)

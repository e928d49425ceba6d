"""What the plain command finds in the table of Martens and Boblan (2017), and says about it."""

import math

import numpy as np
import pytest
from measured import measured

import fascicle as fs
from fascicle.calibrate import select_model
from fascicle.records import load


@pytest.fixture(scope="module")
def choice():
    record = load(measured("martens-boblan-2017/dmsp-20-300.csv"), rest_length=0.3)
    # Festo's nominal sizes
    return select_model(record, fs.Muscle(0.3, 10e-3, 2e-3, math.radians(28.6)))


def test_the_fit_is_found(choice):
    assert choice.calibration.relative_rmse <= 0.008
    taken = next(one for one in choice.candidates if one.chosen)
    assert taken.relative_left_out_rmse <= 0.008
    tuning = next(one for one in choice.candidates if one.method == "tuning")
    assert tuning.relative_left_out_rmse > 3 * taken.relative_left_out_rmse


def test_what_isnt_noise_is_told(choice):
    made = choice.calibration
    trend = made.diagnosis.significant[0]
    assert trend.along == "strain" and trend.share > 0.7
    assert np.max(made.wider) > 1.5
    near = made.errors[np.isfinite(made.errors) & (np.abs(made.record.strain - 0.06) < 1e-3)]
    assert (near.size, np.sum(near < 0)) == (16, 16)
    assert made.diagnosis.causes
    counts = made.fit_data.counts()
    assert (counts["read"], counts["clipped"], counts["averaged"]) == (126, 66, 0)

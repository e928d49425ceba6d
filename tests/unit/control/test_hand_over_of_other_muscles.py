"""A hand-over of muscles that its controller knows wrongly: a sample of `random_muscles.py`."""

import numpy as np
import pytest

from tests.unit.control import random_muscles


@pytest.mark.slow
@pytest.mark.parametrize(
    ("count", "lag", "largest"), [(1, None, 0.3), (4, None, 0.3), (4, 20e-3, 0.4)]
)
def test_random_muscles_are_handed_over_with_small_dips(count, lag, largest):
    result = random_muscles.study(count, 0.2, 12, lag)
    plain, handed = result["threshold"], result["hand_over"]
    can_cross = handed.least == 0
    assert can_cross.sum() >= 9
    assert np.quantile(handed.dip[can_cross], 0.9) <= largest
    assert np.median(plain.dip) > 0.8 and np.all(handed.dip <= plain.dip + 0.05)
    # on its way the first unit may be filled, vented and filled again, which `threshold` doesn't
    assert np.all(handed.air <= plain.air + handed.filling)


@pytest.mark.parametrize(
    ("lag", "declared", "largest"),
    [
        (None, None, 0.15),
        # as identified in one step of pressure
        pytest.param(20e-3, (15e-3, 8e-3), 0.3, marks=pytest.mark.slow),
    ],
)
def test_a_steep_dip_is_crossed_no_faster_than_the_first_unit_can_follow(
    monkeypatch, lag, declared, largest
):
    # all three can cross; the steep part of their dip is at other pressures than the model's
    muscles = [random_muscles.draw_muscles(24, 1)[index] for index in (12, 14, 22)]
    monkeypatch.setattr(random_muscles, "draw_muscles", lambda *_: muscles)
    handed = random_muscles.study(4, 0.2, 3, lag, declared=declared)["hand_over"]
    assert np.all(handed.least == 0) and handed.dip.max() <= largest


@pytest.mark.slow
def test_force_withheld_from_a_fast_sine_comes_before_the_demand_falls(monkeypatch):
    # all three can cross; a second unit that came past its dip as slowly as before it let the force
    # jump by a dip when the demand already fell
    muscles = [random_muscles.draw_muscles(24, 1)[index] for index in (1, 6, 20)]
    monkeypatch.setattr(random_muscles, "draw_muscles", lambda *_: muscles)
    handed = random_muscles.study(4, 0.2, 3, duration=1.0, shape="sine")["hand_over"]
    assert np.all(handed.least == 0) and handed.dip.max() <= 0.25

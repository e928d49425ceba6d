"""Sliders and fields: what they take, and what they refuse, in the unit shown."""

import pytest

from fascicle.explorer.widgets import QuantitySlider
from fascicle.units import parse


SUPPLY = 413.7e3


@pytest.mark.parametrize("unit", ["kPa", "psi", "bar"])
def test_a_slider_ends_where_the_supply_does(unit):
    taken = []
    dial = QuantitySlider("Pressure P", "pressure", "pressure", taken.append)
    dial.show(1e5, unit, SUPPLY)
    dial.slider.value = dial.slider.end
    assert taken == [SUPPLY]
    dial.field.input.value = f"{dial.slider.end:.6g}"  # with the digits of the limits that are told
    assert taken[1:] == [pytest.approx(SUPPLY, rel=1e-6)] and max(taken) == SUPPLY
    assert not dial.field.error


def test_a_slider_gives_its_own_decimals():
    taken = []
    dial = QuantitySlider("Pressure P", "pressure", "pressure", taken.append)
    dial.show(1e5, "psi", SUPPLY)
    dial.slider.value = 0.1 * 202
    assert taken == [parse("20.2 psi", "pressure")]


def test_limits_are_told_as_they_are():
    dial = QuantitySlider("Pressure P", "pressure", "pressure", lambda _: None)
    dial.show(1e5, "kPa", SUPPLY)
    dial.field.input.value = "414"
    assert "Pressure P must lie in [0, 413.7] kPa, got 414 kPa." in dial.field.error

"""The dip before a unit: shapes, limits, unlike units."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle import control


SUPPLY = 413.7e3


def test_strains_of_any_shape(pair):
    strain = np.array([[0.05, 0.15], [0.2, 0.24]])
    result = control.transition(pair, strain)
    for field in result:
        assert np.shape(field) == (2, 2)
    for i in np.ndindex(2, 2):
        one = control.transition(pair, strain[i])
        assert_allclose([field[i] for field in result], list(one), rtol=1e-12)
    assert np.ndim(control.transition(pair, 0.2).dip) == 0
    rows = control.added_force(pair, np.linspace(0, 4e5, 5)[:, None], [0.1, 0.2])
    assert rows.shape == (5, 2)
    assert_array_equal(rows[0], 0.0)


def test_no_dip_below_the_free_strain(pair):
    assert_array_equal(control.transition(pair, [-0.05, 0.0])[:3], 0.0)


def test_a_unit_past_its_largest_free_strain_only_resists(pair):
    result = control.transition(pair, 0.3)
    assert result.onset_pressure == np.inf
    assert result.dip > 0 and result.largest_force < 0


def test_the_slope_vanishes_at_the_dip_and_the_gain_at_the_onset(five):
    result = control.transition(five, 0.18)
    around = control.added_force(five, result.dip_pressure + np.array([-2e3, 0.0, 2e3]), 0.18)
    assert around[1] == pytest.approx(-result.dip, rel=1e-12)
    assert around[0] > around[1] < around[2]
    beside = control.added_force(five, result.onset_pressure * np.array([1 - 1e-9, 1 + 1e-6]), 0.18)
    assert beside[0] <= 1e-9 < beside[1]
    onset = fs.reversal.onset_pressure(five, 0.18)
    assert_allclose(result.onset_pressure, onset, rtol=1e-9)


def test_any_unit_of_any_bundle(muscle):
    wide = muscle.replace(outer_radius=8e-3, wall_thickness=1.4e-3)
    three = fs.Bundle(
        [fs.MotorUnit(muscle), fs.MotorUnit(wide, 2), fs.MotorUnit(muscle, 3)], SUPPLY
    )
    result = control.transition(three, 0.2, unit=3)
    same = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 3)], SUPPLY)
    assert_allclose(result.dip, control.transition(same, 0.2).dip, rtol=1e-12)
    held = three.force([SUPPLY, SUPPLY, 0.0], 0.2)
    assert_allclose(result.largest_force, held, rtol=1e-12)


def test_muscles_of_unlike_length(muscle):
    longer = muscle.replace(length=0.14)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(longer)], SUPPLY, length=0.127)
    result = control.transition(bundle, 0.2)
    alone = fs.Bundle([fs.MotorUnit(longer), fs.MotorUnit(longer)], SUPPLY)
    own = 1 - 0.127 / 0.14 * 0.8
    assert_allclose(result.dip, control.transition(alone, own).dip, rtol=1e-10)

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle.reversal import free_strain_curve, onset_pressure, reversal


SUPPLY = 344.7e3
muscle = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")
even = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle)], SUPPLY)
uneven = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)], SUPPLY)


def test_curve_holds_earlier_units_at_supply():
    P = np.array([0.0, 50e3, 129e3])
    expected = even.free_strain(np.stack([np.full(3, SUPPLY), P], axis=-1))
    assert_allclose(free_strain_curve(even, 2, P), expected, rtol=1e-14)


@pytest.mark.parametrize("bundle", [even, uneven])
def test_reversal_is_the_lowest_point_of_the_curve(bundle):
    result = reversal(bundle)
    brute = free_strain_curve(bundle, 2, np.linspace(0, SUPPLY, 3001))
    assert result.depth > 0
    # the grid can miss the turn by a cell: its lowest is no lower, and near
    assert brute.min() - 2e-4 < result.free_strain <= brute.min() + 1e-12
    assert_allclose(result.initial - result.free_strain, result.depth)


def test_the_turn_of_one_and_four_muscles_is_a_jump():
    result = reversal(uneven)
    assert result.jump
    # with rising pressure the force's dip touches zero at .198 before its zero at .207
    before = free_strain_curve(uneven, 2, np.array([result.pressure - 1.0]))[0]
    assert before > result.free_strain + 5e-3


def test_reversal_only_with_resistance():
    result = reversal(even, resistance=False)
    assert result.depth == 0 and result.pressure == 0 and not result.jump


def test_onset_is_where_the_unit_begins_to_help():
    eps = 0.15
    onset = onset_pressure(even, eps)
    idle = muscle.force(0.0, eps)
    # 10 Pa to either side; the force changes by some 1e-4 N/Pa there
    assert muscle.force(onset - 10.0, eps) < idle < muscle.force(onset + 10.0, eps)


def test_onset_is_zero_at_rest_and_infinite_out_of_reach():
    assert onset_pressure(even, 0.0) == 0.0
    assert onset_pressure(even, 0.25, supply_pressure=100e3) == math.inf


@pytest.mark.parametrize("unit", [1, 2])
def test_onset_in_a_bundle_of_two_lengths(unit):
    """Each muscle has a strain of its own."""
    longer = fs.Muscle(0.14, 9e-3, 2.25e-3, math.radians(33), "silicone_kim2021")
    mixed = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(longer)], SUPPLY, length=0.127)
    strain = 0.15
    result = onset_pressure(mixed, strain, unit)
    assert 0 < result < SUPPLY
    # well below it the unit pushes back more than unfed, above it less
    P = np.zeros((3, 2))
    P[:, unit - 1] = [0.0, 0.999 * result, 1.001 * result]
    none, below, above = mixed.force(P, strain)
    assert below < none < above

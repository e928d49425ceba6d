import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle.recruitment import overlap, pressures_of, workspace


SUPPLY = 413.7e3
muscle = fs.Muscle(0.127, 9e-3, 2.25e-3, math.radians(33), "silicone_kim2021")
two = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle)], SUPPLY)
three = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle), fs.MotorUnit(muscle, 2)], SUPPLY)


def test_orderly_recruitment_fills_units_and_batch_recruitment_gives_all_one_pressure():
    assert pressures_of(2, 1e5, SUPPLY, 3).tolist() == [SUPPLY, 1e5, 0.0]
    assert pressures_of(1, [0.0, 1e5], SUPPLY, 2).tolist() == [[0.0, 0.0], [1e5, 0.0]]
    assert pressures_of(2, 1e5, SUPPLY, 3, "batch").tolist() == [1e5, 1e5, 0.0]


@pytest.mark.parametrize("scheme", ["orderly", "batch"])
def test_curves_are_forces_at_the_pressures_of_the_state(scheme):
    strain = np.linspace(0, 0.25, 6)
    result = workspace(three, levels=4, strain=strain, scheme=scheme)
    for state in (1, 2, 3):
        P = pressures_of(state, result.level, SUPPLY, 3, scheme)
        expected = three.force(P[:, None, :], strain)
        assert_allclose(result.force[state - 1], expected, rtol=1e-12, atol=1e-12)


def test_a_region_holds_its_curves_and_has_an_outline():
    result = workspace(two)
    assert np.all(result.low[:, None] <= result.force)
    assert np.all(result.force <= result.high[:, None])
    strain, force = result.outline(1)
    assert strain.shape == force.shape and np.all(force >= 0)
    assert_allclose(force.max(), two.force([SUPPLY, 0.0], 0.0))


def test_regions_begin_at_no_pressure_for_any_curves():
    result = workspace(two, levels=[1e5])
    assert np.all(result.low[0] <= two.force(np.zeros(2), result.strain))
    assert_allclose(result.high[1], workspace(two).high[1], rtol=1e-12)


def test_outlines_are_closed():
    result = workspace(two)
    shared = overlap(result)
    for strain, force in (result.outline(2), shared.outline(0)):
        half = len(strain) // 2
        assert np.all(np.diff(strain[:half]) > 0) and np.array_equal(strain, strain[::-1])
        top, bottom = force[:half], force[half:][::-1]
        assert np.all(top >= bottom) and np.any(top > bottom)


def test_points_of_the_overlap_are_reached_by_both_states():
    result = overlap(workspace(two))
    j = int(np.nanargmax((result.high - result.low)[0]))
    middle = 0.5 * (result.low[0, j] + result.high[0, j])
    levels = np.linspace(0, SUPPLY, 400)
    for state in (1, 2):
        reach = np.asarray(two.force(pressures_of(state, levels, SUPPLY, 2), result.strain[j]))
        assert reach.min() < middle < reach.max()


def test_area_is_that_of_the_outline():
    result = overlap(workspace(two))
    strain, force = result.outline(0)
    shoelace = 0.5 * abs(np.sum(strain * np.roll(force, -1) - np.roll(strain, -1) * force))
    # the trapezoids at the tips, where the overlap begins, are counted half more
    assert_allclose(result.area[0], shoelace, rtol=0.01)

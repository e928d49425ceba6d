import math
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cubature

import fascicle as fs
from fascicle import energetics
from refusing import warns


SUPPLY = 413.7e3
wide = 9e-3 * math.sqrt(2)
rubber = fs.MooneyRivlin(118.4e3, 105.7e3, youngs_modulus=1.78e6)
semu = fs.Muscle(0.127, wide, 0.25 * wide, math.radians(33), rubber)
two = fs.Bundle.constant_cross_section(semu, 2, SUPPLY)
thin = two.motor_units[0].muscle


@pytest.mark.parametrize("resistance", [True, False])
@pytest.mark.parametrize("strain", [0.05, 0.2, 0.35, -0.05])
def test_work_is_the_area_under_the_force(strain, resistance):
    P = [SUPPLY, 20e3]
    kinks = [float(thin.free_strain(p)) for p in P] + [float(thin.collapse_strain(20e3))]
    ends = [0.0, *sorted(k for k in kinks if 0 < k < strain), strain]

    def force(eps):
        return two.force(P, eps[:, 0], resistance)

    area = 0.0
    for low, high in pairwise(ends):
        result = cubature(force, [low], [high], rule="gk21", rtol=0, atol=1e-8)
        assert result.status == "converged"
        area += result.estimate
    # the integration's own tolerance on some 10 J/m of area
    assert_allclose(energetics.work(two, P, strain, resistance), 0.127 * area, atol=1e-8)


def test_fluid_energy_counts_active_units_at_supply_pressure():
    swept = float(thin.volume(0.2) - thin.volume(0.0))
    assert_allclose(energetics.fluid_energy(two, 0.2, SUPPLY, [1, 0]), SUPPLY * swept)
    assert_allclose(energetics.fluid_energy(two, 0.2, SUPPLY, [1, 1]), 2 * SUPPLY * swept)


@pytest.mark.parametrize("length", np.linspace(0.128, 0.14, 13))
def test_volumes_reach_to_the_end_of_the_domain_of_unlike_lengths(length):
    muscle = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33))
    units = [fs.MotorUnit(muscle), fs.MotorUnit(muscle.replace(length=length))]
    bundle = fs.Bundle(units, length=0.13)
    end = float(np.min(1 - (1 - 0.6) / bundle.ratios))  # a muscle's strain there rounds to 0.6
    volumes = energetics.unit_volume_change(bundle, end)
    assert_allclose(volumes, energetics.unit_volume_change(bundle, end - 1e-9), rtol=1e-6)


def test_ideal_muscle_turns_all_fluid_energy_into_work():
    """Without a bladder W = P ΔV: an isobaric contraction at supply pressure loses nothing."""
    ideal = fs.Muscle(0.127, 9e-3, 2.25e-3, math.radians(33), tension="ideal")
    bundle = fs.Bundle([fs.MotorUnit(ideal)], SUPPLY)
    force = float(bundle.force([SUPPLY], 0.1))
    result = energetics.efficiency_map(bundle, path="isobaric", force=force, strain=0.1)
    # the force is a level's own, so nothing is interpolated
    assert_allclose(result.efficiency, 1.0, rtol=1e-9)


@pytest.mark.parametrize("path", ["isobaric", "isotonic"])
def test_efficiency_at_a_point_is_work_over_energy(path):
    strain, pressure = 0.1, 200e3
    force = float(two.force([pressure, 0.0], strain))
    result = energetics.efficiency_map(two, path=path, force=force, strain=strain)
    isobaric = path == "isobaric"
    work = energetics.work(two, [pressure, 0.0], strain) if isobaric else force * strain * 0.127
    expected = float(work) / float(energetics.fluid_energy(two, strain, SUPPLY, [1, 0]))
    # between levels force and work are linear while unit 1 pulls: only rounding remains
    assert_allclose(result.efficiency, expected, rtol=1e-9)
    assert result.state == 1


def test_unreached_points_have_no_efficiency_and_no_state():
    result = energetics.efficiency_map(two, force=[1e5], strain=[0.1])
    assert np.isnan(result.efficiency) and result.state == 0


def test_second_state_costs_more_than_the_first():
    low = float(two.force([0.3 * SUPPLY, 0.0], 0.05))
    high = float(two.force([SUPPLY, 0.5 * SUPPLY], 0.05))
    result = energetics.efficiency_map(two, path="isotonic", force=[low, high], strain=[0.05])
    assert result.state[:, 0].tolist() == [1, 2]


def test_batch_recruitment_throttles_both_units():
    """At a force just above one unit's reach, both are throttled: half the isobaric work."""
    strain, pressure = 0.05, 0.6 * SUPPLY
    force = float(two.force([pressure, pressure], strain))
    result = energetics.efficiency_map(two, force=force, strain=strain, scheme="batch")
    energy = energetics.fluid_energy(two, strain, SUPPLY, [1, 1])
    expected = energetics.work(two, [pressure, pressure], strain) / energy
    assert_allclose(result.efficiency, expected, rtol=1e-9)
    assert result.state == 2


def test_constant_cross_section_keeps_section_and_shape():
    five = fs.Bundle.constant_cross_section(semu, 5).motor_units
    areas = [float(unit.muscle.bladder.area) for unit in five]
    assert_allclose(sum(areas), float(semu.bladder.area), rtol=1e-12)
    ratio = five[0].muscle.wall_thickness / five[0].muscle.outer_radius
    assert_allclose(ratio, 0.25, rtol=1e-12)


def test_an_efficiency_above_one_warns():
    """A fit of a wide muscle on a thin one works more than the thin one's fluid brings."""
    thin = fs.example("kim2021_figure_6").replace(tension="sarosi")
    with warns("sarosi"):
        result = energetics.efficiency_map(
            fs.Bundle([fs.MotorUnit(thin)]), 3e5, force=[50.0], strain=[0.1]
        )
    assert result.average > 1

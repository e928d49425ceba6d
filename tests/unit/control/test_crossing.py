"""Hand-overs along a path: where they are, that there are none, why, and what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import control, dynamics, fluid
from fascicle.control import GasValves, OilValves, Path
from fascicle.core.errors import InvalidInputError


SUPPLY = 413.7e3


def of_conductance(each, *counts):
    """Valves of air, so much conductance a muscle."""
    return [
        control.PlantValves(fluid.Isothermal(), fluid.SonicValve(n * each, 0.3), SUPPLY, 293.15)
        for n in counts
    ]


def ramp(bundle, strain, begin=0.1, end=3.0):
    """An isometric one, in 4 s, of shares of what the first unit holds."""
    first = float(control.transition(bundle, strain).largest_force)
    return Path.of([0, 4], [begin * first, end * first], strain)


@pytest.mark.parametrize(
    ("unit_2", "strain"), [pytest.param(1, 0.2, marks=pytest.mark.slow), (4, 0.2)]
)
def test_fast_valves_allow_a_crossing_and_slow_ones_none(pair, five, unit_2, strain):
    bundle = pair if unit_2 == 1 else five
    result = control.crossing(bundle, ramp(bundle, strain), of_conductance(1e-9, 1, unit_2))
    assert result.exists and 0 <= result.start < result.end <= result.deadline
    assert result.end - result.start >= result.fill_time > 0
    assert result.reserve > result.dip
    rate = (3.0 - 0.1) * float(control.transition(bundle, strain).largest_force) / 4
    assert result.reserve >= control.needed_reserve(bundle, strain, rate, 0.0)
    slow = control.crossing(bundle, ramp(bundle, strain), of_conductance(1e-10, 1, unit_2))
    assert slow.obstacle.code == "crossing.valves_too_slow" and slow.start is None


def test_a_hand_over_ends_before_the_units_before_no_longer_suffice():
    """The last step, in which the unit before is all but full, takes the longest."""
    supply = 600e3
    material = fs.materials.MooneyRivlin(c10=110e3, c01=40e3, youngs_modulus=1.2e6)
    thick = fs.Muscle(0.15, 10e-3, 2.5e-3, np.radians(24), material, transition_rate=60.0)
    bundle = fs.Bundle([fs.MotorUnit(thick), fs.MotorUnit(thick)], supply)
    valve = fluid.SonicValve(2.48e-9, 0.3)
    valves = [control.PlantValves(fluid.Isothermal(), valve, supply, 293.15)] * 2
    first = float(control.transition(bundle, 0.12).largest_force)
    path = Path.of([0, 1.2], [0.1 * first, 3 * first], 0.12)
    result = control.crossing(bundle, path, valves)
    assert result.exists and result.start < result.end <= result.deadline


def test_a_hand_over_does_not_wait_for_the_demand_to_fall_again():
    latex = fs.Muscle(0.18, 8e-3, 1.5e-3, np.radians(27), "latex")
    bundle = fs.Bundle([fs.MotorUnit(latex), fs.MotorUnit(latex)], 350e3)
    valve = fluid.SonicValve(1.587e-9, 0.3)
    valves = [control.PlantValves(fluid.Isothermal(), valve, 350e3, 293.15)] * 2
    time = np.linspace(0.0, 2.0, 2000)  # two periods of a sine
    first = float(control.transition(bundle, 0.18).largest_force)
    demand = (0.9 - 0.8 * np.cos(2 * np.pi * time)) * first
    result = control.crossing(bundle, Path.of(time, demand, 0.18), valves)
    # it would begin at 0.12 s, and last until the second period
    assert result.deadline == pytest.approx(0.27, abs=0.001)
    assert not result.exists or result.end <= result.deadline


def test_no_crossing_near_the_end_of_the_stroke(five):
    result = control.crossing(five, ramp(five, 0.24), of_conductance(1e-9, 1, 4))
    assert not result.exists
    assert result.obstacle.code == "crossing.dip_too_deep"
    # 0.9 of 8.37 N against 34.66 N
    assert_allclose(
        [result.obstacle.data[k] for k in ("reserve", "dip")], [7.531, 34.66], rtol=1e-3
    )


def test_a_path_crosses_at_its_last_feasible_strain(five):
    path = Path.of([0, 2, 3], [5, 5, 20], [0.15, 0.24, 0.24])
    result = control.crossing(five, path, of_conductance(1e-8, 1, 4))
    assert result.exists and result.end < 2 < result.deadline
    there = control.transition(five, result.strain)
    left = float(there.largest_force - there.dip) - 5
    # on its way there the strain rises, too: nothing is left, where at 0.24 it would be -31 N
    assert -1 < left < 1
    assert_allclose([result.dip, result.onset_pressure], [there.dip, there.onset_pressure])


@pytest.mark.parametrize(
    ("force", "strain", "code", "data"),
    [
        ([1.0, 10.0], 0.2, "not_needed", {"reserve": 28.06}),
        ([50.0, 60.0], 0.2, "too_late", {"shortfall": 11.94}),
        ([-30.0, 60.0], 0.31, "no_gain", {}),
    ],
)
def test_a_path_without_a_crossing_has_an_obstacle(pair, force, strain, code, data):
    result = control.crossing(pair, Path.of([0, 1], force, strain), GasValves(1e-3))
    assert not result.exists and result.obstacle.code == f"crossing.{code}"
    assert (result.deadline is None) == (code == "not_needed") == result.is_resolved
    assert result.obstacle.data == pytest.approx({"unit": 2, **data}, rel=1e-3)


def test_without_a_dip_the_crossing_is_as_late_as_possible(pair):
    path = Path.of([0, 1], [50.0, 250.0], 0.0)
    result = control.crossing(pair, path, GasValves(1e-3))
    assert result.dip == 0 and result.onset_pressure == 0 and result.fill_time == 0
    assert_allclose(result.start, result.deadline, rtol=0, atol=1e-3)


def test_valves_of_oil_and_of_a_plant(pair):
    path = ramp(pair, 0.2)
    oil = control.crossing(pair, path, OilValves(2e-5))
    # V* of 8.3 mL more at the onset
    assert oil.exists and 0.3 < oil.fill_time < 0.5
    plant = dynamics.Plant(
        pair, dynamics.PrescribedMotion(0.2 * 0.127), fluid.ConstantSupply(SUPPLY),
        fluid.Isothermal(dead_volume=np.array([0.0, 20e-6])), fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip
    result = control.crossing(pair, path, plant)
    bare = control.crossing(pair, path, of_conductance(1e-9, 1, 1))
    # a hose of 20 mL on unit 2 takes its gas, too: p_on V/(R T) of it
    flow = result.fill_time - bare.fill_time
    assert flow > 0.02 and result.start < bare.start


def test_crossing_to_the_third_unit(muscle):
    three = fs.Bundle([fs.MotorUnit(muscle)] * 3, SUPPLY)
    path = Path.of([0, 4], [4.0, 110.0], 0.2)
    second = control.crossing(three, path, GasValves(1e-3), unit=2)
    third = control.crossing(three, path, GasValves(1e-3), unit=3)
    assert second.exists and third.exists and second.end < third.start
    assert second.deadline < third.deadline


@pytest.mark.parametrize(
    ("call", "argument"),
    [
        (lambda _: Path.of([0, 0], [1, 2], 0.2), "time"),
        (lambda _: Path.of([0, 1], [1, np.nan], 0.2), "force"),
        (lambda _: GasValves(0.0), "mass_flow"),
        (lambda b: control.crossing(b, Path.of([0, 1], [1, 2], 0.2), 1e-3), "valves"),
        (lambda b: control.crossing(b, Path.of([0, 1], [1, 2], 0.7), GasValves(1e-3)), "strain"),
        (
            lambda b: control.crossing(b, Path.of([0, 1], [1, 2], 0.2), GasValves(1), lag=-1.0),
            "lag",
        ),
        (lambda b: control.transition(b, 0.2, unit=1), "unit"),
        (lambda b: control.transition(b, 0.9), "strain"),
        (lambda b: control.added_force(b, -1.0, 0.2), "pressure"),
        (lambda b: control.needed_reserve(b, 0.2, np.inf, 1.0), "force_rate"),
        (lambda b: control.transition(b.replace(supply_pressure=None), 0.2), "supply_pressure"),
    ],
)
def test_invalid_input_is_refused(pair, call, argument):
    with pytest.raises(InvalidInputError) as error:
        call(pair)
    assert error.value.argument == argument


def test_late_pressures_end_a_crossing_earlier(pair):
    path, valves = ramp(pair, 0.2), of_conductance(1e-9, 1, 1)
    prompt, late = (control.crossing(pair, path, valves, lag=lag) for lag in (0.0, 0.1))
    # a ramp: all of it as much earlier
    assert_allclose([late.start, late.end], [prompt.start - 0.1, prompt.end - 0.1], atol=1e-3)
    assert not control.crossing(pair, path, valves, lag=3.0).exists

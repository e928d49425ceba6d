"""Valves and hoses sized for a cycle."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.design import Designs, Task
from fascicle.design.cycle import ATMOSPHERE, Cycle, run_cycle
from fascicle.design.space import Catalog
from fascicle.design.summary import summarize
from fascicle.fluid.data_sheets import catalog_valves


SUPPLY = 413.7e3


@pytest.fixture(scope="module")
def lift():
    return Task.of([60.0, 250.0], [0.15, 0.1], SUPPLY)


def sized(muscle, lift, cycle, counts=(1, 3)):
    return summarize(Designs.of(muscle, [counts]), 0, lift, Catalog(), cycle=cycle)


def test_conductance_of_a_choked_filling(muscle):
    """By hand: at a high supply all of the filling is choked, C p t is the content."""
    task = Task.of([20.0], [0.01], 900e3)
    sizing = sized(muscle, task, Cycle(0.5, 0.5, 10.0, b=0.45), (2,)).sizing
    # pressure that holds 20 N at 1 %, by a fine search; its share of the supply is below b
    levels = np.linspace(0.0, 400e3, 40_001)
    held = levels[np.argmax(2 * muscle.force(levels, 0.01) >= 20)]
    assert (held + ATMOSPHERE) / 1e6 < 0.45
    full = (held + ATMOSPHERE) * float(muscle.volume(0.01)) - ATMOSPHERE * float(muscle.volume(0.0))
    fill = 2 * full / ATMOSPHERE / (sizing.conductance[0] * 1e6)
    assert_allclose(sizing.fill, fill, rtol=1e-3)
    assert_allclose(max(sizing.fill, sizing.vent), 0.5, rtol=1e-9)


def test_time_and_units_scale_the_conductance(muscle):
    together = Task.of([250.0], [0.1], SUPPLY)
    fast, slow = (sized(muscle, together, Cycle(t, t, 5.0)).sizing for t in (0.25, 2.5))
    assert fast.pressures[0] == SUPPLY > fast.pressures[1] > 0
    assert_allclose(fast.conductance, 10 * slow.conductance, rtol=1e-12)
    assert fast.bore is None


def test_hose_needs_a_larger_valve_and_a_bore(muscle, lift):
    alone = sized(muscle, lift, Cycle(0.25, 0.25, 5.0)).sizing
    hoses = [sized(muscle, lift, Cycle(0.25, 0.25, 5.0, hose)).sizing for hose in (0.5, 5.0)]
    for sizing in hoses:
        assert np.all(sizing.conductance > alone.conductance)
        assert_allclose(max(sizing.fill, sizing.vent), 0.25, rtol=1e-6)
        assert sizing.line.conductance >= 2 * sizing.conductance.max()
    assert hoses[1].bore > hoses[0].bore
    impossible = sized(muscle, lift, Cycle(0.01, 0.01, 5.0, 90.0)).sizing
    assert not impossible.feasible and impossible.bore is None


def test_named_valve_is_the_smallest_that_is_enough(muscle, lift):
    smallest, largest = (v[i].supply.C for v, i in ((catalog_valves(), 0), (catalog_valves(), -1)))
    needed = sized(muscle, lift, Cycle(0.5, 0.5, 1.0)).sizing.conductance[1]
    for C, name in ((0.8 * smallest, catalog_valves()[0].name), (2 * largest, None)):
        valve = sized(muscle, lift, Cycle(0.5 * needed / C, 0.5 * needed / C, 1.0)).sizing.valves[1]
        assert (valve and valve.name) == name


def test_air_and_power(muscle, lift):
    summary = sized(muscle, lift, Cycle(0.25, 0.25, 30.0))
    assert_allclose(summary.flow, summary.cases.fluid_of_a_cycle / 2)
    assert_allclose(summary.supply_power, 1e5 * summary.flow * np.log(SUPPLY / 1e5 + 1))


@pytest.mark.parametrize("hose", [1.0, pytest.param(None, marks=pytest.mark.slow)])
def test_a_slow_load_stands_where_the_pressures_hold_it(muscle, hose):
    """Another computation: the plant in time; a slow load doesn't swing."""
    task = Task.of([250.0], [0.1], SUPPLY)
    designs = Designs.of(muscle, [(1, 3)])
    sizing = sized(muscle, task, Cycle(10.0, 10.0, 1.0, hose)).sizing
    stroke = float(task.stroke_of(float(muscle.length))[0])
    run = run_cycle(designs.bundle(0, task), 250.0, stroke, sizing)
    assert run.passes(sizing.cycle) and 0 < run.lifted < 10.0
    assert_allclose(run.highest, stroke, rtol=0.01)
    assert run.peak_force >= 0.999 * 250.0
    faster = Cycle(0.9 * run.lifted, 10.0, 1.0, hose)
    assert not run.passes(faster)


def test_a_fast_load_swings(muscle):
    task = Task.of([60.0], [0.1], SUPPLY)
    sizing = sized(muscle, task, Cycle(0.05, 0.1, 1.0), (3,)).sizing
    run = run_cycle(Designs.of(muscle, [(3,)]).bundle(0, task), 60.0, 0.0127, sizing)
    assert run.overshoot > 0.1 and not run.passes(sizing.cycle)

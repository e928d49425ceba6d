"""What can go wrong in a run is flagged, with numbers that are finite, and no exception."""

import equinox as eqx
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import dynamics, fluid
from fascicle.dynamics.outputs import LEDGER


@pytest.fixture(scope="module")
def mesh(muscle):
    return fs.Bundle([fs.MotorUnit(muscle.replace(tension="ideal"))])


@pytest.fixture(scope="module")
def single(muscle):
    return fs.Bundle([fs.MotorUnit(muscle)])


def in_oil(bundle, load, orifice=1e-6, supply=413.7e3, **chamber):
    """A plant of a bundle in a liquid, whose chamber has a `compliance`."""
    liquid = fluid.LiquidChamber(**chamber)
    return dynamics.Plant(
        bundle, load, fluid.ConstantSupply(supply), liquid, fluid.Orifice(orifice)
    )


def happened(plant, run):
    """Events by name, all numbers finite up to where one says that they aren't."""
    audit = dynamics.audit(plant, run)
    broken = [e.first for e in audit.events if e.name == "broken"]
    until = run.time < min([np.inf, *broken])
    assert all(np.all(np.isfinite(x[until])) for x in (*run.outputs, run.ledger))
    closes, trusted = [b.closes for b in audit.balances], [e.trusted for e in audit.events]
    assert audit.closes == all(closes + trusted)
    return {event.name: event for event in audit.events}


def test_a_stretched_closed_liquid_cavitates(mesh):
    # lengthened, a braid takes less; contracted, more than a shut chamber has
    plant = in_oil(mesh, dynamics.PrescribedMotion(0.015, 0.004, 2.0), compliance=1e-12)
    run = dynamics.simulate(plant, np.zeros((100, 1)), start=dynamics.equilibrium_state(plant, 2e4))
    result = happened(plant, run)
    assert "cavitates" in result and not result["cavitates"].trusted
    first = np.argmax(run.time >= result["cavitates"].first)
    assert np.all(run.outputs.pressures[:first] > -101325)
    assert not dynamics.audit(plant, run).closes


@pytest.mark.parametrize(("compliance", "folds"), [(1e-13, True), (1e-9, False)])
def test_a_folded_volume_is_reported(single, compliance, folds):
    # where the volume falls with pressure most, by 9.3e-12 m³/Pa: more than stiff oil gives way
    plant = in_oil(single, dynamics.PrescribedMotion(0.0154), compliance=compliance)
    run = dynamics.simulate(plant, np.zeros((5, 1)), start=dynamics.equilibrium_state(plant, 65e3))
    result = happened(plant, run)
    assert ("folded" in result) == folds
    if folds:
        assert not result["folded"].trusted and result["folded"].first == 0
    # shut and held, it stays
    assert_allclose(run.outputs.pressures, 65e3, rtol=1e-9)


@pytest.mark.parametrize(("compliance", "folds"), [(1.6e-11, True), (5e-11, False)])
def test_a_fold_between_two_steps_is_reported(muscle, compliance, folds):
    # beside a kink, near rest at 2 kPa, the table's volume falls by 3e-11 m³/Pa: a pressure jumps
    # over that within a step, and what it has lost there no balance has
    four, load = fs.Bundle([fs.MotorUnit(muscle, 4)]), (0.00824, 0.010376, 5.444)
    chamber = {"compliance": 4 * compliance, "dead_volume": 3.24e-6}
    plant = in_oil(four, dynamics.PrescribedMotion(*load), 1e-4, **chamber)
    run = dynamics.simulate(
        plant, np.full((180, 1), -0.6), start=dynamics.equilibrium_state(plant, 0.0)
    )
    result = happened(plant, run)
    assert ("folded" in result) == folds
    assert dynamics.audit(plant, run).closes == (not folds)
    if folds:
        assert result["folded"].samples == 1 and not result["folded"].trusted


def test_a_stiff_chamber_is_reported(single):
    plant = in_oil(single, dynamics.HangingMass(5.0), 1e-3, 8e5, compliance=1e-13)
    looked = dynamics.estimate_substeps(plant, 1e-3)
    assert looked.stiff and looked.substeps == 64 and looked.part == "a chamber and its valve"
    start = dynamics.equilibrium_state(plant, 1e5, position=0.01)
    result = happened(plant, dynamics.simulate(plant, np.ones((20, 1)), start=start))
    assert result["stiff"].first == 0 and not result["stiff"].trusted


@pytest.fixture(scope="module")
def stopped(single):
    """A light mass under air, with a stop."""
    load = dynamics.HangingMass(2.0, damping=60.0, stop=dynamics.Stop(high=0.01))
    return dynamics.Plant(
        single, load, fluid.ConstantSupply(413.7e3), fluid.AdiabaticWall(dead_volume=2e-6),
        fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip


def test_a_stop_holds_and_is_reported(stopped):
    run = dynamics.simulate(
        stopped, np.full((600, 1), 0.5), start=dynamics.equilibrium_state(stopped, 2e4)
    )
    event = happened(stopped, run)["stop"]
    assert event.trusted and 0 < event.first < event.last == run.time[-1]
    seen, load = run.outputs, stopped.load
    over = seen.position[-1] - 0.01
    # at rest its spring takes what the muscle pulls too much, and stores k s²/2
    assert_allclose(1e5 * over, seen.forces[-1, 0] - 2.0 * load.gravity, rtol=1e-4)
    place = dynamics.outputs.STORES.index("stop")
    assert_allclose(seen.store[-1, place], 1e5 * over**2 / 2, rtol=1e-9)
    assert np.all(seen.store[seen.position < 0.01, place] == 0)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("row", [5, -1])
def test_numbers_that_are_not_finite_close_no_balance(stopped, value, row):
    start = dynamics.equilibrium_state(stopped, 2e4)
    run = dynamics.simulate(stopped, np.zeros((10, 1)), start=start)
    assert dynamics.audit(stopped, run).closes
    ledger = np.array(run.ledger)
    ledger[row] = value
    balances = dynamics.audit(stopped, run._replace(ledger=ledger)).balances
    assert not any(balance.closes for balance in balances)


def test_a_strain_off_the_table_is_reported(stopped):
    plant = eqx.tree_at(lambda p: p.load.mass, stopped, np.float64(200.0))
    start = dynamics.equilibrium_state(plant, 1e5, position=0.0)
    run = dynamics.simulate(plant, np.zeros((600, 1)), start=start)
    result = happened(plant, run)
    assert not result["off_table"].trusted
    inside = run.time < result["off_table"].first
    assert np.all(run.outputs.position[inside] >= plant.stroke[0])


def test_an_accumulator_runs_empty(single):
    supply = fluid.Accumulator(2e-5, 1e5, 1.2e5)
    plant = dynamics.Plant(
        single, dynamics.HangingMass(2.0, damping=100.0), supply,
        fluid.LiquidChamber(compliance=1e-11), fluid.Orifice(2e-6),
    )  # fmt: skip
    # filled and emptied again and again
    command = np.where(np.arange(800) // 100 % 2, -1.0, 1.0)[:, None]
    run = dynamics.simulate(plant, command, start=dynamics.equilibrium_state(plant, 5e4))
    result = happened(plant, run)
    assert result["supply_empty"].trusted
    empty = run.time > result["supply_empty"].first
    drawn = np.trapezoid(run.outputs.drawn[:, 0], run.time)
    had = supply.initial_state()[0]
    # up to a step's flow
    assert_allclose(drawn, had, rtol=0.02)
    assert np.all(run.outputs.drawn[empty] <= 0)
    # it falls to its precharge, below which there is no liquid
    assert_allclose(run.outputs.supply_pressure[-1], 1e5, rtol=0.01)


def test_a_tank_loses_pressure(single):
    plant = dynamics.Plant(
        single, dynamics.HangingMass(2.0, damping=100.0),
        fluid.Tank(fluid.AdiabaticWall(), 1e-5, 2e5), fluid.AdiabaticWall(),
        fluid.SonicValve(2e-9, 0.3),
    )  # fmt: skip
    command = np.where(np.arange(800) // 100 % 2, -1.0, 1.0)[:, None]
    run = dynamics.simulate(plant, command, start=dynamics.equilibrium_state(plant, 5e4))
    result = happened(plant, run)
    assert set(result) <= {"supply_empty"}
    assert run.outputs.supply_pressure[-1] < 0.05 * 2e5
    # what left the tank is in the chamber or in the room
    vented = np.trapezoid(run.outputs.vented[:, 0], run.time)
    drawn = np.trapezoid(run.outputs.drawn[:, 0], run.time)
    held = run.outputs.masses[-1, 0] - run.outputs.masses[0, 0]
    # trapezoids over a step in which a valve turns
    assert_allclose(drawn - vented, held, rtol=0, atol=0.02 * drawn)


@pytest.mark.parametrize("fluid_name", [pytest.param("air", marks=pytest.mark.slow), "oil"])
def test_a_run_in_which_nothing_moves_closes(single, fluid_name):
    """All terms are roundings of the fluid's 3 J; a ten-billionth of them is more than that."""
    load, valve = dynamics.InertiaSpringDamper(2.0, 3e3), fluid.SonicValve(1e-9, 0.3)
    plant = in_oil(single, load, compliance=1e-11)
    if fluid_name == "air":
        supply = fluid.ConstantSupply(413.7e3)
        plant = dynamics.Plant(single, load, supply, fluid.AdiabaticWall(), valve)
    start = dynamics.equilibrium_state(plant, 1e5)
    run = dynamics.simulate(plant, np.zeros((200, 1)), start=start)
    assert np.ptp(run.outputs.position) < 1e-12
    assert dynamics.audit(plant, run).closes
    column = LEDGER.index("pull")
    ledger = np.array(run.ledger)
    ledger[-1, column] += 3e-10
    assert not dynamics.audit(plant, run._replace(ledger=ledger)).closes

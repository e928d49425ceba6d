"""Bundles in time against the oracle, where muscles are ideal and none buckles.

There a muscle's co-energy is P times a cubic in strain, which its bicubic table in √P holds
exactly, so that what is left over is the integrators' own.
"""

import dataclasses
import math

import numpy as np
import oracle_dynamics as oracle
import oracle_fluid
import oracle_muscle
import pytest
from from_oracle import library_muscle
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import dynamics, fluid
from fascicle.dynamics.outputs import LEDGER, STORES


IDEAL = oracle_muscle.Muscle(tension="ideal", material=oracle_muscle.SILICONE)
WIDE = dataclasses.replace(IDEAL, outer_radius=8e-3, braid_angle=math.radians(30))
SUPPLY = 413.7e3
PAIR = (oracle.Unit(IDEAL, 1, 2e-6, compliance=2e-11), oracle.Unit(WIDE, 3, 8e-6, compliance=8e-11))
SIDES = (oracle.Unit(IDEAL, 2, 4e-6), oracle.Unit(IDEAL, 2, 4e-6, side=-1))
MASS = oracle.Load(30.0, weight=30 * oracle.GRAVITY, damping=150.0)
SPRING = oracle.Load(8.0, stiffness=9e3, rest=-0.01, weight=60.0, damping=120.0)
JOINT = oracle.Load(0.02, radius=0.025, contraction=0.015, damping=0.1, pendulum=0.6)
OIL = oracle.Oil(1.4e9, 850.0, 6e-6)

# fills, holds, vents and fills again, by shares of what is open
UP_AND_DOWN = ((0.0, (1.0, 0.3)), (0.1, (0.0, 0.6)), (0.22, (-0.4, -0.2)), (0.35, (0.5, 0.0)))
TURN = ((0.0, (0.8, -0.05)), (0.12, (-0.15, 0.5)), (0.26, (0.1, 0.1)))
TIMES = np.linspace(0, 0.5, 101)

CASES = {
    "wall, mass": (oracle.Plant(PAIR, oracle.Air(0.5, 1.5e-9, 0.3), MASS, SUPPLY), UP_AND_DOWN),
    "isothermal, spring": (
        oracle.Plant(PAIR, oracle.Air(math.inf, 1.5e-9, 0.3), SPRING, SUPPLY), UP_AND_DOWN
    ),
    "wall, joint": (oracle.Plant(SIDES, oracle.Air(0.0, 1e-9, 0.25), JOINT, SUPPLY), TURN),
    "oil, mass": (oracle.Plant(PAIR, OIL, MASS, SUPPLY), UP_AND_DOWN),
}  # fmt: skip
BEGIN = 1.5e5  # gauge, in all units: enough to hold every load


def library_plant(plant, **options):
    """An oracle's plant as the library's."""
    units, load, filling = plant.units, plant.load, plant.filling
    bundles = [
        fs.Bundle(
            [fs.MotorUnit(library_muscle(u.muscle), u.count) for u in units if u.side == side]
        )
        for side in sorted({u.side for u in units}, reverse=True)
    ]
    if load is JOINT:
        weight = dynamics.AntagonisticJoint(
            load.inertia, load.radius, load.contraction, load.damping, load.pendulum
        )
    elif load.stiffness:
        weight = dynamics.InertiaSpringDamper(
            load.inertia, load.stiffness, load.damping, load.rest, load.weight
        )
    else:
        weight = dynamics.HangingMass(load.inertia, damping=load.damping)
    dead = {"dead_volume": np.array([u.dead_volume for u in units])}
    if isinstance(filling, oracle.Oil):
        liquid = fluid.Liquid(filling.density, filling.modulus, 1e-2)
        chamber = fluid.LiquidChamber(liquid, np.array([u.compliance for u in units]), **dead)
        valve = fluid.Orifice(filling.area, filling.density)
    else:
        isothermal = math.isinf(filling.conductance)
        chamber = (
            fluid.Isothermal(**dead)
            if isothermal
            else fluid.AdiabaticWall(filling.conductance, **dead)
        )
        valve = fluid.SonicValve(filling.C, filling.b)
    return dynamics.Plant(
        bundles if len(bundles) > 1 else bundles[0], weight, fluid.ConstantSupply(plant.supply),
        chamber, valve, **options,
    )  # fmt: skip


def _schedule(schedule):
    return dynamics.Schedule(*(list(column) for column in zip(*schedule, strict=True)))


@pytest.fixture(scope="module", params=CASES)
def ran(request):
    """An oracle's plant and run, the library's plant, schedule, start and simulation."""
    plant, schedule = CASES[request.param]
    expected = oracle.run(plant, schedule, TIMES, [BEGIN] * len(plant.units))
    ours = library_plant(plant)
    start = dynamics.equilibrium_state(ours, BEGIN)
    run = dynamics.simulate(ours, _schedule(schedule), duration=TIMES[-1], start=start)
    return plant, expected, ours, start, run, _schedule(schedule)


def _shortest(plant):
    return min(u.muscle.length for u in plant.units) / plant.load.radius


def _near(run, expected, plant):
    """To 1e-8 of strain and 1e-7 of the supply's pressure. 1e-7 of strain is asked for; of 1e-8
    adaptive steps may leave as much as their tolerance, fixed ones of 1 ms left 2e-10.
    """
    unit = _shortest(plant)
    assert np.all(run.outputs.status == 0)
    assert np.ptp(expected.position) > 0.02 * unit  # it moves
    assert_allclose(run.outputs.position / unit, expected.position / unit, rtol=0, atol=1e-8)
    assert_allclose(run.outputs.pressures / SUPPLY, expected.pressures / SUPPLY, rtol=0, atol=1e-7)
    assert_allclose(run.outputs.masses, expected.masses, rtol=1e-7)


def _every(run, step):
    pick = lambda x: x[::step]  # noqa: E731
    seen = run.outputs._replace(**{name: pick(x) for name, x in run.outputs._asdict().items()})
    return run._replace(outputs=seen, ledger=pick(run.ledger))


def test_a_plant_rests_where_the_oracle_s_does(ran):
    plant, expected, _, start, _, _ = ran
    assert_allclose(start.position, expected.position[0], rtol=0, atol=1e-14)
    masses = [oracle.mass(plant, unit, BEGIN, expected.position[0]) for unit in plant.units]
    assert_allclose(start.chambers[:, 0], masses, rtol=1e-12)


def test_fixed_steps_follow_the_oracle(ran):
    plant, expected, _, _, run, _ = ran
    _near(_every(run, 5), expected, plant)


def test_what_was_drawn_and_done_is_the_oracle_s(ran):
    plant, expected, _, _, run, _ = ran
    account = dict(zip(LEDGER, _every(run, 5).ledger.T, strict=True))
    # both from states that agree to 1e-7, summed up by quadratures of their own
    works = expected.works.sum(axis=1)
    assert_allclose(account["fluid_work"], works, rtol=0, atol=1e-7 * np.max(np.abs(works)))
    if isinstance(plant.filling, oracle.Oil):
        worth, _ = oracle_fluid.liquid_energies(OIL.density, OIL.modulus, SUPPLY)
        assert_allclose(account["supplied"], expected.drawn.sum(axis=1) * worth, rtol=1e-7)
        return
    worth = oracle_fluid.flow_exergy(SUPPLY + oracle_fluid.ROOM, oracle_fluid.WARM)
    assert_allclose(account["supplied"], expected.drawn.sum(axis=1) * worth, rtol=1e-7)
    stored = sum(
        np.array([
            oracle_fluid.stored_exergy(m, p, p * V / (m * oracle_fluid.R))
            for m, p, V in zip(
                expected.masses[::20, k], expected.pressures[::20, k] + oracle_fluid.ROOM,
                [oracle.volume(plant, unit, q) for q in expected.position[::20]], strict=True,
            )
        ])
        for k, unit in enumerate(plant.units)
    )  # fmt: skip
    assert_allclose(run.outputs.store[::100, STORES.index("fluid")], stored, rtol=1e-6)


def test_audits_close(ran):
    _, _, ours, _, run, _ = ran
    found = {b.name: b.relative_residual for b in dynamics.audit(ours, run).balances}
    assert found.pop("mass of the fluid") < 1e-12
    assert max(found.values()) < (1e-6 if ours.liquid else 1e-7)


@pytest.mark.parametrize("name", [pytest.param("wall, mass", marks=pytest.mark.slow), "oil, mass"])
def test_adaptive_steps_follow_the_oracle(name):
    plant, schedule = CASES[name]
    expected = oracle.run(plant, schedule, TIMES, [BEGIN] * len(plant.units))
    ours = library_plant(plant)
    start = dynamics.equilibrium_state(ours, BEGIN)
    run = dynamics.integrate(ours, _schedule(schedule), TIMES, start=start)
    _near(run, expected, plant)
    assert max(b.relative_residual for b in dynamics.audit(ours, run).balances) < 1e-7


@pytest.mark.slow  # compiles for half a minute
def test_the_exact_law_follows_the_oracle():
    plant, schedule = CASES["wall, joint"]
    expected = oracle.run(plant, schedule, TIMES, [BEGIN] * len(plant.units))
    ours = library_plant(plant, law="exact")
    start = dynamics.equilibrium_state(ours, BEGIN)
    run = dynamics.simulate(ours, _schedule(schedule), duration=TIMES[-1], start=start)
    _near(_every(run, 5), expected, plant)

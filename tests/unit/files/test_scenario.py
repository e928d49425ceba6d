"""Scenario files: what they say reaches the plant, and what can't be is refused by its key."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle import fluid
from fascicle.dynamics.muscles import ExactMuscles
from fascicle.files import example_text, loads_scenario
from fascicle.files.scenario import scenario_from_dict
from refusing import refuses


GAS, OIL, JOINT, PUMPED, RAMP = map(
    example_text, ("lift_gas", "lift_oil", "joint_step", "supply_is_pumped", "ramp_hand_over")
)


def edited(text, *edits):
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


def test_every_value_reaches_its_part():
    read = loads_scenario(GAS)
    plant = read.plant
    assert plant.counts.tolist() == [1, 4] and plant.units == 2 and not plant.liquid
    assert_allclose([plant.load.mass, plant.load.damping], [10.0, 100.0])
    assert_allclose([plant.load.stop.low, plant.load.stop.high], [-0.02, 0.03])
    assert_allclose(plant.chamber.dead_volume, [2e-6, 8e-6])
    assert_allclose(plant.chamber.conductance, 0.2)
    assert_allclose(plant.supply.pressure, 413.7e3)
    assert plant.valve == fluid.SonicValve(1e-9, 0.3) and plant.exhaust_valve == plant.valve
    assert (read.dt, read.duration, read.findings) == (1e-3, 6.0, ())
    assert read.schedule.times.tolist() == [0, 1, 2, 4, 5]
    assert read.schedule.commands.tolist() == [[1, 0], [0, 0], [0, 1], [0, -1], [-1, 0]]
    # at rest without pressure
    assert_allclose(plant.load.force(read.start.position), -98.0665)
    pull = plant.muscles.at(np.zeros(2), plant.strains(read.start.position)).force
    assert_allclose(np.sum(plant.counts * pull), 98.0665, rtol=1e-9)


def test_a_joint_turns_in_angles():
    plant = loads_scenario(JOINT).plant
    assert plant.sides == (0, 0, 1, 1)
    assert_allclose([plant.load.stop.low, plant.load.stop.high], np.radians([-60, 60]))
    assert_allclose(loads_scenario(JOINT).start.pressures, 100e3)


def test_water_and_nitrogen_flow_as_such():
    water = loads_scenario(edited(OIL, ('medium = "oil"', 'medium = "water"'))).plant
    assert_allclose(water.valve.density, fluid.WATER.reference_density)
    nitrogen = loads_scenario(edited(GAS, ('medium = "air"', 'medium = "nitrogen"'))).plant
    # through one hole, of gases of one γ, by the root of their densities: 1.185 kg/m³ of air
    assert_allclose(nitrogen.valve.reference_density, 1.185 * np.sqrt(287.05 / 296.80))
    assert nitrogen.chamber.gas == fluid.NITROGEN


def test_valve_takes_other_figures_of_its_data_sheet():
    before, C, after = GAS.partition('C = "0.1 L/(s*bar)"')
    for figure, conductance in (
        ('nominal_flow = "100 L/min"', fluid.conductance_from_nominal_flow("100 L/min", 0.3)),
        ('Kv = "0.07 m^3/h"', fluid.conductance_from_kv("0.07 m^3/h", 0.3)),
        ("Cv = 0.1", fluid.conductance_from_cv(0.1, 0.3)),
    ):
        assert_allclose(loads_scenario(before + figure + after).plant.valve.C, conductance)
        with refuses(f"valve.{figure.split()[0]}"):
            loads_scenario(f"{before}{C}\n{figure}{after}")
    with refuses("valve.C"):
        loads_scenario(before + after)


def test_room_reaches_every_part():
    warm = ("conductance =", 'room_temperature = "30 °C"\nroom_pressure = "90 kPa"\nconductance =')
    tank = ('kind = "constant"', 'kind = "tank"\nvolume = "5 L"')
    for edits in ([warm], [warm, tank]):
        plant = loads_scenario(edited(GAS, *edits)).plant
        state = plant.supply.initial_state()
        assert_allclose(plant.supply.temperature_at(state), 303.15)
        assert_allclose(plant.supply.pressure_at(state), 413.7e3)
        assert plant.chamber.room_pressure == 90e3


def test_a_pump_and_its_switch_reach_the_supply():
    warm = 'medium = "oil"\nroom_pressure = "90 kPa"'
    read = loads_scenario(edited(PUMPED, ('medium = "oil"', warm)))
    store = fluid.Accumulator(60e-6, 200e3, 413.7e3, room_pressure=90e3)
    pump = fluid.FixedPump(1e-6, 25.0, 0.92, 0.9, switch_on=350e3, switch_off=413.7e3)
    assert read.plant.supply == fluid.PumpedAccumulator(store, pump)
    always = edited(PUMPED, ('switch_on = "350 kPa"', ""), ('switch_off = "413.7 kPa"', ""))
    supply = loads_scenario(always.replace('"oil"', '"water"')).plant.supply
    assert supply.pump == fluid.FixedPump(1e-6, 25.0, 0.92, 0.9, fluid.WATER)


def test_bundle_is_inline_or_a_file(tmp_path):
    bundle = fs.example("kim2021_bundle_1_4")
    fs.save(bundle, tmp_path / "mine.toml")
    name = 'bundle = "kim2021_bundle_1_4"'
    (tmp_path / "a.toml").write_text(edited(GAS, (name, 'bundle = "mine.toml"')))
    inline = fs.files.dumps(bundle).replace("format = 1", "")
    (tmp_path / "b.toml").write_text(edited(GAS, (name, "")) + inline)
    for file in ("a.toml", "b.toml"):
        assert fs.load(tmp_path / file).plant.bundles == (bundle,)
    assert fs.load(tmp_path / "mine.toml") == bundle


def test_inexact_commands_have_notes():
    for time in ("7 s", "5.0005 s"):  # after the end, and between steps
        assert len(loads_scenario(edited(GAS, ('time = "5 s"', f'time = "{time}"'))).findings) == 1


@pytest.mark.parametrize("kind", ["{}", "1", '["constant"]'])
@pytest.mark.parametrize(
    ("table", "key", "name"),
    [
        ("load", "kind", "lift_gas"), ("fluid", "chamber", "lift_gas"),
        ("supply", "kind", "lift_gas"), ("valve", "kind", "lift_gas"),
        ("exhaust_valve", "kind", "lift_gas"), ("spool", "kind", "lift_gas"),
        ("hysteresis", "kind", "joint_gait"), ("supply.pump", "kind", "supply_is_pumped"),
        ("fluid", "medium", "lift_gas"), ("run", "law", "lift_gas"), ("run", "volume", "lift_gas"),
        ("control", "policy", "ramp_hand_over"), ("", "bundle", "lift_gas"),
        ("", "name", "lift_gas"),
    ],
)  # fmt: skip
def test_kind_must_be_a_name(table, key, name, kind):
    data = tomllib.loads(example_text(name))
    section = data
    for part in filter(None, table.split(".")):
        section = section.setdefault(part, {})
    section[key] = tomllib.loads(f"x = {kind}")["x"]
    dotted = f"{table}.{key}".lstrip(".")
    with refuses(dotted):
        scenario_from_dict(data, "x.toml", Path(), "x")


@pytest.mark.parametrize(
    "compliance", ["", 'compliance = "0 m^3/Pa"', 'compliance = ["0 m^3/Pa", "2e-11 m^3/Pa"]']
)
def test_incompressible_liquid_is_refused(compliance):
    text = re.sub(r"(?m)^compliance = .*$", compliance, example_text("lift_oil"))
    with refuses("fluid.compliance"):
        loads_scenario(text, "x.toml")


def test_runs_that_are_too_large_are_refused():
    rows = "[[bundle.motor_unit]]\ncount = 1\n" * 100
    many = RAMP.replace("[[bundle.motor_unit]]\ncount = 1\n", rows, 1)
    many = edited(many, ('["265 kPa", "0 kPa"]', '"0 kPa"'), ('"2 s"', '"500 s"'))
    with refuses("run.duration"):
        loads_scenario(many, "x.toml")


def test_exact_law_runs_at_rest():
    plant = loads_scenario(edited(GAS, ('dt = "1 ms"', 'dt = "1 ms"\nvolume = "geometric"'))).plant
    units = [unit.muscle for unit in plant.bundles[0].motor_units]
    exact = ExactMuscles.from_muscles(units, 5e5, plant.muscles.strains)
    P, strain = np.array([[1e5, 2e5], [0.0, 4e5]]), np.array([0.05, 0.1])
    of_units = [[m.force(p, e) for m, p, e in zip(units, row, strain, strict=True)] for row in P]
    assert_allclose(exact.at(P, strain).force, of_units, rtol=1e-12)

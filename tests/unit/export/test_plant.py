"""A plant's unit for co-simulation moves as `simulate` does.

Both have the same table, equations and steps, so that they differ by rounding alone. It grows in
the table's second differences, to some 1e-10 of an output, and is allowed a hundred times as much:
far less than what the table's own error, stated in the unit's header, makes of a run.
"""

import math
import shutil

import numpy as np
import pytest

import fascicle as fs
from fascicle import dynamics, fluid
from fascicle.core.module import with_fields
from fascicle.dynamics.muscles import MuscleTables
from fascicle.export import write_plant_fmu
from fascicle.export.c_files import table_strains


fmpy = pytest.importorskip("fmpy", reason="FMPy runs the units")
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc to build it with")
SUPPLY, ROUNDING = 413.7e3, 1e-8
CONSTANT = fluid.ConstantSupply(SUPPLY)
SHAPE = (33, 41)


def muscle():
    return fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33))


def bundle(*counts):
    return fs.Bundle([fs.MotorUnit(muscle(), count) for count in counts])


def lifted():
    """Air behind a wall, with hoses, lifts a mass against its stop."""
    hose = fluid.Line(0.5, 2.5e-3)
    stop = dynamics.Stop(-0.02, 0.015, 2e4, 50.0)
    return dynamics.Plant(
        bundle(1, 4), dynamics.HangingMass(10.0, damping=100.0, stop=stop), CONSTANT,
        fluid.AdiabaticWall(0.5, dead_volume=np.array([2e-6, 8e-6])),
        fluid.SonicValve(np.array([1e-9, 4e-9]), 0.3, line=hose), shape=SHAPE,
    )  # fmt: skip


def oiled():
    """Oil through orifices with hoses and lagging spools."""
    return dynamics.Plant(
        bundle(1, 4), dynamics.HangingMass(10.0, damping=200.0), CONSTANT,
        fluid.LiquidChamber(compliance=2e-11), fluid.Orifice(1e-6, line=fluid.Line(0.5, 3e-3)),
        fluid.Orifice(2e-6), fluid.Servovalve(5e-3, 0.05), shape=SHAPE,
    )  # fmt: skip


def pulsed():
    """On/off valves with a dead time, while a dynamometer moves the plates."""
    return dynamics.Plant(
        bundle(2, 3), dynamics.PrescribedMotion(0.015, 0.005, 3.0), CONSTANT,
        fluid.Isothermal(dead_volume=5e-6), fluid.SonicValve(1e-9, 0.25, 0.6),
        fluid.SonicValve(2e-9, 0.4), fluid.Solenoid(0.02, 2e-3, 3e-3, dead_time=0.012), shape=SHAPE,
    )  # fmt: skip


def sprung():
    """Nitrogen pulls a spring, past an overlap of the spool, after a dead time."""
    return dynamics.Plant(
        bundle(1), dynamics.InertiaSpringDamper(2.0, 3000.0, 30.0, 0.002, 5.0), CONSTANT,
        fluid.Isothermal(gas=fluid.NITROGEN, dead_volume=1e-5), fluid.SonicValve(2e-9, 0.3),
        spool=fluid.Direct(0.1, dead_time=7e-3), shape=SHAPE,
    )  # fmt: skip


def unlike():
    """Water in unlike muscles, of which one is shorter, held by a dynamometer."""
    short = fs.Muscle(0.12, 5e-3, 1.2e-3, math.radians(30))
    both = fs.Bundle([fs.MotorUnit(muscle(), 1), fs.MotorUnit(short, 2)], length=0.127)
    plant = dynamics.Plant(
        both, dynamics.PrescribedMotion(0.01), CONSTANT,
        fluid.LiquidChamber(fluid.WATER, compliance=2e-11), fluid.Orifice(5e-7, 998.21),
        spool=fluid.Servovalve(np.array([5e-3, 8e-3])), shape=SHAPE,
    )  # fmt: skip
    # a bundle's table in C goes on to where no unit pulls any more
    muscles = [unit.muscle for unit in both.motor_units]
    top = float(np.max(plant.muscles.highest_pressure))
    return with_fields(
        plant, muscles=MuscleTables.from_muscles(muscles, top, SHAPE, table_strains(both))
    )


PLANTS = {"gas": lifted, "oil": oiled, "pulses": pulsed, "spring": sprung, "unlike": unlike}


def commands(plant, steps, seed=3):
    """Commands that change every 25 steps, a third of them to a shut valve."""
    rng = np.random.default_rng(seed)
    levels = rng.uniform(-1, 1, (steps // 25 + 1, plant.units))
    levels[rng.uniform(size=levels.shape) < 1 / 3] = 0.0
    levels[0] = 0.8
    return np.repeat(levels, 25, axis=0)[:steps]


class Host:
    """A host of a plant's unit."""

    def __init__(self, plant, load_unit, path, **options):
        self.unit, self.references = load_unit(write_plant_fmu(plant, path, "bench", **options))
        self.units = plant.units

    def get(self, *names):
        return np.array(self.unit.getReal([self.references[name] for name in names]))

    def set(self, **values):
        self.unit.setReal([self.references[name] for name in values], list(values.values()))

    def row(self):
        per_unit = ("pressure", "temperature")
        names = [f"{name}_{i + 1}" for name in per_unit for i in range(self.units)]
        return self.get("position", "velocity", "force", *names, "supply_flow")

    def run(self, rows, dt, start=0.0):
        """Outputs and status at the start, and after each row of commands."""
        outputs, statuses = [], []
        for k in range(len(rows) + 1):
            self.set(**{f"command_{i + 1}": x for i, x in enumerate(rows[min(k, len(rows) - 1)])})
            outputs.append(self.row())
            statuses += self.unit.getInteger([self.references["status"]])
            if k < len(rows):
                self.unit.doStep(start + k * dt, dt)
        return np.array(outputs), np.array(statuses)


def expected(run):
    """Outputs of a run in the order of `Host.row`."""
    out = run.outputs
    pull = np.sum(out.forces, axis=-1)
    columns = out.position, out.velocity, pull, out.pressures, out.temperatures
    return np.column_stack([*columns, np.sum(out.drawn, axis=-1)])


@pytest.mark.parametrize("name", PLANTS)
def test_a_unit_moves_as_simulate_does(name, load_unit, tmp_path):
    plant, dt = PLANTS[name](), 1e-3
    start = dynamics.equilibrium_state(plant, 80e3)
    rows = commands(plant, 300)
    run = dynamics.simulate(plant, rows, dt=dt, start=start)
    host = Host(plant, load_unit, tmp_path / "bench.fmu", start=start, dt=dt)
    outputs, statuses = host.run(rows, dt)
    reference = expected(run)
    # the flow at an output is that of the command from then on, which waits for a dead time
    columns = slice(None) if plant.spool.dead_time == 0 else slice(-1)
    outputs, reference = outputs[:, columns], reference[:, columns]
    scale = np.max(np.abs(reference), axis=0)
    assert np.all(np.ptp(run.outputs.pressures, axis=0) > 5e3)  # Pa: the valves did something
    assert np.max(np.abs(outputs - reference) / np.maximum(scale, 1e-9)) < ROUNDING
    np.testing.assert_array_equal(statuses, run.outputs.status)
    if name == "gas":
        assert np.any(statuses == 32)  # at its stop


def test_a_unit_validates_and_compiles_without_a_warning(load_unit, compile_c, tmp_path):
    from fmpy.validation import validate_fmu

    for name, make in PLANTS.items():
        path = write_plant_fmu(make(), tmp_path / f"{name}.fmu", "bench")
        assert validate_fmu(str(path)) == []
        fmpy.extract(str(path), str(tmp_path / name))
        compile_c(tmp_path / name / "sources" / "bench.c", ("-O0",))


def test_the_hosts_step_is_divided(load_unit, tmp_path):
    """Ten milliseconds at once are ten steps of one, and a reset begins again."""
    plant, dt = lifted(), 1e-3
    rows = np.repeat(commands(plant, 300)[::25][:6], 10, axis=0)
    host = Host(plant, load_unit, tmp_path / "bench.fmu", dt=dt)
    fine, _ = host.run(rows, dt, start=0.0)
    host.unit.reset()
    host.unit.setupExperiment(startTime=2.0)
    coarse, _ = host.run(rows[::10], 10 * dt, start=2.0)
    np.testing.assert_allclose(coarse[:, :-1], fine[::10, :-1], rtol=ROUNDING, atol=1e-12)


def test_a_dead_time_needs_no_whole_steps(load_unit, tmp_path):
    """A command that comes within a step acts when its dead time is over."""
    plant = with_fields(sprung(), spool=fluid.Direct(0.1, dead_time=3.4e-3))
    late = with_fields(plant, spool=fluid.Direct(0.1, dead_time=3e-3))
    rows = np.array([[0.0]] + [[1.0]] * 30)
    run = dynamics.simulate(late, rows, dt=1e-3)
    host = Host(plant, load_unit, tmp_path / "bench.fmu")
    outputs, _ = host.run(rows, 1e-3)
    # its pressure is that of 3 ms, 0.4 ms ago
    at = 1e-3 * np.arange(len(rows) + 1)
    expected_pressure = np.interp(at - 0.4e-3, at, run.outputs.pressures[:, 0])
    bend = np.max(np.abs(np.diff(run.outputs.pressures[:, 0], 2))) / 8 + 1.0  # of interpolation
    filling = at > 5e-3
    error = outputs[filling, 3] - expected_pressure[filling]
    assert np.max(np.abs(error)) < bend
    assert np.ptp(run.outputs.pressures) > 20 * bend


def test_force_and_supply_are_inputs(load_unit, tmp_path):
    """A further force is that outside a load, and the supply's pressure is that of another one."""
    dt, pressure, force = 1e-3, 0.8 * SUPPLY, -20.0
    plant = sprung()
    other = with_fields(
        plant, supply=fluid.ConstantSupply(pressure),
        load=dynamics.InertiaSpringDamper(2.0, 3000.0, 30.0, 0.002, 5.0 - force),
    )  # fmt: skip
    start = dynamics.equilibrium_state(plant)
    rows = commands(plant, 100)
    run = dynamics.simulate(other, rows, dt=dt, start=start)
    host = Host(plant, load_unit, tmp_path / "bench.fmu", start=start, dt=dt)
    host.set(load_force=force, supply_pressure=pressure)
    outputs, _ = host.run(rows, dt)
    reference = expected(run)[:, :-1]
    scale = np.max(np.abs(reference), axis=0)
    assert np.max(np.abs(outputs[:, :-1] - reference) / scale) < ROUNDING


def test_the_step_error_is_far_below_the_tables(load_unit, tmp_path):
    """Against steps a sixteenth as long, whose own error is nothing beside it: a method of fourth
    order leaves 16^4 times less. It was 7e-7 of the velocity, and the table's is 1e-4 of the force.
    """
    host = Host(lifted(), load_unit, tmp_path / "bench.fmu")
    ends = []
    for step in (1e-3, 1e-3 / 32):
        host.unit.reset()
        host.unit.setupExperiment(startTime=0.0)
        outputs, _ = host.run(np.full((round(0.06 / step), 2), 0.05), step)
        ends.append(outputs[-1, :5])
    np.testing.assert_allclose(*ends, rtol=1e-5)


def test_commands_out_of_range_fail(load_unit, tmp_path):
    host = Host(sprung(), load_unit, tmp_path / "bench.fmu")
    for value in (1.01, -2.0, math.nan):
        host.set(command_1=value)
        with pytest.raises(Exception, match="fmi2DoStep failed with status 3"):
            host.unit.doStep(0.0, 1e-3)


@pytest.mark.parametrize(
    ("part", "value"),
    [
        ("supply", fluid.Tank(fluid.Isothermal(), 1e-3, SUPPLY)),
        ("hysteresis", dynamics.Coulomb(1e3, 1e-3)),
        ("damping", dynamics.Damping(1.0, 1.0)),
        ("load", dynamics.AntagonisticJoint(0.01, 0.02, 0.0)),
        ("muscles", None),
    ],
)
def test_parts_that_it_does_not_have_are_refused_by_name(tmp_path, part, value):
    plant = with_fields(sprung(), **{part: value})
    with pytest.raises(fs.InvalidInputError) as error:
        write_plant_fmu(plant, tmp_path / "bench.fmu")
    assert error.value.argument == part
    assert not (tmp_path / "bench.fmu").exists()

"""A cascade's step in C is Python's, step by step."""

import ctypes
import re

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle import control, dynamics, fluid
from fascicle.export import table_code, tabulate_controller, write_table


SUPPLY = 413.7e3
SHAPE = (33, 41)
TOLERANCE = 1e-12
# besides, the rounding of (K3), in Python too: contents differ over 1 kPa and 1e-4
ROUNDING = 8 * np.finfo(float).eps
NUMBER, ARRAY = ctypes.c_double, ctypes.c_double * 3


def make_plant(chamber=None, valve=None):
    muscle = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)
    thicker = fs.Muscle(0.127, 8e-3, 2e-3, 0.55)
    units = [fs.MotorUnit(muscle), fs.MotorUnit(thicker, 2), fs.MotorUnit(muscle)]
    return dynamics.Plant(
        fs.Bundle(units, SUPPLY), dynamics.HangingMass(3.0), fluid.ConstantSupply(SUPPLY),
        chamber or fluid.Isothermal(dead_volume=np.array([1e-6, 5e-6, 2e-6])),
        valve or fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip


CASES = {
    "orderly": ("orderly", {}),
    "threshold": ("threshold", {}),
    "hand_over": ("hand_over", {}),
    "hose": ("threshold", {"valve": fluid.SonicValve(1e-9, 0.3, line=fluid.Line(1.0, 4e-3))}),
    "wall": ("orderly", {"chamber": fluid.AdiabaticWall(0.5, dead_volume=3e-6)}),
}


MEMORY = "force_integral recruited direction withheld disturbance demand rate samples"


class Memory(ctypes.Structure):
    _fields_ = tuple((name, NUMBER) for name in MEMORY.split())


class FloatMemory(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_float) for name in MEMORY.split())


KINDS = {"double": (NUMBER, Memory), "float": (ctypes.c_float, FloatMemory)}
CONVERSIONS = ("-O2", "-Wdouble-promotion", "-Wconversion")


def step_in_c(library, precision, memory, demand, force, pressures, supply, strain, rate):
    """Commands of one step."""
    kind, _ = KINDS[precision]
    command = (kind * len(pressures))()
    measured = map(kind, (demand, force)), map(kind, (supply, strain, rate))
    point = *measured[0], (kind * len(pressures))(*pressures), *measured[1]
    assert library.knee_step(ctypes.byref(memory), *point, command) == 0
    return np.array(command)


def measure(rng, count):
    """A demand that rises and falls beyond the reachable, and noisy measurements."""
    demand = 180 + 260 * np.sin(np.linspace(0, 14, count)) + rng.normal(0, 2, count)
    strain = 0.12 + 0.1 * np.sin(np.linspace(0, 9, count))
    rate = rng.normal(0, 0.3, count)
    force = demand + rng.normal(0, 20, count)
    pressures = rng.uniform(-2e3, 1.1 * SUPPLY, (count, 3))
    supply = rng.uniform(0.8, 1.0, count) * SUPPLY
    return zip(demand, force, pressures, supply, strain, rate, strict=True)


def slopes_over_flow(units, P, supply, strain, rate, command):
    """Factor of a content's relative rounding in (K3), which differs over 1 kPa and 1e-4."""
    m, flows = units.fluid_mass(P, strain + 0 * P), units.valve_flows(P, supply + 0 * P)
    flow = np.maximum(np.where(command > 0, *flows), 1e-9)
    return m * (SUPPLY / (1e3 * 3e-3) + abs(rate) / 1e-4) / flow


# each case compiles its step in Python; two of them run always
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=() if case in ("hose", "hand_over") else pytest.mark.slow)
        for case in CASES
    ],
)
def test_a_step_in_c_equals_python(case, compile_c, tmp_path):
    policy, options = CASES[case]
    plant = make_plant(**options)
    gains = control.Gains(force=0.3, force_integral=40.0)
    cascade = control.cascade(plant, policy, gains=gains, dt=1e-3, flow_limit=0.8)
    library = compile_c(write_table(cascade, tmp_path, "knee", shape=SHAPE)[1])
    controller = tabulate_controller(cascade, SHAPE)
    memory, c_memory = controller.memory, Memory(0.0, 1.0)
    act = jax.jit(controller.__call__)
    length, units = float(plant.bundles[0].length), controller.units[0]
    recruited, exact, saturated, limited = set(), 0, 0, 0
    for demand, force, P, supply, strain, rate in measure(np.random.default_rng(11), 600):
        point = dynamics.Measurement(0.0, strain * length, rate * length, P, force, supply)
        integral = float(memory.force_integral)
        memory, expected = act(memory, point, demand)
        command = step_in_c(library, "double", c_memory, demand, force, P, supply, strain, rate)
        error = np.abs(command - expected)
        rounding = ROUNDING * slopes_over_flow(units, P, supply, strain, rate, expected)
        assert np.all(error <= TOLERANCE + rounding)
        exact += np.all(error <= TOLERANCE)
        np.testing.assert_allclose(c_memory.force_integral, memory.force_integral, rtol=1e-12)
        walk = memory.policies[0]
        if policy == "hand_over":
            np.testing.assert_allclose(c_memory.disturbance, memory.disturbance, rtol=1e-9)
            np.testing.assert_allclose(c_memory.rate, memory.rate, rtol=1e-9)
            np.testing.assert_allclose(c_memory.withheld, walk.withheld, atol=1e-9)
            np.testing.assert_allclose(c_memory.recruited, walk.recruited, atol=1e-12)
            assert c_memory.direction == walk.direction
        else:
            assert c_memory.recruited == float(walk)
        recruited.add(c_memory.recruited // 1)
        saturated += integral == float(memory.force_integral)
        limited += np.any(np.abs(expected) == 0.8)
    # all numbers of units occurred (`hand_over` takes the second at once), anti-windup and limits
    at_all = {2.0, 3.0} if policy == "hand_over" else {1.0, 2.0, 3.0}
    assert recruited == at_all and saturated > 10 and limited > 20
    assert exact > 500  # of 600 steps


def test_a_step_in_single_precision_is_that_in_double(compile_c, tmp_path):
    gains = control.Gains(force=0.3, force_integral=40.0)
    cascade = control.cascade(make_plant(), "hand_over", gains=gains, flow_limit=0.8)
    runs, units = {}, cascade.units[0]
    for precision, (_, memory_of) in KINDS.items():
        paths = write_table(cascade, tmp_path / precision, "knee", precision, shape=SHAPE)
        library, memory = compile_c(paths[1], CONVERSIONS), memory_of(0.0, 1.0)
        runs[precision] = []
        for measured in measure(np.random.default_rng(11), 600):
            # the same measurements: that of a pressure is rounded to 0.03 Pa
            row = [np.float32(x).astype(float) for x in measured]
            runs[precision].append(step_in_c(library, precision, memory, *row))
    rounding = np.finfo(np.float32).eps
    rows = zip(measure(np.random.default_rng(11), 600), *runs.values(), strict=True)
    for (_, _, P, supply, strain, rate), expected, command in rows:
        slopes = slopes_over_flow(units, P, supply, strain, rate, expected)
        assert np.all(np.abs(command - expected) <= 8 * rounding * (1 + slopes))
    assert np.ptp(runs["float"]) > 1


@pytest.mark.slow
def test_twenty_ramps_of_hand_over_in_c_equal_python(compile_c, tmp_path):
    rng, steps = np.random.default_rng(5), 1500
    muscle = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)], SUPPLY)
    valve = fluid.SonicValve(np.array([1e-9, 4e-9]), 0.3)
    held = dynamics.PrescribedMotion(0.0254)
    parts = held, fluid.ConstantSupply(SUPPLY), fluid.Isothermal(), valve
    plant = dynamics.Plant(bundle, *parts, spool=fluid.Servovalve(2e-3))
    controller = control.cascade(plant, "hand_over")
    # by default the C has the table of Python's controller: on another one it decides otherwise
    shapes = {"default": None, "double": SHAPE, "float": SHAPE}
    precisions = {"default": "double", "double": "double", "float": "float"}
    libraries = {
        key: compile_c(
            write_table(controller, tmp_path / key, "knee", precisions[key], shape=shape)[1]
        )
        for key, shape in shapes.items()
    }
    start = dynamics.equilibrium_state(plant, [201e3, 0.0])
    header = (tmp_path / "float" / "knee.h").read_text()
    stated = float(re.search(r"commands are off by up to ([\d.e+-]+) of a full opening", header)[1])
    crossed = 0

    def play(key, *rows):
        """Commands at each step, and units recruited at the end."""
        memory = KINDS[precisions[key]][1](0.0, 1.0)
        still = SUPPLY, 0.2, 0.0
        commands = [
            step_in_c(libraries[key], precisions[key], memory, *row, *still)
            for row in zip(*rows, strict=True)
        ]
        return np.array(commands), memory.recruited

    for _ in range(20):
        low, high = rng.uniform(2.0, 30.0), rng.uniform(35.0, 110.0)
        ramp = np.clip(np.linspace(0, rng.uniform(1.2, 4.0), steps), 0, 1) * (high - low) + low
        run = dynamics.simulate(plant, controller, ramp, start=start)
        force = np.asarray(run.outputs.forces).sum(axis=-1)[:steps]
        rows = ramp, force, np.asarray(run.outputs.pressures)[:steps]
        commands, recruited = play("default", *rows)
        np.testing.assert_allclose(commands, run.commands[:steps], rtol=0, atol=1e-9)
        rounded = [np.float32(row).astype(float) for row in rows]
        single, _ = play("float", *rounded)
        np.testing.assert_allclose(single, play("double", *rounded)[0], rtol=0, atol=stated)
        crossed += recruited == 2.0
    assert crossed > 10


def test_outside_of_the_table_its_valves_are_shut(compile_c, tmp_path):
    cascade = control.cascade(make_plant(), "orderly")
    library = compile_c(write_table(cascade, tmp_path, "knee", shape=SHAPE)[1])
    memory, command = Memory(7.0, 2.0), ARRAY(1, 1, 1)
    code = library.knee_step(
        ctypes.byref(memory), NUMBER(50.0), NUMBER(10.0), ARRAY(1e5, 1e5, 1e5), NUMBER(SUPPLY),
        NUMBER(0.7), NUMBER(0.0), command,
    )  # fmt: skip
    assert code == 1 and list(command) == [0, 0, 0]
    assert (memory.force_integral, memory.recruited) == (7.0, 2.0)
    library.knee_begin(ctypes.byref(memory))
    assert (memory.force_integral, memory.recruited) == (0.0, 1.0)


def test_unsupported_controllers_are_refused():
    plant = make_plant()
    for cascade, options, argument in (
        (control.cascade(plant, "batch"), {}, "controller"),
        (control.cascade(plant, "orderly", "position", control.Gains(1e3)), {}, "controller"),
        (control.cascade(plant, "orderly"), {"precision": "half"}, "precision"),
    ):
        with pytest.raises(fs.InvalidInputError) as error:
            table_code(cascade, **options)
        assert error.value.argument == argument

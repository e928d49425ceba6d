"""A cascade's step in C is Python's, step by step."""

import ctypes

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle import control, dynamics, fluid
from fascicle.export import on_table, table_code, write_table


SUPPLY = 413.7e3
SHAPE = (33, 41)
NEAR = 1e-12
# beside it what rounding leaves of (K3) in Python, too: contents differ over 1 kPa and 1e-4
ROUNDED = 8 * np.finfo(float).eps


def plant(chamber=None, valve=None, load=None):
    muscle = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)
    other = fs.Muscle.from_dimensions(0.127, 8e-3, 2e-3, 0.55)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(other, 2), fs.MotorUnit(muscle)], SUPPLY)
    return dynamics.Plant(
        bundle, load or dynamics.HangingMass(3.0), fluid.ConstantSupply(SUPPLY),
        chamber or fluid.Isothermal(dead_volume=np.array([1e-6, 5e-6, 2e-6])),
        valve or fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip


CASES = {
    "orderly": ("orderly", {}),
    "threshold": ("threshold", {}),
    "polytropic": ("threshold", {"chamber": fluid.Polytropic(1.2, dead_volume=3e-6)}),
    "hose": ("threshold", {"valve": fluid.SonicValve(1e-9, 0.3, line=fluid.Line(1.0, 4e-3))}),
    "wall": ("orderly", {"chamber": fluid.AdiabaticWall(0.5, dead_volume=3e-6)}),
}


class Memory(ctypes.Structure):
    _fields_ = (("force_integral", ctypes.c_double), ("recruited", ctypes.c_double))


def measured(rng, count):
    """A demand that rises and falls beyond what can be given, and measurements that wander."""
    demand = 180 + 260 * np.sin(np.linspace(0, 14, count)) + rng.normal(0, 2, count)
    strain = 0.12 + 0.1 * np.sin(np.linspace(0, 9, count))
    rate = rng.normal(0, 0.3, count)
    force = demand + rng.normal(0, 20, count)
    pressures = rng.uniform(-2e3, SUPPLY, (count, 3))
    supply = rng.uniform(0.8, 1.0, count) * SUPPLY
    return demand, force, pressures, supply, strain, rate


@pytest.mark.parametrize(
    "case",  # each compiles Python's step for itself
    [pytest.param(case, marks=() if case == "hose" else pytest.mark.slow) for case in CASES],
)
def test_a_step_in_c_is_pythons(case, compiled, tmp_path):
    policy, parts = CASES[case]
    moved = plant(**parts)
    gains = control.Gains(force=0.3, force_integral=40.0)
    made = control.cascade(moved, policy, gains=gains, dt=1e-3, flow_limit=0.8)
    _, source = write_table(made, tmp_path, "knee", shape=SHAPE)
    step = compiled(source).knee_step
    known = on_table(made, SHAPE)
    memory, remembered = known.memory, Memory(0.0, 1.0)
    act = jax.jit(known.__call__)
    length = float(moved.bundles[0].length)
    array, number = ctypes.c_double * 3, ctypes.c_double
    rng = np.random.default_rng(11)
    units, near = known.units[0], 0
    seen_recruited, still, at_limit = set(), 0, 0
    for demand, force, P, supply, strain, rate in zip(*measured(rng, 600), strict=True):
        at = dynamics.Measurement(0.0, strain * length, rate * length, P, force, supply)
        before = float(memory.force_integral)
        memory, expected = act(memory, at, demand)
        got = array()
        code = step(
            ctypes.byref(remembered), number(demand), number(force), array(*P), number(supply),
            number(strain), number(rate), got,
        )  # fmt: skip
        assert code == 0
        m, flows = units.content(P, strain + 0 * P), units.flows(P, supply + 0 * P)
        passed = np.maximum(np.where(expected > 0, *flows), 1e-9)
        rounded = ROUNDED * m * (SUPPLY / (1e3 * 3e-3) + abs(rate) / 1e-4) / passed
        off = np.abs(np.array(got) - expected)
        assert np.all(off <= NEAR + rounded)
        near += np.all(off <= NEAR)
        np.testing.assert_allclose(remembered.force_integral, memory.force_integral, rtol=1e-12)
        assert remembered.recruited == float(memory.policies[0].recruited)
        seen_recruited.add(remembered.recruited)
        still += before == float(memory.force_integral)
        at_limit += np.any(np.abs(expected) == 0.8)
    # all of it has been at work: every number of units, the anti-windup, the valves' limit
    assert seen_recruited == {1.0, 2.0, 3.0} and still > 20 and at_limit > 20
    assert near > 500  # of 600 steps


def test_outside_of_the_table_its_valves_are_shut(compiled, tmp_path):
    made = control.cascade(plant(), "orderly")
    lib = compiled(write_table(made, tmp_path, "knee", shape=SHAPE)[1])
    memory, got = Memory(7.0, 2.0), (ctypes.c_double * 3)(1, 1, 1)
    number = ctypes.c_double
    outside = (ctypes.c_double * 3)(1e5, 1e5, 1e5), number(SUPPLY), number(0.7), number(0.0), got
    assert lib.knee_step(ctypes.byref(memory), number(50.0), number(10.0), *outside) == 1
    assert list(got) == [0, 0, 0] and (memory.force_integral, memory.recruited) == (7.0, 2.0)
    lib.knee_begin(ctypes.byref(memory))
    assert (memory.force_integral, memory.recruited) == (0.0, 1.0)


def test_what_c_does_not_do_is_refused():
    made = plant()
    for controller, words in (
        (control.cascade(made, "hand_over"), "take orderly or threshold"),
        (control.cascade(made, "orderly", of="position"), "close that loop around one of force"),
        (control.cascade(made, "orderly", delay=2e-3), "has a delay"),
    ):
        with pytest.raises(ValueError, match=f"can't be written as C.*{words}"):
            table_code(controller)
    with pytest.raises(ValueError, match="`precision` must be double of a controller"):
        table_code(control.cascade(made, "orderly"), precision="float")

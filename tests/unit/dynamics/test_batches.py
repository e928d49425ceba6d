"""Many runs at once, and slopes of many, under a caller's own `jit`, `vmap` and `grad`: those of
the runs alone, of every kind of part.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle import dynamics, fluid


SUPPLY, RUNS, STEPS = 413.7e3, 5, 60
HOSES = {"compliance": np.array([2e-11, 8e-11]), "dead_volume": np.array([2e-6, 8e-6])}
MASS = dynamics.HangingMass(12.0, damping=300.0)
STOP = dynamics.Stop(high=0.012, stiffness=2e5, damping=200.0)
TURN = dynamics.AntagonisticJoint(0.02, 0.025, 0.015, damping=0.1, gravity_moment=0.6)
ACCUMULATOR = fluid.Accumulator(2e-4, 2e5, SUPPLY)
PUMPED = fluid.PumpedAccumulator(ACCUMULATOR, fluid.FixedPump(1e-6, 25.0))

OF_GAS = {
    "wall": {},
    "isothermal": {"chamber": fluid.Isothermal(dead_volume=HOSES["dead_volume"])},
    "hose": {"valve": fluid.SonicValve(2e-9, 0.3, line=fluid.Line(1.0, 0.002))},
    "tank": {"supply": fluid.Tank(fluid.AdiabaticWall(0.5), 1e-3, SUPPLY)},
    "servovalve": {"spool": fluid.Servovalve(0.01, overlap=0.05)},
    "spring and stop": {"load": dynamics.InertiaSpringDamper(8.0, 5e3, 120.0, stop=STOP)},
    "motion": {"load": dynamics.PrescribedMotion(0.012, 0.005, 5.0)},
    "slip": {"hysteresis": dynamics.MaxwellSlip([2e4, 4e4], [3.0, 1.5])},
    "dahl": {"hysteresis": dynamics.Dahl(2e4, 3.0)},
    "coulomb": {"hysteresis": dynamics.Coulomb(5e3)},
    "straight volume": {"volume": "geometric"},
}
OF_OIL = {"oil": {}, "accumulator": {"supply": ACCUMULATOR}, "pump": {"supply": PUMPED}}


def made(name, muscle):
    """A plant by its name."""
    bundle = fs.Bundle([fs.MotorUnit(muscle, 1), fs.MotorUnit(muscle, 4)])
    if name == "joint":
        pair = fs.Bundle([fs.MotorUnit(muscle, 2)])
        air = fluid.AdiabaticWall(dead_volume=4e-6)
        return dynamics.Plant(
            [pair, pair], TURN, fluid.ConstantSupply(SUPPLY), air, fluid.SonicValve(1e-9, 0.25)
        )
    if name in OF_OIL:
        chamber, valve, given = fluid.LiquidChamber(**HOSES), fluid.Orifice(6e-6), OF_OIL[name]
    else:
        chamber = fluid.AdiabaticWall(0.5, dead_volume=HOSES["dead_volume"])
        valve, given = fluid.SonicValve(2e-9, 0.3), OF_GAS[name]
    parts = {"load": MASS, "supply": fluid.ConstantSupply(SUPPLY), "chamber": chamber}
    return dynamics.Plant(bundle, **{**parts, "valve": valve, **given})


def same(result, expected, tolerance):
    """All numbers agree, relative to the largest of each array."""
    for x, y in zip(jax.tree.leaves(result), jax.tree.leaves(expected), strict=True):
        if np.issubdtype(np.asarray(y).dtype, float):
            size = np.max(np.abs(y), initial=1e-12)
            assert_allclose(x, y, rtol=0, atol=tolerance * size)
        else:
            assert_array_equal(x, y)


slow = [pytest.param(name, marks=pytest.mark.slow) for name in [*OF_GAS, *OF_OIL, "joint"]]


@pytest.mark.parametrize(
    "name", ["isothermal", *(case for case in slow if case.values != ("isothermal",))]
)
def test_a_batch_of_runs_equals_single_runs(name, muscle):
    plant = made(name, muscle)
    start = dynamics.equilibrium_state(plant, 1.5e5)
    commands = np.random.default_rng(7).uniform(-1, 1, (RUNS, STEPS, plant.units))

    def ran(rows):
        run = dynamics.simulate(plant, rows, start=start, substeps=16 if plant.liquid else 2)
        return run.outputs, run.ledger, run.end

    many = jax.jit(jax.vmap(ran))(jnp.asarray(commands))
    assert np.ptp(many[0].pressures, axis=0).max() > 1e4  # they differ
    for k in range(RUNS):
        same(jax.tree.map(lambda x, k=k: x[k], many), ran(commands[k]), 1e-10)


@pytest.mark.parametrize("name", slow)
def test_gradients_of_a_batch_equal_those_of_single_runs(name, muscle):
    plant = made(name, muscle)
    start = dynamics.equilibrium_state(plant, 1.5e5)
    rng = np.random.default_rng(8)
    rows = jnp.asarray(rng.uniform(-0.9, 0.9, (RUNS, STEPS, plant.units)))

    def cost(share, rows):
        run = dynamics.simulate(
            plant, share * rows, start=start, substeps=16 if plant.liquid else 2
        )
        drawn = run.ledger[-1, 0] / SUPPLY
        return 1e4 * jnp.mean((run.outputs.position - start.position) ** 2) + drawn

    shares = jnp.linspace(0.6, 1.0, RUNS)
    many = jax.jit(jax.vmap(jax.grad(cost)))(shares, rows)
    alone, forward = jax.jit(jax.grad(cost)), jax.jit(jax.jacfwd(cost))
    each = np.array([alone(shares[k], rows[k]) for k in range(RUNS)])
    size = np.max(np.abs(each))
    assert np.all(np.isfinite(each)) and size > 0
    assert_allclose(many, each, rtol=0, atol=1e-9 * size)
    along = [forward(shares[k], rows[k]) for k in range(RUNS)]
    assert_allclose(along, each, rtol=0, atol=1e-10 * size)

"""Runs of fixed steps: their order, halving, batches, where they end, and what is refused."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle import dynamics, fluid
from fascicle.core.errors import InvalidInputError


BEGIN = 1.5e5  # gauge [Pa], at which the load hangs in the air
SHORT, LONG = 100, 4000  # steps of runs


def up(time):
    """A smooth command of 0.1 to 0.5."""
    return 0.3 + 0.2 * np.sin(20 * np.asarray(time))


def test_the_method_is_of_fourth_order(ideal):
    # off the kinks: ideal muscles pull all the time, flows are subsonic, one command is held
    start = dynamics.equilibrium_state(ideal, [BEGIN, 1.1 * BEGIN], position=0.012)
    command = np.tile([[0.25, 0.2]], (10, 1))

    def ended(substeps):
        run = dynamics.simulate(ideal, command, dt=4e-3, start=start, substeps=substeps)
        ratio = (run.outputs.pressures + 101325) / (413.7e3 + 101325)
        assert np.all((ratio > 0.3) & (ratio < 0.999))
        return run.outputs.position[-1]

    at = np.array([ended(n) for n in (2, 4, 8)])
    steps = np.abs(np.diff(at))
    order = np.log2(steps[:-1] / steps[1:])
    assert_allclose(order, 4, rtol=0, atol=0.2)


def test_a_run_continues_from_the_end_of_another(lift):
    start = dynamics.equilibrium_state(lift, BEGIN)
    rows = np.stack([up(1e-3 * np.arange(SHORT)), np.zeros(SHORT)], axis=1)
    whole = dynamics.simulate(lift, np.concatenate([rows, rows]), start=start, substeps=2)
    first = dynamics.simulate(lift, rows, start=start, substeps=2)
    second = dynamics.simulate(lift, rows, start=first.end, substeps=2)
    assert_array_equal(first.end.position, first.outputs.position[-1])
    # where the second begins its pressures are searched for from the same place
    assert_allclose(second.outputs.position, whole.outputs.position[SHORT:], rtol=1e-12)


def test_a_schedule_equals_its_rows(lift):
    options = {"start": dynamics.equilibrium_state(lift, BEGIN), "substeps": 2}
    whole = dynamics.simulate(lift, np.tile([[0.3, -0.1]], (SHORT, 1)), **options)
    schedule = dynamics.Schedule([0.0], [[0.3, -0.1]])
    again = dynamics.simulate(lift, schedule, duration=1e-3 * SHORT, **options)
    assert_array_equal(whole.outputs.position, again.outputs.position)
    assert_allclose(whole.time, 1e-3 * np.arange(SHORT + 1), rtol=1e-12)
    assert len(whole.commands) == len(whole.ledger) == SHORT + 1


def test_commands_are_held_until_the_next_but_for_rounding():
    schedule = dynamics.Schedule([0, 0.1, 0.3], [[1, 0], [0.5, -1], [0, 0]])
    assert_array_equal(
        schedule.at([0.0, 0.0999, 0.1, 0.2999, 0.3, 9.0]),
        [[1, 0], [1, 0], [0.5, -1], [0.5, -1], [0, 0], [0, 0]],
    )
    schedule = dynamics.Schedule([0, 0.3], [0, 1])
    assert 3 * 0.1 != 0.3
    assert_array_equal(schedule.at(np.arange(5) * 0.1).ravel(), [0, 0, 0, 1, 1])
    assert_array_equal(schedule.at(np.nextafter(0.3, 0)), [1])


def test_a_run_ends_at_the_static_equilibrium(lift, bundle):
    # shut again after 0.1 s, and damped for long: the law at the pressures of then
    start = dynamics.equilibrium_state(lift, BEGIN)
    schedule = dynamics.Schedule([0, 0.1], [[0.5, 0.2], [0, 0]])
    run = dynamics.simulate(lift, schedule, dt=2 / LONG, duration=2.0, start=start, substeps=2)
    seen = run.outputs
    assert abs(seen.velocity[-1]) < 1e-5  # the air still cools
    held = lift.load.mass * lift.load.gravity
    assert_allclose(seen.forces[-1].sum(), held, rtol=1e-4)
    result = bundle.strain_at(held, seen.pressures[-1])
    # a table's largest error of force over the bundle's stiffness is what it may be off
    h = 1e-5
    forces = [bundle.force(seen.pressures[-1], seen.strains[-1, 0] + x) for x in (-h, h)]
    stiff = (forces[0] - forces[1]) / (2 * h)
    off = min(np.sum(lift.counts) * lift.muscles.table.errors[2] / stiff, 5e-4)
    assert_allclose(seen.strains[-1, 0], np.atleast_1d(result.strain)[0], rtol=0, atol=off)


def test_slow_filling_is_quasi_static(lift):
    # the lag behind the static law at the pressures of the moment falls with the time it takes
    start = dynamics.equilibrium_state(lift, BEGIN)

    def lag(duration):
        rows = np.tile([[0.04, 0.16]], (LONG, 1)) / duration
        run = dynamics.simulate(lift, rows, dt=duration / LONG, start=start, substeps=2)
        at = round(0.8 * LONG)
        still = dynamics.equilibrium_state(lift, run.outputs.pressures[at])
        assert run.outputs.position[at] > start.position + 1e-3  # it moves
        return (still.position - run.outputs.position[at]) / 0.127

    fast, slow = lag(1.0), lag(4.0)
    assert 0 < slow < fast < 1e-2
    # 1/T, but for how far the air cools meanwhile
    assert_allclose(fast / slow, 4, rtol=0.2)


class PI(eqx.Module):
    """Proportional and integral, of the load's position."""

    gain: object
    rate: object

    @property
    def memory(self):
        return jnp.zeros(())

    def __call__(self, memory, seen, reference):
        error = reference - seen.position
        memory = memory + 1e-3 * error
        u = jnp.tanh(self.gain * error + self.rate * memory)
        return memory, jnp.stack([u, 0.5 * u])


def test_a_controller_measures_and_acts(lift):
    start = dynamics.equilibrium_state(lift, BEGIN)
    reference = np.full(SHORT, start.position + 0.003)
    run = dynamics.simulate(lift, PI(300.0, 2e3), reference, start=start, substeps=2)
    error = reference[0] - run.outputs.position[:-1]
    u = np.tanh(300.0 * error + 2e3 * np.cumsum(1e-3 * error))
    assert_allclose(run.commands[:-1], np.stack([u, 0.5 * u], axis=1), rtol=1e-12)
    assert run.outputs.position[-1] > start.position + 1e-3


@pytest.fixture(scope="module")
def tracking(lift):
    """A cost of tracking by gains, from a start, with its slopes by the gains."""
    begin = dynamics.equilibrium_state(lift, BEGIN)
    reference = begin.position + 0.004 * np.sin(np.linspace(0, 3, SHORT))

    def cost(gains, start):
        run = dynamics.simulate(lift, PI(*gains), reference, start=start, substeps=2)
        return 1e6 * jnp.mean((run.outputs.position[:-1] - reference) ** 2)

    def twice(gains, start):
        return (result := cost(gains, start)), result

    # forward: `test_batches` compares them with those in reverse, which take longer to compile
    return begin, jax.jit(jax.jacfwd(twice, has_aux=True))


def test_gradients_by_gains_equal_finite_differences(tracking):
    start, slopes_and_cost = tracking
    gains, h = jnp.array([300.0, 2e3]), np.array([3e-2, 2e-1])
    slopes, _ = slopes_and_cost(gains, start)
    ends = [[slopes_and_cost(gains + s * d, start)[1] for s in (-1, 1)] for d in np.diag(h)]
    central = np.diff(ends, axis=1)[:, 0] / (2 * h)
    assert_allclose(slopes, central, rtol=1e-4)


@pytest.mark.parametrize("case", ["shut valves", "no pressure", "supply's pressure"])
def test_gradients_are_finite_without_flow(tracking, lift, case):
    gains = jnp.zeros(2) if case == "shut valves" else jnp.array([300.0, 2e3])
    pressure = {"shut valves": BEGIN, "no pressure": 0.0, "supply's pressure": 413.7e3}[case]
    _, slopes_and_cost = tracking
    start = dynamics.equilibrium_state(lift, pressure, position=0.01)
    slopes, _ = slopes_and_cost(gains, start)
    assert np.all(np.isfinite(slopes)) and np.any(slopes != 0)


def test_plants_of_one_structure_compile_once(lift, muscle, air, caplog):
    """Numbers are arguments of the compiled run, not constants of it."""
    rows = np.stack([up(1e-3 * np.arange(SHORT)), np.zeros(SHORT)], axis=1)

    def ended(plant):
        start = dynamics.equilibrium_state(plant, BEGIN)
        return dynamics.simulate(plant, rows, start=start).outputs.position[-1]

    positions = [ended(lift)]
    with jax.log_compiles(), caplog.at_level("WARNING"):
        for k in (1, 2, 3):
            longer = muscle.replace(length=muscle.length * (1 + 0.05 * k))
            units = [fs.MotorUnit(longer, k), fs.MotorUnit(longer, 4)]
            unit = fs.Bundle(units, scheme="batch" if k == 3 else "orderly")
            load = dynamics.HangingMass(12.0 - k, damping=300.0 + k)
            valve = fluid.SonicValve(2e-9 * k, 0.3)  # the second and third ask for more substeps
            positions.append(ended(dynamics.Plant(unit, load, **{**air, "valve": valve})))
    assert not [record for record in caplog.records if "ompil" in record.getMessage()]
    assert len(set(positions)) == 4


def test_the_last_command_holds_at_the_end_and_substeps_are_reported(lift):
    start = dynamics.equilibrium_state(lift, BEGIN)
    rows = np.stack([up(1e-3 * np.arange(SHORT)), np.zeros(SHORT)], axis=1)
    run = dynamics.simulate(lift, rows, start=start)
    assert len(run.time) == len(run.outputs.position) == len(run.ledger) == SHORT + 1
    assert_array_equal(run.commands, [*rows, rows[-1]])
    assert_array_equal(run.end.position, run.outputs.position[-1])
    looked = dynamics.estimate_substeps(lift, 1e-3)
    assert run.substeps == looked.substeps and run.step_size == looked
    assert 1e-3 / looked.substeps * looked.rate <= 2
    assert dynamics.estimate_substeps(lift, 1e-2).substeps > looked.substeps
    assert dynamics.estimate_substeps(lift, 1.0).stiff


@pytest.mark.parametrize(
    ("arguments", "argument"),
    [
        ({"dt": 0.0}, "dt"),
        ({"substeps": 0}, "substeps"),
        ({"controller": np.zeros((3, 3))}, "commands"),
        ({"controller": np.full((3, 2), 1.5)}, "commands"),
        ({"controller": np.full((3, 2), np.nan)}, "commands"),
        ({"controller": PI(1.0, 1.0)}, "reference"),
        ({"controller": dynamics.Schedule(0.0, [[0.5, 0.5]]), "duration": 0.0}, "duration"),
    ],
)
def test_invalid_input_is_refused(lift, arguments, argument):
    start = dynamics.equilibrium_state(lift, BEGIN)
    arguments = {"controller": np.zeros((3, 2)), "start": start} | arguments
    with pytest.raises(InvalidInputError) as error:
        dynamics.simulate(lift, **arguments)
    assert error.value.argument == argument

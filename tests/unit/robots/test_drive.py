"""A bundle on a tendon keeps energy, and is the same in MJX."""

import warnings
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import fascicle as fs
from fascicle import fluid
from refusing import refuses, warns


mujoco = pytest.importorskip("mujoco", reason="the extra robots isn't here")
from fascicle.robots import (  # noqa: E402 needs what was just looked for
    Drive,
    TableStatus,
    TableWarning,
    attach,
    optional_imports,
    size,
)


SUPPLY = 413.7e3
HELD = np.array([2e5, 1.5e5])
AIR = {
    "supply": fluid.ConstantSupply(SUPPLY), "valve": fluid.SonicValve(1e-9, 0.3),
    "chamber": fluid.Isothermal(dead_volume=2e-6),
}  # fmt: skip


ARM = """<mujoco><worldbody><body><joint name="j" type="hinge"/><geom size="0.02" mass="0.5"/>
</body></worldbody><tendon><fixed name="flexor"><joint joint="j" coef="-0.02"/></fixed></tendon>
</mujoco>"""


def arm_of(target, text=ARM, length=0.0127):
    """Model, data and drive of the arm with a muscle or bundle, and what `attach` returned."""
    spec = mujoco.MjSpec.from_string(text)
    made = attach(spec, "flexor", target, length)
    model = spec.compile()
    return model, mujoco.MjData(model), Drive.of(model, [made]), made


def check_pull(model, data, drive):
    """MuJoCo's force is the bundle's pull at 200 kPa, which is returned [N]."""
    drive.step(model, data, drive.start(model, data), 2e5)
    pull = drive.pull(np.array([2e5]), np.array([0.0]))
    np.testing.assert_allclose(data.actuator_force, -pull)
    return float(pull[0])


def test_runge_kutta_is_refused(elbow):
    """A pull that is constant through its stages creates energy."""
    model, data, drive = elbow()
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    start = drive.start(model, data, HELD)
    for call in (lambda: drive.step(model, data, start, HELD), lambda: elbow(integrator="RK4")):
        with pytest.raises(fs.InvalidInputError) as error:
            call()
        assert error.value.argument == "model.opt.integrator"


def test_a_closed_chamber_conserves_energy(elbow):
    model, data, drive = elbow(**AIR)
    held = drive.start(model, data, HELD)
    mass, angles, act = held.chambers.copy(), [], jax.jit(drive.act)
    for _ in range(2400):
        held = drive.step(model, data, held, np.zeros(2), act)
        angles.append(float(data.qpos[0]))
    np.testing.assert_array_equal(held.chambers, mass)
    assert abs(held.pressures - HELD).max() > 100.0  # they have moved with the arm
    # what pumps energy would swing farther, what takes it less
    first, last = (np.ptp(angles[part]) for part in (slice(0, 1000), slice(-1000, None)))
    np.testing.assert_allclose(last, first, rtol=0.02)


def test_an_open_valve_fills_to_the_supply_and_lifts(elbow):
    model, data, drive = elbow(angle=0.0, spool=fluid.Servovalve(5e-3), **AIR)
    model.dof_damping[:] = 0.05
    held, act = drive.start(model, data, 0.0), jax.jit(drive.act)
    for _ in range(1000):
        held = drive.step(model, data, held, [1.0, -1.0], act)
    np.testing.assert_allclose(held.pressures, [SUPPLY, 0.0], atol=0.01 * SUPPLY)
    assert data.qpos[0] > 0.5  # the flexor is the shorter one


SLACK = {"cord": {"stiffness": ["40 N/mm", 4e4], "slack": True}, "contraction": 0.25}


# rounding of so many steps, and of each root of a cord, which velocities enlarge
@pytest.mark.parametrize(
    ("options", "steps", "size", "columns", "within"),
    [
        ({}, 400, 0.4, 4, {"rtol": 0, "atol": 1e-12}),
        pytest.param(
            {"spatial": True}, 400, 0.4, 4, {"rtol": 0, "atol": 1e-12}, marks=pytest.mark.slow
        ),
        (SLACK, 200, 0.0, 1, {"atol": 1e-9}),
    ],
    ids=["fixed", "spatial", "slack"],
)
def test_mjx_equals_mujoco(elbow, options, steps, size, columns, within):
    model, data, drive = elbow(**options, **AIR)
    mjx = optional_imports.mjx()
    time = 1e-3 * np.arange(steps)
    commands = size * np.stack([np.sin(6 * time), np.cos(5 * time)], axis=1)
    held = drive.start(model, data, HELD)
    there = mjx.put_model(model)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of MJX's own
        begin = mjx.put_data(model, data)

    def step(carry, command):
        now, holding = drive.step_mjx(there, *carry, command)
        return (now, holding), jnp.concatenate([now.qpos, now.qvel, holding.pressures / SUPPLY])

    (_, ended), rows = jax.jit(lambda c: jax.lax.scan(step, c, jnp.asarray(commands)))(
        (begin, jax.tree.map(jnp.asarray, held))
    )
    expected, act = [], jax.jit(drive.act)
    for command in commands:
        held = drive.step(model, data, held, command, act)
        expected.append([*data.qpos, *data.qvel, *(held.pressures / SUPPLY)])
    expected = np.array(expected)
    np.testing.assert_allclose(rows[:, :columns], expected[:, :columns], **within)
    assert bool(ended.inside)
    assert np.ptp(expected[:, 0]) > 0.1  # it has moved


@pytest.mark.parametrize("valved", [False, True])
def test_a_step_keeps_the_types_of_its_input(valved, elbow):
    """Else each compiled loop is compiled twice, for what the first step returns, too."""
    parts = AIR if valved else {}
    model, data, drive = elbow(cord={"stiffness": 4e4, "slack": True}, **parts)
    mjx = optional_imports.mjx()
    begin = mjx.put_model(model), mjx.put_data(model, data), drive.start(model, data, HELD)
    command = np.array([0.5, -0.5]) if valved else HELD

    def types(tree):
        leaves = jax.tree.leaves(jax.eval_shape(lambda: jax.tree.map(jnp.asarray, tree)))
        return [(x.shape, x.dtype, x.weak_type) for x in leaves]

    after, _ = jax.eval_shape(drive.act, begin[2], np.zeros(2), command, 1e-3)
    assert [(x.shape, x.dtype, x.weak_type) for x in after] == types(begin[2])
    after = jax.eval_shape(drive.step_mjx, *begin, command)
    assert [(x.shape, x.dtype, x.weak_type) for x in jax.tree.leaves(after)] == types(begin[1:])


def test_mjx_reports_states_outside_of_the_tables(elbow):
    model, data, drive = elbow()
    mjx = optional_imports.mjx()
    held = drive.start(model, data, HELD)
    data.qpos[0] = 4.0
    _, after = jax.jit(lambda d, h: drive.step_mjx(mjx.put_model(model), d, h, jnp.asarray(HELD)))(
        mjx.put_data(model, data), jax.tree.map(jnp.asarray, held)
    )
    assert not bool(after.inside)


def test_invalid_input_is_refused_in_one_line(elbow, bundle):
    model, data, drive = elbow()
    held = drive.start(model, data, HELD)
    parts = {"supply": fluid.ConstantSupply(SUPPLY), "valve": fluid.SonicValve(1e-9, 0.3)}
    arm, _, _, made = arm_of(bundle)
    spec = mujoco.MjSpec.from_string(ARM)
    attach(spec, "flexor", bundle, 0.01)
    for argument, call in (
        ("tendon", lambda: attach(spec, "extensor", bundle, 0.1)),
        ("spec", lambda: attach(Path("arm.xml"), "flexor", bundle, 0.01)),
        ("name", lambda: attach(spec, "flexor", bundle, 0.01)),
        ("model", lambda: Drive.of("arm.xml", [made])),
        ("model", lambda: size("arm.xml", "flexor", bundle.motor_units[0].muscle, 1.0, 2e5)),
        ("command", lambda: drive.step(model, data, held, [1e5] * 3)),
        ("command", lambda: drive.step(model, data, held, 2e6)),
        ("chamber", lambda: elbow(**parts, chamber=fluid.AdiabaticWall(0.5))),
        ("chamber", lambda: elbow(**parts)),
        ("command", lambda: drive.step(model, data, held, [np.nan, 0.0])),
        ("model", lambda: drive.start(data, model)),
        ("pressures", lambda: drive.start(model, data, [1e5] * 3)),
        ("pressures", lambda: drive.pull([1e5] * 3, drive.rest_lengths)),
        ("lengths", lambda: drive.pull([1e5] * 2, [0.1] * 3)),
        ("attached", lambda: Drive.of(model, [])),
        ("attached", lambda: Drive.of(model, bundle)),
        ("attached", lambda: Drive.of(model, [bundle])),
        ("attached", lambda: Drive.of(arm, [made, made])),
        ("attached", lambda: arm_of(bundle, length=413.8)),
    ):
        with pytest.raises(fs.InvalidInputError) as error:
            call()
        assert error.value.argument == argument and "\n" not in str(error.value)


def test_a_single_muscle_becomes_a_bundle():
    muscle = fs.example("kim2021_figure_6")
    # the law's pull at this strain, to the table's error
    pull = check_pull(*arm_of(muscle, length=0.01)[:3])
    np.testing.assert_allclose(pull, muscle.force(2e5, 0.01 / 0.127), rtol=1e-4)


@pytest.mark.parametrize("stretch", [-0.5, 0.2])
@pytest.mark.parametrize("name", ["pull", "energy"])
def test_pull_outside_of_the_table_warns(elbow, bundle, name, stretch):
    """It held the table's edge there, in silence."""
    drive = elbow()[2]
    lengths = drive.rest_lengths + np.array([0.0, stretch * float(bundle.length)])
    with warns("extensor"):
        assert np.isfinite(getattr(drive, name)(HELD, lengths)).all()
    with warns("extensor"):
        getattr(drive, name)(np.tile(HELD, (2, 1)), np.stack([drive.rest_lengths, lengths]))
    with refuses("pressures"):
        getattr(drive, name)(np.array([9e5, 0.0]), drive.rest_lengths)
    with refuses("lengths"):
        getattr(drive, name)(HELD, lengths * np.nan)
    assert np.isfinite(getattr(drive, name)(HELD, drive.rest_lengths)).all()


def test_a_step_outside_of_the_table_has_a_status_and_goes_on(elbow):
    model, data, drive = elbow()
    held = drive.start(model, data, HELD)
    data.qpos[0] = 4.0
    with pytest.warns(TableWarning, match="(flexor|extensor)"):
        held = drive.step(model, data, held, HELD)
    assert sorted(held.status) == [TableStatus.STRETCHED, TableStatus.SHORTENED]
    assert not held.inside
    data.qpos[:], data.qvel[:] = 0.3, 0.0
    held = drive.step(model, data, held, HELD)
    assert not held.status.any() and not held.inside  # which remembers
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # which starts anew instead
    data.qpos[:] = np.nan
    with pytest.raises(fs.InvalidInputError) as error:
        drive.step(model, data, held, HELD)
    assert error.value.argument == "data"


def sub_model(bundle, *prefixes):
    """A world with copies of the arm under `prefixes`, and what `attach` returned for the arm."""
    arm = mujoco.MjSpec.from_string(ARM)
    made = attach(arm, "flexor", bundle, 0.0127)
    world = mujoco.MjSpec.from_string("<mujoco><worldbody/></mujoco>")
    world.copy_during_attach = True
    for prefix in prefixes:
        world.worldbody.add_frame().attach_body(arm.worldbody.first_body(), prefix, "_s")
    return world.compile(), made


def test_a_sub_model_under_a_prefix_is_found(bundle):
    model, made = sub_model(bundle, "left_")
    drive = Drive.of(model, [made])
    assert drive.actuators == (0,) and drive.tendons == ("left_flexor_s",)
    with pytest.raises(fs.InvalidInputError) as error:
        Drive.of(model, [made._replace(actuator="zzz")])
    assert "left_flexor_bundle" in error.value.remedy


def test_two_sub_models_are_told_apart_by_their_prefix(bundle):
    model, made = sub_model(bundle, "left_", "right_")
    with pytest.raises(fs.InvalidInputError) as error:
        Drive.of(model, [made])
    assert "with_prefix('left_')" in error.value.remedy
    drive = Drive.of(model, [made.with_prefix(side, "_s") for side in ("right_", "left_")])
    assert drive.actuators == (1, 0) and drive.tendons == ("right_flexor_s", "left_flexor_s")


MOTOR = '<actuator><motor name="m" tendon="flexor" gear="7" ctrlrange="0 1"/></actuator></mujoco>'


def test_a_compiled_model_gives_its_motor(bundle):
    model = mujoco.MjModel.from_xml_string(ARM.replace("</mujoco>", MOTOR))
    drive = Drive.of(model, [attach(model, "flexor", bundle, 0.0127)])
    check_pull(model, mujoco.MjData(model), drive)
    bare = mujoco.MjModel.from_xml_string(ARM)
    with pytest.raises(fs.InvalidInputError) as error:
        attach(bare, "flexor", bundle, 0.0127)
    assert "<motor" in error.value.remedy


def test_defaults_of_the_model_do_not_change_the_force(bundle):
    general = '<general gear="3" ctrlrange="0 1" forcerange="-1 1" dyntype="filter" dynprm="0.1"/>'
    text = ARM.replace("<worldbody>", f"<default>{general}</default><worldbody>")
    check_pull(*arm_of(bundle, text)[:3])

"""Muscles of the docs in Newton: their force is the table's, and a forearm moves as in MuJoCo."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.robots import Drive, attach


SCRIPT = Path(__file__).resolve().parents[3] / "docs" / "newton_muscle.py"
MUSCLE = fs.example("kim2021_figure_6")
TABLE = MUSCLE.table("413.7 kPa")
ELBOW = """<mujoco><option timestep="0.001"/><worldbody><body>
<joint name="elbow" type="hinge" axis="0 -1 0"/>
<inertial pos="0 0 -0.15" mass="0.5" diaginertia="3.8e-3 3.8e-3 1e-4"/></body></worldbody><tendon>
<fixed name="flexor"><joint joint="elbow" coef="-0.02"/></fixed>
<fixed name="extensor"><joint joint="elbow" coef="0.02"/></fixed></tendon></mujoco>"""


def test_the_tables_cells_are_read_as_the_kernel_reads_them():
    # what a simulator of its own needs, in plain numbers: lines even in √P, and powers of both
    rng = np.random.default_rng(0)
    (low, high), (lines, columns) = TABLE.strains, TABLE.coefficients.shape[:2]
    step = (high - low) / columns
    for P, strain in zip(rng.uniform(0, 413e3, 200), rng.uniform(low, high, 200), strict=True):
        p = P / TABLE.root_step**2
        i, j = min(int(np.sqrt(p)), lines - 1), min(int((strain - low) / step), columns - 1)
        u, w = np.sqrt(p) - i if i else p, (strain - low) / step - j
        of_w = np.array([0, 1, 2 * w, 3 * w**2])
        force = np.array([1, u, u**2, u**3]) @ TABLE.coefficients[i, j] @ of_w
        force /= step * TABLE.rest_length
        # a sum of sixteen products of some 1e3 N
        assert_allclose(force, TABLE.force(P, strain), rtol=0, atol=1e-9)


@pytest.fixture
def script():
    pytest.importorskip("newton", reason="Newton is no dependency of fascicle")
    spec = importlib.util.spec_from_file_location("newton_muscle", SCRIPT)
    assert spec is not None and spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


def test_torques_in_newton_are_the_tables(script):
    from newton.actuators import Actuator

    wp, rng, n = script.wp, np.random.default_rng(0), 200
    q, P, zero = rng.uniform(-0.6, 0.6, n), rng.uniform(0, 413e3, n), wp.zeros(n, dtype=float)
    arms, torque = rng.choice([-0.02, 0.02], n), wp.zeros(n, dtype=float)
    drive = script.MuscleDrive(TABLE, arms, np.full(n, 0.1))
    state = SimpleNamespace(joint_q=wp.array(q, dtype=float), joint_qd=zero)
    pressures = wp.array(P, dtype=float)
    control = SimpleNamespace(joint_target_q=zero, joint_target_qd=zero, joint_f=torque)
    control.pressures, control.joint_act = pressures, None
    Actuator(wp.array(np.arange(n), dtype=wp.uint32), drive=drive).step(state, control)
    true = arms * TABLE.lookup_at(P, 0.1 + arms * q / TABLE.rest_length).force
    # single precision: 6e-8 of some ten times the largest torque
    assert_allclose(torque.numpy(), true, rtol=0, atol=1e-6 * np.abs(true).max())


@pytest.mark.slow
def test_a_forearm_moves_in_newton_as_in_mujoco(script):
    import mujoco
    import newton

    wp, arms = script.wp, np.array([0.02, -0.02])
    builder = newton.ModelBuilder()
    inertia, center = wp.mat33(np.diag([3.8e-3, 3.8e-3, 1e-4])), wp.vec3(0.0, 0.0, -0.15)
    arm = builder.add_link(mass=0.5, inertia=inertia, com=center)
    joint = builder.add_joint_revolute(-1, arm, axis=wp.vec3(0.0, -1.0, 0.0), armature=0.0)
    builder.add_articulation([joint])
    newton_model = builder.finalize()
    solver = newton.solvers.SolverFeatherstone(newton_model, angular_damping=0.0)
    state, after, control = newton_model.state(), newton_model.state(), newton_model.control()
    drive = script.MuscleDrive(TABLE, arms, np.array([0.1, 0.1]))
    actuator = newton.actuators.Actuator(wp.zeros(2, dtype=wp.uint32), drive=drive)
    control.pressures = wp.array([200e3, 100e3], dtype=float)

    spec = mujoco.MjSpec.from_string(ELBOW)
    x = 0.1 * float(MUSCLE.length)
    attached = [attach(spec, tendon.name, MUSCLE, rest_length=x) for tendon in spec.tendons]
    model = spec.compile()
    data, drive = mujoco.MjData(model), Drive.of(model, attached, highest_pressure="413.7 kPa")
    fluid, angles = drive.start(model, data), []
    for _ in range(1000):
        fluid = drive.step(model, data, fluid, [200e3, 100e3])
        state.clear_forces()
        control.joint_f.zero_()
        actuator.step(state, control)
        solver.step(state, after, control, None, 1e-3)
        state, after = after, state
        angles.append([state.joint_q.numpy()[0], data.qpos[0]])
    one, other = np.array(angles).T
    # both are of first order in a step of a thousandth second, some hundredth of an oscillation
    assert_allclose(one, other, rtol=0, atol=0.01 * np.ptp(other))

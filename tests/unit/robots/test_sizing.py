"""Muscles that are sized to tendons: moment arms in closed form, and margins computed anew."""

import warnings

import numpy as np
import pytest

import fascicle as fs


mujoco = pytest.importorskip("mujoco", reason="the extra robots isn't here")
from fascicle.robots import Drive, attach, size  # noqa: E402 needs what was just looked for
from fascicle.robots.sizing import trace_route  # noqa: E402 as above
from fascicle.robots.sizing_plot import plot_sizing  # noqa: E402 as above


KNEE = """<mujoco><compiler angle="radian"/><worldbody><site name="hip" pos="-0.05 0 0.3"/>
<body name="shank"><joint name="knee" type="hinge" axis="0 -1 0" range="-0.4 1.2" limited="true"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03" mass="3"/>
<site name="calf" pos="-0.04 0 -0.05"/>
<body pos="0 0 -0.4">
<joint name="ankle" type="hinge" axis="0 -1 0" range="-0.3 0.3" limited="true"/>
<geom size="0.03"/></body></body></worldbody>
<tendon><fixed name="flexor"><joint joint="knee" coef="-0.04"/></fixed>
<fixed name="extensor"><joint joint="knee" coef="0.04"/></fixed>
<fixed name="both"><joint joint="knee" coef="-0.04"/><joint joint="ankle" coef="0.02"/></fixed>
<spatial name="straight"><site site="hip"/><site site="calf"/></spatial></tendon></mujoco>"""


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(KNEE)


@pytest.fixture(scope="module")
def muscle():
    return fs.Muscle("220 mm", "10 mm", "2 mm", "25 deg")


def weight(poses):
    """Torque that lifts the shank [N·m]."""
    return 3 * 9.81 * 0.2 * np.sin(np.maximum(poses[:, 0], 0.0))


def test_lengths_and_moment_arms_of_a_straight_tendon(model):
    route = trace_route(model, "straight", None, None, 9)
    # the knee turns about -y: the calf goes from (-0.04, -0.05) by a turn of q towards +x
    q, hip = route.coordinate, np.array([-0.05, 0.3])
    x = -0.04 * np.cos(q) + 0.05 * np.sin(q)
    z = -0.04 * np.sin(q) - 0.05 * np.cos(q)
    length = np.hypot(x - hip[0], z - hip[1])
    np.testing.assert_allclose(route.lengths, length, rtol=1e-12)
    x_q = 0.04 * np.sin(q) + 0.05 * np.cos(q)
    z_q = -0.04 * np.cos(q) + 0.05 * np.sin(q)
    arm = -((x - hip[0]) * x_q + (z - hip[1]) * z_q) / length
    np.testing.assert_allclose(route.moment_arms, arm, atol=1e-9)
    assert route.spatial and route.joints == ("knee",)


def test_a_moment_arm_is_positive_where_a_pull_raises_the_coordinate(model, muscle):
    assert (trace_route(model, "flexor", None, None, 3).moment_arms > 0.039).all()
    spec = mujoco.MjSpec.from_string(KNEE)
    made = attach(spec, "flexor", muscle, 0.0)
    live = spec.compile()
    live.opt.gravity[:] = 0
    data, drive = mujoco.MjData(live), Drive.of(live, [made])
    drive.step(live, data, drive.start(live, data), 3e5)
    assert data.qvel[0] > 0


def test_the_shortest_muscle_with_the_margin_is_chosen(model, muscle):
    sizing = size(model, "flexor", muscle, weight, "620 kPa", counts=(1,))
    poses = np.linspace(-0.4, 1.2, 21)
    contraction = 0.04 * (poses + 0.4)

    def margin(length):
        force = np.array([float(muscle.replace(length=length).force(620e3, c / length))
                          for c in contraction])  # fmt: skip
        torque = weight(poses[:, None])
        return np.min(0.04 * force[torque > 0] / torque[torque > 0]) - 1

    chosen = sizing.chosen
    np.testing.assert_allclose(chosen.margin, margin(chosen.length), rtol=1e-9)
    assert 0.2 <= chosen.margin < 0.2 + 1e-5
    assert margin(0.999 * chosen.length) < 0.2
    np.testing.assert_allclose(sizing.rest_length, 0.4 * 0.04)
    np.testing.assert_allclose(sizing.strains, [0.0, 0.064 / chosen.length], atol=1e-12)


def test_what_is_sized_attaches_and_lifts(model, muscle):
    sizing = size(model, "flexor", [("mine", muscle)], weight, 620e3)
    spec = mujoco.MjSpec.from_string(KNEE)
    made = attach(spec, "flexor", sizing.bundle, sizing.rest_length)
    live = spec.compile()
    drive = Drive.of(live, [made])
    lengths = sizing.route.lengths[:, None]
    pressures = np.full((len(lengths), 1), 620e3)
    pull = drive.pull(pressures, lengths)[:, 0]
    # the table's error, in N, times the moment arm
    np.testing.assert_allclose(0.04 * pull, sizing.available_torque, atol=0.01)
    assert (sizing.available_torque >= 1.2 * sizing.torque - 1e-9).all()


def test_stretch_is_used_up_at_the_longest_pose(model, muscle):
    sizing = size(model, "flexor", muscle, weight, 620e3, stretch=0.02, counts=(1,))
    np.testing.assert_allclose(sizing.strains[0], -0.02)
    assert sizing.chosen.length < size(model, "flexor", muscle, weight, 620e3).chosen.length


def test_measured_muscles_by_name_and_the_catalog(model):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of laws that were fitted at another length
        one = size(model, "flexor", "festo-dmsp-20-300", weight, "500 kPa")
        several = size(model, "flexor", fs.catalog, weight, "500 kPa")
    assert one.chosen.name == "festo-dmsp-20-300"
    assert len(several.candidates) > 3
    fluids = [candidate.fluid for candidate in several.candidates]
    assert fluids == sorted(fluids)
    assert all(candidate.margin >= 0.2 for candidate in several.candidates)
    assert "festo-dmsp-20-300" in str(several)


@pytest.mark.parametrize(
    ("tendon", "changes", "argument", "helps"),
    [
        ("flexor", {"torque": -3.0}, "torque", "other side"),
        ("flexer", {}, "tendon", "'flexor'"),
        ("flexor", {"torque": 300.0}, "muscles", "`counts`"),
        ("flexor", {"torque": 3.0, "longest": "0.12 m"}, "muscles", "`longest`"),
        ("flexor", {"torque": [1.0, 2.0]}, "torque", ""),
    ],
)
def test_refusals_say_what_would_help(model, muscle, tendon, changes, argument, helps):
    arguments = {"muscles": [("mine", muscle)], "torque": 3.0, "pressure": 620e3} | changes
    with pytest.raises(fs.InvalidInputError) as error:
        size(model, tendon, **arguments)
    assert error.value.argument == argument and helps in error.value.remedy


def test_an_unlimited_joint_needs_a_range(muscle):
    free = mujoco.MjModel.from_xml_string(KNEE.replace('range="-0.4 1.2" limited="true"', ""))
    with pytest.raises(fs.InvalidInputError) as error:
        size(free, "flexor", muscle, 3.0, 620e3)
    assert error.value.argument == "ranges"
    ranges = {"knee": ("-20 deg", "60 deg")}
    sizing = size(free, "flexor", muscle, 3.0, 620e3, ranges=ranges)
    np.testing.assert_allclose(sizing.route.coordinate[[0, -1]], np.deg2rad([-20, 60]))


def test_two_joints_make_a_grid(model, muscle):
    sizing = size(model, "both", muscle, 3.0, 620e3, joint="knee", points=5)
    assert sizing.route.poses.shape == (25, 2)
    np.testing.assert_allclose(np.ptp(sizing.route.lengths), 0.04 * 1.6 + 0.02 * 0.6)
    assert plot_sizing(sizing).axes

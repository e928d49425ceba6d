"""A pendulum of half a kilogram, moved by two muscles on tendons, fixed or spatial."""

import numpy as np
import pytest

import fascicle as fs


mujoco = pytest.importorskip("mujoco", reason="the extra robots isn't here")
from fascicle.robots import Drive, attach  # noqa: E402 needs what was just looked for


SUPPLY = 413.7e3
FIXED = """<fixed name="flexor"><joint joint="elbow" coef="-0.02"/></fixed>
<fixed name="extensor"><joint joint="elbow" coef="0.02"/></fixed>"""
SPATIAL = """<spatial name="flexor">
<site site="a"/><geom geom="pulley" sidesite="s"/><site site="b"/></spatial>
<spatial name="extensor">
<site site="c"/><geom geom="pulley" sidesite="t"/><site site="d"/></spatial>"""
MODEL = """<mujoco>
<option timestep="{dt}" integrator="{integrator}"><flag contact="disable"/></option>
<worldbody>
<geom name="pulley" type="cylinder" size="0.02 0.02" euler="90 0 0"/>
<site name="a" pos="0.03 0 0.2"/><site name="c" pos="-0.03 0 0.2"/>
<site name="s" pos="0.04 0 0"/><site name="t" pos="-0.04 0 0"/>
<body><joint name="elbow" type="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.01" mass="0.5"/>
<site name="b" pos="0.02 0 -0.1"/><site name="d" pos="-0.02 0 -0.1"/></body></worldbody>
<tendon>{tendons}</tendon></mujoco>"""


@pytest.fixture(scope="session")
def bundle():
    return fs.Bundle([fs.MotorUnit(fs.example("kim2021_figure_6"))], SUPPLY)


@pytest.fixture
def elbow(bundle):
    """Model, data and drive, with chambers and valves where they are given."""

    def made(
        spatial=False, integrator="Euler", dt=1e-3, angle=0.6, cord=None, contraction=0.1, **parts
    ):
        text = MODEL.format(
            dt=dt, integrator=integrator, tendons=SPATIAL if spatial else FIXED
        )  # fmt: skip
        spec = mujoco.MjSpec.from_string(text)
        bare = spec.compile()
        data = mujoco.MjData(bare)
        mujoco.mj_forward(bare, data)
        # contracted where the pendulum hangs, by a tenth
        rest = data.ten_length + contraction * float(bundle.length)
        attached = [
            attach(spec, name, bundle, length, **(cord or {}))
            for name, length in zip(("flexor", "extensor"), rest, strict=True)
        ]
        model = spec.compile()
        data = mujoco.MjData(model)
        data.qpos[0] = angle
        return model, data, Drive.of(model, attached, **parts)

    return made


def stored(model, data, drive, pressures):
    """Energy of pendulum and muscles [J], looked at in a copy."""
    other = mujoco.MjData(model)
    other.qpos[:], other.qvel[:] = data.qpos, data.qvel
    mujoco.mj_forward(model, other)
    mujoco.mj_energyPos(model, other)
    mujoco.mj_energyVel(model, other)
    lengths = other.actuator_length[list(drive.actuators)]
    return float(np.sum(other.energy)) + float(drive.energy(pressures, lengths))


@pytest.fixture
def energy():
    return stored

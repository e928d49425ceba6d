"""A walker's leg that hangs on a stand and walks in the air, on six muscles: sized, driven, drawn.

Routes, masses and gait are made up, in the manner of human ones: hip and knee flex to the positive
side, the ankle lifts the foot. Each muscle is sized to the torque that the gait takes at its joint,
hangs on a cord, and fills through a valve. A PI controller with damping sets pressures, a joint at
a time.

python docs/walker_leg.py docs/_static/walker_leg.gif
"""

import argparse
import io
import sys
from typing import Any, NamedTuple

import jax
import mujoco
import numpy as np
from matplotlib import colormaps
from PIL import Image

import fascicle as fs
from fascicle import fluid
from fascicle.plot.theme import BLACK, BLUE, GRAY, GREEN, VERMILION, new_figure, styled, to_bytes
from fascicle.robots import Drive, Sizing, attach, size


SUPPLY, REST = 600e3, 150e3  # Pa: of the supply, and of all muscles where nothing is asked
PERIOD = 2.0  # s, of a step
JOINTS = ("hip", "knee", "ankle")
MIDDLE = np.deg2rad([8.0, 32.0, 0.0])
SWING, PHASE = np.deg2rad([20.0, 24.0, 10.0]), np.array([0.0, -1.2, 1.6])
# joints that a muscle turns: +1 to the positive side
MUSCLES = {
    "psoas": {"hip": 1}, "gluteus": {"hip": -1}, "hamstrings": {"knee": 1, "hip": -1},
    "vastus": {"knee": -1}, "tibialis": {"ankle": 1}, "soleus": {"ankle": -1},
}  # fmt: skip
GAINS = np.array([[1000e3, 3000e3, 60e3], [1000e3, 3000e3, 60e3], [900e3, 4000e3, 15e3]])
MODEL = """<mujoco><compiler angle="radian"/>
<option timestep="0.001" integrator="implicitfast"><flag contact="disable"/></option>
<default><geom type="capsule" size="0.02"/><joint type="hinge" limited="true" damping="0.4"/>
<site size="0.005"/></default>
<worldbody>
<site name="p1" pos="0.07 0 0.32"/><site name="g1" pos="-0.07 0 0.32"/>
<site name="h1" pos="-0.06 0 0.02"/><site name="back" pos="-0.09 0 0"/>
<geom name="socket" type="cylinder" size="0.05 0.02" euler="1.5708 0 0"/>
<body name="thigh"><joint name="hip" axis="0 -1 0" range="-0.5 0.8"/>
<geom fromto="0 0 0 0 0 -0.42" mass="2.5"/>
<site name="p2" pos="0.05 0 -0.14"/><site name="g2" pos="-0.05 0 -0.14"/>
<site name="v1" pos="0.05 0 -0.02"/>
<body name="shank" pos="0 0 -0.42"><joint name="knee" axis="0 1 0" range="0 1.3"/>
<geom fromto="0 0 0 0 0 -0.4" mass="1.5"/>
<geom name="patella" type="cylinder" size="0.035 0.02" euler="1.5708 0 0" mass="0.1"/>
<site name="front" pos="0.06 0 0"/><site name="v2" pos="0.03 0 -0.08"/>
<site name="h2" pos="-0.045 0 -0.04"/>
<site name="t1" pos="0.045 0 -0.04"/><site name="s1" pos="-0.045 0 -0.06"/>
<body name="foot" pos="0 0 -0.4"><joint name="ankle" axis="0 -1 0" range="-0.6 0.5"/>
<geom fromto="-0.05 0 -0.04 0.14 0 -0.04" mass="0.5"/>
<site name="t2" pos="0.05 0 -0.02"/><site name="s2" pos="-0.05 0 -0.02"/></body></body></body>
</worldbody><tendon>
<spatial name="psoas"><site site="p1"/><site site="p2"/></spatial>
<spatial name="gluteus"><site site="g1"/><geom geom="socket" sidesite="back"/><site site="g2"/>
</spatial>
<spatial name="hamstrings"><site site="h1"/><site site="h2"/></spatial>
<spatial name="vastus"><site site="v1"/><geom geom="patella" sidesite="front"/><site site="v2"/>
</spatial>
<spatial name="tibialis"><site site="t1"/><site site="t2"/></spatial>
<spatial name="soleus"><site site="s1"/><site site="s2"/></spatial>
</tendon></mujoco>"""


class Leg(NamedTuple):
    """Compiled `model`, its `drive`, and the `sizings` of its muscles."""

    model: Any
    drive: Drive
    sizings: list[Sizing]


def gait(time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles [rad], rates [rad/s] and accelerations [rad/s²] of the joints at a `time` [s]."""
    rate = 2 * np.pi / PERIOD
    turn = rate * time + PHASE
    return (
        MIDDLE + SWING * np.sin(turn),
        rate * SWING * np.cos(turn),
        -(rate**2) * SWING * np.sin(turn),
    )


def gait_torques(model: Any) -> np.ndarray:
    """Least and largest torque of each joint in a step [N·m], by inverse dynamics."""
    data, rows = mujoco.MjData(model), []
    for time in np.linspace(0.0, PERIOD, 100):
        data.qpos[:], data.qvel[:], data.qacc[:] = gait(time)
        mujoco.mj_inverse(model, data)
        rows.append(data.qfrc_inverse.copy())
    return np.stack([np.min(rows, axis=0), np.max(rows, axis=0)])


def build() -> Leg:
    """Size the muscles, attach them with cords, and fill their chambers through valves."""
    spec = mujoco.MjSpec.from_string(MODEL)
    bare = spec.compile()
    torques = gait_torques(bare)
    reach = {name: (MIDDLE[i] - 1.4 * SWING[i], MIDDLE[i] + 1.4 * SWING[i])
             for i, name in enumerate(JOINTS)}  # fmt: skip
    choices = [
        (
            f"{2 * radius} mm",
            fs.Muscle("200 mm", f"{radius} mm", f"{wall} mm", "25 deg"),
        )
        for radius, wall in ((5, 1), (7.5, 1.5), (10, 2))
    ]
    sizings, attached = [], []
    for name, turns in MUSCLES.items():
        joint, sign = next(iter(turns.items()))
        low, high = torques[:, JOINTS.index(joint)]
        torque = max(high, 0.5) if sign > 0 else min(low, -0.5)
        ranges = {joint: reach[joint] for joint in turns}
        sizing = size(bare, name, choices, torque, SUPPLY, joint, ranges, points=9, margin=0.5)
        sizings.append(sizing)
        attached.append(
            attach(spec, name, sizing.bundle, sizing.rest_length, stiffness="100 N/mm", slack=True)
        )
    model = spec.compile()
    model.qpos0[:] = gait(0.0)[0]  # where the muscles are in their tables
    drive = Drive.of(
        model, attached, fluid.ConstantSupply(SUPPLY), fluid.Isothermal(dead_volume="5 mL"),
        fluid.SonicValve(C=2e-9, b=0.3),
    )  # fmt: skip
    return Leg(model, drive, sizings)


def walk(leg: Leg, seconds: float, each: int = 25) -> list[dict[str, Any]]:
    """Walk for some `seconds`; returns what was seen at `each` so many steps of 1 ms."""
    model, drive, _ = leg
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], _ = gait(0.0)
    signs = np.array([[turns.get(joint, 0) for joint in JOINTS] for turns in MUSCLES.values()])
    state, act, total = drive.start(model, data, REST), jax.jit(drive.act), np.zeros(3)
    seen = []
    for k in range(round(seconds / model.opt.timestep)):
        angle, rate, _ = gait(data.time)
        error = angle - data.qpos
        total += model.opt.timestep * error
        ask = GAINS[:, 0] * error + GAINS[:, 1] * total + GAINS[:, 2] * (rate - data.qvel)
        target = np.clip(REST + signs @ ask, 0.0, 0.95 * SUPPLY)
        valves = np.clip(8 * (target - np.asarray(state.pressures)) / SUPPLY, -1.0, 1.0)
        state = drive.step(model, data, state, valves, act)
        if k % each == 0:
            seen.append({
                "time": data.time, "angles": data.qpos.copy(), "targets": angle,
                "pressures": np.asarray(state.pressures), "status": np.asarray(state.status),
                "lines": _lines(model, data), "air": float(state.consumption),
            })  # fmt: skip
    return seen


def _lines(model: Any, data: Any) -> dict[str, Any]:
    """Bones and tendons as points in the plane [m]."""
    mujoco.mj_fwdPosition(model, data)
    foot = data.body("foot")
    toes = [foot.xpos + foot.xmat.reshape(3, 3) @ x for x in ([-0.05, 0, -0.04], [0.14, 0, -0.04])]
    bones = [[0.0, 0.0, 0.34], *(data.body(x).xpos for x in ("thigh", "shank", "foot"))]
    tendons = []
    for i in range(model.ntendon):
        first, count = data.ten_wrapadr[i], data.ten_wrapnum[i]
        tendons.append(data.wrap_xpos.reshape(-1, 3)[first : first + count, ::2].copy())
    return {"bones": np.array(bones)[:, ::2], "foot": np.array(toes)[:, ::2], "tendons": tendons}


@styled
def draw(leg: Leg, seen: list[dict[str, Any]], frame: int) -> Image.Image:
    """Picture of a `frame` of what was `seen`."""
    now = seen[frame]
    figure, axes = new_figure(1, 2, width=5.6, height=3.4, width_ratios=[1, 1.25])
    left, right = axes[0]
    left.axis("off")
    left.set(aspect="equal", xlim=(-0.5, 0.42), ylim=(-0.98, 0.36))
    lines = now["lines"]
    left.plot([-0.1, 0.1], [0.34, 0.34], color=GRAY, linewidth=5)
    left.plot(*lines["bones"].T, color=GRAY, linewidth=7, alpha=0.45)
    left.plot(*lines["foot"].T, color=GRAY, linewidth=7, alpha=0.45)
    for i, points in enumerate(lines["tendons"]):
        pressure = now["pressures"][i] / SUPPLY
        left.plot(*points.T, color=BLACK, linewidth=0.8)
        # the muscle at the upper end of its cord, as long as its contraction leaves it
        length = leg.sizings[i].chosen.length
        along = points[1] - points[0]
        end = points[0] + along * min(1.0, length / np.linalg.norm(along))
        left.plot(*np.array([points[0], end]).T, linewidth=3 + 3 * pressure,
                  color=colormaps["plasma"](0.85 * pressure))  # fmt: skip
    time = np.array([x["time"] for x in seen])
    for i, color in enumerate((BLUE, VERMILION, GREEN)):
        right.plot(time, np.rad2deg([x["targets"][i] for x in seen]), color=color, linewidth=0.8,
                   linestyle=":")  # fmt: skip
        right.plot(time[: frame + 1], np.rad2deg([x["angles"][i] for x in seen[: frame + 1]]),
                   color=color, label=JOINTS[i])  # fmt: skip
    right.set(xlabel="time [s]", ylabel="angle [deg], its target dotted", ylim=(-25, 72))
    right.legend(loc="upper right", ncols=3)
    picture = Image.open(io.BytesIO(to_bytes(figure, "png"))).convert("RGB")
    return picture.resize((round(picture.width * 0.55), round(picture.height * 0.55)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("path", help="GIF to write")
    path = parser.parse_args().path
    leg = build()
    lines = [
        f"{x.tendon:10}  {x.chosen.count} × {x.chosen.name}, {1e3 * x.chosen.length:.0f} mm,"
        f" rest_length {1e3 * x.rest_length:.0f} mm, margin {100 * x.chosen.margin:.0f} %"
        for x in leg.sizings
    ]
    seen = walk(leg, 3 * PERIOD, each=50)
    error = np.rad2deg([x["angles"] - x["targets"] for x in seen if x["time"] > PERIOD])
    lines += [
        f"errors in deg, root mean square: {np.sqrt(np.mean(error**2, axis=0)).round(1)}",
        f"inside of the tables: {not any(x['status'].any() for x in seen)}",
    ]
    sys.stdout.write("\n".join(lines) + "\n")
    seen = [x for x in seen if x["time"] > 2 * PERIOD]  # when the integrals have settled
    frames = [draw(leg, seen, k) for k in range(len(seen))]
    # colors of the last frame, where all curves are complete
    colors = frames[-1].quantize(96)
    frames = [frame.quantize(palette=colors, dither=Image.Dither.NONE) for frame in frames]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=50, loop=0)


if __name__ == "__main__":
    sys.exit(main())

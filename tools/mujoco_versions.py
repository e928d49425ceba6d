"""Try the NumPy path of `fascicle.robots` with several versions of MuJoCo, without MJX.

Each version is installed with `fascicle[jax]` (the muscles' tables need JAX) into a fresh
environment, where a muscle is sized to a tendon and attached, and a pendulum steps with valves, by
Euler and by Runge-Kutta. A line for each version says what came of it.

    python tools/mujoco_versions.py 2.3.7 3.1.6 3.17.0
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path


ROOT = Path(__file__).parents[1]
VERSIONS = ("2.3.3", "2.3.7", "3.0.1", "3.1.6", "3.2.7", "3.3.7", "3.8.1", "3.17.0", "4.0.0")
TRIAL = '''
import mujoco
import numpy as np
import fascicle as fs
from fascicle import fluid
from fascicle.robots import Drive, attach, size
XML = """<mujoco><compiler angle="radian"/><option timestep="0.001"/><worldbody><body>
<joint name="elbow" type="hinge" axis="0 -1 0" range="-1.2 1.2" limited="true" damping="0.05"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.5"/></body></worldbody>
<tendon><fixed name="flexor"><joint joint="elbow" coef="-0.02"/></fixed></tendon>
<actuator><motor name="flexor_bundle" tendon="flexor"/></actuator></mujoco>"""
model = mujoco.MjModel.from_xml_string(XML)
muscle = fs.example("kim2021_figure_6")
sizing = size(model, "flexor", muscle, 0.3, "413.7 kPa")
attached = attach(model, "flexor", sizing.bundle, sizing.rest_length)
valve = fluid.SonicValve(C=5e-10, b=0.3)
drive = Drive.of(model, [attached], supply=fluid.ConstantSupply("413.7 kPa"),
                 chamber=fluid.Isothermal(dead_volume="2 mL"), valve=valve)
angles = []
for integrator in (0, 1):
    model.opt.integrator = integrator
    data = mujoco.MjData(model)
    state = drive.start(model, data, "100 kPa")
    for _ in range(300):
        state = drive.step(model, data, state, [0.2])
    angles.append(float(data.qpos[0]))
assert abs(angles[0] - angles[1]) < 0.02 and 0.05 < angles[0] < 1.25, angles
print(f"{np.rad2deg(angles[0]):.3f} deg by Euler, {np.rad2deg(angles[1]):.3f} by Runge-Kutta")
'''


def trial(version: str) -> str:
    """What came of MuJoCo's `version`: the angles, or the last line of the error."""
    with tempfile.TemporaryDirectory() as folder:
        uv, python = Path(sys.executable).parent / "uv", Path(folder) / "bin" / "python"
        wanted = ["--only-binary", "mujoco", f"{ROOT}[jax]", f"mujoco=={version}"]
        for command in (
            [uv, "venv", "--quiet", "--python", sys.executable, folder],
            [uv, "pip", "install", "--quiet", "--python", python, *wanted],
            [python, "-c", TRIAL],
        ):
            without = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
            done = subprocess.run(  # noqa: S603 commands of this module
                command, capture_output=True, text=True, env=without, cwd=folder, check=False
            )
            if done.returncode:
                return f"fails: {done.stderr.strip().splitlines()[-1]}"
    return done.stdout.strip()


if __name__ == "__main__":
    for version in sys.argv[1:] or VERSIONS:
        sys.stdout.write(f"{version:8} {trial(version)}\n")
        sys.stdout.flush()

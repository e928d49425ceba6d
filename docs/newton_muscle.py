"""McKibben muscles in Newton: a drive that looks their force up in a table of fascicle's.

Needs `pip install newton`, 1.8 or later, whose actuators are experimental. A muscle turns a joint
by an arm: torque = arm · F(P, ε), with ε = ε₀ + arm · q / L₀. Of two muscles at the joint 0:

    drive = MuscleDrive(muscle.table("413.7 kPa"), np.array([0.02, -0.02]), np.array([0.1, 0.1]))
    actuator = newton.actuators.Actuator(wp.zeros(2, dtype=wp.uint32), drive=drive)
    control.pressures = wp.array([200e3, 100e3], dtype=float)

and before each step of Newton's solver `control.joint_f.zero_()`, `actuator.step(state, control)`.
"""

import numpy as np
import warp as wp
from newton.actuators import DriveBase

import fascicle as fs


@wp.kernel
def pull(
    q: wp.array[float],
    index: wp.array[wp.uint32],
    pressure: wp.array[float],
    muscles: wp.array[wp.vec2],  # arm [m] and ε₀ [-]
    cells: wp.array2d[wp.mat44],
    grid: wp.vec4,  # end of the first line [Pa], lowest strain and step of strain [-], length [m]
    torque: wp.array[float],
):
    k = wp.tid()
    arm, lines, columns = muscles[k][0], float(cells.shape[0]), float(cells.shape[1])
    p = wp.clamp(pressure[k] / grid[0], 0.0, lines * lines)  # lines are even in its root
    i = wp.min(wp.floor(wp.sqrt(p)), lines - 1.0)
    u = wp.where(i > 0.0, wp.sqrt(p) - i, p)
    strain = muscles[k][1] + arm * q[index[k]] / grid[3]
    column = wp.clamp((strain - grid[1]) / grid[2], 0.0, columns)
    j = wp.min(wp.floor(column), columns - 1.0)
    w = column - j
    slope = cells[int(i), int(j)] * wp.vec4(0.0, 1.0, 2.0 * w, 3.0 * w * w)  # (V3)
    torque[k] = arm * wp.dot(wp.vec4(1.0, u, u * u, u * u * u), slope) / (grid[2] * grid[3])


class MuscleDrive(DriveBase):
    """Muscles of one `table` with `arms` [m], contracted by `at_zero` [-] where their joint is at
    zero. Their gauge pressures [Pa] are the array `pressures` of Newton's control.
    """

    custom_inputs = ("pressures",)

    def __init__(self, table: fs.MuscleTable, arms: np.ndarray, at_zero: np.ndarray):
        low, high = table.strains
        step = (high - low) / table.coefficients.shape[1]
        self.muscles = wp.array(np.stack([arms, at_zero], axis=1), dtype=wp.vec2)
        self.cells = wp.array(table.coefficients, dtype=wp.mat44)
        self.grid = wp.vec4(*map(float, (table.root_step**2, low, step, table.rest_length)))

    def compute(self, positions, *others, custom_inputs, **_):
        index, torque = others[4], others[8]
        inputs = positions, index, custom_inputs["pressures"], self.muscles, self.cells, self.grid
        wp.launch(pull, dim=len(index), inputs=[*inputs, torque])

    def is_stateful(self):
        return False

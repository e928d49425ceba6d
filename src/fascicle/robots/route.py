"""Lengths and moment arms of a tendon over a grid of poses.

**Sign:** a moment arm is positive where a pull on the tendon raises the joint's coordinate; it is
the negative derivative of the tendon's length, as in OpenSim. MuJoCo's `actuator_moment` has the
other sign for an actuator that pushes.
"""

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Numbers, Values, Whole
from ..core.validation import check_choice, check_interval
from .optional_imports import Model, mujoco


_STEP = 1e-5  # rad or m, of central differences: the length is known to 1e-16 m
_MOVES = 1e-6  # m/rad or m/m, the least moment arm that counts

Ranges = dict[str, Sequence[Values]]  # ends of joints' coordinates by name [rad or m]


class Route(NamedTuple):
    """A tendon's way: names of the `joints` that move it, their coordinates in `poses`, a row for
    each [rad or m], and of each pose the tendon's `lengths` [m] and `moment_arms` about the
    `torque_joint` [m, or - of a slide]. `spatial`: true of a tendon that has a path.
    """

    joints: tuple[str, ...]
    torque_joint: str
    poses: np.ndarray
    lengths: np.ndarray
    moment_arms: np.ndarray
    hinge: bool
    spatial: bool

    @property
    def coordinate(self) -> np.ndarray:
        """Coordinate of the torque's joint in each pose [rad or m]."""
        return self.poses[:, self.joints.index(self.torque_joint)]

    def format_coordinate(self, index: int) -> str:
        """Coordinate of the torque's joint in the pose `index`, with its unit."""
        value = float(self.coordinate[index])
        return f"{np.rad2deg(value):.0f} deg" if self.hinge else f"{1e3 * value:.1f} mm"


def trace_route(
    model: Model,
    tendon: str,
    joint: str | None,
    ranges: Ranges | None,
    points: int,
) -> Route:
    """Trace a `tendon` of MuJoCo's compiled `model` over `points` of each joint that moves it;
    arguments are those of `size`. `InvalidInputError` for unknown names, and joints without range.
    """
    names = [model.tendon(i).name for i in range(model.ntendon)]
    index = names.index(check_choice(tendon, names, "tendon"))
    data = mujoco.MjData(model)

    def length(addresses: Whole, coordinates: Numbers) -> float:
        data.qpos[:] = model.qpos0
        data.qpos[addresses] = coordinates
        mujoco.mj_fwdPosition(model, data)
        return float(data.ten_length[index])

    kinds = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    single = [i for i in range(model.njnt) if int(model.jnt_type[i]) in kinds]
    adr = {model.joint(i).name: int(model.jnt_qposadr[i]) for i in single}
    limits = {model.joint(i).name: _joint_limits(model, i, ranges) for i in single}
    moving_joints = [name for name in adr if _moves(length, adr[name], limits[name])]
    if not moving_joints:
        rule = f"{tendon!r} isn't moved by any hinge or slide joint"
        raise InvalidInputError("tendon", rule, tendon, shown="")
    for name in (*(ranges or {}), *([] if joint is None else [joint])):
        check_choice(name, moving_joints, "joint")
    if joint is None and len(moving_joints) > 1:
        rule = f"must be named for {tendon!r}, which several move: {', '.join(moving_joints)}"
        raise InvalidInputError("joint", rule, None)
    about = moving_joints[0] if joint is None else joint
    if free := [name for name in moving_joints if limits[name] is None]:
        remedy = f"pass ranges={{{free[0]!r}: (low, high)}}, or limit it in the model"
        raise InvalidInputError("ranges", f"must have the joint {free[0]!r}", None, remedy)
    grids = [np.linspace(*(limits[name] or (0.0, 0.0)), points) for name in moving_joints]
    poses = np.array(list(itertools.product(*grids)))
    lengths, arms = np.empty(len(poses)), np.empty(len(poses))
    addresses = [adr[name] for name in moving_joints]
    step = _STEP * (np.array(moving_joints) == about)
    for row, pose in enumerate(poses):
        lengths[row] = length(addresses, pose)
        arms[row] = length(addresses, pose - step) - length(addresses, pose + step)
    arms /= 2 * _STEP
    hinge = int(model.joint(about).type[0]) == kinds[0]
    fixed = int(model.wrap_type[model.tendon_adr[index]]) == int(mujoco.mjtWrap.mjWRAP_JOINT)
    return Route(tuple(moving_joints), about, poses, lengths, arms, hinge, not fixed)


def _joint_limits(model: Model, joint: int, ranges: Ranges | None) -> tuple[float, float] | None:
    """Ends of a joint's coordinate [rad or m], from `ranges` or the model; `None` without any."""
    name = model.joint(joint).name
    hinge = int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_HINGE)
    if ranges and name in ranges:
        unit = "rad" if hinge else "m"
        ends = [check_interval(x, -np.inf, np.inf, "ranges", unit) for x in ranges[name]]
        return float(min(ends)), float(max(ends))
    if not model.jnt_limited[joint]:
        return None
    low, high = model.jnt_range[joint]
    return float(low), float(high)


def _moves(
    length: Callable[[int, float], float], address: int, limits: tuple[float, float] | None
) -> bool:
    """True if a joint moves the tendon somewhere in its range."""
    low, high = limits or (-0.5, 0.5)
    # a wrapped tendon may leave a joint here and there
    lengths = [length(address, value) for value in np.linspace(low, high, 7)]
    return float(np.ptp(lengths)) > _MOVES * (high - low)

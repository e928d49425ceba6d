"""Columns of torque and angle as the moment arms and the shortening of the muscle."""

import numpy as np

from ..units import pretty
from .headers import MissingMetadataError
from .joint import ArmTable, JointReadings, sampled_arms, usable_arms
from .quantities import Readings
from .sidecar import Sidecar


def read_joint(readings: Readings, info: Sidecar) -> JointReadings | None:
    """Moment arms of readings of torque or angle; `None` for other readings."""
    columns, position, raws = readings.columns, readings.position, readings.raws
    on_joint = [columns[role] for role in ("torque",) if role in columns]
    on_joint += [position] if position.role == "angle" else []
    if not on_joint:
        return None
    table, angle, arm = readings.table, readings.si("angle"), readings.si("moment_arm")
    where = f"{table.where}, column `{on_joint[-1].header}`"
    arms = info.arm_table
    if arms is not None and angle is None:
        before = f"{table.where}: no column of angle found, which the moment arms depend on: give "
        raise MissingMetadataError(before, ("constants", "angle", "30 deg", " or its column"))
    if arms is not None and angle is not None:
        excess = arms.excess(angle)
        if np.any(excess > 0):
            row = int(np.argmax(excess))
            rule = f"{raws['angle'][row]:.6g} {columns['angle'].unit} {_outside_message(arms)}."
            raise readings.cell_error(row, columns["angle"], rule)
        arm = arms.arm_at(angle)
    elif arm is not None:
        if angle is not None and position.role == "angle" and columns["moment_arm"].index >= 0:
            try:
                arms = sampled_arms(angle, arm)
            except ValueError as error:
                raise ValueError(f"{where}: {error}.") from None
    else:
        article = "an" if position.role == "angle" else "a"
        before = f"{where}: {article} {on_joint[-1].role} needs the moment arm of the muscle: give "
        after = ", or a table [moment_arm] of angle and arm in the TOML beside it"
        raise MissingMetadataError(before, ("moment_arm", "", "25 mm", after))
    if not np.any(arm):
        raise ValueError(f"{where}: all moment arms are 0: check their column or table.")
    shortening = None
    if angle is not None and position.role == "angle":
        shortening = _shortening(where, angle, arm, arms, info)
    used, notes = usable_arms(arm) if "torque" in columns else (np.ones(arm.size, bool), ())
    return JointReadings(used, arm[used], None if shortening is None else shortening[used], notes)


def _shortening(
    where: str, angle: np.ndarray, arm: np.ndarray, arms: ArmTable | None, info: Sidecar
) -> np.ndarray:
    """Shortening of the muscle at each `angle` [rad] from that at rest [m]."""
    rest_angle = info.angle_at_rest
    if rest_angle is None:
        before = f"{where}: an angle needs the one at which the muscle has its rest length: give "
        raise MissingMetadataError(before, ("zeros", "angle", "0 deg", ", or its value"))
    if arms is None:
        return arm * (angle - rest_angle)
    if arms.excess(np.array(rest_angle)) > 0:
        raise ValueError(
            f"{where}: {pretty(rest_angle, 'angle')}, at rest, {_outside_message(arms)}."
        )
    return arms.shortening(angle, rest_angle)


def _outside_message(arms: ArmTable) -> str:
    low, high = (pretty(float(x), "angle") for x in (arms.angle[0], arms.angle[-1]))
    return f"lies beyond the angles of the moment arms, {low} to {high}"

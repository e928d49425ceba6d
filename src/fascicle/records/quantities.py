"""Columns of a table as quantities [SI]: pressure, force, contraction, branch and time.

Pressures in kPa under `pressure [Pa]` can be parsed, but a fit would give a muscle a thousand times
too strong. So readings must lie in the range of muscles: gauge pressures up to 1 MPa, contractions
from −0.2 to 0.9, and a force that a muscle's cross section can bear.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..core.validation import HIGHEST_PRESSURE
from ..units import pretty
from .headers import (
    DEFLATING,
    INFLATING,
    POSITIONS,
    Column,
    MissingMetadataError,
    is_gauge_unit,
    unit_factor,
)
from .joint import ArmTable, JointReadings, sampled_arms, usable_arms
from .record import DOWN, STRAINS, UNKNOWN, UP
from .sidecar import Sidecar
from .tables import Table


_MIN_PRESSURE = 2e3  # Pa: a record that stays below, but pulls, is in another unit
_LOW_PRESSURE = 10e3  # Pa: of records below in bar under kPa, a pull of more than
_LOW_AREA = 5e-3  # m² times it would be that of a muscle as thick as an arm
_MAX_AREA = 0.05  # m²: the largest muscles reach 6 kN at 0.6 MPa, a fifth of it
_NOISE = (0.02, 5e3)  # of the highest pressure, and Pa: a transducer's zero may be off by that
_MIN_FORCE = 1.0  # N: less is too little to infer a unit from
# units to suggest where a column's unit makes no sense, the likeliest first
_SUGGESTIONS = {"pressure": ("kPa", "bar", "psi", "Pa", "MPa"), "force": ("N", "lbf", "kN")}
_DATE = 1e8  # s since 1970, in 1973
_PER_SECOND = (("ns", 1e9), ("µs", 1e6), ("ms", 1e3))
_DAYS = (3e4, 7e4)  # dates of 1982 to 2091 as Excel counts them
_FREE = 0.45  # contraction beyond any muscle's free strain
_FAR = 0.05  # of the rest length: a muscle begins nearer to it
_STRETCHED = -1e-3  # strain: a gauge's zero is off by that much
_TOP = 0.95  # of the highest pressure: readings above it show how the force follows contraction
_MIN_READINGS = 5  # there: fewer show no direction
_STEADY = 0.1  # of the largest: the force of an isotonic record varies less, its pressure more
_RISING = 0.5  # correlation of force and contraction: any muscle's is near -1, noise gives 0
_ODD = 0.05  # of the readings: fewer beyond any muscle's are no wrong unit, but marks of errors
_ODD_REMEDY = "far beyond all other readings: if it marks an error, empty the cell"
_OUTLIER = 10.0  # times any other force: no muscle's largest readings differ by that
_AT_REST = 0.02  # contraction: any muscle under pressure still pulls there

BRANCHES = {
    **dict.fromkeys(("1", "+1", "1.0", *INFLATING), UP),
    **dict.fromkeys(("-1", "-1.0", *DEFLATING), DOWN),
    **dict.fromkeys(("0", "0.0", "", "-", "unknown"), UNKNOWN),
}
_FLAGS = {
    **dict.fromkeys(("1", "1.0", "true", "yes", "y", "x", "clipped", "censored"), True),
    **dict.fromkeys(("0", "0.0", "false", "no", "n", "", "-", "ok"), False),
}


def to_si_units(values: np.ndarray, factor: float) -> np.ndarray:
    """Multiply `values` by the `factor` of their unit, with a single rounding where possible.

    A thousandth has no float, but a division by a thousand rounds only once: 9 mm are the float
    9e-3, and nine times a thousandth is not.
    """
    divisor = round(1 / factor)
    if factor < 1 and divisor > 1 and 1 / divisor == factor:
        return values / divisor
    return values * factor if factor != 1 else values


@dataclass(frozen=True)
class Readings:
    """Rows of a `table`: the `columns` that were read, and their cells by role.

    - `raws`: numbers in the units of the columns, a constant's for each row.
    - `texts`: of branches and flags.
    - `lines`: the file's line of each row.
    """

    table: Table
    columns: Mapping[str, Column]
    raws: Mapping[str, np.ndarray]
    texts: Mapping[str, np.ndarray]
    lines: np.ndarray

    @property
    def position(self) -> Column:
        """Column of strains, lengths, displacements or angles."""
        return self.columns[next(role for role in POSITIONS if role in self.columns)]

    @property
    def pull(self) -> Column:
        """Column of forces or torques."""
        return self.columns["force" if "force" in self.columns else "torque"]

    def si(self, role: str) -> np.ndarray | None:
        """Numbers of a role [SI], or `None`."""
        column = self.columns.get(role)
        return None if column is None else to_si_units(self.raws[role], column.factor)

    def only(self, mask: np.ndarray) -> "Readings":
        """Rows in a `mask`."""
        raws, texts = ({role: cells[mask] for role, cells in columns.items()}
                       for columns in (self.raws, self.texts))  # fmt: skip
        return replace(self, raws=raws, texts=texts, lines=self.lines[mask])

    def cell_error(self, row: int, column: Column, rule: str) -> ValueError:
        """The error for a row's cell of a `column` that breaks a `rule`."""
        if column.index < 0:
            return ValueError(f"{self.table.source}: constant {column.role}: {rule}")
        return self.table.cell_error(int(self.lines[row]), column.index, rule)


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
        shortening = _joint_shortening(where, angle, arm, arms, info)
    used, notes = usable_arms(arm) if "torque" in columns else (np.ones(arm.size, bool), ())
    return JointReadings(used, arm[used], None if shortening is None else shortening[used], notes)


def _joint_shortening(
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


def read_force(readings: Readings, joint: JointReadings | None, info: Sidecar) -> np.ndarray:
    """Pulling force [N], from a column of forces or torques."""
    if (force := readings.si("force")) is not None:
        force = force - (info.force_at_rest or 0.0)
    else:
        torque = readings.si("torque")
        assert torque is not None  # a table without either is refused
        assert joint is not None
        force = (torque - (info.torque_at_rest or 0.0)) / joint.arm
    return force * (info.signs.sign("force") or 1)


def read_pressure(
    readings: Readings, force: np.ndarray, info: Sidecar
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Gauge pressure [Pa], noise below zero set to zero, and notes; refuses lower pressures, and
    units that can't be right beside the `force` [N].
    """
    column, raw = readings.columns["pressure"], readings.raws["pressure"]
    zero = (info.pressure_at_rest or 0.0) + ((info.atmosphere or 0.0) if column.absolute else 0.0)
    pressure = to_si_units(raw, column.factor) - zero
    row, lowest = int(np.argmax(pressure)), int(np.argmin(pressure))
    top, low, strongest = pressure[row], pressure[lowest], np.max(np.abs(force))
    highest, rule, notes = _reading_text(raw[row], column), "", []
    if top > HIGHEST_PRESSURE and np.mean(pressure > HIGHEST_PRESSURE) < _ODD:
        raise readings.cell_error(row, column, f"{highest}: {_ODD_REMEDY}.")
    if top > HIGHEST_PRESSURE:
        rule = f"{highest} is above {HIGHEST_PRESSURE / 1e6:g} MPa, more than muscles bear"
    elif (0 < top <= _MIN_PRESSURE and strongest > _MIN_FORCE) or (
        0 < top <= _LOW_PRESSURE and strongest > _LOW_AREA * top
    ):
        rule = f"the highest is {highest}, with forces up to {strongest:.3g} N"
    if rule:
        raise readings.cell_error(row, column, f"{rule}{_suggest_unit(column, raw[row])}")
    if low < -min(_NOISE[0] * max(top, 0.0), _NOISE[1]):
        text = _reading_text(raw[lowest], column)
        rule = f"{text} is below zero by more than noise:"
        if column.absolute:
            remedy = "check the atmosphere, or leave it out if the pressure is gauge."
            raise readings.cell_error(lowest, column, f"{rule} {remedy}")
        before = str(readings.cell_error(lowest, column, f"{rule} give "))
        after = ", or another reading of the transducer at zero"
        raise MissingMetadataError(before, ("zeros", "pressure", text, after))
    if below := int(np.count_nonzero(pressure < 0)):
        notes.append(f"{below} pressures below zero, down to {low:.3g} Pa, set to 0")
    _check_forces(readings, force, max(float(top), 0.0))
    if np.max(force) <= 0 < -np.min(force):
        notes.append('no reading pulls: if they do, signs.force is "pushing positive"')
    return np.maximum(pressure, 0.0), tuple(notes)


def _check_forces(readings: Readings, force: np.ndarray, top: float) -> None:
    """Refuse a `force` [N] that needs too large an area at the pressure `top` [Pa]."""
    column, row = readings.pull, int(np.argmax(np.abs(force)))
    raw = readings.raws[column.role]
    ordinary = np.abs(force[raw != raw[row]])
    if ordinary.size > (1 - _ODD) * raw.size and 0 < _OUTLIER * ordinary.max() < abs(force[row]):
        text = _reading_text(raw[row], column)
        raise readings.cell_error(row, column, f"{text}: {_ODD_REMEDY}.")
    area = abs(float(force[row])) / top if top > _MIN_PRESSURE else 0.0
    if area > _MAX_AREA:
        rule = f"{_reading_text(raw[row], column)} at no more than {top / 1e3:.4g} kPa"
        suggestion = _suggest_unit(column, raw[row], area / _MAX_AREA)
        message = f"{rule} needs {area:.2g} m² of cross section{suggestion}"
        raise readings.cell_error(row, column, message)


def _reading_text(value: float, column: Column) -> str:
    return f"{value:.6g} {column.unit}".rstrip()


def _suggest_unit(column: Column, worst: float, excess: float = 0.0) -> str:
    """End of an error: `: did you mean kPa?`, a unit in which `worst` makes sense, or `: check its
    unit.` `excess`: factor by which a force is too large.
    """
    for unit in _SUGGESTIONS.get(column.role, ()):
        factor = unit_factor(unit, column.role)
        if column.role == "pressure" and not 10e3 <= worst * factor <= HIGHEST_PRESSURE:
            continue
        if column.role == "force" and factor > column.factor / excess:
            continue
        if factor != column.factor:
            return f": did you mean {unit}?"
    return (
        ": check its unit and the moment arm." if column.role == "torque" else ": check its unit."
    )


def read_strain(
    readings: Readings,
    joint: JointReadings | None,
    rest_length: float,
    pressure: np.ndarray,
    force: np.ndarray,
    info: Sidecar,
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Contraction, from strains, displacements, lengths or angles, and notes; its direction is
    checked against `pressure` [Pa] and `force` [N].
    """
    column, cell_error = readings.position, readings.cell_error
    raw, values = readings.raws[column.role], readings.si(column.role)
    if joint is not None and joint.shortening is not None:
        values = joint.shortening
    assert values is not None  # a table without a position is refused
    has_direction = info.signs.sign(column.role) or info.signs.sign("strain")
    sign = has_direction or column.sign
    if column.role == "strain":
        strain = values * sign
        _check_fractions(readings)
        _check_percent(readings, pressure, force, info)
    elif column.role in ("displacement", "angle"):
        zero = info.displacement_at_rest if column.role == "displacement" else None
        strain = (values - (zero or 0.0)) * sign / rest_length
    else:
        _check_lengths(readings, values)
        strain = (rest_length - values) / rest_length
    if column.role != "length" and not has_direction:
        _check_direction(readings, strain, pressure, force)
    reach, shifted = (np.array([np.min(x), np.max(x)]) for x in (strain, strain - strain[0]))
    far, row = not _is_strain(reach) and _is_strain(shifted), 0
    if reach[0] > _FAR and reach[1] > _FREE and _is_strain(reach):
        far, row = True, int(np.argmin(strain))
    if column.role == "displacement" and info.displacement_at_rest is None and far:
        text = f"{raw[row]:.6g} {column.unit}"
        before = f"{cell_error(row, column, '')}{text} is far from rest:"
        choice = ("zeros", "displacement", text, ", or its value at rest")
        raise MissingMetadataError(f"{before} give ", choice)
    low, high = STRAINS
    row = int(np.argmax(np.maximum(low - strain, strain - high)))
    if not low <= strain[row] <= high:
        hint = f"it must lie from {low} to {high}, check its unit and sign."
        if column.role != "strain":
            side = "longer than at rest" if strain[row] < 0 else "shorter than at rest"
            arm = "moment arm, " if column.role == "angle" else ""
            hint = f"{abs(strain[row]):.3g} of it {side}: check rest length, {arm}unit and sign."
        if np.mean((strain < low) | (strain > high)) < _ODD:
            hint = f"{_ODD_REMEDY}."
        rule = f"{_reading_text(raw[row], column)} is a contraction of {strain[row]:.4g}: {hint}"
        raise cell_error(row, column, rule)
    notes, longest = (), float(np.min(strain))
    if longest < _STRETCHED:
        count = int(np.count_nonzero(strain < _STRETCHED))
        notes = (f"{count} readings stretched beyond rest, down to {longest:.3g}",)
    elif column.role == "displacement" and info.displacement_at_rest is None and longest > _FAR:
        least = f"{raw[int(np.argmin(strain))]:.6g} {column.unit}"
        notes = (f"all displacements are beyond {least}: if it is 0 there, give {least} as zero",)
    return strain + 0.0, notes  # without negative zeros


def _is_strain(values: np.ndarray) -> bool:
    return bool(np.all((STRAINS[0] <= values) & (values <= STRAINS[1])))


def _check_lengths(readings: Readings, lengths: np.ndarray) -> None:
    """Refuse `lengths` [m] that are not positive."""
    column, raw = readings.position, readings.raws["length"]
    wrong = np.flatnonzero(lengths <= 0)
    if not wrong.size:
        return
    rule = f"{raw[wrong[0]]:g} is no length of a muscle"
    if wrong.size < _ODD * raw.size and -raw[wrong[0]] > raw.max():
        rule = f"{rule}, and {_ODD_REMEDY}"
    elif column.index >= 0:
        before = readings.cell_error(
            int(wrong[0]), column, f"{rule}: if it counts from rest, give "
        )
        raise MissingMetadataError(str(before), ("columns", "displacement", column.header, ""))
    raise readings.cell_error(int(wrong[0]), column, f"{rule}.")


def _check_fractions(readings: Readings) -> None:
    """Refuse strains without a unit that are no fractions."""
    column, raw = readings.position, readings.raws["strain"]
    row = int(np.argmax(np.abs(raw)))
    has_remark = not column.unit and column.header.strip()[-1:] in tuple("])}")
    if column.factor == 1 and column.index >= 0 and abs(raw[row]) > 1 and not has_remark:
        rule = f"{raw[row]:.6g} is a contraction of {raw[row]:.4g}: did you mean %? Give "
        length = ("columns", "displacement", column.header, ", if it is a length")
        raise MissingMetadataError(
            str(readings.cell_error(row, column, rule)), ("units", "strain", "%", ""), length
        )


def _check_percent(
    readings: Readings, pressure: np.ndarray, force: np.ndarray, info: Sidecar
) -> None:
    """Refuse a contraction below 1 % over which the pull at the highest pressure falls by half.
    `pressure` [Pa], `force` [N].
    """
    column, raw = readings.position, readings.raws["strain"]
    F = force[pressure > _TOP * pressure.max()]
    is_guessed = column.factor == 1e-2 and column.index >= 0 and "strain" not in info.units
    is_small = is_guessed and 0 < np.max(np.abs(raw)) < 1
    if is_small and F.size >= _MIN_READINGS and np.min(F) < np.max(F) / 2:
        before = (
            f"{readings.table.where}, column `{column.header}`: the pull falls from"
            f" {np.max(F):.3g} N to {np.min(F):.3g} N over contractions of no more than"
            f" {np.max(np.abs(raw)):.3g} %: if these are fractions, give "
        )
        choices = (("units", "strain", "1", ""), ("units", "strain", "%", ", if they are %"))
        raise MissingMetadataError(before, *choices)


def _check_direction(
    readings: Readings, strain: np.ndarray, pressure: np.ndarray, force: np.ndarray
) -> None:
    """Refuse a position, of no stated direction, that stretches the muscle or along which it pulls
    harder while it contracts. `strain` [-], `pressure` [Pa], `force` [N].
    """
    column, is_longer = readings.position, strain < _STRETCHED
    top, rule = pressure > _TOP * pressure.max(), ""
    x, F = strain[top], force[top]
    if x.size >= _MIN_READINGS and np.ptp(x) > 0 < np.ptp(F) and np.mean(F) > 0:
        is_mostly_longer = column.role == "angle" or np.mean(is_longer) > 0.5
        if is_mostly_longer and np.corrcoef(x, F)[0, 1] > _RISING:
            rule = "the pull grows with contraction, which no muscle's does"
    is_isotonic = (
        strain.size >= _MIN_READINGS
        and np.ptp(strain) > 0
        and np.ptp(force) < _STEADY * np.max(np.abs(force))
        and np.ptp(pressure) > _STEADY * np.max(pressure)
    )
    if is_isotonic and np.corrcoef(strain, pressure)[0, 1] < -_RISING:
        rule = "the muscle lengthens as its pressure rises, which none does under one load"
    is_unknown = column.role != "strain" and column.sign > 0
    if is_unknown and np.any(is_longer) and np.max(strain) < -_STRETCHED:
        rule = rule or f"all {column.role}s stretch the muscle"
    if rule:
        where, sign = f"{readings.table.where}, column `{column.header}`", column.sign
        directions, verbs = ["extension", "contraction"][::sign], ["lengthens", "shortens"][::sign]
        choice = ("signs", column.role, f"{directions[0]} positive", f", else {directions[1]}")
        before = f"{where}: {rule}: if the {column.role} grows as the muscle {verbs[0]}, give "
        raise MissingMetadataError(before, choice)


def check_pull(
    readings: Readings,
    strain: np.ndarray,
    pressure: np.ndarray,
    force: np.ndarray,
    info: Sidecar,
) -> None:
    """Refuse a force of no stated direction that pushes where any muscle pulls: at rest under
    pressure, or less and less along contraction. `strain` [-], `pressure` [Pa], `force` [N].
    """
    top = pressure > _TOP * pressure.max()
    x, F = strain[top], force[top]
    if info.signs.force is not None or not x.size or -F.min() <= max(2 * F.max(), 0.0):
        return
    at_rest = np.abs(x) < _AT_REST
    pushes_at_rest = np.any(at_rest) and np.max(F[at_rest]) < 0
    is_sweep = x.size >= _MIN_READINGS and np.ptp(x) > 0 < np.ptp(F) and np.mean(F) < 0
    if pushes_at_rest or (is_sweep and np.corrcoef(x, F)[0, 1] > _RISING):
        where = f"{readings.table.where}, column `{readings.pull.header}`"
        before = f"{where}: the muscle pushes where all muscles pull: if a pull is negative, give "
        raise MissingMetadataError(before, ("signs", "force", "pushing positive", ", else pulling"))


def check_atmosphere(
    readings: Readings, strain: np.ndarray, pressure: np.ndarray, force: np.ndarray
) -> tuple[str, ...]:
    """A note on a lowest `pressure` [Pa] that may be the atmosphere; refuses one at which a muscle
    at rest doesn't pull. `strain` [-], `force` [N].
    """
    column, low = readings.columns["pressure"], float(np.min(pressure))
    is_gauge = column.absolute or is_gauge_unit(column.unit)
    if is_gauge or not (90e3 < low < 110e3 and np.max(pressure) > 1.5 * low):
        return ()
    at_rest = (pressure < 1.05 * low) & (np.abs(strain) < _AT_REST)
    if np.any(at_rest) and np.max(np.abs(force[at_rest])) < _STEADY * np.max(force):
        before = (
            f"{readings.table.where}, column `{column.header}`: at {low / 1e3:.4g} kPa, its lowest"
            " pressure, the muscle doesn't pull at rest: if that is the atmosphere, give "
        )
        gauge = ("units", "pressure", f"{column.unit} (g)", ", if it is gauge")
        raise MissingMetadataError(before, ("atmosphere", "", f"{low / 1e3:.4g} kPa", ""), gauge)
    text = f"{low / 1e3:.4g} kPa"
    return (f"the lowest pressure is {text}: if that is the atmosphere, give it to subtract it",)


def read_censored(
    readings: Readings, force: np.ndarray, info: Sidecar
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Flags of clipped forces, and notes: from a column `clipped`; with `clipped_at_zero`, also
    forces of exactly 0.
    """
    censored = np.zeros(force.size, dtype=bool)
    if "clipped" in readings.columns:
        censored = _meanings(readings, "clipped", _FLAGS, "0 or 1").astype(bool)
    if info.clipped_at_zero:
        censored = censored | (force == 0)
    count, zeros = int(np.count_nonzero(censored)), int(np.count_nonzero(force == 0))
    if count:
        return censored, (f"{count} of {force.size} readings clipped",)
    if zeros > 2 and "clipped" not in readings.columns and info.clipped_at_zero is None:
        hint = "if the gauge can't push, they are clipped at zero"
        return censored, (f"{zeros} forces are exactly 0: {hint}",)
    return censored, ()


def read_branch(readings: Readings) -> np.ndarray:
    """Branch of each reading, unknown without a column."""
    if "branch" not in readings.columns:
        return np.full(readings.lines.size, UNKNOWN, dtype=np.int8)
    return _meanings(readings, "branch", BRANCHES, "up or down").astype(np.int8)


def read_time(
    readings: Readings,
) -> tuple[np.ndarray | None, tuple[str, ...], tuple[str, ...]]:
    """Time [s], if there is a column, notes and doubts."""
    if (time := readings.si("time")) is None:
        return *_sampled_time(readings), ()
    doubts, steps = (), np.diff(time)
    # counted in s they would be dates in 5000 years, or steps below 0.1 ms
    units = {unit: 1 / per_s for unit, per_s in _PER_SECOND if time[0] > _DATE * per_s}
    if _DAYS[0] < time[0] < _DAYS[1] and time.size > 1 and np.median(np.abs(steps)) < 1e-4:
        units = {"days": 86_400.0}
    if units and readings.columns["time"].unit == "s":
        unit = next(iter(units))
        time, doubts = (time - time[0]) * units[unit], (f"time is a date in {unit}, not in s",)
    back = np.flatnonzero(steps < 0)
    if back.size:
        doubts += (f"time goes back in line {readings.lines[back[0] + 1]}",)
    return time, (), doubts


def _sampled_time(readings: Readings) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """Time [s] from the start and the step that LabVIEW writes instead of a column, and a note."""
    table = readings.table
    entries = {title.split()[0]: title.split()[1:] for title in table.titles if title.strip()}
    used = {column.index for column in readings.columns.values()}
    starts, steps = (
        {cell.replace(",", ".") for i, cell in enumerate(entries.get(key, []), 1) if i in used}
        for key in ("X0", "Delta_X")
    )
    if set(entries.get("X_Dimension", ["Time"])) != {"Time"} or not starts or not steps:
        return None, ()
    if len(steps) > 1:
        rule = "the channels have several Delta_X: resample them to one rate"
        raise ValueError(f"{table.where}: {rule}.")
    if len(starts) > 1 or any("End_of_Header" in line for line in table.body):
        return None, ()
    try:
        start, step = float(starts.pop()), float(steps.pop())
    except ValueError:
        return None, ()
    time = start + step * (readings.lines - table.first)
    return time, (f"time from X0 and Delta_X: a reading every {step:g} s",)


def _meanings(readings: Readings, role: str, meanings: Mapping[str, int], rule: str) -> np.ndarray:
    """Meaning of the text in each cell of a column; the error for an unknown one says `rule`."""
    values = [meanings.get(text.lower()) for text in readings.texts[role]]
    if None in values:
        row = values.index(None)
        rule = f"{readings.texts[role][row]!r} isn't known: write {rule}."
        raise readings.cell_error(row, readings.columns[role], rule)
    return np.array(values)

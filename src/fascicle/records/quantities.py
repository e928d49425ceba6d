"""Columns of a table as quantities [SI]: pressure, force, contraction, branch and time.

Pressures in kPa under `pressure [Pa]` can be parsed, but a fit would give a muscle a thousand times
too strong. So readings must lie in the range of muscles: gauge pressures up to 1 MPa, contractions
from −0.2 to 0.9, and a force that a muscle's cross section can bear.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ..core.findings import Finding
from ..core.validation import HIGHEST_PRESSURE
from ..units import pretty
from .headers import POSITIONS, Column, MissingMetadataError, is_gauge_unit, unit_factor, words
from .joint import sampled_arms, usable_arms
from .record import DOWN, STRAINS, UNKNOWN, UP, note, warning
from .sidecar import Sidecar
from .tables import Table


if TYPE_CHECKING:
    import pandas as pd

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
_REPEATS = 3  # readings of each load of a set
_AT_REST = 0.02  # contraction: any muscle under pressure still pulls there

# names of the two ways of a loop
_INFLATING = words(
    "1, +1, 1.0, up, inflating, inflation, inflate, contracting, contraction, shortening, loading,"
    "forward, increasing, rising"
)
_DEFLATING = words(
    "-1, -1.0, down, deflating, deflation, deflate, extending, extension, lengthening, unloading,"
    "backward, reverse, return, decreasing, falling"
)
BRANCHES = (
    dict.fromkeys(_INFLATING, UP)
    | dict.fromkeys(_DEFLATING, DOWN)
    | dict.fromkeys(("0", "0.0", "", "-", "unknown"), UNKNOWN)
)
_FLAGS = dict.fromkeys(words("1, 1.0, true, yes, y, x, clipped, censored"), True) | dict.fromkeys(
    words("0, 0.0, false, no, n, , -, ok"), False
)


def is_flag_of_ways(texts: Iterable[str]) -> bool:
    """True for 1 one way and 0 the other, as of a valve: which is up, is the user's to say."""
    return {*texts} in ({"0", "1"}, {"0.0", "1.0"})


@dataclass(eq=False)
class Readings:
    """Rows of a `table` and their quantities, which `convert` sets.

    - `columns`: that were read, by role.
    - `cells`: by role, and by the file's line of each row: numbers in the units of the columns,
      texts of branches and flags.
    - `info`: what options and sidecar say.
    - `findings`: on what was read, and on what to check.
    - `force` [N], `pressure` [Pa], `strain` [-].
    """

    table: Table
    columns: dict[str, Column]
    cells: "pd.DataFrame"
    info: Sidecar
    findings: list[Finding]
    force: np.ndarray = field(init=False)
    pressure: np.ndarray = field(init=False)
    strain: np.ndarray = field(init=False)

    @property
    def position(self) -> Column:
        """Column of strains, lengths, displacements or angles."""
        return self.columns[next(role for role in POSITIONS if role in self.columns)]

    @property
    def pull(self) -> Column:
        """Which column holds the forces, else the torques: header, unit and sign."""
        return self.columns["force" if "force" in self.columns else "torque"]

    @property
    def _has_set_loads(self) -> bool:
        """True for masses that hung, or none: a load cell rarely reads a force three times."""
        return bool(np.min(np.unique(self.force, return_counts=True)[1]) >= _REPEATS)

    def raw(self, role: str) -> np.ndarray:
        """Cells of a role, in the unit of its column."""
        return self.cells[role].to_numpy()

    def si(self, role: str) -> np.ndarray:
        """Numbers of a role [SI], with a single rounding where possible."""
        values, factor = self.raw(role), self.columns[role].factor
        # a thousandth has no float, but a division by a thousand rounds only once: 9 mm are the
        # float 9e-3, and nine times a thousandth is not
        divisor = round(1 / factor)
        if factor < 1 and divisor > 1 and 1 / divisor == factor:
            return values / divisor
        return values * factor if factor != 1 else values

    def cell_error(self, row: int, column: Column, rule: str) -> ValueError:
        """The error for a row's cell of a `column` that breaks a `rule`."""
        if column.index < 0:
            return ValueError(f"{self.table.source}: constant {column.role}: {rule}")
        return self.table.cell_error(int(self.cells.index[row]), column.index, rule)

    def _ask(
        self, column: Column, rule: str, *choices: tuple[str, str, str, str], row: int | None = None
    ) -> MissingMetadataError:
        """The error for a `column`, or a `row` of it, about which more must be known."""
        where = f"{self.table.place(column.header)}: "
        where = where if row is None else str(self.cell_error(row, column, ""))
        return MissingMetadataError(f"{where}{rule} give ", *choices)

    def _warn(self, code: str, **data: object) -> None:
        self.findings.append(warning(code, **data))

    def _at_top(self) -> tuple[np.ndarray, np.ndarray]:
        """Contraction [-] and force [N] of the readings near the highest pressure."""
        top = self.pressure > _TOP * self.pressure.max()
        return self.strain[top], self.force[top]

    def convert(self, rest_length: float) -> None:
        """Set pressure, force and contraction, and check them; `rest_length` [m]."""
        self.complete_joint()
        self.set_force()
        self.set_pressure()
        self.set_strain(rest_length)
        self.check_pull()
        self.check_atmosphere()

    def complete_joint(self) -> None:
        """Complete torques by the moment arm [m], and angles by the shortening from rest [m]."""
        columns, is_angle = self.columns, self.position.role == "angle"
        if not is_angle and "torque" not in columns:
            return
        column = self.position if is_angle else columns["torque"]
        angle, arm = (self.si(r) if r in columns else None for r in ("angle", "moment_arm"))
        arms, rest_angle = self.info.arm_table, self.info.angle_at_rest
        if arms is not None and angle is not None:
            row = int(np.argmax(arms.excess(angle)))
            if arms.excess(angle)[row] > 0:
                text = f"{self.raw('angle')[row]:.6g} {columns['angle'].unit}"
                raise self.cell_error(row, columns["angle"], f"{text} {arms.outside_text}.")
            arm = arms.arm_at(angle)
        elif arms is not None:
            choice = ("constants", "angle", "30 deg", " or its column")
            raise self._ask(column, "the moment arms depend on an angle:", choice)
        elif arm is None:
            after = ", or a table [moment_arm] of angle and arm in the TOML beside it"
            choice = ("moment_arm", "", "25 mm", after)
            raise self._ask(column, "the moment arm of the muscle is needed:", choice)
        elif angle is not None and is_angle and columns["moment_arm"].index >= 0:
            try:
                arms = sampled_arms(angle, arm)
            except ValueError as error:
                raise ValueError(f"{self.table.place(column.header)}: {error}.") from None
        if not np.any(arm):
            place = self.table.place(column.header)
            raise ValueError(f"{place}: all moment arms are 0: check their column or table.")
        self.cells["moment_arm"] = arm
        columns["moment_arm"] = Column("moment_arm", -1, "moment_arm", "m")
        if angle is not None and is_angle:
            if rest_angle is None:
                rule = "an angle needs the one at which the muscle has its rest length:"
                raise self._ask(column, rule, ("zeros", "angle", "0 deg", ", or its value"))
            if arms is not None and arms.excess(np.array(rest_angle)) > 0:
                rule = f"{pretty(rest_angle, 'angle')}, at rest, {arms.outside_text}"
                raise ValueError(f"{self.table.place(column.header)}: {rule}.")
            shortening = arms.shortening(angle, rest_angle) if arms else arm * (angle - rest_angle)
            self.cells["shortening"] = shortening
        if "torque" in columns:
            usable, short_arms = usable_arms(arm)
            self.cells = self.cells.loc[usable]
            self.findings += short_arms

    def set_force(self) -> None:
        """Set the pulling `force` [N], from a column of forces or torques."""
        if "force" in self.columns:
            force = self.si("force") - (self.info.force_at_rest or 0.0)
        else:
            torque = self.si("torque") - (self.info.torque_at_rest or 0.0)
            force = torque / self.si("moment_arm")
        self.force = force * (self.info.signs.sign("force") or 1)

    def set_pressure(self) -> None:
        """Set and check the gauge `pressure` [Pa], with noise below zero as zero."""
        column, raw, info = self.columns["pressure"], self.raw("pressure"), self.info
        zero = (info.pressure_at_rest or 0.0) + (info.atmosphere or 0.0) * column.absolute
        pressure = self.si("pressure") - zero
        row, lowest = int(np.argmax(pressure)), int(np.argmin(pressure))
        top, low, strongest = pressure[row], pressure[lowest], np.max(np.abs(self.force))
        highest, rule = _reading_text(raw[row], column), ""
        if top > HIGHEST_PRESSURE and np.mean(pressure > HIGHEST_PRESSURE) < _ODD:
            raise self.cell_error(row, column, f"{highest}: {_ODD_REMEDY}.")
        if top > HIGHEST_PRESSURE:
            rule = f"{highest} is above {HIGHEST_PRESSURE / 1e6:g} MPa, more than muscles bear"
        elif (0 < top <= _MIN_PRESSURE and strongest > _MIN_FORCE) or (
            0 < top <= _LOW_PRESSURE and strongest > _LOW_AREA * top
        ):
            rule = f"the highest is {highest}, with forces up to {strongest:.3g} N"
        if rule:
            raise self.cell_error(row, column, f"{rule}{_suggest_unit(column, raw[row])}")
        if low < -min(_NOISE[0] * max(top, 0.0), _NOISE[1]):
            text = _reading_text(raw[lowest], column)
            rule = f"{text} is below zero by more than noise:"
            if column.absolute:
                remedy = "check the atmosphere, or leave it out if the pressure is gauge."
                raise self.cell_error(lowest, column, f"{rule} {remedy}")
            after = ", or another reading of the transducer at zero"
            raise self._ask(column, rule, ("zeros", "pressure", text, after), row=lowest)
        if below := int(np.count_nonzero(pressure < 0)):
            self._warn("pressures_below_zero", count=below, lowest=float(low))
        self._check_forces(max(float(top), 0.0))
        if np.max(self.force) <= 0 < -np.min(self.force):
            self._warn("no_pull")
        self.pressure = np.maximum(pressure, 0.0)

    def _check_forces(self, top: float) -> None:
        """Refuse a force that needs too large an area at the pressure `top` [Pa]."""
        column, row = self.pull, int(np.argmax(np.abs(self.force)))
        raw, strongest = self.raw(column.role), abs(float(self.force[row]))
        ordinary = np.abs(self.force[raw != raw[row]])
        text = _reading_text(raw[row], column)
        if ordinary.size > (1 - _ODD) * raw.size and 0 < _OUTLIER * ordinary.max() < strongest:
            raise self.cell_error(row, column, f"{text}: {_ODD_REMEDY}.")
        area = strongest / top if top > _MIN_PRESSURE else 0.0
        if area > _MAX_AREA:
            rule = f"{text} at no more than {top / 1e3:.4g} kPa needs {area:.2g} m²"
            suggestion = _suggest_unit(column, raw[row], area / _MAX_AREA)
            raise self.cell_error(row, column, f"{rule} of cross section{suggestion}")

    def set_strain(self, rest_length: float) -> None:
        """Set and check `strain` [-], from positions of any kind; `rest_length` [m]."""
        column, info = self.position, self.info
        values = self.si(column.role)
        direction = info.signs.sign(column.role) or info.signs.sign("strain")
        sign = direction or column.sign
        if column.role == "length":
            self._check_lengths(values)
            strain = (rest_length - values) / rest_length
        elif column.role == "strain":
            strain = values * sign
        elif column.role == "angle":
            strain = self.raw("shortening") * sign / rest_length
        else:
            strain = (values - (info.displacement_at_rest or 0.0)) * sign / rest_length
        self.strain = strain + 0.0  # without negative zeros
        if column.role == "strain":
            self._check_fractions()
        if column.role != "length" and direction is None:
            self._check_direction()
        self._check_range()

    def _check_range(self) -> None:
        """Refuse contractions beyond any muscle's, and displacements that don't count from rest."""
        column, strain, (low, high) = self.position, self.strain, STRAINS
        raw, least = self.raw(column.role), int(np.argmin(strain))
        ends = np.array([np.min(strain), np.max(strain)])
        is_given = self.info.displacement_at_rest is not None
        may_be_shifted = column.role == "displacement" and not is_given
        is_far, row = not _is_strain(ends) and _is_strain(ends - strain[0]), 0
        if ends[0] > _FAR and ends[1] > _FREE and _is_strain(ends):
            is_far, row = True, least
        if is_far and may_be_shifted:
            text = f"{raw[row]:.6g} {column.unit}"
            choice = ("zeros", "displacement", text, ", or its value at rest")
            raise self._ask(column, f"{text} is far from rest:", choice, row=row)
        row = int(np.argmax(np.maximum(low - strain, strain - high)))
        if not low <= strain[row] <= high:
            hint = f"it must lie from {low} to {high}, check its unit and sign."
            if column.role != "strain":
                side = "longer than at rest" if strain[row] < 0 else "shorter than at rest"
                arm = "moment arm, " if column.role == "angle" else ""
                excess = f"{abs(strain[row]):.3g} of it {side}"
                hint = f"{excess}: check rest length, {arm}unit and sign."
            if np.mean((strain < low) | (strain > high)) < _ODD:
                hint = f"{_ODD_REMEDY}."
            rule = f"{_reading_text(raw[row], column)} is a contraction of {strain[row]:.4g}"
            raise self.cell_error(row, column, f"{rule}: {hint}")
        if ends[0] < _STRETCHED:
            count = int(np.count_nonzero(strain < _STRETCHED))
            self._warn("stretched", count=count, lowest=float(ends[0]))
        elif ends[0] > _FAR and may_be_shifted and not self._has_set_loads:
            self._warn("displaced", nearest=f"{raw[least]:.6g} {column.unit}")

    def _check_lengths(self, lengths: np.ndarray) -> None:
        """Refuse `lengths` [m] that are not positive."""
        column, raw = self.position, self.raw("length")
        wrong = np.flatnonzero(lengths <= 0)
        if not wrong.size:
            return
        row = int(wrong[0])
        rule = f"{raw[row]:g} is no length of a muscle"
        if wrong.size < _ODD * raw.size and -raw[row] > raw.max():
            rule = f"{rule}, and {_ODD_REMEDY}"
        elif column.index >= 0:
            choice = ("columns", "displacement", column.header, "")
            raise self._ask(column, f"{rule}: if it counts from rest,", choice, row=row)
        raise self.cell_error(row, column, f"{rule}.")

    def _check_fractions(self) -> None:
        """Refuse strains without a unit that are no fractions, and in % that seem to be."""
        column, raw = self.position, np.abs(self.raw("strain"))
        row, (_, F) = int(np.argmax(raw)), self._at_top()
        if column.index < 0:
            return
        has_remark = not column.unit and column.header.strip()[-1:] in tuple("])}")
        if column.factor == 1 and raw[row] > 1 and not has_remark:
            text = f"{self.raw('strain')[row]:.6g}"
            rule = f"{text} is a contraction of {text}: did you mean %? If so,"
            length = ("columns", "displacement", column.header, ", if it is a length")
            raise self._ask(column, rule, ("units", "strain", "%", ""), length, row=row)
        is_small = column.factor == 1e-2 and "strain" not in self.info.units and 0 < raw[row] < 1
        if is_small and F.size >= _MIN_READINGS and np.min(F) < np.max(F) / 2:
            rule = f"the pull falls from {np.max(F):.3g} N to {np.min(F):.3g} N over contractions"
            rule += f" of no more than {raw[row]:.3g} %: if these are fractions,"
            choices = (("units", "strain", "1", ""), ("units", "strain", "%", ", if they are %"))
            raise self._ask(column, rule, *choices)

    def _check_direction(self) -> None:
        """Refuse a position that stretches the muscle, or along which it pulls harder."""
        column, strain, pressure, force = self.position, self.strain, self.pressure, self.force
        is_longer, (x, F), rule = strain < _STRETCHED, self._at_top(), ""
        if x.size >= _MIN_READINGS and np.ptp(x) > 0 < np.ptp(F) and np.mean(F) > 0:
            is_mostly_longer = column.role == "angle" or np.mean(is_longer) > 0.5
            if is_mostly_longer and np.corrcoef(x, F)[0, 1] > _RISING:
                rule = "the pull grows with contraction, which no muscle's does"
        is_held = np.ptp(force) < _STEADY * np.max(np.abs(force))
        is_isotonic = is_held and np.ptp(pressure) > _STEADY * np.max(pressure)
        is_moved = strain.size >= _MIN_READINGS and np.ptp(strain) > 0
        if is_isotonic and is_moved and np.corrcoef(strain, pressure)[0, 1] < -_RISING:
            rule = "the muscle lengthens as its pressure rises, which none does under one load"
        is_unknown = column.role != "strain" and column.sign > 0
        if is_unknown and np.any(is_longer) and np.max(strain) < -_STRETCHED:
            rule = rule or f"all {column.role}s stretch the muscle"
        if rule:
            ways = ["extension", "contraction"][:: column.sign]
            verb = "lengthens" if column.sign > 0 else "shortens"
            choice = ("signs", column.role, f"{ways[0]} positive", f", else {ways[1]}")
            rule += f": if the {column.role} grows as the muscle {verb},"
            raise self._ask(column, rule, choice)

    def check_pull(self) -> None:
        """Refuse a force that pushes where any muscle pulls, unless its direction is stated."""
        x, F = self._at_top()
        if self.info.signs.force is not None or not x.size or -F.min() <= max(2 * F.max(), 0.0):
            return
        at_rest = np.abs(x) < _AT_REST
        pushes_at_rest = np.any(at_rest) and np.max(F[at_rest]) < 0
        is_sweep = x.size >= _MIN_READINGS and np.ptp(x) > 0 < np.ptp(F) and np.mean(F) < 0
        if pushes_at_rest or (is_sweep and np.corrcoef(x, F)[0, 1] > _RISING):
            rule = "the muscle pushes where all muscles pull: if a pull is negative,"
            choice = ("signs", "force", "pushing positive", ", else pulling")
            raise self._ask(self.pull, rule, choice)

    def check_atmosphere(self) -> None:
        """Doubt a lowest pressure that may be the atmosphere; refuse one without a pull."""
        column, low, force = self.columns["pressure"], float(np.min(self.pressure)), self.force
        is_gauge = column.absolute or is_gauge_unit(column.unit)
        is_gauge = is_gauge or self.info.pressure_at_rest is not None
        if is_gauge or not (90e3 < low < 110e3 and np.max(self.pressure) > 1.5 * low):
            return
        lowest, at_rest = self.pressure < 1.05 * low, np.abs(self.strain) < _AT_REST
        pulls = force >= _STEADY * np.max(force)
        # without pressure a muscle neither contracts under its load nor pulls at rest; a mass that
        # hangs from it at rest shows nothing
        if np.any(lowest & pulls & (self.strain > _AT_REST)):
            return
        first, later = force[lowest & at_rest], force[~lowest & at_rest]
        if np.any(lowest & at_rest & pulls) and later.size and first.max() < later.max():
            return
        text = f"{low / 1e3:.4g} kPa"
        if first.size and np.max(np.abs(first)) < _STEADY * np.max(force):
            rule = f"at {text}, its lowest pressure, the muscle doesn't pull at rest: if that is"
            gauge = ("units", "pressure", f"{column.unit} (g)", ", if it is gauge")
            choices = (("atmosphere", "", text, ""), gauge)
            raise self._ask(column, f"{rule} the atmosphere,", *choices)
        self._warn("atmosphere", lowest=low)

    def read_censored(self) -> np.ndarray:
        """Flags of clipped forces: of a column, and with `clipped_at_zero` of exactly 0."""
        is_zero, clipped_at_zero = self.force == 0, self.info.clipped_at_zero
        censored = np.zeros(is_zero.size, dtype=bool)
        if "clipped" in self.columns:
            censored = self._meanings("clipped", _FLAGS, "0 or 1").astype(bool)
        censored = censored | (is_zero & bool(clipped_at_zero))
        count, zeros = int(np.count_nonzero(censored)), int(np.count_nonzero(is_zero))
        is_stated = "clipped" in self.columns or clipped_at_zero is not None
        if count:
            self._warn("clipped", count=count, readings=is_zero.size)
        elif zeros > 2 and not (is_stated or self._has_set_loads):
            self._warn("zero_forces", count=zeros)
        return censored

    def read_branch(self) -> np.ndarray:
        """Branch of each reading, unknown without a column."""
        if "branch" not in self.columns:
            return np.full(self.force.size, UNKNOWN, dtype=np.int8)
        values = self._meanings("branch", BRANCHES, "up or down").astype(np.int8)
        is_flag = is_flag_of_ways(self.cells["branch"])
        return np.where(values == UNKNOWN, np.int8(DOWN), values) if is_flag else values

    def _meanings(self, role: str, meanings: Mapping[str, int], rule: str) -> np.ndarray:
        """Meaning of the text in each cell of a column; the error for an unknown one: `rule`."""
        texts = self.cells[role]
        values = [meanings.get(text) for text in texts]
        if None in values:
            row = values.index(None)
            rule = f"{texts.iloc[row]!r} isn't known: write {rule}."
            raise self.cell_error(row, self.columns[role], rule)
        return np.array(values)

    def read_time(self) -> np.ndarray | None:
        """Time [s], of a column or of LabVIEW's step, or `None`."""
        if "time" not in self.columns:
            return self._sampled_time()
        time = self.si("time")
        steps = np.diff(time)
        # counted in s they would be dates in 5000 years, or steps below 0.1 ms
        units = {unit: 1 / per_s for unit, per_s in _PER_SECOND if time[0] > _DATE * per_s}
        if _DAYS[0] < time[0] < _DAYS[1] and time.size > 1 and np.median(np.abs(steps)) < 1e-4:
            units = {"days": 86_400.0}
        if units and self.columns["time"].unit == "s":
            unit = next(iter(units))
            time = (time - time[0]) * units[unit]
            self._warn("time_is_date", unit=unit)
        back = np.flatnonzero(steps < 0)
        if back.size:
            self._warn("time_goes_back", line=int(self.cells.index[back[0] + 1]))
        return time

    def _sampled_time(self) -> np.ndarray | None:
        """Time [s] from the start and the step that LabVIEW writes instead of a column."""
        table = self.table
        entries = {title.split()[0]: title.split()[1:] for title in table.titles if title.strip()}
        used = {column.index for column in self.columns.values()}
        starts, steps = (
            {cell.replace(",", ".") for i, cell in enumerate(entries.get(key, []), 1) if i in used}
            for key in ("X0", "Delta_X")
        )
        if set(entries.get("X_Dimension", ["Time"])) != {"Time"} or not starts or not steps:
            return None
        if len(steps) > 1:
            rule = "the channels have several Delta_X: resample them to one rate"
            raise ValueError(f"{table.where}: {rule}.")
        if len(starts) > 1 or any("End_of_Header" in line for line in table.body):
            return None
        try:
            start, step = float(starts.pop()), float(steps.pop())
        except ValueError:
            return None
        self.findings.append(note("sampled_time", step=step))
        return start + step * (self.cells.index.to_numpy() - table.first)


def _reading_text(value: float, column: Column) -> str:
    return f"{value:.6g} {column.unit}".rstrip()


def _suggest_unit(column: Column, worst: float, excess: float = 0.0) -> str:
    """End of an error: a unit in which `worst` makes sense; `excess`: of a force, as factor."""
    for unit in _SUGGESTIONS.get(column.role, ()):
        factor = unit_factor(unit, column.role)
        if column.role == "pressure" and not 10e3 <= worst * factor <= HIGHEST_PRESSURE:
            continue
        if column.role == "force" and factor > column.factor / excess:
            continue
        if factor != column.factor:
            return f": did you mean {unit}?"
    return f": check its unit{' and the moment arm' if column.role == 'torque' else ''}."


def _is_strain(values: np.ndarray) -> bool:
    return bool(np.all((STRAINS[0] <= values) & (values <= STRAINS[1])))

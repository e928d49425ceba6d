"""Units of a table's columns: spellings of instruments, and checks of the numbers against them.

`fascicle.units` reads quantities strictly, since a person types them. A header comes from an
instrument, so `PSI`, `bar(g)`, `pct`, `Newtons` and `µm` are understood here as well. An absolute
pressure is refused.

Pressures in kPa under `pressure [Pa]` can be parsed, but a fit would give a muscle a thousand times
too strong. So readings must lie in the range of muscles: gauge pressures up to 1 MPa, contractions
from −0.2 to 0.9, and a force that a muscle's cross section can bear.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..core.validation import HIGHEST_PRESSURE
from ..units import DIMENSIONS, parse


POSITIONS = ("strain", "length", "displacement", "angle")  # the first in a table is read
USUAL_UNITS = {
    "pressure": "kPa", "force": "N", "length": "mm", "displacement": "mm", "time": "s",
    "torque": "N*m", "angle": "deg", "moment_arm": "mm",
}  # fmt: skip
STRAINS = (-0.2, 0.9)  # a muscle stretched by a fifth has straight fibers
_MIN_PRESSURE = 2e3  # Pa: a record that stays below, but pulls, is in another unit
_MAX_AREA = 0.05  # m²: the largest muscles reach 6 kN at 0.6 MPa, a fifth of it
_NOISE = (0.02, 5e3)  # of the highest pressure, and Pa: a transducer's zero may be off by that
_MIN_FORCE = 1.0  # N: less is too little to infer a unit from
_TIME = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "min": 60.0, "h": 3600.0}
_DIMENSIONLESS = {"", "-", "1", "mm/mm", "m/m", "in/in", "fraction", "ratio", "dimensionless"}
_SMALL_STRAINS = {
    **dict.fromkeys(("mm/m", "‰", "permille"), 1e-3),
    **dict.fromkeys(("µε", "με", "µstrain", "microstrain", "µm/m"), 1e-6),
}  # fmt: skip
# other spellings, in lower case, of the units that `fascicle.units` or `_TIME` know
SPELLINGS = {
    "pressure": {
        "pa": "Pa", "pascal": "Pa", "pascals": "Pa", "hpa": "hPa", "kpa": "kPa",
        "kilopascal": "kPa", "mpa": "MPa", "bar": "bar", "bars": "bar", "mbar": "mbar",
        "psi": "psi", "lbf/in2": "psi", "lbf/in²": "psi", "lb/in2": "psi", "lb/in²": "psi",
        "atm": "atm", "n/mm2": "MPa", "n/mm²": "MPa",
        "n/mm^2": "MPa", "n/m2": "Pa", "n/m²": "Pa", "n/m^2": "Pa", "barü": "bar", "bar(ü)": "bar",
        "kgf/cm2": "kgf/cm^2", "kgf/cm²": "kgf/cm^2", "kg/cm2": "kgf/cm^2", "kg/cm²": "kgf/cm^2",
        "mmhg": "mmHg", "torr": "torr", "inhg": "inHg",
    },
    "force": {
        "n": "N", "newton": "N", "newtons": "N", "kn": "kN", "lbf": "lbf", "lb": "lbf",
        "lbs": "lbf", "pounds": "lbf", "kgf": "kgf", "kp": "kgf", "gf": "gf", "dan": "daN",
        "cn": "cN", "ozf": "ozf", "pound": "lbf", "lb-f": "lbf", "pound-force": "lbf",
        "kg-f": "kgf", "kilogram-force": "kgf", "gram-force": "gf", "grams-force": "gf",
    },
    "length": {
        "m": "m", "meter": "m", "meters": "m", "metre": "m", "metres": "m", "mm": "mm",
        "millimeter": "mm", "millimeters": "mm", "millimetres": "mm", "cm": "cm", "um": "µm",
        "μm": "µm", "in": "in", "inch": "in", "inches": "in", '"': "in", "ft": "ft",
    },
    "angle": {
        "deg": "deg", "°": "deg", "degree": "deg", "degrees": "deg", "rad": "rad",
        "radian": "rad", "radians": "rad", "mrad": "mrad",
    },
    "moment": {
        "nm": "N*m", "n*m": "N*m", "mnm": "mN*m", "mn*m": "mN*m", "knm": "kN*m", "kn*m": "kN*m",
        "nmm": "N*mm", "n*mm": "N*mm", "ncm": "N*cm", "n*cm": "N*cm", "kgf*m": "kgf*m",
        "kgf*cm": "kgf*cm", "kg*cm": "kgf*cm", "lbf*ft": "lbf*ft", "lb*ft": "lbf*ft",
        "ft*lb": "lbf*ft", "ft*lbf": "lbf*ft", "lbf*in": "lbf*in", "lb*in": "lbf*in",
        "in*lb": "lbf*in", "in*lbf": "lbf*in", "ozf*in": "ozf*in", "oz*in": "ozf*in",
    },
    "strain": {"%": "%", "percent": "%", "pct": "%", "prozent": "%"},
    "time": {
        "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s", "ms": "ms",
        "millis": "ms", "msec": "ms", "milliseconds": "ms", "us": "µs", "μs": "µs", "min": "min",
        "minutes": "min", "h": "h", "hours": "h",
    },
}  # fmt: skip
_GAUGE = re.compile(
    r"(?:\s*\((?:g(?:auge)?|rel\.?|ü)\)|[\s_]+(?:g(?:auge)?|rel\.?|ü)|(?<=[a-z])g)$", re.IGNORECASE
)
_ABSOLUTE = re.compile(r"^(psi|m?bar|[hkm]?pa)[\s_(]*(?:a\)?|abs\.?\)?|absolute\)?)$")
# of masses that hang from a muscle, the unit of their weight
_WEIGHTS = {
    **dict.fromkeys(("g", "gram", "grams", "gramm", "gr"), "gf"),
    **dict.fromkeys(("oz", "ounce", "ounces"), "ozf"),
    **dict.fromkeys(
        ("kg", "kgs", "kilo", "kilos", "kilogram", "kilograms", "kilogramm"), "kgf"
    ),
}  # fmt: skip
# units to suggest where a column's unit makes no sense, the likeliest first
_SUGGESTIONS = {"pressure": ("kPa", "bar", "psi", "Pa", "MPa"), "force": ("N", "lbf", "kN")}


@dataclass(frozen=True)
class Column:
    """A column to read.

    - `role`: its quantity, such as "pressure".
    - `index`: its position in the header; `header`: its name there.
    - `unit`: as written; `factor`: SI units in it.
    - `sign`: −1 if the file counts the other way.
    - `replaced_unit`: the header's unit, if the caller gave another one.
    - `absolute`: true for pressures that count from vacuum.
    """

    role: str
    index: int
    header: str
    unit: str = ""
    factor: float = 1.0
    sign: int = 1
    replaced_unit: str = ""
    absolute: bool = False

    def note(self) -> str:
        """Description of how the column is read."""
        has_unit = self.role in {*POSITIONS, *USUAL_UNITS}
        unit = f" in {self.unit or 'fractions'}" if has_unit else ""
        role = self.role.replace("_", " ")
        replaced = f" as given, not in {self.replaced_unit}" if self.replaced_unit else ""
        sign = ", its sign turned" if self.sign < 0 else ""
        absolute = ", less the atmosphere" if self.absolute else ""
        return f"column `{self.header}` read as {role}{unit}{replaced}{sign}{absolute}"


CellError = Callable[[int, Column, str], ValueError]  # row, its column, the rule


def weight_unit(unit: str, dimension: str) -> str:
    """The unit of force for a column of masses, such as "kgf" for "kg"; empty for other units."""
    return _WEIGHTS.get(unit.strip().lower(), "") if dimension == "force" else ""


def is_absolute(unit: str) -> bool:
    """True for a unit of absolute pressure, such as "psia"."""
    return bool(absolute_unit(unit))


def absolute_unit(unit: str) -> str:
    """Plain unit of a unit of absolute pressure, such as "psi" of "psia"; empty for other units."""
    match = _ABSOLUTE.match(unit.strip().lower())
    return match[1] if match else ""


def is_gauge_unit(unit: str) -> bool:
    """True for a unit that says gauge pressure, such as "psig" or "barü"."""
    text = unit.strip().lower()
    return "ü" in text or (text not in SPELLINGS["pressure"] and bool(_GAUGE.search(text)))


def unit_factor(unit: str, dimension: str) -> float:
    """SI units in one `unit`, as a header writes it, without brackets.

    `dimension` is "pressure", "force", "length", "angle", "moment", "strain" or "time". Raises a
    `ValueError` of a few words for a unit that isn't of that dimension.
    """
    text = unit.strip().rstrip(".")  # `in.`
    if dimension == "moment":
        text = re.sub(r"[\s·⋅•.*-]+", "*", text)
    if dimension == "pressure":
        if is_absolute(text):
            raise ValueError(f"{unit!r} is absolute")
        text = _GAUGE.sub("", text) if text.lower() not in SPELLINGS["pressure"] else text
    if dimension == "strain" and text.lower() in _DIMENSIONLESS:
        return 1.0
    if dimension == "strain" and text.lower() in _SMALL_STRAINS:
        return _SMALL_STRAINS[text.lower()]
    exact = DIMENSIONS[dimension].factors if dimension in DIMENSIONS else _TIME
    # the case counts where it can: mN and MN
    name = text if text in exact else SPELLINGS[dimension].get(text.lower(), "")
    if dimension == "time" and name:
        return _TIME[name]
    if not name and not (dimension == "force" and text == "mN"):
        raise ValueError(f"{unit!r} is no unit of {dimension}")
    return parse(f"1 {name or text}", dimension)


def is_unit(text: str, dimensions: tuple[str, ...] = tuple(SPELLINGS)) -> bool:
    """True if `text`, in brackets or not, is a unit of one of the `dimensions`."""
    for dimension in dimensions:
        try:
            unit_factor(strip_brackets(text), dimension)
        except ValueError:
            continue
        return True
    return False


def strip_brackets(text: str) -> str:
    """Remove the brackets around a unit, and the "in" of `Force (in N)`."""
    text = text.strip()
    pairs = ("[]", "()", "{}", "<>")
    text = text[1:-1].strip() if len(text) > 1 and text[0] + text[-1] in pairs else text
    return re.sub(r"^in\s+(?=\S)", "", text)


def to_si_units(values: np.ndarray, factor: float) -> np.ndarray:
    """Multiply `values` by the `factor` of their unit, with a single rounding where possible.

    A thousandth has no float, but a division by a thousand rounds only once: 9 mm are the float
    9e-3, and nine times a thousandth is not.
    """
    divisor = round(1 / factor)
    if factor < 1 and divisor > 1 and 1 / divisor == factor:
        return values / divisor
    return values * factor if factor != 1 else values


def check_pressures(
    column: Column, raw: np.ndarray, force: np.ndarray, zero: float, cell_error: CellError
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Gauge pressures [Pa]: raw readings less the transducer's `zero` [Pa], checked; and notes.

    Noise below zero is set to zero. Raises what `cell_error` returns for pressures below zero, and
    for a unit that can't be right: pressures too high, or too low for the `force` [N].
    """
    pressure = to_si_units(raw, column.factor) - zero
    row, lowest = int(np.argmax(pressure)), int(np.argmin(pressure))
    top, strongest = float(pressure[row]), float(np.max(np.abs(force)))
    highest, rule = _reading_text(raw[row], column), ""
    if top > HIGHEST_PRESSURE:
        rule = f"{highest} is above {HIGHEST_PRESSURE / 1e6:g} MPa, more than muscles bear"
    elif 0 < top <= _MIN_PRESSURE and strongest > _MIN_FORCE:
        rule = f"the highest is {highest}, with forces up to {strongest:.3g} N"
    if rule:
        raise cell_error(row, column, f"{rule}{_suggest_unit(column, raw[row])}")
    if pressure[lowest] < -min(_NOISE[0] * max(top, 0.0), _NOISE[1]):
        rule = f"{_reading_text(raw[lowest], column)} is below zero by more than noise:"
        remedy = "give the transducer's reading at zero as pressure_at_rest (--zero pressure=…)."
        raise cell_error(lowest, column, f"{rule} {remedy}")
    notes = []
    below = int(np.count_nonzero(pressure < 0))
    if below:
        notes.append(f"{below} pressures below zero, down to {pressure[lowest]:.3g} Pa, set to 0")
    is_gauge = column.absolute or is_gauge_unit(column.unit)
    if not is_gauge and 90e3 < pressure[lowest] < 110e3 and top > 1.5 * pressure[lowest]:
        atmosphere = f"the lowest pressure is {pressure[lowest] / 1e3:.4g} kPa"
        notes.append(f"{atmosphere}: if that is the atmosphere, subtract it")
    return np.maximum(pressure, 0.0), tuple(notes)


def check_forces(
    column: Column, raw: np.ndarray, force: np.ndarray, top: float, cell_error: CellError
) -> tuple[str, ...]:
    """Refuse a `force` [N] that needs too large an area at the pressure `top` [Pa]; notes."""
    row = int(np.argmax(np.abs(force)))
    area = abs(float(force[row])) / top if top > _MIN_PRESSURE else 0.0
    if area > _MAX_AREA:
        rule = f"{_reading_text(raw[row], column)} at no more than {top / 1e3:.4g} kPa"
        suggestion = _suggest_unit(column, raw[row], area / _MAX_AREA)
        message = f"{rule} needs {area:.2g} m² of cross section{suggestion}"
        raise cell_error(row, column, message)
    if np.max(force) <= 0 < -np.min(force):
        return (
            "no reading pulls: if they do, turn the sign with --push-positive, or with"
            ' signs.force = "pushing positive"',
        )
    return ()


def check_strains(
    column: Column, raw: np.ndarray, strain: np.ndarray, cell_error: CellError
) -> None:
    """Refuse contractions `strain` [-] that no muscle has, with the line of the worst reading."""
    low, high = STRAINS
    row = int(np.argmax(np.maximum(low - strain, strain - high)))
    if low <= strain[row] <= high:
        return
    if column.role == "strain":
        hint = f"it must lie from {low} to {high}, check its unit and sign (--sign strain=…)."
    else:
        side = "longer than at rest" if strain[row] < 0 else "shorter than at rest"
        arm = "moment arm, " if column.role == "angle" else ""
        hint = f"{abs(strain[row]):.3g} of it {side}: check rest length, {arm}unit and sign."
    reading = _reading_text(raw[row], column)
    raise cell_error(row, column, f"{reading} is a contraction of {strain[row]:.4g}: {hint}")


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

"""Quantities with units: text to SI float and back, lists and ranges.

Files and the command line convert here; the laws only see SI units. A number without its unit is
refused wherever a unit is due. The caller states the dimension.

Decimal text times an exact factor is a rational number, rounded to float64 once, so `"6.35 mm"` is
the float `6.35e-3` to the last bit and `"0:0.33:0.03"` holds the float `0.21`. pint has the exact
factors of all units; the table has those that fascicle writes itself, since pint takes half a
second to start.
"""

import datetime as dt
import functools
import math
import re
from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import Any, NamedTuple

from .core.errors import InvalidInputError


MAX_POINTS = 100_000  # of a list or range: a slip in a step must not fill the memory
_MAX_TEXT = 100  # longest quantity: long digits and exponents make huge fractions

_POUND = Fraction("0.45359237") * Fraction("9.80665")  # lbf in N, exact by definition
_INCH = Fraction("0.0254")  # m, exact by definition
_DEGREE = Fraction(math.pi) / 180  # rad, of the float π
_CELSIUS = Fraction("273.15")  # K at 0 °C, exact by definition


class Dimension(NamedTuple):
    """A kind of quantity, with the units to write it.

    - `article`: its name with an article; `example`: text of such a quantity.
    - `si`, `common`: SI unit, and the one in tables and messages.
    - `exact`: units that are tried in this order for text that must be read back bitwise.
    - `factors`: SI units in each unit that needs no pint.
    - `alternatives`: units that avoid exponents, in this order.
    """

    article: str
    example: str
    si: str
    common: str
    exact: tuple[str, ...]
    factors: Mapping[str, Fraction]
    alternatives: tuple[str, ...] = ()

    @property
    def unitless(self) -> bool:
        """True if a bare number is a quantity of this kind."""
        return "" in self.factors


_FACTORS: dict[str, Any] = {  # SI units in a unit
    "mm": "1e-3", "cm": "1e-2", "µm": "1e-6", "in": _INCH, "deg": _DEGREE, "mN": "1e-3",
    "kN": 1000, "lbf": _POUND, "mN/s": "1e-3", "kPa": 1000, "MPa": 10**6, "bar": 10**5,
    "mbar": 100, "psi": _POUND / _INCH**2, "1/bar": "1e-5", "1/kPa": "1e-3", "1/MPa": "1e-6",
    "1/psi": _INCH**2 / _POUND, "N*mm": "1e-3", "Nm": 1, "Nmm": "1e-3", "mNm": "1e-3",
    "kNm": 1000, "mJ": "1e-3", "kJ": 1000, "ms": "1e-3", "min": 60, "N/mm": 1000, "kN/mm": 10**6,
    "mm^3": "1e-9", "cm^3": "1e-6", "L": "1e-3", "g": "1e-3", "g/m": "1e-3", "mm^2": "1e-6",
    "cm^2": "1e-4", "kHz": 1000, "rpm": Fraction(1, 60), "mm/s": "1e-3", "kg*cm^2": "1e-4",
    "N/kPa": "1e-3", "mW/K": "1e-3", "L/(s*bar)": "1e-8", "L/min": Fraction(1, 60_000),
    "N*s/(m*kPa)": "1e-3", "mL/min": Fraction(1, 60_000_000), "mm^3/kPa": "1e-12",
    "mm/kN": "1e-6", "mPa*s": "1e-3", "%": "1e-2",
}  # fmt: skip


def _dimension(
    article: str, example: str, exact: str, alternatives: str = "", others: str = ""
) -> Dimension:
    """Dimension with lists of units between blanks: of the `exact` ones the last is the SI unit,
    and the first the common one.
    """
    units, choices = exact.split(" "), tuple(alternatives.split())
    factors = {units[-1]: Fraction(1)}
    for unit in (*units[:-1], *choices, *others.split()):
        factors.setdefault(unit, Fraction(_FACTORS.get(unit, 1)))
    table = MappingProxyType(factors)
    return Dimension(article, example, units[-1], units[0], tuple(units), table, choices)


# pint takes the m of Nm for a prefix, and a turn for 2π
DIMENSIONS: Mapping[str, Dimension] = MappingProxyType({
    "length": _dimension("a length", "127 mm", "mm m", "m µm", "cm in"),
    "angle": _dimension("an angle", "33 deg", "deg rad"),
    "force": _dimension("a force", "20 N", "N", "kN mN", "lbf"),
    "force_rate": _dimension("a change of force with time", "0.01 N/s", "N/s", "mN/s"),
    "pressure": _dimension("a pressure", "34.5 kPa", "kPa Pa", "MPa Pa", "bar mbar psi"),
    "inverse_pressure": _dimension("an inverse pressure", "0.92 1/bar", "1/bar 1/Pa",
                                   "1/kPa 1/MPa", "1/psi"),
    "moment": _dimension("a moment", "0.03 N*m", "N*m", "N*mm", "Nm Nmm mNm kNm"),
    "energy": _dimension("an energy", "1.5 J", "J", "kJ mJ"),
    "time": _dimension("a time", "0.2 s", "s", "ms", "min"),
    "stiffness": _dimension("a stiffness", "5 N/mm", "N/mm N/m", "kN/mm N/m"),
    "volume": _dimension("a volume", "12 cm^3", "m^3", "cm^3 m^3", "mm^3 L")._replace(
        common="mm^3"),
    "mass": _dimension("a mass", "58 g", "g kg", "g")._replace(common="kg"),
    "linear_density": _dimension("a mass per length", "94 g/m", "g/m kg/m", "kg/m"),
    "density": _dimension("a density", "1100 kg/m^3", "kg/m^3"),
    "area": _dimension("an area", "1 mm^2", "mm^2 m^2", "cm^2"),
    "temperature": _dimension("a temperature", "293 K", "K"),
    "frequency": _dimension("a frequency", "0.5 Hz", "Hz", "", "kHz rpm"),
    "acceleration": _dimension("an acceleration", "9.81 m/s^2", "m/s^2"),
    "velocity": _dimension("a velocity", "1 mm/s", "mm/s m/s"),
    "damping": _dimension("a damping", "50 N*s/m", "N*s/m"),
    "angular_damping": _dimension("a damping of a turn", "0.1 N*m*s/rad", "N*m*s/rad"),
    "angular_stiffness": _dimension("a stiffness of a turn", "20 N*m/rad", "N*m/rad"),
    "inertia_moment": _dimension("a moment of inertia", "0.01 kg*m^2", "kg*m^2", "kg*cm^2"),
    "slip": _dimension("a force per pressure", "0.02 N/kPa", "N/kPa N/Pa"),
    "damping_slope": _dimension("a damping per pressure", "0.1 N*s/(m*kPa)",
                                "N*s/(m*kPa) N*s/(m*Pa)"),
    "wall_conductance": _dimension("a conductance of heat", "0.2 W/K", "W/K", "mW/K"),
    "sonic_conductance": _dimension("a sonic conductance", "0.1 L/(s*bar)",
                                    "L/(s*bar) m^3/(s*Pa)"),
    "volume_flow": _dimension("a flow", "100 L/min", "L/min m^3/s", "mL/min m^3/s"),
    "compliance": _dimension("a volume per pressure", "1e-12 m^3/Pa", "mm^3/kPa m^3/Pa"),
    "axial_compliance": _dimension("a length per force", "20 mm/kN", "mm/kN m/N"),
    "viscosity": _dimension("a viscosity", "39 mPa*s", "mPa*s Pa*s"),
    "strain": _dimension("a strain", "0.12", "", "", "%"),
    "number": _dimension("a number", "1.25", "", "", "%"),
})  # fmt: skip

_MIX_UPS = {  # by dimension and that of the unit which was written: what to do
    ("force", "mass"): 'it is a mass: write "kgf" for its weight (1 kgf = 9.80665 N), or newtons',
    ("sonic_conductance", "volume_flow"): "it is a flow: in a scenario write nominal_flow, Kv or Cv"
    " instead; in Python convert it by fluid.conductance_from_nominal_flow or …_from_kv",
}

_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)(?![a-z]))\s*(.*?)\s*",
    re.IGNORECASE | re.ASCII | re.DOTALL,
)
# what pint may get: names with one-digit powers, joined by * and /; never an expression
_NAME = r"[^\W\d]+(?:\^-?[1-9])?"
_UNIT = re.compile(rf"(?:1/)?{_NAME}(?:[*/](?:{_NAME}|\({_NAME}(?:\*{_NAME})*\)))*")
_SPELLINGS = str.maketrans({"μ": "µ", "·": "*", "²": "^2", "³": "^3", "°": "deg"})


def parse(text: Any, dimension: str, name: str | None = None) -> float:
    """Value [SI] of one quantity, rounded once: a number and its unit, such as `"34.5kPa"`; for a
    strain or a number also a bare number or `"12 %"`. `dimension`: a key of `DIMENSIONS`; `name`:
    of the quantity in errors. `ValueError`, one line, for other texts.
    """
    return float(_exact(text, dimension, name or dimension))


def quantity_example(dimension: str) -> str:
    """An example of a quantity of a `dimension` as a file has it."""
    kind = DIMENSIONS[dimension]
    return kind.example if kind.unitless else f'"{kind.example}"'


def parse_list(text: str, dimension: str, name: str | None = None) -> list[float]:
    """Values [SI] of a list `a,b,c`, a range `start:stop:step`, or a list of both, each with its
    unit. A range holds both its ends. If the step doesn't divide it, the last step is shorter. A
    falling range takes a negative step. Other arguments and errors as of `parse`; at most
    `MAX_POINTS` values.
    """
    name, values = name or dimension, []
    if not text.strip():
        remedy = f"give a value, such as {DIMENSIONS[dimension].example}"
        raise InvalidInputError(name, "has nothing but an empty entry", text, remedy, shown="")
    for entry in text.split(","):
        if not entry.strip():
            rule = f"has an empty entry in {_quote(text)}"
            raise InvalidInputError(name, rule, text, "drop the comma", shown="")
        if ":" in entry:
            values += _expand_range(entry, dimension, name)
        else:
            values.append(parse(entry, dimension, name))
        if len(values) > MAX_POINTS:
            raise _too_many(text, name)
    return values


# dimensions by SI unit
_BY_UNIT = {kind.si or "-": name for name, kind in DIMENSIONS.items()}
_NUMBERS = frozenset({float, int})


def to_si(value: Any, name: str, unit: str) -> Any:
    """Convert a value with units, text such as `"34.5 kPa"`, a pint quantity, or lists and arrays
    of them, to numbers in the SI `unit`, "-" of pure numbers; other values are returned as they
    are. `name`: of the argument in errors.
    """
    if isinstance(value, float | int):
        return value
    dimension = dimension_of_unit(unit)
    return _convert(value, name, dimension) if dimension and has_units(value) else value


def dimension_of_unit(unit: str) -> str | None:
    """Dimension of a quantity in an SI `unit`, "number" of "-"; `None` for another unit."""
    return _BY_UNIT.get(unit.translate(_SPELLINGS))


def has_units(value: Any) -> bool:
    """True for text or a pint quantity, and for lists and arrays of them."""
    import numpy as np  # not at the top: the command line's help needs none

    if isinstance(value, list | tuple):
        # types first: a long list of numbers takes no time
        return not {type(entry) for entry in value} <= _NUMBERS and any(map(has_units, value))
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "UO" and any(map(has_units, value.flat))
    return isinstance(value, str) or hasattr(value, "m_as")


def _convert(value: Any, name: str, dimension: str) -> Any:
    """Number [SI] of text or a pint quantity, and of lists and arrays of them."""
    import numpy as np

    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, str):
        return parse(value, dimension, name)
    if isinstance(value, list | tuple):
        return [_convert(entry, name, dimension) for entry in value]
    if not hasattr(value, "m_as"):
        return value
    kind = DIMENSIONS[dimension]
    try:
        return value.m_as(kind.si or "dimensionless")
    except (TypeError, ValueError, AttributeError):  # pint's own is a TypeError
        rule = f"must be {kind.article}, such as {quantity_example(dimension)}"
        raise InvalidInputError(name, rule, value, shown=f"{value}") from None


def exact(value: float, dimension: str) -> str:
    """Text of a finite `value` [SI] that `parse` reads as the same float, in a handy unit if it
    can: `"6.35 mm"`, or `"0.1234567890123456 m"`.
    """
    kind = DIMENSIONS[dimension]
    for unit in kind.exact:
        scaled = float(value) / float(kind.factors[unit])
        text = f"{scaled:.12g} {unit}".strip()
        # twelve digits of the largest floats could round up to infinity
        if abs(scaled) < 1e300 and parse(text, dimension) == value:
            return text
    return f"{float(value)!r} {kind.si}".strip()


def pretty(value: float, dimension: str, digits: int = 4) -> str:
    """Text of a `value` [SI] in its dimension's common unit, or another if that takes an exponent:
    `"34.5 kPa"`, `"10 m"` rather than `"1e+04 mm"`; with significant `digits`; "-" for infinity
    and NaN.
    """
    kind = DIMENSIONS[dimension]
    if not math.isfinite(value):
        return "-"
    units = (kind.common, *kind.alternatives)
    scaled = {unit: float(value) / float(kind.factors[unit]) for unit in units}
    plain = (unit for unit, x in scaled.items() if "e" not in f"{x:.{digits}g}")
    nearest = min(units, key=lambda unit: abs(math.log10(abs(scaled[unit]) or 1.0)))
    unit = next(plain, nearest)
    return f"{format_digits(scaled[unit], digits)} {unit}".strip()


def format_digits(value: float, digits: int = 4) -> str:
    """Text of a number with significant `digits`: `"12300"` rather than `"1.23e+04"`; exponents
    only from ten million on, and below 0.0001.
    """
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text and 1 <= abs(value) < 1e7 else text


def _exact(text: Any, dimension: str, name: str) -> Fraction | float:
    """Value [SI] that `parse` rounds: a fraction, or a float for zero and degrees."""
    kind = DIMENSIONS[dimension]

    def invalid(value: str, remedy: str = "") -> InvalidInputError:
        rule = f'must be {kind.article}, such as "{kind.example}"'
        return InvalidInputError(name, rule, text, remedy, shown=value)

    if isinstance(text, int | float) and not isinstance(text, bool) and kind.unitless:
        text = repr(text)
    if isinstance(text, int | float) and not isinstance(text, bool):
        raise invalid(f"the bare number {text!r}", "write it with its unit")
    if not isinstance(text, str):
        raise invalid(_quote(text))
    match = _QUANTITY.fullmatch(text)
    if match is None or len(text) > _MAX_TEXT:
        raise invalid(_quote(text), "start with a number")
    number, unit = match[1], match[2].translate(_SPELLINGS)
    if not math.isfinite(float(number)):
        raise invalid(_quote(text), "it must be finite")
    if unit.startswith(","):
        raise invalid(_quote(text), "write the decimals after a point")
    if not unit and not kind.unitless:
        raise invalid(f"the bare number {number}", "write it with its unit")
    unit = re.sub(r"\s*([*/^()])\s*", r"\1", unit.replace("**", "^"))
    unit = re.sub(r"^/", "1/", re.sub(r"\s+", "*", unit))
    if dimension == "temperature" and unit.removeprefix("deg") == "C":
        return Fraction(number) + _CELSIUS
    factor = kind.factors.get(unit) or _pint_factor(unit, kind.si)
    same = [known for known in kind.factors if known.casefold() == unit.casefold()]
    if unit not in kind.factors and same:  # 0.3 mPa is a slip for MPa
        raise invalid(_quote(text), f"did you mean {same[0]!r}?")
    if factor is None:
        others = (
            (other, text) for (target, other), text in _MIX_UPS.items() if target == dimension
        )
        remedies = [text for other, text in others if _pint_factor(unit, DIMENSIONS[other].si)]
        remedies += [
            f"{_quote(unit)} is per length: multiply it {power} by the length, in m, of the muscle"
            " that its source measured"
            for power, meters in (("once", "m"), ("twice", "m^2"), ("three times", "m^3"))
            if _pint_factor(f"{unit}*{meters}", kind.si)
        ]
        quantity = kind.article.split(" ", 1)[1]
        raise invalid(_quote(text), [*remedies, f"{_quote(unit)} is no unit of {quantity}"][0])
    # zero keeps its sign; and its exponent, which may be any, would make a huge fraction
    value = Fraction(number) * factor if float(number) else float(number)
    if dimension == "angle" and unit == "deg":
        value = math.radians(float(number))  # as other code computes it, to the last bit
    try:
        float(value)
    except OverflowError:
        raise invalid(_quote(text), "it must be finite") from None
    return value


def _pint_factor(unit: str, si: str) -> Fraction | None:
    """SI units in a unit that pint knows; `None` for others, and for scales with another zero."""
    if not _UNIT.fullmatch(unit):
        return None
    registry = _registry()
    try:
        pint_unit = registry.parse_units(unit.replace("^", "**"))
        zero, one = (
            registry.Quantity(Fraction(number), pint_unit).to(si.replace("^", "**")).magnitude
            for number in (0, 1)
        )
    except Exception:  # noqa: BLE001 pint evaluates the user's text, and raises many kinds
        return None
    return None if zero else Fraction(one)


@functools.cache
def _registry() -> Any:
    import pint  # half a second, and rarely needed

    registry: Any = pint.UnitRegistry
    return registry(non_int_type=Fraction)  # the hints of pint have floats alone


def _expand_range(text: str, dimension: str, name: str) -> list[float]:
    """Numbers [SI] of `start:stop:step`, of which `stop` is always the last."""

    def invalid(remedy: str) -> InvalidInputError:
        return InvalidInputError(name, f"has the range {_quote(text)}", text, remedy, shown="")

    entries = text.split(":")
    if len(entries) != 3:
        raise invalid("write start:stop:step")
    start, stop, step = (Fraction(_exact(entry, dimension, name)) for entry in entries)
    if step == 0:
        raise invalid("its step must not be 0")
    if (stop - start) * step < 0:
        raise invalid("its step leads away")
    count = (stop - start) / step
    if count > MAX_POINTS:
        raise _too_many(text, name)
    # degrees and pint's units are floats already: a step divides the range up to rounding
    divides = abs(count - round(count)) < Fraction(1, 10**9)
    inner = round(count) if divides else math.floor(count) + 1
    return [float(start + i * step) for i in range(inner)] + [float(stop)]


def _too_many(text: str, name: str) -> ValueError:
    """Error, for the caller to raise, of more than `MAX_POINTS` values."""
    rule = f"has more than {MAX_POINTS} values in {_quote(text)}"
    return InvalidInputError(name, rule, text, "take fewer", shown="")


def _quote(value: Any) -> str:
    """Text of a value, shortened to 60 characters."""
    if isinstance(value, list):
        text = f"[{', '.join(map(_quote, value))}]"
    else:  # dates as TOML has them
        text = str(value) if isinstance(value, dt.date | dt.time) else repr(value)
    return text if len(text) <= 60 else f"{text[:40]}…{text[-1]}"

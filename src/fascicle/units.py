"""Quantities with units: text to SI float and back, lists and ranges.

Files and the command line convert here; the laws only see SI units. A number without its unit is
refused wherever a unit is due.

Common units have exact SI factors. Decimal text times such a factor is a rational number, rounded
to float64 once, so `"6.35 mm"` is the float `6.35e-3` to the last bit and `"0:0.33:0.03"` holds the
float `0.21`. Other units go to pint, which is imported only then.
"""

import difflib
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


class Dimension(NamedTuple):
    """A kind of quantity, with the units to read and to write it."""

    article: str
    si: str
    common: str  # unit in tables and messages
    exact: tuple[str, ...]  # tried in this order for text that must be read back bitwise
    factors: Mapping[str, Fraction]
    alternatives: tuple[str, ...] = ()  # to avoid exponents, in this order

    @property
    def unitless(self) -> bool:
        """True if a bare number is a quantity of this kind."""
        return "" in self.factors


def _units(**factors: Any) -> Mapping[str, Fraction]:
    return MappingProxyType({unit: Fraction(factor) for unit, factor in factors.items()})


_LENGTH = _units(**{"m": 1, "mm": "1e-3", "cm": "1e-2", "µm": "1e-6", "in": _INCH,
                    "inch": _INCH, "ft": 12 * _INCH})  # fmt: skip
_FORCE = _units(N=1, mN="1e-3", kN=1000, lbf=_POUND)
_PRESSURE = _units(Pa=1, hPa=100, kPa=1000, MPa=10**6, bar=10**5, mbar=100,
                   psi=_POUND / _INCH**2, atm=101325)  # fmt: skip
_INVERSE_PRESSURE = {f"1/{unit}": 1 / factor for unit, factor in _PRESSURE.items()}
_MOMENT = {f"{f}*{d}": _FORCE[f] * _LENGTH[d] for f in _FORCE for d in ("m", "mm", "in")}
_MOMENT |= {unit.replace("*", ""): _MOMENT[unit] for unit in ("N*m", "mN*m", "kN*m", "N*mm")}
_STIFFNESS = {f"{f}/{d}": _FORCE[f] / _LENGTH[d] for f in _FORCE for d in _LENGTH}
_VOLUME = {f"{d}^3": factor**3 for d, factor in _LENGTH.items()}
_MASS = {"kg": Fraction(1), "g": Fraction("1e-3"), "lb": Fraction("0.45359237")}
_DENSITY = {"kg/m^3": Fraction(1), "g/cm^3": Fraction(1000)}
_TIME = {"s": Fraction(1), "ms": Fraction("1e-3"), "min": Fraction(60)}
_AREA = {f"{d}^2": factor**2 for d, factor in _LENGTH.items()}
_LITERS = {"m^3": 1, "dm^3": Fraction("1e-3"), "L": Fraction("1e-3"), "mL": Fraction("1e-6"),
           "cm^3": Fraction("1e-6"), "mm^3": Fraction("1e-9")}  # fmt: skip
_VOLUME_FLOW = {f"{v}/{t}": factor / seconds for v, factor in _LITERS.items()
                for t, seconds in {**_TIME, "h": Fraction(3600)}.items()}  # fmt: skip
_COMPLIANCE = {
    f"{v}/{p}": factor / _PRESSURE[p] for v, factor in _LITERS.items() for p in _PRESSURE
}
_SONIC = {f"{v}/({t}*{p})": factor / _TIME[t] / _PRESSURE[p]
          for v, factor in _LITERS.items() for t in _TIME for p in _PRESSURE}  # fmt: skip
_RELIEF_SLOPE = {f"{m}/({t}*{p})": _MASS[m] / _TIME[t] / _PRESSURE[p]
                 for m in _MASS for t in _TIME for p in _PRESSURE}  # fmt: skip
_AXIAL_COMPLIANCE = {f"{d}/{f}": _LENGTH[d] / _FORCE[f] for d in _LENGTH for f in _FORCE}
_SLIP = {f"{f}/{p}": _FORCE[f] / _PRESSURE[p] for f in _FORCE for p in _PRESSURE}
_INERTIA = {f"{m}*{d}^2": _MASS[m] * _LENGTH[d] ** 2 for m in _MASS for d in ("m", "cm", "mm")}
_KELVIN = {"K": Fraction(1), "degC": Fraction(1)}  # the latter counted from another zero
_CELSIUS = Fraction("273.15")  # K at 0 °C, exact by definition

DIMENSIONS: Mapping[str, Dimension] = MappingProxyType({
    "length": Dimension("a length", "m", "mm", ("mm", "m"), _LENGTH, ("m", "µm")),
    "angle": Dimension("an angle", "rad", "deg", ("deg", "rad"),
                       _units(rad=1, mrad="1e-3", deg=_DEGREE, degree=_DEGREE)),
    "force": Dimension("a force", "N", "N", ("N",), _FORCE, ("kN", "mN")),
    "force_rate": Dimension("a change of force with time", "N/s", "N/s", ("N/s",),
                            _units(**{"N/s": 1, "mN/s": "1e-3", "N/min": Fraction(1, 60),
                                      "N/h": Fraction(1, 3600)}), ("mN/s",)),
    "pressure": Dimension("a pressure", "Pa", "kPa", ("kPa", "Pa"), _PRESSURE,
                          ("MPa", "Pa")),
    "inverse_pressure": Dimension("an inverse pressure", "1/Pa", "1/bar",
                                  ("1/bar", "1/Pa"), _units(**_INVERSE_PRESSURE),
                                  ("1/kPa", "1/MPa")),
    "moment": Dimension("a moment", "N*m", "N*m", ("N*m",), _units(**_MOMENT), ("N*mm",)),
    "energy": Dimension("an energy", "J", "J", ("J",), _units(J=1, mJ="1e-3", kJ=1000),
                        ("kJ", "mJ")),
    "time": Dimension("a time", "s", "s", ("s",), _units(**_TIME), ("ms",)),
    "stiffness": Dimension("a stiffness", "N/m", "N/mm", ("N/mm", "N/m"), _units(**_STIFFNESS),
                           ("kN/mm", "N/m")),
    "volume": Dimension("a volume", "m^3", "mm^3", ("m^3",),
                        _units(**_VOLUME, L="1e-3", mL="1e-6"), ("cm^3", "m^3")),
    "mass": Dimension("a mass", "kg", "kg", ("g", "kg"), _units(**_MASS), ("g",)),
    "linear_density": Dimension("a mass per length", "kg/m", "g/m", ("g/m", "kg/m"),
                                _units(**{f"{m}/m": factor for m, factor in _MASS.items()}),
                                ("kg/m",)),
    "density": Dimension("a density", "kg/m^3", "kg/m^3", ("kg/m^3",), _units(**_DENSITY)),
    "area": Dimension("an area", "m^2", "mm^2", ("mm^2", "m^2"), _units(**_AREA), ("cm^2",)),
    "temperature": Dimension("a temperature", "K", "K", ("K",), _units(**_KELVIN)),
    "frequency": Dimension("a frequency", "Hz", "Hz", ("Hz",),
                           _units(**{"Hz": 1, "kHz": 1000, "1/s": 1, "1/min": Fraction(1, 60),
                                 "rpm": Fraction(1, 60)})),
    "acceleration": Dimension("an acceleration", "m/s^2", "m/s^2", ("m/s^2",),
                              _units(**{"m/s^2": 1})),
    "velocity": Dimension("a velocity", "m/s", "mm/s", ("mm/s", "m/s"),
                          _units(**{f"{d}/s": factor for d, factor in _LENGTH.items()})),
    "damping": Dimension("a damping", "N*s/m", "N*s/m", ("N*s/m",),
                         _units(**{"N*s/m": 1, "N*s/mm": 1000, "kg/s": 1})),
    "angular_damping": Dimension("a damping of a turn", "N*m*s/rad", "N*m*s/rad", ("N*m*s/rad",),
                                 _units(**{"N*m*s/rad": 1, "N*m*s": 1, "N*mm*s/rad": "1e-3"})),
    "angular_stiffness": Dimension("a stiffness of a turn", "N*m/rad", "N*m/rad", ("N*m/rad",),
                                   _units(**{"N*m/rad": 1, "N*m": 1, "N*mm/rad": "1e-3"})),
    "inertia_moment": Dimension("a moment of inertia", "kg*m^2", "kg*m^2", ("kg*m^2",),
                                _units(**_INERTIA), ("kg*cm^2",)),
    "slip": Dimension("a force per pressure", "N/Pa", "N/kPa", ("N/kPa", "N/Pa"),
                      _units(**_SLIP)),
    "wall_conductance": Dimension("a conductance of heat", "W/K", "W/K", ("W/K",),
                                  _units(**{"W/K": 1, "mW/K": "1e-3"}), ("mW/K",)),
    "sonic_conductance": Dimension("a sonic conductance", "m^3/(s*Pa)", "L/(s*bar)",
                                   ("L/(s*bar)", "m^3/(s*Pa)"), _units(**_SONIC)),
    "volume_flow": Dimension("a flow", "m^3/s", "L/min", ("L/min", "m^3/s"),
                             _units(**_VOLUME_FLOW), ("mL/min", "m^3/s")),
    "relief_slope": Dimension("a mass flow per pressure", "kg/(s*Pa)", "g/(s*bar)",
                              ("g/(s*bar)", "kg/(s*Pa)"), _units(**_RELIEF_SLOPE)),
    "compliance": Dimension("a volume per pressure", "m^3/Pa", "mm^3/kPa",
                            ("mm^3/kPa", "m^3/Pa"), _units(**_COMPLIANCE)),
    "axial_compliance": Dimension("a length per force", "m/N", "mm/kN", ("mm/kN", "m/N"),
                                  _units(**_AXIAL_COMPLIANCE)),
    "viscosity": Dimension("a viscosity", "Pa*s", "mPa*s", ("mPa*s", "Pa*s"),
                           _units(**{"Pa*s": 1, "mPa*s": "1e-3", "cP": "1e-3"})),
    "strain": Dimension("a strain", "", "", ("",), _units(**{"": 1, "%": "1e-2"})),
    "number": Dimension("a number", "", "", ("",), _units(**{"": 1, "%": "1e-2"})),
})  # fmt: skip

_EXAMPLES = {"length": "127 mm", "angle": "33 deg", "force": "20 N", "pressure": "34.5 kPa",
             "inverse_pressure": "0.92 1/bar", "moment": "0.03 N*m", "energy": "1.5 J",
             "time": "0.2 s", "stiffness": "5 N/mm", "volume": "12 cm^3", "mass": "58 g",
             "linear_density": "94 g/m", "density": "1100 kg/m^3", "area": "1 mm^2",
             "temperature": "293 K", "frequency": "0.5 Hz", "acceleration": "9.81 m/s^2",
             "velocity": "1 mm/s",
             "damping": "50 N*s/m", "angular_damping": "0.1 N*m*s/rad",
             "angular_stiffness": "20 N*m/rad", "inertia_moment": "0.01 kg*m^2",
             "slip": "0.02 N/kPa", "force_rate": "0.01 N/s", "wall_conductance": "0.2 W/K",
             "sonic_conductance": "0.1 L/(s*bar)", "compliance": "1e-12 m^3/Pa",
             "relief_slope": "100 g/(s*bar)", "volume_flow": "100 L/min",
             "axial_compliance": "20 mm/kN",
             "viscosity": "39 mPa*s", "strain": "0.12", "number": "1.25"}  # fmt: skip

_MIX_UPS = {  # by dimension and that of the unit which was written: what to do
    ("force", "mass"): 'it is a mass: write "kgf" for its weight (1 kgf = 9.80665 N), or newtons',
    ("sonic_conductance", "volume_flow"): "it is a flow: in a scenario write nominal_flow, Kv or Cv"
    " instead; in Python convert it by fluid.conductance_from_nominal_flow or …_from_kv",
}

_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)(?![a-z]))\s*(.*?)\s*",
    re.IGNORECASE | re.ASCII | re.DOTALL,
)
# units for pint: names with one-digit powers, joined by * and /; never an expression
_UNIT = re.compile(r"(?:1/)?[^\W\d]+(?:\^-?[1-9])?(?:[*/][^\W\d]+(?:\^-?[1-9])?)*")
_SPELLINGS = str.maketrans({"μ": "µ", "·": "*", "²": "^2", "³": "^3"})


def parse(text: Any, dimension: str, name: str | None = None) -> float:
    """Value [SI] of one quantity, rounded once: a number and its unit, such as `"34.5kPa"`; for a
    strain or a number also a bare number or `"12 %"`. `dimension`: a key of `DIMENSIONS`; `name`:
    of the quantity in errors. `ValueError`, one line, for other texts.
    """
    return float(_exact(text, dimension, name or dimension))


def quantity_example(dimension: str) -> str:
    """An example of a quantity of a `dimension` as a file has it."""
    text = _EXAMPLES[dimension]
    return text if DIMENSIONS[dimension].unitless else f'"{text}"'


def parse_list(text: str, dimension: str, name: str | None = None) -> list[float]:
    """Values [SI] of a list `a,b,c`, a range `start:stop:step`, or a list of both, each with its
    unit. A range holds both its ends. If the step doesn't divide it, the last step is shorter. A
    falling range takes a negative step. Other arguments and errors as of `parse`; at most
    `MAX_POINTS` values.
    """
    name, values = name or dimension, []
    if not text.strip():
        remedy = f"give a value, such as {_EXAMPLES[dimension]}"
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


# dimensions by SI unit, the first of several with one unit
_BY_UNIT = {kind.si: name for name, kind in reversed(list(DIMENSIONS.items())) if not kind.unitless}
_NUMBERS = frozenset({float, int})


def to_si(value: Any, name: str, unit: str) -> Any:
    """Convert a value with units, text such as `"34.5 kPa"`, a pint quantity, or lists and arrays
    of them, to numbers in the SI `unit` of bare numbers; other values are returned as they are.
    """
    if isinstance(value, float | int):
        return value
    dimension = "strain" if name == "strain" else _BY_UNIT.get(unit.translate(_SPELLINGS))
    if dimension is None or not has_units(value):
        return value
    return _convert(value, name, dimension)


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
    kind, example = DIMENSIONS[dimension], _EXAMPLES[dimension]

    def invalid(value: str, remedy: str = "") -> InvalidInputError:
        rule = f'must be {kind.article}, such as "{example}"'
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
    factor = _factor(unit, dimension)
    if isinstance(factor, str):
        raise invalid(_quote(text), _mix_up(unit, dimension) or factor.removesuffix("."))
    # zero keeps its sign; and its exponent, which may be any, would make a huge fraction
    value = Fraction(number) * factor if float(number) else float(number)
    if dimension == "temperature" and unit.strip("° ") in ("C", "degC"):
        value = Fraction(number) + _CELSIUS
    if dimension == "angle" and factor == _DEGREE:
        value = math.radians(float(number))  # as other code computes it, to the last bit
    try:
        float(value)
    except OverflowError:
        raise invalid(_quote(text), "it must be finite") from None
    return value


def _mix_up(unit: str, dimension: str) -> str:
    """Remedy for a unit of another dimension that is often meant for this one, or nothing."""
    remedies = (
        remedy
        for (target, source), remedy in _MIX_UPS.items()
        if dimension == target and unit in DIMENSIONS[source].factors
    )
    return next(remedies, "")


@functools.lru_cache(maxsize=256)
def _factor(unit: str, dimension: str) -> Fraction | str:
    """SI factor of `unit`, or a message if it has none."""
    kind = DIMENSIONS[dimension]
    name = re.sub(r"\s*([*/^])\s*", r"\1", unit.replace("**", "^").replace("°", "deg"))
    name = re.sub(r"\s+", "*", name).replace("1/*", "1/").removesuffix("^1")
    name = re.sub(r"^/", "1/", re.sub(r"^([^\W\d]+)\^-1$", r"1/\1", name))
    if name in kind.factors:
        return kind.factors[name]
    units = [candidate for candidate in kind.factors if candidate]
    # a unit that differs in case alone is meant, however similar another one may be
    equal = [candidate for candidate in units if candidate.casefold() == name.casefold()]
    similar = equal or difflib.get_close_matches(name, units, n=1, cutoff=0.5)
    hint = f", did you mean {similar[0]!r}?" if similar else "."
    message = f"unknown unit {_quote(unit)}{hint}"
    if not _UNIT.fullmatch(name):
        return message
    factor = _pint_factor(unit, name, dimension) or message
    if equal and isinstance(factor, str) and factor is not message:
        return f"{factor.removesuffix('.')}, did you mean {equal[0]!r}?"
    return factor


def _pint_factor(unit: str, name: str, dimension: str) -> Fraction | str:
    """SI factor of a unit from pint, or a message; empty for units that pint doesn't know."""
    from pint import PintError  # half a second, and rarely needed

    kind = DIMENSIONS[dimension]
    try:
        pint_unit = _registry().parse_units(name.replace("^", "**"))
        si = kind.si.replace("^", "**") or "dimensionless"
        if _registry().Quantity(0.0, pint_unit).to(si).magnitude:
            return ""  # counted from another zero, such as degrees Fahrenheit
        return Fraction(_registry().Quantity(1.0, pint_unit).to(si).magnitude)
    except PintError as error:
        if type(error).__name__ == "DimensionalityError":
            return f"{_quote(unit)} is no unit of {kind.article.split(' ', 1)[1]}."
        return ""
    except Exception:  # noqa: BLE001 pint evaluates the user's text, and raises many kinds
        return ""


@functools.cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


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
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:40]}…{text[-1]}"

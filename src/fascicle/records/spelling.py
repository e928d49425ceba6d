"""The units of a table's header, in the spellings that instruments and people write.

`units` reads a quantity strictly, since a person has just typed it. A header came out of an
instrument, so here `PSI`, `bar(g)`, `pct`, `Newtons` and `µm` are understood as well. What is
ambiguous stays refused: an absolute pressure is no gauge pressure.
"""

import functools
import re

import numpy as np

from ..units import DIMENSIONS, parse


_TIME = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "min": 60.0, "h": 3600.0}
_DIMENSIONLESS = {"", "-", "1", "mm/mm", "m/m", "in/in", "fraction", "ratio", "dimensionless"}
# other spellings, in lower case, of the units that `units` or the tables above know
_SPELLINGS = {
    "pressure": {
        "pa": "Pa", "pascal": "Pa", "pascals": "Pa", "hpa": "hPa", "kpa": "kPa",
        "kilopascal": "kPa", "mpa": "MPa", "bar": "bar", "bars": "bar", "mbar": "mbar",
        "psi": "psi", "lbf/in2": "psi", "atm": "atm", "n/mm2": "MPa", "n/mm²": "MPa",
        "n/mm^2": "MPa", "n/m2": "Pa", "n/m²": "Pa", "n/m^2": "Pa",
    },
    "force": {
        "n": "N", "newton": "N", "newtons": "N", "kn": "kN", "lbf": "lbf", "lb": "lbf",
        "lbs": "lbf", "pounds": "lbf", "kgf": "kgf", "gf": "gf",
    },
    "length": {
        "m": "m", "meter": "m", "meters": "m", "metre": "m", "metres": "m", "mm": "mm",
        "millimeter": "mm", "millimeters": "mm", "millimetres": "mm", "cm": "cm", "um": "µm",
        "μm": "µm", "in": "in", "inch": "in", "inches": "in", '"': "in", "ft": "ft",
    },
    "strain": {"%": "%", "percent": "%", "pct": "%", "prozent": "%", "mm/m": "mm/m"},
    "time": {
        "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s", "ms": "ms",
        "msec": "ms", "milliseconds": "ms", "us": "µs", "μs": "µs", "min": "min",
        "minutes": "min", "h": "h", "hours": "h",
    },
}  # fmt: skip
_GAUGE = re.compile(r"(?:\s*\(g\)|[\s_]+g(?:auge)?|(?<=[a-z])g)$", re.IGNORECASE)
_ABSOLUTE = re.compile(r"^(?:psi|m?bar|[hkm]?pa)[\s_(]*(?:a\)?|abs\.?\)?|absolute\)?)$")
# of masses that hang from a muscle, the unit of their weight
_WEIGHTS = {
    "g": "gf", "gram": "gf", "grams": "gf", "gramm": "gf", "gr": "gf", "kg": "kgf", "kgs": "kgf",
    "kilo": "kgf", "kilos": "kgf", "kilogram": "kgf", "kilograms": "kgf", "kilogramm": "kgf",
}  # fmt: skip
# what else a column in the wrong unit could have been in, the likeliest first
OTHERS = {"pressure": ("kPa", "bar", "psi", "Pa", "MPa"), "force": ("N", "lbf", "kN")}


def remedy_unit(unit: str, dimension: str) -> str:
    """The unit that is meant by one that isn't of its dimension; empty where numbers in it would
    have to be converted.

    **Arguments:** those of `factor` [-].

    **Returns:** the unit [-].
    """
    return _WEIGHTS.get(unit.strip().lower(), "") if dimension == "force" else ""


def is_absolute(unit: str) -> bool:
    """Whether a `unit` [-] is one of absolute pressures."""
    return _ABSOLUTE.match(unit.strip().lower()) is not None


@functools.lru_cache(maxsize=512)
def factor(unit: str, dimension: str) -> float:
    """How many SI units one `unit` is.

    **Arguments:**

    - `unit`: as a header writes it, without its brackets [-].
    - `dimension`: `"pressure"`, `"force"`, `"length"`, `"strain"` or `"time"` [-].

    **Returns:** the factor [-].

    **Raises:** `ValueError`, in a few words, for what is no such unit.
    """
    text = unit.strip()
    if dimension == "pressure":
        if is_absolute(text):
            raise ValueError(f"{unit!r} is absolute")
        text = _GAUGE.sub("", text) if text.lower() not in _SPELLINGS["pressure"] else text
    if dimension == "strain" and text.lower() in _DIMENSIONLESS:
        return 1.0
    if dimension == "strain" and text.lower() == "mm/m":
        return 1e-3
    exact = DIMENSIONS[dimension].factors if dimension in DIMENSIONS else _TIME
    # the case counts where it can: mN and MN
    name = text if text in exact else _SPELLINGS[dimension].get(text.lower(), "")
    if dimension == "time" and name:
        return _TIME[name]
    if not name and not (dimension == "force" and text == "mN"):
        raise ValueError(f"{unit!r} is no unit of {dimension}")
    return parse(f"1 {name or text}", dimension)


def is_unit(text: str, dimensions: tuple[str, ...] = tuple(_SPELLINGS)) -> bool:
    """Whether `text` [-], in brackets or not, is a unit of one of the `dimensions` [-]."""
    for dimension in dimensions:
        try:
            factor(bare(text), dimension)
        except ValueError:
            continue
        return True
    return False


def bare(text: str) -> str:
    """`text` [-] without the brackets around it."""
    text = text.strip()
    if len(text) > 1 and (text[0], text[-1]) in {("[", "]"), ("(", ")"), ("{", "}"), ("<", ">")}:
        return text[1:-1].strip()
    return text


def scaled(values: np.ndarray, by: float) -> np.ndarray:
    """`values` [-] times the factor `by` [-], rounded once where that can be.

    A thousandth has no float, but a division by a thousand rounds only once: 9 mm are the
    float 9e-3, and nine times a thousandth is not.
    """
    whole = round(1 / by)
    if by < 1 and whole > 1 and 1 / whole == by:
        return values / whole
    return values * by if by != 1 else values

"""Names and units in a table's header: the quantity of each column, and its unit.

A column is recognized by its name, in the terms of this field, and by its unit: a
`contraction [mm]` is a displacement, a `contraction [%]` a strain. `fascicle.units` reads
quantities strictly, since a person types them; a header comes from an instrument, so `PSI`,
`bar(g)`, `pct`, `Newtons` and `µm` are understood here as well.
"""

import re
from collections.abc import Callable
from typing import Any

from ..units import DIMENSIONS as UNITS
from ..units import parse


ROLES = ("pressure", "force", "torque", "strain", "length", "displacement", "angle", "moment_arm",
         "time", "branch", "clipped")  # fmt: skip
CONSTANTS = ROLES[:8]  # that one file may share
# of the roles that aren't dimensions themselves
_DIMENSIONS = {"displacement": "length", "torque": "moment", "moment_arm": "length",
               "rest_length": "length"}  # fmt: skip
POSITIONS = ("strain", "length", "displacement", "angle")  # the first in a table is read
USUAL_UNITS = {
    "pressure": "kPa", "force": "N", "length": "mm", "displacement": "mm", "time": "s",
    "torque": "N*m", "angle": "deg", "moment_arm": "mm",
}  # fmt: skip
TERMS = {
    "pressure": ("pressure", "p", "press", "pgauge", "druck", "p gauge", "überdruck", "pression"),
    "force": ("force", "f", "load", "tension", "pull", "kraft", "thrust", "mass", "weight",
              "masse", "gewicht", "standardkraft", "prüfkraft", "zugkraft"),
    "torque": ("torque", "moment", "drehmoment", "tau", "τ", "joint torque"),
    "strain": ("strain", "contraction", "contraction ratio", "eps", "epsilon", "ε", "kappa",
               "shortening", "kontraktion", "verkürzung", "elongation", "extension", "dehnung",
               "length change", "change of length", "verlängerung"),
    "length": ("length", "l", "len", "länge", "laenge", "longueur"),
    "displacement": ("displacement", "shortening", "stroke", "contraction", "disp", "travel",
                     "extension", "elongation", "position", "crosshead", "x", "weg", "hub",
                     "verkürzung", "verlängerung", "kolbenweg", "standardweg", "traversenweg",
                     "laser", "lvdt", "dehnung",
                     "length change", "change of length"),
    "angle": ("angle", "theta", "θ", "phi", "φ", "winkel", "gelenkwinkel", "rotation", "encoder",
              "position", "joint"),
    "moment_arm": ("moment arm", "arm", "lever arm", "lever", "hebelarm"),
    "time": ("time", "t", "elapsed", "zeit", "zeitstempel", "uhrzeit", "timestamp", "prüfzeit",
             "x value", "clock", "ms", "millis", "sec", "seconds"),
    "branch": ("branch", "direction", "sweep", "phase"),
    "clipped": ("clipped", "censored", "saturated", "slack", "zero is no tension", "no tension"),
}  # fmt: skip
# names of the two ways of a loop
INFLATING = ("up", "inflating", "inflation", "inflate", "contracting", "contraction", "shortening",
             "loading", "forward")  # fmt: skip
DEFLATING = ("down", "deflating", "deflation", "deflate", "extending", "extension", "lengthening",
             "unloading", "backward", "return")  # fmt: skip
ABSOLUTE = {"abs", "absolute", "total", "absolutdruck", "absolue", "absolut", "absoluter"}
MASSES = {"mass", "masse", "weight", "gewicht"}
# these grow as the muscle lengthens
LONGER = {"extension", "elongation", "tensile", "verlängerung"}
SIGNALS = {"v", "mv", "µv", "volt", "volts", "ma", "counts", "adc", "lsb"}  # of a raw gauge
_MEASURED = {"ist", "act", "actual", "meas", "measured"}  # beside a setpoint: p_ist is a pressure
# qualifiers of a column that holds something else than a quantity's readings
QUALIFIERS = {
    "setpoint", "set", "soll", "target", "command", "commanded", "reference", "desired", "rate",
    "velocity", "speed", "std", "sd", "error", "uncertainty", "rest", "initial", "nominal", "rms",
    "work", "arm", "lever", "braid", "fiber", "fibre",
    "id", "index", "count", "flow", "stress", "spannung", "sigma", "σ", "modulus", "sollwert",
    "raw", "change", "stdev", "sem", "deviation", "variance",
    "barometric", "ambient", "atmospheric", "atmosphere", "atm", "room", "supply", "luftdruck",
    "umgebungsdruck", "versorgungsdruck", "tank", "cmd", "model", "modeled", "modelled",
    "theoretical", "theory", "simulated", "simulation", "predicted", "calculated",
}  # fmt: skip
MICROSTRAINS = ("µε", "με", "µstrain", "microstrain", "µm/m")
# spellings in lower case, without ^ and with 2 for ²: of units that `fascicle.units` knows, or the
# SI units in one; signs and blanks in those of moments are left out
SPELLINGS: dict[str, dict[str, str | float]] = {
    "pressure": {
        "pa": "Pa", "pascal": "Pa", "pascals": "Pa", "hpa": "hPa", "kpa": "kPa",
        "kilopascal": "kPa", "mpa": "MPa", "bar": "bar", "bars": "bar", "mbar": "mbar",
        "psi": "psi", "lbf/in2": "psi", "lb/in2": "psi", "atm": "atm", "n/mm2": "MPa",
        "n/m2": "Pa", "kgf/cm2": "kgf/cm^2", "kg/cm2": "kgf/cm^2", "mmhg": "mmHg", "torr": "torr",
        "inhg": "inHg", "mh2o": 9806.65, "cmh2o": 98.0665, "mmh2o": 9.80665, "inh2o": 249.08891,
        "n/cm2": 1e4, "kn/m2": "kPa", "kp/cm2": "kgf/cm^2", "lbs/in2": "psi",
    },
    "force": {
        "n": "N", "newton": "N", "newtons": "N", "kn": "kN", "lbf": "lbf", "lb": "lbf",
        "lbs": "lbf", "pounds": "lbf", "kgf": "kgf", "kp": "kgf", "gf": "gf", "dan": "daN",
        "cn": "cN", "kip": "kip", "kips": "kip", "ozf": "ozf", "pound": "lbf", "lb-f": "lbf",
        "pound-force": "lbf", "kg-f": "kgf", "kilogram-force": "kgf", "gram-force": "gf",
        "grams-force": "gf",
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
        "nm": "N*m", "mnm": "mN*m", "knm": "kN*m", "nmm": "N*mm", "ncm": "N*cm", "kgfm": "kgf*m",
        "kgfcm": "kgf*cm", "kgcm": "kgf*cm", "lbfft": "lbf*ft", "lbft": "lbf*ft",
        "ftlb": "lbf*ft", "ftlbf": "lbf*ft", "lbfin": "lbf*in", "lbin": "lbf*in",
        "inlb": "lbf*in", "inlbf": "lbf*in", "ozfin": "ozf*in", "ozin": "ozf*in",
    },
    "strain": {
        **dict.fromkeys(("%", "percent", "pct", "prozent"), 1e-2),
        **dict.fromkeys(("", "-", "1", "mm/mm", "m/m", "in/in", "fraction", "ratio",
                         "dimensionless"), 1.0),
        **dict.fromkeys(("mm/m", "‰", "permille"), 1e-3),
        **dict.fromkeys(MICROSTRAINS, 1e-6),
    },
    "time": {
        **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
        **dict.fromkeys(("ms", "millis", "msec", "milliseconds"), 1e-3),
        **dict.fromkeys(("us", "µs", "μs"), 1e-6),
        **dict.fromkeys(("min", "minutes"), 60.0),
        **dict.fromkeys(("h", "hours"), 3600.0),
        **dict.fromkeys(("hh:mm:ss", "h:m:s", "mm:ss"), 1.0),  # clock times are read in seconds
    },
}  # fmt: skip
_GAUGE = re.compile(
    r"(?:\s*\((?:g(?:auge)?|rel\.?|ü)\)|[\s_]+(?:g(?:auge)?|rel\.?|ü)|(?<=[a-z])[gü])$",
    re.IGNORECASE,
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


LONGEST_NAME = 100  # characters of a column's name


class MissingMetadataError(ValueError):
    """A file that can be read only with further information.

    The message is `before` + the choices as Python writes them + a stop.

    - `before`: what is missing.
    - `choices`: arguments of `load` that would supply it, each with key and value, if it is a
      mapping, and a condition in words.
    - `argument`, `role`, `value`, `after`: the first choice.
    """

    def __init__(self, before: str, *choices: tuple[str, str, str, str]):
        self.before, self.choices = before, choices
        self.argument, self.role, self.value, self.after = choices[0]
        super().__init__(self.message(_python))

    def message(self, write: Callable[[str, str, str], str]) -> str:
        """The message with each choice as `write` puts argument, role and value."""
        texts = [f"{write(*choice[:3])}{choice[3]}" for choice in self.choices]
        return f"{self.before}{'; or give '.join(texts)}."

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.before, *self.choices)


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
    return unit.strip().lower() not in SPELLINGS["pressure"] and bool(_GAUGE.search(unit.strip()))


def unit_factor(unit: str, dimension: str) -> float:
    """SI units in one `unit`, as a header writes it, without brackets.

    `dimension`: a key of `SPELLINGS`. Raises a `ValueError` of a few words for a unit that isn't of
    that dimension.
    """
    text = unit.strip().rstrip(".")  # `in.`
    if dimension == "moment":
        text = re.sub(r"[\s·⋅•.*-]+", "", text)
    if dimension == "pressure":
        if is_absolute(text):
            raise ValueError(f"{unit!r} is absolute")
        text = _GAUGE.sub("", text) if is_gauge_unit(text) else text
    name = SPELLINGS[dimension].get(text.lower().replace("²", "2").replace("^", ""))
    if isinstance(name, float):
        return name
    if text in UNITS[dimension].factors:  # the case counts where it can: mN and MN
        name = text
    if name is None:
        raise ValueError(f"{unit!r} is no unit of {dimension}")
    return parse(f"1 {name}", dimension)


def is_unit(text: str, dimensions: tuple[str, ...] = tuple(SPELLINGS)) -> bool:
    """True if `text`, in brackets or not, is a unit of one of the `dimensions`."""
    for dimension in dimensions:
        try:
            unit_factor(strip_brackets(text), dimension)
        except ValueError:
            continue
        return True
    return False


def is_any_unit(text: str) -> bool:
    """True if `text` is a unit, also of absolute pressure."""
    return is_unit(text) or is_absolute(text)


def strip_brackets(text: str) -> str:
    """Remove the brackets around a unit, and the "in" of `Force (in N)`."""
    text = text.strip()
    pairs = ("[]", "()", "{}", "<>")
    text = text[1:-1].strip() if len(text) > 1 and text[0] + text[-1] in pairs else text
    return re.sub(r"^in\s+(?=\S)", "", text)


def read_header(header: str) -> list[tuple[str, str]]:
    """Possible meanings of a header: its name in lower case, and its unit."""
    if len(header) > LONGEST_NAME:  # no name of a quantity, and long to search
        return [("", "")]
    meanings = []
    brackets = re.findall(
        r"[\[({<]([^\[\](){}<>]*(?:\s?\((?:[gaü]|abs\.?|gauge|rel\.?)\))?)[\])}>]",
        header,
    )
    outside = re.sub(r"[\[({<].*?[\])}>]+", " ", header) if brackets else header
    outside = outside.strip(" _")  # MATLAB makes `Force_N_` of `Force (N)`
    units = [text for text in brackets if is_any_unit(text)]
    if brackets:
        # a bracket that is no unit may be a misspelled one, or a remark
        meanings.append((_plain(outside), strip_brackets((units or brackets)[-1])))
    for pattern in (
        r"(.+?)\s*/\s*(.+)", r"(.+),\s*(.+)", r"(.+)\s+in\s+(.+)",
        r"(.+?)[_\s]+(\S+[_\s]+abs(?:olute)?\.?)", r"(.+)[_\s]+(\S+)",
    ):  # fmt: skip
        match = re.fullmatch(pattern, outside)
        # 1 is a unit behind a sign alone: `Force 1` is the first of several
        if match and is_any_unit(match[2]) and not units and (match[2] != "1" or "/" in outside):
            meanings.append((_plain(match[1]), strip_brackets(match[2])))
    has_unit = any(is_any_unit(unit) for _, unit in meanings)
    return meanings if has_unit else [*meanings, (_plain(outside), "")]


def score(header: str, unit: str, role: str) -> int:
    """Agreement of a header, and of a `unit` from elsewhere, with a role; 0 for none.

    A name that is the role's counts more than one that mentions it, and either more with the
    role's unit. A unit of pressure or force is enough where the name says nothing.
    """
    dimension, best = dimension_of(role), 0
    meanings = read_header(header)
    for name, written in meanings:
        # a remark in brackets may follow a strain, or stand above a unit; T [degC] is no time
        is_remark = not is_any_unit(written)
        stated = (unit if is_remark else written) or written or unit
        stated = stated or ("" if role == "strain" else meanings[0][1])
        fits = dimension in SPELLINGS and bool(stated) and is_unit(stated, (dimension,))
        if role in {*POSITIONS, "torque", "moment_arm", "time"} and stated:
            if not fits:  # the unit tells which of them it is
                continue
        elif role == "force" and is_unit(stated, ("moment",)):
            continue
        elif role == "angle" and name in {"position", "rotation", "encoder", "joint"}:
            continue  # without a unit these may be lengths or counts
        elif role == "displacement" and name in {"contraction", "shortening", *LONGER, "x"}:
            continue  # without a unit these are strains, and x is anything
        terms = set(name.split())
        if name in TERMS[role]:
            best = max(best, 2 if stated.lower() in SIGNALS else 4 + fits)
        elif terms & QUALIFIERS or (role == "length" and terms & {"gauge", "gage"}):
            continue
        elif terms & {term for term in TERMS[role] if len(term) > 1} or (
            " ".join(word for word in name.split() if word not in _MEASURED) in TERMS[role]
        ):
            best = max(best, 2 + fits)
        elif fits and (role in {"pressure", "force", "torque"} or (role == "time" and not name)):
            best = max(best, 1)
    return best


def dimension_of(role: str) -> str:
    """Dimension of a role's quantity, also of the rest length."""
    return _DIMENSIONS.get(role, role)


def si_unit(role: str) -> str:
    """SI unit of a role's quantity, "-" of a strain."""
    return UNITS[dimension_of(role)].si or "-"


def is_known(header: str) -> bool:
    """True for a header that names a quantity of a record."""
    return any(score(header, "", role) > 1 for role in ROLES)


def differ(first: str, second: str) -> bool:
    """True for two headers that name different quantities or units."""
    roles = [{role for role in ROLES if score(text, "", role) > 1} for text in (first, second)]
    units = [{unit for _, unit in read_header(text) if unit} for text in (first, second)]
    return any(a and b and a.isdisjoint(b) for a, b in (roles, units))


def list_words(header: str) -> set[str]:
    """Words of a header's possible names, in lower case."""
    return {word for name, _ in read_header(header) for word in name.split()}


def _python(argument: str, role: str, value: str) -> str:
    """An argument of `load` as Python writes it."""
    text = f'"{value}"' if value else ""
    return f'{argument} {{"{role}": {text}}}' if role else f"{argument} {text}".rstrip()


def _plain(text: str) -> str:
    """Words of a `text` in lower case, parted at capitals and signs."""
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)  # MusclePressure
    return " ".join(re.sub(r"[\W_]+", " ", text).lower().split())

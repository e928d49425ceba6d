"""Names in a table's header: the quantity that each names, and its unit.

A column is recognized by its name, in the terms of this field, and by its unit: a
`contraction [mm]` is a displacement, a `contraction [%]` a strain.
"""

import re
from collections.abc import Callable
from typing import Any

from .units import POSITIONS, SPELLINGS, is_absolute, is_unit, strip_brackets


ROLES = ("pressure", "force", "torque", "strain", "length", "displacement", "angle", "moment_arm",
         "time", "branch", "clipped")  # fmt: skip
CONSTANTS = ROLES[:8]  # that one file may share
# of the roles that aren't dimensions themselves
DIMENSIONS = {"displacement": "length", "torque": "moment", "moment_arm": "length"}
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
    "time": ("time", "t", "elapsed", "zeit", "timestamp", "prüfzeit", "x value", "clock",
             "ms", "millis", "sec", "seconds"),
    "branch": ("branch", "direction", "sweep", "phase"),
    "clipped": ("clipped", "censored", "saturated", "slack", "zero is no tension", "no tension"),
}  # fmt: skip
ABSOLUTE = {"abs", "absolute", "total", "absolutdruck", "absolue", "absolut", "absoluter"}
MASSES = {"mass", "masse", "weight", "gewicht"}
# these grow as the muscle lengthens
LONGER = {"extension", "elongation", "tensile", "verlängerung"}
_SIGNALS = {"v", "mv", "µv", "volt", "volts", "ma", "counts", "adc", "lsb"}  # of a raw gauge
# qualifiers of a column that holds something else than a quantity's readings
_QUALIFIERS = {
    "setpoint", "set", "soll", "target", "command", "commanded", "reference", "desired", "rate",
    "velocity", "speed", "std", "sd", "error", "uncertainty", "rest", "initial", "nominal", "rms",
    "work", "arm", "lever", "braid", "fiber", "fibre",
    "id", "index", "count", "flow", "stress", "spannung", "sigma", "σ", "modulus", "sollwert",
    "raw", "change",
    "barometric", "ambient", "atmospheric", "atmosphere", "atm", "room", "supply", "luftdruck",
    "umgebungsdruck", "versorgungsdruck",
}  # fmt: skip


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


def read_header(header: str) -> list[tuple[str, str]]:
    """Possible meanings of a header: its name in lower case, and its unit."""
    meanings = []
    brackets = re.findall(
        r"[\[({<]([^\[\](){}<>]*(?:\s?\((?:[gaü]|abs\.?|gauge|rel\.?)\))?)[\])}>]",
        header,
    )
    outside = re.sub(r"[\[({<].*?[\])}>]+", " ", header) if brackets else header
    outside = outside.strip(" _")  # MATLAB makes `Force_N_` of `Force (N)`
    units = [text for text in brackets if is_unit(text) or is_absolute(text)]
    if brackets:
        # a bracket that is no unit may be a misspelled one, or a remark
        meanings.append((_plain(outside), strip_brackets((units or brackets)[-1])))
    for pattern in (
        r"(.+?)\s*/\s*(.+)", r"(.+),\s*(.+)", r"(.+)\s+in\s+(.+)",
        r"(.+?)[_\s]+(\S+[_\s]+abs(?:olute)?\.?)", r"(.+)[_\s]+(\S+)",
    ):  # fmt: skip
        match = re.fullmatch(pattern, outside)
        if match and (is_unit(match[2]) or is_absolute(match[2])) and not units:
            meanings.append((_plain(match[1]), strip_brackets(match[2])))
    has_unit = any(is_unit(unit) or is_absolute(unit) for _, unit in meanings)
    return meanings if has_unit else [*meanings, (_plain(outside), "")]


def score(header: str, unit: str, role: str) -> int:
    """Agreement of a header, and of a `unit` from elsewhere, with a role; 0 for none.

    A name that is the role's counts more than one that mentions it, and either more with the
    role's unit. A unit of pressure or force is enough where the name says nothing.
    """
    dimension, best = DIMENSIONS.get(role, role), 0
    meanings = read_header(header)
    for name, written in meanings:
        # a remark in brackets may follow a strain, or stand above a unit; T [degC] is no time
        is_remark = not (is_unit(written) or is_absolute(written))
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
            best = max(best, 2 if stated.lower() in _SIGNALS else 4 + fits)
        elif terms & _QUALIFIERS or (role == "length" and terms & {"gauge", "gage"}):
            continue
        elif terms & {term for term in TERMS[role] if len(term) > 1}:
            best = max(best, 2 + fits)
        elif fits and (role in {"pressure", "force", "torque"} or (role == "time" and not name)):
            best = max(best, 1)
    return best


def dimension_of(role: str) -> str:
    """Dimension of a role's quantity, also of the rest length."""
    return "length" if role == "rest_length" else DIMENSIONS.get(role, role)


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

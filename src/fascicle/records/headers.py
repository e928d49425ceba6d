"""Names and units in a table's header: the quantity of each column, given or inferred.

A column is recognized by its name, in the terms of this field, and by its unit: a
`contraction [mm]` is a displacement, a `contraction [%]` a strain. An ambiguous header is refused,
with the choices. `fascicle.units` reads quantities strictly, since a person types them; a header
comes from an instrument, so `PSI`, `bar(g)`, `pct`, `Newtons` and `µm` are understood here as well.
"""

import difflib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..core.errors import InvalidInputError
from ..core.findings import Finding
from ..table_model import did_you_mean
from ..units import DIMENSIONS as UNITS
from ..units import parse
from .record import note


if TYPE_CHECKING:
    from .sidecar import Sidecar
    from .tables import Table

ROLES = ("pressure", "force", "torque", "strain", "length", "displacement", "angle", "moment_arm",
         "time", "branch", "clipped")  # fmt: skip
CONSTANTS = ROLES[:8]  # that one file may share
# of the roles that aren't dimensions themselves
_DIMENSIONS = dict.fromkeys(("displacement", "moment_arm", "rest_length"), "length") | {
    "torque": "moment"
}
POSITIONS = ("strain", "length", "displacement", "angle")  # the first in a table is read
USUAL_UNITS = {"pressure": "kPa", "force": "N", "length": "mm", "displacement": "mm", "time": "s",
               "torque": "N*m", "angle": "deg", "moment_arm": "mm"}  # fmt: skip


def words(text: str) -> tuple[str, ...]:
    """Entries of a list between commas."""
    return tuple(entry.strip() for entry in text.split(","))


def _lists(text: str) -> dict[str, tuple[str, ...]]:
    """Lists by name, from `name = entry, entry; name = …`."""
    entries = (entry.partition("=") for entry in text.split(";"))
    return {name.strip(): words(names) for name, _, names in entries}


TERMS = _lists("""
    pressure = pressure, p, press, pgauge, druck, p gauge, überdruck, pression;
    force = force, f, load, tension, pull, kraft, thrust, mass, weight, payload, masse,
        gewicht, standardkraft, prüfkraft, zugkraft;
    torque = torque, moment, drehmoment, tau, τ, joint torque;
    strain = strain, contraction, contraction ratio, eps, epsilon, ε, kappa, shortening,
        kontraktion, verkürzung, elongation, extension, dehnung, length change, change of length,
        verlängerung;
    length = length, l, len, länge, laenge, longueur;
    displacement = displacement, shortening, stroke, contraction, disp, travel, extension,
        elongation, position, crosshead, x, weg, hub, verkürzung, verlängerung, kolbenweg,
        standardweg, traversenweg, laser, lvdt, dehnung, length change, change of length;
    angle = angle, theta, θ, phi, φ, winkel, gelenkwinkel, rotation, encoder, position, joint;
    moment_arm = moment arm, arm, lever arm, lever, hebelarm;
    time = time, t, elapsed, zeit, zeitstempel, uhrzeit, timestamp, prüfzeit, x value, clock, ms,
        millis, sec, seconds;
    branch = branch, direction, sweep, phase;
    clipped = clipped, censored, saturated, slack, zero is no tension, no tension""")
_ABSOLUTE_WORDS = {*words("abs, absolute, total, absolutdruck, absolue, absolut, absoluter")}
# these grow as the muscle lengthens
_LONGER = {"extension", "elongation", "tensile", "verlängerung"}
_NEEDS_UNIT = {
    "angle": {"position", "rotation", "encoder", "joint"},  # else they may be lengths or counts
    "displacement": {"contraction", "shortening", *_LONGER, "x"},  # else strains, or anything
}
SIGNALS = {*words("v, mv, µv, volt, volts, ma, counts, adc, lsb")}  # of a raw gauge
_RAW = {*SIGNALS, "raw", "voltage", "bits"}  # words in the name of a gauge's raw readings
_MEASURED = {"ist", "act", "actual", "meas", "measured"}  # beside a setpoint: p_ist is a pressure
# qualifiers of a column that holds something else than a quantity's readings
_QUALIFIERS = {*words(
    "setpoint, set, soll, target, command, commanded, reference, desired, rate, velocity, speed,"
    "std, sd, error, uncertainty, rest, initial, nominal, rms, work, arm, lever, braid, fiber,"
    "fibre, id, index, count, flow, stress, spannung, sigma, σ, modulus, sollwert, raw, change,"
    "stdev, sem, deviation, variance, barometric, ambient, atmospheric, atmosphere, atm, room,"
    "supply, luftdruck, umgebungsdruck, versorgungsdruck, tank, cmd, model, modeled, modelled,"
    "theoretical, theory, simulated, simulation, predicted, calculated"
)}  # fmt: skip
_SPECIMENS = {*words("specimen, sample, muscle, actuator, probe, muskel")}  # whose mass is no load
# of a strain gauge on the rig: no muscle's contraction
_MICROSTRAINS = "µε, με, µstrain, microstrain, µm/m"


def _spellings(text: str) -> dict[str, str]:
    """The unit of each spelling."""
    return {spelling: unit for unit, names in _lists(text).items() for spelling in names}


# of masses that hang from a muscle, the unit of their weight
_WEIGHTS = _spellings("""gf = g, gram, grams, gramm, gr; ozf = oz, ounce, ounces;
    kgf = kg, kgs, kilo, kilos, kilogram, kilograms, kilogramm""")
# spellings in lower case, without ^ and with 2 for ²: of units that `fascicle.units` knows, or of
# the SI units in one; signs and blanks in those of moments are left out
SPELLINGS = {
    "pressure": _spellings("""Pa = pa, pascal, pascals, n/m2; hPa = hpa; MPa = mpa, n/mm2;
        kPa = kpa, kilopascal, kn/m2; bar = bar, bars; mbar = mbar; atm = atm; mmHg = mmhg;
        psi = psi, lbf/in2, lb/in2, lbs/in2; kgf/cm^2 = kgf/cm2, kg/cm2, kp/cm2; torr = torr;
        inHg = inhg; 9806.65 = mh2o; 98.0665 = cmh2o; 9.80665 = mmh2o; 249.08891 = inh2o;
        1e4 = n/cm2"""),
    "force": _spellings("""N = n, newton, newtons; kN = kn; daN = dan; cN = cn; kip = kip, kips;
        lbf = lbf, lb, lbs, pound, pounds, lb-f, pound-force; ozf = ozf;
        kgf = kgf, kp, kg-f, kilogram-force; gf = gf, gram-force, grams-force""")
    | _WEIGHTS,
    "length": _spellings("""m = m, meter, meters, metre, metres; cm = cm; µm = um, μm; ft = ft;
        mm = mm, millimeter, millimeters, millimetres; in = in, inch, inches, \""""),
    "angle": _spellings("deg = deg, °, degree, degrees; rad = rad, radian, radians; mrad = mrad"),
    "moment": _spellings("""N*m = nm; mN*m = mnm; kN*m = knm; N*mm = nmm; N*cm = ncm; kgf*m = kgfm;
        kgf*cm = kgfcm, kgcm; lbf*ft = lbfft, lbft, ftlb, ftlbf; ozf*in = ozfin, ozin;
        lbf*in = lbfin, lbin, inlb, inlbf"""),
    "strain": _spellings(f"""1e-2 = %, percent, pct, prozent; 1e-3 = mm/m, ‰, permille;
        1e-6 = {_MICROSTRAINS};
        1 = , -, 1, mm/mm, m/m, in/in, fraction, ratio, dimensionless"""),
    # clock times are read in seconds
    "time": _spellings("""1e-3 = ms, millis, msec, milliseconds; 1e-6 = us, µs, μs;
        60 = min, minutes; 3600 = h, hours;
        1 = s, sec, secs, second, seconds, hh:mm:ss, h:m:s, mm:ss"""),
}
_GAUGE = re.compile(
    r"(?:\s*\((?:g(?:auge)?|rel\.?|ü)\)|[\s_]+(?:g(?:auge)?|rel\.?|ü)|(?<=[a-z])[gü])$",
    re.IGNORECASE,
)
_ABSOLUTE = re.compile(r"^(psi|m?bar|[hkm]?pa)[\s_(]*(?:a\)?|abs\.?\)?|absolute\)?)$")
NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_ALTERNATIVES = (("pressure",), ("force", "torque"), POSITIONS)  # one of each is needed
_EXAMPLES = {"pressure": "200 kPa", "force": "20 N", "length": "167 mm"}  # of a file's constants
# the name of a column for one value of a quantity
_LEVEL = re.compile(
    r"(?<![\d.,])\d+(?:[.,]\d+)?\s*(?:[kM]?Pa|m?bar|psi|[cm]?m|kg|g|N|%)(?![a-zA-Z])"
)
EXAMPLE_NAMES = "force[N],pressure[kPa],-,length[mm]"  # columns in their order
LONGEST_NAME = 100  # characters of a column's name
_BRACKETS = re.compile(r"[\[({<]([^\[\](){}<>]*(?:\s?\((?:[gaü]|abs\.?|gauge|rel\.?)\))?)[\])}>]")
# a name with a unit behind it, without brackets
_UNIT_BEHIND = (r"(.+?)\s*/\s*(.+)", r"(.+),\s*(.+)", r"(.+)\s+in\s+(.+)",
                r"(.+?)[_\s]+(\S+[_\s]+abs(?:olute)?\.?)", r"(.+)[_\s]+(\S+)")  # fmt: skip


class MissingMetadataError(ValueError):
    """A file that can be read only with further information.

    - `before`: what is missing.
    - `choices`: arguments of `load` that would supply it, each with key and value, if it is a
      mapping, and a condition in words.
    - `argument`, `role`, `value`: of the first choice.
    """

    def __init__(self, before: str, *choices: tuple[str, str, str, str]):
        super().__init__(before, *choices)
        self.before, self.choices = before, choices
        self.argument, self.role, self.value, _ = choices[0]

    def message(self, write: Callable[[str, str, str], str]) -> str:
        """The message with each choice as `write` puts argument, role and value."""
        texts = [f"{write(*choice[:3])}{choice[3]}" for choice in self.choices]
        return f"{self.before}{'; or give '.join(texts)}."

    def __str__(self) -> str:
        return self.message(_python)


def _python(argument: str, role: str, value: str) -> str:
    """An argument of `load` as Python writes it."""
    text = f'"{value}"' if value else ""
    return f'{argument} {{"{role}": {text}}}' if role else f"{argument} {text}".rstrip()


class Scale(NamedTuple):
    """Quantity of a signal: `factor` in SI units for one `unit` of it, such as a volt."""

    factor: float
    unit: str

    def zero(self, text: Any) -> Any:
        """A zero that is a signal, such as `0.2V`, as the quantity [SI]; others as they are."""
        match = re.fullmatch(rf"\s*({NUMBER.pattern})\s*{re.escape(self.unit)}\s*", str(text))
        return self.factor * float(match[1]) if match else text


def read_scale(text: str, role: str) -> Scale:
    """Scale of a gauge's signal, such as `1.475bar/V`."""
    quantity, sign, unit = map(str.strip, str(text).rpartition("/"))
    if not sign or unit.lower() not in SIGNALS:
        rule = f"of {role} must be a quantity for one unit of its signal"
        raise InvalidInputError("scales", rule, text, "write such as 1.475bar/V")
    return Scale(parse(quantity, dimension_of(role), f"scale of {role}"), unit)


def dimension_of(role: str) -> str:
    """Dimension of a role's quantity, also of the rest length."""
    return _DIMENSIONS.get(role, role)


def si_unit(role: str) -> str:
    """SI unit of a role's quantity, "-" of a strain."""
    return UNITS[dimension_of(role)].si or "-"


def is_mass(unit: str) -> bool:
    """True for a unit of mass, which is read as one of weight."""
    return unit.strip().lower() in _WEIGHTS


def absolute_unit(unit: str) -> str:
    """Plain unit of a unit of absolute pressure, such as "psi" of "psia"; empty for other units."""
    match = _ABSOLUTE.match(unit.strip().lower())
    return match[1] if match else ""


def is_gauge_unit(unit: str) -> bool:
    """True for a unit that says gauge pressure, such as "psig" or "barü"."""
    return unit.strip().lower() not in SPELLINGS["pressure"] and bool(_GAUGE.search(unit.strip()))


def unit_factor(unit: str, dimension: str) -> float:
    """SI units in one `unit`, as a header writes it; `ValueError` if of another dimension."""
    text = unit.strip().rstrip(".")  # `in.`
    if dimension == "moment":
        text = re.sub(r"[\s·⋅•.*-]+", "", text)
    if dimension == "pressure":
        if absolute_unit(text):
            raise ValueError(f"{unit!r} is absolute")
        text = _GAUGE.sub("", text) if is_gauge_unit(text) else text
    name = SPELLINGS[dimension].get(text.lower().replace("²", "2").replace("^", ""))
    if name and NUMBER.fullmatch(name):
        return float(name)
    if text in UNITS[dimension].factors:  # the case counts where it can: mN and MN
        name = text
    if name is None:
        raise ValueError(f"{unit!r} is no unit of {dimension}")
    return parse(f"1 {name}", dimension)


def is_unit(text: str, *dimensions: str) -> bool:
    """True if `text`, in brackets or not, is a unit of one of the `dimensions`; default: of any."""
    for dimension in dimensions or SPELLINGS:
        try:
            unit_factor(strip_brackets(text), dimension)
        except ValueError:
            continue
        return True
    return False


def is_any_unit(text: str) -> bool:
    """True if `text` is a unit, also of absolute pressure."""
    return is_unit(text) or bool(absolute_unit(text))


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
    meanings, brackets = [], _BRACKETS.findall(header)
    outside = re.sub(r"[\[({<].*?[\])}>]+", " ", header) if brackets else header
    outside = outside.strip(" _")  # MATLAB makes `Force_N_` of `Force (N)`
    units = [text for text in brackets if is_any_unit(text)]
    if brackets:
        # a bracket that is no unit may be a misspelled one, or a remark
        meanings.append((_plain(outside), strip_brackets(units[0] if units else brackets[-1])))
    for pattern in _UNIT_BEHIND:
        match = re.fullmatch(pattern, outside)
        if units or not match or not is_any_unit(match[2]):
            continue
        # `Force 1` is the first of several, and `P_g` a gauge pressure
        is_index = match[2] == "1" and "/" not in outside
        if not is_index and (match[2].lower() != "g" or _plain(match[1]) not in TERMS["pressure"]):
            meanings.append((_plain(match[1]), strip_brackets(match[2])))
    has_unit = any(is_any_unit(unit) for _, unit in meanings)
    return meanings if has_unit else [*meanings, (_plain(outside), "")]


def _plain(text: str) -> str:
    """Words of a `text` in lower case, parted at capitals and signs."""
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)  # MusclePressure
    return " ".join(re.sub(r"[\W_]+", " ", text).lower().split())


def score(header: str, unit: str, role: str) -> int:
    """Agreement of a header, and of a `unit` from elsewhere, with a role; 0 for none.

    The role's own name counts more than a mention of it, and either more with the role's unit. A
    unit of pressure or force is enough where the name says nothing.
    """
    dimension, best = dimension_of(role), 0
    meanings = read_header(header)
    for name, written in meanings:
        # a remark in brackets may follow a strain, or stand above a unit; T [degC] is no time
        is_remark = not is_any_unit(written)
        stated = (unit if is_remark else written) or written or unit
        stated = stated or ("" if role == "strain" else meanings[0][1])
        fits = dimension in SPELLINGS and bool(stated) and is_unit(stated, dimension)
        # a column in N is preferred to one of masses
        fits = fits and not is_mass(stated) and stated not in words(_MICROSTRAINS)
        if role in {*POSITIONS, "torque", "moment_arm", "time"} and stated:
            if not fits:  # the unit tells which of them it is
                continue
        elif name in _NEEDS_UNIT.get(role, ()) or (role == "force" and is_unit(stated, "moment")):
            continue
        terms, names = TERMS[role], name.split()
        if is_mass(stated) and _SPECIMENS & {*names}:
            continue
        if name in terms:
            best = max(best, 2 if stated.lower() in SIGNALS else 4 + fits)
        elif _QUALIFIERS & {*names} or (role == "length" and {"gauge", "gage"} & {*names}):
            continue
        elif any(len(word) > 1 and word in terms for word in names) or (
            " ".join(word for word in names if word not in _MEASURED) in terms
        ):
            best = max(best, 2 + fits)
        elif fits and (role in {"pressure", "force", "torque"} or (role == "time" and not name)):
            best = max(best, 1)
    return best


def _roles_of(header: str) -> set[str]:
    """Roles that the name in a header may have."""
    return {role for role in ROLES if score(header, "", role) > 1}


def is_known(header: str) -> bool:
    """True for a header that names a quantity of a record."""
    return bool(_roles_of(header))


def differ(first: str, second: str) -> bool:
    """True for two headers that name different quantities or units."""
    roles = [_roles_of(text) for text in (first, second)]
    units = [{unit for _, unit in read_header(text) if unit} for text in (first, second)]
    return any(a and b and a.isdisjoint(b) for a, b in (roles, units))


def _list_words(header: str) -> set[str]:
    """Words of a header's possible names, in lower case."""
    return {word for name, _ in read_header(header) for word in name.split()}


@dataclass(frozen=True)
class Column:
    """A column to read.

    - `role`: its quantity, such as "pressure".
    - `index`: its position in the header, −1 for a constant; `header`: its name there.
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

    def finding(self) -> Finding:
        """How the column is read."""
        fields = vars(self) | {"has_unit": self.role in {*POSITIONS, *USUAL_UNITS}}
        del fields["index"], fields["factor"]
        return note("column", **fields)


def choose_columns(table: "Table", info: "Sidecar") -> tuple[dict[str, Column], list[Finding]]:
    """Columns of a `table` to read, by role, and findings; what `info` says overrules the header.

    Raises a `ValueError` for a column or a unit that is missing, unknown or ambiguous.
    """
    names, units, constants = info.names, info.units, set(info.constants)
    constants |= {"moment_arm"} if info.arm_table else set()
    file_header = table.header
    if names and len(table.header) > 2 * len(names):
        missing = len(table.header) - len(names)
        rule = f"{missing} of its {len(table.header)} columns are not named: give "
        text = ",".join([*(name or "-" for name in names), "-", "…"])
        choice = ("columns", "", text, ", with - for each to skip")
        raise MissingMetadataError(f"{table.where}: {rule}", choice)
    table = _rename(table, names) if names else table
    chosen = {role: _index_of(table, role, header) for role, header in info.columns.items()}
    for role, scale in info.scales.items():
        chosen.setdefault(role, _signal_index(table, role, scale))
    _infer(table, chosen, units, constants)
    columns, optional = {}, _optional_roles(constants | chosen.keys())
    for role, index in chosen.items():
        try:
            columns[role] = _complete(table, role, index, units.get(role), info)
        except ValueError:
            if role not in optional or role in info.columns or role in units:
                raise
    used = {column.index for column in columns.values()}
    # a nameless last column is a trailing delimiter
    unread = [name for i, name in enumerate(file_header) if name and i not in used]
    columns = {role: column for role, column in columns.items() if role not in constants}
    findings = [column.finding() for column in columns.values()]
    force = columns.get("force")
    if force and is_mass(force.unit):
        findings.append(note("weights", column=force.header, unit=force.unit))
    return columns, findings + [note("unread_columns", names=unread)] * bool(unread)


def _rename(table: "Table", names: Sequence[str]) -> "Table":
    """A table with the given names of its columns; without a unit they keep that of the file."""
    units = [table.stated_unit(i) for i in range(len(table.header))]
    named = [
        f"{name} [{unit}]" if name and unit and not read_header(name)[0][1] else name
        for name, unit in zip(names, units, strict=False)
    ]
    blanks = [""] * len(units)
    return replace(table, header=(*named, *blanks)[: len(units)], units=tuple(blanks))


def _infer(
    table: "Table", chosen: dict[str, int], units: Mapping[str, str], constants: set[str]
) -> None:
    """Add the columns that the header tells to the `chosen` ones."""
    for role in ROLES:
        supplied, used = constants | set(chosen), set(chosen.values())
        alternatives = next((group for group in _ALTERNATIVES if role in group), (role,))
        # a moment arm may depend on the angle, also where the length was measured
        if supplied & ({role} if role == "angle" and "torque" in supplied else set(alternatives)):
            continue
        indices = _candidates(table, role, used, units.get(role))
        if role == "moment_arm" and not supplied & {"torque", "angle"}:
            # none of a joint, but one that was written with a record
            indices = [i for i in indices if read_header(table.header[i])[0][0] == "moment arm"]
        if role in _optional_roles(supplied):
            # several of one name, as a time beside each channel, are alike
            indices = indices[:1] if len({table.header[i] for i in indices}) == 1 else []
        if indices:
            chosen[role] = _only_index(table, role, indices)
    supplied = constants | set(chosen)
    for role, group in zip(_EXAMPLES, _ALTERNATIVES, strict=True):
        if not supplied & set(group):
            raise _missing(table, role, group, set(chosen.values()))
    if "force" in supplied:
        chosen.pop("torque", None)


def _optional_roles(roles: set[str]) -> set[str]:
    """Roles of which a wrong guess doesn't stop the reading, beside columns of `roles`."""
    optional = {"time", "branch"}
    if roles & {"strain", "length", "displacement"}:
        optional |= {"angle"} if "torque" in roles else {"angle", "moment_arm"}
    return optional


def check_roles(mapping: Mapping[str, Any], argument: str, roles: Sequence[str] = ROLES) -> None:
    """Refuse keys of a `mapping` that are no `roles`; `argument` names it in the error."""
    for role in mapping:
        if role not in roles:
            hint = did_you_mean(str(role), roles).strip(", .")
            raise InvalidInputError(argument, f"has the unknown key {role!r}", role, hint, shown="")


def split_names(names: Any) -> tuple[str, ...]:
    """Names of columns in their order, from text with commas or a list; `-` skips one."""
    entries = names.split(",") if isinstance(names, str) else names
    if not isinstance(entries, Sequence) or not all(isinstance(x, str) for x in entries):
        raise InvalidInputError("columns in order", "must be a list of names", names)
    columns = tuple("" if entry.strip() == "-" else entry.strip() for entry in entries)
    plain = [read_header(name)[0][0] for name in columns if name]
    for name in filter(None, columns):
        is_repeated = plain.count(read_header(name)[0][0]) > 1
        if is_repeated or not _roles_of(name):
            hint = f"choose of {', '.join(ROLES)}, with a unit as in force[N], or - to skip"
            rule = f"has the {'repeated' if is_repeated else 'unknown'} name {name!r}"
            raise InvalidInputError("columns in order", rule, name, hint, "")
    return columns


def _index_of(table: "Table", role: str, header: str) -> int:
    """Index of the column that the caller named."""
    target, names = header.strip().lower(), table.header
    indices = [i for i, name in enumerate(names) if name.lower() == target]
    if not indices:
        indices = [i for i, name in enumerate(names) if target in dict(read_header(name))]
    if not indices:
        names = [name for name in names if name]
        fitting = [table.header[i] for i in _candidates(table, role, set(), None)]
        best = [*difflib.get_close_matches(header, names, 1), *fitting, *names][0]
        how = f"{table.where}: no column `{header}` for {role}: name it with "
        raise MissingMetadataError(how, ("columns", role, best, f", one of {_list_names(names)}"))
    return _only_index(table, role, indices)


def _signal_index(table: "Table", role: str, scale: Scale) -> int:
    """Index of the column of a role's signal, by its unit and, if several have it, by its name."""
    unit = scale.unit.lower()
    indices = [i for i in range(len(table.header)) if table.stated_unit(i).lower() == unit]
    if len(indices) > 1:
        indices = [i for i in indices if _list_words(table.header[i]) & {*TERMS[role]}] or indices
    if not indices:
        raise ValueError(f"{table.where}: no column in {scale.unit} for the scale of {role}.")
    return _only_index(table, role, indices)


def _candidates(table: "Table", role: str, used: set[int], unit: str | None) -> list[int]:
    """Indices of the unused columns that fit a role best: several if they tie."""
    scores: dict[int, int] = {}
    for i, header in enumerate(table.header):
        if header and i not in used:
            points = score(header, table.units[i] or unit or "", role)
            # a unit that the caller gave is that of a name, not one of all columns without unit
            scores[i] = points if points > 1 else score(header, table.units[i], role)
    best = max(scores.values(), default=0)
    return [i for i, points in scores.items() if points == best > 0]


def _complete(
    table: "Table", role: str, index: int, override: str | None, info: "Sidecar"
) -> Column:
    """The column with its unit (`override`, else the header's), factor and sign."""
    header, stated = table.header[index], table.stated_unit(index)
    where = table.place(header)
    if scale := info.scales.get(role):
        if stated.lower() not in ("", scale.unit.lower()):
            rule = f"its unit is {stated}, not {scale.unit} as in the scale: leave the scale out"
            raise ValueError(f"{where}: {rule}.")
        return Column(role, index, header, scale.unit, scale.factor)
    if role in {"branch", "clipped"}:
        return Column(role, index, header)
    dimension, names = dimension_of(role), _list_words(header)
    header_unit = table.stated_unit(index, dimension)
    unit = override or header_unit
    if unit.lower() in SIGNALS or (not unit and names & _RAW):
        raise _raw_signal(where, role, unit)
    if not unit and role == "time":
        unit = header if is_unit(header, "time") else "s"
    elif not unit and role in USUAL_UNITS:
        is_mass_name = role == "force" and names & {*words("mass, masse, weight, gewicht")}
        best, *alternatives = ["kg", "g", "N"] if is_mass_name else [USUAL_UNITS[role]]
        how = f"{where}: no unit: write it with the name, such as `{header} [{best}]`, or give "
        after = f", or {' or '.join(alternatives)}" if alternatives else ""
        raise MissingMetadataError(how, ("units", role, best, after))
    has_atmosphere = info.atmosphere is not None
    is_named = absolute_unit(header_unit) or names & _ABSOLUTE_WORDS or has_atmosphere
    is_absolute = absolute_unit(unit) or (is_named and not is_gauge_unit(unit))
    absolute = role == "pressure" and bool(is_absolute)
    if absolute and not has_atmosphere:
        how = f"{where}: {unit if absolute_unit(unit) else header!r} is absolute, muscles are"
        how += " computed in gauge pressure: to subtract the atmosphere, give "
        choices = [("atmosphere", "", "1.013 bar", " as measured then")]
        if not absolute_unit(unit):  # its name may be wrong
            choices.append(("units", "pressure", f"{unit} (g)", ", if it is gauge"))
        raise MissingMetadataError(how, *choices)
    unit = (absolute and absolute_unit(unit)) or unit
    try:
        factor = unit_factor(unit, dimension)
    except ValueError as error:
        # a remark in brackets is no unit of a strain
        if role != "strain" or override is not None or is_unit(unit):
            raise _wrong_unit(where, role, error) from None
        unit, factor = "", 1.0
    longer = role in {"strain", "displacement"} and names & _LONGER
    longer = longer and not names & {"compressive", "compression"}
    is_replaced = override not in (None, header_unit) and is_any_unit(header_unit)
    replaced = header_unit if is_replaced else ""
    return Column(role, index, header, unit, factor, -1 if longer else 1, replaced, absolute)


def _raw_signal(where: str, role: str, unit: str) -> MissingMetadataError:
    """The error for a gauge's signal instead of a quantity."""
    usual = USUAL_UNITS.get(role, "%")
    before = f"{where}: raw readings of a gauge: convert them to {usual}, or give "
    choice = ("scales", role, f"1 {usual}/{unit or 'V'}", " with its own number")
    return MissingMetadataError(before, choice)


def _wrong_unit(where: str, role: str, error: ValueError) -> ValueError:
    """The error for a unit of another dimension than its column's."""
    remedy = "convert its numbers, and write their unit in the header, such as"
    remedy += f" `[{USUAL_UNITS.get(role, '%')}]`; or choose another column"
    return ValueError(f"{where}: {error}: {remedy}.")


def _check_wide(table: "Table") -> None:
    """Refuse a table with a column for each of several values of a quantity, such as `100 kPa`."""
    titles = ([cell.strip() for cell in re.split("[\t;,|]", line)] for line in table.titles)
    for cells in (list(table.header), *titles):
        levels = [cell for cell in cells if NUMBER.fullmatch(cell) or _LEVEL.search(cell)]
        is_names = cells == list(table.header) or is_known(cells[0]) or "" in cells[1:2]
        if len(set(levels)) > 1 and is_names:
            recipe = "pandas.read_csv(FILE).melt(NAME_OF_FIRST_COLUMN)"
            remedy = f"make a row of each reading, with {recipe}, and name the columns with units"
            raise ValueError(
                f"{table.where}: a column for each of {_list_names(levels)}: {remedy}."
            )


def _only_index(table: "Table", role: str, indices: Sequence[int]) -> int:
    """The index of the column of a role; the error for several."""
    if len(indices) == 1:
        return indices[0]
    _check_wide(table)
    names = [table.header[i] for i in indices]
    if len(set(names)) == 1:
        rule = f"column `{names[0]}` is there {len(names)} times: name all in order, as in "
        choice = ("columns", "", EXAMPLE_NAMES, ", with - for each to skip")
    else:
        rule = f"several columns could be {role}, {_list_names(names)}: choose one with "
        choice = ("columns", role, names[0], "")
    raise MissingMetadataError(f"{table.where}: {rule}", choice)


def _missing(table: "Table", role: str, group: Sequence[str], used: set[int]) -> ValueError:
    """The error for a `group` of roles without a column, with what could supply one of them."""
    if len(table.header) == 1:
        remedy = "part its cells by commas, semicolons, tabs or blanks"
        return ValueError(f"{table.where}: one column only, `{table.header[0]}`: {remedy}.")
    _check_wide(table)
    unused = [(name, table.stated_unit(i)) for i, name in enumerate(table.header)
              if i not in used and name.lower() not in ("", "comment")]  # fmt: skip
    group = sorted(group, key=lambda candidate: candidate != role)
    fitting = {
        name: [x for x in group if not unit or is_unit(unit, dimension_of(x))]
        for name, unit in unused
    }
    names = [name for name, unit in dict(unused).items()
             if fitting[name] or (role == "pressure" and absolute_unit(unit))]  # fmt: skip
    signals = [(name, unit) for name, unit in unused if unit.lower() in SIGNALS]
    if signals and not names:
        return _raw_signal(table.place(signals[0][0]), role, signals[0][1])
    before = f"{table.where}: no column of {' or '.join(group)} found: "
    constant = ("constants", role, _EXAMPLES[role], ", if it is one for all readings")
    if not names:
        return MissingMetadataError(f"{before}add it, or give ", constant)
    names.sort(key=lambda name: bool(_list_words(name) & _QUALIFIERS))  # setpoints last
    roles = (fitting[names[0]] if dict(unused)[names[0]] else []) or [role]
    choices = [("columns", candidate, names[0], "") for candidate in roles]
    choices[-1] = (*choices[-1][:3], f" if it is one of {_list_names(names)}")
    return MissingMetadataError(f"{before}name it with ", *choices, constant)


def _list_names(names: Sequence[str]) -> str:
    """Names in backticks: the first eight, and how many more."""
    text = ", ".join(f"`{name}`" for name in names[:8])
    return f"{text} and {len(names) - 8} more" if len(names) > 8 else text


def read_name(path: Path, pattern: str, table: str = "") -> dict[str, float]:
    """Constants [SI] in the name of a `table` in a file, or of the file and it, by a `pattern`.

    The unit stands after the braces, or in them: `{length}cm`, `{pressure:kPa}`; grams are weights.
    """
    choices, values = (*CONSTANTS, "rest_length"), {}
    # a name, its unit in the braces, and the unit behind them
    fields = re.findall(r"\{(\w+)(?::([^}]*))?\}([^\W\d_]*%?)", pattern)
    unknown = [name for name, _, _ in fields if name not in choices]
    if unknown or not fields:
        rule = f"has the unknown name {unknown[0]!r}" if unknown else "has no name in braces"
        hint = f'write such as "{{length}}cm_{{pressure}}kPa", of {", ".join(choices)}'
        raise InvalidInputError("name_pattern", rule, pattern, hint)
    number = r"([+-]?\\d+(?:[.,]\\d+)?)"
    expression = re.sub(r"\\\{.*?\\\}", number, re.escape(pattern))
    expression = expression.replace(r"\*", ".*").replace(r"\?", ".")
    match = re.search(expression, table) or re.search(expression, f"{path.stem} {table}".rstrip())
    if match is None:
        what = f"`{path.stem}` or table `{table}`" if table else f"`{path.stem}`"
        raise ValueError(f"{path}: its name {what} doesn't fit the pattern {pattern!r}.")
    for (name, inside, behind), text in zip(fields, match.groups(), strict=True):
        dimension, unit = dimension_of(name), inside or behind
        unit = _WEIGHTS.get(unit, unit) if dimension == "force" else unit
        values[name] = parse(f"{text.replace(',', '.')} {unit}", dimension, name)
    return values

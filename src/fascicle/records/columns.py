"""Roles and units of a table's columns, inferred from the header.

A column is recognized by its name, in the terms of this field, and by its unit: a
`contraction [mm]` is a displacement, a `contraction [%]` a strain. Every inference becomes a note
of the record; an ambiguous header is refused.
"""

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..core.errors import InvalidInputError
from .csv_table import Table
from .units import (
    POSITIONS,
    USUAL_UNITS,
    Column,
    is_absolute,
    is_unit,
    strip_brackets,
    unit_factor,
    weight_unit,
)


OPTIONAL = ("time", "branch")  # a wrong guess of these doesn't stop the reading
ROLES = ("pressure", "force", "strain", "length", "displacement", "time", "branch", "clipped")
_TERMS = {
    "pressure": ("pressure", "p", "press", "pgauge", "druck", "p gauge"),
    "force": ("force", "f", "load", "tension", "pull", "kraft", "thrust"),
    "strain": ("strain", "contraction", "contraction ratio", "eps", "epsilon", "ε", "kappa",
               "shortening", "kontraktion", "verkürzung", "elongation", "extension"),
    "length": ("length", "l", "len", "länge", "laenge"),
    "displacement": ("displacement", "shortening", "stroke", "contraction", "disp", "travel",
                     "extension", "elongation", "position", "crosshead", "x", "weg", "hub",
                     "verkürzung"),
    "time": ("time", "t", "elapsed", "zeit", "timestamp"),
    "branch": ("branch", "direction", "sweep", "phase"),
    "clipped": ("clipped", "censored", "saturated", "slack", "zero is no tension", "no tension"),
}  # fmt: skip
_DIMENSIONS = {"displacement": "length"}
_LONGER = {"extension", "elongation"}  # these grow as the muscle lengthens
# qualifiers of a column that holds something else than a quantity's readings
_QUALIFIERS = {
    "setpoint", "target", "command", "commanded", "reference", "desired", "rate", "velocity",
    "speed", "std", "sd", "error", "uncertainty", "rest", "initial", "nominal", "rms", "work",
    "id", "index", "count", "absolute", "abs",
}  # fmt: skip


class MissingMetadataError(ValueError):
    """A file that can be read only with further information.

    The message is `before` + the argument of `load` as Python writes it + `after`.

    - `argument`: of `load`, that would supply the information.
    - `role`, `value`: key and value of it, if it is a mapping.
    """

    def __init__(
        self, before: str, argument: str, role: str = "", value: str = "", after: str = ""
    ):
        self.before, self.argument, self.role, self.value = before, argument, role, value
        self.after = after
        python = f'{argument} {{"{role}": "{value}"}}' if role else argument
        super().__init__(f"{before}{python}{after}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.before, self.argument, self.role, self.value, self.after)


def choose_columns(
    table: Table, headers: Mapping[str, str], units: Mapping[str, str]
) -> tuple[dict[str, Column], tuple[str, ...]]:
    """Columns of a `table` to read, by role, and a note for each guess.

    `headers` and `units`, by role, overrule what the table's header says. Raises a `ValueError`
    for a column or a unit that is missing, unknown or ambiguous.
    """
    chosen: dict[str, Column] = {}
    for role, header in headers.items():
        chosen[role] = Column(role, _index_of(table, role, header), header)
    used = {column.index for column in chosen.values()}
    for role in ROLES:
        if role in chosen or (role in POSITIONS and any(p in chosen for p in POSITIONS)):
            continue
        indices = _candidates(table, role, used, units.get(role))
        if len(indices) > 1 and role not in OPTIONAL:
            raise _ambiguous(table, role, indices)
        if len(indices) == 1:
            chosen[role] = Column(role, indices[0], table.header[indices[0]])
            used.add(indices[0])
    for role in ("pressure", "force"):
        if role not in chosen:
            raise _missing(table, role, used)
    if not any(role in chosen for role in POSITIONS):
        raise _missing(table, "length", used)
    columns = {}
    for role, column in chosen.items():
        try:
            columns[role] = _with_unit(table, column, units.get(role))
        except ValueError:
            if role not in OPTIONAL or role in headers or role in units:
                raise
    notes = [column.note() for column in columns.values()]
    notes += [
        f"unit {units[role]!r} of {role} not used: there is no such column"
        for role in units
        if role not in columns
    ]
    used = {column.index for column in columns.values()}
    # a nameless last column is a trailing delimiter
    unread = [f"`{h}`" for i, h in enumerate(table.header) if h and i not in used]
    if unread:
        notes.append(f"columns not read: {', '.join(unread)}")
    return columns, tuple(notes)


def check_roles(mapping: Mapping[str, str], argument: str) -> None:
    """Refuse keys of a `mapping` that are no roles; `argument` names it in the error."""
    for role in mapping:
        if role not in ROLES:
            hint = _nearest(str(role), ROLES, '"') or f"choose one of {', '.join(ROLES)}"
            raise InvalidInputError(argument, f"has the unknown key {role!r}", role, hint, shown="")


def _nearest(name: str, choices: Sequence[str], quote: str) -> str:
    """A question for the most similar name; empty if none is similar."""
    similar = difflib.get_close_matches(name, choices, n=1, cutoff=0.5)
    return f"did you mean {quote}{similar[0]}{quote}?" if similar else ""


def _index_of(table: Table, role: str, header: str) -> int:
    """Index of the column that the caller named."""
    target, names = header.strip().lower(), table.header
    indices = [i for i, name in enumerate(names) if name.lower() == target]
    if not indices:
        indices = [
            i for i, name in enumerate(names) if target in [plain for plain, _ in _readings(name)]
        ]
    if not indices:
        names = [name for name in names if name]
        hint = _nearest(header, names, "`") or f"there are {_listed(names)}."
        raise ValueError(f"{table.where}: no column `{header}` for {role}: {hint}")
    if len(indices) > 1:
        raise _ambiguous(table, role, indices)
    return indices[0]


def _candidates(table: Table, role: str, used: set[int], unit: str | None) -> list[int]:
    """Indices of the columns that could have a role."""
    scores = {
        i: _score(header, table.units[i] or unit or "", role)
        for i, header in enumerate(table.header)
        if header and i not in used
    }
    best = max(scores.values(), default=0)
    return [i for i, score in scores.items() if score == best > 0]


def _score(header: str, unit: str, role: str) -> int:
    """2 for a header that names the role, 1 for one that mentions it, else 0."""
    dimension, best = _DIMENSIONS.get(role, role), 0
    readings = _readings(header)
    for name, written in readings:
        # a remark in brackets may follow a strain; T [degC] is no time
        stated = written or unit or ("" if role == "strain" else readings[0][1])
        if role in {*POSITIONS, "time"} and stated:
            if not is_unit(stated, (dimension,)):  # the unit tells which of them it is
                continue
        elif role == "displacement" and name in {"contraction", "shortening", *_LONGER, "x"}:
            continue  # without a unit these are strains, and x is anything
        terms = set(name.split())
        if name in _TERMS[role]:
            best = 2
        elif not terms & _QUALIFIERS and terms & {term for term in _TERMS[role] if len(term) > 1}:
            best = max(best, 1)
    return best


def _readings(header: str) -> list[tuple[str, str]]:
    """Possible meanings of a header: its name in lower case, and its unit."""
    readings = []
    brackets = re.findall(r"[\[({<]([^\[\](){}<>]*(?:\([ga]\))?)[\])}>]", header)
    outside = re.sub(r"[\[({<].*?[\])}>]+", " ", header) if brackets else header
    units = [text for text in brackets if is_unit(text)]
    if brackets:
        # a bracket that is no unit may be a misspelled one, or a remark
        readings.append((_plain(outside), (units or brackets)[-1].strip()))
    for pattern in (r"(.+?)\s*/\s*(.+)", r"(.+),\s*(.+)", r"(.+)\s+in\s+(.+)", r"(.+)[_\s]+(\S+)"):
        match = re.fullmatch(pattern, outside.strip())
        if match and is_unit(match[2]) and not units:
            readings.append((_plain(match[1]), strip_brackets(match[2])))
    has_unit = any(is_unit(unit) for _, unit in readings)
    return readings if has_unit else [*readings, (_plain(outside), "")]


def _plain(text: str) -> str:
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)  # MusclePressure
    return " ".join(re.sub(r"[\W_]+", " ", text).lower().split())


def _with_unit(table: Table, column: Column, override: str | None) -> Column:
    """The column with its unit, factor and sign."""
    if column.role in {"branch", "clipped"}:
        return column
    header, row_unit = table.header[column.index], strip_brackets(table.units[column.index])
    readings = _readings(header)
    dimension = _DIMENSIONS.get(column.role, column.role)
    units = [unit for _, unit in readings if unit]
    units.sort(key=lambda unit: not is_unit(unit, (dimension,)))
    header_unit = row_unit or next(iter(units), "")
    unit = override or header_unit or None
    where = f"{table.where}, column `{header}`"
    if unit is None and column.role in USUAL_UNITS:
        if column.role == "time":
            unit = "s"
        else:
            best = USUAL_UNITS[column.role]
            how = f"{where}: no unit: write it in the header, such as `{header} [{best}]`, or give "
            raise MissingMetadataError(how, "units", column.role, best, ".")
    try:
        factor = unit_factor(unit or "", dimension)
    except ValueError as error:
        # a remark in brackets is no unit of a strain
        if column.role != "strain" or override is not None or is_unit(unit or ""):
            raise _wrong_unit(where, column.role, unit or "", dimension, error) from None
        unit, factor = "", 1.0
    is_valid = is_unit(header_unit) or is_absolute(header_unit)
    meaning = header_unit if is_valid else weight_unit(header_unit, dimension)
    longer = any(set(name.split()) & _LONGER for name, _ in readings)
    return replace(
        column,
        header=header,
        unit=unit or "",
        factor=factor,
        sign=-1 if longer and column.role in {"strain", "displacement"} else 1,
        replaced_unit=header_unit if override and meaning not in ("", override) else "",
    )


def _wrong_unit(where: str, role: str, unit: str, dimension: str, error: ValueError) -> ValueError:
    """The error for a unit of another dimension than its column's."""
    if role == "pressure" and is_absolute(unit):
        return ValueError(
            f"{where}: {error}, muscles are computed in gauge pressure: subtract the atmosphere"
            " from the column, and write the unit without it."
        )
    if best := weight_unit(unit, dimension):
        how = f"{where}: {error}: write `[{best}]` in the header, the weight of that mass, or give "
        return MissingMetadataError(how, "units", role, best, ".")
    return ValueError(
        f"{where}: {error}: convert its numbers, and write their unit in the header, such as"
        f" `[{USUAL_UNITS.get(role, '%')}]`; or choose another column."
    )


def _ambiguous(table: Table, role: str, indices: Sequence[int]) -> ValueError:
    names = [table.header[i] for i in indices]
    if len(set(names)) == 1:
        times = f"is there {len(names)} times: rename or delete one."
        return ValueError(f"{table.where}: column `{names[0]}` {times}")
    how = f"{table.where}: several columns could be {role}, {_listed(names)}: choose one with "
    return MissingMetadataError(how, "columns", role, names[0], ".")


def _missing(table: Table, role: str, used: set[int]) -> ValueError:
    quantity = "length, strain or displacement" if role == "length" else role
    names = [name for i, name in enumerate(table.header) if name and i not in used]
    message = f"{table.where}: no column of {quantity} found: "
    if not names:
        return ValueError(f"{message}add it, such as `{role} [{USUAL_UNITS[role]}]`.")
    after = f" if it is one of {_listed(names)}."
    return MissingMetadataError(f"{message}name it with ", "columns", role, names[0], after)


def _listed(names: Sequence[str]) -> str:
    text = ", ".join(f"`{name}`" for name in names[:8])
    return f"{text} and {len(names) - 8} more" if len(names) > 8 else text

"""Roles and units of a table's columns, inferred from its header or given by the caller.

Every inference becomes a note of the record; an ambiguous header is refused, with the choices. The
names of files, such as `run_150kPa.csv`, and patterns that read them tell what no column holds.
"""

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..core.errors import InvalidInputError
from ..units import parse
from .cells import NUMBER, is_number, split_cells
from .headers import (
    ABSOLUTE,
    CONSTANTS,
    LONGER,
    MASSES,
    MICROSTRAINS,
    POSITIONS,
    QUALIFIERS,
    ROLES,
    SIGNALS,
    TERMS,
    USUAL_UNITS,
    MissingMetadataError,
    absolute_unit,
    dimension_of,
    is_absolute,
    is_any_unit,
    is_gauge_unit,
    is_known,
    is_unit,
    list_words,
    read_header,
    score,
    strip_brackets,
    unit_factor,
    weight_unit,
)
from .tables import Table


_ALTERNATIVES = (("pressure",), ("force", "torque"), POSITIONS)  # one of each is needed
_EXAMPLES = {"pressure": "200 kPa", "force": "20 N", "length": "167 mm"}  # of a file's constants
_PATTERN_NAMES = (*CONSTANTS, "rest_length")
# the name of a column for one value of a quantity
_LEVEL = re.compile(
    r"(?<![\d.,])\d+(?:[.,]\d+)?\s*(?:[kM]?Pa|m?bar|psi|[cm]?m|kg|g|N|%)(?![a-zA-Z])"
)
_RAW = {*SIGNALS, "raw", "voltage", "bits"}  # words in the name of a gauge's raw readings
# a line above or between readings that states a value: `Pressure: 1,5 bar`
_LONGEST_STATEMENT = 100  # characters
_STATED = re.compile(
    rf"[\s#%/;!\"]*([^\W\d][\w ]*?)\s*[:=]\s*({NUMBER.pattern})\s*([^\W\d_]+)\s*", re.ASCII
)


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


def choose_columns(
    table: Table,
    headers: Mapping[str, str],
    units: Mapping[str, str],
    constants: Iterable[str] = (),
    *,
    names: Sequence[str] = (),
    atmosphere: bool = False,
) -> tuple[dict[str, Column], tuple[str, ...]]:
    """Columns of a `table` to read, by role, and a note for each guess.

    `headers` and `units`, by role, overrule what the table's header says, and so do the `names` of
    columns in their order. The roles `constants` need no column. `atmosphere`: absolute pressures
    are read. Raises a `ValueError` for a column or a unit that is missing, unknown or ambiguous.
    """
    chosen = {
        role: Column(role, _index_of(table, role, header), header)
        for role, header in headers.items()
    }
    units = dict(units)
    for role, index, unit in _role_positions(names):
        if index < len(table.header):
            chosen[role] = Column(role, index, table.header[index] or names[index])
        if unit:
            units.setdefault(role, unit)
    constants = set(constants)
    _infer(table, chosen, units, constants, () if names else ROLES)
    columns, optional = {}, _optional_roles(constants | chosen.keys())
    for role, column in chosen.items():
        try:
            columns[role] = _complete(table, column, units.get(role), atmosphere=atmosphere)
        except ValueError:
            if role not in optional or role in headers or role in units:
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


def _infer(
    table: Table,
    chosen: dict[str, Column],
    units: Mapping[str, str],
    constants: set[str],
    roles: Sequence[str],
) -> None:
    """Add the columns of `roles` that the header tells to the `chosen` ones, and drop a torque
    beside a force; raises for several candidates, or without pressure, force or position.
    """
    used = {column.index for column in chosen.values()}
    for role in roles:
        supplied = constants | set(chosen)
        alternatives = next((group for group in _ALTERNATIVES if role in group), (role,))
        # a moment arm may depend on the angle, also where the length was measured
        if supplied & ({role} if role == "angle" and "torque" in supplied else set(alternatives)):
            continue
        indices = _candidates(table, role, used, units.get(role))
        if role == "moment_arm" and not supplied & {"torque", "angle"}:
            # none of a joint, but one that was written with a record
            indices = [i for i in indices if read_header(table.header[i])[0][0] == "moment arm"]
        lengths = ("length", "displacement") if role == "strain" else ()
        if any(_candidates(table, length, used, units.get(length)) for length in lengths):
            # beside a length these are of a strain gauge on the rig
            indices = [i for i in indices if _stated_unit(table, i, role) not in MICROSTRAINS]
        if role in _optional_roles(supplied):
            # several of one name, as a time beside each channel, are alike
            indices = indices[:1] if len({table.header[i] for i in indices}) == 1 else []
        if len(indices) > 1:
            raise _ambiguous(table, role, indices)
        if indices:
            chosen[role] = Column(role, indices[0], table.header[indices[0]])
            used.add(indices[0])
    supplied = constants | set(chosen)
    for role, group in zip(("pressure", "force", "length"), _ALTERNATIVES, strict=True):
        if not supplied & set(group):
            _check_position_units(table, group)
            raise _missing(table, role, used)
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
            hint = _suggest_name(str(role), roles, '"') or f"choose one of {', '.join(roles)}"
            raise InvalidInputError(argument, f"has the unknown key {role!r}", role, hint, shown="")


def split_names(names: Any) -> tuple[str, ...]:
    """Names of columns in their order, from text with commas or a list; `-` skips one."""
    entries = names.split(",") if isinstance(names, str) else names
    if not isinstance(entries, Sequence) or not all(isinstance(x, str) for x in entries):
        raise InvalidInputError("columns in order", "must be a list of names", names)
    columns = tuple("" if entry.strip() == "-" else entry.strip() for entry in entries)
    _role_positions(columns)
    return columns


def _role_positions(names: Sequence[str]) -> list[tuple[str, int, str]]:
    """Role, index and unit of each column that is named by its place."""
    positions: list[tuple[str, int, str]] = []
    for index, text in enumerate(names):
        for name, unit in read_header(text) if text else ():
            fits = [
                role for role in ROLES
                if name in {role, *TERMS[role]}
                and (not unit or role == "branch" or is_unit(unit, (dimension_of(role),))
                     or is_absolute(unit))
            ]  # fmt: skip
            role = name if name in fits else next(iter(fits), None)
            if role is not None:
                break
        else:
            if text:
                hint = f"choose of {', '.join(ROLES)}, with a unit such as force[N], or - to skip"
                raise InvalidInputError(
                    "columns in order", f"has the unknown name {text!r}", text, hint, ""
                )
            continue
        if any(role == position[0] for position in positions):
            hint = "write - for the one to skip"
            raise InvalidInputError("columns in order", f"names {role} twice", text, hint, "")
        positions.append((role, index, unit))
    return positions


def _suggest_name(name: str, choices: Sequence[str], quote: str) -> str:
    """A question for the most similar name; empty if none is similar."""
    similar = difflib.get_close_matches(name, choices, n=1, cutoff=0.5)
    return f"did you mean {quote}{similar[0]}{quote}?" if similar else ""


def _index_of(table: Table, role: str, header: str) -> int:
    """Index of the column that the caller named."""
    target, names = header.strip().lower(), table.header
    indices = [i for i, name in enumerate(names) if name.lower() == target]
    if not indices:
        indices = [
            i for i, name in enumerate(names) if target in [plain for plain, _ in read_header(name)]
        ]
    if not indices:
        names = [name for name in names if name]
        hint = _suggest_name(header, names, "`") or f"there are {_list_names(names)}."
        raise ValueError(f"{table.where}: no column `{header}` for {role}: {hint}")
    if len(indices) > 1:
        raise _ambiguous(table, role, indices)
    return indices[0]


def _candidates(table: Table, role: str, used: set[int], unit: str | None) -> list[int]:
    """Indices of the unused columns that fit a role best: several if they tie."""
    scores: dict[int, int] = {}
    for i, header in enumerate(table.header):
        if header and i not in used:
            points = score(header, table.units[i] or unit or "", role)
            # a unit that the caller gave is that of a name, not one of all columns without unit
            scores[i] = points if points > 1 else score(header, table.units[i], role)
    best = max(scores.values(), default=0)
    return [i for i, points in scores.items() if points == best > 0]


def _complete(table: Table, column: Column, override: str | None, *, atmosphere: bool) -> Column:
    """The column with its unit (`override`, else the header's), factor and sign; an absolute
    pressure is refused unless the `atmosphere` is known.
    """
    role, header = column.role, table.header[column.index]
    if role in {"branch", "clipped"}:
        return column
    dimension, header_words = dimension_of(role), list_words(header)
    header_unit = _stated_unit(table, column.index, dimension)
    unit = override or header_unit
    where = f"{table.where}, column `{header}`"
    if not unit and role == "time":
        unit = header if is_unit(header, ("time",)) else "s"
    elif not unit and header_words & _RAW:
        raise ValueError(f"{where}: raw readings of a gauge: convert them to {USUAL_UNITS[role]},"
                         " and write the unit in the header.")  # fmt: skip
    elif not unit and role in USUAL_UNITS:
        weights = [unit for word in header_words if (unit := weight_unit(word, dimension))]
        if not weights and role == "force" and header_words & MASSES:
            weights = ["kgf", "gf", "N"]
        best, *alternatives = weights or [USUAL_UNITS[role]]
        how = f"{where}: no unit: write it with the name, such as `{header} [{best}]`, or give "
        after = f", or {' or '.join(alternatives)}" if alternatives else ""
        raise MissingMetadataError(how, ("units", role, best, after))
    calls_absolute = is_absolute(header_unit) or bool(header_words & ABSOLUTE)
    absolute = role == "pressure" and (
        is_absolute(unit) or ((calls_absolute or atmosphere) and not is_gauge_unit(unit))
    )
    if absolute and not atmosphere:
        how = (
            f"{where}: {unit if is_absolute(unit) else header!r} is absolute, muscles are computed"
            " in gauge pressure: to subtract the atmosphere, give "
        )
        choices = [("atmosphere", "", "1.013 bar", " as measured then")]
        if not is_absolute(unit):  # its name may be wrong
            choices.append(("units", "pressure", f"{unit} (g)", ", if it is gauge"))
        raise MissingMetadataError(how, *choices)
    unit = (absolute and absolute_unit(unit)) or unit
    try:
        factor = unit_factor(unit, dimension)
    except ValueError as error:
        # a remark in brackets is no unit of a strain
        if role != "strain" or override is not None or is_unit(unit):
            raise _wrong_unit(where, role, unit, error) from None
        unit, factor = "", 1.0
    meaning = header_unit if is_any_unit(header_unit) else weight_unit(header_unit, dimension)
    longer = role in {"strain", "displacement"} and header_words & LONGER
    longer = longer and not header_words & {"compressive", "compression"}
    return replace(
        column,
        header=header,
        unit=unit,
        factor=factor,
        sign=-1 if longer else 1,
        replaced_unit=header_unit if override and meaning not in ("", override) else "",
        absolute=absolute,
    )


def _stated_unit(table: Table, index: int, *dimensions: str) -> str:
    """Unit of a column: of the row of units, or else of its name, best one of the `dimensions`."""
    units = [strip_brackets(table.units[index])]
    units = units if units[0] else [unit for _, unit in read_header(table.header[index])]
    return next((unit for unit in units if unit and is_unit(unit, dimensions)), units[0])


def _wrong_unit(where: str, role: str, unit: str, error: ValueError) -> ValueError:
    """The error for a unit of another dimension than its column's."""
    if best := weight_unit(unit, dimension_of(role)):
        how = f"{where}: {error}: write `[{best}]` in the header, the weight of that mass, or give "
        return MissingMetadataError(how, ("units", role, best, ""))
    return ValueError(
        f"{where}: {error}: convert its numbers, and write their unit in the header, such as"
        f" `[{USUAL_UNITS.get(role, '%')}]`; or choose another column."
    )


def _check_wide(table: Table) -> None:
    """Refuse a table with a column for each of several values of a quantity, such as `100 kPa`."""
    for cells in (table.header, *(split_cells(line, table.delimiter) for line in table.titles)):
        levels = [cell for cell in cells if is_number(cell) or _LEVEL.search(cell)]
        if len(set(levels)) > 1 and (cells is table.header or is_known(cells[0]) or not cells[1]):
            raise ValueError(
                f"{table.where}: a column for each of {_list_names(levels)}: make a row of each"
                " reading, with pandas.read_csv(FILE).melt(NAME_OF_FIRST_COLUMN), and name the"
                " columns with their units."
            )


def _ambiguous(table: Table, role: str, indices: Sequence[int]) -> ValueError:
    _check_wide(table)
    names = [table.header[i] for i in indices]
    if len(set(names)) == 1:
        before = f"{table.where}: column `{names[0]}` is there {len(names)} times: choose one with "
        choices = (("columns", "", _columns_in_order(table, i), "") for i in (0, -1))
        return MissingMetadataError(before, *choices)
    how = f"{table.where}: several columns could be {role}, {_list_names(names)}: choose one with "
    return MissingMetadataError(how, ("columns", role, names[0], ""))


def _columns_in_order(table: Table, repeat: int) -> str:
    """Names for `--columns`: of columns with one name the `repeat`-th, `-` for one to skip."""
    entries, roles = [], set()
    for i, header in enumerate(table.header):
        points = {role: score(header, table.units[i], role) for role in ROLES}
        role = max(points, key=lambda role: points[role])
        repeats = [k for k, name in enumerate(table.header) if name == header]
        if points[role] < 2 or role in roles or i != repeats[repeat]:
            entries.append("-")
            continue
        roles.add(role)
        unit = _stated_unit(table, i, dimension_of(role))
        is_stated = unit and is_unit(unit, (dimension_of(role),))
        entries.append(f"{role}[{unit}]" if is_stated else role)
    return ",".join(entries).rstrip(",-")


def _check_position_units(table: Table, roles: Sequence[str]) -> None:
    """Refuse a column named as one of the `roles` whose unit is unknown."""
    for i, header in enumerate(table.header):
        name, unit = read_header(header)[0][0], _stated_unit(table, i)
        role = next((role for role in roles if name in TERMS[role]), None)
        if role in POSITIONS and unit and not is_unit(unit):
            error = ValueError(f"{unit!r} is no unit of {dimension_of(role)}")
            raise _wrong_unit(f"{table.where}, column `{header}`", role, unit, error)


def _missing(table: Table, role: str, used: set[int]) -> ValueError:
    """The error for a role without a column, with what could supply it."""
    if len(table.header) == 1:
        remedy = "part its cells by commas, semicolons, tabs or blanks"
        return ValueError(f"{table.where}: one column only, `{table.header[0]}`: {remedy}.")
    _check_wide(table)
    quantities = {"length": "length, strain, displacement or angle", "force": "force or torque"}
    quantity = quantities.get(role, role)
    dimension, names = dimension_of(role), []
    dimensions = ("length", "strain", "angle") if role == "length" else (dimension,)
    for i, name in enumerate(table.header):
        stated = _stated_unit(table, i)
        fits = not stated or is_unit(stated, dimensions) or weight_unit(stated, dimension)
        if name.lower() in {"", "comment"}:  # the last column of LabVIEW
            continue
        if i not in used and (fits or (role == "pressure" and is_absolute(stated))):
            names.append(name)
    names.sort(key=lambda name: bool(list_words(name) & QUALIFIERS))  # setpoints last
    before = f"{table.where}: no column of {quantity} found: "
    signals = [name for i, name in enumerate(table.header)
               if i not in used and _stated_unit(table, i).lower() in SIGNALS]  # fmt: skip
    if signals and not names:
        before += f"{_list_names(signals)} hold signals, convert one to {USUAL_UNITS[role]}: "
    # a length above the readings may be the muscle's
    stated = [] if role == "length" else _stated_values((*table.remarks, *table.titles), role)
    constant = ("constants", role, [*stated, _EXAMPLES[role]][0], ", if it is one for all readings")
    check_stated(table, (role,))
    if not names:
        return MissingMetadataError(f"{before}add it, or give ", constant)
    unit = _stated_unit(table, table.header.index(names[0]))
    roles = [role for role in ("length", "displacement", "strain", "angle")
             if unit and is_unit(unit, (dimension_of(role),))]  # fmt: skip
    if len(names) == 1 and role == "length" and roles:
        choices = [("columns", role, names[0], "") for role in roles]
        return MissingMetadataError(f"{before}`{names[0]}` is which of them: give ", *choices)
    after = f" if it is one of {_list_names(names)}"
    named = ("columns", role, names[0], after)
    return MissingMetadataError(f"{before}name it with ", named, constant)


def check_stated(table: Table, roles: Iterable[str]) -> None:
    """Refuse a constant of `roles` for which lines between the readings state several values."""
    roles = [role for role in ("pressure", "force") if role in roles]
    if not roles:
        return
    for role in roles:
        body_values = _stated_values(table.body, role)
        title_values = _stated_values((*table.remarks, *table.titles), role)
        values = list(dict.fromkeys((*title_values, *body_values)))
        if body_values and len(values) > 1:
            listed = f"its lines state a {role} of {', '.join(values[:4])}"
            remedy = f"write a column of {role}, or read those of one by --rows"
            raise ValueError(f"{table.source}: {listed}: {remedy}.")


def _stated_values(lines: Iterable[str], role: str) -> list[str]:
    """Values of a `role`, with units, that `lines` state, such as `Pressure: 100 kPa`."""
    matches = (_STATED.fullmatch(line) for line in lines if len(line) < _LONGEST_STATEMENT)
    return [
        f"{match[2].replace(',', '.')} {match[3]}"
        for match in matches
        if match and match[1].lower() in TERMS[role] and is_unit(match[3], (dimension_of(role),))
    ]


def _list_names(names: Sequence[str]) -> str:
    """Names in backticks: the first eight, and how many more."""
    text = ", ".join(f"`{name}`" for name in names[:8])
    return f"{text} and {len(names) - 8} more" if len(names) > 8 else text


def read_name(path: Path, pattern: str, table: str = "") -> dict[str, float]:
    """Constants [SI] that the name of a `table` in a file, or the file's name and it, holds where
    the `pattern` has their names in braces.

    The unit stands after the braces, or in them: `{length}cm`, `{pressure:kPa}`; grams and the
    like of a force are weights.
    """
    # text, and after each piece of it a name, its unit in the braces, and the unit behind them
    *pieces, end = re.split(r"\{(\w+)(?::([^}]*))?\}(?=([^\W\d_]*%?))", pattern)
    expression, fields = "", []
    for text, name, inside, behind in zip(*(pieces[i::4] for i in range(4)), strict=True):
        expression += _wildcard_expression(text) + r"([+-]?\d+(?:[.,]\d+)?)"
        fields.append((name, inside or behind))
        if name not in _PATTERN_NAMES:
            hint, rule = f"choose of {', '.join(_PATTERN_NAMES)}", f"has the unknown name {name!r}"
            raise InvalidInputError("name_pattern", rule, name, f"{hint}; * is other text", "")
    if not fields:
        hint = 'write such as "{length}cm_{pressure}kPa"'
        raise InvalidInputError("name_pattern", "has no name in braces", pattern, hint)
    expression += _wildcard_expression(end)
    match = re.search(expression, table) or re.search(expression, f"{path.stem} {table}".rstrip())
    if match is None:
        what = (
            f"neither table `{table}` nor its name with the file's fits"
            if table
            else ("the file's name doesn't fit")
        )
        raise ValueError(f"{path}: {what} the pattern {pattern!r}.")
    values = {}
    for (name, unit), text in zip(fields, match.groups(), strict=True):
        dimension = dimension_of(name)
        number = f"{text.replace(',', '.')} {weight_unit(unit, dimension) or unit}"
        values[name] = parse(number, dimension, name)
    return values


def _wildcard_expression(text: str) -> str:
    return re.escape(text).replace(r"\*", ".*").replace(r"\?", ".")

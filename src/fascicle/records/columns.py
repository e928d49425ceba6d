"""Which column is what, and in which unit: guessed from the header, and said.

A column is recognized by its name, in the words of this field, and by its unit, since a
`contraction [mm]` is a displacement and a `contraction [%]` a strain. What was guessed becomes
a note of the record; what could be read two ways is refused.
"""

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ..core.errors import InvalidInputError
from .asking import Asked
from .spelling import bare, factor, is_absolute, is_unit, remedy_unit
from .table import Table


OPTIONAL = ("time", "branch")  # a column that was only guessed to be one doesn't stop the reading
ROLES = ("pressure", "force", "strain", "length", "displacement", "time", "branch", "clipped")
POSITIONS = ("strain", "length", "displacement")  # one is enough, the first that is there
_WORDS = {
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
# what is said of a quantity, but isn't it
_ABOUT = {
    "setpoint", "target", "command", "commanded", "reference", "desired", "rate", "velocity",
    "speed", "std", "sd", "error", "uncertainty", "rest", "initial", "nominal", "rms", "work",
    "id", "index", "count", "absolute", "abs",
}  # fmt: skip
_SPELLED = {
    "pressure": "kPa", "force": "N", "length": "mm", "displacement": "mm", "time": "s",
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """A column that will be read.

    - `role`: what it holds [-].
    - `place`: where it stands in the header [-].
    - `header`: its name as written [-].
    - `unit`: as written [-]; `factor`: how many SI units that is [-].
    - `sign`: −1 where the file counts the other way [-].
    - `written`: the header's unit, where another one was given [-].
    """

    role: str
    place: int
    header: str
    unit: str = ""
    factor: float = 1.0
    sign: int = 1
    written: str = ""

    def told(self) -> str:
        """What it was taken for [-], in words."""
        unit = f" in {self.unit or 'fractions'}" if self.role in {*POSITIONS, *_SPELLED} else ""
        turned = ", its sign turned" if self.sign < 0 else ""
        instead = f" as given, not in {self.written}" if self.written else ""
        return f"column `{self.header}` read as {self.role}{unit}{instead}{turned}"


def choose(
    table: Table, columns: Mapping[str, str], units: Mapping[str, str]
) -> tuple[dict[str, Column], tuple[str, ...]]:
    """The columns to read, by role.

    **Arguments:**

    - `table`: whose header to look at [-].
    - `columns`: headers that were given by role [-].
    - `units`: units that were given by role [-].

    **Returns:** the columns, and what was guessed, a line each [-].

    **Raises:** `ValueError`, in one line, for a column or a unit that is missing, unknown or
    ambiguous.
    """
    where = f"{table.source}, line {table.line}"
    found: dict[str, Column] = {}
    for role, header in columns.items():
        found[role] = Column(role, _given(table, role, header), header)
    taken = {column.place for column in found.values()}
    for role in ROLES:
        if role in found or (role in POSITIONS and any(p in found for p in POSITIONS)):
            continue
        places = _guessed(table, role, taken, units.get(role))
        if len(places) > 1 and role not in OPTIONAL:
            raise _several(table, role, places)
        if len(places) == 1:
            found[role] = Column(role, places[0], table.header[places[0]])
            taken.add(places[0])
    for role in ("pressure", "force"):
        if role not in found:
            raise _missing(table, where, role, found)
    if not any(role in found for role in POSITIONS):
        raise _missing(table, where, "length", found)
    found = _with_units(table, found, columns, units)
    taken = {column.place for column in found.values()}
    notes = [column.told() for column in found.values()]
    notes += [
        f"unit {units[role]!r} of {role} not used: there is no such column"
        for role in units
        if role not in found
    ]
    ignored = [
        f"`{h}`" for i, h in enumerate(table.header) if h and i not in taken
    ]  # a nameless last column is a trailing delimiter
    if ignored:
        notes.append(f"columns not read: {', '.join(ignored)}")
    return found, tuple(notes)


def check_roles(given: Mapping[str, object], what: str) -> None:
    """Refuse keys of `given` [-] that are no roles, named as `what` [-]."""
    for role in given:
        if role not in ROLES:
            near = difflib.get_close_matches(str(role), ROLES, n=1, cutoff=0.5)
            hint = f'did you mean "{near[0]}"?' if near else f"choose one of {', '.join(ROLES)}"
            raise InvalidInputError(what, f"has the unknown key {role!r}", role, hint, shown="")


def _given(table: Table, role: str, header: str) -> int:
    wanted = header.strip().lower()
    places = [i for i, name in enumerate(table.header) if name.lower() == wanted]
    places = places or [
        i for i, name in enumerate(table.header)
        if any(n == wanted for n, _ in _parts(name))
    ]  # fmt: skip
    if not places:
        names = [name for name in table.header if name]
        near = difflib.get_close_matches(header, names, n=1, cutoff=0.5)
        hint = f"did you mean `{near[0]}`?" if near else f"there are {_listed(names)}."
        raise ValueError(
            f"{table.source}, line {table.line}: no column `{header}` for {role}: {hint}"
        )
    if len(places) > 1:
        raise _several(table, role, places)
    return places[0]


def _guessed(table: Table, role: str, taken: set[int], unit: str | None) -> list[int]:
    """Places of the columns that could be `role`."""
    exact, partly = [], []
    for i, header in enumerate(table.header):
        if i in taken or not header:
            continue
        likeness = _likeness(header, table.units[i] or unit or "", role)
        if likeness:
            (exact if likeness == 2 else partly).append(i)
    return exact or partly


def _likeness(header: str, unit: str, role: str) -> int:
    """2 where a header says `role`, 1 where it mentions it, else 0."""
    dimension, best = _DIMENSIONS.get(role, role), 0
    parts = _parts(header)
    for name, written in parts:
        # a remark in brackets may follow a strain; T [degC] is no time
        said = written or unit or ("" if role == "strain" else parts[0][1])
        if role in {"strain", "length", "displacement", "time"} and said:
            # the unit says which of them it is
            if not is_unit(said, (dimension,)):
                continue
        elif role == "displacement" and name in {"contraction", "shortening", *_LONGER, "x"}:
            continue  # without a unit these are strains, and x is anything
        words = set(name.split())
        if name in _WORDS[role]:
            best = 2
        elif not words & _ABOUT and words & {w for w in _WORDS[role] if len(w) > 1}:
            best = max(best, 1)
    return best


def _parts(header: str) -> list[tuple[str, str]]:
    """What a header could mean: its name in plain words, and the unit that follows it."""
    found = []
    brackets = re.findall(r"[\[({<]([^\[\](){}<>]*(?:\([ga]\))?)[\])}>]", header)
    outside = re.sub(r"[\[({<].*?[\])}>]+", " ", header) if brackets else header
    units = [text for text in brackets if is_unit(text)]
    if brackets:
        # a bracket that is no unit may be one misspelled, or a remark
        found.append((_plain(outside), (units or brackets)[-1].strip()))
    for pattern in (r"(.+?)\s*/\s*(.+)", r"(.+),\s*(.+)", r"(.+)\s+in\s+(.+)", r"(.+)[_\s]+(\S+)"):
        match = re.fullmatch(pattern, outside.strip())
        if match and is_unit(match[2]) and not units:
            found.append((_plain(match[1]), bare(match[2])))
    understood = any(is_unit(unit) for _, unit in found)
    return found if understood else [*found, (_plain(outside), "")]


def _plain(text: str) -> str:
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)  # MusclePressure
    return " ".join(re.sub(r"[\W_]+", " ", text).lower().split())


def _with_units(
    table: Table,
    found: Mapping[str, Column],
    columns: Mapping[str, str],
    units: Mapping[str, str],
) -> dict[str, Column]:
    """The columns with their units; without those that were only guessed, have none that is known,
    and aren't needed.
    """
    complete = {}
    for role, column in found.items():
        try:
            complete[role] = _with_unit(table, column, units.get(role))
        except ValueError:
            if role not in OPTIONAL or role in columns or role in units:
                raise
    return complete


def _with_unit(table: Table, column: Column, given: str | None) -> Column:
    if column.role in {"branch", "clipped"}:
        return column
    header = table.header[column.place]
    parts = _parts(header)
    dimension = _DIMENSIONS.get(column.role, column.role)
    written = [unit for _, unit in parts if unit and is_unit(unit, (dimension,))]
    other = [unit for _, unit in parts if unit]
    unit = given or (bare(table.units[column.place]) or None) or next(iter(written or other), None)
    where = f"{table.source}, line {table.line}, column `{header}`"
    if unit is None and column.role in _SPELLED:
        if column.role == "time":
            unit = "s"
        else:
            best = _SPELLED[column.role]
            how = f"{where}: no unit: write it in the header, such as `{header} [{best}]`, or give "
            raise Asked(how, "units", column.role, best, ".")
    try:
        by = factor(unit or "", dimension)
    except ValueError as error:
        # a remark in brackets is no unit of a strain
        if column.role == "strain" and given is None and not is_unit(unit or ""):
            unit, by = "", 1.0
        else:
            raise _wrong_unit(where, column.role, unit or "", dimension, error) from None
    own = bare(table.units[column.place]) or next(iter(written or other), "")
    meant = own if is_unit(own) or is_absolute(own) else remedy_unit(own, dimension)
    instead = own if given and meant not in ("", given) else ""
    longer = column.role in {"strain", "displacement"} and any(
        set(name.split()) & _LONGER for name, _ in parts
    )
    sign = -1 if longer else 1
    return replace(column, header=header, unit=unit or "", factor=by, sign=sign, written=instead)


def _wrong_unit(where: str, role: str, unit: str, dimension: str, error: ValueError) -> ValueError:
    """What to say of a unit that isn't of its column's dimension: another unit is offered only
    where the numbers are in it.
    """
    if role == "pressure" and is_absolute(unit):
        return ValueError(
            f"{where}: {error}, muscles are computed in gauge pressure: subtract the atmosphere"
            " from the column, and write the unit without it."
        )
    if best := remedy_unit(unit, dimension):
        how = f"{where}: {error}: write `[{best}]` in the header, the weight of that mass, or give "
        return Asked(how, "units", role, best, ".")
    best = _SPELLED.get(role, "%")
    return ValueError(
        f"{where}: {error}: convert its numbers, and write their unit in the header, such as"
        f" `[{best}]`; or choose another column."
    )


def _several(table: Table, role: str, places: Sequence[int]) -> ValueError:
    names = [table.header[i] for i in places]
    where = f"{table.source}, line {table.line}"
    if len(set(names)) == 1:
        return ValueError(
            f"{where}: column `{names[0]}` is there {len(names)} times: rename or delete one."
        )
    how = f"{where}: several columns could be {role}, {_listed(names)}: choose one with "
    return Asked(how, "columns", role, names[0], ".")


def _missing(table: Table, where: str, role: str, found: Mapping[str, Column]) -> ValueError:
    what = "length, strain or displacement" if role == "length" else role
    taken = {column.place for column in found.values()}
    left = [name for i, name in enumerate(table.header) if name and i not in taken]
    none = f"{where}: no column of {what} found: "
    if not left:
        return ValueError(f"{none}add it, such as `{role} [{_SPELLED[role]}]`.")
    after = f" if it is one of {_listed(left)}."
    return Asked(f"{none}name it with ", "columns", role, left[0], after)


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(f"`{name}`" for name in names[:8])
    return f"{shown} and {len(names) - 8} more" if len(names) > 8 else shown

"""From a dynamometer's file to a `Record`: everything is checked here, once, and what was
guessed on the way is in its notes.
"""

import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import to_si
from ..io.input_file import read_bytes
from ..units import parse, pretty
from .asking import Asked
from .columns import OPTIONAL, POSITIONS, Column, check_roles, choose
from .plausible import Fault, check_force, check_pressure, check_strain
from .record import DOWN, UNKNOWN, UP, Record, Source, join
from .sidecar import Sidecar, beside
from .sidecar import read as read_sidecar
from .spelling import scaled
from .table import Cells, Table, open_table


LARGEST_FILE = 1_000_000_000  # bytes

_BRANCHES = {
    **dict.fromkeys(
        ("1", "+1", "1.0", "up", "inflating", "inflation", "inflate", "contracting",
         "contraction", "shortening", "loading", "forward"), UP),
    **dict.fromkeys(
        ("-1", "−1", "-1.0", "down", "deflating", "deflation", "deflate", "extending",
         "extension", "lengthening", "unloading", "backward", "return"), DOWN),
    **dict.fromkeys(("0", "0.0", "", "-", "unknown"), UNKNOWN),
}  # fmt: skip
_FLAGS = {
    **dict.fromkeys(("1", "1.0", "true", "yes", "y", "x", "clipped", "censored"), True),
    **dict.fromkeys(("0", "0.0", "false", "no", "n", "", "-", "ok"), False),
}
_WORDS = ("branch", "clipped")  # roles of columns that hold words
_NUMBER = re.compile(r"[+−-]?\d+(?:\.\d*)?", re.ASCII)
_REMARK = re.compile(r"(\w+)\s*[:=]\s*(.*)")  # key: text, or key = text


def load(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rest_length: Any = None,
    clipped_at_zero: bool | None = None,
    header: int | None = None,
    sidecar: str | os.PathLike[str] | None = None,
) -> Record:
    """Read what a dynamometer wrote.

    What is given here wins over what the TOML beside the file says, and that over the file.

    **Arguments:**

    - `path`: the CSV [-], or several of the same muscle.
    - `columns`: the headers of columns that aren't recognized, by role [-]: pressure, force,
      strain, length, displacement, time, branch, clipped.
    - `units`: units of columns whose header has none, by role [-].
    - `rest_length`: the length that strains refer to [m]; lengths and displacements need it.
    - `clipped_at_zero`: whether forces of exactly zero are clipped readings [-].
    - `header`: the line that the columns' names stand in [-]; left out, it is looked for.
    - `sidecar`: the TOML [-]; left out, the one of the same name, if there is one.

    **Returns:** the record [-].

    **Raises:** `OSError` for a file that can't be read; `ValueError`, in one line with file,
    line and column, for one that says what can't be.
    """
    if not isinstance(path, str | os.PathLike):
        if not path:
            raise InvalidInputError("path", "must name at least one file", None, shown="none")
        return join([
            load(one, columns=columns, units=units, rest_length=rest_length,
                 clipped_at_zero=clipped_at_zero, header=header, sidecar=sidecar) for one in path
        ])  # fmt: skip
    path = Path(path)
    raw = read_bytes(path, LARGEST_FILE, "record", ": keep every tenth row, or split it.")
    if sidecar is None:
        said, notes = beside(path)
    else:
        said, notes = read_sidecar(sidecar), (f"{Path(sidecar).name} read with it",)
    given = _given(said, columns, units, rest_length, clipped_at_zero)
    return _record(raw, str(path), path.name, given, notes, header)


def loads(
    text: str,
    source: str = "<text>",
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rest_length: Any = None,
    clipped_at_zero: bool | None = None,
    header: int | None = None,
) -> Record:
    """Read what such a file holds.

    **Arguments:**

    - `text`: the table [-].
    - `source`: what to call it in an error [-].
    - `columns`: as for `load` [-].
    - `units`: as for `load` [-].
    - `rest_length`: as for `load` [m].
    - `clipped_at_zero`: as for `load` [-].
    - `header`: as for `load` [-].

    **Returns:** the record [-].

    **Raises:** `ValueError` as `load`.
    """
    given = _given(Sidecar(), columns, units, rest_length, clipped_at_zero)
    return _record(text.encode(), source, source, given, (), header)


def _given(
    said: Sidecar,
    columns: Mapping[str, str] | None,
    units: Mapping[str, str] | None,
    rest_length: Any,
    clipped_at_zero: bool | None,
) -> Sidecar:
    """What the TOML and the caller say together, the caller first."""
    for what, table in (("columns", columns or {}), ("units", units or {})):
        check_roles(table, what)
    rest_length = to_si(rest_length, "rest_length", "m")
    if rest_length is not None and not (np.isfinite(rest_length) and rest_length > 0):
        raise InvalidInputError(
            "rest_length", "must be positive and finite", rest_length, shown=f"{rest_length} m"
        )
    return Sidecar(
        rest_length=said.rest_length if rest_length is None else float(rest_length),
        displacement_at_rest=said.displacement_at_rest,
        clipped_at_zero=said.clipped_at_zero if clipped_at_zero is None else clipped_at_zero,
        columns={**said.columns, **(columns or {})},
        units={**said.units, **(units or {})},
        signs=said.signs,
        synthetic=said.synthetic,
        notes=said.notes,
    )


def _record(
    raw: bytes,
    source: str,
    name: str,
    given: Sidecar,
    notes: tuple[str, ...],
    header: int | None,
) -> Record:
    table = open_table(raw, source, header)
    chosen, guessed = choose(table, given.columns, given.units)
    above = (*table.remarks, *table.titles)
    remarks = [(match[1].lower(), match[2]) for match in map(_REMARK.match, above) if match]
    rest, told = _rest_length(table, given, dict(remarks))
    position = chosen[next(role for role in POSITIONS if role in chosen)]
    if rest is None and position.role != "strain":
        where = f"{source}, line {table.line}, column `{position.header}`"
        raise Asked(
            f"{where}: a {position.role} needs the rest length: give ",
            "rest_length",
            after=', or write rest_length = "300 mm" in'
            f" {Path(name).stem or 'its'}.toml beside it.",
        )
    cells, left_out = _cells(table, chosen, given)
    for column in left_out:
        del chosen[column.role]
        passed = f"column `{column.header}` not read as {column.role}: it holds something else"
        guessed = (*(note for note in guessed if note != column.told()), passed)

    def fault(row: int, column: Column, rule: str) -> ValueError:
        return table.fault(int(cells.lines[row]), column.place, rule)

    load_cell = chosen["force"]
    raws = {
        role: cells.numbers[column.place] for role, column in chosen.items() if role not in _WORDS
    }
    force = scaled(raws["force"], load_cell.factor) * given.signs.get("force", 1)
    pressure, noted = check_pressure(chosen["pressure"], raws["pressure"], force, fault)
    noted += check_force(load_cell, raws["force"], force, pressure, fault)
    strain, stretched = _strain(position, raws[position.role], rest or np.nan, given, fault)
    censored, clipped = _censored(table, cells, chosen.get("clipped"), force, given)
    branch = np.full(force.size, UNKNOWN, dtype=np.int8)
    if "branch" in chosen:
        branch = _mapped(table, cells, chosen["branch"], _BRANCHES, "up or down").astype(np.int8)
    time = None
    if "time" in chosen:
        time = scaled(raws["time"], chosen["time"].factor)
        back = np.flatnonzero(np.diff(time) < 0)
        if back.size:
            noted += (f"time goes back in line {cells.lines[back[0] + 1]}",)
    said = tuple(f"{key}: {text}" for key, text in remarks if key in {"source", "note"})
    every = (
        *notes,
        *_passed(table),
        *guessed,
        *told,
        *stretched,
        *clipped,
        *noted,
        *given.notes,
        *said,
    )
    return Record(
        pressure=pressure, strain=strain, force=force, censored=censored, branch=branch, time=time,
        rest_length=rest, synthetic=given.synthetic or _synthetic(above),
        sources=(Source(name, hashlib.sha256(raw).hexdigest()),),
        notes=tuple(f"{name}: {note}" for note in every),
    )  # fmt: skip


def _cells(
    table: Table, chosen: Mapping[str, Column], given: Sidecar
) -> tuple[Cells, list[Column]]:
    """The columns' cells, and the optional columns that were left out: they were only guessed, and
    can't be read as what they were taken for.
    """

    def read(roles: Sequence[str]) -> Cells:
        words = [chosen[role].place for role in roles if role in _WORDS]
        return table.read([chosen[role].place for role in roles if role not in _WORDS], words)

    asked = {*given.columns, *given.units}
    guessed = [role for role in OPTIONAL if role in chosen and role not in asked]
    left_out = []
    if "branch" in guessed:
        column = chosen["branch"]
        _, words = read(["branch"]).words[column.place]
        # sweeps that are counted: numbers other than those of branches
        if all(map(_NUMBER.fullmatch, words)) and not set(words) <= set(_BRANCHES):
            left_out.append(column)
    roles = [role for role, column in chosen.items() if column not in left_out]
    try:
        return read(roles), left_out
    except ValueError:
        if "time" not in guessed:
            raise
    left_out.append(chosen["time"])
    return read([role for role in roles if role != "time"]), left_out


def _passed(table: Table) -> tuple[str, ...]:
    """A note of the lines above the header, if there are any."""
    if not table.titles:
        return ()
    lines = "; ".join(line if len(line) <= 60 else f"{line[:57]}…" for line in table.titles[:3])
    more = f" and {len(table.titles) - 3} more" if len(table.titles) > 3 else ""
    return (f"lines above the header not read as data: {lines}{more}",)


def _synthetic(remarks: Sequence[str]) -> bool:
    """Whether a remark says so, in as many words as it likes."""
    said = [text.lower()[len("synthetic") :].strip(" :=.") for text in remarks
            if text.lower().startswith("synthetic")]  # fmt: skip
    return any(text not in {"false", "no", "0"} for text in said)


def _rest_length(
    table: Table, given: Sidecar, remarks: Mapping[str, str]
) -> tuple[float | None, tuple[str, ...]]:
    if given.rest_length is not None or "rest_length" not in remarks:
        return given.rest_length, ()
    try:
        rest = parse(remarks["rest_length"].strip('" '), "length", "rest_length")
    except ValueError as error:
        raise ValueError(f"{table.source}: in its remarks, {error}") from None
    if rest <= 0:
        raise ValueError(f"{table.source}: in its remarks, `rest_length` must be positive.")
    return rest, (f"rest length {pretty(rest, 'length')} read from its remarks",)


def _strain(
    column: Column, raw: np.ndarray, rest: float, given: Sidecar, fault: Fault
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Contraction, from whichever position was measured."""
    values = scaled(raw, column.factor)
    sign = given.signs.get(column.role, given.signs.get("strain", column.sign))
    if column.role == "strain":
        strain = values * sign
    elif column.role == "displacement":
        strain = (values - (given.displacement_at_rest or 0.0)) * sign / rest
    else:
        wrong = np.flatnonzero(values <= 0)
        if wrong.size:
            told = f"{raw[wrong[0]]:g} is no length of a muscle"
            if raw[wrong[0]] == 0:
                told += (
                    ": if it counts from rest, say so with columns"
                    f' {{"displacement": "{column.header}"}}'
                )
            raise fault(int(wrong[0]), column, f"{told}.")
        strain = (rest - values) / rest
    check_strain(column, raw, strain, fault)
    notes = ()
    longest = int(np.argmin(strain))
    # a gauge's zero is off by that much
    if strain[longest] < -1e-3:
        count = int(np.count_nonzero(strain < -1e-3))
        notes = (f"{count} readings stretched beyond rest, down to {strain[longest]:.3g}",)
    return strain + 0.0, notes


def _censored(
    table: Table, cells: Cells, column: Column | None, force: np.ndarray, given: Sidecar
) -> tuple[np.ndarray, tuple[str, ...]]:
    censored = np.zeros(force.size, dtype=bool)
    if column is not None:
        censored = _mapped(table, cells, column, _FLAGS, "0 or 1").astype(bool)
    if given.clipped_at_zero:
        censored = censored | (force == 0)
    count, zeros = int(np.count_nonzero(censored)), int(np.count_nonzero(force == 0))
    if count:
        return censored, (f"{count} of {force.size} readings clipped",)
    if zeros > 2 and column is None and given.clipped_at_zero is None:
        return censored, (
            f"{zeros} forces are exactly 0: if the gauge can't push, give clipped_at_zero = true",
        )
    return censored, ()


def _mapped(
    table: Table, cells: Cells, column: Column, meanings: Mapping[str, int], rule: str
) -> np.ndarray:
    codes, words = cells.words[column.place]
    for i, word in enumerate(words):
        if word.strip().lower() not in meanings:
            line = int(cells.lines[int(np.argmax(codes == i))])
            raise table.fault(line, column.place, f"{word!r} isn't known: write {rule}.")
    known = np.array([meanings[word.strip().lower()] for word in words], dtype=int)
    return known[codes]

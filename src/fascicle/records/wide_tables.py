"""Tables with columns for each pressure, as digitized figures have them, turned into long ones.

A pressure stands in the header: in each name (`200 kPa`, `F at 2 bar [N]`), or in a row of its own
above or below the names. Each pressure has one column of forces beside a shared column of
contractions, or a pair of both. In the long table each row is a reading, with its pressure. Columns
for each length (`180 mm`) beside one of pressures are turned likewise.
"""

import re
from collections.abc import Sequence
from itertools import pairwise

from .cells import is_number, is_remark, split_cells
from .headers import (
    DEFLATING,
    INFLATING,
    POSITIONS,
    QUALIFIERS,
    is_absolute,
    is_known,
    is_unit,
    list_words,
    read_header,
    score,
    strip_brackets,
    unit_factor,
)


_REACH = 3  # rows above the readings: names, pressures and units
_LEVEL = re.compile(
    r"(?:(?:@|\b(?:at|bei|p|pressure|druck|l|length|länge)\b)\s*[=:]?\s*)*"
    r"(?<![\d.,])(\d+(?:[.,]\d+)?)\s*([a-zA-Z]+(?:\s?\([ag]\))?)(?![a-zA-Z])",
    re.IGNORECASE,
)
_WAYS = {*INFLATING, *DEFLATING}
_PLAIN = re.compile(r"\d+(?:[.,]\d+)?")


def _read_header(
    rows: Sequence[Sequence[str]], readings: Sequence[Sequence[str]]
) -> tuple[list[str], list[tuple[str, list[int]]]] | None:
    """Names of the long table's columns, and for each pressure its text and the indices of shared
    columns and its own; from the `rows` above the first `readings`. `None` without two pressures.

    Raises a `ValueError` of a few words for pressures with different numbers of columns.
    """
    width = max(map(len, [*rows, *readings]), default=0)
    rows = [[*row, *[""] * (width - len(row))] for row in rows]
    used = [any(j < len(row) and row[j] for row in readings) for j in range(width)]
    for name_row, row in pairwise(rows):  # a name of pressures above numbers alone leads them
        numbers = [j for j, cell in enumerate(row) if _PLAIN.fullmatch(cell)]
        j = numbers[0] if len(numbers) > 1 and len(numbers) == sum(map(bool, row)) else 0
        if j and score(name_row[j], "", "pressure") > 1:
            row[j - 1], name_row[j] = name_row[j], "force"
    choices = ((kind, i) for kind in ("pressure", "length") for i in range(len(rows) - 1, -1, -1))
    kind, i = next((x for x in choices if len({*_levels(rows[x[1]], x[0])} - {None}) > 1), ("", 0))
    if not kind:
        return None
    names = _column_names(rows, i, kind)
    shared, groups = _group_columns(rows[i], _levels(rows[i], kind), names, used)
    if len({number for number, _, _ in groups}) < 2:
        return None
    header = _long_names([names[j] for j in shared], [names[j] for j in groups[0][2]])
    residues = [_residue(rows[i][j], kind) for *_, indices in groups for j in indices]
    roles = [_likely_role(text) for text in (*header, *residues)]
    of_shared = set(roles[: len(shared)])
    repeated = {"pressure"} if kind == "pressure" else set(POSITIONS)
    if repeated & set(roles) or ("force" in of_shared and of_shared & set(POSITIONS)):
        return None
    sizes = {len(indices) for *_, indices in groups}
    if len(sizes) > 1:
        counts = f"{min(sizes)} to {max(sizes)} columns"
        raise ValueError(f"its pressures have {counts}: give each the same, with empty cells")
    written = {unit for _, unit, _ in groups}
    if len(written) == 1:
        unit, factors = written.pop(), [1.0] * len(groups)
    else:
        unit = "Pa" if kind == "pressure" else "m"
        factors = [unit_factor(unit, kind) for _, unit, _ in groups]
    # an exponent, since points between digits may separate thousands
    columns = [
        (f"{number * factor:.16e}", [*shared, *indices])
        for (number, _, indices), factor in zip(groups, factors, strict=True)
    ]
    return [*header, f"{kind} [{unit}]" if unit else kind], columns


def unfold(
    lines: Sequence[str],
    head: Sequence[tuple[int, str]],
    delimiter: str,
    start: int,
    names: Sequence[str],
    source: str,
) -> tuple[str, tuple[int, ...]] | None:
    """Text of a wide table as a long one, and the file's line of each of its lines; `None` for
    other tables.
    """
    rows = [split_cells(text, delimiter, trim=False) for _, text in head]
    firsts = [is_number(row[0]) for row in rows[start : start + 2]]
    start += firsts == [False, True]  # a row of pressures that begins with their name
    header_start = max(start - _REACH, 0)
    try:
        header = _read_header(rows[header_start:start], rows[start:])
    except ValueError as error:
        raise ValueError(f"{source}, line {head[start - 1][0]}: {error}.") from None
    if header is None or len(names) >= len(header[0]):
        return None
    header_names, groups = header
    first, top = head[start][0] if start < len(head) else len(lines) + 1, head[header_start][0]
    body = [
        [] if is_remark(line) else split_cells(line, delimiter, trim=False)
        for line in lines[first - 1 :]
    ]
    is_led = any(is_number(row[0]) for row in body if row)
    width = 1 + max(index for _, indices in groups for index in indices)
    readings, texts = [], []
    for line, row in enumerate(body, first):
        if any(map(is_number, row)) and not (is_led and row[0][:1].isalpha()):
            readings.append((line, [*row, *[""] * (width - len(row))]))
        elif any(row):
            texts.append((line, row[0]))
    shared = len(set(groups[0][1]) & set(groups[1][1]))
    below = [
        (line, "\t".join([*(row[j] for j in indices), level]))
        for level, indices in groups
        for line, row in readings
        if any(row[j] for j in indices[shared:])
    ]
    titles = [
        (line, text)
        for (line, text), row in zip(
            head[header_start:start], rows[header_start:start], strict=True
        )
        if sum(map(bool, row)) == 1
    ]
    text = [*lines[: top - 1], *(title for _, title in titles), "\t".join(header_names)]
    origins = [*range(1, top), *(line for line, _ in titles), head[start - 1][0]]
    below += texts
    return "\n".join([*text, *(row for _, row in below)]), (*origins, *(line for line, _ in below))


def _column_names(rows: Sequence[Sequence[str]], i: int, kind: str) -> list[str]:
    """Name of each column, from the rows but the one of index `i`, and the rest of that one."""
    unit_rows = [row for row in rows if _is_unit_row(row)]
    other_rows = [
        row
        for k, row in enumerate(rows)
        if k != i and row not in unit_rows and sum(map(bool, row)) > 1
        and not any(map(_PLAIN.fullmatch, row))
    ]  # fmt: skip
    label, names = _label_index(rows[i]), []
    for j, cell in enumerate(rows[i]):
        header_text = next((row[j] for row in reversed(other_rows) if row[j]), "")
        is_pressure = j == label and score(cell, "", "pressure")
        text = header_text or ("" if is_pressure else _residue(cell, kind))
        unit = strip_brackets(unit_rows[0][j]) if unit_rows else ""
        names.append(f"{text} [{unit}]" if unit else text)
    return names


def _likely_role(text: str) -> str:
    """Pressure, force or a kind of position that a name tells; empty for another name."""
    scores = {role: score(text, "", role) for role in ("pressure", "force", *POSITIONS)}
    best = max(scores, key=lambda role: scores[role])
    return best if scores[best] > 1 else ""


def _levels(row: Sequence[str], kind: str) -> list[tuple[float, str] | None]:
    """Pressure or length, as the `kind`, and its unit in each cell of a `row` of a header."""
    label = _label_index(row)
    if label is not None and kind == "pressure":
        unit = next((unit for _, unit in read_header(row[label]) if is_unit(unit, (kind,))), "")
        return [(_parse_number(cell), unit) if _PLAIN.fullmatch(cell) else None for cell in row]
    matches = (_level(cell, kind) for cell in row)
    return [(_parse_number(match[1]), match[2]) if match else None for match in matches]


def _label_index(row: Sequence[str]) -> int | None:
    """Index of the name of pressures or contractions before a row of numbers, `None` for others."""
    cells = [j for j, cell in enumerate(row) if cell]
    numbers = [j for j in cells if _PLAIN.fullmatch(row[j])]
    if len(numbers) < 2 or len(cells) != len(numbers) + 1 or cells[0] in numbers:
        return None
    text = row[cells[0]]
    is_position = any(score(text, "", role) > 1 for role in POSITIONS)
    return cells[0] if is_position or score(text, "", "pressure") else None


def _level(cell: str, kind: str) -> re.Match[str] | None:
    """First pressure or length, as the `kind`, with its unit in a `cell`; `None` without one."""
    for match in _LEVEL.finditer(cell):
        if is_unit(match[2], (kind,)) or (kind == "pressure" and is_absolute(match[2])):
            return match
    return None


def _residue(cell: str, kind: str) -> str:
    """A name without its pressure or length."""
    match = _level(cell, kind)
    if match is None:
        return cell
    text = re.sub(r"[\[({]\s*[\])}]", "", f"{cell[: match.start()]} {cell[match.end() :]}")
    return re.sub(r"[\s_]+", " ", text).strip(" -,;:@=/")


def _parse_number(text: str) -> float:
    """Value of a number written with a decimal point or comma."""
    return float(text.replace(",", "."))


def _is_unit_row(row: Sequence[str]) -> bool:
    """True for a row of two or more units alone, none of them a number."""
    cells = [cell for cell in row if cell]
    return len(cells) > 1 and all(map(is_unit, cells)) and not any(map(_PLAIN.fullmatch, cells))


def _group_columns(
    row: Sequence[str],
    levels: Sequence[tuple[float, str] | None],
    names: Sequence[str],
    used: Sequence[bool],
) -> tuple[list[int], list[tuple[float, str, tuple[int, ...]]]]:
    """Indices of the columns that all levels share, and each level's number, unit and column
    indices; only `used` columns count.

    A blank cell continues the level before it, and so does a repeated level over another name,
    unless that is the other way of a loop. Columns of deviations, setpoints and the like are
    left out.
    """
    shared: list[int] = []
    groups: list[tuple[float, str, tuple[int, ...]]] = []
    for j, (cell, level) in enumerate(zip(row, levels, strict=True)):
        if not used[j]:
            continue
        if level is None and (cell or not groups):
            shared.append(j)
        elif list_words(names[j]) & QUALIFIERS:
            continue
        elif level is None:
            number, unit, indices = groups[-1]
            groups[-1] = number, unit, (*indices, j)
        elif (
            groups and groups[-1][:2] == level and names[j] not in [names[k] for k in groups[-1][2]]
            and not (read_header(names[j])[0][0] in _WAYS and not _likely_role(names[j]))
        ):  # fmt: skip
            groups[-1] = *level, (*groups[-1][2], j)
        else:
            groups.append((*level, (j,)))
    return shared, groups


def _long_names(shared: Sequence[str], group: Sequence[str]) -> list[str]:
    """Names of shared columns and of those of a group: X and force where there is none."""
    names, is_pair = list(group), len(group) == 2
    if is_pair and names[0].partition(" [")[0].lower() in ("", "x"):
        names[0] = f"X{names[0].lstrip('Xx')}"
    has_force = any(score(text, "", "force") > 1 for text in (*shared, *names[:-1]))
    may_be_force = len(group) == 1 or (is_pair and (not shared or names[0][:1] == "X"))
    if may_be_force and not has_force and not is_known(names[-1]):
        units = [unit for _, unit in read_header(names[-1]) if is_unit(unit, ("force",))]
        names[-1] = f"force [{units[0]}]" if units else "force"
    return [*(text or "X" for text in shared), *(text or "value" for text in names)]

"""Measured records for publication: JSON of the schema `fascicle-record/1`, to the bit and back.

A file has the fields of a `Record` in SI units. Its schema is `json_schema()`; the first key names
the version, and a reader refuses versions that it doesn't know.
"""

import json
import os
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, StrictBool, StrictStr

from ..core.validation import HIGHEST_PRESSURE
from ..io.atomic import write_text
from ..table_model import FileError, TableModel, validate
from .record import COLUMNS, OPTIONAL_COLUMNS, STRAINS, Record, Source, dumps


SCHEMA = "fascicle-record/1"

# strict: text is no number; JSON has no infinity
_Real = Annotated[float, Field(strict=True, allow_inf_nan=False)]


def _check_encoding(text: str) -> str:
    """The `text`, if UTF-8 can hold it; else `ValueError`, before any work on the record."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        sign = f"{text[error.start]!a}"
        raise ValueError(f"has half a character, {sign}: remove it") from None
    return text


_Text = Annotated[StrictStr, AfterValidator(_check_encoding)]


class SourceTable(TableModel):
    """A file that the readings were read from."""

    name: _Text = Field(description="name of the file")
    sha256: StrictStr = Field(
        description="SHA-256 of its bytes, hexadecimal", pattern="^[0-9a-f]{64}$"
    )


class RecordTable(TableModel):
    """Schema of a record's JSON file: readings of one muscle, in the order taken, in SI units."""

    schema_: Literal["fascicle-record/1"] = Field(
        alias="schema", description="version of this schema", examples=[f'"{SCHEMA}"']
    )
    synthetic: StrictBool = Field(description="true if a model made the readings")
    rest_length: Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)] | None = Field(
        None, description="length that strains refer to [m]"
    )
    sources: list[SourceTable] = Field(
        default_factory=list[SourceTable], description="files that the readings were read from"
    )
    notes: list[_Text] = Field(
        default_factory=list[str], description="assumptions and changes, and what was measured"
    )
    pressure: list[Annotated[_Real, Field(ge=0, le=HIGHEST_PRESSURE)]] = Field(
        description="gauge pressure [Pa]", min_length=1
    )
    strain: list[Annotated[_Real, Field(ge=STRAINS[0], le=STRAINS[1])]] = Field(
        description="contraction over the rest length [-]"
    )
    force: list[_Real] = Field(description="force, positive where the muscle pulls [N]")
    censored: list[StrictBool] = Field(
        default_factory=list[bool],
        description="true for a force that is an upper bound, as of a load cell that can't push;"
        " empty: none is",
    )
    branch: list[Literal[-1, 0, 1]] = Field(
        default_factory=list[Literal[-1, 0, 1]],
        description="1 inflating or contracting, -1 deflating or extending, 0 or empty: unknown",
    )
    time: list[_Real] | None = Field(None, description="time [s]")
    moment_arm: list[_Real] | None = Field(
        None, description="moment arm of the muscle on the joint whose torque was measured [m]"
    )


def json_schema() -> dict[str, Any]:
    """JSON schema of a file, draft 2020-12."""
    schema = RecordTable.model_json_schema()
    schema["title"] = SCHEMA
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def to_json(record: Record) -> str:
    """Text of a JSON file that reads back to an equal record, to the bit.

    **Raises:** `ValueError` in one line for a record that the schema doesn't allow.
    """
    columns = {name: getattr(record, name) for name in (*COLUMNS, *OPTIONAL_COLUMNS)}
    fields = {name: values.tolist() for name, values in columns.items() if values is not None}
    for name in ("censored", "branch"):
        fields[name] = fields[name] if any(fields[name]) else []
    length = None if record.rest_length is None else float(record.rest_length)
    fields |= {"schema": SCHEMA, "synthetic": bool(record.synthetic), "rest_length": length}
    fields |= {"sources": list(map(vars, record.sources)), "notes": list(record.notes)}
    table = _validate(fields, "the record").model_dump(by_alias=True, exclude_defaults=True)
    lines = (
        f"  {json.dumps(key)}: {json.dumps(value, ensure_ascii=False, allow_nan=False)}"
        for key, value in table.items()
    )
    return "{\n" + ",\n".join(lines) + "\n}\n"


def from_json(raw: str | bytes, source: str) -> Record:
    """Record of a JSON file; `source`: its name in errors.

    **Raises:** `ValueError` in one line for another version, and for contents that aren't valid.
    """
    try:
        data = json.loads(raw)
    except RecursionError:
        raise ValueError(f"{source}: no record of {SCHEMA}: it is nested too deep.") from None
    except ValueError as error:
        remedy = "if it is a log of nested objects, export its readings as CSV"
        raise ValueError(f"{source}: no valid JSON: {error}: {remedy}.") from None
    version = data.get("schema") if isinstance(data, dict) else None
    if version is None:
        rule = f"missing, so it is no record of {SCHEMA}: export its readings as CSV"
        raise ValueError(f"{source}: schema: {rule}.")
    if version != SCHEMA:
        rule = f"this fascicle reads {SCHEMA}: choose that, or install a newer fascicle."
        raise FileError(source, ["schema"], rule, version)
    table = _validate(data, source)
    optional = {name: getattr(table, name) for name in OPTIONAL_COLUMNS}
    return Record.of(
        table.pressure, table.strain, table.force, table.censored or None, table.branch or None,
        rest_length=table.rest_length, synthetic=table.synthetic, notes=tuple(table.notes),
        sources=tuple(Source(entry.name, entry.sha256) for entry in table.sources),
        **{n: None if values is None else np.array(values) for n, values in optional.items()},
    )  # fmt: skip


def _validate(data: Any, source: str) -> RecordTable:
    """Check the data of a JSON file; `ValueError` names file and key of an invalid value."""
    table = validate(RecordTable, data, source)
    for name in (*COLUMNS, *OPTIONAL_COLUMNS):
        values = getattr(table, name)
        if values is None or (name in ("censored", "branch") and not values):
            continue
        if len(values) != len(table.pressure):
            rule = f"has {len(values)} values, but pressure has {len(table.pressure)}."
            raise FileError(source, [name], rule)
    return table


def write(record: Record, path: str | os.PathLike[str]) -> None:
    """Write a record, completely or not at all.

    **Arguments:**

    - `record`: the readings.
    - `path`: the file, CSV, or JSON of the schema `fascicle-record/1` if its name ends in .json;
      an existing file is replaced.

    **Raises:** `OSError` if the file can't be written; `ValueError` for a record that the schema
    doesn't allow.
    """
    write_text(path, file_text(record, path))


def file_text(record: Record, path: str | os.PathLike[str]) -> str:
    """Text of a record for a file: JSON if the name of its `path` ends in .json, else CSV."""
    return to_json(record) if os.fspath(path).lower().endswith(".json") else dumps(record)

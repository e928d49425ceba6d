"""The TOML file beside a table, or `sidecar`: what the table's header can't say.

```toml
rest_length = "300 mm"
pressure = "200 kPa"                  # of all readings; length, strain, displacement, force too
displacement_at_rest = "12.5 mm"      # the displacement's reading at the rest length
clipped_at_zero = true                # readings of exactly zero are clipped

[columns]                             # a header that isn't recognized
force = "Load cell 2"
```

The page *records* of the docs has all keys. Arguments of `load` are checked by the same schema.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    PlainValidator,
    StrictBool,
    StrictInt,
    StrictStr,
    ValidationError,
    model_validator,
)

from ..core.errors import InvalidInputError
from ..core.findings import Finding
from ..io.input_file import parse_toml, read_bytes
from ..table_model import TableModel, validate
from ..units import parse, to_si
from .headers import CONSTANTS, Scale, check_roles, dimension_of, read_scale, si_unit, split_names
from .joint import ArmTable, read_arm_table
from .record import note


_MAX_SIZE = 1_000_000  # bytes
_ARGUMENTS = "arguments"  # context of a check: bare numbers are in SI units
_POSITIVE = ("rest_length", "moment_arm", "resample")
# gauges that may be off by a constant, and the joint's angle at rest
_ZEROS = ("pressure", "force", "torque", "displacement", "angle")


def _read_number(value: Any, info: Any) -> Any:
    """Number [SI] of a key, or the table of moment arms."""
    name, is_bare = info.field_name, info.context == _ARGUMENTS
    if name == "moment_arm" and isinstance(value, Mapping | ArmTable):
        return value if isinstance(value, ArmTable) else read_arm_table(value, bare=is_bare)
    role = {"atmosphere": "pressure", "resample": "time"}.get(name, name.removesuffix("_at_rest"))
    if name != role and (scale := info.data.get("scales", {}).get(role)):
        value = scale.zero(value)
        is_bare = is_bare or isinstance(value, float)
    if is_bare:
        number = float(to_si(value, name, si_unit(role)))
    else:
        number = parse(value, dimension_of(role), name)
    if not np.isfinite(number) or (name in _POSITIVE and number <= 0):
        rule = f"must be {'positive and ' if name in _POSITIVE else ''}finite"
        raise InvalidInputError(name, rule, number, shown=f"{number} {si_unit(role)}")
    return number


def _by_role(table: Any, info: Any) -> dict[str, Any]:
    """A table by role, with the scales of signals read."""
    if not isinstance(table, dict):
        raise ValueError("must be a table of keys")
    check_roles(table, info.field_name)
    if info.field_name == "scales":
        scales = {
            role: read_scale(x, role) for role, x in table.items() if not isinstance(x, Scale)
        }
        table = table | scales
    return table


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


_Contraction = Literal["contraction positive", "extension positive"]
_TextsByRole = Annotated[dict[str, StrictStr], BeforeValidator(_by_role)]
_Number = Annotated[float | None, PlainValidator(_read_number)]


class Signs(TableModel):
    """`[signs]`: the direction in which the file counts."""

    force: Literal["pulling positive", "pushing positive"] | None = None
    strain: _Contraction | None = None
    displacement: _Contraction | None = None
    angle: _Contraction | None = None

    def sign(self, role: str) -> int | None:
        """1 or −1 for a role, or `None`."""
        negative = {None: None, "pushing positive": -1, "extension positive": -1}
        return negative.get(getattr(self, role, None), 1)


class Sidecar(TableModel):
    """Keys of the file; quantities in SI units, `names`: a list of columns in their order."""

    scales: Annotated[dict[str, Scale], BeforeValidator(_by_role)] = Field(default_factory=dict)
    rest_length: _Number = None
    pressure: _Number = None
    force: _Number = None
    torque: _Number = None
    strain: _Number = None
    length: _Number = None
    displacement: _Number = None
    angle: _Number = None
    moment_arm: Annotated[float | ArmTable | None, PlainValidator(_read_number)] = None
    pressure_at_rest: _Number = None
    force_at_rest: _Number = None
    torque_at_rest: _Number = None
    angle_at_rest: _Number = None
    displacement_at_rest: _Number = None
    atmosphere: _Number = None
    resample: _Number = None
    clipped_at_zero: StrictBool | None = None
    columns: _TextsByRole = Field(default_factory=dict)
    names: Annotated[tuple[str, ...], BeforeValidator(split_names)] = ()
    units: _TextsByRole = Field(default_factory=dict)
    signs: Signs = Signs()
    rows: StrictStr | None = None
    header: StrictInt | None = None
    decimal: Literal[".", ","] | None = None
    table: StrictStr | None = None
    synthetic: StrictBool = False
    source: StrictStr | None = None
    notes: Annotated[list[StrictStr], BeforeValidator(_as_list)] = Field(default_factory=list)

    @model_validator(mode="before")
    @classmethod
    def _name_columns(cls, data: Any) -> Any:
        """Move `columns` in their order, text or a list, to `names`."""
        if isinstance(columns := data.get("columns"), str | list):
            data = {k: v for k, v in data.items() if k != "columns"} | {"names": columns}
        return data

    @property
    def constants(self) -> dict[str, float]:
        """Values that all readings of the file share [SI], by role."""
        values = {role: getattr(self, role) for role in CONSTANTS}
        return {role: value for role, value in values.items() if isinstance(value, float)}

    @property
    def arm_table(self) -> ArmTable | None:
        """Moment arms by angle, if a table was given."""
        return self.moment_arm if isinstance(self.moment_arm, ArmTable) else None

    def overruled(self, arguments: Mapping[str, Any]) -> "Sidecar":
        """The information, overruled by `arguments` of `load`; the error names an invalid one."""
        data = {name: value for name, value in arguments.items() if value is not None}
        if unknown := data.keys() - Sidecar.model_fields.keys() - {"constants", "zeros"}:
            raise TypeError(f"unexpected arguments: {', '.join(sorted(unknown))}")
        choices = {"constants": CONSTANTS, "zeros": _ZEROS, "signs": tuple(Signs.model_fields)}
        tables = {argument: data.pop(argument, {}) for argument in choices}
        for argument, roles in choices.items():
            check_roles(tables[argument], argument, roles)
        if not isinstance(columns := data.get("columns", {}), Mapping):
            data |= {"names": columns, "columns": {}}
        for argument in ("columns", "units", "scales"):
            data[argument] = {**getattr(self, argument), **data.get(argument, {})}
        full = {role: f"{str(text).removesuffix('positive').strip()} positive"
                for role, text in tables["signs"].items()}  # fmt: skip
        data["signs"] = self.signs.model_dump(exclude_none=True) | full
        data |= tables["constants"] | {f"{role}_at_rest": x for role, x in tables["zeros"].items()}
        former = {name: getattr(self, name) for name in self.model_fields_set}
        try:
            return Sidecar.model_validate(former | data, context=_ARGUMENTS)
        except ValidationError as error:
            fault = error.errors(include_url=False)[0]
        if isinstance(cause := fault.get("ctx", {}).get("error"), ValueError):
            raise cause
        name, *keys = map(str, fault["loc"])
        rule = " ".join(["of", *keys] if keys else [])
        rule = f"{rule} {fault['msg'].replace('Input should be', 'must be')}".strip()
        raise InvalidInputError(name, rule, fault["input"])


def read_sidecar(path: str | os.PathLike[str]) -> Sidecar:
    """Read a sidecar file; `ValueError` names file and key of an invalid value."""
    return validate(Sidecar, _read_tables(Path(path)), str(path))


def sidecar_beside(path: Path) -> tuple[Sidecar, list[Finding]]:
    """The sidecar of a table's own name, empty if there is none, and a finding on it."""
    toml = path.with_suffix(".toml")
    if toml == path or not toml.is_file():
        return Sidecar(), []
    data = _read_tables(toml)
    if {"muscle", "bundle"} & set(data):
        # a calibrated muscle's file may have its record's name
        return Sidecar(), [note("sidecar_of_muscle", sidecar=toml.name)]
    return validate(Sidecar, data, str(toml)), [note("sidecar_beside", sidecar=toml.name)]


def _read_tables(path: Path) -> dict[str, Any]:
    """Read the tables of a TOML file."""
    raw = read_bytes(path, _MAX_SIZE, "record's TOML")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file; this one is TOML in UTF-8.") from None
    return parse_toml(text, str(path))

"""The TOML file beside a table, or `sidecar`: what the table's header can't say.

```toml
rest_length = "300 mm"
pressure = "200 kPa"                  # of all readings; length, strain, displacement, force too
displacement_at_rest = "12.5 mm"      # the displacement's reading at the rest length
clipped_at_zero = true                # readings of exactly zero are clipped

[columns]                             # a header that isn't recognized
force = "Load cell 2"
```

The page *records* of the docs has all keys.
"""

import contextlib
import os
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainValidator,
    StrictBool,
    StrictInt,
    StrictStr,
    model_validator,
)

from ..io.input_file import parse_toml, read_bytes
from ..table_model import Quantity, TableModel, validate
from ..units import parse
from .headers import CONSTANTS, Scale, check_roles, read_scale, si_unit, split_names
from .joint import ArmTable, read_arm_table


_MAX_SIZE = 1_000_000  # bytes
_NEGATIVE = ("pushing positive", "extension positive")
# gauges that may be off by a constant, and the joint's angle at rest
ZEROS = ("pressure", "force", "torque", "displacement", "angle")


def _check_roles(table: dict[str, str], info: Any) -> dict[str, str]:
    """Refuse keys of a `table` that are no roles."""
    check_roles(table, str(info.field_name))
    return table


def _as_list(value: Any) -> Any:
    """A single text as a list of one text; other values as they are."""
    return [value] if isinstance(value, str) else value


def _arm_or_table(value: Any) -> Any:
    """Moment arm [m], or a table of moment arms by angle."""
    if isinstance(value, dict):
        return read_arm_table(value, bare=False)
    if (arm := parse(value, "length", "moment_arm")) <= 0:
        raise ValueError("must be positive")
    return arm


def _read_scales(table: Any) -> dict[str, Scale]:
    """Scales of signals by role."""
    if not isinstance(table, dict):
        raise ValueError("must be a table of keys")
    check_roles(table, "scales")
    return {role: read_scale(text, role) for role, text in table.items()}


Contraction = Literal["contraction positive", "extension positive"]
TextsByRole = Annotated[dict[str, StrictStr], AfterValidator(_check_roles)]
Pressure = Annotated[float, Quantity("pressure")]
Length = Annotated[float, Quantity("length")]
Force = Annotated[float, Quantity("force")]
Torque = Annotated[float, Quantity("moment")]
Angle = Annotated[float, Quantity("angle")]


class Signs(TableModel):
    """`[signs]`: the direction in which the file counts."""

    force: Literal["pulling positive", "pushing positive"] | None = None
    strain: Contraction | None = None
    displacement: Contraction | None = None
    angle: Contraction | None = None

    def sign(self, role: str) -> int | None:
        """1 or −1 for a role, or `None`."""
        direction = getattr(self, role, None)
        return None if direction is None else -1 if direction in _NEGATIVE else 1


class Sidecar(TableModel):
    """Keys of the file; quantities in SI units, `names`: a list of columns in their order."""

    rest_length: Annotated[float, Quantity("length"), Field(gt=0)] | None = None
    pressure: Pressure | None = None
    force: Force | None = None
    torque: Torque | None = None
    strain: Annotated[float, Quantity("strain")] | None = None
    length: Length | None = None
    displacement: Length | None = None
    angle: Angle | None = None
    moment_arm: Annotated[float | ArmTable | None, PlainValidator(_arm_or_table)] = None
    pressure_at_rest: Pressure | None = None
    force_at_rest: Force | None = None
    torque_at_rest: Torque | None = None
    angle_at_rest: Angle | None = None
    displacement_at_rest: Length | None = None
    atmosphere: Pressure | None = None
    clipped_at_zero: StrictBool | None = None
    columns: TextsByRole = Field(default_factory=dict)
    names: Annotated[tuple[str, ...], BeforeValidator(split_names)] = ()
    units: TextsByRole = Field(default_factory=dict)
    scales: Annotated[dict[str, Scale], BeforeValidator(_read_scales)] = Field(default_factory=dict)
    signs: Signs = Signs()
    resample: Annotated[float, Quantity("time"), Field(gt=0)] | None = None
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
        """Move `columns` in their order, text or a list, to `names`; read zeros of signals."""
        if isinstance(columns := data.get("columns"), str | list):
            data = {k: v for k, v in data.items() if k != "columns"} | {"names": columns}
        scales = data.get("scales")
        for role, text in scales.items() if isinstance(scales, dict) else ():
            key = f"{role}_at_rest"
            # an invalid scale is refused where it stands
            with contextlib.suppress(ValueError):
                if key in data and isinstance(
                    zero := read_scale(text, role).zero(data[key]), float
                ):
                    data = data | {key: f"{zero!r} {si_unit(role)}"}
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


def read_sidecar(path: str | os.PathLike[str]) -> Sidecar:
    """Read a sidecar file; `ValueError` names file and key of an invalid value."""
    return validate(Sidecar, _read_tables(Path(path)), str(path))


def sidecar_beside(path: Path) -> tuple[Sidecar, tuple[str, ...]]:
    """The sidecar of a table's own name, empty if there is none, and a note of it."""
    toml = path.with_suffix(".toml")
    if toml == path or not toml.is_file():
        return Sidecar(), ()
    data = _read_tables(toml)
    if {"muscle", "bundle"} & set(data):
        # a calibrated muscle's file may have its record's name
        return Sidecar(), (f"{toml.name} beside it not read: it describes a muscle",)
    return validate(Sidecar, data, str(toml)), (f"{toml.name} beside it read",)


def _read_tables(path: Path) -> dict[str, Any]:
    """Read the tables of a TOML file."""
    raw = read_bytes(path, _MAX_SIZE, "record's TOML")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file; this one is TOML in UTF-8.") from None
    return parse_toml(text, str(path))

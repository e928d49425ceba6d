"""Options with which commands read measured records, and the reading."""

from typing import TYPE_CHECKING, Any

from .errors import UserError, user_errors
from .options import argument, flag, option


if TYPE_CHECKING:
    from ..records.record import Record


DATA = argument(
    "DATA",
    "Files of a dynamometer, or patterns such as 'runs/*.csv', all of one muscle: text, .xlsx,"
    " .mat, .tdms or published .json with pressure, force, and strain, length or displacement; or"
    " torque and angle of a joint.",
)
REST_LENGTH = option(
    "Reference length of strains and displacements; default: the file's, else the muscle's.",
    metavar="LENGTH",
)
UNIT = option("Unit of a column whose header has none: force=N; repeatable.", metavar="ROLE=UNIT")
COLUMN = option(
    "Header of an unrecognized column, with a ROLE as in --columns: force='Load cell 2';"
    " repeatable.",
    metavar="ROLE=HEADER",
)
COLUMNS = option(
    "Columns in order, for files without a header: force[N],pressure[kPa],-,length[mm]; - skips"
    " one; also strain, displacement, torque, angle, moment_arm, time, branch, clipped.",
    metavar="NAMES",
)
HEADER = option(
    "Number of the line that names the columns; default: detected.", metavar="LINE", min=1
)
ROWS = option(
    "Rows to read, counted from 1 below the header: 40:200, or 40: for all from row 40 on.",
    metavar="FIRST:LAST",
)
DECIMAL = option(
    "Decimal separator, . or , (the other may separate thousands); default: detected.",
    metavar="SIGN",
)
TABLE = option(
    "Sheet (.xlsx), matrix (.mat) or group (.tdms) of a file that has several; '*' for all.",
    metavar="NAME",
)
PRESSURE = option("Pressure of all readings of the files.", metavar="PRESSURE")
CONSTANT = option(
    "Constant of all readings: length=167mm, force=2kgf; repeatable.", metavar="ROLE=VALUE"
)
NAME_PATTERN = option(
    "Pattern of names of files or tables, with constants: {length}cm_{pressure}kPa, * for other"
    " text.",
    metavar="PATTERN",
)
ZERO = option(
    "Reading of a gauge at zero or at rest: force=8N, pressure=1.5kPa, displacement=2mm,"
    " torque=0.1Nm, angle=10deg; repeatable.",
    metavar="ROLE=VALUE",
)
SCALE = option(
    "Quantity of a gauge's signal: pressure=1.475bar/V, force=12N/V; --zero may be a signal then:"
    " pressure=0.2V; repeatable.",
    metavar="ROLE=VALUE/UNIT",
)
RESAMPLE = option(
    "Step of one clock, for channels that have clocks of their own: 0.1s.", metavar="TIME"
)
SIGN = option(
    "Positive direction of a column: displacement=extension, angle=extension; repeatable.",
    metavar="ROLE=DIRECTION",
)
MOMENT_ARM = option(
    "Moment arm of the muscle about the joint whose torque was measured; a table of arms by angle"
    " goes into the TOML file beside the record.",
    metavar="LENGTH",
)
ATMOSPHERE = option("Atmosphere to subtract from absolute pressures.", metavar="PRESSURE")
CLIPPED_AT_ZERO = flag(
    "Clipping at zero: a force of exactly 0 means 0 or less.", "--clipped-at-zero"
)
PUSH_POSITIVE = flag("Sign of the file's forces: positive for a push.", "--push-positive")


def read_pairs(texts: list[str] | None, name: str) -> dict[str, str]:
    """Read values by name of an option's `NAME=VALUE`s."""
    pairs: dict[str, str] = {}
    for text in texts or []:
        key, _, value = map(str.strip, text.partition("="))
        if not key or not value:
            raise UserError(f"{name} {text!r}: write NAME=VALUE.")
        if key in pairs:
            raise UserError(f"{name} {text!r}: {key} was given twice: give it once.")
        pairs[key] = value
    return pairs


def read_options(
    unit: list[str] | None = None,
    column: list[str] | None = None,
    columns: str | None = None,
    pressure: str | None = None,
    constant: list[str] | None = None,
    zero: list[str] | None = None,
    scale: list[str] | None = None,
    sign: list[str] | None = None,
    *,
    clipped_at_zero: bool = False,
    push_positive: bool = False,
    **settings: Any,
) -> dict[str, Any]:
    """Arguments of `records.load` from the texts of the options of this module."""
    headers = read_pairs(column, "--column")
    if columns is not None and headers:
        raise UserError("--columns names all columns: leave out --column.")
    constants = read_pairs(constant, "--constant")
    signs = read_pairs(sign, "--sign")
    return settings | {
        "columns": headers if columns is None else columns,
        "units": read_pairs(unit, "--unit"),
        "constants": constants | ({} if pressure is None else {"pressure": pressure}),
        "zeros": read_pairs(zero, "--zero"),
        "scales": read_pairs(scale, "--scale"),
        "signs": signs | ({"force": "pushing"} if push_positive else {}),
        "clipped_at_zero": clipped_at_zero or None,
    }


def read_record(paths: list[str], options: dict[str, Any], length: float | None = None) -> "Record":
    """Read one record from files.

    **Arguments:**

    - `paths`: files and patterns.
    - `options`: arguments of `records.load`.
    - `length`: of the muscle at rest [m], for files that name no rest length; left out, they are
      refused.
    """
    from ..records import load
    from ..records.headers import MissingMetadataError

    with user_errors():
        try:
            return load(paths, **options, default_length=length)
        except MissingMetadataError as error:
            raise ValueError(error.message(_record_option)) from None


def _record_option(argument: str, role: str, value: str) -> str:
    """An argument of `records.load` as options of the command line."""
    if argument == "constants" and role == "pressure":
        return f"--pressure '{value}'"
    name = argument.removesuffix("s") if role else argument
    text = value.removesuffix(" positive") if argument == "signs" else value
    setting = f" {role}='{text}'" if role else f" '{text}'" if text else ""
    return f"--{name.replace('_', '-')}{setting}"

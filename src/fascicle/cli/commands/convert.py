"""`fascicle convert`: a measured record of any format as CSV, or as JSON for publication."""

import json

from .. import options, reading
from ..errors import user_errors
from ..options import option
from ..outputs import check_file, print_line, write_text


def run(
    data: list[str] = reading.DATA,
    out: str = option(
        "Result file: .json of the schema fascicle-record/1, or .csv.",
        "--out -o",
        metavar="PATH",
        default=...,
    ),
    rest_length: str | None = reading.REST_LENGTH,
    unit: list[str] | None = reading.UNIT,
    column: list[str] | None = reading.COLUMN,
    columns: str | None = reading.COLUMNS,
    header: int | None = reading.HEADER,
    rows: str | None = reading.ROWS,
    table: str | None = reading.TABLE,
    decimal: str | None = reading.DECIMAL,
    pressure: str | None = reading.PRESSURE,
    constant: list[str] | None = reading.CONSTANT,
    name_pattern: str | None = reading.NAME_PATTERN,
    zero: list[str] | None = reading.ZERO,
    scale: list[str] | None = reading.SCALE,
    resample: str | None = reading.RESAMPLE,
    sign: list[str] | None = reading.SIGN,
    atmosphere: str | None = reading.ATMOSPHERE,
    moment_arm: str | None = reading.MOMENT_ARM,
    clipped_at_zero: bool = reading.CLIPPED_AT_ZERO,
    push_positive: bool = reading.PUSH_POSITIVE,
    overwrite: bool = options.OVERWRITE,
    as_json: bool = options.JSON,
) -> None:
    """Convert a record of any format to CSV, or to JSON to publish."""
    check_file("--out", out, overwrite, (".json", ".csv"))
    settings = reading.read_options(
        unit, column, columns, pressure, constant, zero, scale, sign, resample=resample,
        clipped_at_zero=clipped_at_zero, push_positive=push_positive, rest_length=rest_length,
        header=header, rows=rows, table=table, decimal=decimal, name_pattern=name_pattern,
        atmosphere=atmosphere, moment_arm=moment_arm,
    )  # fmt: skip
    record = reading.read_record(data, settings)
    from ...records.published import file_text

    with user_errors():
        text = file_text(record, out)
    write_text("--out", out, overwrite, text)
    if as_json:
        print(json.dumps({"path": out, "readings": len(record), "notes": list(record.notes)}))
        return
    print_line(f"wrote {out}: {len(record)} readings")
    for note in record.notes:
        print_line(f"  {note}")


COMMANDS = {"convert": run}

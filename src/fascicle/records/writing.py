"""A record as a tidy CSV that reads back to the same floats.

What no column can say stands above them in remarks: the rest length, where the readings came
from, and, first, that they are synthetic where no muscle was measured.
"""

import io
import os

from ..io.atomic import write_text
from ..units import exact
from .record import Record


def write(record: Record, path: str | os.PathLike[str]) -> None:
    """Write a record, whole or not at all.

    **Arguments:**

    - `record`: the readings [-].
    - `path`: the CSV [-]; a file that is there is replaced.

    **Raises:** `OSError`, one line, where nothing can be written there.
    """
    write_text(path, dumps(record))


def dumps(record: Record) -> str:
    """What such a file holds.

    **Arguments:** `record`: the readings [-].

    **Returns:** the text [-].
    """
    columns = {
        "pressure [Pa]": record.pressure, "strain [-]": record.strain, "force [N]": record.force,
    }  # fmt: skip
    if record.time is not None:
        columns["time [s]"] = record.time
    if record.branch.any():
        columns["branch"] = record.branch
    if record.censored.any():
        columns["clipped"] = record.censored.astype(int)
    out = io.StringIO()
    for key, value in _remarks(record):
        out.write(f"# {key}: {' '.join(value.split())}\n")
    out.write(",".join(columns) + "\n")
    # Python's own text of a float is the shortest that reads back to it
    texts = (map(repr, column.tolist()) for column in columns.values())
    out.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))
    return out.getvalue()


def _remarks(record: Record) -> list[tuple[str, str]]:
    remarks = []
    if record.synthetic:
        remarks.append(("synthetic", "a model made these readings, no muscle was measured"))
    if record.rest_length is not None:
        remarks.append(("rest_length", exact(record.rest_length, "length")))
    remarks += [("source", f"{source.name} sha256 {source.sha256}") for source in record.sources]
    return remarks + [("note", note) for note in record.notes]

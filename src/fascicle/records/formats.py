"""Files of instruments as text tables: text as it is, .xlsx, .mat and .tdms by a process apart."""

import fnmatch
import json
import os
import subprocess
import sys
from typing import Any

from ..core.errors import require
from .headers import MissingMetadataError
from .tables import has_readings


# first bytes of files that can't be read, and what to do
_REMEDIES = {
    b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1": "an Excel file of before 2007: save it as .xlsx or CSV",
    b"\x89HDF\r\n\x1a\n": "an HDF5 file; if MATLAB wrote it, save it with save(…, '-v7')",
    b"\x1f\x8b": "a compressed file: unpack it, or export its readings as CSV",
    b"%PDF": "a PDF: export the readings as CSV",
    **dict.fromkeys(
        (b"<html", b"<!doctype", b"<table", b"<?xml"), "a web page or XML: save it as .xlsx or CSV"
    ),
}
_LIBRARIES = {"xlsx": "openpyxl", "tdms": "nptdms", "mat": "scipy"}
_TIME = 60  # s of a reader: a million cells of a sheet take ten


def table_texts(raw: bytes, source: str, table: str | None = None) -> dict[str, bytes]:
    """Text of a file's table, or of several, by name; a text file is one without name.

    **Arguments:**

    - `raw`: the file's bytes; `source`: its name in errors.
    - `table`: name of the sheet, matrix or group, or a pattern such as `"*"` for all with readings
      that it fits; default: the one with readings.

    **Raises:** `ValueError` for a file that can't be read; `MissingExtraError` if its library isn't
    installed.
    """
    beginning = raw[:64].lstrip().lower()
    for start, remedy in _REMEDIES.items():
        if beginning.startswith(start.lower()):
            raise ValueError(f"{source}: {remedy}.")
    if raw.startswith(b"PK\3\4"):
        tables = _read_apart("xlsx", raw, source)
    elif raw.startswith(b"TDSm"):
        tables = _read_apart("tdms", raw, source)
    elif raw.startswith(b"MATLAB") or (source.lower().endswith(".mat") and b"\0" in raw):
        tables = _read_apart("mat", raw, source)
    elif table is not None:
        raise ValueError(
            f"{source}: no table `{table}`: a text file holds one, leave the name out."
        )
    else:
        return {"": raw}
    names = [name for name in tables if table is not None and name.lower() == table.lower()]
    if not names:
        pattern = "*" if table is None else table.lower()
        fits = [name for name in tables if fnmatch.fnmatchcase(name.lower(), pattern)]
        if not fits and table is not None:
            listed = ", ".join(f"`{name}`" for name in tables) or "none"
            raise ValueError(f"{source}: no table `{table}`: there are {listed}.")
        names = [name for name in fits if has_readings(tables[name], source)]
    if not names:
        raise ValueError(f"{source}: no table of numbers in it: export the readings as CSV.")
    if len(names) > 1 and table is None:
        listed = ", ".join(f"`{name}`" for name in names)
        before = f"{source}: several tables, {listed}: choose one with "
        longest = max(names, key=lambda name: tables[name].count(b"\n"))  # others hold results
        several = ("table", "", "*", " for all, if of one muscle")
        raise MissingMetadataError(before, ("table", "", longest, ""), several)
    return {name: tables[name] for name in names}


def _read_apart(kind: str, raw: bytes, source: str) -> dict[str, bytes]:
    """Texts of a binary file's tables by name, from a process that may crash."""
    require(_LIBRARIES[kind])
    # -P: nothing is imported from the working folder, which may be that of a downloaded file
    command = [sys.executable, "-P", "-m", f"{__package__}.binary_tables", kind]
    # a thread of OpenBLAS takes memory that counts
    paths = os.pathsep.join(filter(None, sys.path))
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": paths}
    try:
        done = subprocess.run(  # noqa: S603 of this package
            command, input=raw, capture_output=True, timeout=_TIME, env=environment, check=False
        )
        reason = "its reader crashed"
        answer: dict[str, Any] = {"error": reason}
        answer = json.loads(done.stdout) if done.returncode == 0 else answer
    except subprocess.TimeoutExpired:
        answer = {"error": f"it takes longer than {_TIME} s"}
    if "error" in answer:
        remedy = "save it again, for .mat with save(…, '-v7'), or export its readings as CSV"
        raise ValueError(f"{source}: can't be read as .{kind}: {answer['error']}: {remedy}.")
    return {name: text.encode() for name, text in answer["tables"].items()}

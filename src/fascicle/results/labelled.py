"""Results as labelled arrays: files as netCDF, CSV or JSON; the last two need only NumPy."""

import csv
import errno
import io
import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..io.atomic import check_writable
from ..io.atomic import write as write_whole


if TYPE_CHECKING:
    import xarray

SUFFIXES = (".nc", ".csv", ".json")  # of results, by which the format is chosen


class Variable(NamedTuple):
    """Values over named dimensions. A variable named for its own dimension is a coordinate."""

    dims: tuple[str, ...]
    values: Any
    unit: str
    about: str = ""
    source: str = ""


def dataset(variables: Mapping[str, Variable], **attributes: str) -> "xarray.Dataset":
    """Labelled dataset of variables by name; `attributes`: of the whole: `title`, `source`."""
    import xarray

    data: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for name, variable in variables.items():
        labels = {
            "units": variable.unit if variable.unit not in ("", "-") else "1",
            "long_name": variable.about or name.replace("_", " "),
            "source": variable.source or attributes.get("source", ""),
        }
        values = np.asarray(variable.values)
        # text of any length
        values = values.astype(object) if values.dtype.kind == "U" else values
        group = coordinates if variable.dims == (name,) else data
        group[name] = (variable.dims, values, labels)
    return xarray.Dataset(data, coordinates, attributes)


def to_json(
    variables: Mapping[str, Variable], findings: Sequence[Mapping[str, Any]] | None = None
) -> str:
    """JSON object of nested lists by variable, and of `findings`; numbers that aren't finite are
    null.
    """
    lists: dict[str, Any] = {} if findings is None else {"findings": findings}
    for name, variable in variables.items():
        values = np.asarray(variable.values)
        if values.dtype.kind == "f":
            values = np.where(np.isfinite(values), values.astype(object), np.array(None))
        lists[name] = values.tolist()
    return json.dumps(lists, allow_nan=False)


def to_csv(variables: Mapping[str, Variable]) -> str:
    """CSV of variables, with `name [unit]` as headings and a row for each point of the first one
    that is no coordinate. A variable with one more dimension takes a column for each index along
    it; others are omitted.
    """
    first = next(iter(variables.values()))
    main = next((v for name, v in variables.items() if v.dims != (name,)), first)
    dims, shape = main.dims, np.shape(main.values)
    columns: dict[str, list[Any]] = {}
    for name, variable in variables.items():
        extra = [dim for dim in variable.dims if dim not in dims]
        if len(extra) > 1 or (extra and len(variable.dims) == 1):
            continue
        values = np.asarray(variable.values)
        axes = [dims.index(dim) for dim in variable.dims if dim in dims]
        slices = np.moveaxis(values, variable.dims.index(extra[0]), 0) if extra else values[None]
        absent = [axis for axis in range(len(dims)) if axis not in axes]
        for index, selection in enumerate(slices, 1):
            label = f"{name}_{index}" if extra else name
            expanded = np.expand_dims(np.transpose(selection, np.argsort(axes)), absent)
            column = np.broadcast_to(expanded, shape).ravel().tolist()
            columns[f"{label} [{variable.unit or '-'}]"] = column
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(columns)
    table.writerows(zip(*columns.values(), strict=True))
    return out.getvalue()


def write(
    variables: Mapping[str, Variable],
    path: str | os.PathLike[str],
    findings: Sequence[Mapping[str, Any]] | None = None,
    **attributes: str,
) -> None:
    """Write variables, completely or not at all, in the format of the file's suffix.

    `path` ends in `.nc`, `.csv` or `.json`; an existing file is replaced. `findings`: for
    JSON; `attributes`: as for `dataset`. Raises `ValueError` for another suffix, `OSError` if it
    can't be written.
    """
    suffix = check_result_path(path).suffix.lower()
    fill: Mapping[str, Callable[[Path], object]] = {
        ".nc": lambda draft: write_netcdf(dataset(variables, **attributes), draft),
        ".csv": lambda draft: draft.write_text(to_csv(variables), encoding="utf-8"),
        ".json": lambda draft: draft.write_text(f"{to_json(variables, findings)}\n", "utf-8"),
    }
    write_whole(path, fill[suffix])


class Table(dict[str, Variable]):
    """Variables by name, in their order; it prints as a list of them."""

    dataset = dataset
    to_csv = to_csv
    to_json = to_json
    write = write

    def __repr__(self) -> str:
        """A line for each variable: name, unit, dimensions, meaning."""
        rows = []
        for name, (dims, values, unit, about, _) in self.items():
            sizes = zip(dims, np.shape(values), strict=True)
            shape = " × ".join(f"{dim} {size}" for dim, size in sizes)
            rows.append((name, f"[{unit or '-'}]", shape, about))
        a, b, c = (max((len(row[i]) for row in rows), default=0) for i in range(3))
        lines = (f"{row[0]:{a}}  {row[1]:{b}}  {row[2]:{c}}  {row[3]}" for row in rows)
        return "\n".join(line.rstrip() for line in lines)


def build_table(*rows: tuple[Any, ...]) -> Table:
    """Table from rows of name, dimensions in one text, values, unit and meaning."""
    table = Table()
    for name, dims, values, *texts in rows:
        table[name] = Variable(tuple(dims.split()), np.asarray(values), *texts)
    return table


def write_netcdf(data: "xarray.Dataset", path: Path) -> None:
    """Write a dataset as netCDF; `OSError` if it can't be written."""
    try:
        data.to_netcdf(path, engine="netcdf4")
    # netCDF4's own, for any failure of the system; a full disk is also "Permission denied"
    except (RuntimeError, PermissionError) as error:
        raise OSError(errno.EIO, f"no space left on the disk, or {error}") from None


def check_result_path(path: str | os.PathLike[str]) -> Path:
    """Refuse a path that no result can be written to, before the work begins; errors as `write`."""
    name = os.fspath(path)
    if Path(name).suffix.lower() not in SUFFIXES:
        raise ValueError(f"{name!r}: a result's name must end in {', '.join(SUFFIXES)}.")
    check_writable(path)
    return Path(name)

"""Results in and out: labelled arrays as netCDF, zarr, CSV or JSON.

A result is a set of named variables, each with its dimensions, unit and meaning. It becomes
an `xarray.Dataset` when it leaves as netCDF or zarr; CSV and JSON need no more than NumPy.
"""

import csv
import errno
import importlib.util
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

SUFFIXES = (".nc", ".zarr", ".csv", ".json")
_ZARR_MARKS = ("zarr.json", ".zgroup", ".zattrs")  # of its versions 3 and 2


class Variable(NamedTuple):
    """Values over named dimensions. One named for its own dimension is a coordinate."""

    dims: tuple[str, ...]
    values: Any
    unit: str
    about: str = ""
    source: str = ""


class Table(dict[str, Variable]):
    """Variables by name, in their order; it prints as a list of them."""

    def dataset(self, **attributes: str) -> "xarray.Dataset":
        """As `xarray` has it.

        **Arguments:** `attributes`: what holds for all: `title`, `source` [-].

        **Returns:** the dataset [-], with unit, meaning and source on each variable.
        """
        return dataset(self, **attributes)

    def to_csv(self) -> str:
        """As CSV [-], a row for each point; what has more dimensions than that is left out."""
        return to_csv(self)

    def to_json(self) -> str:
        """As JSON [-]; what isn't finite is null."""
        return to_json(self)

    def write(self, path: str | os.PathLike[str], **attributes: str) -> None:
        """Write it, whole or not at all, in the format that the name's end says.

        **Arguments:**

        - `path`: ends in `.nc`, `.zarr`, `.csv` or `.json` [-]; what is there is replaced.
        - `attributes`: what holds for all: `title`, `source` [-].

        **Raises:** `ValueError` for another ending; `OSError` where it can't be written.
        """
        write(self, path, **attributes)

    def __repr__(self) -> str:
        """A line for each variable: name, unit, dimensions, meaning."""
        rows = [
            (
                name,
                f"[{one.unit or '-'}]",
                " × ".join(
                    f"{dim} {size}"
                    for dim, size in zip(one.dims, np.shape(one.values), strict=True)
                ),
                one.about,
            )
            for name, one in self.items()
        ]
        widths = [max((len(row[i]) for row in rows), default=0) for i in range(3)]
        lines = (
            "  ".join([*(x.ljust(n) for x, n in zip(row, widths, strict=False)), row[3]]).rstrip()
            for row in rows
        )
        return "\n".join(lines)


def dataset(variables: Mapping[str, Variable], **attributes: str) -> "xarray.Dataset":
    """A labelled dataset of `variables`.

    **Arguments:**

    - `variables`: by name, each in its own unit [-].
    - `attributes`: what holds for all: `title`, `source` [-].

    **Returns:** the dataset [-], with unit, meaning and source on each variable.
    """
    import xarray

    data: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for name, variable in variables.items():
        given = {
            "units": variable.unit if variable.unit not in ("", "-") else "1",
            "long_name": variable.about or name.replace("_", " "),
            "source": variable.source or attributes.get("source", ""),
        }
        home = coordinates if variable.dims == (name,) else data
        values = np.asarray(variable.values)
        # text of any length: the only kind that zarr's format specifies
        values = values.astype(object) if values.dtype.kind == "U" else values
        home[name] = (variable.dims, values, given)
    return xarray.Dataset(data, coordinates, attributes)


def to_json(variables: Mapping[str, Variable]) -> str:
    """`variables` as one JSON object of nested lists.

    **Arguments:** `variables`: by name [-].

    **Returns:** the text [-]; what isn't finite is null.
    """
    lists = {name: _finite(np.asarray(variable.values)) for name, variable in variables.items()}
    return json.dumps(lists, allow_nan=False)


def to_csv(variables: Mapping[str, Variable]) -> str:
    """`variables` as a table: a row for each point of the first one that is no coordinate.

    **Arguments:** `variables`: by name [-]; one with one more dimension takes a column for
    each place along it, one with still more is left out.

    **Returns:** the text [-], with `name [unit]` as headings.
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
        for place in range(values.shape[variable.dims.index(extra[0])] if extra else 1):
            one = values.take(place, axis=variable.dims.index(extra[0])) if extra else values
            kept = [dim for dim in variable.dims if dim in dims]
            label = f"{name}_{place + 1}" if extra else name
            columns[f"{label} [{variable.unit or '-'}]"] = _spread(one, kept, dims, shape)
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(columns)
    table.writerows(zip(*columns.values(), strict=True))
    return out.getvalue()


def write(
    variables: Mapping[str, Variable], path: str | os.PathLike[str], **attributes: str
) -> None:
    """Write `variables`, whole or not at all, in the format that the name's end says.

    **Arguments:**

    - `variables`: by name [-].
    - `path`: ends in `.nc`, `.zarr`, `.csv` or `.json` [-]; what is there is replaced.
    - `attributes`: what holds for all: `title`, `source` [-].

    **Raises:** `ValueError` for another ending; `OSError` where it can't be written.
    """
    suffix = check_result_path(path).suffix.lower()
    fill: Mapping[str, Callable[[Path], object]] = {
        ".nc": lambda draft: write_netcdf(dataset(variables, **attributes), draft),
        ".zarr": lambda draft: dataset(variables, **attributes).to_zarr(draft, consolidated=False),
        ".csv": lambda draft: draft.write_text(to_csv(variables), encoding="utf-8"),
        ".json": lambda draft: draft.write_text(to_json(variables) + "\n", encoding="utf-8"),
    }
    write_whole(path, fill[suffix], folder=suffix == ".zarr")


def write_netcdf(made: "xarray.Dataset", path: Path) -> None:
    """Write a dataset as netCDF.

    **Arguments:**

    - `made`: the dataset [-].
    - `path`: where it goes [-].

    **Raises:** `OSError` where it can't be written.
    """
    try:
        made.to_netcdf(path, engine="netcdf4")
    except RuntimeError as error:  # the library's own, for whatever the system refuses
        reason = f"{error}; is the disk full?"
        raise OSError(errno.EIO, reason) from None


def check_result_path(path: str | os.PathLike[str]) -> Path:
    """Refuse a path that no result can be written to, before there is one.

    **Arguments:** `path`: where it will go [-].

    **Returns:** the path [-].

    **Raises:** as `write`.
    """
    name = os.fspath(path)
    suffix = Path(name).suffix.lower()
    if suffix not in SUFFIXES:
        raise ValueError(f"{name!r}: a result's name must end in {', '.join(SUFFIXES)}.")
    if suffix == ".zarr":
        if importlib.util.find_spec("zarr") is None:
            install = "pip install 'fascicle[sweep]'"
            raise ValueError(f"{name!r}: .zarr needs the package zarr: {install}.")
        if Path(name).is_dir() and not any(Path(name, mark).exists() for mark in _ZARR_MARKS):
            raise ValueError(f"{name!r}: a folder that is no zarr store; it isn't replaced.")
    check_writable(path, folder=suffix == ".zarr")
    return Path(name)


def read(path: str | os.PathLike[str]) -> "xarray.Dataset":
    """Read what `write` wrote as netCDF or zarr.

    **Arguments:** `path`: ends in `.nc` or `.zarr` [-].

    **Returns:** the dataset [-], in memory.

    **Raises:** `ValueError` for another ending; `OSError` where it can't be read.
    """
    import xarray

    suffix = Path(path).suffix.lower()
    if suffix not in (".nc", ".zarr"):
        raise ValueError(f"{os.fspath(path)!r}: only .nc and .zarr can be read back.")
    how: dict[str, Any] = {"engine": "netcdf4"}
    if suffix == ".zarr":
        how = {"engine": "zarr", "consolidated": False}
    with xarray.open_dataset(path, **how) as stored:
        return stored.load()


def _spread(
    values: np.ndarray, own: Sequence[str], dims: Sequence[str], shape: tuple[int, ...]
) -> list[Any]:
    """`values` over their `own` dimensions at every point over `dims`, in order."""
    places = [dims.index(dim) for dim in own]
    ordered = np.transpose(values, np.argsort(places))
    absent = [axis for axis in range(len(dims)) if axis not in places]
    return np.broadcast_to(np.expand_dims(ordered, absent), shape).ravel().tolist()


def _finite(values: np.ndarray) -> Any:
    """Nested lists, with `None` for what JSON has no number for."""
    bad = ~np.isfinite(values) if values.dtype.kind == "f" else np.zeros(values.shape, bool)
    if np.any(bad):
        values = values.astype(object)
        values[bad] = None
    return values.tolist()

"""Measurements on one muscle, reading by reading, in SI units and one sign convention.

A reading is a gauge pressure, a contraction and a pulling force. A *censored* reading was clipped
at zero: the gauge could not push, so its force is an upper bound.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.findings import Finding, Severity
from ..core.validation import broadcast_shape
from ..units import exact


UP, DOWN, UNKNOWN = 1, -1, 0  # branches of a hysteresis loop
COLUMNS = ("pressure", "strain", "force", "censored", "branch")
OPTIONAL_COLUMNS = ("time", "moment_arm")
STRAINS = (-0.2, 0.9)  # a muscle stretched by a fifth has straight fibers


def note(code: str, **data: object) -> Finding:
    """Finding of a record that says how it was read."""
    return Finding(f"record.{code}", Severity.NOTE, data)


def warning(code: str, **data: object) -> Finding:
    """Finding of a record to check."""
    return Finding(f"record.{code}", Severity.WARNING, data)


@dataclass(frozen=True)
class Source:
    """A file that a record was read from, and the SHA-256 of its bytes."""

    name: str
    sha256: str


@dataclass(frozen=True, eq=False)
class Record:
    """Readings of one muscle, in the order in which they were taken.

    - `pressure`: gauge pressure [Pa].
    - `strain`: contraction over `rest_length` [-].
    - `force`: pulling force [N].
    - `censored`: flags of readings that are only upper bounds.
    - `branch`: 1 inflating or contracting, −1 deflating or extending, 0 unknown.
    - `time`: [s], or `None`; `file`: of several, the index of each reading's file, or `None`.
    - `rest_length`: reference length of the strains [m], or `None` if only strains were given.
    - `moment_arm`: of the muscle on the joint whose torque was measured [m], or `None`.
    - `synthetic`: true for readings of a model.
    - `sources`: the files it was read from.
    - `notes`: what people wrote of it, a line each.
    - `findings`: what was assumed and changed while reading; warnings are to check.
    - `zeroed`: channels whose reading at zero, or at rest, was given: "force", "pressure" or
      "displacement".
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    censored: np.ndarray
    branch: np.ndarray
    time: np.ndarray | None = None
    rest_length: float | None = None
    moment_arm: np.ndarray | None = None
    synthetic: bool = False
    sources: tuple[Source, ...] = ()
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    zeroed: tuple[str, ...] = ()
    file: np.ndarray | None = None

    @classmethod
    def of(
        cls,
        pressure: Any,
        strain: Any,
        force: Any,
        censored: Any = None,
        branch: Any = None,
        **fields: Any,
    ) -> "Record":
        """Build a record from arrays.

        **Arguments:**

        - `pressure`: gauge pressure [Pa].
        - `strain`: contraction [-].
        - `force`: pulling force [N]; all three broadcast, and are flattened.
        - `censored`: flags of clipped readings; default: none.
        - `branch`: 1, −1 or 0; default: unknown.
        - `fields`: the other fields.

        **Returns:** the record.

        **Raises:** `InvalidInputError` for shapes that don't fit and readings that aren't finite.
        """
        readings = {"pressure": pressure, "strain": strain, "force": force}
        shape = broadcast_shape(**{name: np.shape(values) for name, values in readings.items()})
        flags = {"censored": False if censored is None else censored}
        flags["branch"] = UNKNOWN if branch is None else branch
        kinds = {"censored": bool, "branch": np.int8}
        columns: dict[str, np.ndarray] = {}
        for name, values in (readings | flags).items():
            if np.ma.is_masked(values):
                remedy = "drop the masked readings, such as by .compressed()"
                raise InvalidInputError(name, "must have no masked values", None, remedy)
            array = np.asarray(values, dtype=kinds.get(name, float))
            columns[name] = np.broadcast_to(array, shape).reshape(-1).copy()
            bad = np.flatnonzero(~np.isfinite(columns[name]))
            if bad.size:
                value = float(columns[name][bad[0]])
                text = f"{value} in reading {bad[0] + 1}"
                raise InvalidInputError(name, "must be finite", value, "drop that reading", text)
        return cls(**columns, **fields)

    def __len__(self) -> int:
        return self.force.size

    @property
    def has_one_clock(self) -> bool:
        """Times are known, and don't start anew in each of several files."""
        if self.time is None:
            return False
        return len(self.sources) < 2 or bool(np.all(np.diff(self.time) >= 0))

    def only(self, selection: Any, *findings: Finding) -> "Record":
        """Record of selected readings alone.

        **Arguments:**

        - `selection`: a mask or indices.
        - `findings`: added to the record's.

        **Returns:** the selected readings.
        """
        columns = {name: getattr(self, name) for name in (*COLUMNS, *OPTIONAL_COLUMNS, "file")}
        arrays = {name: x[selection] for name, x in columns.items() if x is not None}
        return replace(self, **arrays, findings=(*self.findings, *findings))


def join(records: Sequence[Record]) -> Record:
    """Concatenate records of one muscle; `time` and `moment_arm` are `None` unless all have one.

    **Arguments:** `records`: at least one.

    **Returns:** all their readings; a warning and a finding name records with equal readings.

    **Raises:** `InvalidInputError` if their strains refer to different lengths.
    """
    lengths = {record.rest_length for record in records} - {None}
    if len(lengths) > 1:
        values, remedy = sorted(map(str, lengths)), "name one in each file's TOML"
        rule = "must share one rest length"
        raise InvalidInputError("records", rule, values, remedy, shown=f"{values} m")
    duplicates = _duplicates(records)
    for pair in dict.fromkeys(tuple(finding.data.values()) for finding in duplicates):
        message = "{} and {} hold the same readings, which count twice: leave one out."
        warnings.warn(message.format(*pair), stacklevel=2)
    arrays: dict[str, np.ndarray | None] = {}
    for name in (*COLUMNS, *OPTIONAL_COLUMNS):
        columns = [getattr(record, name) for record in records]
        is_missing = any(values is None for values in columns)
        arrays[name] = None if is_missing else np.concatenate(columns)
    arrays["file"] = np.repeat(np.arange(len(records)), [len(record) for record in records])
    return replace(
        records[0],
        **arrays,
        # strains without a rest length refer to the length that the other records name
        rest_length=next(iter(lengths), None),
        synthetic=any(record.synthetic for record in records),
        sources=tuple(source for record in records for source in record.sources),
        notes=tuple(dict.fromkeys(note for record in records for note in record.notes)),
        findings=(*(finding for record in records for finding in record.findings), *duplicates),
        zeroed=tuple(x for x in records[0].zeroed if all(x in r.zeroed for r in records)),
    )


def _duplicates(records: Sequence[Record]) -> list[Finding]:
    """A finding for each record that repeats the readings of an earlier one."""
    names = [", ".join(source.name for source in record.sources) for record in records]
    earlier: dict[bytes, int] = {}
    findings = []
    for index, record in enumerate(records):
        readings = np.stack([record.pressure, record.strain, record.force]).tobytes()
        first = earlier.setdefault(readings, index)
        if first != index:
            pair = {"first": names[first] or f"record {first + 1}"}
            pair["second"] = names[index] or f"record {index + 1}"
            findings.append(warning("duplicates", **pair))
    return findings


def dumps(record: Record) -> str:
    """Text of a CSV file that reads back to the same floats.

    **Arguments:** `record`: the readings.

    **Returns:** the text: remarks with rest length and sources, a header, a row per reading.
    """
    columns = {"pressure [Pa]": record.pressure, "strain [-]": record.strain}
    columns |= {"force [N]": record.force, "time [s]": record.time}
    columns |= {"moment arm [m]": record.moment_arm}
    # an unknown one is blank: 0 beside 1 would be the other way
    branches = np.where(record.branch == UNKNOWN, "", record.branch.astype(str))
    columns |= {"branch": branches if record.branch.any() else None}
    columns |= {"clipped": record.censored.astype(int) if record.censored.any() else None}
    columns = {name: values.tolist() for name, values in columns.items() if values is not None}
    remarks = []
    if record.synthetic:
        remarks.append(("synthetic", "a model made these readings, no muscle was measured"))
    if record.rest_length is not None:
        remarks.append(("rest_length", exact(record.rest_length, "length")))
    remarks += [("source", f"{source.name} sha256 {source.sha256}") for source in record.sources]
    remarks += [("note", note) for note in record.notes]
    lines = [f"# {key}: {' '.join(value.split())}" for key, value in remarks]
    # the shortest text that reads back to the same float
    rows = zip(*(map(str, values) for values in columns.values()), strict=True)
    return "\n".join([*lines, ",".join(columns), *map(",".join, rows), ""])

"""A record: what was measured on one muscle, point by point, in SI and in one sign.

Whatever the file looked like, here a point is a gauge pressure, a contraction, and the
pulling force; with it goes what the reading is worth. A *censored* reading is one that was
clipped at zero: the gauge could not push, so it only says that the force was not above it.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import broadcast_shape


UP, DOWN, UNKNOWN = 1, -1, 0  # branches of a hysteresis loop


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
    - `censored`: whether the reading only says "not above" [-].
    - `branch`: 1 inflating or contracting, −1 deflating or extending, 0 unknown [-].
    - `time`: [s], or `None`.
    - `rest_length`: the length that strains refer to [m], or `None` where only strains
      were given.
    - `synthetic`: whether a model made it and no muscle [-].
    - `sources`: the files it came from [-].
    - `notes`: what was guessed or changed on the way in, a line each [-].
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    censored: np.ndarray
    branch: np.ndarray
    time: np.ndarray | None = None
    rest_length: float | None = None
    synthetic: bool = False
    sources: tuple[Source, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @classmethod
    def of(
        cls,
        pressure: Any,
        strain: Any,
        force: Any,
        censored: Any = None,
        branch: Any = None,
        **more: Any,
    ) -> "Record":
        """A record from arrays.

        **Arguments:**

        - `pressure`: gauge pressure [Pa].
        - `strain`: contraction [-].
        - `force`: pulling force [N]; all three broadcast, and are flattened.
        - `censored`: whether a reading is clipped at zero [-]; left out, none is.
        - `branch`: 1, −1 or 0 [-]; left out, unknown.
        - `more`: the other fields [-].

        **Returns:** the record [-].

        **Raises:** `ValueError` for shapes that don't fit and readings that aren't finite.
        """
        readings = {"pressure": pressure, "strain": strain, "force": force}
        shape = broadcast_shape(**{name: np.shape(values) for name, values in readings.items()})

        def flat(values: Any, kind: Any) -> np.ndarray:
            return np.broadcast_to(np.asarray(values, dtype=kind), shape).reshape(-1).copy()

        columns = {name: flat(values, float) for name, values in readings.items()}
        for name, values in columns.items():
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                raise InvalidInputError(
                    name,
                    "must be finite",
                    float(values[bad[0]]),
                    "drop that reading",
                    shown=f"{values[bad[0]]} in reading {bad[0] + 1}",
                )
        return cls(
            **columns,
            censored=flat(False if censored is None else censored, bool),
            branch=flat(UNKNOWN if branch is None else branch, np.int8),
            **more,
        )

    def __len__(self) -> int:
        return self.force.size

    def only(self, chosen: Any, *notes: str) -> "Record":
        """The readings that are `chosen` [-], a mask or places, with further `notes` [-]."""
        time = None if self.time is None else self.time[chosen]
        arrays = {
            name: getattr(self, name)[chosen]
            for name in ("pressure", "strain", "force", "censored", "branch")
        }
        return replace(self, **arrays, time=time, notes=(*self.notes, *notes))


def join(records: Sequence[Record]) -> Record:
    """One record of several of the same muscle, one after the other.

    **Arguments:** `records`: at least one [-].

    **Returns:** all their readings [-]; a warning and a note tell of those that are there twice.

    **Raises:** `ValueError` where their strains refer to unlike lengths.
    """
    first = records[0]
    lengths = {record.rest_length for record in records} - {None}
    if len(lengths) > 1:
        raise InvalidInputError(
            "records",
            "must share one rest length",
            sorted(map(str, lengths)),
            "name one in each file's TOML",
            shown=f"{sorted(map(str, lengths))} m",
        )
    # where only strains were given, they refer to the length that the others name
    rest_length = next(iter(lengths), None)
    twice = _twice(records)
    for told in twice:
        warnings.warn(f"{told}.", stacklevel=2)
    timed = all(record.time is not None for record in records)
    return replace(
        first,
        **{
            name: np.concatenate([getattr(record, name) for record in records])
            for name in ("pressure", "strain", "force", "censored", "branch")
        },
        time=np.concatenate([record.time for record in records]) if timed else None,  # pyright: ignore[reportCallIssue, reportArgumentType] timed says that each is an array
        rest_length=rest_length,
        synthetic=any(record.synthetic for record in records),
        sources=tuple(source for record in records for source in record.sources),
        notes=tuple(dict.fromkeys([*(note for one in records for note in one.notes), *twice])),
    )


def _twice(records: Sequence[Record]) -> list[str]:
    """Which of the records hold the same readings, a line for each that is there again [-]."""

    def name(place: int) -> str:
        return ", ".join(one.name for one in records[place].sources) or f"record {place + 1}"

    def readings(record: Record) -> bytes:
        return np.stack([record.pressure, record.strain, record.force]).tobytes()

    first, lines = {}, []
    for place, record in enumerate(records):
        before = first.setdefault(readings(record), place)
        if before != place:
            pair = f"{name(before)} and {name(place)}"
            lines.append(f"{pair} hold the same readings, which count twice: leave one out")
    return list(dict.fromkeys(lines))

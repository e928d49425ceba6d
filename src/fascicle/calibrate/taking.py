"""What of a record goes into a fit, and what became of the rest: all of it is counted."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..records.record import UNKNOWN, Record
from .grid import Gathered, Grid, gathered, trimmed


@dataclass(frozen=True, eq=False)
class Taken:
    """A record as it is fitted.

    - `record`: the readings that are fitted [-], their branches told apart where they can be.
    - `gathered`: where each of them went [-].
    - `read`: how many readings were read [-].
    - `left_out`: how many of these are not fitted, by the reason why [-].
    """

    record: Record
    gathered: Gathered
    read: int
    left_out: Mapping[str, int] = field(default_factory=dict)

    @property
    def data(self) -> Grid:
        """The tables of a fit [-]."""
        return self.gathered.data

    @property
    def clipped(self) -> int:
        """Readings that only say "not above" [-]."""
        return int(np.sum(self.record.censored))

    @property
    def pulls(self) -> bool:
        """Whether all that was measured pulls, so that the tension law is all that is needed [-]."""
        force = self.record.force[~self.record.censored]
        return bool(force.size and np.min(force) > 0)

    def counts(self) -> dict[str, int]:
        """Readings by what became of them [-]."""
        return {
            "read": self.read,
            **{f"left out: {why}": count for why, count in self.left_out.items()},
            "clipped": self.clipped,
            "averaged": self.gathered.averaged,
            "means": self.gathered.means,
            "pressures": int(self.gathered.level.max()) + 1,
        }

    def words(self) -> list[str]:
        """The same in sentences [-]."""
        lines = [f"{self.read} readings read"]
        lines += [f"{count} left out: {why}" for why, count in self.left_out.items()]
        if not self.left_out:
            lines[0] += ", none left out"
        if self.clipped:
            lines.append(f"{self.clipped} clipped: they only say that the force was not above zero")
        made = self.gathered
        if made.averaged:
            lines.append(
                f"{made.averaged} averaged into {made.means} means for the fit, in steps of strain,"
                " each way by itself; errors are those of all readings"
            )
        levels, seen = int(made.level.max()) + 1, np.unique(self.record.pressure).size
        if seen > levels:
            lines.append(f"{seen} pressures gathered into {levels} levels")
        return lines

    def errors(self, force: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """Measured less fitted force of each reading [N], NaN where it is clipped; from the model's
        `force` [N] at the tables' places, which lie at this `strain` of the record [-].
        """
        record, made = self.record, self.gathered
        at = force[made.level, made.place]
        if made.averaged:
            away = record.strain - strain[made.level, made.place]
            at = at + away * _slopes(force, strain, np.asarray(self.data.count))[made.level, made.place]
        return np.where(record.censored, np.nan, record.force - at)


def taken(record: Record) -> Taken:
    """What of a `record` [-] is fitted: readings of a record in time that belong to sweeps, without
    the ramps between them.
    """
    branches, ramps = _branches(record)
    read, left_out = len(record), {}
    if record.time is not None and 0 < np.sum(ramps) < len(record) / 2:
        left_out = {"on ramps between sweeps": int(np.sum(ramps))}
        note = f"{np.sum(ramps)} readings of ramps between sweeps left out of the fit"
        record, branches = record.only(~ramps, note), branches[~ramps]
    record = replace(record, branch=branches)
    return Taken(record, gathered(record), read, left_out)


def pulling_of(of: Taken) -> Taken:
    """The same as a gauge would have `taken` it that only pulls: pushes are clipped at zero."""
    record, below = of.record, of.record.force <= 0
    if not np.any(below & ~record.censored):
        return of
    clipped = replace(
        record, force=np.where(below, 0.0, record.force), censored=record.censored | below
    )
    return Taken(clipped, gathered(clipped), of.read, of.left_out)


def shown(table: np.ndarray, data: Grid) -> np.ndarray:
    """Of a `table` of places [any] those of `trimmed` data [-]."""
    rows, columns = np.shape(trimmed(data).count)
    return np.asarray(table)[:rows, :columns]


def _branches(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Branches as the record tells them, or as its sweeps turn [-]; and which readings are ramps."""
    from ..records.splitting import runs

    branches, ramps = record.branch.copy(), np.zeros(len(record), dtype=bool)
    told = bool(np.any(branches != UNKNOWN))
    for run in runs(record):
        ramps[run.points] = run.kind == "mixed"
        if not told and run.kind != "mixed":
            branches[run.points] = run.branch
    return branches, ramps


def _slopes(force: np.ndarray, strain: np.ndarray, count: np.ndarray) -> np.ndarray:
    """How the model's force [N] changes with strain [-] from one place of a level to the next."""
    out = np.zeros(force.shape)
    for row in range(len(force)):
        places = np.flatnonzero(count[row] > 0)
        places = places[np.argsort(strain[row, places], kind="stable")]
        x, first = np.unique(strain[row, places], return_index=True)
        if x.size > 1:
            slope = np.gradient(force[row, places][first], x)
            out[row, places] = np.interp(strain[row, places], x, slope)
    return out

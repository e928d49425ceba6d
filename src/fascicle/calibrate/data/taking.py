"""What of a record goes into a fit, and what became of the rest: all of it is counted."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...records.record import UNKNOWN, Record
from ...units import pretty
from .grid import LONGEST, Gathered, Grid, gathered, trimmed


TELLING = 5  # readings that push: as many as what resists has factors; fewer can't tell them
_SMALL = 0.1  # of a level's largest force: what noise may be where a gauge reads none
_NOISE = 0.02  # of the largest force, the same
# a load cell's floor: so many readings, such a share of all, so many times as often as each of
# the numbers next above it
_FEWEST, _SHARE, _TIMES, _ABOVE = 5, 0.02, 4, 10
_IDLE = 0.01  # of the highest pressure: below, a muscle that isn't stretched doesn't pull


@dataclass(frozen=True, eq=False)
class Taken:
    """A record as it is fitted.

    - `record`: the readings that are fitted [-], their branches told apart where they can be.
    - `gathered`: where each of them went [-].
    - `read`: how many readings were read [-].
    - `left_out`: how many of these are not fitted, by the reason why [-].
    - `slack`: how many small forces among clipped ones were taken for clipped as well [-].
    - `pushes`: how many readings that don't pull were taken for clipped as well [-].
    """

    record: Record
    gathered: Gathered
    read: int
    left_out: Mapping[str, int] = field(default_factory=dict)
    slack: int = 0
    pushes: int = 0

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
        """Whether all that was measured pulls: the tension law is all that is needed [-]."""
        return not self.pushing and not np.all(self.record.censored)

    @property
    def pushing(self) -> int:
        """Readings of no pull that aren't clipped [-]."""
        return int(np.sum((self.record.force <= 0) & ~self.record.censored))

    def counts(self) -> dict[str, int]:
        """Readings by what became of them [-]."""
        return {
            "read": self.read,
            **{f"left out: {why}": count for why, count in self.left_out.items()},
            "clipped": self.clipped,
            "clipped as noise": self.slack,
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
            floor = floor_of(self.record)
            lines.append(
                f"{self.clipped} clipped: they only say that the force was not above {floor}"
            )
        if self.slack:
            lines.append(
                f"{self.slack} of these are small forces past the strain from which the others of"
                " their pressure are clipped: taken for noise"
            )
        if self.pushes:
            lines.append(
                f"{self.pushes} of these {'does' if self.pushes == 1 else 'do'} not pull, too few"
                f" to tell what resists ({TELLING} numbers): `--fit tuning` fits that all the same"
            )
        made = self.gathered
        if made.averaged:
            lines.append(
                f"{made.averaged} averaged into {made.means} means for the fit, in steps of strain,"
                " each way by itself; errors are those of all readings"
            )
        levels, seen = int(made.level.max()) + 1, np.unique(self.record.pressure).size
        if seen > levels:
            lines.append(f"{seen} pressures gathered into {levels} level{'s' * (levels > 1)}")
        return lines

    def errors(self, force: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """Measured less fitted force of each reading [N], NaN where it is clipped; from the model's
        `force` [N] at the tables' places, which lie at this `strain` of the record [-].
        """
        record, made = self.record, self.gathered
        place = made.level, made.place
        at = force[place]
        if made.averaged:
            slopes = _slopes(force, strain, np.asarray(self.data.count))
            at = at + (record.strain - strain[place]) * slopes[place]
        return np.where(record.censored, np.nan, record.force - at)


def taken(record: Record) -> Taken:
    """What of a `record` [-] is fitted: readings of a record in time that belong to sweeps, without
    the ramps between them.
    """
    # a reading that the file calls clipped is clipped at zero, whatever number stands there
    force = np.where(record.censored, 0.0, record.force)
    record = replace(record, force=force, censored=record.censored | _at_floor(record))
    branches, ramps = _branches(record)
    read, left_out = len(record), {}
    if record.time is not None and 0 < np.sum(ramps) < len(record) / 2:
        left_out = {"on ramps between sweeps": int(np.sum(ramps))}
        note = f"{np.sum(ramps)} readings of ramps between sweeps left out of the fit"
        record, branches = record.only(~ramps, note), branches[~ramps]
    record = replace(record, branch=branches)
    return Taken(record, gathered(record), read, left_out)


def floor_of(record: Record) -> str:
    """Force at which a `record` [-] is clipped, in words [-]: zero, or the gauge's floor."""
    forces = np.unique(record.force[record.censored])
    below = forces[forces != 0]
    return pretty(float(below[0]), "force") if below.size else "zero"


def _at_floor(record: Record) -> np.ndarray:
    """Readings at the floor of the load cell [-]: many of exactly the least number, far more than
    of those above it, which a coarse gauge would repeat as well.
    """
    values, counts = np.unique(record.force[~record.censored], return_counts=True)
    if values.size < 2 or values[0] >= 0:  # zeros are the file's to explain
        return np.zeros(len(record), dtype=bool)
    most = np.max(counts[1 : 1 + _ABOVE])
    many = max(_FEWEST, _SHARE * np.sum(counts), _TIMES * most)
    return (record.force == values[0]) & ~record.censored & bool(counts[0] >= many)


def pulling_of(of: Taken, longest: int = LONGEST) -> Taken:
    """The same as a gauge would have `taken` it that only pulls, for the tension law alone: pushes
    are clipped at zero, and so is the noise that such a gauge reads past a free strain; at most
    `longest` readings [-] at a pressure.
    """
    record = of.record
    below = (record.force <= 0) & ~record.censored
    slack = _slack(of, record.censored | below)
    if not np.any(below | slack) and longest == LONGEST:
        return of
    gone = record.censored | below | slack
    clipped = replace(record, force=np.where(gone, 0.0, record.force), censored=gone)
    return replace(
        of, record=clipped, gathered=gathered(clipped, longest),
        slack=int(np.sum(slack)), pushes=int(np.sum(below)),
    )  # fmt: skip


def _slack(of: Taken, clipped: np.ndarray) -> np.ndarray:
    """Readings that aren't `clipped` [-], but lie where most others of their level are, and are
    small: a force that falls with strain is gone once it has gone.
    """
    force, strain = of.record.force, of.record.strain
    out, top = np.zeros(force.size, dtype=bool), float(np.max(force))
    idle = of.record.pressure < _IDLE * float(np.max(of.record.pressure))
    order = np.lexsort((strain, of.gathered.level))
    for points in np.split(order, np.flatnonzero(np.diff(of.gathered.level[order])) + 1):
        gone = clipped[points]
        if np.all(gone) or not (np.any(gone) or idle[points[0]]):
            continue
        # where the level ends to pull: most before it do, and most beyond it don't
        right = np.concatenate([[0], np.cumsum(~gone)]) + np.concatenate(
            [np.cumsum(gone[::-1])[::-1], [0]]
        )
        ends = 0 if idle[points[0]] else int(np.argmax(right))
        small = force[points] < max(_SMALL * np.max(force[points]), _NOISE * top)
        slack = (np.arange(points.size) >= ends) & ~gone & small
        # before it, too, what is no more than the noise that is seen beyond
        noise = np.max(force[points], where=slack, initial=0.0)
        while ends > 0 and (gone[ends - 1] or force[points][ends - 1] <= noise):
            ends -= 1
            slack[ends] = not gone[ends]
        out[points] = slack
    return out


def shown(table: np.ndarray, data: Grid) -> np.ndarray:
    """Of a `table` of places [any] those of `trimmed` data [-]."""
    rows, columns = np.shape(trimmed(data).count)
    return np.asarray(table)[:rows, :columns]


def _branches(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Branches as the record tells them, or as its sweeps turn [-]; and which are on ramps."""
    from ...records.segmentation import runs

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
        x = strain[row, places]
        # the means of both branches may lie a rounding apart
        apart = np.concatenate([[True], np.diff(x) > 1e-6 * np.ptp(x)]) if x.size else []
        kept = places[apart]
        if kept.size > 1:
            slope = np.gradient(force[row, kept], strain[row, kept])
            out[row, places] = np.interp(x, strain[row, kept], slope)
    return out

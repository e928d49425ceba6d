"""A measured record against every law: errors, where they lie, constants, and words."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...calibrate.after.calibration import Calibration
from ...calibrate.data.taking import taken
from ...calibrate.fits.comparing import Row, compare_published, row, tension_fits
from ...calibrate.fits.finding import Choice, find
from ...calibrate.problem.beginning import Search
from .found import Measured


_CELLS = 8  # of strain
_MOST = 2  # causes that are told


@dataclass(frozen=True)
class Against:
    """One law against a record.

    - `row`: its errors, seen and left out, and what it cost [-].
    - `along_pressure`, `along_strain`: least and largest mean residual [N] at a pressure, and in
      an eighth of the strains; measured less the law's.
    - `constants`: each with its 90 % interval [SI], and whether the data know it.
    - `misses`: what it misses, in words [-].
    """

    row: Row
    along_pressure: tuple[float, float]
    along_strain: tuple[float, float]
    constants: Mapping[str, tuple[float, float, float, bool]]
    misses: str


@dataclass(frozen=True, eq=False)
class Judged:
    """A `measured` record [-], the `choice` that a plain calibration makes [-], and what
    each law does `against` it [-], the least left-out error first.
    """

    measured: Measured
    choice: Choice
    against: tuple[Against, ...]


def judged(measured: Measured) -> Judged:
    """A `measured` record [-] against every tension law, fitted; laws as published for one maker's
    muscle as they are.
    """
    record, muscle = measured.record, measured.muscle
    assert record is not None
    assert muscle is not None
    choice = find(record, muscle)
    names = list(choice.made.names) if choice.made.method == "constants" else None
    fits = tension_fits(taken(record), muscle, names, None, Search(whole=False))
    rows = [_against(row(label, made), made, made.force, _words(made)) for label, made in
            fits.items()]  # fmt: skip
    first = next(iter(fits.values()))
    for published, force in compare_published(first):
        rows.append(_against(published, first, force, "not looked into", fitted=False))
    rows.sort(key=lambda one: one.row.relative_left_out_rmse)
    return Judged(measured, choice, tuple(rows))


def _against(
    told: Row, made: Calibration, force: np.ndarray, misses: str, fitted: bool = True
) -> Against:
    data = made.data
    missed = np.where(data.uncensored, np.asarray(data.force) - force, np.nan)
    known = {
        one.name: (one.value, one.low, one.high, one.identifiable)
        for one in (made.parameters if fitted else ())
    }
    used, strain = np.isfinite(missed), np.asarray(data.strain)
    rows = [float(np.mean(one[there])) for one, there in zip(missed, used, strict=True) if
            np.any(there)]  # fmt: skip
    edges = np.quantile(strain[used], np.linspace(0, 1, _CELLS + 1))
    cell = np.clip(np.searchsorted(edges, strain, "right") - 1, 0, _CELLS - 1)
    cells = [float(np.mean(missed[used & (cell == i)])) for i in range(_CELLS) if
             np.any(used & (cell == i))]  # fmt: skip
    return Against(told, (min(rows), max(rows)), (min(cells), max(cells)), known, misses)


def _words(made: Calibration) -> str:
    """What a fit misses."""
    if made.seen.noisy:
        return "nothing that shows: what is left could be noise"
    along = [f"{one.along} ({_percent(one.share)} of squares)" for one in made.seen.found]
    along = along or [f"{one.along}, by runs of one sign" for one in made.seen.wandering]
    causes = [one.name for one in made.causes[:_MOST]]
    most = f"; most like {' or '.join(causes)}" if causes else "; like no cause known here"
    return f"what is left follows {', '.join(along)}{most}"


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.005 else "less than 1 %"

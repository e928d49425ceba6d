"""A visitor's readings, within limits; the muscle's curves beside them; and the fit."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...calibrate.data.grid import level_of
from ...core.domain import HIGHEST_PRESSURE
from ...muscle import Muscle
from ...records import loads
from ...records.asking import Asked
from ...records.record import Record
from ...units import pretty


if TYPE_CHECKING:
    from ...calibrate import Choice

LARGEST_FILE = 5_000_000  # bytes
MOST_ROWS = 100_000
MOST_LEVELS, MOST_POINTS = 8, 4_000  # curves and readings that are drawn
STARTS = 2  # places the fit begins from: few, so that it doesn't take long
_POINTS = 121


@dataclass(frozen=True)
class Beside:
    """Curves at the pressures that were held: `pressure` [Pa], `strain` [-], `force` [N] by
    row; and `level` of each reading [-].
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    level: np.ndarray


def read(
    raw: bytes, name: str, length: float, clipped: bool, rest_length: float | None = None
) -> Record:
    """Readings from a file that was sent.

    **Arguments:**

    - `raw`: its bytes [-].
    - `name`: what it is called [-]; nothing of that name is opened.
    - `length`: the muscle's [m], for strains where the file names no rest length.
    - `clipped`: whether forces of exactly zero are clipped readings [-].
    - `rest_length`: that strains refer to [m]; left out, what the file says, else the muscle's.

    **Returns:** the record [-].

    **Raises:** `ValueError`, in one line, for what is too large or can't be read.
    """
    if len(raw) > LARGEST_FILE:
        raise ValueError(f"{name}: a record may have {LARGEST_FILE} bytes, got {len(raw)}.")
    rows = raw.count(b"\n")
    if rows > MOST_ROWS:
        raise ValueError(
            f"{name}: a record may have {MOST_ROWS} rows here, got {rows}:"
            " thin it out, or use `fascicle calibrate`."
        )
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    given = True if clipped else None
    try:
        record = loads(text, source=name, clipped_at_zero=given, rest_length=rest_length)
    except Asked as error:  # a length or displacement in a file that names no rest length
        if error.argument != "rest_length":
            raise
        record = _over(text, name, given, length)
    if record.rest_length is None:
        told = pretty(length, "length")
        assumed = f"rest length not given: strains are taken over the muscle's, {told}"
        record = replace(record, rest_length=length, notes=(*record.notes, assumed))
    return record


def synthetic(muscle: Muscle) -> bytes:
    """A record to try [-]: of a virtual dynamometer on a `muscle` [-], and it says so. The muscle
    is a little thicker and steeper than drawn, as one that was built is.
    """
    from ...records import VirtualDynamometer
    from ...records.writing import dumps

    pressures = [0.0, 1e5, 2e5, 3e5, 4e5]
    machine = VirtualDynamometer(pressures, samples=60, both_ways=False)
    built = muscle.replace(
        outer_radius=1.02 * muscle.outer_radius, braid_angle=0.97 * muscle.braid_angle
    )
    return dumps(machine.record(built, seed=7)).encode()


def _over(text: str, name: str, clipped: bool | None, length: float) -> Record:
    """The record of a `text` [-] over the muscle's `length` [m]; that is said where it can't be."""
    try:
        return loads(text, source=name, clipped_at_zero=clipped, rest_length=length)
    except ValueError as error:
        told = pretty(length, "length")
        raise ValueError(
            f"{error} Contractions were taken over the muscle's length, {told}: give the record's"
            " rest length if it is another."
        ) from None


def suited(muscle: Muscle, record: Record) -> str:
    """Why a `record` [-] can hardly be of this `muscle` [-], in words [-]; empty where it can."""
    highest = float(np.clip(record.pressure.max(), 0.0, HIGHEST_PRESSURE))
    if not highest:
        return "It holds no pressure above zero: nothing of tension can be told from it."
    pulls = record.strain[record.force > 0.02 * record.force.max()]
    farthest, free = float(pulls.max(initial=0.0)), float(muscle.free_strain(highest))
    if farthest <= 1.4 * free:
        return ""
    over = muscle.length if record.rest_length is None else record.rest_length
    return (
        f"It still pulls at a contraction of {farthest:.3g}, where this muscle's free strain is"
        f" {free:.3g}: contractions are taken over {pretty(float(over), 'length')}; give the rest"
        " length if it is another, or open the muscle that was measured."
    )


def beside(muscle: Muscle, record: Record) -> Beside:
    """A muscle's curves [N] at the pressures of a `record` [-]."""
    level = level_of(record.pressure)
    held = [number for number in np.unique(level) if number >= 0]
    if len(held) > MOST_LEVELS:  # evenly among them
        held = [held[i] for i in np.linspace(0, len(held) - 1, MOST_LEVELS).astype(int)]
    pressures = np.array([record.pressure[level == number].mean() for number in held])
    low, high = min(0.0, float(record.strain.min())), float(record.strain.max())
    strain = np.linspace(low, max(high, low + 0.01), _POINTS)
    force = np.asarray(muscle.force(np.clip(pressures, 0.0, HIGHEST_PRESSURE)[:, None], strain))
    return Beside(pressures, strain, force, level)


def drawn(record: Record) -> np.ndarray:
    """Which readings are drawn [-]: all, or evenly among many."""
    return np.unique(np.linspace(0, len(record) - 1, min(len(record), MOST_POINTS)).astype(int))


def fitted(record: Record, muscle: Muscle, tell: Callable[[str], object]) -> "Choice":
    """What is found for a `muscle` [-] in a `record` [-], as `fascicle calibrate` finds it; `tell`
    [-] is told what is being done.
    """
    from ...calibrate.fits.finding import find

    return find(record, muscle, starts=STARTS, tell=tell)


def tuned_file(choice: "Choice", date: str) -> str:
    """The fitted muscle's file [-] with where it comes from, made on a `date` [-]."""
    from ...files import dumps
    from ...files.calibrated import provenance_of

    return dumps(choice.made.muscle, provenance_of(choice.made, date, choice))


def report_page(choice: "Choice", date: str) -> str:
    """The report [-] of what was found, made on a `date` [-]."""
    from ...calibrate.after.pictures import figures
    from ...reports.calibration import report

    return report(choice.made, date, figures(choice.made), choice=choice)

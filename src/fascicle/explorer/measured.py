"""A visitor's readings, within limits; the muscle's curves beside them; and the fit."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..calibrate.data import assign_levels
from ..core.validation import HIGHEST_PRESSURE
from ..muscle import Muscle
from ..muscle.validation import extension_message, lowest_strain, strain_domain
from ..records import loads
from ..records.columns import MissingMetadataError
from ..records.csv_table import open_table
from ..records.record import Record
from ..units import pretty


if TYPE_CHECKING:
    from ..calibrate import Selection


LARGEST_FILE = 5_000_000  # bytes
MOST_ROWS = 100_000
MOST_LEVELS, MOST_POINTS = 8, 4_000  # curves and readings that are drawn
STARTS = 2  # places the fit begins from: few, so that it doesn't take long
FOUND, TUNING = "found", "tuning"  # what is fitted, where it isn't constants by name
_POINTS = 121
_PRESSURES = (0.0, 1e5, 2e5, 3e5, 4e5)  # Pa, of a record to try
_HEAD = 200_000  # bytes in which the header stands


@dataclass(frozen=True)
class Reading:
    """How a record is to be read: whether forces of exactly zero are `clipped` readings; the
    `rest_length` [m]; headers of `columns` and their `units` by role [-], where it doesn't say it.
    """

    clipped: bool = False
    rest_length: float | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def given(self) -> dict[str, Any]:
        """What is given of it, as `records.load` takes it [-]."""
        said = {
            "columns": dict(self.columns), "units": dict(self.units),
            "rest_length": self.rest_length, "clipped_at_zero": True if self.clipped else None,
        }  # fmt: skip
        return {name: value for name, value in said.items() if value}


@dataclass(frozen=True)
class Beside:
    """Curves at the pressures that were held: `pressure` [Pa], `strain` [-], `force` [N] by
    row; and `level` of each reading [-].
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    level: np.ndarray


def read(raw: bytes, name: str, length: float, reading: "Reading | None" = None) -> Record:
    """Readings from a file that was sent.

    **Arguments:**

    - `raw`: its bytes [-].
    - `name`: what it is called [-]; nothing of that name is opened.
    - `length`: the muscle's [m], for strains where nobody names a rest length.
    - `reading`: what the file doesn't say itself [-].

    **Returns:** the record [-].

    **Raises:** `ValueError`, in one line, for what is too large or can't be read.
    """
    if not raw.strip():
        raise ValueError(f"{name}: the file is empty, {len(raw)} bytes.")
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
    said = Reading() if reading is None else reading
    given: dict[str, Any] = said.given
    try:
        record = loads(text, source=name, **given)
    except MissingMetadataError as error:  # a length in a file that names no rest length
        if error.argument != "rest_length":
            # in the words of the fields that are there
            what = "" if error.argument == "columns" else "its unit in "
            fields = f"{what}the fields below, {error.role} `{error.value}` for instance"
            then = f",{error.after}" if error.after.startswith(" ") else error.after
            raise ValueError(f"{error.before}{fields}{then}") from None
        record = replace(_over(text, name, given, length), rest_length=None)
    if record.rest_length is None:
        told = pretty(length, "length")
        assumed = f"rest length not given: strains are taken over the muscle's, {told}"
        record = replace(record, rest_length=length, notes=(*record.notes, assumed))
    return record


def headers(raw: bytes, name: str) -> tuple[str, ...]:
    """Headers [-] of the columns of a file that was sent; none where it has none.

    **Arguments:** `raw`: its bytes [-]; `name`: what it is called [-].
    """
    try:
        return open_table(raw[:_HEAD], name).header
    except ValueError:
        return ()


def synthetic(muscle: Muscle) -> bytes:
    """A record to try [-]: of a virtual dynamometer on a `muscle` [-], and it says so. The muscle
    is a little thicker and steeper than drawn, as one that was built is.
    """
    from ..records import VirtualDynamometer
    from ..records.record import dumps

    machine = VirtualDynamometer(list(_PRESSURES), samples=60, both_ways=False)
    built = muscle.replace(
        outer_radius=1.02 * muscle.outer_radius, braid_angle=0.97 * muscle.braid_angle
    )
    return dumps(machine.record(built, seed=7)).encode()


def _over(text: str, name: str, given: Mapping[str, Any], length: float) -> Record:
    """The record of a `text` [-] over the muscle's `length` [m]; that is said where it can't be."""
    try:
        return loads(text, source=name, **{**given, "rest_length": length})
    except ValueError as error:
        told = pretty(length, "length")
        raise ValueError(
            f"{error} Contractions were taken over the muscle's length, {told}: give the record's"
            " rest length if it is another."
        ) from None


def suited(muscle: Muscle, record: Record) -> str:
    """Why a `record` [-] can hardly be of this `muscle` [-], or that it stretches it, in words
    [-]; empty where there is nothing to say.
    """
    if stretched := extension_message(record.strain, lowest_strain(*strain_domain(muscle))):
        return stretched
    highest = float(np.clip(record.pressure.max(), 0.0, HIGHEST_PRESSURE))
    if not highest:
        return "The record holds no pressure above zero: nothing of tension can be told from it."
    pulls = record.strain[record.force > 0.02 * record.force.max()]
    farthest, free = float(pulls.max(initial=0.0)), float(muscle.free_strain(highest))
    if farthest <= 1.4 * free:
        return ""
    over = muscle.length if record.rest_length is None else record.rest_length
    return (
        f"This record hardly suits this muscle: it still pulls at a contraction of {farthest:.3g},"
        f" where the muscle's free strain is {free:.3g}. Contractions are taken over"
        f" {pretty(float(over), 'length')}: give the rest length if it is another, or open the"
        " muscle that was measured."
    )


def beside(muscle: Muscle, record: Record) -> Beside:
    """A muscle's curves [N] at the pressures of a `record` [-]."""
    level = assign_levels(record.pressure)
    held = [number for number in np.unique(level) if number >= 0]
    if len(held) > MOST_LEVELS:  # evenly among them
        held = [held[i] for i in np.linspace(0, len(held) - 1, MOST_LEVELS).astype(int)]
    pressures = np.array([record.pressure[level == number].mean() for number in held])
    low, high = min(0.0, float(record.strain.min())), float(record.strain.max())
    strain = np.linspace(low, max(high, low + 0.01), _POINTS)
    force = np.asarray(muscle.force(np.clip(pressures, 0.0, HIGHEST_PRESSURE)[:, None], strain))
    return Beside(pressures, strain, force, level)


def check_drawn(muscle: Muscle, record: Record, name: str) -> None:
    """Refuse a `record` [-] called `name` [-] beside which a `muscle` [-] has no curves."""
    try:
        beside(muscle, record)
    except ValueError as error:
        raise ValueError(f"{name}: no curve of this muscle can lie beside it: {error}") from None


def awaited(muscle: Muscle) -> Beside:
    """A muscle's curves [N] where readings of it would lie, as those of `synthetic` [-] do."""
    pressures = np.array(_PRESSURES)
    free = float(muscle.free_strain(pressures[-1]))
    strain = np.linspace(0.0, max(free, 0.01), _POINTS)
    force = np.asarray(muscle.force(pressures[:, None], strain))
    return Beside(pressures, strain, force, np.zeros(0, int))


def drawn(record: Record) -> np.ndarray:
    """Which readings are drawn [-]: all, or evenly among many."""
    return np.unique(np.linspace(0, len(record) - 1, min(len(record), MOST_POINTS)).astype(int))


def fittable(muscle: Muscle) -> tuple[str, ...]:
    """Names [-] of what can be fitted of a `muscle` [-]."""
    from ..calibrate.parameters import parameters_of

    return tuple(parameters_of(muscle))


def fitted(
    record: Record,
    muscle: Muscle,
    tell: Callable[[str], object],
    names: Sequence[str] = (FOUND,),
) -> "Selection":
    """A muscle fitted to a record.

    **Arguments:**

    - `record`: the readings [-].
    - `muscle`: the muscle [-].
    - `tell`: is told what is being done [-].
    - `names`: what is fitted: `FOUND`, as `fascicle calibrate` finds it; `TUNING`, the paper's; or
      names of `fittable` [-].

    **Returns:** what was fitted, and what it was chosen from [-].
    """
    from ..calibrate.fitting import fit
    from ..calibrate.model_selection import Selection, select_model

    if tuple(names) == (FOUND,):
        return select_model(record, muscle, starts=STARTS, tell=tell)
    tell("fitting")
    free = None if tuple(names) == (TUNING,) else list(names)
    return Selection(fit(record, muscle, free, starts=STARTS, whole=False))


def tuned_file(choice: "Selection", date: str) -> str:
    """The fitted muscle's file [-] with where it comes from, made on a `date` [-]."""
    from ..files.calibration_files import calibrated_text

    return calibrated_text(choice.calibration, date, _several(choice))


def report_page(choice: "Selection", date: str) -> str:
    """The report [-] of what was found, made on a `date` [-]."""
    from ..calibrate.plot_data import figures
    from ..reports.calibration import report

    return report(choice.calibration, date, figures(choice.calibration), choice=_several(choice))


def _several(choice: "Selection") -> "Selection | None":
    """The `choice` [-], or `None` where there was none."""
    return choice if choice.candidates else None

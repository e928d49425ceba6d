"""Records of a visitor: reading within limits, a muscle's curves at their pressures, the fit."""

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
MOST_CURVES, MOST_POINTS = 100, 4_000  # that are drawn: what a browser draws at once
STARTS = 2  # starting points of a fit: few, so that it doesn't take long
AUTOMATIC, TUNING = "found", "tuning"  # what is fitted, where it isn't constants by name
_POINTS = 121
_PRESSURES = (0.0, 1e5, 2e5, 3e5, 4e5)  # Pa, of the example record
_HEADER_BYTES = 200_000  # that hold the header


@dataclass(frozen=True)
class ReadOptions:
    """What a record's file doesn't say.

    Whether forces of exactly zero are `clipped` readings; the `rest_length` [m]; headers of
    `columns` and their `units` by role.
    """

    clipped: bool = False
    rest_length: float | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of `records.load` that are given."""
        options = {
            "columns": dict(self.columns), "units": dict(self.units),
            "rest_length": self.rest_length, "clipped_at_zero": True if self.clipped else None,
        }  # fmt: skip
        return {name: value for name, value in options.items() if value}


@dataclass(frozen=True)
class MeasuredCurves:
    """Curves of a muscle at the pressures of a record.

    `pressure` [Pa], `strain` [-], `force` [N] by row; `count` of pressures in the record, of
    which not more than `MOST_CURVES` have a curve.
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    count: int


def read_record(
    raw: bytes, name: str, length: float, options: ReadOptions = ReadOptions()
) -> Record:
    """Record of an uploaded file.

    **Arguments:**

    - `raw`: bytes of the file.
    - `name`: of the file; nothing of that name is opened.
    - `length`: of the muscle [m], for strains where no rest length is given.
    - `options`: what the file doesn't say.

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
    arguments = options.arguments
    try:
        record = loads(text, source=name, **arguments)
    except MissingMetadataError as error:
        if error.argument != "rest_length":
            # in the words of the fields on the page
            what = "" if error.argument == "columns" else "its unit in "
            fields = f"{what}the fields below, {error.role} `{error.value}` for instance"
            then = f",{error.after}" if error.after.startswith(" ") else error.after
            raise ValueError(f"{error.before}{fields}{then}") from None
        # lengths or displacements in a file that names no rest length
        record = replace(_read_over(text, name, arguments, length), rest_length=None)
    if record.rest_length is None:
        note = (
            "rest length not given: strains are taken over the muscle's,"
            f" {pretty(length, 'length')}"
        )
        record = replace(record, rest_length=length, notes=(*record.notes, note))
    return record


def _read_over(text: str, name: str, arguments: Mapping[str, Any], length: float) -> Record:
    """Record over the muscle's `length` [m], which an error names."""
    try:
        return loads(text, source=name, **{**arguments, "rest_length": length})
    except ValueError as error:
        raise ValueError(
            f"{error} Contractions were taken over the muscle's length,"
            f" {pretty(length, 'length')}: give the record's rest length if it is another."
        ) from None


def read_headers(raw: bytes, name: str) -> tuple[str, ...]:
    """Headers of the columns of an uploaded file; none where it has none.

    **Arguments:** `raw`: bytes of the file; `name`: of it.
    """
    try:
        return open_table(raw[:_HEADER_BYTES], name).header
    except ValueError:
        return ()


def example_record(muscle: Muscle) -> bytes:
    """Synthetic record of a virtual dynamometer, as a file.

    Its muscle is a little thicker and steeper than the `muscle`, as one that was built is.
    """
    from ..records import VirtualDynamometer
    from ..records.record import dumps

    machine = VirtualDynamometer(list(_PRESSURES), samples=60, both_ways=False)
    built = muscle.replace(
        outer_radius=1.02 * muscle.outer_radius, braid_angle=0.97 * muscle.braid_angle
    )
    return dumps(machine.record(built, seed=7)).encode()


def mismatch_reason(muscle: Muscle, record: Record) -> str:
    """Reason why a `record` can hardly be of this `muscle`, or stretches it; empty without one."""
    if stretched := extension_message(record.strain, lowest_strain(*strain_domain(muscle))):
        return stretched
    highest = float(np.clip(record.pressure.max(), 0.0, HIGHEST_PRESSURE))
    if not highest:
        return "The record has no pressure above zero: tension can't be fitted to it."
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


def measured_curves(muscle: Muscle, record: Record) -> MeasuredCurves:
    """Curves of a muscle at the pressures of a `record`."""
    level = assign_levels(record.pressure)
    levels = [number for number in np.unique(level) if number >= 0]
    count = len(levels)
    if count > MOST_CURVES:  # evenly among them
        levels = [levels[i] for i in np.linspace(0, count - 1, MOST_CURVES).astype(int)]
    pressures = np.array([record.pressure[level == number].mean() for number in levels])
    low, high = min(0.0, float(record.strain.min())), float(record.strain.max())
    strain = np.linspace(low, max(high, low + 0.01), _POINTS)
    force = np.asarray(muscle.force(np.clip(pressures, 0.0, HIGHEST_PRESSURE)[:, None], strain))
    return MeasuredCurves(pressures, strain, force, count)


def check_measured_curves(muscle: Muscle, record: Record, name: str) -> None:
    """Raise `ValueError` where a `muscle` has no curves at a record's strains."""
    try:
        measured_curves(muscle, record)
    except ValueError as error:
        raise ValueError(f"{name}: this muscle has no curve at its strains: {error}") from None


def preview_curves(muscle: Muscle) -> MeasuredCurves:
    """Curves of a muscle at the pressures of the example record."""
    pressures = np.array(_PRESSURES)
    free = float(muscle.free_strain(pressures[-1]))
    strain = np.linspace(0.0, max(free, 0.01), _POINTS)
    force = np.asarray(muscle.force(pressures[:, None], strain))
    return MeasuredCurves(pressures, strain, force, len(pressures))


def drawn_readings(record: Record) -> np.ndarray:
    """Indices of the readings that are drawn: all, or evenly among many."""
    return np.unique(np.linspace(0, len(record) - 1, min(len(record), MOST_POINTS)).astype(int))


def fittable_names(muscle: Muscle) -> tuple[str, ...]:
    """Names of the constants of a `muscle` that can be fitted."""
    from ..calibrate.parameters import parameters_of

    return tuple(parameters_of(muscle))


def fit_record(
    record: Record,
    muscle: Muscle,
    progress: Callable[[str], object],
    names: Sequence[str] = (AUTOMATIC,),
) -> "Selection":
    """Fit a muscle to a record.

    **Arguments:**

    - `record`: the readings.
    - `muscle`: the muscle.
    - `progress`: takes a line on what is being done.
    - `names`: what is fitted: `AUTOMATIC`, as `fascicle calibrate` chooses it; `TUNING`, the
      paper's; or some of `fittable_names`.

    **Returns:** the fit, and what it was chosen from.
    """
    from ..calibrate.fitting import fit
    from ..calibrate.model_selection import Selection, select_model

    if tuple(names) == (AUTOMATIC,):
        return select_model(record, muscle, starts=STARTS, tell=progress)
    progress("fitting")
    free = None if tuple(names) == (TUNING,) else list(names)
    return Selection(fit(record, muscle, free, starts=STARTS, whole=False))


def tuned_file(choice: "Selection", date: str) -> str:
    """Text of the fitted muscle's file, made on a `date`."""
    from ..files.calibration_files import calibrated_text

    return calibrated_text(choice.calibration, date, choice if choice.candidates else None)


def report_page(choice: "Selection", date: str) -> str:
    """Report of a fit, made on a `date`."""
    from ..calibrate.plot_data import figures
    from ..reports.calibration import report

    several = choice if choice.candidates else None
    return report(choice.calibration, date, figures(choice.calibration), choice=several)

"""Records of a visitor: reading within limits, a muscle's curves at their pressures, the fit."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..calibrate.data import assign_levels
from ..core.validation import HIGHEST_PRESSURE
from ..muscle import Muscle
from ..muscle.validation import extension_message, lowest_strain
from ..records import loads
from ..records.headers import MissingMetadataError
from ..records.record import Record
from ..units import pretty


if TYPE_CHECKING:
    from ..calibrate import Selection

LARGEST_FILE = 5_000_000  # bytes: a record of the most rows
MOST_ROWS = 100_000  # a fit to more takes minutes
MOST_CURVES, MOST_POINTS = 100, 4_000  # that are drawn: a browser draws them at once
STARTS = 2  # starting points of a fit: few, so that it doesn't take long
AUTOMATIC, TUNING = "automatic", "tuning"  # instead of names of constants to fit
_POINTS = 121  # along a curve
_PRESSURES = (0.0, 1e5, 2e5, 3e5, 4e5)  # Pa, of the example record
_TAIL = 0.02  # of the largest force: above it a muscle still pulls
_PLAUSIBLE = 1.4  # of the free strain: no muscle's own record pulls beyond it


class ModelCurves(NamedTuple):
    """A muscle's curves at pressures of a record: `pressure` [Pa], `strain` [-], `force` [N] by
    row; `total` of pressures in the record, of which `MOST_CURVES` at most have a curve.
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    total: int


def read_record(
    raw: bytes, name: str, muscle: Muscle, options: Mapping[str, object] | None = None
) -> Record:
    """Record of an uploaded file; the `muscle`'s length stands in for a missing rest length."""
    if not raw.strip():
        raise ValueError(f"{name}: the file is empty, {len(raw)} bytes.")
    if len(raw) > LARGEST_FILE:
        raise ValueError(f"{name}: a record may have {LARGEST_FILE} bytes, got {len(raw)}.")
    length = float(muscle.length)
    try:
        record = loads(raw, name, default_length=length, **dict(options or {}))
    except MissingMetadataError as error:
        raise ValueError(error.message(_in_page_words)) from None
    except ImportError as error:
        raise ValueError(f"{name}: {error}") from None
    if len(record) > MOST_ROWS:
        raise ValueError(
            f"{name}: a record may have {MOST_ROWS} rows here, got {len(record)}:"
            " thin it out, or use `fascicle calibrate`."
        )
    try:
        curves_at_levels(muscle, record)
    except ValueError as error:
        raise ValueError(f"{name}: this muscle has no curve at its strains: {error}") from None
    return record


def _in_page_words(argument: str, role: str, value: str) -> str:
    """An argument of the reader as the page has it."""
    fields = {"columns": "Column", "units": "Unit"}
    if not role or argument not in fields:
        return "`fascicle calibrate`, which takes more"
    return f"the field {fields[argument]} of {role}" + f", `{value}` for instance" * bool(value)


def example_record(muscle: Muscle) -> bytes:
    """Synthetic record, as a file, of a muscle a little thicker and steeper than the `muscle`."""
    from ..records import VirtualDynamometer, dumps

    machine = VirtualDynamometer(list(_PRESSURES), samples=60, both_ways=False)
    built = muscle.replace(
        outer_radius=1.02 * muscle.outer_radius, braid_angle=0.97 * muscle.braid_angle
    )
    return dumps(machine.record(built, seed=7)).encode()


def mismatch_reason(muscle: Muscle, record: Record) -> str:
    """Reason why a `record` doesn't suit this `muscle`; else empty."""
    if stretched := extension_message(record.strain, lowest_strain(muscle.law)):
        return stretched
    highest = float(np.clip(record.pressure.max(), 0.0, HIGHEST_PRESSURE))
    if not highest:
        return "The record has no pressure above zero: tension can't be fitted to it."
    pulls = record.strain[record.force > _TAIL * record.force.max()]
    farthest, free = float(pulls.max(initial=0.0)), float(muscle.free_strain(highest))
    if farthest <= _PLAUSIBLE * free:
        return ""
    length = muscle.length if record.rest_length is None else record.rest_length
    return (
        f"This record hardly fits this muscle: it pulls at a contraction of {farthest:.3g}, past"
        f" the muscle's free strain of {free:.3g}. Contractions are taken over a rest length of"
        f" {pretty(float(length), 'length')}: enter the record's Rest length if it differs, or open"
        " the muscle that was measured."
    )


def curves_at_levels(muscle: Muscle, record: Record) -> ModelCurves:
    """The model's curves at the mean pressures of a `record`'s levels, at most 100 of them."""
    level = assign_levels(record.pressure)
    levels = np.unique(level[level >= 0])
    drawn = levels[np.unique(np.linspace(0, len(levels) - 1, MOST_CURVES).astype(int))]
    pressure = np.array([record.pressure[level == number].mean() for number in drawn])
    low, high = min(0.0, float(record.strain.min())), float(record.strain.max())
    strain = np.linspace(low, max(high, low + 0.01), _POINTS)
    force = muscle.force(np.clip(pressure, 0.0, HIGHEST_PRESSURE)[:, None], strain)
    return ModelCurves(pressure, strain, np.asarray(force), len(levels))


def fit_record(
    record: Record,
    muscle: Muscle,
    progress: Callable[[str], object],
    names: Sequence[str] = (AUTOMATIC,),
) -> "Selection":
    """Model selected for a `record`: the best of all (`AUTOMATIC`), or a fit of the laws' `TUNING`
    or of constants by their `names`; `progress` takes each step.
    """
    from ..calibrate.fitting import fit
    from ..calibrate.model_selection import Selection, select_model

    if tuple(names) == (AUTOMATIC,):
        return select_model(record, muscle, starts=STARTS, progress=progress)
    progress("fitting")
    free = None if tuple(names) == (TUNING,) else list(names)
    return Selection(fit(record, muscle, free, starts=STARTS, whole=False))

"""Measured records against every law: the error of each law, and the trend of its residuals.

The records are public or a lab's own, and not in the repository: they are looked for under
`FASCICLE_DATA`, or beside the checkout. A record is a CSV as `fascicle calibrate` reads it, with
the muscle that was measured, by its nominal sizes, in a file beside it.
"""

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fascicle.calibrate.calibration import Calibration
from fascicle.calibrate.comparison import Row, compare_tension
from fascicle.calibrate.model_selection import Selection, select_model
from fascicle.files import load as load_muscle
from fascicle.muscle import Muscle
from fascicle.plot import to_bytes
from fascicle.records import load
from fascicle.records.record import Record
from fascicle.report.calibration_figures import draw_fit, fit_plot
from fascicle.report.calibration_words import (
    cause_words,
    interval_texts,
    selection_reasons,
    warning_lines,
)
from fascicle.report.page import Picture, data_uri, render, screen_width
from fascicle.units import pretty


VARIABLE = "FASCICLE_DATA"
UNTESTED = (
    "Uncensored measurements of the force with which a muscle resists, past its free strain, are"
    " not public: gauges that only pull clip them at zero. Buckling, collapse and the hinge are"
    " therefore untested by any record here, and so is the tension law past the free strain. The"
    " paper's own Fig. 12 is known only as a picture.",
    "A lab that has such a record can send it: a CSV with pressure, force that may be negative, and"
    " length, units in the header, and muscle.toml beside it with the nominal sizes, maker and how"
    " it was measured; CONTRIBUTING says how.",
)
# published sizes of records whose folder holds no muscle: length, radius, wall and braid angle; a
# maker's wall and angle aren't published, and only begin the fit
_SIZES = {
    "martens-boblan-2017/dmsp-20-300.csv": (
        0.3, 10e-3, 2e-3, math.radians(28.6),
        "Martens and Boblan (2017), doi:10.3390/act6040033, table A1, CC BY 4.0",
    ),
}  # fmt: skip
_CELLS = 8  # of strain: as few as a mean residual takes to show a trend
_MOST_CAUSES = 2  # of a misfit that are named
_PICTURE_WIDTH = 5.9  # inches, in print


@dataclass(frozen=True, eq=False)
class MeasuredRecord:
    """A measured `record` by its `name`, with the `muscle` of nominal sizes and their `source`; or
    why it is `left_out`.
    """

    name: str
    record: Record | None = None
    muscle: Muscle | None = None
    source: str = ""
    left_out: str = ""


@dataclass(frozen=True)
class LawError:
    """One law against a record.

    - `row`: its errors, within the fit and cross-validated, and its free constants.
    - `along_pressure`, `along_strain`: least and largest mean residual [N] at a pressure, and in
      an eighth of the strains; measured less the law's.
    - `constants`: value, ends of the 90 % interval [SI], and whether the data determine it.
    - `misses`: what it misses, in words.
    """

    row: Row
    along_pressure: tuple[float, float]
    along_strain: tuple[float, float]
    constants: Mapping[str, tuple[float, float, float, bool]]
    misses: str


@dataclass(frozen=True, eq=False)
class RecordComparison:
    """A `measured` record, the `choice` that a plain calibration makes, and the errors of all
    `laws`, the least cross-validated error first.
    """

    measured: MeasuredRecord
    choice: Selection
    laws: tuple[LawError, ...]


def run(
    folder: Path,
    records: Sequence[MeasuredRecord],
    progress: Callable[[str], object] = lambda _: None,
) -> list[RecordComparison]:
    """Compare every law with `records`; write page, tables and pictures into a `folder`.

    `progress` is called with a line on what is being done. Returns the records' comparisons, of
    those that aren't left out.
    """
    comparisons = []
    for record in records:
        if not record.left_out:
            progress(f"fitting {record.name}")
            comparisons.append(compare_laws(record))
    sections = []
    for number, comparison in enumerate(comparisons, start=1):
        picture = to_bytes(draw_fit(fit_plot(comparison.choice.calibration)), "png")
        (folder / f"record_{number}.png").write_bytes(picture)
        sections.append(_section(comparison, picture))
    left_out = [f"{record.name}: {record.left_out}" for record in records if record.left_out]
    page = render(
        "measurements.html", Path(__file__).parent, title="Measured muscles against every law",
        untested=UNTESTED, sections=sections, left_out=left_out,
        footer="fascicle reproduce measurements",
    )  # fmt: skip
    (folder / "report.html").write_text(page, encoding="utf-8")
    data = {
        "untested": UNTESTED, "left_out": left_out,
        "records": [_record_data(comparison) for comparison in comparisons],
    }  # fmt: skip
    text = json.dumps(_without_nan(data), indent=1, ensure_ascii=False)
    (folder / "measurements.json").write_text(text + "\n", encoding="utf-8")
    return comparisons


def measured_records() -> list[MeasuredRecord]:
    """Find every CSV in the data folder and its own folders, by name."""
    folder = data_folder()
    if folder is None:
        return []
    return [_measured_record(path, folder) for path in sorted(folder.rglob("*.csv"))]


def data_folder() -> Path | None:
    """Folder that measured records are looked for in; `None` where there is none."""
    folder = os.environ.get(VARIABLE)
    if folder is not None:
        return Path(folder) if Path(folder).is_dir() else None
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    return default if default.is_dir() else None


def no_records_message() -> str:
    """Line for the case that no record is in reach."""
    return (
        "no measured record was found: set"
        f" {VARIABLE} to a folder with CSV files, a muscle.toml beside each. {UNTESTED[0]}"
    )


def _measured_record(path: Path, folder: Path) -> MeasuredRecord:
    name = path.relative_to(folder).as_posix()
    candidates = [path.with_suffix(".toml"), path.with_name("muscle.toml")]
    # a record's own description may have the first of these names
    toml = next(
        (file for file in candidates if file.is_file()
         and "[muscle" in file.read_text(encoding="utf-8", errors="replace")), None,
    )  # fmt: skip
    if toml is None and name not in _SIZES:
        return MeasuredRecord(name, left_out="no muscle.toml with nominal sizes beside it")
    try:
        if toml is not None:
            muscle, source = load_muscle(toml), f"sizes from {toml.name}"
            if not isinstance(muscle, Muscle):
                return MeasuredRecord(name, left_out=f"{toml.name} holds more than one muscle")
        else:
            length, radius, wall, angle, source = _SIZES[name]
            muscle = Muscle(length, radius, wall, angle)
        record = load(path, rest_length=float(muscle.length))
    except (ValueError, OSError) as error:
        return MeasuredRecord(name, left_out=str(error))
    if record.synthetic:
        return MeasuredRecord(name, left_out="it is synthetic: a model made it")
    return MeasuredRecord(name, record, muscle, source)


def compare_laws(measured: MeasuredRecord) -> RecordComparison:
    """Fit every tension law to a record; laws published for one maker's muscle are as published."""
    record, muscle = measured.record, measured.muscle
    assert record is not None
    assert muscle is not None
    choice = select_model(record, muscle)
    names = list(choice.calibration.names) if choice.calibration.method == "constants" else None
    laws = compare_tension(record, muscle, names, whole=False)
    errors = [_law_error(row, laws.fits[row.label]) for row in laws.rows]
    errors.sort(key=lambda error: error.row.relative_left_out_rmse)
    return RecordComparison(measured, choice, tuple(errors))


def _law_error(errors: Row, fit: Calibration) -> LawError:
    grid = fit.grid
    residual = np.where(grid.measured, grid.force - fit.force, np.nan)
    used, strain = np.isfinite(residual), grid.strain
    by_pressure = [
        float(np.mean(row[mask])) for row, mask in zip(residual, used, strict=True) if mask.any()
    ]
    edges = np.quantile(strain[used], np.linspace(0, 1, _CELLS + 1))
    cell = np.clip(np.searchsorted(edges, strain, "right") - 1, 0, _CELLS - 1)
    by_strain = [
        float(np.mean(residual[used & (cell == i)]))
        for i in range(_CELLS)
        if np.any(used & (cell == i))
    ]
    constants = {
        constant.name: (constant.value, constant.low, constant.high, constant.identifiable)
        for constant in fit.parameters
    }
    return LawError(
        errors, (min(by_pressure), max(by_pressure)), (min(by_strain), max(by_strain)),
        constants, _misfit(fit),
    )  # fmt: skip


def _misfit(fit: Calibration) -> str:
    """Trend of a fit's residuals in words."""
    if fit.diagnosis.is_white_noise:
        return "nothing visible: the residuals could be noise"
    trends = [
        f"{trend.along} ({_share(trend.share)} of their squares)"
        for trend in fit.diagnosis.significant
    ]
    trends = trends or [f"{run.along}, by runs of one sign" for run in fit.diagnosis.autocorrelated]
    causes = [cause_words(vars(cause))[0] for cause in fit.diagnosis.causes[:_MOST_CAUSES]]
    most = f"; likely cause: {' or '.join(causes)}" if causes else "; no known cause"
    return f"residuals vary with {', '.join(trends)}{most}"


def _share(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.005 else "less than 1 %"


def _section(comparison: RecordComparison, picture: bytes) -> dict[str, Any]:
    """Values of a record's section on the page."""
    fit, measured = comparison.choice.calibration, comparison.measured
    return {
        "measured": measured, "fit": fit, "reasons": selection_reasons(comparison.choice),
        "picture": Picture(data_uri(picture, "png"), screen_width(_PICTURE_WIDTH)),
        "laws": [
            [
                law.row.label, law.row.free, _percent(law.row.relative_rmse),
                _percent(law.row.relative_left_out_rmse),
                *(f"{low:+.3g} to {high:+.3g} N" for low, high in
                  (law.along_pressure, law.along_strain)),
                law.misses,
            ]
            for law in comparison.laws
        ],
        "constants": [
            [constant.name, pretty(constant.value, constant.dimension), interval_texts(constant)[1],
             "yes" if constant.identifiable else "no"]
            for constant in fit.parameters
        ],
    }  # fmt: skip


def _record_data(comparison: RecordComparison) -> dict[str, Any]:
    fit = comparison.choice.calibration
    return {
        "name": comparison.measured.name, "source": comparison.measured.source,
        "reasons": selection_reasons(comparison.choice), "warnings": warning_lines(fit),
        "chosen": list(fit.names),
        "laws": [
            {
                **vars(law.row), "bias_along_pressure": list(law.along_pressure),
                "bias_along_strain": list(law.along_strain), "misses": law.misses,
                "constants": {
                    name: dict(zip(("value", "low", "high", "identifiable"), values, strict=True))
                    for name, values in law.constants.items()
                },
            }
            for law in comparison.laws
        ],
    }  # fmt: skip


def _percent(share: float) -> str:
    return f"{share:.2%}" if math.isfinite(share) else "-"


def _without_nan(value: Any) -> Any:
    """Data with `None` where a number isn't finite, as JSON has it."""
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

"""Tab of measured data: records within limits, the muscle's curves, and the muscle fitted to it."""

import datetime as dt
from collections.abc import Callable, Mapping
from functools import partial
from typing import ClassVar, NamedTuple

import numpy as np
import panel as pn

from ..calibrate import Selection
from ..calibrate.data import assign_levels
from ..calibrate.gauges import strain_scale
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, check_positive
from ..files.calibration_files import calibrated_text
from ..muscle import Muscle
from ..muscle.validation import extension_message, lowest_strain
from ..plot.theme import Colors
from ..records import loads
from ..records.headers import USUAL_UNITS, MissingMetadataError, dimension_of, is_unit
from ..records.record import Record
from ..report import calibration_words as words
from ..report.calibration import CalibrationResult, report
from ..report.calibration_figures import draw_fit, figures, measured_with_curves
from ..report.words import record_lines
from ..results import Table, Variable
from ..units import pretty
from . import widgets as ui
from .chart import Chart, padded_range, pressure_colors, screen_height
from .state import Session, View, view_of
from .tab import WAITING, Export, Job, LatestResult, Tab, output_stem
from .texts import TEXTS


LARGEST_FILE = 5_000_000  # bytes: a record of the most rows
MOST_ROWS = 100_000  # a fit to more takes minutes
MOST_CURVES, MOST_POINTS = 100, 4_000  # that are drawn: a browser draws them at once
STARTS = 2  # starting points of a fit: few, so that it doesn't take long
AUTOMATIC, TUNING = "automatic", "tuning"  # kinds of a fit
KINDS = {"what the data determine": AUTOMATIC, "the paper's tuning": TUNING}  # by label
_POINTS = 121  # along a curve
_PRESSURES = (0.0, 1e5, 2e5, 3e5, 4e5)  # Pa, of the example record
_TAIL = 0.02  # of the largest force: above it a muscle still pulls
_PLAUSIBLE = 1.4  # of the free strain: no muscle's own record pulls beyond it
_SIDE, _GAP = 0.015, 0.06  # of a range: room around the readings and the labels of pressures
_MARGIN = 220  # pixels of the screen beside the figure
_EXAMPLE = "example.csv"
RECORD_SUFFIXES = ".csv,.txt,.tsv,.dat,.lvm,.xlsx,.mat"
_MOST_LABELS = 8  # more would collide
_MOST_NOTES = 12  # of a record
_TITLES = {"columns": "Column", "units": "Unit"}  # of fields of these arguments
_ROLES = ("pressure", "force", "strain", "displacement", "length")  # of columns that have fields
# as measured with 300 and 5000 readings on two cores
_DURATIONS = {AUTOMATIC: "20 to 40 s", TUNING: "10 s"}


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
    if role not in _ROLES or argument not in _TITLES:
        return "`fascicle calibrate`, which takes more"
    return f"the field {_TITLES[argument]} of {role}" + f", `{value}` for instance" * bool(value)


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
    contraction = strain_scale(record, muscle) * record.strain
    if stretched := extension_message(contraction, lowest_strain(muscle.law)):
        return stretched
    highest = float(np.clip(record.pressure.max(), 0.0, HIGHEST_PRESSURE))
    if not highest:
        return "The record has no pressure above zero: tension can't be fitted to it."
    pulls = contraction[record.force > _TAIL * record.force.max()]
    farthest, free = float(pulls.max(initial=0.0)), float(muscle.free_strain(highest))
    if farthest <= _PLAUSIBLE * free:
        return ""
    length = record.rest_length or float(muscle.length)
    return (
        f"This record hardly fits this muscle: it pulls at a contraction of {farthest:.3g}, past"
        f" the muscle's free strain of {free:.3g}. The record's strains refer to a rest length of"
        f" {pretty(length, 'length')}: enter the muscle's length and the record's, or open"
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
    contraction = strain_scale(record, muscle) * strain
    force = muscle.force(np.clip(pressure, 0.0, HIGHEST_PRESSURE)[:, None], contraction)
    return ModelCurves(pressure, strain, np.asarray(force), len(levels))


def fit_record(
    record: Record,
    muscle: Muscle,
    progress: Callable[[str], object],
    kind: str = AUTOMATIC,
) -> Selection:
    """Model selected for a `record`: the best of all (`AUTOMATIC`), or a fit of the laws' `TUNING`;
    `progress` takes each step.
    """
    from ..calibrate.fitting import fit
    from ..calibrate.model_selection import select_model

    try:
        if kind == AUTOMATIC:
            return select_model(record, muscle, starts=STARTS, progress=progress)
        progress("fitting")
        return Selection(fit(record, muscle, starts=STARTS, whole=False))
    except InvalidInputError as error:
        if error.argument != "record":
            raise
        # the page can't name constants, which is the library's remedy
        other = next(label for label, value in KINDS.items() if value != kind)
        remedy = f"choose {other} at What to fit, or check the muscle's sizes and the rest length"
        raise InvalidInputError("record", error.rule, None, remedy) from None


class RecordInputs:
    """Fields for information that a record's file lacks; a `change` reads it again."""

    def __init__(self, change: Callable[[], None]):
        label, self._change = "Rest length, if the record doesn't have it", change
        self._options: dict[str, dict[str, str]] = {"columns": {}, "units": {}}
        self.length = ui.Field(label, "rest_length", "length", self._set_length, optional=True)
        self._length: float | None = None
        label = "A force of exactly 0 means 0 or less"
        style = {"margin": (6, 8)}
        self.clipped = ui.widget(pn.widgets.Checkbox, label, lambda _: change(), **style)
        self.fields = {
            (kind, role): ui.Field(
                f"{_TITLES[kind]} of {role}", role, "", partial(self._set_text, kind, role)
            )
            for role in _ROLES
            for kind in self._options
        }
        cells = [ui.column(*field.widgets) for field in self.fields.values()]
        fold = ui.fold("Columns and units", ui.column(*cells, kind="pairs"))
        self._toggle = fold[0]
        self.panel = ui.column(*self.length.widgets, self.clipped, fold)

    def show(self, view: View) -> None:
        self.length.show(self._length, view.display_units["length"])

    def show_error(self, error: MissingMetadataError) -> bool:
        """Show an `error` of reading at the field that it names; False where there is none."""
        field = self.fields.get((error.argument, error.role))
        if field is not None:
            self._toggle.value = True
            field.show_error(error.message(_in_page_words))
        return field is not None

    def clear_errors(self) -> None:
        for field in self.fields.values():
            field.show_error("")

    def options(self) -> dict[str, object]:
        """Arguments of `records.load`."""
        options = {"rest_length": self._length, "clipped_at_zero": self.clipped.value}
        return {name: value for name, value in (options | self._options).items() if value}

    def _set_length(self, value: float | None) -> None:
        self._length = None if value is None else float(check_positive(value, "rest_length", "m"))
        self._change()

    def _set_text(self, kind: str, role: str, text: str) -> None:
        """Set the column or the unit of a role, or clear it; `ValueError` for no unit of it."""
        if text and kind == "units" and not is_unit(text, dimension_of(role)):
            gauge, usual = " (gauge)" * (role == "pressure"), USUAL_UNITS.get(role, "%")
            raise InvalidInputError(role, f"must be a unit{gauge}, such as {usual}", text)
        options = {name: value for name, value in self._options[kind].items() if name != role}
        self._options[kind] = options | ({role: text} if text else {})
        self._change()


class FitResult(NamedTuple):
    """Result of a fit, with its report and the tuned muscle's file."""

    selection: Selection
    report: str
    toml: str


class DataView(Tab):
    """Widgets and figure of measured data."""

    name: ClassVar[str] = "data"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self.record: Record | None = None
        self.fit: FitResult | None = None
        self._raw, self.file_name = b"", ""  # of the record that was opened last
        self._add_widgets()
        self._add_chart()
        self._curves = LatestResult(self._show_curves, self.message.show, self.is_open)
        # a file's reader may take a minute, in another process
        self._reads = LatestResult(self._show_record, self._fail_read, self.is_open, WAITING)
        inputs = (self.file, self._other_example, self.message.pane, self.read_inputs.panel)
        fit = (self.kind, self.job.run, self.job.cancel, self.job.bar)
        results = (self.status, self.table, self.use, ui.row(*self.saves, kind=""), self.fit_notes)
        left = ui.side_column(*inputs, *fit, *results, self.notes, width=420)
        text = TEXTS["data"]["empty"].format(rows=MOST_ROWS) + TEXTS["data"]["form"]
        self.empty_state = ui.column(ui.pane(text), self._example, kind="framed", margin=8)
        self._figure = ui.column(self.chart.new_pane(), visible=False)
        self.panel = ui.row(left, ui.column(self.empty_state, self._figure, kind="equal"))

    def _add_widgets(self) -> None:
        label = "Open a record (CSV, .xlsx, .mat)"
        self.file = ui.file_input(label, RECORD_SUFFIXES, self.open_record)
        label, wide = "Try an example record (synthetic)", {"sizing_mode": "stretch_width"}
        self._example = ui.button(label, self.open_example, color="primary", **wide)
        self._other_example = ui.button(label, self.open_example, visible=False, **wide)
        self.read_inputs = RecordInputs(self._read)
        self.kind = ui.dropdown("What to fit", KINDS)
        wide |= {"margin": (6, 8)}
        self.job = Job(self, "Calibrate the muscle", self.start_fit, self._show_fit, **wide)
        self.fit_notes = ui.wide_pane()
        self.table = ui.pane(margin=(4, 8))
        self.use = ui.button("Use the tuned muscle in all tabs", self._use_tuned_muscle, **wide)
        tuned, report = partial(self._as_file, "tuned"), partial(self._as_file, "report")
        self.saves = [
            ui.download_button("Download tuned muscle", tuned, self.message, width=190),
            ui.download_button("Download report", report, self.message),
        ]
        self.job.run.disabled = True
        self._enable_results(False)

    @property
    def shown_record(self) -> Record | None:
        """The record, if any; after a fit as the fit has corrected it for errors of its gauges."""
        return self.record if self.fit is None else self.fit.selection.calibration.record

    def draw(self, view: View) -> None:
        self.chart.figure.yaxis[0].axis_label = f"Force F [{view.display_units['force']}]"
        self.read_inputs.show(view)
        record, fit = self.shown_record, self.fit
        if record is None:
            return

        def compute() -> tuple[ModelCurves, ModelCurves | None]:
            tuned = fit and curves_at_levels(fit.selection.calibration.muscle, record)
            return curves_at_levels(view.muscle, record), tuned

        self._curves.request(compute)

    def export(self) -> Export:
        record = self.shown_record
        if record is None:
            raise ValueError("Open a record first: there is nothing to download yet.")
        drawn, label = self.session.view.muscle, "the muscle"
        if self.fit is not None:
            drawn, label = self.fit.selection.calibration.muscle, "tuned"
        contraction = strain_scale(record, drawn) * record.strain
        force = drawn.force(np.clip(record.pressure, 0.0, HIGHEST_PRESSURE), contraction)
        reading = partial(Variable, ("reading",))
        variables = Table(
            {
                "pressure": reading(record.pressure, "Pa"),
                "strain": reading(record.strain, "-"),
                "force": reading(record.force, "N"),
                "muscle": reading(np.asarray(force), "N"),
            }
        )
        stem = output_stem(self.file_name, "comparison")
        return Export(stem, variables, lambda: draw_fit(measured_with_curves(record, drawn, label)))

    def _add_chart(self) -> None:
        height = screen_height(_MARGIN)
        chart = self.chart = Chart(self.colors, "Contraction ε [–]", "Force F [N]", height)
        self.readings = chart.add("readings")
        self._before, self._after = chart.add("untuned"), chart.add("tuned")
        self._labels = chart.new_source("x y label")
        chart.add_labels(self._labels)
        chart.add_zero_line()
        _, self._tuned = chart.style_legend()

    def open_example(self) -> None:
        self.file.clear()  # the example replaces it
        self.open_record(example_record(self.session.view.muscle), _EXAMPLE)

    def open_record(self, raw: bytes, name: str) -> None:
        """Open a file; the earlier record is dropped, even if the file can't be read."""
        self._raw, self.file_name = raw, name
        self._set_record(None)
        self.notes.object = ""
        self._read()

    def _read(self) -> None:
        """Read the file with the options in the fields; an error leaves the last picture."""
        view, name = self.session.view, self.file_name
        if not name:
            return
        raw, options = self._raw, self.read_inputs.options()
        self.read_inputs.clear_errors()
        self.message.show("")
        self.status.object = ui.status_line(f"reading {ui.text_html(name)}")
        self._reads.request(lambda: (raw, read_record(raw, name, view.muscle, options)))

    def _fail_read(self, error: ValueError | str) -> None:
        is_missing = isinstance(error, MissingMetadataError)
        if not (is_missing and self.read_inputs.show_error(error)):
            self.fail(error.message(_in_page_words) if is_missing else error)
        self.status.object = ""

    def _show_record(self, content: tuple[bytes, Record]) -> None:
        raw, record = content
        if raw is not self._raw:  # another file was opened meanwhile
            return
        view, name = self.session.view, self.file_name
        self.message.show(mismatch_reason(view.muscle, record))
        self._set_record(record)
        count = (
            f"{len(record)}{' synthetic' * (name == _EXAMPLE)} reading{'s' * (len(record) != 1)}"
        )
        lines = record_lines(record)[:_MOST_NOTES]
        notes = "".join(f"<li>{ui.text_html(line)}</li>" for line in lines)
        self.notes.object = f'<div class="note">{count}.<ul>{notes}</ul></div>'
        with pn.io.unlocked():
            self.draw(view)

    def _set_record(self, record: Record | None) -> None:
        """Take a `record`, or none; drop any fit, and reset results and buttons."""
        self.record, self.fit = record, None
        self.job.stop()
        self.job.run.disabled = record is None
        self.table.object = self.fit_notes.object = ""
        self.empty_state.visible, self._figure.visible = record is None, record is not None
        self._other_example.visible = record is not None
        self._enable_results(False)

    def _enable_results(self, enabled: bool) -> None:
        for result in (self.use, *self.saves):
            result.disabled = not enabled

    def _show_curves(self, pair: tuple[ModelCurves, ModelCurves | None]) -> None:
        before, after = pair
        _, scale = self.unit("force")
        number = len(before.pressure)
        colors = pressure_colors(self.colors, number)
        record = self.shown_record
        assert record is not None  # else nothing is drawn
        drawn = np.unique(np.linspace(0, len(record) - 1, MOST_POINTS).astype(int))
        strain, force = record.strain[drawn], record.force[drawn]
        nearest = np.abs(record.pressure[drawn, None] - before.pressure).argmin(axis=1)
        fills = [colors[i] for i in nearest]
        self.readings.data = {"x": strain, "y": force / scale, "color": fills}
        self._tuned.visible = after is not None
        for source, curves in ((self._before, before), (self._after, after)):
            ys = [] if curves is None else list(curves.force / scale)
            source.data = {"xs": [before.strain] * len(ys), "ys": ys, "color": colors[: len(ys)]}
        labeled = np.unique(np.linspace(0, number - 1, min(number, _MOST_LABELS)).astype(int))
        unit, pressure_scale = self.unit("pressure")
        self._labels.data = {
            "x": [float(before.strain[0])] * len(labeled),
            "y": before.force[labeled, 0] / scale,
            "label": [f"{before.pressure[i] / pressure_scale:.3g} {unit}" for i in labeled],
        }
        text = f"Curves of {number} of {before.total} pressures are drawn."
        self.status.object = ui.status_line(text if before.total > number else "")
        tuned = ", and of the tuned one" if after is not None else ""
        low, high = (f"{P / pressure_scale:.3g}" for P in before.pressure[[0, -1]])
        self.chart.describe(
            f"Force over contraction. {len(strain)} readings; curves of this muscle{tuned} at {low}"
            f" to {high} {unit}."
        )
        forces = np.r_[force, before.force.ravel()] / scale
        self.chart.set_ranges(padded_range(before.strain, _SIDE), padded_range(forces, _GAP))

    def start_fit(self) -> None:
        record, muscle, kind = self.record, self.session.view.muscle, self.kind.value
        if record is None:
            return

        def compute(is_cancelled: Callable[[], bool]) -> FitResult:
            def progress(_: str) -> None:
                if is_cancelled():
                    raise ValueError("The fit was canceled.")

            selection = fit_record(record, muscle, progress, kind)
            calibration, today = selection.calibration, f"{dt.datetime.now().astimezone():%Y-%m-%d}"
            candidates = selection if selection.candidates else None
            progress("drawing the report")
            page = report(CalibrationResult(calibration, candidates), today, figures(calibration))
            lines = words.warning_lines(calibration), record_lines(record)
            return FitResult(selection, page, calibrated_text(calibration, today, *lines))

        usual = f"it usually takes {_DURATIONS[kind]}, longer on a busy machine"
        self.job.start(f"fitting: {usual}", compute)

    def _show_fit(self, fit: FitResult) -> None:
        self.fit, calibration = fit, fit.selection.calibration
        rows = []
        for parameter in calibration.parameters:
            value, interval = words.interval_texts(parameter)
            text = interval if parameter.identifiable else "not known from these data"
            rows.append((parameter.name.replace("_", " "), value, text))
        self.table.object = ui.html_table(("parameter", "value", "90 % interval"), rows)
        lines, _ = words.verdict_lines(calibration, fit.selection)
        lines = [*lines, *words.selection_reasons(fit.selection)]
        if not all(parameter.identifiable for parameter in calibration.parameters):
            lines.append(TEXTS["data"]["undetermined"])
        doubts = (
            f"<b>{topic.capitalize()}</b>{ui.status_line('<br>'.join(map(ui.text_html, texts)))}"
            for topic, texts in words.warnings_by_topic(calibration).items()
        )
        notes = (ui.status_line(ui.text_html(line)) for line in lines if line)
        self.fit_notes.object = "".join([*notes, *doubts])
        self._enable_results(True)
        self.draw(self.session.view)

    def _as_file(self, kind: str) -> tuple[str, bytes]:
        assert self.fit is not None  # else the button is disabled
        text, suffix = (self.fit.report, "html") if kind == "report" else (self.fit.toml, "toml")
        stem = output_stem(self.file_name, kind)
        return f"{stem}.{suffix}", text.encode()

    def _use_tuned_muscle(self) -> None:
        assert self.fit is not None  # else the button is disabled
        muscle = self.fit.selection.calibration.muscle
        self.session.open(view_of(muscle, "tuned muscle", self.session.view))

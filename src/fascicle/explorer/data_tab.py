"""Tab of measured data: a record and the muscle's curves, and the muscle fitted to it."""

import datetime as dt
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
import panel as pn

from ..calibrate import Calibration, Selection
from ..calibrate.messages import fit_data_lines, hysteresis_message, interval_texts
from ..calibrate.parameters import parameters_of
from ..calibrate.plot_data import figures
from ..files.calibration_files import calibrated_text
from ..muscle import Muscle
from ..plot.theme import APART, Colors
from ..records.record import Record
from ..report.calibration import report
from ..report.calibration_words import verdict_lines, warning_lines, warnings_by_topic
from .chart import Chart, padded_range, pressure_colors, screen_height
from .exports import Export, data, download_button, download_buttons, output_stem
from .measured import (
    AUTOMATIC,
    MOST_POINTS,
    MOST_ROWS,
    TUNING,
    ModelCurves,
    curves_at_levels,
    example_record,
    fit_record,
    mismatch_reason,
    preview_curves,
    read_headers,
    read_record,
)
from .state import Session, View, view_of
from .tab import LatestResult, Progress, Tab
from .theme import column, height_css, pane, row, side_column
from .widgets import (
    WHOLE_ROW,
    button,
    dropdown,
    file_input,
    html_table,
    parse_field,
    status_line,
    text_html,
    widget,
)


_SIDE, _GAP = 0.015, 0.06  # of a range: room around the readings and the labels of pressures
_MARGIN, _MARGIN_EMPTY = 220, 440  # pixels of the screen beside the figure; without a record
_EXAMPLE = "example.csv"
RECORD_SUFFIXES = ".csv,.txt,.tsv,.dat,.lvm,.xlsx,.mat"
_REST_SHARE = 0.04  # of the strains drawn, where the labels of curves stand
_MOST_LABELS = 8  # more would collide
_ROLES = ("pressure", "force", "strain", "displacement", "length")  # of columns that have fields
_DETECT = "(automatic)"
_WIDE: dict[str, Any] = {"sizing_mode": "stretch_width"}
_BY_NAME = "constants of your choice"
_STAGES = ("fitting", "drawing")  # that are verbs
# as measured with 300 and 5000 readings on two cores
_DURATIONS = {AUTOMATIC: "20 to 40 s", TUNING: "10 s", _BY_NAME: "a few seconds"}
_UNDETERMINED = (
    "Here a prior is a value that you enter: measure the size, enter it in the tab Muscle, and fit"
    f" {_BY_NAME} without it. fascicle calibrate takes its deviation, too."
)
_TITLE = "Your own muscle, as it was measured"
_TEXT = (
    "Open a dynamometer's CSV, .xlsx or .mat: pressure, force, and strain, length or displacement,"
    " with units in its header. Its readings appear here beside this muscle's curves; then the"
    " muscle is tuned to them, with an interval for each constant. At most"
    f" {MOST_ROWS} rows; they stay in this session's memory. No record at hand? There is a"
    " synthetic one of this muscle, a little thicker and steeper than drawn."
)
# a form to fill in: nobody's readings
_FORM = """pressure [kPa],strain [-],force [N]
100,0.00,…
100,0.02,…
200,0.00,…"""


class RecordInputs:
    """Fields for information that a record's file lacks; a change reads it again."""

    def __init__(self, on_change: Callable[[], None]):
        self._on_change, self._updating = on_change, False
        label = "Rest length, if the record doesn't have it"
        self.length = widget(pn.widgets.TextInput, label, self._change, **WHOLE_ROW)
        label = "A force of exactly 0 means 0 or less"
        self.clipped = widget(pn.widgets.Checkbox, label, self._change, margin=(6, 8), **WHOLE_ROW)
        self.toggle = widget(pn.widgets.Toggle, "Show columns and units", margin=(4, 8))
        self.columns = {
            role: dropdown(f"Column of {role}", [_DETECT], self._change) for role in _ROLES
        }
        self.units = {
            role: widget(pn.widgets.TextInput, f"Unit of {role}", self._change) for role in _ROLES
        }
        pairs = [w for role in _ROLES for w in (self.columns[role], self.units[role])]
        # a grid's style would show it: the column around it can be hidden
        fields = column(column(*pairs, kind="pairs"), kind="whole-row", visible=False)
        self.toggle.link(fields, value="visible")
        self.panel = column(self.length, self.clipped, self.toggle, fields, kind="pairs")

    def _change(self, _: Any) -> None:
        if not self._updating:
            self._on_change()

    def offer(self, headers: Sequence[str]) -> None:
        """Offer the columns of a file by their `headers`; all are chosen automatically at first."""
        self._updating = True
        for choice in self.columns.values():
            choice.param.update(options=[_DETECT, *headers], value=_DETECT)
        self._updating = False

    def options(self, length_unit: str) -> dict[str, Any]:
        """Arguments of `records.load` in the fields; a bare rest length is in the `length_unit`.

        Raises `ValueError` for a rest length that can't be read.
        """
        text = self.length.value.strip()
        options = {
            "columns": {r: w.value for r, w in self.columns.items() if w.value != _DETECT},
            "units": {r: w.value.strip() for r, w in self.units.items() if w.value.strip()},
            "rest_length": text and parse_field(text, "length", length_unit, "rest_length"),
            "clipped_at_zero": self.clipped.value,
        }
        return {name: value for name, value in options.items() if value}


class FitResult(NamedTuple):
    """Result of a fit to a `record`, with the `muscle` before it and the `names` of constants."""

    selection: Selection
    report: str
    record: Record
    muscle: Muscle
    names: tuple[str, ...]

    @property
    def calibration(self) -> Calibration:
        """Calibration of the `selection`: its best candidate, or the only fit."""
        return self.selection.calibration

    @property
    def candidates(self) -> Selection | None:
        """The selection, if there was one among several fits; else `None`."""
        return self.selection if self.selection.candidates else None


class DataView(Tab):
    """Widgets and figure of measured data."""

    name: ClassVar[str] = "data"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self.record: Record | None = None
        self.fit: FitResult | None = None
        self._raw, self.file_name = b"", ""  # of the record that was opened last
        self._read_options: Mapping[str, Any] = {}
        self._stage = ""  # of a fit
        self._cancelled = threading.Event()
        self._add_widgets()
        self._add_chart()
        self._curves = LatestResult(self._show_curves, self.message.show, is_open=self.is_open)
        self._fits = LatestResult(self._show_fit, self._fail_fit, is_open=self.is_open)
        left = side_column(
            self.file, self._other_example, self.message.pane, self.read_inputs.panel, self.kind,
            self.constants, self.calibrate, self.cancel, self.progress.bar, self.status, self.table,
            self.use, row(*self.saves, kind=""), self.fit_notes, self.notes, width=420,
        )  # fmt: skip
        self.empty_state = _empty_state(self._example)
        self._download_row = row(
            *self.record_downloads, kind="wrapped", visible=False, margin=(0, 8)
        )
        parts = (self.empty_state, self.chart.new_pane(), self._download_row,
                 self.download_message.pane)  # fmt: skip
        self.panel = row(left, column(*parts, kind="equal"))

    def _add_widgets(self) -> None:
        self.file = file_input(
            "Open a record (CSV, .xlsx, .mat)", RECORD_SUFFIXES, self.open_record
        )
        self._example, self._other_example = (
            button("Try an example record (synthetic)", self.open_example, color=color,
                   visible=visible, sizing_mode="stretch_width")
            for color, visible in (("primary", True), ("default", False))
        )  # fmt: skip
        self.read_inputs = RecordInputs(self._read)
        kinds = {"what the data determine": AUTOMATIC, "the paper's tuning": TUNING,
                 _BY_NAME: _BY_NAME}  # fmt: skip
        self.kind = dropdown(
            "What to fit", kinds,
            lambda kind: self.constants.param.update(visible=kind == _BY_NAME),
        )  # fmt: skip
        self.constants = widget(
            pn.widgets.MultiSelect, "Constants", size=6, visible=False, css_classes=["several"]
        )
        wide = {"margin": (6, 8), "disabled": True, **_WIDE}
        self.calibrate = button("Calibrate the muscle", self.start_fit, color="primary", **wide)
        self.cancel = button("Cancel the fit", self.cancel_fit, visible=False, **wide)
        self.cancel.disabled = False
        self.status, self.fit_notes = (pane(**_WIDE) for _ in range(2))
        self.progress = Progress("fitting", self.status, self.is_open)
        self.table = pane(margin=(4, 8))
        self.use = button("Use the tuned muscle in all tabs", self._use_tuned_muscle, **wide)
        self.saves = [
            download_button(
                "Download tuned muscle", "toml",
                lambda: self._as_file("tuned", self._tuned_muscle_toml()), self.download_message,
                disabled=True, width=184,
            ),
            download_button(
                "Download report", "html", lambda: self._as_file("report", self._shown_fit.report),
                self.download_message, disabled=True,
            ),
        ]  # fmt: skip
        self.record_downloads = download_buttons(self.export, self.download_message, disabled=True)

    def draw(self, view: View) -> None:
        """Show force curves of the muscle and the fit, at the record's pressures, if any."""
        self.chart.figure.yaxis[0].axis_label = f"Force F [{view.display_units['force']}]"
        record, fit = self.record, self.fit

        def compute() -> tuple[ModelCurves, ModelCurves | None]:
            if record is None:
                return preview_curves(view.muscle), None
            before = curves_at_levels(view.muscle, record)
            return before, fit and curves_at_levels(fit.calibration.muscle, record)

        self._curves.request(compute)

    def _add_chart(self) -> None:
        """Add the chart of force over strain."""
        chart = self.chart = Chart(
            self.colors, "Contraction ε [–]", "Force F [N]", screen_height(_MARGIN_EMPTY)
        )
        self.readings = chart.add(
            "scatter", "x y color", "readings", size=4, color="color", alpha=0.55,
            legend_label="measured",
        )  # fmt: skip
        self._before = chart.add(
            "multi_line", "xs ys color", "untuned", line_width=1.5, line_dash="dashed",
            legend_label="this muscle",
        )  # fmt: skip
        self._after = chart.add(
            "multi_line", "xs ys color", "tuned", line_width=2.6, legend_label="tuned"
        )
        self._labels = chart.new_source("x y label")
        chart.add_labels(self._labels)
        chart.add_zero_line()
        self._measured_entry, _, self._tuned_entry = chart.style_legend()

    # the record

    def open_example(self) -> None:
        """Open the synthetic record of the session's muscle."""
        self.file.clear()  # the example replaces it
        self.open_record(example_record(self.session.view.muscle), _EXAMPLE)

    def open_record(self, raw: bytes, name: str) -> None:
        """Open a file; the earlier record is dropped, even if the file can't be read."""
        self._raw, self.file_name = raw, name
        self.session.input_names.add(name)
        self.read_inputs.offer(read_headers(raw, name))
        self._set_record(None)
        self.notes.object = ""
        self._read()
        if self.record is None:
            self.draw(self.session.view)

    def _read(self) -> None:
        """Read the file with the options in the fields; an error leaves the last picture."""
        view, name = self.session.view, self.file_name
        if not name:
            return
        try:
            options = self.read_inputs.options(view.display_units["length"])
            record = read_record(self._raw, name, view.muscle, options)
        except ValueError as error:
            self.message.show(error)
            self.read_inputs.toggle.value = bool(self._raw)  # columns and units may help
            return
        self._read_options = options
        names = parameters_of(view.muscle)
        self.constants.options = {name.replace("_", " "): name for name in names}
        self.message.show(mismatch_reason(view.muscle, record))
        self._set_record(record)
        kind = " synthetic" if name == _EXAMPLE else ""
        plural = "s" * (len(record) != 1)
        notes = "".join(f"<li>{text_html(note)}</li>" for note in record.notes[:12])
        self.notes.object = (
            f'<div class="note">{len(record)}{kind} reading{plural}.<ul>{notes}</ul></div>'
        )
        with pn.io.unlocked():
            self.draw(view)

    def _set_record(self, record: Record | None) -> None:
        """Take a `record`, or none; drop any fit, and reset results and buttons."""
        self.record, self.fit = record, None
        self._end_fit()
        self.table.object = self.fit_notes.object = ""
        exists = record is not None
        self.empty_state.visible = not exists
        self._download_row.visible = self._other_example.visible = exists
        self.enable([self.use, *self.saves], False)
        self.enable(self.record_downloads, exists)

    def _show_curves(self, pair: tuple[ModelCurves, ModelCurves | None]) -> None:
        """Show a muscle's curves before and after tuning, beside the readings."""
        before, after = pair
        _, scale = self.unit("force")
        number = len(before.pressure)
        colors = pressure_colors(self.colors, number)
        strain, force, nearest = self._drawn_readings(before.pressure)
        self.readings.data = {
            "x": strain, "y": force / scale, "color": [colors[i] for i in nearest]
        }  # fmt: skip
        margin = _MARGIN_EMPTY if self.record is None else _MARGIN
        self.chart.figure.stylesheets = [height_css(screen_height(margin))]
        self._measured_entry.visible = self.record is not None
        self._tuned_entry.visible = after is not None
        for source, curves in ((self._before, before), (self._after, after)):
            rows = [] if curves is None else list(curves.force / scale)
            source.data = {
                "xs": [before.strain] * len(rows),
                "ys": rows,
                "color": colors[: len(rows)],
            }
        labeled = np.unique(np.linspace(0, number - 1, min(number, _MOST_LABELS)).astype(int))
        # above the readings, too, which lie at rest
        is_near_rest = strain < before.strain[0] + _REST_SHARE * np.ptp(before.strain)
        tops = [max([before.force[i, 0], *force[is_near_rest & (nearest == i)]]) for i in labeled]
        unit, pressure_scale = self.unit("pressure")
        self._labels.data = {
            "x": [float(before.strain[0])] * len(labeled),
            "y": np.array(tops) / scale,
            "label": [f"{before.pressure[i] / pressure_scale:.3g} {unit}" for i in labeled],
        }
        self.status.object = status_line(
            f"Curves of {number} of {before.total} pressures are drawn."
            if before.total > number else ""
        )  # fmt: skip
        readings = "No" if self.record is None else f"{len(self.record)}"
        tuned = ", and of the tuned one" if after is not None else ""
        self.chart.describe(
            f"Force over contraction. {readings} readings; curves of this muscle{tuned} at"
            f" {before.pressure[0] / pressure_scale:.3g} to"
            f" {before.pressure[-1] / pressure_scale:.3g} {unit}."
        )
        forces = np.r_[force, before.force.ravel()] / scale
        self.chart.set_ranges(padded_range(before.strain, _SIDE), padded_range(forces, _GAP))

    def _drawn_readings(self, pressure: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Strain [-], force [N] and index of the nearest `pressure` of each drawn reading."""
        record = self.record
        if record is None:
            return np.zeros(0), np.zeros(0), np.zeros(0, int)
        drawn = np.unique(np.linspace(0, len(record) - 1, MOST_POINTS).astype(int))
        nearest = np.abs(record.pressure[drawn, None] - pressure).argmin(axis=1)
        return record.strain[drawn], record.force[drawn], nearest

    # the fit

    def start_fit(self) -> None:
        """Fit the muscle to the record."""
        record, muscle = self.record, self.session.view.muscle
        names = (self.kind.value,) if self.kind.value != _BY_NAME else tuple(self.constants.value)
        if record is None:
            return
        if not names:
            self.message.show("Choose at least one constant to fit, or fit something else.")
            return
        self.message.show("")
        self.calibrate.disabled, self.cancel.visible = True, True
        cancelled = self._cancelled = threading.Event()
        self._stage, usual = "fitting", _DURATIONS[self.kind.value]
        self.progress.start(
            lambda seconds: (
                f"{self._stage}: {seconds:.0f} s. It usually takes {usual}, longer on"
                " a busy machine."
            )
        )

        def progress(stage: str) -> None:
            if cancelled.is_set():
                raise ValueError("The fit was cancelled.")
            self._stage = stage if stage.startswith(_STAGES) else f"fitting: {stage}"

        def compute() -> FitResult:
            fit = FitResult(fit_record(record, muscle, progress, names), "", record, muscle, names)
            progress("drawing the report")
            pictures = figures(fit.calibration)
            page = report(fit.calibration, _today(), pictures, choice=fit.candidates)
            return fit._replace(report=page)

        self._fits.request(compute)

    def cancel_fit(self) -> None:
        """Drop the running fit, whose thread ends with its next step."""
        self._fits.drop()
        self._end_fit()
        self.status.object = status_line("The fit was cancelled.")

    def _end_fit(self) -> None:
        self.progress.stop()
        self._cancelled.set()
        self.calibrate.disabled, self.cancel.visible = self.record is None, False

    def _fail_fit(self, error: ValueError | str) -> None:
        if self.progress.bar.visible:  # else another record was opened meanwhile
            self._end_fit()
            self.fail(error)

    def _show_fit(self, fit: FitResult) -> None:
        if fit.record is not self.record:  # another one was opened meanwhile
            return
        self._end_fit()
        self.fit, calibration = fit, fit.calibration
        rows = []
        for parameter in calibration.parameters:
            value, interval = interval_texts(parameter)
            text = interval if parameter.identifiable else "not known from these data"
            rows.append((parameter.name.replace("_", " "), value, text))
        self.table.object = html_table(("parameter", "value", "90 % interval"), rows)
        first, _ = verdict_lines(calibration, fit.selection)
        lines = [
            *first,
            *fit_data_lines(calibration.fit_data),
            hysteresis_message(calibration),
            *fit.selection.reasons,
        ]
        if not all(parameter.identifiable for parameter in calibration.parameters):
            lines.append(_UNDETERMINED)
        warnings = warnings_by_topic(calibration)
        names = {name for candidate in fit.selection.candidates for name in candidate.names}

        def note(text: str) -> str:
            """A `text` in HTML with the page's labels of constants."""
            for name in names:
                text = text.replace(name, name.replace("_", " "))
            return text_html(text)

        self.fit_notes.object = "".join(
            [status_line(note(line)) for line in lines if line]
            + [
                f"<b>{topic.capitalize()}</b>{status_line('<br>'.join(map(note, texts)))}"
                for topic, texts in warnings.items()
            ]
        )
        self.enable([self.use, *self.saves], True)
        self.draw(self.session.view)

    # downloads

    def export(self) -> Export:
        """Downloads of the record and the muscle, the tuned one where there is one."""
        fit, record = self.fit, self.record
        assert record is not None  # else the buttons are disabled
        muscle, tuned, names = self.session.view.muscle, None, (AUTOMATIC,)
        if fit is not None:
            muscle, tuned, names = fit.muscle, fit.calibration.muscle, fit.names
        inputs = self.session.input_names
        return data(muscle, record, tuned, self.file_name, self._read_options, names, inputs)

    def _tuned_muscle_toml(self) -> str:
        fit = self._shown_fit
        return calibrated_text(
            fit.calibration, _today(), fit.candidates, warning_lines(fit.calibration)
        )

    def _as_file(self, kind: str, text: str) -> tuple[str, bytes]:
        """Stem of a download's name, with its `kind`, and `text` as its bytes."""
        return output_stem(self.file_name, kind, self.session.input_names), text.encode()

    def _use_tuned_muscle(self) -> None:
        muscle = self._shown_fit.calibration.muscle
        self.session.open(view_of(muscle, "tuned muscle", self.session.view))

    @property
    def _shown_fit(self) -> FitResult:
        assert self.fit is not None  # else the buttons are disabled
        return self.fit


def _today() -> str:
    """Local date, such as 2026-03-31."""
    return f"{dt.datetime.now().astimezone():%Y-%m-%d}"


def _empty_state(example: Any) -> Any:
    """Framed panel above the muscle's curves; `example` is the button of an example record."""
    text = pane(f"<h2>{_TITLE}</h2><p>{_TEXT}</p>", (0, APART, APART, APART), **_WIDE)
    form = f'<p class="small">Such a file begins with</p><pre>{_FORM}</pre>'
    left = column(text, example, styles={"flex": "3 1 0", "min-width": "0"})
    right = pane(form, 0, styles={"flex": "2 1 0", "min-width": "0"}, **_WIDE)
    return row(left, right, kind="stacked framed", margin=APART)

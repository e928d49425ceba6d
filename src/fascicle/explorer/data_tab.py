"""Tab of measured data: a record and the muscle's curves, and the muscle fitted to it."""

import datetime as dt
import html
import time
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.models.glyphs import MultiLine, Scatter

from ..plot.theme import Colors
from ..results.labelled import Variable
from .background import LatestResult
from .exports import Export, data, download_button, download_buttons, output_stem
from .measured import (
    AUTOMATIC,
    MeasuredCurves,
    ReadOptions,
    check_measured_curves,
    drawn_readings,
    example_record,
    fit_record,
    measured_curves,
    mismatch_reason,
    preview_curves,
    read_headers,
    read_record,
    report_page,
    tuned_file,
)
from .record_inputs import FitInputs, RecordInputs, empty_state_panel
from .state import Session, View, view_of
from .tab import Tab, progress_bar
from .theme import (
    LAST,
    SCROLLED,
    STACKED,
    TALL,
    WRAPPED,
    Chart,
    equal_column,
    figure_height,
    height_css,
    pressure_colors,
)
from .widgets import (
    Message,
    button,
    html_table,
    pane,
    status_line,
    unit_factor,
    widget,
)


_ROOM, _ROOM_EMPTY = 220, 440  # pixels of the screen beside the figure; without a record
_EXAMPLE = "example.csv"
_NEAR_REST = 0.04  # of the strains drawn, where the labels of curves stand
_MOST_LABELS = 8  # more would collide


class DataView(Tab):
    """Widgets and figure of measured data."""

    name: ClassVar[str] = "data"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "shown")

    def __init__(self, session: Session, colors: Colors):
        """**Arguments:** those of `Tab`."""
        super().__init__(session, colors)
        self.record: Any = None
        self.fit: Any = None
        self._choice: Any = None
        self._raw, self.file_name = b"", ""  # of the record that was opened last
        self._read_options, self._fitted_names = ReadOptions(), (AUTOMATIC,)
        self._fit_muscle = session.view.muscle  # as it was when the fit began
        self._report, self._stage = "", "fitting"
        self._began, self._timer, self._fitting = 0.0, None, None
        self._add_widgets()
        self._add_chart()
        self._fits = LatestResult(self._show_fit, self._fail_fit)
        left = pn.Column(
            self.file, self._other_example, self.read_inputs.panel, self.fit_inputs.kind,
            self.fit_inputs.names, self.calibrate, self.bar, self._status, self.table, self.use,
            pn.Row(*self.saves, margin=0), self.fit_notes, self.notes,
            width=420, margin=(0, 8, 0, 0), stylesheets=[SCROLLED, LAST],
        )  # fmt: skip
        self.message = Message(left, self._other_example)
        self._curves = LatestResult(self._show_curves, self.message.show)
        self.empty_state = empty_state_panel(self._example)
        self._download_row = pn.Row(
            *self.downloads, visible=False, margin=(0, 8), stylesheets=[WRAPPED]
        )
        right = pn.Column(
            self.empty_state, pn.pane.Bokeh(self.chart.figure, margin=0, stylesheets=[TALL]),
            self._download_row, margin=0, **equal_column(),
        )  # fmt: skip
        self.panel = pn.Row(
            left, right, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]
        )

    def _add_widgets(self) -> None:
        self.file = widget(
            pn.widgets.FileInput, "Open a record (CSV)", accept=".csv,.txt,.tsv"
        )  # fmt: skip
        # an empty file changes nothing but the name
        self.file.param.watch(lambda *_: self._open_file(), ["value", "filename"])
        self._example, self._other_example = (
            button("Try an example record (synthetic)", self.open_example, color=color,
                   visible=visible, sizing_mode="stretch_width")
            for color, visible in (("primary", True), ("default", False))
        )  # fmt: skip
        self.read_inputs, self.fit_inputs = RecordInputs(self._read), FitInputs()
        self.calibrate = button(
            "Calibrate the muscle", self.start_fit, color="primary", disabled=True,
            sizing_mode="stretch_width", margin=(6, 8),
        )  # fmt: skip
        self.bar = pn.pane.HTML(
            progress_bar("fitting"), visible=False, margin=(0, 8), sizing_mode="stretch_width"
        )
        self._status, self.fit_notes = (pane(sizing_mode="stretch_width") for _ in range(2))
        self.notes, self.table = pane((4, 8), sizing_mode="stretch_width"), pane((4, 8))
        self.use = button(
            "Use the tuned muscle in all tabs", self._use_fit, disabled=True,
            sizing_mode="stretch_width", margin=(6, 8),
        )  # fmt: skip
        self.saves = [
            download_button(
                "Download tuned muscle", "toml", self._tuned_file, disabled=True, width=184
            ),
            download_button("Download report", "html", self._report_file, disabled=True),
        ]
        self.downloads = download_buttons(self.export, disabled=True)

    def draw(self, view: View) -> None:
        """Show a `view`."""
        self.chart.figure.yaxis[0].axis_label = f"Force F [{view.shown['force']}]"
        record, fit = self.record, self.fit

        def compute() -> tuple[MeasuredCurves, MeasuredCurves | None]:
            if record is None:
                return preview_curves(view.muscle), None
            before = measured_curves(view.muscle, record)
            return before, None if fit is None else measured_curves(fit.muscle, record)

        self._curves.request(compute)

    def _add_chart(self) -> None:
        chart = self.chart = Chart(
            self.colors, "Contraction ε [–]", "Force F [N]", room=_ROOM_EMPTY
        )
        self.readings = chart.source("x", "y", "color", name="readings")
        self._before = chart.source("xs", "ys", "color", name="untuned")
        self._after = chart.source("xs", "ys", "color", name="tuned")
        self._labels = chart.source("x", "y", "label")
        chart.draw(self.readings, Scatter(x="x", y="y", size=4, fill_color="color",
                                          line_color="color", fill_alpha=0.55, line_alpha=0.55),
                   "measured")  # fmt: skip
        chart.draw(self._before, MultiLine(xs="xs", ys="ys", line_color="color", line_width=1.5,
                                           line_dash="dashed"), "this muscle")  # fmt: skip
        chart.draw(self._after, MultiLine(xs="xs", ys="ys", line_color="color", line_width=2.6),
                   "tuned")  # fmt: skip
        chart.tags(self._labels)
        chart.add_zero_line()
        self._measured_entry, _, self._tuned_entry = chart.add_legend()

    # the record

    def open_example(self) -> None:
        """Open the synthetic record of the session's muscle."""
        self.file.clear()  # the example takes its place
        self._open(example_record(self.session.view.muscle), _EXAMPLE)

    def _open_file(self) -> None:
        if self.file.value or self.file.filename:
            self._open(self.file.value or b"", str(self.file.filename or "record.csv")[-60:])

    def _open(self, raw: bytes, name: str) -> None:
        """Open a file; nothing of an earlier record is left, whether it can be read or not."""
        self._raw, self.file_name = raw, name
        self.session.opened.add(name)
        self.read_inputs.offer(read_headers(raw, name))
        self._take_record(None)
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
            options = self.read_inputs.options(view.shown)
            record = read_record(self._raw, name, float(view.muscle.length), options)
            check_measured_curves(view.muscle, record, name)
        except ValueError as error:
            self.message.show(error)
            self.read_inputs.show_columns(bool(self._raw))  # what can help
            return
        self._read_options = options
        self.fit_inputs.offer(view.muscle)
        self.message.show(mismatch_reason(view.muscle, record))
        self._take_record(record)
        kind = " synthetic" if name == _EXAMPLE else ""
        plural = "s" * (len(record) != 1)
        notes = "".join(f"<li>{html.escape(note)}</li>" for note in record.notes[:12])
        self.notes.object = (
            f'<div style="font-size:12.5px;opacity:.85">{len(record)}{kind} reading{plural}.'
            f"<ul style='padding-left:18px;margin:2px 0'>{notes}</ul></div>"
        )
        with pn.io.unlocked():
            self.draw(view)

    def _take_record(self, record: Any) -> None:
        """Take a `record`, or none, that nothing is fitted to yet."""
        self.record, self.fit, self._fitting = record, None, None
        self._end_fit()
        self.table.object = self.fit_notes.object = ""
        exists = record is not None
        self.empty_state.visible = not exists
        self._download_row.visible = self._other_example.visible = exists
        for each in (self.use, *self.saves):
            each.disabled = True
        for each in self.downloads:
            each.disabled = not exists

    def _show_curves(self, result: tuple[MeasuredCurves, MeasuredCurves | None]) -> None:
        before, after = result
        view = self.session.view
        scale = unit_factor(view.shown["force"], "force")
        colors = pressure_colors(self.colors, len(before.pressure))
        strain, force, nearest = _nearest_curves(self.record, before)
        self.readings.data = {
            "x": strain, "y": force / scale, "color": [colors[i] for i in nearest]
        }  # fmt: skip
        room = _ROOM_EMPTY if self.record is None else _ROOM
        self.chart.figure.stylesheets = [height_css(figure_height(room))]
        self._measured_entry.visible = self.record is not None
        self._tuned_entry.visible = after is not None
        for source, curves in ((self._before, before), (self._after, after)):
            rows = [] if curves is None else list(curves.force / scale)
            source.data = {
                "xs": [before.strain] * len(rows),
                "ys": rows,
                "color": colors[: len(rows)],
            }
        unit = view.shown["pressure"]
        number = len(before.pressure)
        labeled = np.unique(np.linspace(0, number - 1, min(number, _MOST_LABELS)).astype(int))
        # above the readings, too, which lie at rest
        at_rest = strain < before.strain[0] + _NEAR_REST * np.ptp(before.strain)
        tops = [max([before.force[i, 0], *force[at_rest & (nearest == i)]]) for i in labeled]
        to_unit = unit_factor(unit, "pressure")
        self._labels.data = {
            "x": [float(before.strain[0])] * len(labeled),
            "y": np.array(tops) / scale,
            "label": [f"{before.pressure[i] / to_unit:.3g} {unit}" for i in labeled],
        }
        self._status.object = status_line(
            f"Curves of {number} of {before.count} pressures are drawn."
            if before.count > number else ""
        )  # fmt: skip
        every = np.r_[force, before.force.ravel()] / scale
        margin = 0.06 * float(np.ptp(every))
        self.chart.set_ranges(
            (float(before.strain[0]), float(before.strain[-1])),
            (float(every.min()) - margin, float(every.max()) + margin),
        )

    # the fit

    def start_fit(self) -> None:
        """Fit the muscle to the record."""
        record, muscle, names = self.record, self.session.view.muscle, self.fit_inputs.chosen
        if not names:
            self.message.show("Choose at least one constant to fit, or fit something else.")
            return
        self._fit_muscle, self._fit_names, self._fitting = muscle, names, record
        self.calibrate.disabled = True
        self._began, self._stage = time.monotonic(), "fitting"
        self._show_progress()
        if pn.state.curdoc is not None and pn.state.curdoc.session_context:
            self._timer = pn.state.add_periodic_callback(self._show_progress, period=500)

        def progress(stage: str) -> None:
            self._stage = stage if stage.startswith("fitting") else f"fitting: {stage}"

        def compute() -> tuple[Any, str]:
            choice = fit_record(record, muscle, progress, names)
            self._stage = "drawing the report"
            return choice, report_page(choice, _today())

        self._fits.request(compute)

    def _show_progress(self) -> None:
        # of unknown duration: the bar moves, and the seconds count
        self.bar.visible = True
        seconds = time.monotonic() - self._began
        self._status.object = status_line(f"{self._stage}: {seconds:.0f} s")

    def _end_fit(self) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        self.calibrate.disabled, self.bar.visible = self.record is None, False
        self._status.object = ""

    def _fail_fit(self, text: str) -> None:
        if self._fitting is not None:  # no other record came meanwhile
            self._end_fit()
            self.message.show(text, self.session.view.shown)

    def _show_fit(self, result: tuple[Any, str]) -> None:
        # loaded here: a page that fits nothing doesn't need it
        from ..calibrate.messages import fit_data_lines, hysteresis_message, interval_texts

        if self._fitting is None:  # another record came meanwhile
            return
        self._end_fit()
        self._fitted_names = self._fit_names
        self._choice, self._report = result
        fit = self.fit = self._choice.calibration
        rows = []
        for parameter in fit.parameters:
            value, interval = interval_texts(parameter)
            known = interval if parameter.identifiable else "not known from these data"
            rows.append((parameter.name.replace("_", " "), value, known))
        self.table.object = html_table(("parameter", "value", "90 % interval"), rows)
        lines = [
            f"rmse {fit.rmse:.4g} N, {100 * fit.relative_rmse:.3g} % of the largest force",
            *fit_data_lines(fit.fit_data),
            hysteresis_message(fit),
            *self._choice.reasons,
        ]
        warnings: Mapping[str, Any] = fit.warnings_by_topic
        self.fit_notes.object = "".join(
            [status_line(html.escape(line)) for line in lines if line]
            + [
                f"<b>{topic.capitalize()}</b>{status_line('<br>'.join(map(html.escape, texts)))}"
                for topic, texts in warnings.items()
            ]
        )
        for each in (self.use, *self.saves):
            each.disabled = False
        self.draw(self.session.view)

    # what is taken away

    def export(self) -> Export:
        """Downloads of the record and the muscle, the tuned one where there is one."""
        muscle, tuned = self.session.view.muscle, None
        if self.fit is not None:
            muscle, tuned = self._fit_muscle, self.fit.muscle
        return data(
            muscle, self.record, tuned, self.file_name, self._read_options, self._fitted_names,
            self.session.opened,
        )  # fmt: skip

    def _tuned_file(self) -> Export:
        return self._text_file("tuned", tuned_file(self._choice, _today()))

    def _report_file(self) -> Export:
        return self._text_file("report", self._report)

    def _text_file(self, what: str, text: str) -> Export:
        variables: Mapping[str, Variable] = {}
        stem = output_stem(self.file_name, what, self.session.opened)
        return Export(stem, variables, lambda: None, text)

    def _use_fit(self) -> None:
        self.session.show(view_of(self.fit.muscle, "tuned muscle", self.session.view))


def _today() -> str:
    return f"{dt.datetime.now().astimezone():%Y-%m-%d}"


def _nearest_curves(
    record: Any, curves: MeasuredCurves
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Strain [-] and force [N] of drawn readings, and the curve of nearest pressure of each."""
    if record is None:
        return np.zeros(0), np.zeros(0), np.zeros(0, int)
    indices = drawn_readings(record)
    nearest = np.abs(record.pressure[indices, None] - curves.pressure).argmin(axis=1)
    return record.strain[indices], record.force[indices], nearest

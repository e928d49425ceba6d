"""The data's tab: a record beside the muscle's curves, and the muscle tuned to it."""

import datetime as dt
import html
import io
import time
from typing import Any, ClassVar

import numpy as np
import panel as pn

from ...units import pretty
from ..curves.measured import (
    MOST_ROWS,
    Beside,
    beside,
    drawn,
    fitted,
    read,
    report_page,
    suited,
    synthetic,
    tuned_file,
)
from ..parts.background import Latest
from ..parts.exports import Export, data, downloads
from ..parts.look import (
    STACKED,
    TALL,
    WRAPPED,
    Look,
    legend_style,
    plain_figure,
    pressure_colors,
    set_range,
    source_of,
    widget_css,
)
from ..parts.widgets import button, factor
from ..parts.widgets import read as read_field
from ..state import Session, View, view_of
from .reversal import grid
from .tab import Tab, status


class DataView(Tab):
    """Widgets and figure of measured data."""

    name: ClassVar[str] = "data"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "shown")

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        super().__init__(session, look)
        css = [widget_css(look)]
        self.record: Any = None
        self.made: Any = None
        self._choice: Any = None
        self._tunes = session.view.muscle  # as it was when the fit began
        self._report = ""
        self._file = pn.widgets.FileInput(
            label="Open a record",
            accept=".csv,.txt,.tsv",
            stylesheets=css,
            margin=(2, 8),
            sizing_mode="stretch_width",
        )
        self._file.param.watch(lambda _: self._opened(), "value")
        self._example: bytes = b""  # instead of a file
        self._try = button(
            look, "Try an example record (synthetic)", self._tried, sizing_mode="stretch_width",
            margin=(2, 8),
        )  # fmt: skip
        self._length = pn.widgets.TextInput(
            label="Rest length, if the record doesn't say it",
            stylesheets=css, sizing_mode="stretch_width", margin=(2, 8),
        )  # fmt: skip
        self._length.param.watch(lambda _: self._opened(), "value")
        self._clipped = pn.widgets.Checkbox(
            label="Forces of exactly zero only say: not above", stylesheets=css, margin=(6, 8)
        )
        self._clipped.param.watch(lambda _: self._opened(), "value")
        self._calibrate = button(
            look, "Calibrate the muscle", self._fit, color="primary", disabled=True,
            sizing_mode="stretch_width", margin=(6, 8),
        )  # fmt: skip
        self._progress = pn.indicators.Progress(
            active=False, value=0, sizing_mode="stretch_width", margin=(2, 8), height=12
        )
        self._status = pn.pane.HTML("", margin=(0, 8))
        self._notes = pn.pane.HTML("", margin=(4, 8), sizing_mode="stretch_width")
        self._table = pn.pane.HTML("", margin=(4, 8))
        self._take = button(
            look, "Use the tuned muscle in all tabs", self._taken, disabled=True,
            sizing_mode="stretch_width", margin=(6, 8),
        )  # fmt: skip
        self._saves = [
            pn.widgets.FileDownload(
                label=label, filename=name, callback=made, disabled=True, stylesheets=css,
                width=150, margin=(4, 8),
            )
            for label, name, made in (
                ("Tuned muscle", "muscle.toml", self._tuned),
                ("Report", "report.html", lambda: io.BytesIO(self._report.encode())),
            )
        ]  # fmt: skip
        self._given = downloads(look, "data", self._export)
        for widget in self._given:
            widget.disabled = True
        self._draw_figure()
        self._beside = Latest(self._show_beside, self.message.say)
        self._fitted = Latest(self._show_fit, self._failed)
        self._begun, self._timer = 0.0, None
        left = pn.Column(
            pn.pane.HTML(
                '<div style="font-size:13.5px">A dynamometer\'s CSV: pressure, force, and strain,'
                f" length or displacement, with units in its header; up to {MOST_ROWS} rows. It"
                " stays in this session's memory.</div>", margin=(4, 8),
            ),
            self._file, self._try, self._length, self.message.pane, self._clipped,
            self._calibrate, self._progress, self._status, self._table, self._take,
            pn.Row(*self._saves, margin=0), self._notes,
            width=420, height=660, scroll=True, margin=0,
        )  # fmt: skip
        right = pn.Column(
            pn.pane.Bokeh(self.figure, margin=0, stylesheets=[TALL]),
            pn.Row(*self._given, margin=(0, 8), stylesheets=[WRAPPED]),
            sizing_mode="stretch_width", margin=0,
        )  # fmt: skip
        self.panel = pn.Row(
            left, right, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]
        )

    def draw(self, view: View) -> None:
        """Show a `view` [-]."""
        unit = view.shown["force"]
        self.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        if self.record is not None:
            record, made = self.record, self.made
            self._beside.ask(
                lambda: (
                    beside(view.muscle, record),
                    None if made is None else beside(made.muscle, record),
                )
            )

    def _draw_figure(self) -> None:
        look = self.look
        fig = plain_figure(look, "Contraction ε [–]", "Force F [N]", room=220)
        self.figure = fig
        self._points = source_of({"x": [], "y": [], "color": []}, name="readings")
        self._before = source_of({"xs": [], "ys": [], "color": []}, name="untuned")
        self._after = source_of({"xs": [], "ys": [], "color": []}, name="tuned")
        self._names = source_of({"x": [], "y": [], "label": [], "color": []})
        fig.scatter("x", "y", source=self._points, size=4, color="color", alpha=0.55,
                    legend_label="measured")  # fmt: skip
        fig.multi_line("xs", "ys", source=self._before, color="color", line_width=1.5,
                       line_dash="dashed", legend_label="this muscle")  # fmt: skip
        fig.multi_line("xs", "ys", source=self._after, color="color", line_width=2.6,
                       legend_label="tuned")  # fmt: skip
        fig.text("x", "y", "label", source=self._names, color="color", text_font_size="12px",
                 x_offset=6, y_offset=-2)  # fmt: skip
        fig.line([-1, 1], [0, 0], color=look.soft, line_width=1)
        legend_style(fig, look)

    def _tried(self) -> None:
        self._example = synthetic(self.session.view.muscle)
        if self._file.value:
            self._file.value = None  # the example takes its place, and is opened by that
        else:
            self._opened()

    @property
    def _kind(self) -> str:
        return "" if self._file.value else " synthetic"

    def _opened(self) -> None:
        raw = self._file.value or self._example
        if not raw:
            return
        view, name = self.session.view, self._name
        unit, typed = view.shown["length"], self._length.value.strip()
        try:
            rest = read_field(typed, "length", unit, "rest_length") if typed else None
            self.record = read(raw, name, float(view.muscle.length), self._clipped.value, rest)
        except ValueError as error:
            self.message.say(str(error))
            return
        self.message.say(suited(view.muscle, self.record))
        self.made = None
        self._table.object = ""
        for widget in (self._take, *self._saves):
            widget.disabled = True
        for widget in (self._calibrate, *self._given):
            widget.disabled = False
        told = "".join(f"<li>{html.escape(note)}</li>" for note in self.record.notes[:12])
        self._notes.object = (
            f'<div style="font-size:12.5px;opacity:.85">{len(self.record)}{self._kind} readings.'
            f"<ul style='padding-left:18px;margin:2px 0'>{told}</ul></div>"
        )
        with pn.io.unlocked():
            self.draw(view)

    def _show_beside(self, found: tuple[Beside, Beside | None]) -> None:
        before, after = found
        view, record = self.session.view, self.record
        scale = factor(view.shown["force"], "force")
        colors = pressure_colors(self.look, len(before.pressure))
        places = drawn(record)
        nearest = np.abs(record.pressure[places, None] - before.pressure).argmin(axis=1)
        self._points.data = {
            "x": record.strain[places], "y": record.force[places] / scale,
            "color": [colors[i] for i in nearest],
        }  # fmt: skip
        for source, curves in ((self._before, before), (self._after, after)):
            rows = [] if curves is None else list(curves.force / scale)
            source.data = {
                "xs": [before.strain] * len(rows),
                "ys": rows,
                "color": colors[: len(rows)],
            }
        unit = view.shown["pressure"]
        self._names.data = {
            "x": [float(before.strain[0])] * len(colors),
            "y": before.force[:, 0] / scale,
            "label": [f"{P / factor(unit, 'pressure'):.3g} {unit}" for P in before.pressure],
            "color": colors,
        }
        force = np.r_[record.force, before.force.ravel()] / scale
        room = 0.06 * float(np.ptp(force))
        set_range(self.figure.x_range, float(before.strain[0]), float(before.strain[-1]))
        set_range(self.figure.y_range, float(force.min()) - room, float(force.max()) + room)

    # the fit

    def _fit(self) -> None:
        record, muscle = self.record, self.session.view.muscle
        self._tunes = muscle
        self._calibrate.disabled = True
        self._progress.value, self._progress.active = -1, True  # it moves
        self._begun = time.monotonic()
        date = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
        stage = ["fitting"]
        self._stage = stage
        if pn.state.curdoc is not None and pn.state.curdoc.session_context:
            self._timer = pn.state.add_periodic_callback(self._tick, period=500)

        def compute() -> tuple[Any, str]:
            def tell(what: str) -> None:
                stage[0] = what if what.startswith("fitting") else f"fitting: {what}"

            choice = fitted(record, muscle, tell)
            stage[0] = "drawing the report"
            return choice, report_page(choice, date)

        self._fitted.ask(compute)

    def _tick(self) -> None:
        seconds = time.monotonic() - self._begun
        self._status.object = status(f"{self._stage[0]}: {seconds:.0f} s")

    def _done(self) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        self._progress.value, self._progress.active = 0, False
        self._calibrate.disabled = False
        self._status.object = ""

    def _failed(self, text: str) -> None:
        self._done()
        self.message.say(text)

    def _show_fit(self, found: tuple[Any, str]) -> None:
        from ...calibrate.after.warned import (
            hysteresis,  # loads what a page that fits nothing needn't
        )

        self._done()
        self._choice, self._report = found
        self.made = self._choice.made
        rows = [
            (
                one.name.replace("_", " "),
                pretty(one.value, one.dimension),
                f"{pretty(one.low, one.dimension, 3)} to {pretty(one.high, one.dimension, 3)}"
                if one.identifiable
                else "not known from these data",
            )
            for one in self.made.parameters
        ]
        self._table.object = grid(("parameter", "value", "90 % interval"), rows)
        made = self.made
        told = [
            f"rmse {made.rmse:.4g} N, {100 * made.relative_rmse:.3g} % of the largest force",
            *made.taken.words(),
            hysteresis(made),
            *self._choice.reasons,
            *made.warnings,
        ]
        self._status.object = "".join(status(html.escape(line)) for line in told if line)
        for widget in (self._take, *self._saves):
            widget.disabled = False
        self.draw(self.session.view)

    @property
    def _name(self) -> str:
        if not self._file.value:
            return "example.csv"
        return str(self._file.filename or "data.csv")[-60:]

    def _export(self) -> Export:
        muscle, tuned = self.session.view.muscle, None
        if self.made is not None:
            muscle, tuned = self._tunes, self.made.muscle
        return data(muscle, self.record, tuned, self._name, self._clipped.value)

    def _tuned(self) -> Any:
        return io.BytesIO(
            tuned_file(self._choice, f"{dt.datetime.now().astimezone():%Y-%m-%d}").encode()
        )

    def _taken(self) -> None:
        view = self.session.view
        self.session.become(view_of(self.made.muscle, "tuned muscle", view))

"""The data's tab: a record beside the muscle's curves, and the muscle tuned to it."""

import datetime as dt
import html
import io
import time
from typing import Any, ClassVar

import numpy as np
import panel as pn

from .background import Latest
from .exports import Export, data, downloads, output_stem
from .measured import (
    FOUND,
    Beside,
    Reading,
    awaited,
    beside,
    check_drawn,
    drawn,
    fitted,
    headers,
    read,
    report_page,
    suited,
    synthetic,
    tuned_file,
)
from .record_inputs import FitInputs, RecordInputs, invitation
from .reversal_tab import grid
from .state import Session, View, view_of
from .tab import Tab, moving, status
from .theme import (
    AFTER,
    ROLLED,
    STACKED,
    TALL,
    WRAPPED,
    Look,
    half,
    height_of,
    high_css,
    legend_style,
    plain_figure,
    pressure_colors,
    set_range,
    source_of,
    tags,
    widget_css,
)
from .widgets import button, factor


_ROOM, _BELOW = 220, 440  # pixels of the screen that are not the figure's; below an invitation
_EXAMPLE = "example.csv"
_NEAR_REST = 0.04  # of the strains drawn: where a curve's name stands


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
            label="Open a record (CSV)",
            accept=".csv,.txt,.tsv",
            stylesheets=css,
            margin=(2, 8),
            sizing_mode="stretch_width",
        )
        # an empty file changes nothing but the name
        self._file.param.watch(lambda *_: self._sent(), ["value", "filename"])
        self._raw, self._name = b"", ""  # what was opened last, and what it is called
        self._try, self._again = (
            button(look, "Try an example record (synthetic)", self._tried, color=color,
                   visible=visible, sizing_mode="stretch_width", margin=(2, 8))
            for color, visible in (("primary", True), ("default", False))
        )  # fmt: skip
        self._how = RecordInputs(look, self._opened)
        self._what = FitInputs(look)
        self._reading, self._free = Reading(), (FOUND,)  # of what was read and fitted
        self._calibrate = button(
            look, "Calibrate the muscle", self._fit, color="primary", disabled=True,
            sizing_mode="stretch_width", margin=(6, 8),
        )  # fmt: skip
        self._bar = pn.pane.HTML(
            moving("fitting"), visible=False, margin=(0, 8), sizing_mode="stretch_width"
        )  # fmt: skip
        self._status = pn.pane.HTML("", margin=(0, 8), sizing_mode="stretch_width")
        self._told = pn.pane.HTML("", margin=(0, 8), sizing_mode="stretch_width")
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
                ("Tuned muscle", "tuned.toml", self._tuned),
                ("Report", "report.html", lambda: io.BytesIO(self._report.encode())),
            )
        ]  # fmt: skip
        self._given = downloads(look, "data", self._export)
        for widget in self._given:
            widget.disabled = True
        self._draw_figure()
        self._beside = Latest(self._show_beside, self.message.say)
        self._fitted = Latest(self._show_fit, self._failed)
        self._begun, self._timer, self._fitting = 0.0, None, None
        left = pn.Column(
            self._file, self._again, self.message.pane, self._how.panel, self._what.panel,
            self._calibrate, self._bar, self._status, self._table, self._take,
            pn.Row(*self._saves, margin=0), self._told, self._notes,
            width=420, margin=(0, 8, 0, 0), stylesheets=[ROLLED, AFTER],
        )  # fmt: skip
        self._invitation = invitation(self._try)
        self._gives = pn.Row(*self._given, visible=False, margin=(0, 8), stylesheets=[WRAPPED])
        right = pn.Column(
            self._invitation, pn.pane.Bokeh(self.figure, margin=0, stylesheets=[TALL]),
            self._gives, margin=0, **half(),
        )  # fmt: skip
        self.panel = pn.Row(
            left, right, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]
        )

    def draw(self, view: View) -> None:
        """Show a `view` [-]."""
        unit = view.shown["force"]
        self.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        record, made = self.record, self.made
        if record is None:
            self._beside.ask(lambda: (awaited(view.muscle), None))
            return
        self._beside.ask(
            lambda: (
                beside(view.muscle, record),
                None if made is None else beside(made.muscle, record),
            )
        )

    def _draw_figure(self) -> None:
        look = self.look
        fig = plain_figure(look, "Contraction ε [–]", "Force F [N]", room=_BELOW)
        self.figure = fig
        self._points = source_of({"x": [], "y": [], "color": []}, name="readings")
        self._before = source_of({"xs": [], "ys": [], "color": []}, name="untuned")
        self._after = source_of({"xs": [], "ys": [], "color": []}, name="tuned")
        self._names = source_of({"x": [], "y": [], "label": []})
        fig.scatter("x", "y", source=self._points, size=4, color="color", alpha=0.55,
                    legend_label="measured")  # fmt: skip
        fig.multi_line("xs", "ys", source=self._before, color="color", line_width=1.5,
                       line_dash="dashed", legend_label="this muscle")  # fmt: skip
        fig.multi_line("xs", "ys", source=self._after, color="color", line_width=2.6,
                       legend_label="tuned")  # fmt: skip
        tags(fig, look, self._names)
        fig.line([-1, 1], [0, 0], color=look.soft, line_width=1)
        legend_style(fig, look)
        self._legend = dict(zip(("measured", "this", "tuned"), fig.legend.items, strict=True))

    def _tried(self) -> None:
        self._file.clear()  # the example takes its place
        self._begin(synthetic(self.session.view.muscle), _EXAMPLE)

    def _sent(self) -> None:
        if self._file.value or self._file.filename:
            self._begin(self._file.value or b"", str(self._file.filename or "record.csv")[-60:])

    def _begin(self, raw: bytes, name: str) -> None:
        """Open a file: nothing of an earlier record is left, whatever becomes of this one."""
        self._raw, self._name = raw, name
        for what, widgets in (
            ("comparison", self._given),
            ("tuned", self._saves[:1]),
            ("report", self._saves[1:]),
        ):
            for widget in widgets:
                suffix = str(widget.filename).rpartition(".")[2]
                widget.filename = f"{output_stem(name, what)}.{suffix}"
        self._how.offer(headers(raw, name))
        self._settle(None)
        self._notes.object = ""
        self._opened()
        if self.record is None:
            self.draw(self.session.view)

    def _opened(self) -> None:
        """Read what was opened, as the fields say; what can't be leaves the last picture."""
        view, name = self.session.view, self._name
        if not name:
            return
        try:
            reading = self._how.reading(view.shown)
            record = read(self._raw, name, float(view.muscle.length), reading)
            check_drawn(view.muscle, record, name)
        except ValueError as error:
            self.message.say(str(error))
            self._how.show(bool(self._raw))  # what can be said to it
            return
        self._reading = reading
        self._what.offer(view.muscle)
        self.message.say(suited(view.muscle, record))
        self._settle(record)
        several = "s" * (len(record) != 1)
        kind = " synthetic" if name == _EXAMPLE else ""
        told = "".join(f"<li>{html.escape(note)}</li>" for note in record.notes[:12])
        self._notes.object = (
            f'<div style="font-size:12.5px;opacity:.85">{len(record)}{kind} reading{several}.'
            f"<ul style='padding-left:18px;margin:2px 0'>{told}</ul></div>"
        )
        with pn.io.unlocked():
            self.draw(view)

    def _settle(self, record: Any) -> None:
        """Take a `record` [-] or none, of which nothing is known yet: what can be done with it."""
        self.record, self.made, self._fitting = record, None, None
        self._done()
        self._table.object = self._told.object = ""
        there = record is not None
        self._invitation.visible, self._gives.visible, self._again.visible = not there, there, there
        for widget in (self._take, *self._saves):
            widget.disabled = True
        for widget in self._given:
            widget.disabled = not there

    def _show_beside(self, found: tuple[Beside, Beside | None]) -> None:
        before, after = found
        view = self.session.view
        scale = factor(view.shown["force"], "force")
        colors = pressure_colors(self.look, len(before.pressure))
        strain, force, nearest = _readings(self.record, before)
        self._points.data = {
            "x": strain, "y": force / scale, "color": [colors[i] for i in nearest]
        }  # fmt: skip
        room = _BELOW if self.record is None else _ROOM
        self.figure.stylesheets = [high_css(height_of(room))]
        self._legend["measured"].visible = self.record is not None
        self._legend["tuned"].visible = after is not None
        for source, curves in ((self._before, before), (self._after, after)):
            rows = [] if curves is None else list(curves.force / scale)
            source.data = {
                "xs": [before.strain] * len(rows),
                "ys": rows,
                "color": colors[: len(rows)],
            }
        unit = view.shown["pressure"]
        # above the readings, too, which lie at rest
        at_rest = strain < before.strain[0] + _NEAR_REST * np.ptp(before.strain)
        tops = [
            max([before.force[i, 0], *force[at_rest & (nearest == i)]]) for i in range(len(colors))
        ]
        self._names.data = {
            "x": [float(before.strain[0])] * len(colors),
            "y": np.array(tops) / scale,
            "label": [f"{P / factor(unit, 'pressure'):.3g} {unit}" for P in before.pressure],
        }
        every = np.r_[force, before.force.ravel()] / scale
        room = 0.06 * float(np.ptp(every))
        set_range(self.figure.x_range, float(before.strain[0]), float(before.strain[-1]))
        set_range(self.figure.y_range, float(every.min()) - room, float(every.max()) + room)

    # the fit

    def _fit(self) -> None:
        record, muscle, names = self.record, self.session.view.muscle, self._what.chosen
        if not names:
            self.message.say("`fit` must name at least one constant: choose some, or another way.")
            return
        self._tunes, self._fits, self._fitting = muscle, names, record
        self._calibrate.disabled = True
        self._begun = time.monotonic()
        date = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
        stage = ["fitting"]
        self._stage = stage
        self._tick()
        if pn.state.curdoc is not None and pn.state.curdoc.session_context:
            self._timer = pn.state.add_periodic_callback(self._tick, period=500)

        def compute() -> tuple[Any, str]:
            def tell(what: str) -> None:
                stage[0] = what if what.startswith("fitting") else f"fitting: {what}"

            choice = fitted(record, muscle, tell, names)
            stage[0] = "drawing the report"
            return choice, report_page(choice, date)

        self._fitted.ask(compute)

    def _tick(self) -> None:
        # nobody knows how long it takes: the bar moves, and the seconds count
        self._bar.visible = True
        seconds = time.monotonic() - self._begun
        self._status.object = status(f"{self._stage[0]}: {seconds:.0f} s")

    def _done(self) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        self._calibrate.disabled, self._bar.visible = self.record is None, False
        self._status.object = ""

    def _failed(self, text: str) -> None:
        if self._fitting is None:  # another record came meanwhile
            return
        self._done()
        self.message.say(text)

    def _show_fit(self, found: tuple[Any, str]) -> None:
        from ..calibrate.messages import fit_data_lines, hysteresis_message, interval_texts

        if self._fitting is None:  # another record came meanwhile
            return
        self._done()
        self._free = self._fits
        self._choice, self._report = found
        self.made = self._choice.calibration
        rows = [
            (
                one.name.replace("_", " "),
                interval_texts(one)[0],
                interval_texts(one)[1] if one.identifiable else "not known from these data",
            )
            for one in self.made.parameters
        ]
        self._table.object = grid(("parameter", "value", "90 % interval"), rows)
        made = self.made
        told = [
            f"rmse {made.rmse:.4g} N, {100 * made.relative_rmse:.3g} % of the largest force",
            *fit_data_lines(made.fit_data),
            hysteresis_message(made),
            *self._choice.reasons,
        ]
        self._told.object = "".join(
            [status(html.escape(line)) for line in told if line]
            + [
                f"<b>{about.capitalize()}</b>{status('<br>'.join(map(html.escape, lines)))}"
                for about, lines in made.warnings_by_topic.items()
            ]
        )
        for widget in (self._take, *self._saves):
            widget.disabled = False
        self.draw(self.session.view)

    def _export(self) -> Export:
        muscle, tuned = self.session.view.muscle, None
        if self.made is not None:
            muscle, tuned = self._tunes, self.made.muscle
        return data(muscle, self.record, tuned, self._name, self._reading, self._free)

    def _tuned(self) -> Any:
        return io.BytesIO(
            tuned_file(self._choice, f"{dt.datetime.now().astimezone():%Y-%m-%d}").encode()
        )

    def _taken(self) -> None:
        view = self.session.view
        self.session.become(view_of(self.made.muscle, "tuned muscle", view))


def _readings(record: Any, curves: Beside) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Strain [-] and force [N] of the readings of a `record` [-] that are drawn, and which of the
    `curves` [-] is nearest in pressure; none without a record.
    """
    if record is None:
        return np.zeros(0), np.zeros(0), np.zeros(0, int)
    places = drawn(record)
    nearest = np.abs(record.pressure[places, None] - curves.pressure).argmin(axis=1)
    return record.strain[places], record.force[places], nearest

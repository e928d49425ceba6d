"""Tab of a simulation in time: a scenario is run, then bundle, load and charts move together.

The run goes to the browser once; there `time_page.js` plays it, without a message to the server.
"""

import asyncio
import html
import io
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.events import Tap
from bokeh.models import Button, CustomJS, Div, Select, Slider, Span

from ..core.errors import MissingExtraError, require
from ..files.shipped_files import scenarios
from ..plot.theme import LIGHT, Colors, to_bytes
from ..results import Table
from .chart import Chart, cycle_colors
from .exports import download_button, output_stem
from .remarks import glossary_html
from .scenario_setup import LARGEST_FILE, POLICIES, ScenarioValue, Setup, check_policies, open_setup
from .state import Session, View
from .tab import LatestResult, Progress, Tab
from .theme import LAYOUT_CSS, WIDGET_CSS, column, pane, row, side_column
from .time_drawing import ALPHAS, HATCHED, STATES, rigid_colors
from .time_film import ChartCurves, Curve, charts_figure, film
from .time_run import PolicyResult, SimulationResult, run_policies
from .widgets import (
    Field,
    button,
    decode_upload,
    dropdown,
    field_unit,
    file_input,
    heading,
    html_legend,
    html_table,
    status_line,
    text_html,
    widget,
)
from .worker import WAITING, run_job


_OWN = "(your file)"
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
_HEIGHTS = (150, 150, 150, 110, 170)  # pixels of the charts, from top to bottom
_LEFT = 66  # pixels beside each chart, so that times are below one another
_SCENE_HEIGHT = "clamp(300px, 100vh - 420px, 620px)"
_DASHES = ("solid", "dashed", "dotted", "dotdash", "dashdot")
_CSS_DASHES = ("solid", "dashed", "dotted", "dashed", "dashed")  # the nearest that CSS has
_NARROW = 44.0  # mm of the drawing that a unit's labels take
_OPEN = 1e-3  # of a valve, from which on it counts as open
# of the table of policies
_COLUMNS = ("policy", "drawdown", "drawdown/D", "rms error", "energy")  # heads, without units
_TABLE_CSS = (  # five columns on a phone
    ".scroll { overflow-x: auto; } table { font-size: 12.5px; } th, td { padding-right: 9px; }"
)
_PLAY = (Path(__file__).with_name("time_page.js")).read_text(encoding="utf-8")
_EMPTY = (
    "<h2>A bundle in time</h2><p>Choose a scenario and press <b>Run</b>. The simulator computes"
    " valves, pressures and the load, as <code>fascicle simulate</code> does; then you play the run"
    " here. A scenario brings its own bundle: the muscle of the other tabs takes no part. The"
    " first run takes longer: the simulator is compiled.</p>"
)
_LEGEND = (  # of the drawing
    "Filled: the muscle pulls. Pale: it has buckled. Hatched: it has collapsed. ▼ the valve is open"
    " to the supply, ▲ to the room, – shut."
)
_DEMAND_LEGEND = " Red line: where the load should be."
_DRAWDOWN = "Drawdown: how far force or position falls back while its demand does not."
_DIP = (
    " D: how far the force falls while a motor unit fills and the others hold their pressures."
    " Drawdown/D is 0 for a smooth hand-over, and 1 where nothing made up for the fall."
)


class TimeView(Tab):
    """Widgets and figures of a simulation."""

    name: ClassVar[str] = "time"
    fields: ClassVar[tuple[str, ...]] = ("setup", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self.result: SimulationResult | None = None
        self._setup = Setup()  # of the result
        self._job = 0  # number of the running or last job
        self._updating = False
        self._inputs: dict[str, Field] = {}
        self._add_widgets()
        self._add_charts()
        self._add_player()
        self._runs = LatestResult(self._show_result, self._fail_job, WAITING, self.is_open)
        self._lay_out()

    # widgets

    def _add_widgets(self) -> None:
        """Make the inputs and buttons, but those of the player."""
        names = [*scenarios(), _OWN]
        self.scenario = dropdown("Scenario", names, self._choose_scenario, width=200)
        self.run = button("Run", self.start_run, color="primary", width=76, margin=(22, 4, 4, 8))
        self.cancel = button(
            "Cancel", self.cancel_job, width=76, margin=(22, 4, 4, 4), disabled=True
        )
        self.file = file_input("Open a scenario (.toml)", ".toml", self._open_file)
        self._fields = column()
        self.policies = widget(
            pn.widgets.CheckBoxGroup, "Policies", self._set_policies, options=list(POLICIES)
        )
        self._policy_title = pane()
        self._policy_words = pane(glossary_html("Explain the policies", POLICIES))
        self._progress = Progress("simulating", self.status, self.is_open)
        self._about, self._table = (
            pane(sizing_mode="stretch_width"),
            pane(margin=(4, 8), sizing_mode="stretch_width", stylesheets=[LAYOUT_CSS, _TABLE_CSS]),
        )
        self.drawn = dropdown("Policy that is drawn", [], self._choose_drawn, visible=False)
        self.saves = [
            *(download_button(f"Save charts ({kind.upper()})", kind,
                              lambda kind=kind: self._charts_file(kind), self.download_message,
                              disabled=True)
              for kind in ("png", "svg")),
            self._film_button(),
            download_button("Save table (CSV)", "csv", self._table_file, self.download_message,
                            disabled=True),
        ]  # fmt: skip
        self.save_scenario = download_button(
            "Save scenario", "toml", self._scenario_file, self.message, width=118
        )

    def _film_button(self) -> Any:
        """Button that downloads the film, which a job draws."""

        async def make_file() -> io.BytesIO:
            job = self._begin_job("drawing the film")
            call = partial(run_job, film, *self._film_arguments())
            loop = asyncio.get_running_loop()
            try:
                raw = await loop.run_in_executor(WAITING, call)
            except ValueError as error:
                self._fail_job(error)
                raise asyncio.CancelledError from None  # nothing to send
            if self._job != job:  # canceled meanwhile
                raise asyncio.CancelledError
            self._end_job()
            result.filename = f"{self._file_stem()}.gif"
            return io.BytesIO(raw)

        result = widget(
            pn.widgets.FileDownload, "Save film (GIF)", filename="fascicle.gif",
            callback=make_file, width=146, margin=(2, 4), disabled=True,
        )  # fmt: skip
        return result

    def _add_charts(self) -> None:
        self.charts = [
            Chart(self.colors, "Time t [s]", " ", f"{height}px", min_border_left=_LEFT,
                  tools="xpan,xbox_zoom,xwheel_zoom,reset")
            for height in _HEIGHTS
        ]  # fmt: skip
        for chart in self.charts[:-1]:
            chart.figure.xaxis[0].axis_label = None
        self._legends = [pane(sizing_mode="stretch_width", margin=(4, 8, 0, 8)) for _ in _HEIGHTS]
        names = ("force", "contraction", "pressures", "valves", "energies")
        self._curves, self._cursors = [], []
        for chart, name in zip(self.charts, names, strict=True):
            self._curves.append(chart.add(
                "multi_line", "xs ys color dash width", f"time_{name}", line_width="width",
                line_dash="dash",
            ))  # fmt: skip
            chart.figure.x_range = self.charts[0].figure.x_range
            chart.add_zero_line()
            cursor = Span(
                location=0, dimension="height", line_color=self.colors.ink, line_width=1.5,
                level="overlay",  # drawn alone: the curves stay
                name=f"cursor_{name}",
            )  # fmt: skip
            chart.figure.add_layout(cursor)
            self._cursors.append(cursor)

    def _add_player(self) -> None:
        colors = self.colors
        style: dict[str, Any] = {"stylesheets": [WIDGET_CSS]}
        play = Button(label="▶ Play", width=96, margin=(20, 4, 4, 8), name="play", **style)
        speed = Select(title="Speed", width=78, value="1", margin=(2, 8),
                       options=[(value, f"{value}×") for value in _SPEEDS], **style)  # fmt: skip
        self._slider = Slider(
            title="Time [s]", start=0, end=1, value=0, step=0.001, margin=(4, 14), name="time",
            sizing_mode="stretch_width", format="0.000", **style,
        )  # fmt: skip
        readout = Div(text="", sizing_mode="stretch_width", margin=(2, 8), name="readout",
                      stylesheets=[":host { font-variant-numeric: tabular-nums;"
                                   " color: var(--ink); }"])  # fmt: skip
        scene = self._scene = Chart(
            colors, "", "", _SCENE_HEIGHT, tools="", toolbar_location=None, min_border=0
        )
        rigid = scene.add("patches", "xs ys fill", "time_rigid", fill_color="fill",
                          line_color=None)  # fmt: skip
        tubes = scene.add(
            "patches", "xs ys fill line alpha hatch", "time_tubes", fill_color="fill",
            fill_alpha="alpha", line_color="line", line_width=1.5, hatch_pattern="hatch",
            hatch_color="line", hatch_scale=7,
        )  # fmt: skip
        labels = scene.add(
            "text", "x y label", "time_labels", text_color=colors.ink, text_align="center",
            text_baseline="bottom", text_font_size="12px", text_line_height=1.1,
        )  # fmt: skip
        valves = scene.new_source("x y marker size color", "time_valves")
        scene.figure.scatter("x", "y", source=valves, marker="marker", size="size",
                             fill_color="color", line_color="color", line_width=2)  # fmt: skip
        frames = self._frames = scene.new_source("time", "time_frames")
        frames.tags = [None]
        code = CustomJS(
            args={
                "frames": frames, "slider": self._slider, "play": play, "speed": speed,
                "cursors": self._cursors, "tubes": tubes, "rigid": rigid, "labels": labels,
                "valves": valves, "readout": readout, "scene": scene.figure,
            },
            code=_PLAY,
        )  # fmt: skip
        play.js_on_click(code)
        frames.js_on_change("data", code)
        for control in (self._slider, speed):
            control.js_on_change("value", code)
        for size in ("inner_width", "inner_height"):
            scene.figure.js_on_change(size, code)
        for chart in self.charts:
            chart.figure.js_on_event(Tap, code)
        self._player = [play, self._slider, speed]
        self._readout = pn.pane.Bokeh(readout, margin=0, sizing_mode="stretch_width")

    def _lay_out(self) -> None:
        left = side_column(
            self.file, self._fields, self._policy_title, self.policies, self._policy_words,
            self.save_scenario,
            width=300,
        )  # fmt: skip
        play, slider, speed = (
            pn.pane.Bokeh(model, margin=0, sizing_mode="stretch_width" if model is self._slider
                          else None)
            for model in self._player
        )  # fmt: skip
        self._drawing_legend = pane(sizing_mode="stretch_width")
        drawing = column(
            self.drawn, self._scene.new_pane(), self._drawing_legend, self._table,
            row(*self.saves, kind="wrapped", sizing_mode=None, margin=(4, 4)),
            self.download_message.pane,
            kind="equal", styles={"flex": "2 1 0"},
        )  # fmt: skip
        charts = column(
            *(component for legend, chart in zip(self._legends, self.charts, strict=True)
              for component in (legend, chart.new_pane())),
            kind="equal", styles={"flex": "3 1 0"},
        )  # fmt: skip
        self._shown = column(
            row(play, slider, speed, kind=""), self._readout, row(drawing, charts), visible=False,
        )  # fmt: skip
        self.empty_state = column(pane(_EMPTY, sizing_mode="stretch_width"), kind="framed",
                                  margin=8)  # fmt: skip
        top = row(self.scenario, self.run, self.cancel, kind="wrapped")
        main = column(
            top, self._about, self._progress.bar, self.status, self.message.pane, self.notes,
            self.empty_state, self._shown,
        )  # fmt: skip
        self.panel = row(left, main)

    # the setup

    def draw(self, view: View) -> None:
        """Draw all that the tab shows of a `view`."""
        setup = view.setup
        self._updating = True
        self.scenario.value = _OWN if setup.own else setup.name
        name = setup.name if setup.own else scenarios()[setup.name]
        self._about.object = f"<p>{html.escape(name)}</p>"
        self._show_fields(view)
        has_control = setup.has_control
        self.policies.param.update(visible=has_control, value=list(setup.policies))
        self._policy_title.object = (
            heading("Policies to compare (default: the scenario's)")
            if has_control
            else status_line("Valves follow a schedule: there is no policy to choose.")
        )
        self._policy_words.visible = has_control
        self._updating = False
        try:
            require("jax")
        except MissingExtraError as error:
            self.run.disabled = True
            self.message.show(f"A simulation needs JAX: {error}")
        if self.result is not None:
            self._show_runs()
        self._show_notes()

    def follow(self, before: View, after: View) -> None:
        """Send the drawing once more: browsers drop what they drew when another tab is opened."""
        del before, after
        if self.result is not None:
            self._show_frames()

    def _show_fields(self, view: View) -> None:
        fields = view.setup.fields
        if [field.path for field in fields] != list(self._inputs):
            self._inputs = {field.path: self._make_input(field) for field in fields}
            cells = [column(*field.widgets) for field in self._inputs.values()]
            # a new grid: Bokeh leaves an empty cell where it changes the children of one
            self._fields.objects = [column(*cells, kind="pairs")]
        for field in fields:
            unit = field_unit(field.dimension, view.display_units)
            self._inputs[field.path].show(field.value, unit)

    def _make_input(self, field: ScenarioValue) -> Field:
        def set_value(value: float) -> None:
            setup = self.session.view.setup
            self.session.change(setup=setup.with_value(field.path, value))

        (*_, name) = (key for key in field.path.split(".") if not key.isdigit())
        return Field(field.label, name, field.dimension, set_value)

    def _choose_scenario(self, name: str) -> None:
        if self._updating:
            return
        if name == _OWN:
            self.message.show("Open your own scenario by its file, on the left.")
            self.draw(self.session.view)
            return
        self.message.show("")
        self.session.change(setup=Setup(name))

    def _set_policies(self, names: list[str]) -> None:
        """Set the control policies to compare to those that a visitor ticked."""
        if self._updating:
            return
        setup = self.session.view.setup
        policies = check_policies(setup, names)
        self.session.change(setup=replace(setup, policies=policies))

    def _open_file(self, raw: bytes, name: str) -> None:
        with self.message.errors():
            setup = open_setup(decode_upload(raw, name, "scenario", LARGEST_FILE), name)
            self.session.input_names.add(name)
            self.session.change(setup=setup)

    # jobs

    def start_run(self) -> None:
        """Run the scenario in a worker process."""
        setup = self.session.view.setup
        self._begin_job("simulating")
        arguments = setup.text(), setup.name, setup.policies
        self._runs.request(lambda: (setup, run_job(run_policies, *arguments)))

    def cancel_job(self) -> None:
        """Drop the result of the running job."""
        self._runs.drop()
        self._end_job()
        self.status.object = status_line("Canceled.")

    def _begin_job(self, text: str) -> int:
        """Show the `text` of a job while it runs; returns its number."""
        self._job += 1
        self.message.show("")
        self._enable_buttons(False)
        self._progress.start(lambda seconds: f"{text}: {seconds:.0f} s")
        return self._job

    def _end_job(self) -> None:
        self._job += 1
        self._progress.stop()
        self._enable_buttons(True)

    def _fail_job(self, error: ValueError | str) -> None:
        """End a job that failed, and say so; the last result stays."""
        self._end_job()
        self.fail(error)

    def _enable_buttons(self, idle: bool) -> None:
        """Enable the buttons of a tab that is `idle`, or that of a running job."""
        self.run.disabled, self.cancel.disabled = not idle, idle
        self.enable(self.saves, idle and self.result is not None)

    # the result

    def _show_result(self, outcome: tuple[Setup, SimulationResult]) -> None:
        self._setup, self.result = outcome
        self._end_job()
        labels = [run.policy for run in self.result.runs]
        self._updating = True
        value = self.drawn.value if self.drawn.value in labels else labels[0]
        self.drawn.param.update(options=labels, value=value, visible=len(labels) > 1)
        self._updating = False
        self.empty_state.visible, self._shown.visible = False, True
        self._show_runs()
        self._show_notes()

    def _choose_drawn(self, _: Any) -> None:
        if not self._updating and self.result is not None:
            with pn.io.unlocked():
                self._show_runs()

    @property
    def drawn_run(self) -> PolicyResult:
        """The run that is drawn."""
        assert self.result is not None  # else nothing is shown
        runs = {run.policy: run for run in self.result.runs}
        return runs.get(self.drawn.value, self.result.runs[0])

    def _show_notes(self) -> None:
        result, setup = self.result, self.session.view.setup
        if result is None:
            return
        moments, samples = len(result.runs[0].table["time"].values), len(result.runs[0].rows)
        lines = [
            f"The page has {samples} even samples of the run's {moments} times; CSV and table"
            " have all of them."
        ]
        if setup != self._setup:
            name = html.escape(result.name)
            text = f"<b>These are results of {name} before your changes: press Run.</b>"
            lines.insert(0, text)
        notes = [note for run in result.runs for note in run.notes]
        lines += [text_html(note) for note in dict.fromkeys(notes)]
        lines += [f"{text_html(note[:1].upper() + note[1:])}." for note in result.notes]
        doubts = "".join(
            f'<p class="warning">{html.escape(_run_label(run))} can\'t be trusted:'
            f" {text_html('; '.join(run.doubts))}.</p>"
            for run in result.runs if run.doubts
        )  # fmt: skip
        self.notes.object = doubts + status_line(" ".join(lines))

    def _show_runs(self) -> None:
        """Show the charts, the drawing and the table."""
        result, run, colors = self.result, self.drawn_run, self.colors
        assert result is not None
        end = float(run.table["time"].values[-1])
        step = float(f"{end / (len(run.rows) - 1):.6g}")
        self._slider.update(end=end, step=step)
        for curves, chart, source, legend in zip(
            self._chart_curves(colors), self.charts, self._curves, self._legends, strict=True
        ):
            self._show_curves(curves, chart, source, legend)
        if result.policy_rows:
            keep = [i for i, head in enumerate(result.heads)
                    if head.split(" [")[0] in _COLUMNS]  # fmt: skip
            heads = [result.heads[i].removesuffix(" [-]") for i in keep]
            rows = [[html.escape(cells[i]) for i in keep] for cells in result.policy_rows]
            measure = _DRAWDOWN + (_DIP if "drawdown/D" in heads else "")
            self._table.object = html_table(heads, rows) + f'<p class="small note">{measure}</p>'
        else:
            self._table.object = ""
        self._show_frames()

    def _show_curves(
        self, chart_curves: ChartCurves, chart: Chart, source: Any, legend: Any
    ) -> None:
        title, unit, curves = chart_curves
        time = self._samples("time")
        source.data = {
            "xs": [time] * len(curves),
            "ys": [curve.values for curve in curves],
            "color": [curve.color for curve in curves],
            "dash": [curve.dash for curve in curves],
            "width": [curve.width for curve in curves],
        }
        lines = [(html.escape(curve.label), curve.color, _CSS_DASHES[_DASHES.index(curve.dash)])
                 for curve in curves]  # fmt: skip
        legend.object = f"<b>{title}</b>{html_legend(lines)}"
        chart.figure.yaxis[0].axis_label = f"[{unit}]"
        values = np.concatenate([curve.values for curve in curves])
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        gap = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
        chart.set_ranges((0.0, time[-1]), (low - gap, high + gap))

    def _samples(self, name: str, run: PolicyResult | None = None) -> np.ndarray:
        """Values [SI] of a variable of a `run`, the drawn one by default, at its samples."""
        run = run or self.drawn_run
        return np.asarray(run.table[name].values)[run.rows]

    def _chart_curves(self, colors: Colors) -> list[ChartCurves]:
        """Curves of each chart, on a page of these `colors`."""
        result, run = self.result, self.drawn_run
        assert result is not None
        labels = [_run_label(item) for item in result.runs]
        styles = list(zip(labels, _run_colors(colors, len(labels)), cycle(_DASHES)))
        rotary = result.rotary
        force_unit, force = ("N·m", 1.0) if rotary else self.unit("force")
        length_unit, length = ("°", np.pi / 180) if rotary else self.unit("length")
        pressure_unit, pressure = self.unit("pressure")
        runs = result.runs
        forces = _curves([item.pull[item.rows] / force for item in runs], styles)
        positions = _curves([self._samples("position", item) / length for item in runs], styles)
        if result.quantity:
            chart, scale = (forces, force) if result.quantity == "force" else (positions, length)
            demand = self._samples("demand") / scale
            chart.insert(0, Curve(demand, "demand", colors.ink, "dashed", 1.5))
        units = run.table["pressure"].values.shape[1]
        by_unit = [(f"unit {i + 1}", color) for i, color in
                   enumerate(cycle_colors(colors, units))]  # fmt: skip
        pressures = _curves(self._samples("pressure").T / pressure, by_unit)
        supply = self._samples("supply_pressure") / pressure
        pressures.append(Curve(supply, "supply", colors.ink, "dashed", 1.5))
        valves = _curves(self._openings(run).T, by_unit)
        energies = _energies(run.table, run.rows, colors)
        of_run = f", {run.policy}" if len(result.runs) > 1 else ""
        return [
            ChartCurves(f"{'Moment' if rotary else 'Force'} on the load", force_unit, forces),
            ChartCurves("Angle" if rotary else "Contraction", length_unit, positions),
            ChartCurves(f"Pressures, gauge{of_run}", pressure_unit, pressures),
            ChartCurves(f"Valves{of_run}: + to the supply, − to the room", "–", valves),
            ChartCurves(f"Energies since the start{of_run}", "J", energies),
        ]

    def _openings(self, run: PolicyResult) -> np.ndarray:
        """Opening of each unit's valve at the samples [-], negative to the room."""
        return self._samples("supply_opening", run) - self._samples("exhaust_opening", run)

    def _show_frames(self) -> None:
        """Send the drawing, and the numbers beside it."""
        result, run, colors = self.result, self.drawn_run, self.colors
        assert result is not None
        drawing = run.drawing
        frames, units = len(run.rows), drawing.states.shape[1]
        pressure_unit, pressure = self.unit("pressure")
        openings = self._openings(run)
        openings = np.where(np.abs(openings) < _OPEN, 0.0, openings)
        fills = rigid_colors(colors)
        force, contraction, *_ = self._chart_curves(colors)
        numbers, columns = [], {}
        for (name, unit, curves), key in ((force, "force"), (contraction, "position")):
            curve_by_label = {curve.label: curve for curve in curves}
            columns[key] = curve_by_label[_run_label(run)].values
            numbers.append((name.lower(), key, unit))
            if "demand" in curve_by_label:
                columns["demand"] = curve_by_label["demand"].values
                numbers.append(("demand", "demand", unit))
        has_line = "demand" in drawing.rigid_kinds
        self._drawing_legend.object = status_line(_LEGEND + _DEMAND_LEGEND * has_line)
        top = drawing.extent[3]
        self._frames.tags = [{
            "muscles": drawing.muscles,
            "colors": cycle_colors(colors, units),
            "alphas": ALPHAS,
            "hatches": ["right_diagonal_line" if hatched else " " for hatched in HATCHED],
            "states": STATES,
            "fixed": [[polygon[:, 0].tolist(), polygon[:, 1].tolist()]
                      for polygon in drawing.fixed],
            "fixed_fills": [fills[kind] for kind in drawing.fixed_kinds],
            "rigid_fills": [fills[kind] for kind in drawing.rigid_kinds],
            "labels": drawing.labels,
            "label_height": top - 28.0,
            "valve_height": top - 40.0,
            "narrow": min(width for _, width in drawing.labels) < _NARROW and units > 2,
            "extent": drawing.extent,
            "digits": 0 if pressure_unit == "kPa" else 2,
            "pressure_unit": pressure_unit,
            "numbers": numbers,
            "supply": colors.curves[5] if not colors.dark else colors.accent,
            "room": colors.curves[4],
            "shut": colors.soft,
        }]  # fmt: skip
        self._frames.data = {
            "time": self._samples("time"),
            "tubes": drawing.tubes.reshape(frames, -1),
            "rigid": drawing.rigid.reshape(frames, -1),
            "states": drawing.states,
            "pressures": self._samples("pressure") / pressure,
            "openings": openings,
            **columns,
        }

    # files

    def _file_stem(self) -> str:
        assert self.result is not None
        kind = self.drawn_run.policy.split(" ")[0] or "run"
        return output_stem(self.result.name, kind, self.session.input_names)

    def _table_file(self) -> tuple[str, bytes]:
        return self._file_stem(), self.drawn_run.table.to_csv().encode()

    def _charts_file(self, kind: str) -> tuple[str, bytes]:
        figure = charts_figure(self._samples("time"), self._chart_curves(LIGHT))
        return self._file_stem(), to_bytes(figure, kind)

    def _film_arguments(self) -> tuple[Any, ...]:
        run, (force, contraction, pressures, *_) = self.drawn_run, self._chart_curves(LIGHT)
        assert self.result is not None
        title = ", ".join(filter(None, (self.result.name, run.policy)))
        colors = cycle_colors(LIGHT, run.drawing.states.shape[1])
        charts = [force, contraction, pressures]
        return title, self._samples("time"), run.drawing, charts, colors

    def _scenario_file(self) -> tuple[str, bytes]:
        """Stem and bytes of the scenario with the changed values, and the policy that is drawn."""
        setup = self.session.view.setup
        policies = setup.policies
        if self.drawn.value and self.drawn.value.split(" ")[0] in policies:
            policies = (self.drawn.value.split(" ")[0],)
        policy = policies[0] if len(policies) == 1 else ""
        stem = output_stem(setup.name, "changed", self.session.input_names)
        return stem, setup.text(policy).encode()


def _curves(rows: Iterable[np.ndarray], styles: Iterable[tuple[Any, ...]]) -> list[Curve]:
    """Curves of the values in `rows`, with label, color and dash of `styles`."""
    return [Curve(values, *style) for values, style in zip(rows, styles, strict=True)]


def _run_colors(colors: Colors, count: int) -> list[str]:
    """Colors of `count` policies or energies, none of which is unit 1's or 2's."""
    return [colors.curves[2 + i % (len(colors.curves) - 2)] for i in range(count)]


def _run_label(run: PolicyResult) -> str:
    """Label of a run: its policy, or "reached" for a schedule."""
    return run.policy or "reached"


def _energies(table: Table, rows: np.ndarray, colors: Colors) -> list[Curve]:
    """Curves of the energies [J] since the start, in the terms of (A1) and (A2)."""

    def total(*names: str) -> np.ndarray:
        values = np.sum([table[name].values for name in names], axis=0)
        return (values - values[0])[rows]

    losses = [f"account_{name}" for name in ("valve", "exhaust", "mixing", "wall")]
    terms = {
        "from the supply": total("account_supplied"),
        "lost in valves and walls": total(*losses),
        "stored in fluid and muscles": total("stored_fluid", "stored_muscles"),
        "work on the load": total("account_pull"),
    }
    palette = (colors.ink, *_run_colors(colors, 3))
    return _curves(terms.values(), zip(terms, palette, _DASHES, strict=False))

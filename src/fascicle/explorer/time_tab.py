"""Tab of a simulation in time: a scenario is run, then bundle, load and charts move together.

The run goes to the browser once; there `time_page.js` plays it, without a message to the server.
"""

import html
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import panel as pn
from bokeh.events import Tap
from bokeh.models import Button, CustomJS, Div, Select, Slider, Span

from ..core.errors import MissingExtraError, require
from ..plot.theme import Colors
from . import time_run
from . import widgets as ui
from .chart import Chart, other_colors, padded_range, unit_colors
from .remarks import glossary_html
from .scenario_setup import (
    LARGEST_FILE,
    POLICIES,
    ScenarioValue,
    Setup,
    bundle_of,
    check_policies,
    open_setup,
    page_scenarios,
)
from .state import Session, View, view_of
from .tab import Export, Job, Tab, output_stem, run_job
from .texts import TEXTS


_TEXTS = TEXTS["time"]
_OWN = "(your file)"
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
# name of each chart's source, and its height in pixels, from top to bottom
_CHARTS = {"force": 150, "contraction": 150, "pressures": 150, "valves": 110, "energies": 170}
_LEFT = 66  # pixels beside each chart, so that times are below one another
_SCENE_HEIGHT = "clamp(300px, 100vh - 420px, 620px)"
_DASHES = ("solid", "dashed", "dotted", "dotdash", "dashdot")
_CSS_DASHES = {"dotdash": "dashed", "dashdot": "dashed"}  # the nearest of CSS, where it differs
_ENERGIES = {
    "from the supply": "account_supplied",
    "lost in valves and walls": "account_valve account_exhaust account_mixing account_wall",
    "stored in fluid and muscles": "stored_fluid stored_muscles",
    "work on the load": "account_pull",
}
_NARROW = 44.0  # mm of the drawing that a unit's labels take
_OPEN = 1e-3  # of a valve, from which on it counts as open
_TABLE_CSS = (  # five columns on a phone
    ".scroll { overflow-x: auto; } table { font-size: 12.5px; } th, td { padding-right: 9px; }"
)
_PLAY = (Path(__file__).with_name("time_page.js")).read_text(encoding="utf-8")


class Curve(NamedTuple):
    """A curve of a chart: `values` at the samples in the unit shown, `label`, `color`, `dash`."""

    values: np.ndarray
    label: str
    color: str
    dash: str = "solid"
    width: float = 2.0


ChartCurves = tuple[str, str, list[Curve]]  # title, unit and curves of a chart


class ScenarioInputs:
    """Choice of a scenario, and its values and policies that a visitor changes."""

    def __init__(self, tab: "TimeView"):
        self._session, self._tab = tab.session, tab
        self._scenarios = page_scenarios()
        names = [*self._scenarios, _OWN]
        self.scenario = ui.dropdown("Scenario", names, self._choose_scenario, width=180)
        self.file = ui.file_input("Open a scenario (.toml)", ".toml", self._open_file)
        self.about = ui.wide_pane()
        self._inputs: dict[str, ui.Field] = {}
        self._fields, self._policy_title = ui.column(), ui.pane()
        self.policies = ui.widget(
            pn.widgets.CheckBoxGroup, "Policies", self._set_policies, options=list(POLICIES)
        )
        self._words = ui.pane(glossary_html("Explain the policies", POLICIES))
        self.save = ui.download_button("Save scenario", self._scenario_file, tab.message)
        inputs = (self.file, self._fields, self._policy_title, self.policies, self._words)
        self.panel = ui.side_column(*inputs, self.save, width=300)

    def show(self, view: View) -> None:
        setup, has_control = view.setup, view.setup.has_control
        self.scenario.value = _listed_name(setup)
        name = setup.name if setup.own else self._scenarios[setup.name]
        self.about.object = f"<p>{html.escape(name)}</p>"
        self._show_fields(view)
        self.policies.param.update(visible=has_control, value=list(setup.policies))
        title = ui.heading("Policies to compare (default: the scenario's)")
        self._policy_title.object = title if has_control else ui.status_line(_TEXTS["no_policy"])
        self._words.visible = has_control

    def _show_fields(self, view: View) -> None:
        fields = view.setup.fields
        if [field.path for field in fields] != list(self._inputs):
            self._inputs = {field.path: self._make_input(field) for field in fields}
            cells = [ui.column(*field.widgets) for field in self._inputs.values()]
            # a new grid: Bokeh leaves an empty cell where it changes the children of one
            self._fields.objects = [ui.column(*cells, kind="pairs")]
        for field in fields:
            unit = ui.field_unit(field.dimension, view.display_units)
            self._inputs[field.path].show(field.value, unit)

    def _make_input(self, field: ScenarioValue) -> ui.Field:
        def set_value(value: float) -> None:
            setup = self._session.view.setup
            self._session.change(setup=setup.with_value(field.path, value))

        return ui.Field(field.label, field.name, field.dimension, set_value)

    def _choose_scenario(self, name: str) -> None:
        if name == _listed_name(self._session.view.setup):
            return
        if name == _OWN:
            self._tab.message.show("Open your own scenario by its file, on the left.")
            self.show(self._session.view)
            return
        self._tab.message.show("")
        self._session.change(setup=Setup(name))

    def _set_policies(self, names: list[str]) -> None:
        setup = self._session.view.setup
        self._session.change(setup=replace(setup, policies=check_policies(setup, names)))

    def _open_file(self, raw: bytes, name: str) -> None:
        with self._tab.message.errors():
            setup, session = (
                open_setup(ui.decode_upload(raw, name, LARGEST_FILE), name),
                self._session,
            )
            view = view_of(bundle_of(setup), name, session.view)
            session.open(replace(view, setup=setup))

    def _scenario_file(self) -> tuple[str, bytes]:
        """Name and bytes of the scenario with the changed values, and the policy that is drawn."""
        view = self._session.view
        policies = view.setup.policies
        drawn = str(self._tab.drawn.value or "").split(" ")[0]
        policy = drawn if drawn in policies else policies[0] if len(policies) == 1 else ""
        stem = output_stem(view.setup.name, "changed")
        return f"{stem}.toml", view.setup.text(policy, view.bundle).encode()


def _listed_name(setup: Setup) -> str:
    return _OWN if setup.own else setup.name


class Player:
    """Drawing of a run, with a button, a slider and a speed that play it in the browser."""

    def __init__(self, colors: Colors, charts: Sequence[Chart]):
        """Player whose slider and cursor are those of the `charts` over time, too."""
        plain = {"tools": "", "toolbar_location": None, "min_border": 0}
        scene = Chart(colors, "", "", _SCENE_HEIGHT, **plain)
        parts = {name: scene.add(f"time_{name}") for name in ("boxes", "tubes", "labels", "valves")}
        self._frames = scene.new_source("time", "time_frames")
        self._frames.tags = [None]
        cursors = []
        for name, chart in zip(_CHARTS, charts, strict=True):
            # drawn alone: the curves stay
            cursor = Span(location=0, dimension="height", level="overlay", name=f"cursor_{name}")
            cursor.update(line_color=colors.ink, line_width=1.5)
            chart.figure.add_layout(cursor)
            cursors.append(cursor)
        models = {"cursors": cursors, "frames": self._frames, "scene": scene.figure}
        style: Any = {"stylesheets": [ui.WIDGET_CSS]}
        play = Button(label="▶ Play", width=96, margin=(20, 4, 4, 8), name="play", **style)
        options: Any = [(value, f"{value}×") for value in _SPEEDS]
        speed = Select(title="Speed", width=78, value="1", margin=(2, 8), options=options, **style)
        style |= {"sizing_mode": "stretch_width", "margin": (4, 14), "format": "0.000"}
        slider = Slider(title="Time [s]", start=0, end=1, value=0, step=0.001, name="time", **style)
        numbers = ":host { font-variant-numeric: tabular-nums; color: var(--ink); }"
        readout = Div(text="", sizing_mode="stretch_width", margin=(2, 8), stylesheets=[numbers])
        controls = {"play": play, "speed": speed, "slider": slider, "readout": readout}
        code = CustomJS(args=parts | models | controls, code=_PLAY)
        play.js_on_click(code)
        self._frames.js_on_change("data", code)
        for control in (slider, speed):
            control.js_on_change("value", code)
        for size in ("inner_width", "inner_height"):
            scene.figure.js_on_change(size, code)
        for chart in charts:
            chart.figure.js_on_event(Tap, code)
        self._slider, self.pane = slider, scene.new_pane()
        modes = (play, None), (slider, "stretch_width"), (speed, None), (readout, "stretch_width")
        *controls, self.readout = (
            pn.pane.Bokeh(model, margin=0, sizing_mode=mode) for model, mode in modes
        )
        self.controls = ui.row(*controls, kind="")

    def show(self, fixed: dict[str, Any], frames: dict[str, np.ndarray]) -> None:
        """Send the columns of `frames`, and what is `fixed` in all of them."""
        end = float(frames["time"][-1])
        self._slider.update(end=end, step=float(f"{end / (len(frames['time']) - 1):.6g}"))
        self._frames.tags = [fixed]
        self._frames.data = frames


class TimeView(Tab):
    """Widgets and figures of a simulation."""

    name: ClassVar[str] = "time"
    fields: ClassVar[tuple[str, ...]] = ("setup", "display_units", "units", "muscle", "supply")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self.result: time_run.SimulationResult | None = None
        self._run_text = ""  # scenario of the result
        self.drawn = ui.dropdown("Policy that is drawn", [], self._choose_drawn, visible=False)
        self.inputs = ScenarioInputs(self)
        style: Any = {"width": 76, "margin": (22, 4, 4, 4)}
        self.job = Job(self, "Run", self.start_run, self._show_result, **style)
        style = {"min_border_left": _LEFT, "tools": "xpan,xbox_zoom,xwheel_zoom,reset"}
        self.charts = [
            Chart(colors, " ", " ", f"{height}px", **style) for height in _CHARTS.values()
        ]
        self.charts[-1].figure.xaxis[0].axis_label = "Time t [s]"
        self._legends = [ui.wide_pane(margin=(4, 8, 0, 8)) for _ in _CHARTS]
        self.curves: list[Any] = []
        for chart, name in zip(self.charts, _CHARTS, strict=True):
            chart.figure.x_range = self.charts[0].figure.x_range
            chart.add_zero_line()
            self.curves.append(chart.add("over_time", f"time_{name}"))
        self._player = Player(colors, self.charts)
        self._drawing_legend = ui.wide_pane()
        self._table = ui.pane(margin=(4, 8), stylesheets=[ui.LAYOUT_CSS, _TABLE_CSS])
        drawn = (self.drawn, self._player.pane, self._drawing_legend, self._table)
        drawing = ui.column(*drawn, kind="equal", styles={"flex": "2 1 0"})
        pairs = zip(self._legends, self.charts, strict=True)
        panes = (part for legend, chart in pairs for part in (legend, chart.new_pane()))
        charts = ui.column(*panes, kind="equal", styles={"flex": "3 1 0"})
        player = (self._player.controls, self._player.readout)
        self._shown = ui.column(*player, ui.row(drawing, charts), visible=False)
        self.empty_state = ui.column(ui.pane(_TEXTS["empty"]), kind="framed", margin=8)
        top = ui.row(self.inputs.scenario, self.job.run, self.job.cancel, kind="wrapped")
        state = (self.job.bar, self.status, self.message.pane, self.notes)
        main = ui.column(top, self.inputs.about, *state, self.empty_state, self._shown)
        self.panel = ui.row(self.inputs.panel, main)

    def draw(self, view: View) -> None:
        self.inputs.show(view)
        try:
            require("jax")
        except MissingExtraError as error:
            self.job.run.disabled = True
            self.message.show(f"A simulation needs JAX: {error}")
        self._show_runs()

    def follow(self, before: View, after: View) -> None:
        """Send the drawing once more: browsers drop what they drew when another tab is opened."""
        if self.result is not None and before.tab != after.tab:
            self._show_frames()

    def start_run(self) -> None:
        view = self.session.view
        text = view.setup.text(bundle=view.bundle)
        arguments = text, view.setup.name, view.setup.policies
        self.job.start("simulating", lambda _: (text, run_job(time_run.run_policies, *arguments)))

    def _show_result(self, outcome: tuple[str, time_run.SimulationResult]) -> None:
        self._run_text, self.result = outcome
        labels = [run.policy for run in self.result.runs]
        value = self.drawn.value if self.drawn.value in labels else labels[0]
        self.drawn.param.update(options=labels, value=value, visible=len(labels) > 1)
        self.empty_state.visible, self._shown.visible = False, True
        self._show_runs()

    def _choose_drawn(self, _: str) -> None:
        with pn.io.unlocked():
            self._show_runs()

    @property
    def drawn_run(self) -> time_run.PolicyResult:
        assert self.result is not None  # else nothing is shown
        runs = {run.policy: run for run in self.result.runs}
        return runs.get(self.drawn.value, self.result.runs[0])

    def _show_runs(self) -> None:
        result = self.result
        if result is None:
            return
        self._show_notes(result)
        time = self._samples("time")
        charts = self._chart_curves()
        rows = zip(charts, self.charts, self.curves, self._legends, strict=True)
        for (title, unit, curves), chart, source, legend in rows:
            ys, _, color, dash, width = map(list, zip(*curves, strict=True))
            xs = [time] * len(curves)
            source.data = {"xs": xs, "ys": ys, "color": color, "dash": dash, "width": width}
            lines = [
                (html.escape(c.label), c.color, _CSS_DASHES.get(c.dash, c.dash)) for c in curves
            ]
            legend.object = f"<b>{title}</b>{ui.html_legend(lines)}"
            chart.figure.yaxis[0].axis_label = f"[{unit}]"
            values = np.concatenate(ys)
            least = 0.0 if np.nanmin(values) < np.nanmax(values) else 1.0  # of a level curve
            chart.set_ranges((0.0, time[-1]), padded_range(values, 0.06, least))
        self._table.object = self._policy_table(result) if result.quantity else ""
        self._show_frames()

    def _policy_table(self, result: time_run.SimulationResult) -> str:
        """Table of the policies of a `result` in HTML."""
        is_force = result.quantity == "force"
        unit, scale = self.unit("force" if is_force else "length")
        heads = ["policy", f"drawdown [{unit}]", f"rms error [{unit}]", "energy [J]"]
        rows = [
            [html.escape(run.policy), f"{m.drawdown / scale:.4g}", f"{m.rms / scale:.4g}"]
            + [f"{m.energy:.4g}"]
            + [f"{m.drawdown / m.dip:.3f}" if m.dip else "–"] * is_force
            for run in result.runs
            if (m := run.measures) is not None
        ]
        note = _TEXTS["drawdown"] + _TEXTS["dip"] * is_force
        table = ui.html_table(heads + ["drawdown/D"] * is_force, rows)
        return f'{table}<p class="small note">{note}</p>'

    def _show_notes(self, result: time_run.SimulationResult) -> None:
        view = self.session.view
        moments, samples = len(result.runs[0].table["time"].values), len(result.runs[0].rows)
        lines = [f"The page has {samples} even samples of the run's {moments} times; CSV has all."]
        if view.setup.text(bundle=view.bundle) != self._run_text:
            name = html.escape(result.name)
            text = f"<b>These are results of {name} before your changes: press Run.</b>"
            lines.insert(0, text)
        lines += map(ui.text_html, result.notes)
        doubts = (
            f'<p class="warning">{html.escape(_run_label(run))} can\'t be trusted:'
            f" {ui.text_html('; '.join(run.doubts))}.</p>"
            for run in result.runs
            if run.doubts
        )
        self.notes.object = "".join(doubts) + ui.status_line(" ".join(lines))

    def _samples(self, name: str, run: time_run.PolicyResult | None = None) -> np.ndarray:
        """Values [SI] of a variable of a `run`, the drawn one by default, at its samples."""
        run = run or self.drawn_run
        return np.asarray(run.table[name].values)[run.rows]

    def _chart_curves(self) -> list[ChartCurves]:
        result, run, colors = self.result, self.drawn_run, self.colors
        assert result is not None
        labels = [_run_label(item) for item in result.runs]
        styles = list(zip(labels, other_colors(colors, len(labels)), cycle(_DASHES)))
        units = {name: self.unit(name) for name in ("force", "length", "pressure")}
        (_, force), (_, length), (_, pressure) = units.values()
        forces = _curves([item.pull[item.rows] / force for item in result.runs], styles)
        positions = [self._samples("position", item) / length for item in result.runs]
        contractions = _curves(positions, styles)
        if result.quantity:
            is_force = result.quantity == "force"
            demand = self._samples("demand") / (force if is_force else length)
            curve = Curve(demand, "demand", colors.ink, "dashed", 1.5)
            (forces if is_force else contractions).insert(0, curve)
        by_unit = [(f"unit {i + 1}", color) for i, color in enumerate(self._unit_colors())]
        pressures = _curves(self._samples("pressure").T / pressure, by_unit)
        supply = self._samples("supply_pressure") / pressure
        pressures.append(Curve(supply, "supply", colors.ink, "dashed", 1.5))
        openings = _curves(self._openings().T, by_unit)
        of_run = f", {run.policy}" if len(result.runs) > 1 else ""
        return [
            ("Force on the load", units["force"][0], forces),
            ("Contraction", units["length"][0], contractions),
            (f"Pressures, gauge{of_run}", units["pressure"][0], pressures),
            (f"Valves{of_run}: + to the supply, − to the room", "–", openings),
            (f"Energies since the start{of_run}", "J", self._energies()),
        ]

    def _unit_colors(self) -> list[str]:
        return unit_colors(self.colors, self.drawn_run.drawing.states.shape[1])

    def _openings(self) -> np.ndarray:
        """Opening of each unit's valve at the samples [-], negative to the room."""
        return self._samples("supply_opening") - self._samples("exhaust_opening")

    def _energies(self) -> list[Curve]:
        """Curves of the energies [J] since the start, in the terms of (A1) and (A2)."""
        names = map(str.split, _ENERGIES.values())
        totals = [np.sum([self._samples(name) for name in group], axis=0) for group in names]
        styles = zip(_ENERGIES, other_colors(self.colors, len(_ENERGIES)), _DASHES, strict=False)
        return _curves([total - total[0] for total in totals], styles)

    def _show_frames(self) -> None:
        run, drawing = self.drawn_run, self.drawn_run.drawing
        frames = len(run.rows)
        pressure_unit, pressure = self.unit("pressure")
        openings = self._openings()
        fills = time_run.box_colors(self.colors)
        numbers, columns = [], {}
        for (name, unit, curves), key in zip(
            self._chart_curves(), ("force", "position"), strict=False
        ):
            for curve in curves:
                if curve.label in ("demand", _run_label(run)):
                    column = "demand" if curve.label == "demand" else key
                    columns[column] = curve.values
                    numbers.append((column if column == "demand" else name.lower(), column, unit))
        kinds, left, right = zip(*drawing.boxes, strict=True)
        has_line = "demand" in kinds
        self._drawing_legend.object = ui.status_line(_TEXTS["legend"] + _TEXTS["demand"] * has_line)
        top = drawing.extent[3]
        fixed = {
            "muscles": drawing.muscles,
            "colors": self._unit_colors(),
            "alphas": time_run.ALPHAS,
            "hatches": time_run.HATCHES,
            "states": time_run.STATES,
            "boxes": {"left": left, "right": right, "fill": [fills[kind] for kind in kinds]},
            "labels": drawing.labels,
            "label_height": top - 28.0,
            "valve_height": top - 40.0,
            "narrow": min(width for _, width in drawing.labels) < _NARROW
            and len(drawing.labels) > 2,
            "extent": drawing.extent,
            "digits": 0 if pressure_unit == "kPa" else 2,
            "pressure_unit": pressure_unit,
            "numbers": numbers,
            "open": self.colors.ink,
            "shut": self.colors.soft,
        }
        columns |= {
            "time": self._samples("time"),
            "tubes": drawing.tubes.reshape(frames, -1),
            "heights": drawing.heights.reshape(frames, -1),
            "states": drawing.states,
            "pressures": self._samples("pressure") / pressure,
            "openings": np.where(np.abs(openings) < _OPEN, 0.0, openings),
        }
        self._player.show(fixed, columns)

    def export(self) -> Export:
        if self.result is None:
            raise ValueError("Run a scenario first: there is nothing to download yet.")
        run = self.drawn_run
        kind = run.policy.split(" ")[0] or "run"
        stem = output_stem(self.result.name, kind)
        return Export(stem, run.table, lambda: run.figure)


def _curves(rows: Iterable[np.ndarray], styles: Iterable[tuple[Any, ...]]) -> list[Curve]:
    """Curves of the values in `rows`, with label, color and dash of `styles`."""
    return [Curve(values, *style) for values, style in zip(rows, styles, strict=True)]


def _run_label(run: time_run.PolicyResult) -> str:
    """Label of a run: its policy, or "reached" for a schedule."""
    return run.policy or "reached"

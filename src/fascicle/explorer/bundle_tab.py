"""The bundle's tab: motor units, what they reach together, and the way back from a point."""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.events import Press, Tap
from bokeh.models import HoverTool

from ..bundle.schemes import SCHEMES
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, check_interval
from ..plot.theme import BLACK, WHITE, mixed
from .background import Latest, shared
from .bundle_curves import Shown, Way, force_at, shown_space, solids, state_at, ways
from .solid import Scene
from .state import MOST_UNITS, SIZES, Session, Unit, View, changed, check_units
from .tab import Tab, equilibria, remarks, status
from .theme import (
    AFTER,
    NARROW,
    ROLLED,
    STACKED,
    TALL,
    Look,
    half,
    legend_style,
    plain_figure,
    set_range,
    source_of,
    told,
    widget_css,
)
from .widgets import (
    STEPS,
    Dial,
    Field,
    Message,
    Sweep,
    button,
    choice,
    factor,
    heading,
    shown,
    table,
)


_STAGE = "clamp(240px, 100vh - 480px, 900px)"  # how high the bundle is shown


class BundleView(Tab):
    """Widgets and figures of a bundle."""

    name: ClassVar[str] = "bundle"
    fields: ClassVar[tuple[str, ...]] = (
        "muscle", "units", "supply", "scheme", "resistance", "shown", "distance",
    )  # fmt: skip

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        super().__init__(session, look)
        self._silent, self._top, self._half_force = False, 0.3, 0.0
        self._rows = UnitRows(session, look)
        self._scheme = choice(look, "Recruitment", list(SCHEMES))
        self._scheme.param.watch(lambda e: self._set(scheme=e.new), "value")
        self._resistance = pn.widgets.Checkbox(
            label="Muscles past their free strain push back", margin=(6, 8),
            stylesheets=[widget_css(look)],
        )  # fmt: skip
        self._resistance.param.watch(lambda e: self._set(resistance=e.new), "value")
        self._supply = Field(look, "Supply pressure", "supply", "pressure", self._supplied)
        self._strain = Dial(
            look, "Contraction ε", "strain", "strain", lambda value: session.change(strain=value)
        )
        self._draw_figure()
        self._scene = Scene(look, "bundle", _STAGE)
        self._play = Sweep(look, "", self._step)
        self._numbers = pn.pane.HTML("", margin=(0, 8))
        self._status = pn.pane.HTML("", margin=(0, 8), height=22)
        self._notes = pn.pane.HTML("", sizing_mode="stretch_width", margin=(0, 8))
        self._ways = pn.Column(margin=0, sizing_mode="stretch_width")
        self._space = Latest(self._show_space, self._failed)
        self._state = Latest(self._show_state, self._failed)
        self._way = Latest(self._show_ways, self._failed)
        left = pn.Column(
            self._scheme, self._supply.panel, self._resistance, self._rows.panel,
            width=318, margin=(0, 8, 0, 0), stylesheets=[ROLLED, AFTER],
        )  # fmt: skip
        space = pn.Column(
            pn.pane.Bokeh(self.figure, margin=0, stylesheets=[TALL]), self.message.pane,
            margin=0, **half(),
        )  # fmt: skip
        stage = pn.Column(
            pn.pane.Bokeh(self._scene.figure, margin=0, stylesheets=[TALL]),
            pn.Row(self._scene.turn, self._play.button, sizing_mode="stretch_width", margin=0),
            heading("At this point"), self._numbers,
            heading("Pressures that reach a point"), self._ways, margin=0, **half(),
        )  # fmt: skip
        main = pn.Column(
            self._notes, self._strain.panel, self._status,
            pn.Row(space, stage, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]),
            sizing_mode="stretch_width", margin=0, stylesheets=[NARROW],
        )  # fmt: skip
        self.panel = pn.Row(
            left, main, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]
        )

    def draw(self, view: View) -> None:
        """Show a `view` [-]."""
        self._silent = True
        self._scheme.value = str(view.scheme)
        self._resistance.value = view.resistance
        self._silent = False
        self._supply.show(view.supply, view.shown["pressure"])
        self._rows.show(view)
        self._play.name(f"P{len(view.units)}")
        self._notes.object = remarks(view, "bundle")
        self._status.object = status("computing the space")
        self._space.ask(lambda: shared(shown_space, view.bundle, view.resistance))

    def moved(self, before: View, after: View) -> None:
        """Follow the sliders of pressure and strain."""
        if changed(before, after, "pressures"):
            self._rows.press(after)
        if changed(before, after, "strain"):
            self._strain.show(after.strain, "", self._top)
        if changed(before, after, "pressures", "strain"):
            self._ask_state(after)

    def _set(self, **changes: Any) -> None:
        if not self._silent:
            self.session.change(**changes)

    def _supplied(self, value: float) -> None:
        check_interval(value, 0.0, HIGHEST_PRESSURE, "supply", "Pa", "(gauge)", (False, True))
        view = self.session.view
        self.session.change(
            supply=value,
            pressures=tuple(min(P, value) for P in view.pressures),
            pressure=min(view.pressure, value),
        )

    def _failed(self, text: str) -> None:
        self._status.object = ""
        self.message.say(text)

    def _step(self) -> bool:
        """Raise the last unit's pressure, and begin anew at none."""
        view = self.session.view
        if view.tab != self.name:
            return False
        following = float(f"{view.pressures[-1] + view.supply / STEPS:.6g}")
        last = 0.0 if following > view.supply else following
        self.session.change(pressures=(*view.pressures[:-1], last))
        return True

    # the figure

    def _draw_figure(self) -> None:
        look = self.look
        fig = plain_figure(look, "Contraction ε [–]", "Force F [N]", room=290)
        self.figure = fig
        empty = {"xs": [], "ys": [], "color": [], "label": []}
        self._regions = source_of(empty, name="regions")
        self._levels = source_of({**empty, "width": []})
        self._shared = source_of({"xs": [], "ys": []}, name="overlap")
        self.chosen = source_of({"strain": [], "force": []}, name="bundle_force")
        self._units = source_of(empty)
        self._zeros = source_of({"x": [], "y": [], "fill": []}, name="zeros")
        self._here = source_of({"x": [], "y": []})
        self._asked = source_of({"x": [], "y": []}, name="asked")
        fig.line([-1, 10], [0, 0], color=look.soft, line_width=1)
        fig.patches("xs", "ys", source=self._regions, color="color", fill_alpha=0.16,
                    line_width=1.5, legend_field="label")  # fmt: skip
        fig.multi_line("xs", "ys", source=self._levels, color="color", line_width="width",
                       line_alpha=0.7)  # fmt: skip
        fig.patches("xs", "ys", source=self._shared, fill_alpha=0, line_alpha=0,
                    hatch_pattern="right_diagonal_line", hatch_color=look.ink, hatch_alpha=0.55,
                    hatch_scale=9, legend_label="overlap of states")  # fmt: skip
        fig.multi_line("xs", "ys", source=self._units, color="color", line_width=1.6,
                       line_dash="dashed", legend_label="each unit, now")  # fmt: skip
        main = fig.line("strain", "force", source=self.chosen, color=look.ink, line_width=3,
                        legend_label="all units, now")  # fmt: skip
        self._hover = HoverTool(
            renderers=[main], mode="vline", line_policy="interp", tooltips=told("F", "N")
        )
        fig.add_tools(self._hover)
        fig.scatter("x", "y", source=self._zeros, size=10, line_color=look.ink,
                    fill_color="fill", line_width=2,
                    legend_label="at rest (hollow: not stable)")  # fmt: skip
        fig.scatter("x", "y", source=self._here, size=13, marker="diamond", color=look.curves[1],
                    line_color=look.paper, legend_label="this contraction")  # fmt: skip
        fig.scatter("x", "y", source=self._asked, size=16, marker="cross", color=look.curves[1],
                    line_width=3, legend_label="the point asked for")  # fmt: skip
        fig.on_event(Tap, self._tapped)
        fig.on_event(Press, self._tapped)  # a click that lasts, too
        legend_style(fig, look)
        fig.legend.glyph_height = 20  # of points
        *_, self._pointed = fig.legend.items
        self._pointed.visible = False

    def _show_space(self, found: Shown) -> None:
        view = self.session.view
        scale, unit = factor(view.shown["force"], "force"), view.shown["force"]
        space, cycle = found.space, self.look.curves
        self._top = max(0.1, float(np.ceil(found.top * 50) / 50))
        outlines = [space.outline(state + 1) for state in range(len(space.force))]
        colors = [cycle[i % len(cycle)] for i in range(len(outlines))]
        self._regions.data = {
            "xs": [strain for strain, _ in outlines],
            "ys": [force / scale for _, force in outlines],
            "color": colors,
            "label": [f"recruitment state {i + 1}" for i in range(len(outlines))],
        }
        lines = [
            (np.where(row >= 0, row / scale, np.nan), color, 0.5 + 1.2 * k / len(curves))
            for curves, color in zip(space.force, colors, strict=True)
            for k, row in enumerate(curves)
        ]
        self._levels.data = {
            "xs": [space.strain] * len(lines),
            "ys": [line for line, _, _ in lines],
            "color": [color for _, color, _ in lines],
            "label": [""] * len(lines),
            "width": [width for _, _, width in lines],
        }
        pairs = [found.overlap.outline(i) for i in range(len(found.overlap.states))]
        pairs = [(strain, force) for strain, force in pairs if strain.size]
        self._shared.data = {
            "xs": [strain for strain, _ in pairs],
            "ys": [force / scale for _, force in pairs],
        }
        high = float(space.high.max()) / scale
        self._half_force = float(np.interp(0.5 * self._top, space.strain, space.high[-1])) / scale
        set_range(self.figure.x_range, 0.0, self._top)
        set_range(self.figure.y_range, -0.12 * high, 1.06 * high)
        self.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = told("F", unit)
        self._asked.data, self._pointed.visible = {"x": [], "y": []}, False
        self._invite()
        self.message.say("")
        self._strain.show(min(view.strain, self._top), "", self._top)
        self._ask_state(view)

    def _ask_state(self, view: View) -> None:
        top = self._top
        strain = min(view.strain, top)

        def compute() -> tuple[Any, ...]:
            bundle = view.bundle
            return (
                view,
                state_at(bundle, view.pressures, top, view.resistance),
                force_at(bundle, view.pressures, strain, view.resistance),
                solids(view, top),
            )

        self._state.ask(compute)

    def _show_state(self, found: tuple[Any, ...]) -> None:
        view, state, force, (drawn, owner, places, reach) = found
        scale, unit = factor(view.shown["force"], "force"), view.shown["force"]
        cycle = self.look.curves
        self._status.object = ""
        self._units.data = {
            "xs": [state.strain] * len(state.units),
            "ys": list(state.units / scale),
            "color": [cycle[i % len(cycle)] for i in range(len(state.units))],
            "label": [""] * len(state.units),
        }
        self.chosen.data = {"strain": state.strain, "force": state.force / scale}
        self._zeros.data = {
            "x": state.zeros, "y": np.zeros(state.zeros.size),
            "fill": [self.look.ink if one else self.look.paper for one in state.stable],
        }  # fmt: skip
        self._here.data = {"x": [min(view.strain, self._top)], "y": [force / scale]}
        colors = [cycle[i % len(cycle)] for i in range(max(owner) + 1)]
        pale = 0.35 if self.look.dark else 0.62  # so that fibers are seen on it
        shades = [(mixed(one, WHITE, pale), mixed(one, BLACK, 0.35)) for one in colors]
        length = float(view.bundle.length)
        wide = max(0.58 * length, 1.1 * reach), 1.05 * reach + 0.12 * length
        self._scene.show(drawn, [shades[i] for i in owner], places, wide)
        inch = view.shown["length"]
        self._numbers.object = table({
            "force": f"{force / scale:.4g} {unit}",
            "free strain": equilibria(state.zeros, state.stable),
            "envelope's radius": f"{reach / factor(inch, 'length'):.4g} {inch}",
        })  # fmt: skip

    # the way back

    def _invite(self) -> None:
        text = "Click in the space, and here are the pressures that reach that point. "
        self._ways.objects = [
            pn.pane.HTML(status(text), margin=(0, 8)),
            button(self.look, "Try a point", self._try_point, margin=(2, 8)),
        ]

    def _try_point(self) -> None:
        """In the middle of what all units together reach, for keys too."""
        self._asked_for(0.5 * self._top, 0.3 * self._half_force)

    def _tapped(self, event: Any) -> None:
        if event.x is None or not 0 <= event.x <= self._top:
            return
        self._asked_for(float(event.x), float(event.y))

    def _asked_for(self, x: float, y: float) -> None:
        """Look for pressures that reach the point `x` [-], `y` [shown unit]."""
        view = self.session.view
        scale = factor(view.shown["force"], "force")
        with pn.io.unlocked():
            self._asked.data, self._pointed.visible = {"x": [x], "y": [y]}, True
        self._ways.objects = [pn.pane.HTML(status("looking for pressures"))]
        # as finely as it can be pointed at; the slider, the field and the link follow
        strain, force = round(x, 4), y * scale
        self.session.change(strain=strain)
        unit = view.shown["force"]
        self._way.ask(lambda: (strain, *ways(view.bundle, force, strain, view.resistance, unit)))

    def _show_ways(self, found: tuple[float, list[Way], str]) -> None:
        strain, several, remark = found
        unit = self.session.view.shown["pressure"]
        scale = factor(unit, "pressure")
        rows: list[Any] = [pn.pane.HTML(status(remark), margin=(0, 8))] if remark else []
        for way in several:
            needed = ", ".join(f"{P / scale:.4g}" for P in way.pressures)
            kept = "" if way.stable else ", not stable"
            rows.append(
                button(
                    self.look, f"state {way.state}: {needed} {unit}{kept}",
                    lambda way=way: self.session.change(
                        pressures=tuple(float(f"{P:.6g}") for P in way.pressures), strain=strain
                    ),
                    sizing_mode="stretch_width", margin=(2, 8),
                )
            )  # fmt: skip
        self._ways.objects = rows


class UnitRows:
    """A row for each motor unit, added and removed at the end."""

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        self._session, self._look, self._silent = session, look, False
        self.message = Message("units")
        self._rows = pn.Column(margin=0, sizing_mode="stretch_width")
        self._parts: list[tuple[Any, Field, Dial, Any]] = []
        buttons = pn.Row(
            button(look, "Add a unit", self._add, width=110, margin=(4, 4, 4, 8)),
            button(look, "Remove the last", self._remove, width=130, margin=4),
            margin=0,
        )
        self.panel = pn.Column(
            buttons, self.message.pane, self._rows, margin=0, sizing_mode="stretch_width"
        )

    def show(self, view: View) -> None:
        """Show the units of a `view` [-]."""
        self._silent = True
        while len(self._parts) > len(view.units):
            self._parts.pop()
        while len(self._parts) < len(view.units):
            self._parts.append(self._row(len(self._parts)))
        if len(self._rows) != len(self._parts):
            self._rows.objects = [part[3] for part in self._parts]
        for (count, radius, _, _), unit in zip(self._parts, view.units, strict=True):
            count.value = unit.count
            muscle = view.muscle_of(unit)
            radius.show(float(muscle.outer_radius), view.shown["length"])
        self._silent = False
        self.message.say("")
        self.press(view)

    def press(self, view: View) -> None:
        """Show the pressures of a `view` [-]."""
        for (_, _, dial, _), pressure in zip(self._parts, view.pressures, strict=True):
            dial.show(pressure, view.shown["pressure"], view.supply)

    def _row(self, i: int) -> tuple[Any, Field, Dial, Any]:
        count = pn.widgets.IntInput(
            label=f"Unit {i + 1}: muscles", value=1, width=118, margin=(2, 8),
            stylesheets=[widget_css(self._look)],  # its limits are told, here: the browser's aren't
        )  # fmt: skip
        count.param.watch(lambda event: self._counted(i, event.new), "value")
        radius = Field(
            self._look, "Radius", "outer_radius", "length", lambda value: self._resize(i, value)
        )
        dial = Dial(
            self._look,
            f"Pressure P{i + 1}",
            "pressure",
            "pressure",
            lambda value: self._press(i, value),
        )
        row = pn.Row(count, radius.panel, margin=0, sizing_mode="stretch_width")
        return count, radius, dial, pn.Column(row, dial.panel, margin=(0, 0, 6, 0))

    def _counted(self, i: int, count: int | None) -> None:
        if self._silent:
            return
        if count is None:
            self.message.say("`count` must be a whole number of muscles, got none.")
            return
        self._try(replace(self._session.view.units[i], count=count), i)

    def _resize(self, i: int, radius: float) -> None:
        view = self._session.view
        unit = view.units[i]
        base = view.muscle if unit.own is None else unit.own
        size = radius / float(base.outer_radius)
        if not SIZES[0] <= size <= SIZES[1]:
            unit = view.shown["length"]
            low, high = (shown(by * float(base.outer_radius), unit, "length") for by in SIZES)
            rule = f"must be {low} to {high}, a tenth to ten times the muscle's"
            raise InvalidInputError("radius", rule, radius, shown=shown(radius, unit, "length"))
        if unit.own is not None:
            from .state import scaled

            self._become(i, replace(unit, own=scaled(unit.own, size)))
        else:
            self._become(i, replace(unit, size=size))

    def _press(self, i: int, pressure: float) -> None:
        pressures = list(self._session.view.pressures)
        pressures[i] = pressure
        self._session.change(pressures=tuple(pressures))

    def _add(self) -> None:
        view = self._session.view
        if len(view.units) >= MOST_UNITS:
            self.message.say(f"`units` must be at most {MOST_UNITS} motor units.")
            return
        self._session.change(units=(*view.units, Unit()), pressures=(*view.pressures, 0.0))
        self.message.say("")

    def _remove(self) -> None:
        view = self._session.view
        if len(view.units) == 1:
            self.message.say("`units` must be at least 1 motor unit.")
            return
        self._session.change(units=view.units[:-1], pressures=view.pressures[:-1])
        self.message.say("")

    def _try(self, unit: Unit, i: int) -> None:
        try:
            self._become(i, unit)
            self.message.say("")
        except ValueError as error:
            self.message.say(str(error))

    def _become(self, i: int, unit: Unit) -> None:
        units = list(self._session.view.units)
        units[i] = unit
        check_units(tuple(units))
        self._session.change(units=tuple(units))

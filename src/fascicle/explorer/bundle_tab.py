"""Tab of a bundle: motor units, what they reach together, and pressures that reach a point."""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.events import Press, Tap
from bokeh.models import HoverTool
from bokeh.models.glyphs import Line, MultiLine, Patches, Scatter

from ..bundle.schemes import SCHEMES
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, check_interval
from ..plot.theme import BLACK, WHITE, Colors, mix
from .background import LatestResult
from .bundle_curves import (
    BundleState,
    DrawnSpace,
    Solution,
    bundle_solids,
    bundle_state,
    drawn_space,
    solutions,
)
from .solid import Scene
from .state import MOST_UNITS, SIZES, Session, Unit, View, changed, check_units, scaled
from .tab import Tab, equilibria_text, remarks_html
from .theme import (
    LAST,
    NARROW,
    PAIRS,
    SCROLLED,
    STACKED,
    TALL,
    Chart,
    equal_column,
    hover_tooltips,
)
from .widgets import (
    SWEEP_STEPS,
    Field,
    Message,
    QuantitySlider,
    Sweep,
    button,
    dropdown,
    format_quantity,
    heading,
    pane,
    readout_table,
    status_line,
    unit_factor,
    widget,
)


_STAGE = "clamp(240px, 100vh - 480px, 900px)"  # height of the bundle's figure


class UnitRows:
    """Inputs of each motor unit; units are added and removed at the end."""

    def __init__(self, session: Session):
        """**Arguments:** `session`: the visitor's."""
        self._session, self._updating = session, False
        self.rows: list[tuple[Any, Field, QuantitySlider]] = []
        self._buttons = [
            button("Add a unit", self._add, margin=(4, 4, 4, 8)),
            button("Remove the last", self._remove, margin=4),
        ]
        self.panel = pn.Column(
            *self._buttons, margin=0, sizing_mode="stretch_width", stylesheets=[PAIRS]
        )
        self.message = Message(self.panel, self._buttons[1])

    def show(self, view: View) -> None:
        """Show the units of a `view`."""
        self._updating = True
        if len(self.rows) != len(view.units):
            self.rows = self.rows[: len(view.units)]
            self.rows += [self._row(i) for i in range(len(self.rows), len(view.units))]
            widgets = [w for count, radius, dial in self.rows
                       for w in (count, radius.input, dial.panel)]  # fmt: skip
            self.panel.objects = [*self._buttons, *widgets]
        for (count, radius, _), unit in zip(self.rows, view.units, strict=True):
            count.value = unit.count
            radius.show(float(view.muscle_of(unit).outer_radius), view.shown["length"])
        self._updating = False
        self.message.show("")
        self.show_pressures(view)

    def show_pressures(self, view: View) -> None:
        """Show the pressures of a `view`."""
        for (_, _, slider), pressure in zip(self.rows, view.pressures, strict=True):
            slider.show(pressure, view.shown["pressure"], view.supply)

    def _row(self, i: int) -> tuple[Any, Field, QuantitySlider]:
        # without limits: at those the browser would refuse without a word
        count = widget(pn.widgets.IntInput, f"Unit {i + 1}: muscles", value=1)
        count.param.watch(lambda event: self._set_count(i, event.new), "value")
        radius = Field("Radius", "outer_radius", "length", lambda value: self._set_radius(i, value))
        radius.place(self.panel)
        slider = QuantitySlider(
            f"Pressure P{i + 1}", "pressure", "pressure", lambda value: self._set_pressure(i, value)
        )
        return count, radius, slider

    def _set_count(self, i: int, count: int | None) -> None:
        if self._updating:
            return
        try:
            if count is None:
                raise InvalidInputError("count", "must be a whole number", None)
            self._set_unit(i, replace(self._session.view.units[i], count=count))
            self.message.show("")
        except ValueError as error:
            self.message.show(error)

    def _set_radius(self, i: int, radius: float) -> None:
        view = self._session.view
        unit = view.units[i]
        base = view.muscle if unit.own is None else unit.own
        size = radius / float(base.outer_radius)
        if not SIZES[0] <= size <= SIZES[1]:
            shown = view.shown["length"]
            low, high, given = (
                format_quantity(x, shown, "length")
                for x in (*(by * float(base.outer_radius) for by in SIZES), radius)
            )
            rule = f"must be {low} to {high}, a tenth to ten times the muscle's"
            raise InvalidInputError("radius", rule, radius, shown=given)
        if unit.own is None:
            self._set_unit(i, replace(unit, size=size))
        else:
            self._set_unit(i, replace(unit, own=scaled(unit.own, size)))

    def _set_pressure(self, i: int, pressure: float) -> None:
        pressures = list(self._session.view.pressures)
        pressures[i] = pressure
        self._session.change(pressures=tuple(pressures))

    def _add(self) -> None:
        view = self._session.view
        if len(view.units) >= MOST_UNITS:
            self.message.show(f"A bundle has at most {MOST_UNITS} motor units here.")
            return
        self._session.change(units=(*view.units, Unit()), pressures=(*view.pressures, 0.0))

    def _remove(self) -> None:
        view = self._session.view
        if len(view.units) == 1:
            self.message.show("A bundle has at least 1 motor unit.")
            return
        self._session.change(units=view.units[:-1], pressures=view.pressures[:-1])

    def _set_unit(self, i: int, unit: Unit) -> None:
        units = list(self._session.view.units)
        units[i] = unit
        check_units(tuple(units))
        self._session.change(units=tuple(units))


class BundleView(Tab):
    """Widgets and figures of a bundle."""

    name: ClassVar[str] = "bundle"
    fields: ClassVar[tuple[str, ...]] = (
        "muscle", "units", "supply", "scheme", "resistance", "shown", "distance",
    )  # fmt: skip

    def __init__(self, session: Session, colors: Colors):
        """**Arguments:** those of `Tab`."""
        super().__init__(session, colors)
        self._updating, self._top, self._half_force = False, 0.3, 0.0
        self.units = UnitRows(session)
        self._scheme = dropdown("Recruitment", list(SCHEMES))
        self._scheme.param.watch(lambda event: self._set(scheme=event.new), "value")
        self._resistance = widget(
            pn.widgets.Checkbox, "Muscles past their free strain push back", margin=(6, 8)
        )
        self._resistance.param.watch(lambda event: self._set(resistance=event.new), "value")
        self._supply = Field("Supply pressure", "supply", "pressure", self._set_supply)
        self._strain = QuantitySlider(
            "Contraction ε", "strain", "strain", lambda value: session.change(strain=value)
        )
        self._add_chart()
        self._scene = Scene(colors, "bundle", _STAGE)
        self._sweep = Sweep("", self._step)
        self._numbers, self._status = pane(), pane(height=22)
        self._notes = pane(sizing_mode="stretch_width")
        self._space = LatestResult(self._show_space, self._fail)
        self._state = LatestResult(self._show_state, self._fail)
        self._solutions = LatestResult(self._show_solutions, self._fail)
        left = pn.Column(
            self._scheme, self._supply.input, self._resistance, self.units.panel,
            width=318, margin=(0, 8, 0, 0), stylesheets=[SCROLLED, LAST],
        )  # fmt: skip
        self._supply.place(left)
        space = pn.Column(
            pn.pane.Bokeh(self.chart.figure, margin=0, stylesheets=[TALL]), margin=0,
            **equal_column(),
        )  # fmt: skip
        self.message = Message(space)
        self._stage = pn.Column(
            pn.pane.Bokeh(self._scene.figure, margin=0, stylesheets=[TALL]),
            pn.Row(self._scene.slider, self._sweep.button, sizing_mode="stretch_width", margin=0),
            self._numbers, margin=0, **equal_column(),
        )  # fmt: skip
        self._fixed = len(self._stage)  # parts above the solutions
        main = pn.Column(
            self._notes, self._strain.panel, self._status,
            pn.Row(space, self._stage, sizing_mode="stretch_width", margin=0,
                   stylesheets=[STACKED]),
            sizing_mode="stretch_width", margin=0, stylesheets=[NARROW],
        )  # fmt: skip
        self.panel = pn.Row(
            left, main, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]
        )

    def draw(self, view: View) -> None:
        """Show a `view`."""
        self._updating = True
        self._scheme.value = str(view.scheme)
        self._resistance.value = view.resistance
        self._updating = False
        self._supply.show(view.supply, view.shown["pressure"])
        self.units.show(view)
        self._sweep.set_label(f"P{len(view.units)}")
        self._notes.object = remarks_html(view, "bundle")
        self._status.object = status_line("computing the space")
        self._space.request(lambda: drawn_space(view.bundle, view.resistance))

    def follow(self, before: View, after: View) -> None:
        """Follow the sliders of pressure and strain."""
        if changed(before, after, "pressures"):
            self.units.show_pressures(after)
        if changed(before, after, "strain"):
            self._strain.show(min(after.strain, self._top), "", self._top)
        if changed(before, after, "pressures", "strain"):
            self._request_state(after)

    def _set(self, **changes: Any) -> None:
        if not self._updating:
            self.session.change(**changes)

    def _set_supply(self, value: float) -> None:
        check_interval(value, 0.0, HIGHEST_PRESSURE, "supply", "Pa", "(gauge)", (False, True))
        view = self.session.view
        self.session.change(
            supply=value,
            pressures=tuple(min(P, value) for P in view.pressures),
            pressure=min(view.pressure, value),
        )

    def _fail(self, text: str) -> None:
        self._status.object = ""
        self.message.show(text, self.session.view.shown)

    def _step(self) -> bool:
        """Raise the last unit's pressure, or begin again at zero."""
        view = self.session.view
        if view.tab != self.name:
            return False
        following = float(f"{view.pressures[-1] + view.supply / SWEEP_STEPS:.6g}")
        last = 0.0 if following > view.supply else following
        self.session.change(pressures=(*view.pressures[:-1], last))
        return True

    # the figure

    def _add_chart(self) -> None:
        colors = self.colors
        chart = self.chart = Chart(colors, "Contraction ε [–]", "Force F [N]", room=290)
        self._regions = chart.source("xs", "ys", "color", "label", name="regions")
        self._levels = chart.source("xs", "ys", "color", "width")
        self._overlap = chart.source("xs", "ys", name="overlap")
        self._force = chart.source("strain", "force", name="bundle_force")
        self._unit_forces = chart.source("xs", "ys", "color")
        self._zeros = chart.source("x", "y", "fill", name="zeros")
        self._here = chart.source("x", "y")
        self._target = chart.source("x", "y", name="asked")
        chart.add_zero_line()
        chart.draw(self._regions, Patches(xs="xs", ys="ys", fill_color="color", fill_alpha=0.16,
                                          line_color="color", line_width=1.5),
                   "@label")  # fmt: skip
        chart.draw(self._levels, MultiLine(xs="xs", ys="ys", line_color="color",
                                           line_width="width", line_alpha=0.7))  # fmt: skip
        chart.draw(self._overlap, Patches(xs="xs", ys="ys", fill_alpha=0, line_alpha=0,
                                          hatch_pattern="right_diagonal_line",
                                          hatch_color=colors.ink, hatch_alpha=0.55, hatch_scale=9),
                   "overlap of states")  # fmt: skip
        chart.draw(self._unit_forces, MultiLine(xs="xs", ys="ys", line_color="color",
                                                line_width=1.6, line_dash="dashed"),
                   "each unit, now")  # fmt: skip
        line = Line(x="strain", y="force", line_color=colors.ink, line_width=3)
        force = chart.draw(self._force, line, "all units, now")
        chart.draw(self._zeros, Scatter(x="x", y="y", size=10, line_color=colors.ink,
                                        fill_color="fill", line_width=2),
                   "at rest (hollow: not stable)")  # fmt: skip
        chart.draw(self._here, Scatter(x="x", y="y", size=13, marker="diamond",
                                       fill_color=colors.curves[1], line_color=colors.paper),
                   "this contraction")  # fmt: skip
        chart.draw(self._target, Scatter(x="x", y="y", size=16, marker="cross",
                                         line_color=colors.curves[1], line_width=3),
                   "the chosen point")  # fmt: skip
        self._hover = HoverTool(renderers=[force], mode="vline", line_policy="interp",
                                tooltips=hover_tooltips("F", "N"))  # fmt: skip
        chart.figure.add_tools(self._hover)
        chart.figure.on_event(Tap, self._point_at)
        chart.figure.on_event(Press, self._point_at)  # a long click
        *_, self._target_entry = chart.add_legend(glyph_height=20)  # of points
        self._target_entry.visible = False

    def _show_space(self, drawn: DrawnSpace) -> None:
        view = self.session.view
        unit = view.shown["force"]
        scale, cycle = unit_factor(unit, "force"), self.colors.curves
        space = drawn.space
        self._top = max(0.1, float(np.ceil(drawn.top * 50) / 50))
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
            "width": [width for _, _, width in lines],
        }
        pairs = [drawn.overlap.outline(i) for i in range(len(drawn.overlap.states))]
        pairs = [(strain, force) for strain, force in pairs if strain.size]
        self._overlap.data = {
            "xs": [strain for strain, _ in pairs],
            "ys": [force / scale for _, force in pairs],
        }
        high = float(space.high.max()) / scale
        self._half_force = float(np.interp(0.5 * self._top, space.strain, space.high[-1])) / scale
        self.chart.set_ranges((0.0, self._top), (-0.12 * high, 1.06 * high))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = hover_tooltips("F", unit)
        self._target.data, self._target_entry.visible = {"x": [], "y": []}, False
        self._invite()
        self.message.show("")
        self._strain.show(min(view.strain, self._top), "", self._top)
        self._request_state(view)

    def _request_state(self, view: View) -> None:
        top = self._top
        strain = min(view.strain, top)

        def compute() -> tuple[Any, ...]:
            bundle, pressures = view.bundle, view.pressures
            force = float(bundle.force(np.array(pressures), strain, view.resistance))
            state = bundle_state(bundle, pressures, top, view.resistance)
            return view, state, force, bundle_solids(view, top)

        self._state.request(compute)

    def _show_state(self, result: tuple[View, BundleState, float, Any]) -> None:
        view, state, force, (solids, owners, places, reach) = result
        unit, cycle = view.shown["force"], self.colors.curves
        scale = unit_factor(unit, "force")
        self._status.object = ""
        colors = [cycle[i % len(cycle)] for i in range(len(state.units))]
        self._unit_forces.data = {
            "xs": [state.strain] * len(state.units),
            "ys": list(state.units / scale),
            "color": colors,
        }
        self._force.data = {"strain": state.strain, "force": state.force / scale}
        self._zeros.data = {
            "x": state.zeros, "y": np.zeros(state.zeros.size),
            "fill": [self.colors.ink if stable else self.colors.paper for stable in state.stable],
        }  # fmt: skip
        self._here.data = {"x": [min(view.strain, self._top)], "y": [force / scale]}
        pale = 0.35 if self.colors.dark else 0.62  # fibers contrast with it
        shades = [(mix(c, WHITE, pale), mix(c, BLACK, 0.35)) for c in colors]
        length = float(view.bundle.length)
        extent = max(0.58 * length, 1.1 * reach), 1.05 * reach + 0.12 * length
        self._scene.show(solids, [shades[i] for i in owners], places, extent)
        shown = view.shown["length"]
        rows = {
            "force": f"{force / scale:.4g} {unit}",
            "free strain": equilibria_text(state.zeros, state.stable),
            "envelope radius": f"{reach / unit_factor(shown, 'length'):.4g} {shown}",
        }
        title = heading("Pressures that reach a point")
        self._numbers.object = heading("At this point") + readout_table(rows) + title

    # pressures that reach a point

    def _show_below(self, parts: list[Any]) -> None:
        self._stage.objects = [*self._stage.objects[: self._fixed], *parts]

    def _invite(self) -> None:
        text = "Click in the space to get the pressures that reach that point."
        self._show_below([
            pn.pane.HTML(status_line(text), margin=(0, 8)),
            button("Try a point", self.try_point),
        ])  # fmt: skip

    def try_point(self) -> None:
        """Look for pressures that reach the middle of the space, for keyboards too."""
        self._find_pressures(0.5 * self._top, 0.3 * self._half_force)

    def _point_at(self, event: Any) -> None:
        if event.x is not None and 0 <= event.x <= self._top:
            self._find_pressures(float(event.x), float(event.y))

    def _find_pressures(self, x: float, y: float) -> None:
        """Look for pressures that reach the point `x` [-], `y` [shown unit]."""
        view = self.session.view
        unit = view.shown["force"]
        with pn.io.unlocked():
            self._target.data, self._target_entry.visible = {"x": [x], "y": [y]}, True
        self._show_below([pn.pane.HTML(status_line("looking for pressures"))])
        # with the digits of the pointer; the slider, the field and the link follow
        strain, force = round(x, 4), y * unit_factor(unit, "force")
        self.session.change(strain=strain)
        self._solutions.request(
            lambda: (strain, *solutions(view.bundle, force, strain, view.resistance, unit))
        )

    def _show_solutions(self, result: tuple[float, list[Solution], str]) -> None:
        strain, several, remark = result
        unit = self.session.view.shown["pressure"]
        scale = unit_factor(unit, "pressure")
        rows: list[Any] = [pn.pane.HTML(status_line(remark), margin=(0, 8))] if remark else []
        for solution in several:
            pressures = ", ".join(f"{P / scale:.4g}" for P in solution.pressures)
            stability = "" if solution.stable else ", not stable"
            rows.append(button(
                f"Set state {solution.state}: {pressures} {unit}{stability}",
                lambda solution=solution: self.session.change(
                    pressures=tuple(float(f"{P:.6g}") for P in solution.pressures), strain=strain
                ),
                sizing_mode="stretch_width",
            ))  # fmt: skip
        self._show_below(rows)

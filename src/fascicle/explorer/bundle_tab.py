"""Tab of a bundle: motor units, what they reach together, and pressures that reach a point."""

from dataclasses import replace
from functools import partial
from typing import ClassVar, NamedTuple

import numpy as np
import panel as pn

from .. import plot
from ..bundle import Bundle
from ..bundle.energetics import PATHS
from ..bundle.schemes import SCHEMES
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, check_finite, check_interval
from ..plot.curves import split_at_reversal
from ..plot.resistance_loss import efficiency_maps
from ..plot.theme import BLACK, WHITE, Colors, mix, to_bytes
from ..plot.workspace import efficiency, efficiency_loss
from ..results import tables
from .bundle_curves import (
    BundleSolids,
    BundleState,
    BundleWorkspace,
    FreeStrainCurve,
    Recruitment,
    bundle_solids,
    bundle_state,
    bundle_workspace,
    recruitments,
    second_unit_curve,
)
from .chart import Chart, cycle_colors, hover_tooltips, padded_range
from .remarks import equilibria_text, remarks_html, words_html
from .solid import Scene
from .state import MOST_UNITS, SIZES, Session, Unit, View, changed, check_units, scaled_muscle
from .tab import Export, LatestResult, Tab
from .widgets import (
    Field,
    Message,
    QuantitySlider,
    button,
    column,
    dropdown,
    format_quantity,
    heading,
    html_legend,
    html_table,
    pane,
    readout_table,
    row,
    side_column,
    status_line,
    text_html,
    volume_unit,
    widget,
)


# room for header, readouts and buttons
_SCENE_HEIGHT = "var(--scene-height, clamp(240px, min(100vh - 540px, 90vw), 900px))"
# both figures are on the screen: of the force, and of the free strain below it
_FORCE_HEIGHT = "var(--figure-height, clamp(300px, min(46vh, 100vw), 800px))"
_FREE_STRAIN_HEIGHT = "var(--figure-height, clamp(200px, 26vh, 400px))"
_NO_LOAD = "Enter a load, or click in the figure."
_EXPLANATION = (
    "Unit 1 is at P1, unit 2 is being filled, later units are vented. At first unit 2 may resist"
    " more than when it was empty: the bundle's free strain falls, and rises only past the reversal"
    " point (triangle)."
)
_NO_CURVE = "Raise P1: the curve is that of a bundle whose unit 1 is pressurized."
_NO_PATH = (
    "With free recruitment, many pressures of the motor units give one force and contraction, so"
    " that no path is isobaric: choose the path isotonic."
)


class UnitInputs(NamedTuple):
    """Inputs of a motor unit: count and radius of its muscles, and its pressure."""

    muscles: pn.widgets.IntInput
    radius: Field
    pressure: QuantitySlider


class UnitRows:
    """Inputs of all motor units; units are added and removed at the end."""

    def __init__(self, session: Session):
        self._session = session
        self.rows: list[UnitInputs] = []
        self._buttons = [
            button("Add a unit", self._add_unit, margin=(4, 4, 4, 8)),
            button("Remove the last", self._remove_last, margin=4),
        ]
        self.panel = column(kind="pairs")
        self.message = Message()

    def show(self, view: View) -> None:
        """Show the units of a `view`."""
        if len(self.rows) != len(view.units):
            self.rows = self.rows[: len(view.units)]
            self.rows += [self._make_row(i) for i in range(len(self.rows), len(view.units))]
            inputs = [
                w for r in self.rows for w in (r.muscles, *r.radius.widgets, r.pressure.panel)
            ]
            self.panel.objects = [*self._buttons, self.message.pane, *inputs]
        for inputs, unit in zip(self.rows, view.units, strict=True):
            inputs.muscles.value = unit.count
            inputs.radius.show(
                float(view.muscle_of(unit).outer_radius), view.display_units["length"]
            )
        self.message.show("")
        self.show_pressures(view)

    def show_pressures(self, view: View) -> None:
        """Show the pressures of a `view`."""
        for inputs, pressure in zip(self.rows, view.pressures, strict=True):
            inputs.pressure.show(pressure, view.display_units["pressure"], view.supply)

    def set_pressure(self, i: int, pressure: float) -> None:
        """Set the pressure [Pa] of unit `i`, counted from 0."""
        pressures = self._session.view.pressures
        self._session.change(pressures=(*pressures[:i], pressure, *pressures[i + 1 :]))

    def _make_row(self, i: int) -> UnitInputs:
        # without limits: at those the browser would refuse without a word
        count = widget(
            pn.widgets.IntInput, f"Unit {i + 1}: muscles", partial(self._set_count, i), value=1
        )
        radius = Field("Radius", "outer_radius", "length", partial(self._set_radius, i))
        pressure = QuantitySlider(
            f"Pressure P{i + 1}", "pressure", "pressure", partial(self.set_pressure, i)
        )
        return UnitInputs(count, radius, pressure)

    def _set_count(self, i: int, count: int | None) -> None:
        """Set the count of muscles of unit `i`, or show why it can't be."""
        with self.message.errors():
            if count is None:
                raise InvalidInputError("count", "must be a whole number", None)
            self._set_unit(i, replace(self._session.view.units[i], count=count))

    def _set_radius(self, i: int, radius: float) -> None:
        """Set the radius [m] of the muscles of unit `i`; `ValueError` beyond `SIZES`."""
        view = self._session.view
        unit = view.units[i]
        base = view.muscle if unit.own is None else unit.own
        size = radius / float(base.outer_radius)
        if not SIZES[0] <= size <= SIZES[1]:
            limits = [ratio * float(base.outer_radius) for ratio in SIZES]
            low, high, radius_text = (
                format_quantity(x, view.display_units["length"], "length")
                for x in (*limits, radius)
            )
            rule = f"must be {low} to {high}, a tenth to ten times the muscle's"
            raise InvalidInputError("outer_radius", rule, radius, shown=radius_text)
        if unit.own is None:
            self._set_unit(i, replace(unit, size=size))
        else:
            self._set_unit(i, replace(unit, own=scaled_muscle(unit.own, size)))

    def _set_unit(self, i: int, unit: Unit) -> None:
        units = self._session.view.units
        units = (*units[:i], unit, *units[i + 1 :])
        check_units(units)
        self._session.change(units=units)

    def _add_unit(self) -> None:
        view = self._session.view
        if len(view.units) >= MOST_UNITS:
            self.message.show(f"A bundle has at most {MOST_UNITS} motor units here.")
            return
        self._session.change(units=(*view.units, Unit()), pressures=(*view.pressures, 0.0))

    def _remove_last(self) -> None:
        view = self._session.view
        if len(view.units) == 1:
            self.message.show("A bundle has at least 1 motor unit.")
            return
        self._session.change(units=view.units[:-1], pressures=view.pressures[:-1])


class FreeStrainChart:
    """Chart of free strain over unit 2's pressure, as the layout `panel` of a `tab`; empty for a
    bundle of one unit. A hand moves the point, and with it unit 2's valve.
    """

    def __init__(self, tab: "BundleView", colors: Colors):
        self._tab = tab
        chart = self.chart = Chart(colors, "Pressure P2", "Free strain [–]", _FREE_STRAIN_HEIGHT)
        self._lines = {
            name: chart.add(f"free_strain_{name}") for name in ("resisted", "free", "jump")
        }
        self._turn = chart.add("turn")
        chart.add_labels(self._turn, x_offset=8, y_offset=-18, text_font_size="12px")
        self._point = chart.add("point", "free_strain_point")
        chart.on_hold(self._set_pressure)
        self._legend = pane()
        self._message = pane(margin=(2, 8), sizing_mode="stretch_width")
        self._figure = column(self._legend, chart.new_pane())
        title = pane(heading("Free strain over the pressure of unit 2"))
        self.panel = column(title, self._figure, self._message, kind="reversal")
        self._curves = LatestResult(self._show, tab.fail, tab.is_open)

    def draw(self, view: View) -> None:
        """Request the curve of a `view`."""
        self.panel.visible = len(view.units) > 1
        first = view.pressures[0]
        self._figure.visible = first > 0
        if not self.panel.visible or not first:
            self._message.object = status_line(_NO_CURVE)
            return
        self._curves.request(lambda: second_unit_curve(view.bundle, first))

    def show_point(self, view: View, free_strain: float) -> None:
        """Mark the `free_strain` [-] at the pressures of a `view`, where it is on the curve."""
        is_on_curve = len(view.units) > 1 and not any(view.pressures[2:])
        is_on_curve &= view.pressures[1:2] <= view.pressures[:1]
        scale = self._tab.unit("pressure")[1]
        point = {"x": [view.pressures[1] / scale], "y": [free_strain]} if is_on_curve else None
        self._point.data = point or {"x": [], "y": []}

    def _set_pressure(self, position: float, _: float) -> None:
        """Open unit 2's valve to a pressure [shown unit] on the curve."""
        first, scale = self._tab.session.view.pressures[0], self._tab.unit("pressure")[1]
        pressure = float(f"{np.clip(position * scale, 0.0, first):.4g}")
        self._tab.units.set_pressure(1, min(pressure, first))

    def _show(self, curve: FreeStrainCurve) -> None:
        unit, scale = self._tab.unit("pressure")
        colors, turn = self._tab.colors, curve.turn
        entries = [
            ("with resistance", colors.ink, "solid"),
            ("without", colors.soft, "dashed"),
            ("jump", colors.ink, "dotted"),
        ]
        drawn, jump = split_at_reversal(curve.pressure, curve.resisted, turn)
        self._legend.object = html_legend(entries[: 2 + bool(turn.jump)])
        for name, (pressure, strain), color in (
            ("resisted", drawn, colors.ink),
            ("free", (curve.pressure, curve.free), colors.soft),
            ("jump", jump, colors.ink),
        ):
            self._lines[name].data = {"xs": [pressure / scale], "ys": [strain], "color": [color]}
        falls = turn.depth > 0
        self._turn.data = {
            "x": [turn.pressure / scale] * falls,
            "y": [turn.free_strain] * falls,
            "label": [f"−{turn.depth:.4f}"] * falls,
        }
        highest = float(curve.pressure[-1]) / scale
        strains = np.concatenate([curve.resisted, curve.free])
        self.chart.set_ranges((0.0, highest), padded_range(strains, 0.18, 0.004))
        self.chart.figure.xaxis[0].axis_label = f"Pressure of unit 2 P2 [{unit}]"
        text = "It never falls."
        if falls:
            text = (
                f"It falls by {turn.depth:.4f} to {turn.free_strain:.4f}, at"
                f" {turn.pressure / scale:.4g} {unit}{', in a jump' * turn.jump}."
            )
        self._message.object = status_line(f"{_EXPLANATION} {text}")
        self.chart.describe(f"Free strain of the bundle over the pressure of unit 2. {text}")


class EfficiencyMaps:
    """Pictures of a bundle's efficiency over contraction and force, below a button that asks for
    them, as the layout `panel` of a `tab`.
    """

    def __init__(self, tab: "BundleView"):
        session = self._session = tab.session
        self._path = dropdown("Path", PATHS, lambda path: session.change(path=path), width=200)
        self._numbers, self._message = pane(), Message()
        self.pictures = [pn.pane.PNG(width=620, alt_text="") for _ in range(2)]
        self.toggle = widget(
            pn.widgets.Toggle,
            "More: efficiency",
            lambda _: self.draw(session.view),
            margin=(8, 8),
            sizing_mode=None,
        )
        self._maps = LatestResult(self._show, self._fail, tab.is_open)
        explanations = pane(words_html("efficiency", "isobaric", "isotonic", "resistance"))
        self._content = column(
            row(self._path, self._numbers, kind="wrapped", sizing_mode=None),
            self._message.pane,
            *self.pictures,
            explanations,
            visible=False,
        )
        self.panel = column(self.toggle, self._content)

    def draw(self, view: View) -> None:
        """Request the maps of a `view`, where they are shown."""
        self._content.visible, self._path.value = self.toggle.value, view.path
        if not self.toggle.value:
            return
        if SCHEMES[view.scheme].independent and view.path == "isobaric":
            self._fail(_NO_PATH)
            return
        self._content.loading = True
        self._maps.request(lambda: _efficiency_pictures(view.bundle, view.path))

    def _show(self, result: tuple[list[str], list[bytes]]) -> None:
        averages, pictures = result
        self._content.loading = False
        self._message.show("")
        rows = [("with resistance", averages[0]), ("without", averages[1])]
        self._numbers.object = html_table(("this bundle", "average efficiency"), rows)
        texts = "Efficiency with resistance and without", "Efficiency lost to resistance"
        for picture, raw, text in zip(self.pictures, pictures, texts, strict=True):
            picture.param.update(object=raw, alt_text=f"{text}, over contraction and force")

    def _fail(self, error: ValueError | str) -> None:
        """Show the error of a computation in place of the pictures."""
        self._maps.drop()
        self._content.loading, self._numbers.object = False, ""
        for picture in self.pictures:
            picture.object = None
        self._message.show(error)


def _efficiency_pictures(bundle: Bundle, path: str) -> tuple[list[str], list[bytes]]:
    """Average efficiencies with resistance and without, and the maps' pictures as PNG."""
    maps = efficiency_maps(bundle, path)
    averages = [f"{result.average:.4f}" for result in (maps.resisted, maps.free)]
    figures = (
        efficiency(maps.resisted, maps.free),
        efficiency_loss(maps.loss, maps.resistance_gaps),
    )
    return averages, [to_bytes(figure, "png") for figure in figures]


class BundleView(Tab):
    """Widgets and figures of a bundle."""

    name: ClassVar[str] = "bundle"
    fields: ClassVar[tuple[str, ...]] = (
        "muscle",
        "units",
        "supply",
        "scheme",
        "resistance",
        "display_units",
        "distance",
    )

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self._top, self._middle_force, self._highest = 0.3, 0.0, 0.0  # of the workspace
        self.units = UnitRows(session)
        self._scheme = dropdown(
            "Recruitment", list(SCHEMES), lambda scheme: session.change(scheme=scheme)
        )
        self._resistance = widget(
            pn.widgets.Checkbox,
            "Muscles push back past their free strain",
            lambda resistance: session.change(resistance=resistance),
            margin=(6, 8),
        )
        self._supply = Field("Supply pressure", "supply", "pressure", self._set_supply)
        self._strain = self.strain_slider()
        self._add_chart()
        self._scene = Scene(colors, "bundle", _SCENE_HEIGHT)
        self._numbers = pane()
        self._workspace, self._state, self._recruitments = (
            LatestResult(show, self.fail, self.is_open)
            for show in (self._show_workspace, self._show_state, self._show_recruitments)
        )
        self._load = Field("Load", "load", "force", self._set_load, optional=True)
        self._load_strain = Field("at contraction ε", "strain", "strain", self._set_load_strain)
        for field in (self._load, self._load_strain):
            field.message.pane.param.watch(self._hide_solutions, "visible")
        self._solution_column = column()
        explanations = pane(words_html("motor unit", "recruitment state", "overlap", "resistance"))
        inputs = (self._scheme, *self._supply.widgets, self._resistance, self.units.panel)
        left = side_column(*inputs, explanations, width=318)
        self.free_strain = FreeStrainChart(self, colors)
        self.efficiency = EfficiencyMaps(self)
        curves = (self.chart.new_pane(), self.message.pane, self.free_strain.panel)
        demand = column(*self._load.widgets, *self._load_strain.widgets, kind="pairs")
        asides = column(self._numbers, demand, self._solution_column, kind="aside")
        scene = column(*self._scene.panes(), asides, kind="equal picture")
        main = column(
            self.notes,
            row(self._strain.panel, kind="stacked pinned"),
            self.status,
            row(column(*curves, kind="equal"), scene),
            self.efficiency.panel,
        )
        self.panel = row(left, main)

    def draw(self, view: View) -> None:
        """Draw all that the tab shows of a `view`."""
        self._scheme.value = str(view.scheme)
        self._resistance.value = view.resistance
        self._supply.show(view.supply, view.display_units["pressure"])
        self.units.show(view)
        self.notes.object = remarks_html(view, "bundle")
        self.status.object = status_line("computing the workspace")
        self._workspace.request(lambda: bundle_workspace(view.bundle, view.resistance))
        self.free_strain.draw(view)
        self.efficiency.draw(view)

    def follow(self, before: View, after: View) -> None:
        """Update pressures and strain, the state there, and the pressures that carry the load."""
        if changed(before, after, "pressures"):
            self.units.show_pressures(after)
            if before.pressures[0] != after.pressures[0]:
                self.free_strain.draw(after)
        if changed(before, after, "path"):
            self.efficiency.draw(after)
        if changed(before, after, "strain"):
            self._strain.show(min(after.strain, self._top), "", self._top)
        if changed(before, after, "pressures", "strain"):
            self._request_state(after)
        if changed(before, after, "load", "strain", "path"):
            self._request_recruitments(after)

    def export(self) -> Export:
        """Picture and data of the workspace."""
        target, resistance = self.session.view.bundle, self.session.view.resistance
        variables = tables.space(target.workspace(resistance=resistance))
        return Export(
            self.stem("space"),
            variables,
            lambda: plot.bundle_force_strain(target, resistance=resistance),
        )

    def _set_supply(self, value: float) -> None:
        """Set the supply pressure [Pa] and lower others to it; `ValueError` if out of range."""
        check_interval(value, 0.0, HIGHEST_PRESSURE, "supply", "Pa", "(gauge)", (False, True))
        view = self.session.view
        self.session.change(
            supply=value,
            pressures=tuple(min(P, value) for P in view.pressures),
            pressure=min(view.pressure, value),
        )

    # the figure

    def _add_chart(self) -> None:
        """Add the chart of force over strain: workspace, units, bundle, equilibria, point."""
        colors = self.colors
        chart = self.chart = Chart(colors, "Contraction ε [–]", "Force F [N]", _FORCE_HEIGHT)
        chart.add_zero_line()
        self._regions = chart.add("states", "regions")
        self._levels = chart.add("levels")
        self._overlap = chart.add("overlap")
        self._unit_forces = chart.add("unit_forces")
        self._force = chart.add("bundle_force")
        self._hover = chart.add_force_hover()
        self._equilibria = chart.add("equilibria")
        self._point = chart.add("point", "bundle_point")
        self._target = chart.add("target")
        chart.on_hold(self._set_demand)
        chart.style_legend(glyph_height=20)  # of points

    def _show_workspace(self, result: BundleWorkspace) -> None:
        view, space = self.session.view, result.workspace
        unit, scale = self.unit("force")
        self._top = max(0.1, float(np.ceil(result.top * 50) / 50))
        states = range(1, len(space.force) + 1)
        colors = cycle_colors(self.colors, len(states))
        outlines = [space.outline(state) for state in states]
        self._regions.data = {
            "xs": [strain for strain, _ in outlines],
            "ys": [force / scale for _, force in outlines],
            "color": colors,
            "label": [f"recruitment state {state}" for state in states],
        }
        levels = [
            (force, color, 0.5 + 1.2 * k / len(curves))  # thicker with rising pressure
            for curves, color in zip(space.force, colors, strict=True)
            for k, force in enumerate(curves)
        ]
        self._levels.data = {
            "xs": [space.strain] * len(levels),
            "ys": [np.where(force >= 0, force / scale, np.nan) for force, _, _ in levels],
            "color": [color for _, color, _ in levels],
            "width": [width for _, _, width in levels],
        }
        outlines = [result.overlap.outline(i) for i in range(len(result.overlap.states))]
        outlines = [(strain, force) for strain, force in outlines if strain.size]
        self._overlap.data = {
            "xs": [strain for strain, _ in outlines],
            "ys": [force / scale for _, force in outlines],
        }
        self._highest = float(space.high.max())
        high = self._highest / scale
        middle = float(np.interp(0.5 * self._top, space.strain, space.high[-1]))
        self._middle_force = 0.3 * middle / scale
        self.chart.set_ranges((0.0, self._top), (-0.12 * high, 1.06 * high))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = hover_tooltips(unit)
        self.message.show("")
        self._strain.show(min(view.strain, self._top), "", self._top)
        self._request_state(view)
        self._request_recruitments(view)

    def _request_state(self, view: View) -> None:
        """Request force curves, equilibria and drawing at the pressures of a `view`."""
        top = self._top
        strain = min(view.strain, top)

        def compute() -> tuple[View, BundleState, float, BundleSolids]:
            bundle, pressures = view.bundle, view.pressures
            force = float(bundle.force(np.array(pressures), strain, view.resistance))
            state = bundle_state(bundle, pressures, top, view.resistance)
            return view, state, force, bundle_solids(view, top)

        self._state.request(compute)

    def _show_state(self, result: tuple[View, BundleState, float, BundleSolids]) -> None:
        """Show force curves, equilibria, drawing, and numbers at the view's point."""
        view, state, force, scene = result
        unit, scale = self.unit("force")
        self.status.object = ""
        colors = cycle_colors(self.colors, len(state.units))
        self._unit_forces.data = {
            "xs": [state.strain] * len(colors),
            "ys": list(state.units / scale),
            "color": colors,
        }
        self._force.data = {"strain": state.strain, "force": state.force / scale}
        fills = {True: self.colors.ink, False: self.colors.paper}
        self._equilibria.data = {
            "x": state.equilibria,
            "y": np.zeros(state.equilibria.size),
            "fill": [fills[bool(stable)] for stable in state.stable],
        }
        self._point.data = {"x": [min(view.strain, self._top)], "y": [force / scale]}
        self.free_strain.show_point(view, float(state.equilibria[0]))
        point = f"{force / scale:.4g} {unit} at a contraction of {min(view.strain, self._top):.4g}"
        self.chart.describe(
            f"Force over contraction that {len(self._regions.data['xs'])} recruitment states reach,"
            f" up to {self._highest / scale:.4g} {unit}; at these pressures {point}."
        )
        count = sum(unit.count for unit in view.units)
        self._scene.describe(f"Drawing of {count} muscles in {len(colors)} motor units: {point}.")
        pale = 0.35 if self.colors.dark else 0.62  # fibers contrast with it
        shades = [(mix(c, WHITE, pale), mix(c, BLACK, 0.35)) for c in colors]
        length, envelope = float(view.bundle.length), scene.envelope
        reach = max(0.58 * length, 1.1 * envelope), 1.05 * envelope + 0.12 * length
        owners = [shades[i] for i in scene.owners]
        self._scene.show(scene.solids, owners, self.colors.fitting, scene.positions, reach)
        length_unit, length_scale = self.unit("length")
        rows = {
            "force": f"{force / scale:.4g} {unit}",
            "free strain": equilibria_text(state.equilibria, state.stable),
            "envelope radius": f"{envelope / length_scale:.4g} {length_unit}",
        }
        title = heading("Pressures for a load")
        self._numbers.object = heading("At this point") + readout_table(rows) + title

    # pressures for a load

    def try_point(self) -> None:
        """Set a load inside the space, for keyboards too."""
        self._set_demand(0.5 * self._top, self._middle_force)

    def _set_demand(self, x: float, y: float) -> None:
        """Set the contraction `x` [-] and the load `y` [shown unit], with a pointer's digits."""
        _, scale = self.unit("force")
        strain = round(float(np.clip(x, 0.0, self._top)), 4)
        self.session.change(strain=strain, load=float(f"{y:.4g}") * scale)

    def _set_load_strain(self, value: float) -> None:
        """Set the contraction [-] of the load; `ValueError` beyond those that are drawn."""
        check_interval(value, 0.0, self._top, "strain", "-", closed=(True, True))
        self.session.change(strain=value)

    def _set_load(self, value: float | None) -> None:
        if value is not None:
            check_finite(value, "load", "N")
        self.session.change(load=value)

    def _request_recruitments(self, view: View) -> None:
        """Show the load of a `view`, and request the pressures for it, if there is one."""
        unit, scale = self.unit("force")
        strain, load = min(view.strain, self._top), view.load
        self._load.show(load, unit)
        self._load_strain.show(strain, "")
        if load is None:
            self._recruitments.drop()
            self._target.data = {"x": [], "y": []}
            example = button("Try a point", self.try_point)
            self._solution_column.objects = [pane(status_line(_NO_LOAD)), example]
            return
        self._target.data = {"x": [strain], "y": [load / scale]}
        self._recruitments.request(
            lambda: recruitments(view.bundle, load, strain, view.resistance, view.path)
        )

    def _hide_solutions(self, *_: object) -> None:
        """Hide the pressures of the last load while a field of the demand shows an error."""
        fields = self._load, self._load_strain
        self._solution_column.visible = not any(x.message.pane.visible for x in fields)

    def _show_recruitments(self, result: tuple[list[Recruitment], str]) -> None:
        """Show a table of all pressures that carry the load, and a button to set each of them."""
        several, remark = result
        (unit, _), (volume, _) = self.unit("pressure"), volume_unit(self.unit("length")[0])
        heads = ("state", f"pressures [{unit}]", "load", f"fluid [{volume}]", "η [–]")
        first, *others = map(self._recruitment_cells, several)
        if several[0].reached and others:
            first = [f"<b>{cell}</b>" for cell in first]
            first[2] = first[2].replace("reached", "reached, cheapest")
        path = "constant pressure" if self.session.view.path == "isobaric" else "constant load"
        note = f"Fluid is counted from rest length on, efficiency η at {path}. {remark}"
        table = html_table(heads, [first, *others]) + status_line(text_html(note))
        buttons = [
            button(self._set_label(recruitment), partial(self._set_recruitment, recruitment))
            for recruitment in several
            if recruitment.reached or recruitment is several[0]
        ]
        scroll = pane(f'<div class="scroll">{table}</div>')
        self._solution_column.objects = [scroll, row(*buttons, kind="wrapped")]

    def _set_recruitment(self, recruitment: Recruitment) -> None:
        pressures = tuple(float(f"{P:.6g}") for P in recruitment.pressures)
        self.session.change(pressures=pressures)

    @staticmethod
    def _set_label(recruitment: Recruitment) -> str:
        """Label of the button that sets a recruitment's pressures."""
        label = f"Set state {recruitment.state}"
        if not recruitment.reached:
            return f"{label}, the nearest"
        return label if recruitment.stable else f"{label}, unstable"

    def _recruitment_cells(self, recruitment: Recruitment) -> list[str]:
        """Cells of a row of the table: state, pressures, status, fluid and efficiency."""
        (_, scale), (unit, force_scale) = self.unit("pressure"), self.unit("force")
        _, volume_scale = volume_unit(self.unit("length")[0])
        force, load = recruitment.force, self.session.view.load or 0.0
        status = "reached" if recruitment.stable else "reached, unstable"
        if not recruitment.reached:
            limit = "at most" if force < load else "at least"
            status = f"{limit} {force / force_scale:.4g} {unit}"
        fluid, efficiency = recruitment.fluid / volume_scale, recruitment.efficiency
        return [
            f"{recruitment.state}",
            ", ".join(f"{P / scale:.4g}" for P in recruitment.pressures),
            status,
            "–" if np.isnan(fluid) else f"{fluid:.4g}",
            "–" if np.isnan(efficiency) else f"{efficiency:.3f}",
        ]

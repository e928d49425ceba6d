"""Tab of a bundle: motor units, what they reach together, and pressures that reach a point."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np
import panel as pn

from .. import plot
from ..bundle import Bundle
from ..bundle.energetics import PATHS
from ..bundle.inverse import ABOVE
from ..bundle.schemes import SCHEMES
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE
from ..plot.curves import split_at_reversal
from ..plot.resistance_loss import efficiency_maps
from ..plot.theme import BLACK, WHITE, Colors, mix, to_bytes
from ..plot.workspace import efficiency, efficiency_loss
from ..results import tables
from . import bundle_curves
from . import widgets as ui
from .bundle_curves import BundleState, BundleWorkspace, FreeStrainCurve, Recruitment
from .chart import Chart, hover_tooltips, padded_range, unit_colors
from .remarks import equilibria_text, remarks_html, words_html
from .solid import Scene
from .state import Session, Unit, View, changed, check_units, check_value
from .tab import Export, LatestResult, StrainTab
from .texts import TEXTS


_TEXTS = TEXTS["bundle"]
_FIELDS = ("muscle", "units", "supply", "scheme", "resistance", "display_units", "distance")
# room for header, readouts and buttons
_SCENE_HEIGHT = "var(--scene-height, clamp(240px, min(100vh - 540px, 90vw), 900px))"
# both figures are on the screen: of the force, and of the free strain below it
_FORCE_HEIGHT = "var(--figure-height, clamp(300px, min(46vh, 100vw), 800px))"
_FREE_STRAIN_HEIGHT = "var(--figure-height, clamp(200px, 26vh, 400px))"


class UnitRows:
    """Inputs of all motor units; units are added and removed at the end."""

    def __init__(self, session: Session):
        self._session = session
        self.rows: list[tuple[ui.Field, ui.QuantitySlider]] = []  # count of muscles, pressure
        self._buttons = [
            ui.button("Add a unit", partial(self._set_number, 1), margin=(4, 4, 4, 8)),
            ui.button("Remove the last", partial(self._set_number, -1), margin=4),
        ]
        self.panel, self.message = ui.column(kind="pairs"), ui.Message()

    def show(self, view: View) -> None:
        if len(self.rows) != len(view.units):
            self.rows = self.rows[: len(view.units)]
            self.rows += [self._make_row(i) for i in range(len(self.rows), len(view.units))]
            parts = [(*count.widgets, pressure.panel) for count, pressure in self.rows]
            self.panel.objects = [*self._buttons, self.message.pane, *sum(parts, ())]
        for (count, _), unit in zip(self.rows, view.units, strict=True):
            count.show(unit.count, "")
        self.message.show("")
        self.show_pressures(view)

    def show_pressures(self, view: View) -> None:
        for (_, slider), pressure in zip(self.rows, view.pressures, strict=True):
            slider.show(pressure, view.display_units["pressure"], view.supply)

    def set_pressure(self, i: int, pressure: float) -> None:
        """Set the pressure [Pa] of unit `i`, counted from 0."""
        pressures = self._session.view.pressures
        self._session.change(pressures=(*pressures[:i], pressure, *pressures[i + 1 :]))

    def _make_row(self, i: int) -> tuple[ui.Field, ui.QuantitySlider]:
        count = ui.Field(f"Unit {i + 1}: muscles", "count", "number", partial(self._set_count, i))
        label, set_pressure = f"Pressure P{i + 1}", partial(self.set_pressure, i)
        return count, ui.QuantitySlider(label, "pressure", "pressure", set_pressure)

    def _set_count(self, i: int, count: float) -> None:
        if not count.is_integer():
            raise InvalidInputError("count", "must be a whole number", count)
        units = self._session.view.units
        units = (*units[:i], replace(units[i], count=int(count)), *units[i + 1 :])
        check_units(units)
        self._session.change(units=units)

    def _set_number(self, change: int) -> None:
        view, number = self._session.view, len(self._session.view.units) + change
        units, pressures = (*view.units, Unit())[:number], (*view.pressures, 0.0)[:number]
        with self.message.errors():
            check_units(units)
            self._session.change(units=units, pressures=pressures)


class FreeStrainChart:
    """Chart of free strain over unit 2's pressure, as the layout `panel` of a `tab`; empty for a
    bundle of one unit. A hand moves the point, and with it unit 2's valve.
    """

    def __init__(self, tab: "BundleView", colors: Colors):
        self._tab = tab
        chart = self.chart = Chart(colors, "Pressure P2", "Free strain [–]", _FREE_STRAIN_HEIGHT)
        self._lines = [chart.add(f"free_strain_{name}") for name in ("resisted", "free", "jump")]
        self._turn = chart.add("turn")
        chart.add_labels(self._turn, x_offset=8, y_offset=-18, text_font_size="12px")
        self._point = chart.add("point", "free_strain_point")
        chart.on_hold(self._set_pressure)
        self._legend, self._message = ui.pane(), ui.wide_pane(margin=(2, 8))
        self._figure = ui.column(self._legend, chart.new_pane())
        title = ui.pane(ui.heading("Free strain over the pressure of unit 2"))
        self.panel = ui.column(title, self._figure, self._message, kind="reversal")
        self._curves = LatestResult(self._show, tab.fail, tab.is_open)

    def draw(self, view: View) -> None:
        first = view.pressures[0]
        self.panel.visible, self._figure.visible = len(view.units) > 1, first > 0
        if self.panel.visible and first:
            self._curves.request(lambda: bundle_curves.second_unit_curve(view.bundle, first))
        else:
            self._message.object = ui.status_line(_TEXTS["no_curve"])

    def show_point(self, view: View, free_strain: float) -> None:
        """Mark the `free_strain` [-] at the pressures of a `view`, where it is on the curve."""
        is_on_curve = len(view.units) > 1 and not any(view.pressures[2:])
        is_on_curve &= view.pressures[1:2] <= view.pressures[:1]
        pressure = [P / self._tab.unit("pressure")[1] for P in view.pressures[1:2]]
        self._point.data = {"x": pressure * is_on_curve, "y": [free_strain] * is_on_curve}

    def _set_pressure(self, position: float, _: float) -> None:
        """Set unit 2's pressure to a `position` on the curve [shown unit], at most unit 1's."""
        first, scale = self._tab.session.view.pressures[0], self._tab.unit("pressure")[1]
        pressure = float(f"{np.clip(position * scale, 0.0, first):.4g}")
        self._tab.units.set_pressure(1, min(pressure, first))

    def _show(self, curve: FreeStrainCurve) -> None:
        unit, scale = self._tab.unit("pressure")
        ink, soft, turn = self._tab.colors.ink, self._tab.colors.soft, curve.turn
        drawn, jump = split_at_reversal(curve.pressure, curve.resisted, turn)
        entries = [("with resistance", ink, "solid"), ("without", soft, "dashed")]
        self._legend.object = ui.html_legend(entries + [("jump", ink, "dotted")] * bool(turn.jump))
        lines = (*drawn, ink), (curve.pressure, curve.free, soft), (*jump, ink)
        for source, (pressure, strain, color) in zip(self._lines, lines, strict=True):
            source.data = {"xs": [pressure / scale], "ys": [strain], "color": [color]}
        pressure, text = turn.pressure / scale, _TEXTS["no_reversal"]
        self._turn.data = {"x": [], "y": [], "label": []}
        if turn.depth > 0:
            label = f"−{turn.depth:.4f}"
            self._turn.data = {"x": [pressure], "y": [turn.free_strain], "label": [label]}
            text = (
                f"{_TEXTS['reversal']} It falls by {turn.depth:.4f} to {turn.free_strain:.4f}, at"
                f" {pressure:.4g} {unit}{', in a jump' * turn.jump}."
            )
        strains = np.concatenate([curve.resisted, curve.free])
        highest = float(curve.pressure[-1]) / scale
        self.chart.set_ranges((0.0, highest), padded_range(strains, 0.18, 0.004))
        self.chart.figure.xaxis[0].axis_label = f"Pressure of unit 2 P2 [{unit}]"
        self._message.object = ui.status_line(text)
        self.chart.describe(f"Free strain of the bundle over the pressure of unit 2. {text}")


class EfficiencyMaps:
    """Pictures of a bundle's efficiency over contraction and force, below a button that asks for
    them, as the layout `panel` of a `tab`.
    """

    def __init__(self, tab: "BundleView"):
        session = tab.session
        self._path = ui.dropdown("Path", PATHS, lambda path: session.change(path=path), width=200)
        self._numbers, self._message = ui.pane(), ui.Message()
        self.pictures = [pn.pane.PNG(width=620, alt_text="") for _ in range(2)]
        words = ui.pane(words_html("efficiency", "isobaric", "isotonic", "resistance"))
        head = ui.row(self._path, self._numbers, kind="wrapped", sizing_mode=None)
        parts = head, self._message.pane, *self.pictures, words
        self.panel = ui.fold("More: efficiency", *parts)
        self.toggle, self._content = self.panel
        self.toggle.param.watch(lambda _: self.draw(session.view), "value")
        self._maps = LatestResult(self._show, self._fail, tab.is_open)

    def draw(self, view: View) -> None:
        self._path.value = view.path
        if not self.toggle.value:
            return
        if SCHEMES[view.scheme].independent and view.path == "isobaric":
            self._fail(_TEXTS["no_path"])
            return
        self._content.loading = True
        self._maps.request(lambda: _efficiency_pictures(view.bundle, view.path))

    def _show(self, result: tuple[list[str], list[bytes]]) -> None:
        averages, pictures = result
        self._content.loading = False
        self._message.show("")
        rows = [*zip(("with resistance", "without"), averages, strict=True)]
        self._numbers.object = ui.html_table(("this bundle", "average efficiency"), rows)
        texts = "Efficiency with resistance and without", "Efficiency lost to resistance"
        for picture, raw, text in zip(self.pictures, pictures, texts, strict=True):
            picture.param.update(object=raw, alt_text=f"{text}, over contraction and force")

    def _fail(self, error: ValueError | str) -> None:
        self._maps.drop()
        self._content.loading, self._numbers.object = False, ""
        for picture in self.pictures:
            picture.object = None
        self._message.show(error)


def _efficiency_pictures(bundle: Bundle, path: str) -> tuple[list[str], list[bytes]]:
    """Average efficiencies with resistance and without, and the maps' pictures as PNG."""
    maps = efficiency_maps(bundle, path)
    averages = [f"{result.average:.4f}" for result in (maps.resisted, maps.free)]
    losses = efficiency_loss(maps.loss, maps.resistance_gaps)
    figures = efficiency(maps.resisted, maps.free), losses
    return averages, [to_bytes(figure, "png") for figure in figures]


class BundleView(StrainTab):
    """Widgets and figures of a bundle."""

    name: ClassVar[str] = "bundle"
    fields: ClassVar[tuple[str, ...]] = _FIELDS

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self._middle_force, self._highest = 0.0, 0.0  # of the workspace
        self.units = UnitRows(session)
        change = session.change
        self._scheme = ui.dropdown("Recruitment", SCHEMES, lambda name: change(scheme=name))
        label, margin = "Muscles push back past their free strain", (6, 8)
        self._resistance = ui.widget(
            pn.widgets.Checkbox, label, lambda on: change(resistance=on), margin=margin
        )
        self._supply = ui.Field("Supply pressure", "supply", "pressure", self._set_supply)
        self._add_chart()
        self._scene = Scene(colors, "bundle", _SCENE_HEIGHT)
        self._numbers = ui.pane()
        self._workspace, self._state, self._recruitments = (
            LatestResult(show, self.fail, self.is_open)
            for show in (self._show_workspace, self._show_state, self._show_recruitments)
        )
        self._load = ui.Field("Load", "load", "force", self._set_load, optional=True)
        self._load_strain = ui.Field("at contraction ε", "strain", "strain", self._set_load_strain)
        for field in (self._load, self._load_strain):
            field.message.pane.param.watch(self._hide_solutions, "visible")
        self._solutions = ui.column()
        words = ui.pane(words_html("motor unit", "recruitment state", "overlap", "resistance"))
        inputs = (self._scheme, *self._supply.widgets, self._resistance, self.units.panel)
        self.free_strain = FreeStrainChart(self, colors)
        self.efficiency = EfficiencyMaps(self)
        curves = (self.chart.new_pane(), self.message.pane, self.free_strain.panel)
        demand = ui.column(*self._load.widgets, *self._load_strain.widgets, kind="pairs")
        asides = ui.column(self._numbers, demand, self._solutions, kind="aside")
        scene = ui.column(*self._scene.panes(), asides, kind="equal picture")
        slider = ui.row(self.strain.panel, kind="stacked pinned")
        figures = ui.row(ui.column(*curves, kind="equal"), scene)
        main = ui.column(self.notes, slider, self.status, figures, self.efficiency.panel)
        self.panel = ui.row(ui.side_column(*inputs, words, width=318), main)

    def draw(self, view: View) -> None:
        self._scheme.value, self._resistance.value = str(view.scheme), view.resistance
        self._supply.show(view.supply, view.display_units["pressure"])
        self.units.show(view)
        self.notes.object = remarks_html(view, "bundle")
        self.status.object = ui.status_line("computing the workspace")
        bundle, resistance = view.bundle, view.resistance
        self._workspace.request(lambda: bundle_curves.bundle_workspace(bundle, resistance))
        self.free_strain.draw(view)
        self.efficiency.draw(view)

    def follow(self, before: View, after: View) -> None:
        if changed(before, after, "pressures"):
            self.units.show_pressures(after)
            if before.pressures[0] != after.pressures[0]:
                self.free_strain.draw(after)
        if changed(before, after, "path"):
            self.efficiency.draw(after)
        if changed(before, after, "strain"):
            self.show_strain(after)
        if changed(before, after, "pressures", "strain"):
            self._request_state(after)
        if changed(before, after, "load", "strain", "path"):
            self._request_recruitments(after)

    def export(self) -> Export:
        bundle, resistance = self.session.view.bundle, self.session.view.resistance
        variables = tables.space(bundle.workspace(resistance=resistance))
        figure = partial(plot.bundle_force_strain, bundle, resistance=resistance)
        return Export(self.stem("space"), variables, figure)

    def _set_supply(self, value: float) -> None:
        """Set the supply pressure [Pa], and lower others to it."""
        ui.check_limit(value, HIGHEST_PRESSURE, "supply", "pressure", self.unit("pressure")[0])
        check_value("supply", value)
        view = self.session.view
        pressures = tuple(min(P, value) for P in view.pressures)
        pressure = min(view.pressure, value)
        self.session.change(supply=value, pressures=pressures, pressure=pressure)

    def _add_chart(self) -> None:
        chart = self.chart = Chart(self.colors, "Contraction ε [–]", "Force F [N]", _FORCE_HEIGHT)
        chart.add_zero_line()
        self._regions = chart.add("states", "regions")
        self._overlap = chart.add("overlap")
        self._unit_forces, self._force = chart.add("unit_forces"), chart.add("bundle_force")
        self._hover = chart.add_force_hover()
        self._equilibria = chart.add("equilibria")
        self._point, self._target = chart.add("point", "bundle_point"), chart.add("target")
        chart.on_hold(self._set_demand)
        chart.style_legend(glyph_height=20)  # of points

    def _show_workspace(self, result: BundleWorkspace) -> None:
        view, space, overlap = self.session.view, result.workspace, result.overlap
        unit, scale = self.unit("force")
        self.top = max(0.1, float(np.ceil(result.top * 50) / 50))
        outlines, number = map(space.outline, range(1, len(space.force) + 1)), len(space.force)
        labels = [f"recruitment state {i + 1}" for i in range(number)]
        style = {"color": unit_colors(self.colors, number), "label": labels}
        self._regions.data = _outline_columns(outlines, scale) | style
        outlines = (overlap.outline(i) for i in range(len(overlap.states)))
        self._overlap.data = _outline_columns(outlines, scale)
        self._highest = float(space.high.max())
        high = self._highest / scale
        middle = float(np.interp(0.5 * self.top, space.strain, space.high[-1]))
        self._middle_force = 0.3 * middle / scale
        self.chart.set_ranges((0.0, self.top), (-0.12 * high, 1.06 * high))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = hover_tooltips(unit)
        self.message.show("")
        self.show_strain(view)
        self._request_state(view)
        self._request_recruitments(view)

    def _request_state(self, view: View) -> None:
        top = self.top
        self._state.request(lambda: (view, bundle_curves.bundle_state(view, top)))

    def _show_state(self, result: tuple[View, BundleState]) -> None:
        view, state = result
        unit, scale = self.unit("force")
        self.status.object = ""
        colors = unit_colors(self.colors, len(state.units))
        xs, ys = [state.strain] * len(colors), list(state.units / scale)
        self._unit_forces.data = {"xs": xs, "ys": ys, "color": colors}
        self._force.data = {"strain": state.strain, "force": state.force / scale}
        fills = [self.colors.ink if stable else self.colors.paper for stable in state.stable]
        zeros = np.zeros(state.equilibria.size)
        self._equilibria.data = {"x": state.equilibria, "y": zeros, "fill": fills}
        strain, force = min(view.strain, self.top), state.point_force / scale
        self._point.data = {"x": [strain], "y": [force]}
        self.free_strain.show_point(view, float(state.equilibria[0]))
        point = f"{force:.4g} {unit} at a contraction of {strain:.4g}"
        self.chart.describe(
            f"Force over contraction that {len(self._regions.data['xs'])} recruitment states reach,"
            f" up to {self._highest / scale:.4g} {unit}; at these pressures {point}."
        )
        count = sum(unit.count for unit in view.units)
        self._scene.describe(f"Drawing of {count} muscles in {len(colors)} motor units: {point}.")
        pale = 0.35 if self.colors.dark else 0.62  # fibers contrast with it
        shades = [(mix(c, WHITE, pale), mix(c, BLACK, 0.35)) for c in colors]
        length, scene, envelope = float(view.bundle.length), state.scene, state.scene.envelope
        reach = max(0.58 * length, 1.1 * envelope), 1.05 * envelope + 0.12 * length
        shades = [shades[i] for i in scene.owners]
        self._scene.show(scene.solids, shades, self.colors.fitting, scene.positions, reach)
        length_unit, length_scale = self.unit("length")
        rows = {
            "force": f"{force:.4g} {unit}",
            "free strain": equilibria_text(state.equilibria, state.stable),
            "envelope radius": f"{envelope / length_scale:.4g} {length_unit}",
        }
        title = ui.heading("Pressures for a load")
        self._numbers.object = ui.heading("At this point") + ui.readout_table(rows) + title

    def _set_demand(self, x: float, y: float) -> None:
        """Set the contraction `x` [-] and the load `y` [shown unit], with a pointer's digits."""
        load = float(f"{y:.4g}") * self.unit("force")[1]
        self.session.change(strain=round(float(np.clip(x, 0.0, self.top)), 4), load=load)

    def _set_load_strain(self, value: float) -> None:
        ui.check_limit(value, self.top, "strain", "strain", "")
        self.session.change(strain=value)

    def _set_load(self, value: float | None) -> None:
        self.session.change(load=None if value is None else check_value("load", value))

    def _request_recruitments(self, view: View) -> None:
        """Show the load of a `view`, and request the pressures for it, if there is one."""
        unit, scale = self.unit("force")
        strain, load = min(view.strain, self.top), view.load
        self._load.show(load, unit)
        self._load_strain.show(strain, "")
        if load is None:
            self._recruitments.drop()
            self._target.data = {"x": [], "y": []}
            middle = 0.5 * self.top, self._middle_force  # for keyboards, too
            example = ui.button("Try a point", lambda: self._set_demand(*middle))
            self._solutions.objects = [ui.pane(ui.status_line(_TEXTS["no_load"])), example]
            return
        self._target.data = {"x": [strain], "y": [load / scale]}
        self._recruitments.request(
            lambda: bundle_curves.recruitments(
                view.bundle, load, strain, view.resistance, view.path
            )
        )

    def _hide_solutions(self, *_: object) -> None:
        """Hide the pressures of the last load while a field of the demand shows an error."""
        fields = self._load, self._load_strain
        self._solutions.visible = not any(field.message.pane.visible for field in fields)

    def _show_recruitments(self, result: tuple[int, list[Recruitment]]) -> None:
        status, recruitments = result
        (unit, scale), (force_unit, force) = self.unit("pressure"), self.unit("force")
        volume, volume_scale = ui.volume_unit(self.unit("length")[0])
        heads = ("state", f"pressures [{unit}]", "load", f"fluid [{volume}]", "η [–]")
        limit = f"at {'most' if status == ABOVE else 'least'} {recruitments[0].force / force:.4g}"
        rows, buttons = [], []
        for row in recruitments:
            how = (
                f"{limit} {force_unit}"
                if status
                else f"reached{'' if row.stable else ', unstable'}"
            )
            pressures = ", ".join(f"{P / scale:.4g}" for P in row.pressures)
            numbers = f"{row.fluid / volume_scale:.4g}", f"{row.efficiency:.3f}"
            cells = (f"{row.state}", pressures, how, *numbers)
            rows.append(["–" if cell == "nan" else cell for cell in cells])
            rounded = tuple(float(f"{P:.6g}") for P in row.pressures)
            label = f"Set state {row.state}" + ("" if row.stable or status else ", unstable")
            change = partial(self.session.change, pressures=rounded)
            buttons.append(ui.button(label + ", the nearest" * bool(status), change))
        if len(rows) > 1:
            rows[0][2] = rows[0][2].replace("reached", "reached, cheapest")
            rows[0] = [f"<b>{cell}</b>" for cell in rows[0]]
        path = "constant pressure" if self.session.view.path == "isobaric" else "constant load"
        note = f"Fluid is counted from rest length on, efficiency η at {path}."
        note += _TEXTS["compliant"] * any(np.isnan(row.fluid) for row in recruitments)
        table = ui.pane(
            f'<div class="scroll">{ui.html_table(heads, rows)}{ui.status_line(note)}</div>'
        )
        self._solutions.objects = [table, ui.row(*buttons, kind="wrapped")]


def _outline_columns(
    outlines: Iterable[tuple[np.ndarray, np.ndarray]], scale: float
) -> dict[str, list]:
    """Columns of the `outlines` that have points; forces over a `scale`."""
    pairs = [(strain, force / scale) for strain, force in outlines if strain.size]
    return {"xs": [strain for strain, _ in pairs], "ys": [force for _, force in pairs]}

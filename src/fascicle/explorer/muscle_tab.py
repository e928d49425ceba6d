"""Tab of one muscle: its force over strain with its parts, other laws, and the muscle itself."""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.events import Press, Tap
from bokeh.models import HoverTool
from bokeh.models.glyphs import Line, MultiLine, Quad, Scatter, Text

from ..plot.theme import Colors
from ..units import pretty
from .background import LatestResult
from .muscle_curves import (
    PARTS,
    REGIONS,
    MuscleCurves,
    alternative_laws,
    check_compared,
    curve_marks,
    muscle_curves,
    region_strips,
    strain_limit,
    with_alternative,
)
from .muscle_inputs import MuscleInputs
from .solid import Scene, muscle_solid
from .state import Session, View, changed
from .tab import Tab, branches_text, remarks_html, tuning_note
from .theme import (
    LAST,
    NARROW,
    SCROLLED,
    STACKED,
    TALL,
    WHOLE_ROW,
    Chart,
    equal_column,
    hover_tooltips,
    pressure_colors,
)
from .widgets import (
    SWEEP_STEPS,
    Message,
    QuantitySlider,
    Sweep,
    heading,
    moment_text,
    pane,
    readout_table,
    status_line,
    unit_factor,
    volume_text,
    widget,
)


_STAGE = "clamp(220px, 100vh - 500px, 900px)"  # height of the muscle's figure
_STRAIGHT = (0, 3)  # regions in which a muscle is straight
_LETTER = 0.0245  # width of a letter of a region's name, of the strains drawn
_FAR = 1e9  # [shown unit] beyond every picture
# of `curves` for other laws: none is the force's or a part's, nor are the long dashes
_COMPARED_COLORS = (3, 4, 5, 7)
_COMPARED_DASHES = ("14 4", "14 4 3 4", "14 4 3 4 3 4", "5 3 1 3")
_PART_DASHES = {"mesh": "dashed", "bladder": "dotdash", "bending": "dotted"}


class MuscleView(Tab):
    """Widgets and figures of one muscle."""

    name: ClassVar[str] = "muscle"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "units", "supply", "shown")

    def __init__(self, session: Session, colors: Colors):
        """**Arguments:** those of `Tab`."""
        super().__init__(session, colors)
        self.top, self._label_height, self._updating = 0.3, 0.0, False
        self.inputs = MuscleInputs(session)
        self._pressure = QuantitySlider(
            "Pressure P", "pressure", "pressure", lambda value: session.change(pressure=value)
        )
        self._strain = QuantitySlider(
            "Contraction ε", "strain", "strain", lambda value: session.change(strain=value)
        )
        self._add_chart()
        self._scene = Scene(colors, "solid", _STAGE)
        self._numbers = pane(sizing_mode="stretch_width")
        self.notes = pane((2, 8), sizing_mode="stretch_width")
        self._sweep = Sweep("the strain", self._step)
        self.compare = widget(
            pn.widgets.MultiSelect, "Compare with (Ctrl for several)", size=4, styles=WHOLE_ROW
        )
        self.compare.param.watch(self._choose_compared, "value")
        self._others = LatestResult(self._show_others, self.inputs.refuse)
        left = pn.Column(
            self.inputs.panel, self.compare, width=284, margin=(0, 8, 0, 0),
            stylesheets=[SCROLLED, LAST],
        )  # fmt: skip
        self.message = Message(left)
        sliders = pn.Row(
            self._pressure.panel, self._strain.panel, sizing_mode="stretch_width", margin=0,
            stylesheets=[STACKED],
        )  # fmt: skip
        stage = pn.Column(
            pn.pane.Bokeh(self._scene.figure, margin=0, stylesheets=[TALL]),
            pn.Row(self._scene.slider, self._sweep.button, sizing_mode="stretch_width", margin=0),
            self._numbers, margin=0, **equal_column(),
        )  # fmt: skip
        curves = pn.Column(
            pn.pane.Bokeh(self.chart.figure, margin=0, stylesheets=[TALL]), margin=0,
            **equal_column(),
        )  # fmt: skip
        main = pn.Column(
            self.notes, sliders,
            pn.Row(curves, stage, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]),
            sizing_mode="stretch_width", margin=0, stylesheets=[NARROW],
        )  # fmt: skip
        self.panel = pn.Row(
            left, main, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]
        )

    def draw(self, view: View) -> None:
        """Show a `view`."""
        self.top, strain = strain_limit(view.muscle, view.supply), view.strain
        if strain > self.top:
            self.session.view = view = replace(view, strain=self.top)
        self.inputs.show(view)
        self._updating = True
        keys = alternative_laws(view.muscle)
        self.compare.options = {_law_label(key): key for key in keys}
        self.compare.value = [key for key in view.compared if key in keys]
        self._updating = False
        curves = self._curves(view)
        self._show_family(view, curves)
        self._show_curve(view, curves)
        self._show_point(view, curves)
        if strain > self.top:
            self._strain.field.refuse(
                f"Contraction ε is drawn up to {self.top:g} for this muscle, got {strain:g}."
            )
        self._show_remarks(view)
        self._request_others(view)

    def follow(self, before: View, after: View) -> None:
        """Follow the sliders, and what is compared."""
        if changed(before, after, "pressure", "strain"):
            curves = self._curves(after)
            if changed(before, after, "pressure"):
                self._show_curve(after, curves)
                if self.others.data["xs"]:
                    self._request_others(after)
            self._show_point(after, curves)
        if changed(before, after, "compared"):
            self._show_remarks(after)
            self._request_others(after)

    def _curves(self, view: View) -> MuscleCurves:
        return muscle_curves(view.muscle, view.pressure, view.strain, view.supply, self.top)

    def _show_remarks(self, view: View) -> None:
        note = tuning_note(view.muscle, view.shown["pressure"])
        self.notes.object = remarks_html(view, "muscle") + status_line(note)

    # the figure

    def _add_chart(self) -> None:
        colors = self.colors
        chart = self.chart = Chart(colors, "Contraction ε [–]", "Force F [N]", room=270)
        self.strips = chart.source("left", "right", "color", "alpha", name="strips")
        self.region_names = chart.source("x", "y", "label", name="regions")
        self._family = chart.source("xs", "ys", "color", "label", name="family")
        self._family_names = chart.source("x", "y", "label")
        self.chosen = chart.source("strain", *PARTS, name="chosen")
        self.others = chart.source("xs", "ys", "color", "label", "dash", name="compared")
        self._marks = chart.source("x", "y", "label", "above", "beside", "align", name="marks")
        self._here = chart.source("x", "y", name="here")
        chart.draw(self.strips, Quad(left="left", right="right", top=_FAR, bottom=-_FAR,
                                     fill_color="color", fill_alpha="alpha",
                                     line_color=None))  # fmt: skip
        chart.add_zero_line()
        chart.draw(self.region_names, Text(x="x", y="y", text="label", text_color=colors.soft,
                                           text_align="center", text_font_size="12px",
                                           text_baseline="top"))  # fmt: skip
        family = chart.draw(self._family, MultiLine(xs="xs", ys="ys", line_color="color",
                                                    line_width=1.2, line_alpha=0.9))  # fmt: skip
        chart.tags(self._family_names)
        for (part, dash), color in zip(_PART_DASHES.items(), colors.curves, strict=False):
            line = Line(x="strain", y=part, line_color=color, line_dash=dash, line_width=1.8)
            chart.draw(self.chosen, line, part)
        line = Line(x="strain", y="force", line_color=colors.ink, line_width=3)
        force = chart.draw(self.chosen, line, "force")
        chart.draw(self.others, MultiLine(xs="xs", ys="ys", line_color="color", line_width=2.4,
                                          line_dash="dash"), "@label")  # fmt: skip
        chart.draw(self._marks, Scatter(x="x", y="y", size=9, line_color=colors.ink, line_width=2,
                                        fill_color=colors.paper))  # fmt: skip
        chart.tags(self._marks, x_offset="beside", y_offset="above", text_align="align",
                   text_font_size="12px")  # fmt: skip
        chart.draw(self._here, Scatter(x="x", y="y", size=13, marker="diamond",
                                       fill_color=colors.curves[1],
                                       line_color=colors.paper))  # fmt: skip
        self._hover = HoverTool(renderers=[force], mode="vline", line_policy="interp",
                                tooltips=hover_tooltips("F", "N"))  # fmt: skip
        chart.figure.add_tools(
            self._hover, HoverTool(renderers=[family], tooltips=[("P", "@label")])
        )
        chart.figure.on_event(Tap, self._point_at)
        chart.figure.on_event(Press, self._point_at)  # a long click
        chart.add_legend("right")

    def _show_family(self, view: View, curves: MuscleCurves) -> None:
        unit, scale = self._force_unit(view)
        force = curves.force[:-1]
        pressures = curves.pressure[:-1] / unit_factor(view.shown["pressure"], "pressure")
        self._family.data = {
            "xs": list(curves.strain[:-1]),
            "ys": list(force / scale),
            "color": pressure_colors(self.colors, len(force)),
            "label": [f"{x:.3g} {view.shown['pressure']}" for x in pressures],
        }
        every = np.array([getattr(curves, name)[:-1] for name in PARTS])
        low, high = float(every.min()) / scale, float(every.max()) / scale
        room = high - low
        self._label_height = high + 0.14 * room
        self.chart.set_ranges((0.0, self.top), (low - 0.08 * room, high + 0.16 * room))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = hover_tooltips("F", unit)

    def _show_curve(self, view: View, curves: MuscleCurves) -> None:
        self._pressure.show(view.pressure, view.shown["pressure"], view.supply)
        unit, scale = self._force_unit(view)
        parts = {name: getattr(curves, name)[-1] / scale for name in PARTS}
        self.chosen.data = {"strain": curves.strain[-1], **parts}
        # pressures of the family, save where the chosen one's mark stands
        held, blocked = curves.blocked[:-1], curves.blocked[-1]
        named = np.flatnonzero(np.abs(held - blocked) > 0.06 * np.ptp(held))
        self._family_names.data = {
            "x": [0.0] * len(named),
            "y": held[named] / scale,
            "label": [self._family.data["label"][i] for i in named],
        }
        strips = region_strips(curves.strain[-1], curves.regions)
        colors = self.colors
        fills = [(colors.paper, 0.0), (colors.curves[4], 0.14), (colors.soft, 0.20),
                 (colors.curves[5], 0.14)]  # fmt: skip
        self.strips.data = {
            "left": [left for left, _, _ in strips], "right": [right for _, right, _ in strips],
            "color": [fills[i][0] for _, _, i in strips],
            "alpha": [fills[i][1] for _, _, i in strips],
        }  # fmt: skip
        self.region_names.data = {
            "x": [(left + right) / 2 for left, right, _ in strips],
            "y": [self._label_height] * len(strips),
            # a strip too narrow for its name has none, on a phone's 300 pixels too
            "label": [
                REGIONS[i] if right - left > _LETTER * len(REGIONS[i]) * self.top else ""
                for left, right, i in strips
            ],
        }
        self._marks.data = curve_marks(curves, self.top, scale, unit)

    def _show_point(self, view: View, curves: MuscleCurves) -> None:
        self._strain.show(view.strain, "", self.top)
        unit, scale = self._force_unit(view)
        self._here.data = {"x": [view.strain], "y": [curves.force_here / scale]}
        solid = muscle_solid(view.muscle, curves, view.strain)
        length = float(view.muscle.length)
        # a stubby muscle is wider than long; what bows out is seen, too
        reach = max(0.53 * length, 2.0 * solid.radius), 2.0 * solid.radius + 0.16 * length
        colors = [(self.colors.tube, self.colors.fiber)]
        self._scene.show([solid], colors, [(0.0, 0.0, 0.0)], reach)
        # the volume is a straight muscle's of this length: no law here knows a bent one's
        fluid = "fluid" if curves.region in _STRAIGHT else "fluid, if it were straight"
        unit_of_length = view.shown["length"]
        to_length = unit_factor(unit_of_length, "length")
        rows = {
            "force": f"{curves.force_here / scale:.4g} {unit}",
            "state": REGIONS[curves.region]
            + (", other equilibria exist" if curves.several else ""),
            fluid: volume_text(curves.volume, unit_of_length),
            "braid angle": pretty(solid.angle, "angle"),
            "radius": f"{solid.radius / to_length:.4g} {unit_of_length}",
            "bows out": f"{curves.deflection / to_length:.4g} {unit_of_length}",
            "bending moment": moment_text(curves.moment, view.shown),
        }
        if branches := branches_text(curves.strain[-1], curves.branches):
            rows["several equilibria"] = branches
        self._numbers.object = heading("At this point") + readout_table(rows)

    # other laws

    def _choose_compared(self, event: Any) -> None:
        if self._updating:
            return
        try:
            self.session.change(compared=check_compared(tuple(event.new)))
            self.message.show("")
        except ValueError as error:
            self._updating = True
            self.compare.value = list(event.old)
            self._updating = False
            self.message.show(error)

    def _request_others(self, view: View) -> None:
        keys = [key for key in view.compared if key in alternative_laws(view.muscle)]
        top = self.top

        def compute() -> list[tuple[str, MuscleCurves]]:
            others = {key: with_alternative(view.muscle, key) for key in keys}
            return [
                (key, muscle_curves(muscle, view.pressure, view.strain, view.supply, top))
                for key, muscle in others.items()
            ]

        if keys:
            self._others.request(compute)
        else:
            self._show_others([])

    def _show_others(self, others: list[tuple[str, MuscleCurves]]) -> None:
        _, scale = self._force_unit(self.session.view)
        self.others.data = {
            "xs": [curves.strain[-1] for _, curves in others],
            "ys": [curves.force[-1] / scale for _, curves in others],
            "color": [self.colors.curves[i] for i in _COMPARED_COLORS[: len(others)]],
            "dash": list(_COMPARED_DASHES[: len(others)]),
            "label": [_law_label(key) for key, _ in others],
        }

    # a point that is clicked, and the sweep

    def _point_at(self, event: Any) -> None:
        if event.x is not None and 0 <= event.x <= self.top:
            self.session.change(strain=round(float(event.x), 4))

    def _force_unit(self, view: View) -> tuple[str, float]:
        unit = view.shown["force"]
        return unit, unit_factor(unit, "force")

    def _step(self) -> bool:
        view = self.session.view
        if view.tab != self.name:
            return False
        following = round(view.strain + self.top / SWEEP_STEPS, 4)
        self.session.change(strain=0.0 if following > self.top else following)
        return True


def _law_label(key: str) -> str:
    return key.replace("_", " ").replace(":", ": ")

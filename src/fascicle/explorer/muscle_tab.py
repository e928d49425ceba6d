"""The muscle's tab: its force over strain, taken apart, beside other laws, and itself."""

from dataclasses import replace
from typing import Any

import numpy as np
import panel as pn
from bokeh.events import Press, Tap
from bokeh.models import HoverTool

from ..units import pretty
from .background import Latest
from .muscle_curves import (
    PARTS,
    REGIONS,
    Picture,
    alternative,
    alternatives,
    check_compared,
    marks,
    picture,
    strips,
    widest,
)
from .muscle_inputs import MuscleInputs
from .solid import Scene, solid
from .state import Session, View, changed
from .tab import branches, remarks, status, tuned
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
    pressure_colors,
    set_range,
    source_of,
    tags,
    told,
    widget_css,
)
from .widgets import STEPS, Dial, Message, Sweep, factor, heading, moment, table, volume


_STAGE = "clamp(220px, 100vh - 500px, 900px)"  # how high the muscle is shown
_STRAIGHT = (0, 3)  # regions in which a muscle is
_LETTER = 0.0245  # of the strains drawn: one of a region's name
_FAR = 1e9  # any shown unit: beyond every picture
# of `curves`, for what is laid over it: none is the force's or a part's, nor are the long dashes
_OTHERS = (3, 4, 5, 7)
_DASHES = ("14 4", "14 4 3 4", "14 4 3 4 3 4", "5 3 1 3")
_PARTS = (
    ("mesh", "mesh", "dashed"),
    ("bladder", "bladder", "dotdash"),
    ("bending", "bending", "dotted"),
)


class MuscleView:
    """Widgets and figures of one muscle; `refresh` when its tab is looked at."""

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        self._session, self._look, self._stale = session, look, True
        self._top, self._above = 0.3, 0.0
        self._inputs = MuscleInputs(session, look)
        self._pressure = Dial(look, "Pressure P", "pressure", "pressure", self._set_pressure)
        self._strain = Dial(
            look, "Contraction ε", "strain", "strain", lambda value: session.change(strain=value)
        )
        self._draw()
        self._scene = Scene(look, "solid", _STAGE)
        self._numbers = pn.pane.HTML("", sizing_mode="stretch_width", margin=(0, 8))
        self._notes = pn.pane.HTML("", sizing_mode="stretch_width", margin=(2, 8))
        self._play = Sweep(look, "the strain", self._step)
        self._compare = pn.widgets.MultiSelect(
            label="Compare with (Ctrl for several)", size=4, stylesheets=[widget_css(look)],
            sizing_mode="stretch_width", margin=(2, 8),
        )  # fmt: skip
        self._compare.param.watch(self._compared, "value")
        self._many = Message("compare")
        self._silent = False
        self._others = Latest(self._show_others, self._inputs.message.say)
        session.watch(self._changed)
        left = pn.Column(
            self._inputs.panel, self._compare, self._many.pane, width=284, margin=(0, 8, 0, 0),
            stylesheets=[ROLLED, AFTER],
        )  # fmt: skip
        dials = pn.Row(
            self._pressure.panel, self._strain.panel, sizing_mode="stretch_width", margin=0,
            stylesheets=[STACKED],
        )  # fmt: skip
        stage = pn.Column(
            pn.pane.Bokeh(self._scene.figure, margin=0, stylesheets=[TALL]),
            pn.Row(self._scene.turn, self._play.button, sizing_mode="stretch_width", margin=0),
            heading("At this point"), self._numbers, margin=0, **half(),
        )  # fmt: skip
        curves = pn.Column(
            pn.pane.Bokeh(self.figure, margin=0, stylesheets=[TALL]), margin=0, **half()
        )
        main = pn.Column(
            self._notes, dials,
            pn.Row(curves, stage, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]),
            sizing_mode="stretch_width", margin=0, stylesheets=[NARROW],
        )  # fmt: skip
        self.panel = pn.Row(
            left, main, sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]
        )

    # what is told, and what follows

    def refresh(self) -> None:
        """Draw all of it, if anything changed since it was drawn."""
        if self._stale:
            self._stale = False
            self._all(self._session.view)

    def _changed(self, before: View, after: View) -> None:
        if after.tab != "muscle":
            self._stale = True
            return
        if self._stale or changed(before, after, "muscle", "units", "supply", "shown", "tab"):
            self._stale = False
            self._all(after)
        elif changed(before, after, "pressure", "strain"):
            self._picture(after, pressed=changed(before, after, "pressure"))
        if changed(before, after, "compared"):
            self._remark(after)
            self._ask_others(after)

    def _all(self, view: View) -> None:
        self._top, asked = widest(view.muscle, view.supply), view.strain
        if asked > self._top:
            self._session.view = view = replace(view, strain=self._top)
        self._inputs.show(view)
        self._silent = True
        options = alternatives(view.muscle)
        self._compare.options = {key.replace("_", " ").replace(":", ": "): key for key in options}
        self._compare.value = [key for key in view.compared if key in options]
        self._silent = False
        self._picture(view, pressed=True, family=True)
        if asked > self._top:
            self._strain.field.message.say(
                f"`strain` is drawn up to {self._top:g} for this muscle, asked was {asked:g}."
            )
        self._remark(view)
        self._ask_others(view)

    def _remark(self, view: View) -> None:
        about = tuned(view.muscle, view.shown["pressure"])
        self._notes.object = remarks(view, "muscle") + status(about)

    def _picture(self, view: View, pressed: bool, family: bool = False) -> None:
        found = picture(view.muscle, view.pressure, view.strain, view.supply, self._top)
        if family:
            self._family(view, found)
        if pressed:
            self._curves(view, found)
        self._point(view, found)

    # figures

    def _draw(self) -> None:
        look = self._look
        fig = plain_figure(look, "Contraction ε [–]", "Force F [N]", room=270)
        self.figure = fig
        self._strips = source_of({"left": [], "right": [], "color": [], "alpha": []}, name="strips")
        fig.quad("left", "right", _FAR, -_FAR, source=self._strips, fill_color="color",
                 fill_alpha="alpha", line_color=None)  # fmt: skip
        names = ("force", *(part for part, _, _ in _PARTS))
        self.chosen = source_of({"strain": [], **{n: [] for n in names}}, name="chosen")
        self._families = source_of({"xs": [], "ys": [], "color": [], "label": []}, name="family")
        self._told = source_of({"x": [], "y": [], "label": []})
        self._other = source_of(
            {"xs": [], "ys": [], "color": [], "label": [], "dash": []}, name="compared"
        )
        self._marks = source_of({"x": [], "y": [], "label": [], "below": [],
                                 "beside": [], "align": []}, name="marks")  # fmt: skip
        self._here = source_of({"x": [], "y": []}, name="here")
        self._names = source_of({"x": [], "y": [], "label": []}, name="regions")
        fig.line([0, 10], [0, 0], color=look.soft, line_width=1)
        fig.text("x", "y", "label", source=self._names, color=look.soft, text_align="center",
                 text_font_size="12px", text_baseline="top")  # fmt: skip
        several = fig.multi_line(
            "xs", "ys", source=self._families, color="color", line_width=1.2, line_alpha=0.9
        )
        tags(fig, look, self._told)
        for (part, label, dash), color in zip(_PARTS, look.curves, strict=False):
            fig.line("strain", part, source=self.chosen, color=color, line_dash=dash,
                     line_width=1.8, legend_label=label)  # fmt: skip
        main = fig.line("strain", "force", source=self.chosen, color=look.ink, line_width=3,
                        legend_label="force")  # fmt: skip
        fig.multi_line("xs", "ys", source=self._other, color="color", line_width=2.4,
                       line_dash="dash", legend_field="label")  # fmt: skip
        fig.scatter("x", "y", source=self._marks, size=9, color=look.ink, fill_color=look.paper,
                    line_width=2)  # fmt: skip
        tags(fig, look, self._marks, x_offset="beside", y_offset="below", text_align="align",
             text_font_size="12px")  # fmt: skip
        fig.scatter("x", "y", source=self._here, size=13, marker="diamond",
                    color=look.curves[1], line_color=look.paper)  # fmt: skip
        self._hover = HoverTool(
            renderers=[main], mode="vline", line_policy="interp", tooltips=told("F", "N")
        )
        fig.on_event(Tap, self._tapped)
        fig.on_event(Press, self._tapped)  # a click that lasts, too
        fig.add_tools(
            self._hover,
            HoverTool(renderers=[several], tooltips=[("P", "@label")]),
        )
        legend_style(fig, look, "right")

    def _family(self, view: View, found: Picture) -> None:
        unit, scale = self._force_unit(view)
        force = found.force[:-1]
        in_unit = found.pressure[:-1] / factor(view.shown["pressure"], "pressure")
        self._families.data = {
            "xs": list(found.strain[:-1]),
            "ys": list(force / scale),
            "color": pressure_colors(self._look, len(force)),
            "label": [f"{x:.3g} {view.shown['pressure']}" for x in in_unit],
        }
        every = np.array([getattr(found, name)[:-1] for name in PARTS])
        low, high = float(every.min()) / scale, float(every.max()) / scale
        self._above = high + 0.14 * (high - low)
        set_range(self.figure.x_range, 0.0, self._top)
        set_range(self.figure.y_range, low - 0.08 * (high - low), high + 0.16 * (high - low))
        self.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = told("F", unit)

    def _curves(self, view: View, found: Picture) -> None:
        self._pressure.show(view.pressure, view.shown["pressure"], view.supply)
        _, scale = self._force_unit(view)
        parts = {name: getattr(found, name)[-1] / scale for name in PARTS}
        self.chosen.data = {"strain": found.strain[-1], **parts}
        self._tell_pressures(found, scale)
        self._mark(view, found)
        if self._other.data["xs"]:
            self._ask_others(view)

    def _tell_pressures(self, found: Picture, scale: float) -> None:
        """Name the family's pressures, save where the chosen one's mark stands."""
        held, chosen = found.blocked[:-1], found.blocked[-1]
        shown = np.flatnonzero(np.abs(held - chosen) > 0.06 * np.ptp(held))
        self._told.data = {
            "x": [0.0] * len(shown),
            "y": held[shown] / scale,
            "label": [self._families.data["label"][i] for i in shown],
        }

    def _mark(self, view: View, found: Picture) -> None:
        unit, scale = self._force_unit(view)
        ran = strips(found.strain[-1], found.regions)
        fills = [(self._look.paper, 0.0), (self._look.curves[4], 0.14), (self._look.soft, 0.20),
                 (self._look.curves[5], 0.14)]  # fmt: skip
        self._strips.data = {
            "left": [left for left, _, _ in ran], "right": [right for _, right, _ in ran],
            "color": [fills[i][0] for _, _, i in ran], "alpha": [fills[i][1] for _, _, i in ran],
        }  # fmt: skip
        self._names.data = {
            "x": [(left + right) / 2 for left, right, _ in ran],
            "y": [self._above] * len(ran),
            # a strip too narrow for its name goes without, on a phone's 300 pixels too
            "label": [
                REGIONS[i] if right - left > _LETTER * len(REGIONS[i]) * self._top else ""
                for left, right, i in ran
            ],
        }
        self._marks.data = marks(found, self._top, scale, unit)

    def _point(self, view: View, found: Picture) -> None:
        self._strain.show(view.strain, "", self._top)
        unit, scale = self._force_unit(view)
        self._here.data = {"x": [view.strain], "y": [found.force_here / scale]}
        drawn = solid(view.muscle, found, view.strain)
        length = float(view.muscle.length)
        # a stubby muscle is wider than long; what bows out is seen, too
        reach = max(0.53 * length, 2.0 * drawn.radius), 2.0 * drawn.radius + 0.16 * length
        colors = [(self._look.tube, self._look.fiber)]
        self._scene.show([drawn], colors, [(0.0, 0.0, 0.0)], reach)
        state = REGIONS[found.region] + (", other equilibria exist" if found.several else "")
        # the volume is a straight muscle's of this length: no law here knows a bent one's
        fluid = "fluid" if found.region in _STRAIGHT else "fluid, if it were straight"
        rows = {
            "force": f"{found.force_here / scale:.4g} {unit}",
            "state": state,
            fluid: volume(found.volume, view.shown["length"]),
            "braid angle": pretty(drawn.angle, "angle"),
            "radius": f"{drawn.radius / factor(view.shown['length'], 'length'):.4g}"
            f" {view.shown['length']}",
            "bows out": f"{found.deflection / factor(view.shown['length'], 'length'):.4g}"
            f" {view.shown['length']}",
            "bending moment": moment(found.moment, view.shown),
        }
        if more := branches(found.strain[-1], found.branches):
            rows["several equilibria"] = more
        self._numbers.object = table(rows)

    # other laws

    def _compared(self, event: Any) -> None:
        if self._silent:
            return
        try:
            self._session.change(compared=check_compared(tuple(event.new)))
            self._many.say("")
        except ValueError as error:
            self._silent = True
            self._compare.value = list(event.old)
            self._silent = False
            self._many.say(str(error))

    def _ask_others(self, view: View) -> None:
        keys = [key for key in view.compared if key in alternatives(view.muscle)]
        top = self._top

        def compute() -> list[tuple[str, np.ndarray, np.ndarray]]:
            out = []
            for key in keys:
                other = alternative(view.muscle, key)
                found = picture(other, view.pressure, view.strain, view.supply, top)
                out.append((key, found.strain[-1], found.force[-1]))
            return out

        if keys:
            self._others.ask(compute)
        else:
            self._show_others([])

    def _show_others(self, found: list[tuple[str, np.ndarray, np.ndarray]]) -> None:
        _, scale = self._force_unit(self._session.view)
        self._other.data = {
            "xs": [strain for _, strain, _ in found],
            "ys": [force / scale for _, _, force in found],
            "color": [self._look.curves[i] for i in _OTHERS[: len(found)]],
            "dash": list(_DASHES[: len(found)]),
            "label": [key.replace("_", " ").replace(":", ": ") for key, _, _ in found],
        }

    # pressure, a point that is clicked, and the sweep

    def _tapped(self, event: Any) -> None:
        if event.x is not None and 0 <= event.x <= self._top:
            self._session.change(strain=round(float(event.x), 4))

    def _set_pressure(self, value: float) -> None:
        self._session.change(pressure=value)

    def _force_unit(self, view: View) -> tuple[str, float]:
        unit = view.shown["force"]
        return unit, factor(unit, "force")

    def _step(self) -> bool:
        view = self._session.view
        if view.tab != "muscle":
            return False
        following = round(view.strain + self._top / STEPS, 4)
        self._session.change(strain=0.0 if following > self._top else following)
        return True

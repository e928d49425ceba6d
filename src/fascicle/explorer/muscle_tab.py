"""Tab of one muscle: its force over strain with its parts, and the muscle itself."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from .. import plot
from ..plot.theme import Colors
from ..results import tables
from ..units import pretty
from .chart import Chart, cycle_colors, hover_tooltips, pressure_colors, screen_height
from .compare_tab import PinButton
from .muscle_curves import (
    PARTS,
    POINTS,
    REGIONS,
    MuscleCurves,
    curve_marks,
    muscle_curves,
    region_strips,
    strain_limit,
)
from .muscle_inputs import MuscleInputs
from .remarks import branches_text, remarks_html, tuning_note, words_html
from .solid import Scene, muscle_solid
from .state import Session, View, changed
from .tab import Export, Tab
from .widgets import (
    QuantitySlider,
    column,
    format_quantity,
    heading,
    pane,
    readout_table,
    row,
    side_column,
    status_line,
    unit_factor,
    volume_unit,
)


# room for header, sliders and readouts
_SCENE_HEIGHT = "var(--scene-height, clamp(220px, min(100vh - 500px, 90vw), 900px))"
_STRAIGHT = (0, 3)  # regions in which a muscle is straight
_LETTER = 0.0245  # width of a letter of a region's name, of the strains drawn
# told apart without color
_PART_DASHES = {"mesh": "dashed", "bladder": "dotdash", "bending": "dotted"}


class MuscleView(Tab):
    """Widgets and figures of one muscle."""

    name: ClassVar[str] = "muscle"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "units", "supply", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self.top, self._label_height = 0.3, 0.0
        self.inputs = MuscleInputs(session)
        self._pressure = QuantitySlider(
            "Pressure P", "pressure", "pressure", lambda value: session.change(pressure=value)
        )
        self._strain = self.strain_slider()
        self._add_chart()
        self._scene = Scene(colors, "solid", _SCENE_HEIGHT, self._set_strain)
        self._numbers = pane(sizing_mode="stretch_width")
        explanations = pane(
            words_html(*PARTS[1:], "blocked force", "free strain", "buckling", "collapse")
        )
        left = side_column(self.inputs.panel, self.message.pane, explanations, width=284)
        curves = column(self.chart.new_pane(), kind="equal")
        scene = column(
            *self._scene.panes(),
            column(self._numbers, kind="aside"),
            kind="equal picture",
        )
        pin = PinButton(session)
        sliders = row(self._pressure.panel, self._strain.panel, pin.panel, kind="stacked pinned")
        main = column(self.notes, sliders, pin.result, row(curves, scene))
        self.panel = row(left, main)

    def draw(self, view: View) -> None:
        """Show a `view`."""
        self.top = strain_limit(view.muscle, view.supply)
        self.inputs.show(view)
        curves = self._compute_curves(view)
        self._show_family(curves)
        self._show_curve_and_regions(view, curves)
        self._show_point(view, curves)
        self.notes.object = remarks_html(view, "muscle") + status_line(tuning_note(view.muscle))

    def follow(self, before: View, after: View) -> None:
        """Update what depends on pressure and contraction."""
        if changed(before, after, "pressure", "strain"):
            curves = self._compute_curves(after)
            if changed(before, after, "pressure"):
                self._show_curve_and_regions(after, curves)
            self._show_point(after, curves)

    def export(self) -> Export:
        """Picture and data of the curve at the view's pressure."""
        muscle, pressures = self.session.view.muscle, [self.session.view.pressure]
        strain = np.linspace(0.0, self.top, POINTS)
        variables = tables.muscle_force(muscle, pressures, strain)
        return Export(
            self.stem("force"), variables, lambda: plot.force_strain(muscle, pressures, strain)
        )

    def _compute_curves(self, view: View) -> MuscleCurves:
        strain = min(view.strain, self.top)
        return muscle_curves(view.muscle, view.pressure, strain, view.supply, self.top)

    # the figure

    def _add_chart(self) -> None:
        """Add the chart of force over strain."""
        colors = self.colors
        chart = self.chart = Chart(colors, "Contraction ε [–]", "Force F [N]", screen_height(270))
        self.strips = chart.add("strips")
        chart.add_zero_line()
        self.region_names = chart.add("regions")
        self._family = chart.add("family")
        chart.add_hover([("P", "@label")])
        self._family_names = chart.new_source("x y label")
        chart.add_labels(self._family_names)
        self.curve = chart.add("curve")
        self._hover = chart.add_force_hover()
        part_colors = cycle_colors(colors, len(_PART_DASHES), first=2)
        for (part, dash), color in zip(_PART_DASHES.items(), part_colors, strict=True):
            style = {"y": part, "line_color": color, "line_dash": dash, "legend_label": part}
            chart.add("part", source=self.curve, **style)
        self._marks = chart.add("marks")
        offsets = {"x_offset": "beside", "y_offset": "above", "text_align": "align"}
        chart.add_labels(self._marks, text_font_size="12px", **offsets)
        self._point = chart.add("point")
        chart.on_hold(self._set_strain)
        chart.style_legend(location="right")

    def _show_family(self, curves: MuscleCurves) -> None:
        unit, scale = self.unit("force")
        pressure_unit, pressure_scale = self.unit("pressure")
        force = curves.force[:-1]
        self._family.data = {
            "xs": list(curves.strain[:-1]),
            "ys": list(force / scale),
            "color": pressure_colors(self.colors, len(force)),
            "label": [f"{P / pressure_scale:.3g} {pressure_unit}" for P in curves.pressure[:-1]],
        }
        forces = np.array([getattr(curves, name)[:-1] for name in PARTS]) / scale
        low, high = float(forces.min()), float(forces.max())
        span = high - low
        self._label_height = high + 0.14 * span
        self.chart.set_ranges((0.0, self.top), (low - 0.08 * span, high + 0.16 * span))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = hover_tooltips(unit)

    def _show_curve_and_regions(self, view: View, curves: MuscleCurves) -> None:
        self._pressure.show(view.pressure, view.display_units["pressure"], view.supply)
        unit, scale = self.unit("force")
        forces = {name: getattr(curves, name)[-1] / scale for name in PARTS}
        self.curve.data = {"strain": curves.strain[-1], **forces}
        # pressures of the family, save where the chosen one's mark stands
        *family, blocked = curves.blocked
        distance = np.abs(np.array(family) - blocked)
        labeled = np.flatnonzero(distance > 0.06 * np.ptp(family))
        self._family_names.data = {
            "x": [0.0] * len(labeled),
            "y": [family[i] / scale for i in labeled],
            "label": [self._family.data["label"][i] for i in labeled],
        }
        colors = self.colors
        fills = [
            (colors.paper, 0.0),
            (colors.curves[4], 0.14),
            (colors.soft, 0.20),
            (colors.curves[5], 0.14),
        ]
        strips = region_strips(curves.strain[-1], curves.regions)
        left, right = ([strip[end] for strip in strips] for end in (0, 1))
        regions = [region for _, _, region in strips]
        self.strips.data = {
            "left": left,
            "right": right,
            "color": [fills[i][0] for i in regions],
            "alpha": [fills[i][1] for i in regions],
        }
        widths = np.subtract(right, left)
        self.region_names.data = {
            "x": np.add(left, right) / 2,
            "y": [self._label_height] * len(regions),
            # a strip too narrow for its name has none, on a phone's 300 pixels too
            "label": [
                REGIONS[i] if width > _LETTER * len(REGIONS[i]) * self.top else ""
                for width, i in zip(widths, regions, strict=True)
            ],
        }
        self._marks.data = curve_marks(curves, self.top, scale, unit)

    def _show_point(self, view: View, curves: MuscleCurves) -> None:
        strain = min(view.strain, self.top)
        self._strain.show(strain, "", self.top)
        unit, scale = self.unit("force")
        pressure = format_quantity(view.pressure, self.unit("pressure")[0], "pressure", 4)
        force, region = f"{curves.point_force / scale:.4g} {unit}", REGIONS[curves.region]
        position_text = f"at a contraction of {strain:.4g}, {region}"
        marks = ", ".join(self._marks.data["label"])
        self.chart.describe(
            f"Force over contraction at {pressure}: {marks}; {force} {position_text}."
        )
        self._scene.describe(f"Drawing of the muscle {position_text}.")
        self._point.data = {"x": [strain], "y": [curves.point_force / scale]}
        solid = muscle_solid(view.muscle, curves, strain)
        length = float(view.muscle.length)
        # a stubby muscle is wider than long; it bows out to its side
        reach = max(0.53 * length, 2.0 * solid.radius), 2.0 * solid.radius + 0.16 * length
        colors = [(self.colors.tube, self.colors.fiber)]
        positions = [(0.0, 0.0, 0.0)]
        self._scene.show([solid], colors, self.colors.fitting, positions, reach, (strain, length))
        # the volume is a straight muscle's of this length: no law has that of a bent one
        fluid = "fluid" if curves.region in _STRAIGHT else "fluid, if it were straight"
        length_unit, length_scale = self.unit("length")
        volume, volume_scale = volume_unit(length_unit)
        rows = {
            "force": force,
            "state": region + (", other equilibria exist" if curves.several else ""),
            fluid: f"{curves.volume / volume_scale:.4g} {volume}",
            "braid angle": pretty(solid.angle, "angle"),
            "radius": f"{solid.radius / length_scale:.4g} {length_unit}",
            "deflection": f"{curves.deflection / length_scale:.4g} {length_unit}",
            "bending moment": _bending_moment_text(curves.moment, view.display_units),
        }
        if branches := branches_text(curves.strain[-1], curves.branches):
            rows["several equilibria"] = branches
        self._numbers.object = heading("At this point") + readout_table(rows)

    # the hand

    def _set_strain(self, strain: float, _: float = 0.0) -> None:
        """Move the point to a `strain` [-] that is drawn."""
        self.session.change(strain=round(float(np.clip(strain, 0.0, self.top)), 4))


def _bending_moment_text(moment: float, units: Mapping[str, str]) -> str:
    """Text of a bending `moment` [N m] in the `units` shown of force and length; in m for mm."""
    length = "m" if units["length"] == "mm" else units["length"]  # N·m, the field's unit
    scale = unit_factor(units["force"], "force") * unit_factor(length, "length")
    return f"{moment / scale:.4g} {units['force']}·{length}"

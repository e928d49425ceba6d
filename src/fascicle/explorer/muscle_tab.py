"""Tab of one muscle: its inputs, its force over strain with its parts, and the muscle itself."""

import html
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import numpy as np
import panel as pn

from .. import plot
from ..core.errors import InvalidInputError
from ..core.module import replace_checked
from ..muscle.laws import LAWS
from ..muscle.materials import MATERIALS
from ..plot.theme import Colors
from ..results import tables
from ..units import pretty
from . import widgets as ui
from .chart import Chart, hover_tooltips, other_colors, pressure_colors, screen_height
from .compare_tab import pin_muscle
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
from .remarks import branches_text, remarks_html, tuning_note, words_html
from .solid import Scene, muscle_solid
from .state import CHANGED, Session, View, changed, is_shipped
from .tab import Export, StrainTab


# room for header, sliders and readouts
_SCENE_HEIGHT = "var(--scene-height, clamp(220px, min(100vh - 500px, 90vw), 900px))"
_FAMILY = 7  # thin curves, at even pressures
_ALPHAS = (0.0, 0.10, 0.24, 0.05)  # of regions' strips
_STRAIGHT = (0, 3)  # regions in which a muscle is straight
_LETTER = 0.0245  # width of a letter of a region's name, of the strains drawn
# told apart without color
_PART_DASHES = {"mesh": "dashed", "bladder": "dotdash", "bending": "dotted"}
_CUSTOM = "its own"  # material
_TITLES = {"post_collapse": "After collapse"}  # of laws, where it isn't the kind's name


class MuscleInputs:
    """Inputs of a muscle; a change makes another muscle, or shows why there is none."""

    def __init__(self, session: Session):
        self._session, self.message = session, ui.Message()
        self.fields = {
            name: ui.Field(label, name, dimension, partial(self._set_size, name))
            for name, (label, dimension) in ui.SIZES.items()
        }
        self._material = ui.dropdown("Material", [*MATERIALS, _CUSTOM], self._choose_material)
        self.laws = {kind: LawInputs(kind, self) for kind in LAWS}
        sizes = [widget for field in self.fields.values() for widget in field.widgets]
        panels = [law.panel for law in self.laws.values()]
        laws = ui.fold("Advanced: laws and their constants", *panels)
        self.panel = ui.column(
            ui.column(*sizes, kind="pairs"), self._material, self.message.pane, laws
        )

    def show(self, view: View) -> None:
        """Fill the inputs from the view's muscle, and clear the message."""
        muscle = view.muscle
        for name, (_, dimension) in ui.SIZES.items():
            unit = ui.field_unit(dimension, view.display_units)
            self.fields[name].show(float(getattr(muscle, name)), unit)
        names = [name for name, material in MATERIALS.items() if material == muscle.material]
        self._material.value = names[0] if names else _CUSTOM
        for kind, law in self.laws.items():
            law.show(getattr(muscle, kind), view.display_units)
        self.message.show("")

    def change(self, **parts: object) -> None:
        """Replace parts of the session's muscle, and rename it; `ValueError` if it can't be."""
        view, opened = self._session.view, self._session.opened
        muscle, name = view.muscle.replace(**parts), view.name.removesuffix(CHANGED)
        if muscle == opened.muscle:
            name = opened.name
        elif not is_shipped(name, muscle):
            name += CHANGED
        after = replace(view, muscle=muscle, name=name)
        _ = after.bundle  # raises at this field if it can't be a bundle any more
        self._session.show(after)

    def _set_size(self, name: str, value: float) -> None:
        try:
            self.change(**{name: value})
        except InvalidInputError as error:
            # a rule between two sizes names one of them: it is shown at both
            if error.argument != name and error.argument in self.fields:
                self.fields[error.argument].show_error(error)
            raise

    def _choose_material(self, name: str) -> None:
        if name != _CUSTOM and MATERIALS[name] != self._session.view.muscle.material:
            with self.message.errors():
                self.change(material=name)


class LawInputs:
    """Inputs of one kind of law: its name, and a field for each of its constants and options."""

    def __init__(self, kind: str, inputs: MuscleInputs):
        self._kind, self._inputs, self._message = kind, inputs, ui.Message()
        self._law: Any = None
        self.fields: dict[str, ui.Field] = {}
        self.choices: dict[str, pn.widgets.Select] = {}
        names = {name.replace("_", " "): name for name in LAWS[kind]}
        self.select = ui.dropdown(_TITLES.get(kind, kind.capitalize()), names, self._choose_law)
        self._constants = ui.column(margin=(0, 0, 0, 12))
        self.panel = ui.column(self.select, self._message.pane, self._constants)

    def show(self, law: Any, units: Mapping[str, str]) -> None:
        """Show a `law` with quantities in `units`, by dimension."""
        before, self._law = self._law, law
        if type(law) is not type(before):
            self.fields, self.choices = {}, {}
            for name, dimension in ((x.name, x.dimension) for x in law.constants()):
                set_value = partial(self._set_constant, name)
                self.fields[name] = ui.Field(_label_of(name), name, dimension, set_value)
            for switch in law.switches():
                options = {option.replace("_", " "): option for option in switch.options}
                choose = partial(self._choose_option, switch.name)
                self.choices[switch.name] = ui.dropdown(_label_of(switch.name), options, choose)
            fields = [widget for field in self.fields.values() for widget in field.widgets]
            self._constants.objects = [*fields, *self.choices.values()]
        self.select.value = law.name
        for constant in law.constants():
            unit = ui.field_unit(constant.dimension, units)
            self.fields[constant.name].show(float(getattr(law, constant.name)), unit)
        for name, choice in self.choices.items():
            choice.value = getattr(law, name)

    def _set_constant(self, name: str, value: object) -> None:
        self._inputs.change(**{self._kind: replace_checked(self._law, {name: value})})

    def _choose_law(self, name: str) -> None:
        if name != self._law.name:
            with self._message.errors():
                self._inputs.change(**{self._kind: name})

    def _choose_option(self, name: str, option: str) -> None:
        if option != getattr(self._law, name):
            with self._message.errors():
                self._set_constant(name, option)


def _label_of(name: str) -> str:
    return name.replace("_", " ").capitalize()


class MuscleView(StrainTab):
    """Widgets and figures of one muscle."""

    name: ClassVar[str] = "muscle"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "units", "supply", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        # of the family of curves [shown unit]: largest force, and each force at rest length
        self._high, self._blocked = 0.0, np.zeros(_FAMILY)
        self._label_height, self._error = 0.0, ui.Message()
        names = "Pressure P", "pressure", "pressure"
        self._pressure = ui.QuantitySlider(*names, lambda value: session.change(pressure=value))
        self._add_chart()
        self._scene = Scene(colors, "solid", _SCENE_HEIGHT, self.set_strain)
        self.inputs, self._numbers = MuscleInputs(session), ui.wide_pane()
        words = words_html(*PARTS[1:], "blocked force", "free strain", "buckling", "collapse")
        inputs = self.inputs.panel, self.message.pane, ui.pane(words)
        curves = ui.column(self.chart.new_pane(), kind="equal")
        numbers = ui.column(self._numbers, kind="aside")
        scene = ui.column(*self._scene.panes(), numbers, kind="equal picture")
        pin = ui.button("Pin this curve", self._pin, margin=(8, 8, 2, 8))
        aside = ui.column(pin, kind="aside", sizing_mode=None)
        self._pinned = ui.pane(css_classes=["live"])
        sliders = (self._pressure.panel, self.strain.panel, aside)
        top = ui.row(*sliders, kind="stacked pinned")
        main = ui.column(self.notes, top, self._pinned, self._error.pane, ui.row(curves, scene))
        self.panel = ui.row(ui.side_column(*inputs, width=284), main)

    def draw(self, view: View) -> None:
        self.top = strain_limit(view.muscle, view.supply)
        self.show_strain(view)
        self.inputs.show(view)
        curves = self._compute_curves(view)
        self._show_family(view)
        self._show_curve_and_regions(view, curves)
        self._show_point(view, curves)
        note = ui.status_line(tuning_note(view.muscle))
        self.notes.object = remarks_html(view, "muscle", self.session.opened.muscle) + note

    def follow(self, before: View, after: View) -> None:
        if changed(before, after, "strain"):
            self.show_strain(after)
        if changed(before, after, "pressure", "strain"):
            curves = self._compute_curves(after)
            if changed(before, after, "pressure"):
                self._show_curve_and_regions(after, curves)
            self._show_point(after, curves)

    def export(self) -> Export:
        view, strain = self.session.view, np.linspace(0.0, self.top, POINTS)
        arguments = view.muscle, [view.pressure], strain
        variables = tables.muscle_force(*arguments)
        return Export(self.stem("force"), variables, lambda: plot.force_strain(*arguments))

    def _pin(self) -> None:
        view, self._pinned.object = self.session.view, ""
        with self._error.errors():
            name = html.escape(pin_muscle(self.session, view.muscle))
            self._pinned.object = f'<p class="small">Pinned in Compare as “{name}”.</p>'

    def _compute_curves(self, view: View) -> MuscleCurves:
        strain = min(view.strain, self.top)
        return muscle_curves(view.muscle, view.pressure, strain, self.top)

    def _add_chart(self) -> None:
        colors, labels = self.colors, ("Contraction ε [–]", "Force F [N]")
        chart = self.chart = Chart(colors, *labels, screen_height(270))
        self.strips = chart.add("strips")
        chart.add_zero_line()
        self.region_names, self._family = chart.add("regions"), chart.add("family")
        chart.add_hover([("P", "@label")])
        self._family_names = chart.new_source("x y label")
        chart.add_labels(self._family_names)
        self.curve = chart.add("curve")
        self._hover = chart.add_force_hover()
        part_colors = other_colors(colors, len(_PART_DASHES))
        for (part, dash), color in zip(_PART_DASHES.items(), part_colors, strict=True):
            style = {"y": part, "line_color": color, "line_dash": dash, "legend_label": part}
            chart.add("part", source=self.curve, **style)
        self._marks = chart.add("marks")
        chart.add("leaders", source=self._marks)
        offsets = {"y": "place", "x_offset": "beside", "y_offset": "above", "text_align": "align"}
        chart.add_labels(self._marks, text_font_size="12px", **offsets)
        self._point = chart.add("point")
        chart.on_hold(self.set_strain)
        chart.style_legend(location="right")

    def _show_family(self, view: View) -> None:
        unit, scale = self.unit("force")
        pressure_unit, pressure_scale = self.unit("pressure")
        pressures = np.linspace(0.0, view.supply, _FAMILY)
        curves = [muscle_curves(view.muscle, float(P), 0.0, self.top) for P in pressures]
        self._family.data = {
            "xs": [curve.strain for curve in curves],
            "ys": [curve.force / scale for curve in curves],
            "color": pressure_colors(self.colors, _FAMILY),
            "label": [f"{P / pressure_scale:.3g} {pressure_unit}" for P in pressures],
        }
        forces = np.array([[getattr(curve, name) for name in PARTS] for curve in curves]) / scale
        low, high, span = float(forces.min()), float(forces.max()), float(np.ptp(forces))
        self._blocked, self._high = forces[:, 0, 0], high
        self._label_height = high + 0.14 * span
        self.chart.set_ranges((0.0, self.top), (low - 0.08 * span, high + 0.16 * span))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = hover_tooltips(unit)

    def _show_curve_and_regions(self, view: View, curves: MuscleCurves) -> None:
        self._pressure.show(view.pressure, view.display_units["pressure"], view.supply)
        unit, scale = self.unit("force")
        forces = {name: getattr(curves, name) / scale for name in PARTS}
        self.curve.data = {"strain": curves.strain, **forces}
        # pressures of the family, save where the chosen one's mark stands
        family, blocked = self._blocked, curves.blocked / scale
        labeled = np.flatnonzero(np.abs(family - blocked) > 0.06 * np.ptp(family))
        labels = [self._family.data["label"][i] for i in labeled]
        heights = family[labeled]
        self._family_names.data = {"x": [0.0] * len(labeled), "y": heights, "label": labels}
        strips = region_strips(curves.strain, curves.regions)
        left, right, regions = map(list, zip(*strips, strict=True))
        alphas = [_ALPHAS[i] for i in regions]
        self.strips.data = {"left": left, "right": right, "alpha": alphas}
        # a strip too narrow for its name has none, on a phone's 300 pixels too
        names = [
            REGIONS[i] if end - start > _LETTER * len(REGIONS[i]) * self.top else ""
            for start, end, i in strips
        ]
        heights = [self._label_height] * len(names)
        self.region_names.data = {"x": right, "y": heights, "label": names}
        self._marks.data = curve_marks(curves, self.top, self._high * scale, scale, unit)

    def _show_point(self, view: View, curves: MuscleCurves) -> None:
        strain = min(view.strain, self.top)
        unit, scale = self.unit("force")
        pressure = ui.format_quantity(view.pressure, self.unit("pressure")[0], "pressure", 4)
        force, region = f"{curves.point_force / scale:.4g} {unit}", REGIONS[curves.region]
        point, marks = f"at a contraction of {strain:.4g}, {region}", self._marks.data["label"]
        self.chart.describe(
            f"Force over contraction at {pressure}: {', '.join(marks)}; {force} {point}."
        )
        self._scene.describe(f"Drawing of the muscle {point}.")
        self._point.data = {"x": [strain], "y": [curves.point_force / scale]}
        solid, length = muscle_solid(view.muscle, curves, strain), float(view.muscle.length)
        # a stubby muscle is wider than long; it bows out to its side
        reach = max(0.53 * length, 2.0 * solid.radius), 2.0 * solid.radius + 0.16 * length
        colors, positions = [(self.colors.tube, self.colors.fiber)], [(0.0, 0.0, 0.0)]
        self._scene.show([solid], colors, self.colors.fitting, positions, reach, (strain, length))
        # the volume is a straight muscle's of this length: no law has that of a bent one
        fluid = "fluid" if curves.region in _STRAIGHT else "fluid, if it were straight"
        length_unit, length_scale = self.unit("length")
        arm = "m" if length_unit == "mm" else length_unit  # N·m, the field's unit
        moment = curves.moment / (scale * ui.unit_factor(arm, "length"))
        volume, volume_scale = ui.volume_unit(length_unit)
        rows = {
            "force": force,
            "state": region + ", other equilibria exist" * curves.several,
            fluid: f"{curves.volume / volume_scale:.4g} {volume}",
            "braid angle": pretty(solid.angle, "angle"),
            "radius": f"{solid.radius / length_scale:.4g} {length_unit}",
            "deflection": f"{curves.deflection / length_scale:.4g} {length_unit}",
            "bending moment": f"{moment:.4g} {unit}·{arm}",
        }
        if branches := branches_text(curves.strain, curves.branches):
            rows["several equilibria"] = branches
        self._numbers.object = ui.heading("At this point") + ui.readout_table(rows)

"""Tab of efficiency: maps over the force-strain space, and averages by number of motor units."""

from functools import lru_cache
from typing import ClassVar

import numpy as np
import panel as pn
from bokeh.models import ColorBar, LinearColorMapper, Title
from bokeh.palettes import Cividis256

from ..bundle.energetics import (
    PATHS,
    average_efficiency,
    constant_cross_section,
)
from ..bundle.schemes import SCHEMES
from ..muscle import Muscle
from ..plot.resistance_loss import Maps, efficiency_maps
from ..plot.theme import CLEAR, FIGURES, Colors
from .chart import Chart, padded_range, screen_height
from .remarks import remarks_html, words_html
from .state import MAPS, Session, View, changed, scaled_muscle
from .tab import LatestResult, Tab
from .theme import column, pane, row
from .widgets import dropdown, html_table, status_line


COUNTS = (1, 2, 3, 4, 5)  # of motor units; the first is the single equivalent motor unit
_LEAST_SCALE = 0.001  # of efficiency: less can't be read from a map
_NO_PATH = (
    "With free recruitment, many pressures of the motor units give one force and contraction, so"
    " that no path is isobaric: choose the path isotonic."
)
_LABELS: dict[str, str] = dict(zip(
    MAPS, ("with resistance", "without resistance", "loss due to resistance"), strict=True
))  # fmt: skip


def equivalent_muscle(view: View) -> Muscle:
    """The view's muscle, scaled to the cross-section of the whole bundle; same length."""
    radius = float(view.muscle.outer_radius)
    total = sum(unit.count * float(view.muscle_of(unit).outer_radius) ** 2 for unit in view.units)
    return scaled_muscle(view.muscle, float(np.sqrt(total)) / radius)


@lru_cache(maxsize=16)  # visitors share it
def average_efficiencies(muscle: Muscle, supply: float, path: str) -> dict[bool, np.ndarray]:
    """Average efficiency [-] of each number of units in `COUNTS`, with resistance under `True`."""
    bundles = [constant_cross_section(muscle, count, supply) for count in COUNTS]
    return {
        resistance: np.array([
            average_efficiency(bundle, path=path, resistance=resistance) for bundle in bundles
        ])
        for resistance in (True, False)
    }  # fmt: skip


class EfficiencyView(Tab):
    """Widgets and figures of efficiency."""

    name: ClassVar[str] = "efficiency"
    fields: ClassVar[tuple[str, ...]] = (
        "muscle", "units", "supply", "scheme", "display_units", "path", "distance",
    )  # fmt: skip

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self._result: Maps | None = None
        self._path = dropdown("Path", PATHS, lambda path: session.change(path=path), width=200)
        kinds = {label: kind for kind, label in _LABELS.items()}
        self._kind = dropdown("Map", kinds, lambda kind: session.change(map=kind), width=230)
        self._add_map_chart()
        self._make_averages_chart()
        self._numbers, self._strip_note = pane(), pane(width=330)
        self.maps = LatestResult(self._show_maps, self.fail)
        self.averages = LatestResult(self._show_averages, self.fail)
        # a figure itself would lose its height while it loads
        self.figures = [
            column(chart.new_pane(), kind="equal")
            for chart in (self.map_chart, self.averages_chart)
        ]
        columns = row(*self.figures)
        choices = row(self._path, self._kind, self._numbers, self._strip_note, kind="wrapped",
                      sizing_mode=None)  # fmt: skip
        explanations = pane(words_html("efficiency", "isobaric", "isotonic", "resistance"))
        self.panel = column(
            choices, self.message.pane, self.notes, self.status, columns, explanations
        )

    def draw(self, view: View) -> None:
        """Draw all that the tab shows of a `view`."""
        self._path.value, self._kind.value = view.path, view.map
        self.notes.object = remarks_html(view, "efficiency")
        if SCHEMES[view.scheme].independent and view.path == "isobaric":
            self.fail(_NO_PATH)
            return
        self.status.object = status_line("computing the map")
        for figure in self.figures:
            figure.visible = figure.loading = True
        self.maps.request(lambda: efficiency_maps(view.bundle, view.path))

    def follow(self, before: View, after: View) -> None:
        """Show another map."""
        if changed(before, after, "map"):
            self._kind.value = after.map
            self._show_map()

    def fail(self, error: ValueError | str) -> None:
        """Show the error of a computation in place of the figures."""
        super().fail(error)
        self.maps.drop()
        self.averages.drop()
        self._numbers.object = self._strip_note.object = ""
        for figure in self.figures:
            figure.visible = figure.loading = False

    def _add_map_chart(self) -> None:
        """Add the map of efficiency over contraction and force."""
        colors = self.colors
        chart = self.map_chart = Chart(
            colors, "Contraction ε [–]", "Force F [N]", screen_height(320)
        )
        self._mapper = LinearColorMapper(palette=Cividis256, low=0, high=1, nan_color=CLEAR)
        columns = ("image", "x", "y", "dw", "dh")
        self._image = chart.new_source(" ".join(columns), "efficiency")
        chart.figure.image(*columns, source=self._image, color_mapper=self._mapper)
        self._hover = chart.add_hover([])
        self._strips = chart.add(
            "patches", "xs ys", "strips", fill_alpha=0, line_color=colors.curves[1], line_width=1.5
        )
        bar = ColorBar(
            color_mapper=self._mapper, major_label_text_color=colors.ink,
            background_fill_color=colors.paper, major_tick_line_color=colors.paper, width=12,
        )  # fmt: skip
        chart.figure.add_layout(bar, "right")
        self._bar_title = Title(
            text="Efficiency η [–]", align="center", text_color=colors.ink, text_font=FIGURES,
            text_font_style="normal", text_font_size="14px",
        )  # fmt: skip
        chart.figure.add_layout(self._bar_title, "right")  # the bar's own would stand at its foot

    def _make_averages_chart(self) -> None:
        colors = self.colors
        label = "Motor units in the same cross-section"
        chart = self.averages_chart = Chart(
            colors, label, "Average efficiency [–]", screen_height(320)
        )
        self._means = {}
        for resistance, dash, color, marker in (
            (True, "solid", colors.curves[0], "circle"),
            (False, "dashed", colors.curves[1], "square"),
        ):
            source = chart.new_source("x y", f"average_{resistance}".lower())
            both = {
                "source": source,
                "legend_label": f"with{'' if resistance else 'out'} resistance",
            }
            chart.figure.line("x", "y", line_color=color, line_dash=dash, line_width=2.4, **both)
            chart.figure.scatter("x", "y", color=color, marker=marker, size=9, **both)
            self._means[resistance] = source
        chart.figure.xaxis.ticker = list(COUNTS)
        chart.style_legend("bottom_right")

    def _show_maps(self, result: Maps) -> None:
        """Show the chosen map and this bundle's averages, and request those by number of units."""
        self._result = result
        self.figures[0].loading = False
        self._show_map()
        view = self.session.view
        self.message.show("")
        self._numbers.object = html_table(
            ("this bundle", "average efficiency"),
            [("with resistance", f"{result.resisted.average:.4f}"),
             ("without", f"{result.free.average:.4f}")],
        )  # fmt: skip
        self.status.object = status_line("computing averages by number of units")
        muscle = equivalent_muscle(view)
        self.averages.request(lambda: average_efficiencies(muscle, view.supply, view.path))

    def _show_map(self) -> None:
        if self._result is None:
            return
        result, kind = self._result, self.session.view.map
        unit, scale = self.unit("force")
        is_loss, loss = kind == "loss", result.difference[result.changes_state]
        values = getattr(result, kind).efficiency
        strips = result.resistance_gaps if is_loss else ()
        note = (
            (
                "In the outlined strip, which is thinner than a cell, resistance makes another"
                f" recruitment state necessary: it takes {loss.min():.2g} to {loss.max():.2g}."
            )
            if strips and loss.size
            else ""
        )
        strain, force = result.resisted.strain, result.resisted.force / scale
        strain_step, force_step = strain[1] - strain[0], force[1] - force[0]
        finite = values[np.isfinite(values)]
        low, high = min(0.0, finite.min(initial=0.0)), finite.max(initial=-np.inf)
        with pn.io.unlocked():
            # a map of nothing, or of zeros, needs a scale all the same
            high = max(float(high), _LEAST_SCALE) if finite.size else 1.0
            self._mapper.update(low=float(low), high=high)
            self._bar_title.text = "Loss of η [–]" if is_loss else "Efficiency η [–]"
            self._strip_note.object = status_line(note)
            self._strips.data = {
                "xs": [x for x, _ in strips], "ys": [y / scale for _, y in strips]
            }  # fmt: skip
            self._image.data = {
                "image": [np.asarray(values, dtype=np.float32)],
                "x": [strain[0] - strain_step / 2], "y": [force[0] - force_step / 2],
                "dw": [strain[-1] - strain[0] + strain_step],
                "dh": [force[-1] - force[0] + force_step],
            }  # fmt: skip
            self.map_chart.set_ranges(
                (0.0, float(strain[-1] + strain_step)), (0.0, float(force[-1] + force_step))
            )
            self.map_chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
            point = [("ε", "$x{0.000}"), ("F", f"$y{{0.0}} {unit}")]
            self.map_chart.describe(
                f"Map of the efficiency over contraction and force, {_LABELS[kind]}: {low:.3g} to"
                f" {high:.3g}, up to {force[-1]:.4g} {unit}."
            )
            self._hover.tooltips = [("η", "@image{0.000}"), *point]

    def _show_averages(self, averages: dict[bool, np.ndarray]) -> None:
        self.figures[1].loading = False
        for resistance, values in averages.items():
            self._means[resistance].data = {"x": list(COUNTS), "y": values}
        lists = (", ".join(f"{x:.3f}" for x in averages[key]) for key in (True, False))
        self.averages_chart.describe(
            "Average efficiency of {} to {} motor units: {} with resistance; {} without.".format(
                COUNTS[0], COUNTS[-1], *lists
            )
        )
        values = np.concatenate(list(averages.values()))
        counts = (COUNTS[0] - 0.3, COUNTS[-1] + 0.3)
        self.averages_chart.set_ranges(counts, padded_range(values, 0.1, 0.005))
        self.status.object = ""

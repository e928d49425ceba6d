"""Map of a bundle's efficiency over contraction and force, computed when it is asked for."""

import numpy as np
import panel as pn
from bokeh.models import ColorBar, LinearColorMapper, Title
from bokeh.palettes import Cividis256

from ..bundle.energetics import PATHS
from ..bundle.schemes import SCHEMES
from ..plot.resistance_loss import Maps, efficiency_maps
from ..plot.theme import CLEAR, FIGURES, Colors
from .chart import Chart, screen_height
from .remarks import words_html
from .state import MAPS, Session, View
from .tab import LatestResult, Tab
from .theme import column, pane, row
from .widgets import Message, dropdown, html_table, status_line, widget


_LEAST_SCALE = 0.001  # of efficiency: less can't be read from a map
_NO_PATH = (
    "With free recruitment, many pressures of the motor units give one force and contraction, so"
    " that no path is isobaric: choose the path isotonic."
)
_LABELS: dict[str, str] = dict(zip(
    MAPS, ("with resistance", "without resistance", "loss due to resistance"), strict=True
))  # fmt: skip


class EfficiencyChart:
    """Map as the layout `panel` of a `tab`, below a button that shows it."""

    def __init__(self, tab: Tab, session: Session, colors: Colors):
        self._tab, self._session = tab, session
        self._result: Maps | None = None
        self._path = dropdown("Path", PATHS, lambda path: session.change(path=path), width=200)
        kinds = {label: kind for kind, label in _LABELS.items()}
        self._kind = dropdown("Map", kinds, lambda kind: session.change(map=kind), width=230)
        self._add_chart(colors)
        self._numbers, self._strip_note = pane(), pane(width=330)
        self.message = Message()
        # a figure itself would lose its height while it loads
        self.figure = column(self.chart.new_pane())
        self.maps = LatestResult(self._show_maps, self._fail, is_open=tab.is_open)
        self.toggle = widget(
            pn.widgets.Toggle, "More: efficiency", lambda _: self.draw(session.view),
            margin=(8, 8), sizing_mode=None,
        )  # fmt: skip
        choices = row(self._path, self._kind, self._numbers, self._strip_note, kind="wrapped",
                      sizing_mode=None)  # fmt: skip
        explanations = pane(words_html("efficiency", "isobaric", "isotonic", "resistance"))
        self._content = column(choices, self.message.pane, self.figure, explanations, visible=False)
        self.panel = column(self.toggle, self._content)

    def draw(self, view: View) -> None:
        """Request the maps of a `view`, where they are shown."""
        self._content.visible = self.toggle.value
        self._path.value, self._kind.value = view.path, view.map
        if not self.toggle.value:
            return
        if SCHEMES[view.scheme].independent and view.path == "isobaric":
            self._fail(_NO_PATH)
            return
        self.figure.visible = self.figure.loading = True
        self.maps.request(lambda: efficiency_maps(view.bundle, view.path))

    def _show_map(self) -> None:
        """Show the map that the session's view names."""
        if self._result is None:
            return
        result, kind = self._result, self._session.view.map
        unit, scale = self._tab.unit("force")
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
            self.chart.set_ranges(
                (0.0, float(strain[-1] + strain_step)), (0.0, float(force[-1] + force_step))
            )
            self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
            point = [("ε", "$x{0.000}"), ("F", f"$y{{0.0}} {unit}")]
            self.chart.describe(
                f"Map of the efficiency over contraction and force, {_LABELS[kind]}: {low:.3g} to"
                f" {high:.3g}, up to {force[-1]:.4g} {unit}."
            )
            self._hover.tooltips = [("η", "@image{0.000}"), *point]

    def _fail(self, error: ValueError | str) -> None:
        """Show the error of a computation in place of the figure."""
        self.maps.drop()
        self._result = None
        self._numbers.object = self._strip_note.object = ""
        self.figure.visible = self.figure.loading = False
        self.message.show(error, self._session.view.display_units)

    def _add_chart(self, colors: Colors) -> None:
        chart = self.chart = Chart(colors, "Contraction ε [–]", "Force F [N]", screen_height(320))
        self._mapper = LinearColorMapper(palette=Cividis256, low=0, high=1, nan_color=CLEAR)
        columns = ("image", "x", "y", "dw", "dh")
        self._image = chart.new_source(" ".join(columns), "efficiency")
        chart.figure.image(*columns, source=self._image, color_mapper=self._mapper)
        self._hover = chart.add_hover([])
        self._strips = chart.add(
            "patches", "xs ys", "strips", fill_alpha=0, line_color=colors.ink, line_width=1.5
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

    def _show_maps(self, result: Maps) -> None:
        """Show the chosen map and this bundle's averages."""
        self._result = result
        self.figure.loading = False
        self.message.show("")
        self._numbers.object = html_table(
            ("this bundle", "average efficiency"),
            [("with resistance", f"{result.resisted.average:.4f}"),
             ("without", f"{result.free.average:.4f}")],
        )  # fmt: skip
        self._show_map()

"""The efficiency's tab: maps over the force-strain space, and averages by number of states."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.models import ColorBar, HoverTool, LinearColorMapper, Title
from bokeh.palettes import Cividis256

from ..bundle import Bundle
from ..energetics import (
    PATHS,
    EfficiencyMap,
    average_efficiency,
    constant_cross_section,
    efficiency_map,
)
from ..muscle import Muscle
from ..plot.theme import CLEAR, FIGURES
from .background import Latest, shared
from .reversal_tab import grid
from .state import Session, View, scaled
from .tab import Tab, card, moving, remarks, status
from .theme import (
    NARROW,
    STACKED,
    TALL,
    WRAPPED,
    Look,
    half,
    legend_style,
    plain_figure,
    set_range,
    source_of,
)
from .widgets import choice, factor


_SHOWN = {"with resistance": "resisted", "without resistance": "free",
          "what resistance takes": "difference"}  # fmt: skip
# what stands where the map and the averages will be, and on what they wait
_AWAITED = {
    "Drawing the map …": "How much of the fluid's energy becomes work, at every strain and force"
    " that this bundle reaches: with its muscles' resistance, and without.",
    "Averages come next …": "What more motor units in the same cross-section save.",
}


STATES = (1, 2, 3, 4, 5)  # the first is the single equivalent motor unit, the SEMU


@dataclass(frozen=True)
class Maps:
    """Maps along one `path` [-]: `resisted`, and `free` of resistance."""

    path: str
    resisted: EfficiencyMap
    free: EfficiencyMap

    @property
    def difference(self) -> np.ndarray:
        """What resistance takes [-], over the points that both reach."""
        return self.free.efficiency - self.resisted.efficiency


def maps(bundle: Bundle, path: str) -> Maps:
    """The maps of a `bundle` [-] along a `path` [-], on the points of the one with resistance."""
    resisted = efficiency_map(bundle, path=path, resistance=True)
    free = efficiency_map(
        bundle, path=path, force=resisted.force, strain=resisted.strain, resistance=False
    )
    return Maps(path, resisted, free)


def semu(view: View) -> Muscle:
    """The one muscle whose cross-section is that of all of the bundle's [-]."""
    radius = float(view.muscle.outer_radius)
    total = sum(unit.count * float(view.muscle_of(unit).outer_radius) ** 2 for unit in view.units)
    return scaled(view.muscle, float(np.sqrt(total)) / radius)


def averages(whole: Muscle, supply: float, path: str) -> dict[bool, np.ndarray]:
    """Average efficiency [-] of `STATES` equal units in a muscle's section, by resistance.

    **Arguments:**

    - `whole`: the muscle, a bundle's `semu` [-].
    - `supply`: the supply's pressure [Pa].
    - `path`: "isobaric" or "isotonic" [-].

    **Returns:** averages [-], with resistance under `True`.
    """
    return {
        resistance: np.array([
            average_efficiency(
                constant_cross_section(whole, count, supply), path=path, resistance=resistance
            )
            for count in STATES
        ])
        for resistance in (True, False)
    }  # fmt: skip


class EfficiencyView(Tab):
    """Widgets and figures of efficiency."""

    name: ClassVar[str] = "efficiency"
    fields: ClassVar[tuple[str, ...]] = (
        "muscle", "units", "supply", "scheme", "shown", "path", "distance",
    )  # fmt: skip

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        super().__init__(session, look)
        self._silent, self._last = False, None
        self._path = choice(look, "Path", list(PATHS), width=200, sizing_mode=None)
        self._path.param.watch(self._along, "value")
        self._kind = choice(look, "Map", _SHOWN, width=230, sizing_mode=None)
        self._kind.param.watch(lambda _: self._other_map(), "value")
        self._draw_figures()
        self._status = pn.pane.HTML("", margin=(0, 8), height=22)
        self._notes = pn.pane.HTML("", sizing_mode="stretch_width", margin=(0, 8))
        self._numbers = pn.pane.HTML("", margin=(0, 8))
        self._maps = Latest(self._show, self._failed)
        self._averages = Latest(self._show_averages, self._failed)
        self._waits = [
            card(title, text, pn.pane.HTML(moving(title), sizing_mode="stretch_width"))
            for title, text in _AWAITED.items()
        ]
        self._figures = [
            pn.Column(
                pn.pane.Bokeh(one, margin=0, stylesheets=[TALL]), margin=0, visible=False,
                sizing_mode="stretch_width", stylesheets=[NARROW],
            )
            for one in (self.figure, self._bars)
        ]  # fmt: skip
        self.panel = pn.Column(
            pn.Row(
                self._path, self._kind, self._numbers, margin=0, stylesheets=[WRAPPED]
            ),
            self.message.pane, self._notes, self._status,
            pn.Row(*(pn.Column(*both, margin=0, **half())
                     for both in zip(self._waits, self._figures, strict=True)),
                   sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]),
            sizing_mode="stretch_width", margin=0,
        )  # fmt: skip

    def draw(self, view: View) -> None:
        """Show a `view` [-]."""
        self._silent = True
        self._path.value = view.path
        self._silent = False
        self._notes.object = remarks(view, "efficiency")
        self._status.object = status("computing the map")
        self._maps.ask(lambda: shared(maps, view.bundle, view.path))

    def _along(self, event: Any) -> None:
        if not self._silent:
            self.session.change(path=event.new)

    def _failed(self, text: str) -> None:
        self._status.object = ""
        self.message.say(text)
        for one in self._waits:
            one.visible = False

    def _there(self, which: int) -> None:
        """Show the figure `which` [-] waited for, in place of its card."""
        self._waits[which].visible, self._figures[which].visible = False, True

    def _draw_figures(self) -> None:
        look = self.look
        fig = plain_figure(look, "Contraction ε [–]", "Force F [N]", room=320)
        self.figure = fig
        self._colors = LinearColorMapper(palette=Cividis256, low=0, high=1, nan_color=CLEAR)
        self.image = source_of(
            {"image": [], "x": [], "y": [], "dw": [], "dh": []}, name="efficiency"
        )
        drawn = fig.image(
            "image", "x", "y", "dw", "dh", source=self.image, color_mapper=self._colors
        )
        bar = ColorBar(
            color_mapper=self._colors, major_label_text_color=look.ink,
            background_fill_color=look.paper, width=12,
        )  # fmt: skip
        fig.add_layout(bar, "right")
        name = Title(
            text="Efficiency η [–]", align="center", text_color=look.ink, text_font=FIGURES,
            text_font_style="normal", text_font_size="14px",
        )  # fmt: skip
        fig.add_layout(name, "right")  # the bar's own would stand at its foot
        self._hover = HoverTool(renderers=[drawn])
        fig.add_tools(self._hover)
        self._bars = plain_figure(
            look,
            "Motor units in the same cross-section (1: a single one)",
            "Average efficiency [–]",
            room=320,
        )
        self._means = {}
        for resistance, dash, color, marker in (
            (True, "solid", look.curves[0], "circle"), (False, "dashed", look.curves[1], "square"),
        ):  # fmt: skip
            source = source_of({"x": [], "y": []}, name=f"average_{resistance}".lower())
            label = f"with{'' if resistance else 'out'} resistance"
            self._bars.line("x", "y", source=source, color=color, line_dash=dash, line_width=2.4,
                            legend_label=label)  # fmt: skip
            self._bars.scatter("x", "y", source=source, color=color, marker=marker, size=9,
                               legend_label=label)  # fmt: skip
            self._means[resistance] = source
        self._bars.xaxis.ticker = list(STATES)
        set_range(self._bars.x_range, STATES[0] - 0.3, STATES[-1] + 0.3)
        legend_style(self._bars, look, "bottom_right")

    def _show(self, found: Maps) -> None:
        self._last = found
        self._there(0)
        self._show_map()
        view = self.session.view
        self.message.say("")
        with_it, without = found.resisted.average, found.free.average
        self._numbers.object = grid(
            ("this bundle", "average efficiency"),
            [("with resistance", f"{with_it:.4f}"), ("without", f"{without:.4f}")],
        )
        self._status.object = status("computing averages by number of units")
        self._averages.ask(lambda: shared(averages, semu(view), view.supply, view.path))

    def _other_map(self) -> None:
        with pn.io.unlocked():
            self._show_map()

    def _show_map(self) -> None:
        found = self._last
        if found is None:
            return
        unit = self.session.view.shown["force"]
        kind = self._kind.value
        values = found.difference if kind == "difference" else getattr(found, kind).efficiency
        strain, force = found.resisted.strain, found.resisted.force / factor(unit, "force")
        d_strain, d_force = strain[1] - strain[0], force[1] - force[0]
        largest = float(np.nanmax(values)) if np.isfinite(values).any() else 1.0
        least = min(0.0, float(np.nanmin(values))) if np.isfinite(values).any() else 0.0
        self._colors.update(low=least, high=max(largest, 1e-6))
        self.image.data = {
            "image": [np.asarray(values, dtype=np.float32)],
            "x": [strain[0] - d_strain / 2], "y": [force[0] - d_force / 2],
            "dw": [strain[-1] - strain[0] + d_strain], "dh": [force[-1] - force[0] + d_force],
        }  # fmt: skip
        set_range(self.figure.x_range, 0.0, float(strain[-1] + d_strain))
        set_range(self.figure.y_range, 0.0, float(force[-1] + d_force))
        self.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        at = [("ε", "$x{0.000}"), ("F", f"$y{{0.0}} {unit}")]
        self._hover.tooltips = [("η", "@image{0.000}"), *at]

    def _show_averages(self, found: dict[bool, np.ndarray]) -> None:
        self._there(1)
        for resistance, values in found.items():
            self._means[resistance].data = {"x": list(STATES), "y": values}
        low = min(float(values.min()) for values in found.values())
        high = max(float(values.max()) for values in found.values())
        room = max(0.1 * (high - low), 0.005)
        set_range(self._bars.x_range, STATES[0] - 0.3, STATES[-1] + 0.3)
        set_range(self._bars.y_range, low - room, high + room)
        self._status.object = ""

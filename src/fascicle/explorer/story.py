"""Story in four scenes: a muscle pulls, buckles and folds; a second unit shortens a bundle's reach.

A scene sets the inputs of its tab; its sentences follow the view. At the end the inputs are again
those from before, unless another muscle was opened meanwhile.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import panel as pn

from ..bundle.reversal import reversal
from .muscle_curves import REGIONS, strain_limit
from .state import Session, Unit, View
from .tab import LatestResult, session_document
from .texts import TEXTS
from .widgets import button, column, format_quantity, row, text_html, wide_pane


TITLES = ("It pulls", "It buckles", "It folds", "Feeding a second unit shortens the reach")
# that scenes set
_FIELDS = ("tab", "name", "muscle", "supply", "units", "pressures", "pressure", "strain")
_TEXTS = TEXTS["story"]
_SHARE = 1 / 3  # of the supply, in the muscle's scenes: all three regions are well in the figure
_SECOND_PRESSURE = 60e3  # Pa, of the second unit, where no pressure shortens the reach
_ROUND_PRESSURE = 1e3  # Pa: the next whole kPa past the turn, where the reach is short
_STEPS, _STEP_TIME = 16, 200  # of the second unit's pressure, from zero on; ms of each
_FOCUS = "window.fascicleStory?.(cb_obj.visible)"
_KEEP_FOCUS = "window.fascicleStory?.(true, true)"  # a button with another label is a new element


class Story:
    """Panel of the story: an offer, or a scene with its sentences and buttons."""

    def __init__(self, session: Session, offer: bool = False):
        """Story of a `session`; browsers show an `offer` of it until it is dismissed."""
        self._session, self._before, self.scene = session, session.view, 0
        self._opened, self._changes, self._timer = session.opened, 0, None
        self._text = wide_pane(margin=0, css_classes=["live", "scene-text"])
        self._texts = LatestResult(self._show_text, self._show_error)
        self._views = LatestResult(self._show_view, self._show_error)
        self.back = button("Back", lambda: self._move(-1))
        style = {"color": "primary", "css_classes": ["story-next"]}
        self.next = button("Next", lambda: self._move(1), **style)
        self.next.jscallback(label=_KEEP_FOCUS)
        for move in (self.back, self.next):
            move.js_on_click(code="window.fascicleTop?.()")
        self.skip = button("Skip", self.end)
        buttons = row(self.back, self.next, self.skip, kind="buttons", sizing_mode=None)
        self._running = row(self._text, buttons, kind="stacked scene", visible=False)
        self._running.jscallback(visible=_FOCUS)
        self.panel = column(self._running, kind="story")
        if offer:
            start = self.start_button(_TEXTS["offer"], color="primary")
            dismiss = button("No, thanks", None)
            dismiss.js_on_click(code="fascicleDismiss()")
            self.panel.insert(0, row(start, dismiss, kind="offer"))
        session.watch(self._request_text)

    def start_button(self, label: str, **options: object) -> pn.widgets.Button:
        """A new button with a `label` that starts the story, and dismisses the offer."""
        start = button(label, self.start, **options)
        start.js_on_click(code="window.fascicleDismiss?.(); window.fascicleTop?.()")
        return start

    def start(self) -> None:
        if not self.scene:
            self._before, self._opened = self._session.view, self._session.opened
            self._changes = self._session.changes[0]
        self._show_scene(1)

    def end(self) -> None:
        """Hide the story, and set its inputs as they were before it."""
        self._stop_playing()
        self.scene = 0
        if self._session.opened is self._opened:
            inputs = {name: getattr(self._before, name) for name in (*_FIELDS, "resistance")}
            self._session.show(replace(self._session.view, **inputs))
        self._session.forget_changes(self._changes)
        self._running.visible = False

    def _move(self, step: int) -> None:
        """Show the scene `step` further on, or end the story past either end."""
        if 0 < self.scene + step <= len(TITLES):
            self._show_scene(self.scene + step)
        elif self.scene:
            self.end()

    def _show_scene(self, scene: int) -> None:
        self._stop_playing()
        self.scene, before = scene, self._session.view
        self._running.visible = True
        if scene == len(TITLES):  # seconds, the first time
            self.next.disabled = True
            self._write(scene, _TEXTS["computing"])
        self._views.request(lambda: (scene, scene_view(before, scene)))

    def _show_view(self, result: tuple[int, View]) -> None:
        """Show the inputs of a scene, unless another one was chosen meanwhile."""
        scene, view = result
        if scene != self.scene:
            return
        if scene == len(TITLES) and session_document() is not None:
            self._play(view)
        else:
            self._session.show(view)
        self.next.param.update(label="Done" if scene == len(TITLES) else "Next", disabled=False)

    def _play(self, view: View) -> None:
        """Raise the second unit's pressure from zero to that of a `view`, step by step."""
        first, last, *others = view.pressures
        steps = iter(np.linspace(0.0, last, _STEPS).tolist())

        def step() -> None:
            second = next(steps, None)
            if second is None:
                self._stop_playing()
                self._session.show(view)
                self._request_text(view, view)  # also where the last step has shown the same
                return
            pressures = (first, float(f"{second:.5g}"), *others)
            strain = round(float(view.bundle.free_strain(pressures)), 4)
            self._session.show(replace(view, pressures=pressures, strain=strain))

        # before the first step: the text follows when the last one is shown
        self._timer = pn.state.add_periodic_callback(step, period=_STEP_TIME)
        self._session.show(replace(view, pressures=(first, next(steps), *others)))

    def _stop_playing(self) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None

    def _request_text(self, _: View, view: View) -> None:
        if (scene := self.scene) and self._timer is None:  # no text of a step that is past
            self._texts.request(lambda: (scene, scene_text(view, scene)))

    def _show_text(self, result: tuple[int, str]) -> None:
        if result[0] == self.scene and self._timer is None:
            self._write(*result)

    def _write(self, scene: int, text: str) -> None:
        """Write the `text` of a `scene` under its title."""
        title = f"{scene} of {len(TITLES)}: {TITLES[scene - 1]}"
        more = {1: _TEXTS["promise"], len(TITLES): _TEXTS["why"]}.get(scene, "")
        note = f' <span class="soft">{more}</span>' if more else ""
        self._text.object = f"<h2>{title}</h2><p>{text}{note}</p>"

    def _show_error(self, error: ValueError | str) -> None:
        self._text.object = f"<p>{text_html(str(error))}</p>"


def scene_view(view: View, scene: int) -> View:
    """The `view` with the inputs of a `scene`, counted from 1."""
    if scene == len(TITLES):
        units = view.units if len(view.units) > 1 else (Unit(1), Unit(4))
        view = replace(view, tab="bundle", units=units, resistance=True)
        turn = reversal(view.bundle)
        second = _ROUND_PRESSURE * np.ceil(turn.pressure / _ROUND_PRESSURE)
        second = second if turn.depth > 0 else _SECOND_PRESSURE
        pressures = (view.supply, min(float(second), view.supply), *(0.0,) * (len(units) - 2))
        reach = float(view.bundle.free_strain(pressures))
        return replace(view, pressures=pressures, strain=round(max(reach, 0.0), 4))
    pressure = float(f"{view.supply * _SHARE:.4g}")
    top = strain_limit(view.muscle, view.supply)
    free = min(float(view.muscle.free_strain(pressure)), top)
    collapse = min(float(view.muscle.collapse_strain(pressure)), top)
    strains = (free / 2, (free + collapse) / 2, collapse + (top - collapse) / 3)
    return replace(view, tab="muscle", pressure=pressure, strain=round(strains[scene - 1], 4))


def scene_text(view: View, scene: int) -> str:
    """Sentences of a `scene`, counted from 1, on a `view`, with its numbers."""

    def format_value(value: float, dimension: str) -> str:
        if dimension == "strain":
            return f"{value:#.3g}"
        digits = 4 if dimension == "pressure" else 3
        return format_quantity(value, view.display_units[dimension], dimension, digits)

    return (_reversal_text if scene == len(TITLES) else _muscle_text)(view, format_value)


def _muscle_text(view: View, format_value: Callable[[float, str], str]) -> str:
    """Sentence of the story on the state of the view's muscle."""
    muscle, pressure, strain = view.muscle, view.pressure, view.strain
    response, collapse = muscle.response(pressure, strain), float(muscle.collapse_strain(pressure))
    force, onset = float(response.force), -float(muscle.force(pressure, min(collapse, strain)))
    return _TEXTS[REGIONS[int(response.region)]].format(
        pressure=format_value(pressure, "pressure"),
        strain=format_value(strain, "strain"),
        force=format_value(force, "force"),
        push=format_value(-force, "force"),
        free=format_value(float(muscle.free_strain(pressure)), "strain"),
        collapse=format_value(collapse, "strain"),
        blocked=format_value(float(muscle.blocked_force(pressure)), "force"),
        bow=format_value(float(muscle.deflection(pressure, strain)), "length"),
        onset=format_value(onset, "force"),
        change="falls" if -force < onset else "rises",
    )


def _reversal_text(view: View, format_value: Callable[[float, str], str]) -> str:
    bundle = view.bundle
    if len(view.units) < 2 or view.pressures[0] <= 0:
        return _TEXTS["one unit"]
    first, second = view.pressures[:2]
    states = (first, 0.0, *view.pressures[2:]), view.pressures
    before, reach = (float(bundle.free_strain(P, view.resistance)) for P in states)
    push = -float(bundle.unit_forces(view.pressures, reach, view.resistance)[1])
    # "only" where the numbers that are shown differ
    shorter = reach < before and format_value(reach, "strain") != format_value(before, "strain")
    effect = "resists" if shorter and push > 0 else "reaches"
    return f"{_TEXTS['vented']} {_TEXTS[effect]}".format(
        first=format_value(first, "pressure"),
        second=format_value(second, "pressure"),
        before=format_value(before, "strain"),
        reach=format_value(reach, "strain"),
        push=format_value(push, "force"),
    )

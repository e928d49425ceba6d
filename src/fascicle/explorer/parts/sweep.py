"""A button that moves something on, step by step, until it is pressed again."""

from collections.abc import Callable
from typing import Any

import panel as pn

from .look import Look, widget_css


_PERIOD = 120  # ms from step to step
STEPS = 80  # from one end to the other


class Sweep:
    """The button; `step` is called each time, and says whether to go on."""

    def __init__(self, look: Look, label: str, step: Callable[[], bool]):
        """**Arguments:** `look`: the page's [-]; `label`: what is swept [-]; `step` [-]."""
        self._step, self._timer = step, None
        self.button = pn.widgets.Toggle(stylesheets=[widget_css(look)], margin=(4, 8))
        self.name(label)
        self.button.param.watch(self._pressed, "value")

    def name(self, label: str) -> None:
        """Call it by what is swept: `label` [-]."""
        self.button.label = f"▶ Sweep {label}"

    def _pressed(self, event: Any) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if event.new and pn.state.curdoc is not None:
            self._timer = pn.state.add_periodic_callback(self._on, period=_PERIOD)

    def _on(self) -> None:
        if not self._step():
            self.button.value = False

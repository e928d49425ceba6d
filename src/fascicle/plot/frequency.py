"""Bode diagrams of a plant's linear model and of its pressure loops."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import theme
from .theme import BLACK, CYCLE, DOUBLE, GRAY, LINE_STYLES, styled


if TYPE_CHECKING:
    from ..dynamics import Plant, State

_SLOWEST, _FASTEST = 0.1, 300.0  # Hz: slower is at rest, faster no valve of a muscle follows


@styled
def bode(plant: "Plant", state: "State", controller: Any = None) -> Figure:
    """Figure of gain and phase of a `plant` about a `state` [SI], dead time included: from each
    command to its unit's pressure and to the position; with a cascade as `controller`, of its
    pressure loops, too.
    """
    outputs = ["pressure"] if plant.load.prescribed else ["pressure", "position"]
    model = plant.linearize(state, outputs=outputs)
    frequency = np.geomspace(_SLOWEST, _FASTEST, 500)
    response = model.frequency_response(frequency)
    units = np.arange(plant.units)
    panels = [("pressure over command", "Pa", response[:, units, units].T)]
    if not plant.load.prescribed:
        panels.append(("position over command", plant.load.unit, response[:, -1].T))
    count = len(panels) + (controller is not None)
    width = DOUBLE * min(1.0, 0.2 + count / 3)
    figure, axes = theme.new_figure(2, count, width, 0.6 * DOUBLE, sharex=True)
    for (gain, phase), (_, unit, rows) in zip(axes.T, panels, strict=False):
        for k, values in enumerate(rows):
            color, line = CYCLE[k % len(CYCLE)], LINE_STYLES[k % len(LINE_STYLES)]
            style: dict[str, Any] = {"color": color, "linestyle": line}
            _draw(gain, phase, frequency, values, label=f"unit {k + 1}", **style)
        gain.set_ylabel(f"Gain [{unit}]")
    axes[0, 0].legend(loc="lower left")
    titles = [title for title, *_ in panels]
    if controller is not None:
        gain, phase = axes[:, -1]
        _draw(gain, phase, frequency, controller.loop_response(frequency), color=BLACK)
        gain.axhline(1.0, color=GRAY, linewidth=0.6)
        phase.axhline(-180.0, color=GRAY, linewidth=0.6)
        margins = controller.margins
        gain.set_ylabel("Gain [–]")
        degrees = np.degrees(margins.phase)
        numbers = f"gain × {margins.gain:.3g}, phase {degrees:.0f}°"
        titles.append(f"pressure loop alone, margins:\n{numbers}")
    theme.letters(axes[0], titles)
    for ax in axes[1]:
        ax.set_xlabel("Frequency [Hz]")
    axes[1, 0].set_ylabel("Phase [°]")
    return figure


def _draw(gain: Axes, phase: Axes, frequency: np.ndarray, values: np.ndarray, **style: Any) -> None:
    """Draw gain and phase of the complex `values` at each `frequency` [Hz]."""
    gain.loglog(frequency, np.abs(values), **style)
    phase.semilogx(frequency, np.degrees(np.unwrap(np.angle(values))), **style)

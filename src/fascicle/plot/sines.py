"""Maps of amplitude and frequency, a number in each cell."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from .style import DOUBLE, GRAY, letter, new_figure, styled


class Panel(NamedTuple):
    """One map: its `title` [-], `values` with amplitudes in rows [any unit], whether they `diverge`
    from zero [-], and which cells are `doubtful` [-].
    """

    title: str
    values: np.ndarray
    diverge: bool
    doubtful: np.ndarray


@styled
def sine_maps(
    panels: Sequence[Sequence[Panel]], amplitudes: Sequence[float], frequencies: Sequence[float]
) -> Figure:
    """Rows of maps.

    **Arguments:**

    - `panels`: rows of them [-].
    - `amplitudes`: of their rows [m].
    - `frequencies`: of their columns [Hz].

    **Returns:** the figure [-].
    """
    rows, columns = len(panels), len(panels[0])
    figure, axes = new_figure(rows, columns, DOUBLE, 0.27 * DOUBLE * rows, sharex=True, sharey=True)
    marks = iter("abcdefghijklmnopqrstuvwxyz")
    for line, row in zip(axes, panels, strict=True):
        for ax, panel in zip(line, row, strict=True):
            _map(ax, panel)
            letter(ax, next(marks), panel.title)
    for ax in axes[-1]:
        ax.set_xticks(range(len(frequencies)), [f"{f:g}" for f in frequencies])
        ax.set_xlabel("Frequency [Hz]")
    for ax in axes[:, 0]:
        ax.set_yticks(range(len(amplitudes)), [f"{1e3 * A:g}" for A in amplitudes])
        ax.set_ylabel("Amplitude [mm]")
    return figure


def _map(ax: Axes, panel: Panel) -> None:
    values = np.asarray(panel.values, float)
    if panel.diverge:
        size = max(float(np.max(np.abs(values))), 1e-9)
        how: dict[str, Any] = {"cmap": "RdBu", "norm": TwoSlopeNorm(0.0, -size, size)}
    else:
        how = {"cmap": "Greys", "vmin": 0.0, "vmax": 1.5}
    ax.imshow(values, origin="lower", aspect="auto", alpha=0.6, **how)
    ax.grid(visible=False)
    for (i, j), value in np.ndenumerate(values):
        shown = f"{value:+.0f} %" if panel.diverge else f"{value:.2f}"
        ax.text(j, i, shown, ha="center", va="center", fontsize=6.5)
        if panel.doubtful[i, j]:
            ax.add_patch(
                Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, edgecolor=GRAY, hatch="////",
                          linewidth=0)
            )  # fmt: skip

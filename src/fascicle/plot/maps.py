"""Efficiency over the force-strain space, as a map."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..energetics import EfficiencyMap
from .style import BLACK, GRAY, SINGLE, new_figure, styled
from .theme import WHITE


_LEVELS = np.arange(0.1, 1.0, 0.1)
_LINES = {"colors": BLACK, "linewidths": 0.5}


@styled
def efficiency(found: EfficiencyMap) -> Figure:
    """An efficiency map, with its average in the title.

    **Arguments:** `found`: the map [-].

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(width=SINGLE)
    image = draw_efficiency(axes[0, 0], found, float(np.nanmax(found.efficiency)))
    axes[0, 0].set_title(f"{found.path}: average {found.average:.3f}", loc="left")
    figure.colorbar(image, ax=axes[0, 0], label="Efficiency η [–]", pad=0.02)
    return figure


def draw_efficiency(ax: Axes, found: EfficiencyMap, highest: float) -> Any:
    """The map with contour lines, colors from zero to `highest` [-]; returns the image."""
    strain, force, eta = found.strain, found.force, found.efficiency
    # cividis reads alike to all eyes; a picture inside the vector file, or it is megabytes
    image = ax.pcolormesh(
        strain, force, eta, cmap="cividis", vmin=0, vmax=highest, rasterized=True, shading="nearest"
    )
    for state in range(1, int(found.state.max()) + 1):
        # state by state: lines must not crowd where efficiency jumps
        inside = found.state == state
        if min(eta.shape) > 1:  # a single row or column has no lines
            lines = ax.contour(strain, force, np.where(inside, eta, np.nan), _LEVELS, **_LINES)
            ax.clabel(lines, fmt="%.1f", fontsize=6)
        if state < found.state.max():
            there = inside.any(axis=0)
            edge = force[len(force) - 1 - np.argmax(inside[::-1], axis=0)]
            ax.plot(strain[there], edge[there], color=WHITE, linewidth=1.0)
    ax.set(xlabel="Contraction ε [–]", ylabel="Force F [N]", xlim=(0, None), ylim=(0, None))
    ax.grid(False)
    ax.tick_params(color=GRAY)
    return image

"""A bundle's force-strain space with what is demanded of it."""

import numpy as np
from matplotlib.figure import Figure

from ..bundle.space import Overlap, Space
from ..core.types import Bool, Float
from .space import draw_space
from .style import BLACK, SINGLE, VERMILION, new_figure, styled


_SMALLEST, _LARGEST = 2.0, 6.0  # points, of a mark


@styled
def task(
    found: Space,
    overlap: Overlap | None,
    force: Float[np.ndarray, " point"],
    strain: Float[np.ndarray, " point"],
    weight: Float[np.ndarray, " point"],
    reached: Bool[np.ndarray, " point"],
) -> Figure:
    """A bundle's force-strain space, and the points of a task in it.

    **Arguments:**

    - `found`: its curves and regions [-].
    - `overlap`: what two states reach [-]; or none.
    - `force`: demanded [N].
    - `strain`: at which it is [-].
    - `weight`: how much each point counts [-]; larger marks count more.
    - `reached`: whether the bundle gives it [-]; those it doesn't are crosses, of one size.

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(width=1.4 * SINGLE, height=SINGLE)
    ax = axes[0, 0]
    draw_space(ax, found, overlap)
    sizes = _SMALLEST + (_LARGEST - _SMALLEST) * np.sqrt(weight / weight.max())
    sizes = np.where(reached, sizes, _LARGEST)  # a missed peak isn't to be overlooked
    for mask, mark, color, label in (
        (reached, "o", BLACK, "demanded, reached"),
        (~reached, "x", VERMILION, "demanded, not reached"),
    ):
        if np.any(mask):
            ax.scatter(
                strain[mask], force[mask], s=sizes[mask] ** 2, marker=mark, color=color, zorder=5,
                label=label, linewidths=1.0,
            )  # fmt: skip
    ax.set_xlim(0, max(found.strain[-1], 1.05 * strain.max()))
    ax.set_ylim(0, 1.05 * max(found.high.max(), force.max()))
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure

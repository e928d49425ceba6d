"""The force-strain plane of a bundle: states, their overlap, demands of a task, efficiency."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..bundle.energetics import EfficiencyMap
from ..bundle.recruitment import Overlap, Workspace
from ..core.types import Bool, Float
from . import theme
from .theme import BLACK, CYCLE, DOUBLE, GRAY, VERMILION, in_kilopascals, styled


_THIN, _THICK = 0.4, 2.2  # points, lines of the lowest and the highest pressure
_SMALLEST, _LARGEST = 2.0, 6.0  # points, of a demand's mark
_LEAST_SCALE = 0.001  # of efficiency: less can't be read from a map
_CONTOURS = np.arange(0.1, 1.0, 0.1)  # of efficiency


@styled
def workspace(space: Workspace, overlap: Overlap | None = None, ax: Axes | None = None) -> Figure:
    """Figure of a bundle's workspace, a color for each recruitment state, its `overlap` shaded; on
    the axes `ax`, or in a new figure.
    """
    figure, ax = theme.single_axes(ax, DOUBLE, 0.45 * DOUBLE)
    for state in range(1, len(space.force) + 1):
        color = CYCLE[(state - 1) % len(CYCLE)]
        ax.fill(*space.outline(state), color=color, alpha=0.12, linewidth=0)
    draw_workspace(ax, space, overlap, thick=1.5)
    highest = in_kilopascals(space.supply_pressure)
    ax.set_title(f"{space.scheme} recruitment, up to {highest}", loc="left")
    ax.legend()
    return figure


def draw_workspace(
    ax: Axes, space: Workspace, overlap: Overlap | None = None, thick: float = _THICK
) -> None:
    """Draw curves [N] of all states over strain [-], thicker for higher pressures, and overlap."""
    theme.force_strain_axes(ax)
    label: str | None = "overlap of the states"
    outlines = [] if overlap is None else map(overlap.outline, range(len(overlap.states)))
    for strain, force in outlines:
        if strain.size:
            ax.fill(strain, force, color=theme.YELLOW, alpha=0.6, linewidth=0, label=label)
        label = None
    widths = np.linspace(_THIN, thick, space.level.size)
    for state, curves in enumerate(space.force, start=1):
        color = CYCLE[(state - 1) % len(CYCLE)]
        for curve, width in zip(curves, widths, strict=True):
            ax.plot(space.strain, curve, color=color, linewidth=width)
        ax.lines[-1].set_label(f"recruitment state {state}")
    ax.set_xlim(space.strain[0], space.strain[-1])
    ax.set_ylim(bottom=0)


@styled
def task(
    space: Workspace,
    overlap: Overlap | None,
    force: Float[np.ndarray, " point"],
    strain: Float[np.ndarray, " point"],
    weight: Float[np.ndarray, " point"],
    reached: Bool[np.ndarray, " point"],
    ax: Axes | None = None,
) -> Figure:
    """Figure of a bundle's workspace with the demands of a task: `force` [N] and `strain` [-]; on
    the axes `ax`, or in a new figure.

    A larger `weight` [-] has a larger mark; demands that aren't `reached` are crosses of one size.
    """
    figure, ax = theme.single_axes(ax, 1.4 * theme.SINGLE, theme.SINGLE)
    draw_workspace(ax, space, overlap)
    for curves in space.force:
        # without the first, where the state before ends
        for pressure, blocked in zip(space.level[1:], curves[1:, 0], strict=True):
            ax.annotate(f" {in_kilopascals(pressure)}", (0.0, blocked), fontsize=5, va="bottom")
    sizes = _SMALLEST + (_LARGEST - _SMALLEST) * np.sqrt(weight / weight.max())
    sizes = np.where(reached, sizes, _LARGEST)  # a missed peak must not be overlooked
    for mask, mark, color, label in (
        (reached, "o", BLACK, "demanded, reached"),
        (~reached, "x", VERMILION, "demanded, not reached"),
    ):
        if np.any(mask):
            style: dict[str, Any] = {"marker": mark, "color": color, "label": label, "zorder": 5}
            ax.scatter(strain[mask], force[mask], sizes[mask] ** 2, linewidths=1.0, **style)
    ax.set_xlim(0, max(space.strain[-1], 1.05 * strain.max()))
    ax.set_ylim(0, 1.05 * max(space.high.max(), force.max()))
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


@styled
def efficiency(*maps: EfficiencyMap) -> Figure:
    """Figure of efficiency over force and strain, a panel for each of one or two maps."""
    figure, axes = theme.new_figure(1, len(maps), theme.SINGLE * len(maps), 0.72 * theme.SINGLE)
    for ax, mark, result in zip(axes[0], "ab", maps, strict=False):
        highest = float(np.nanmax(result.efficiency)) if result.state.any() else 1.0
        image = draw_efficiency(ax, result, highest)
        figure.colorbar(image, ax=ax, label="Efficiency η [–]", pad=0.02)
        title = f"{result.path}: average {result.average:.3f}"
        if len(maps) > 1:
            theme.letter(ax, mark, title)
        else:
            ax.set_title(title, loc="left")
    return figure


@styled
def efficiency_loss(loss: EfficiencyMap, gaps: Sequence[tuple[np.ndarray, np.ndarray]]) -> Figure:
    """Figure of the efficiency lost to resistance, the map `loss` [-]; `gaps`: outlines (strain
    [-], force [N]) of what a state reaches without resistance alone.
    """
    figure, axes = theme.new_figure(1, 1, theme.SINGLE, 0.72 * theme.SINGLE)
    ax = axes[0, 0]
    # negative where the map with resistance is the higher one
    finite = loss.efficiency[np.isfinite(loss.efficiency)]
    lowest, highest = finite.min(initial=0.0), max(finite.max(initial=0.0), _LEAST_SCALE)
    image = draw_efficiency(ax, loss, highest, lowest)
    for strain, force in gaps:
        ax.plot(strain, force, color=VERMILION, linewidth=0.8)
    figure.colorbar(image, ax=ax, label="Loss of η [–]", pad=0.02)
    ax.set_title(f"{loss.path}: loss due to resistance", loc="left")
    return figure


def draw_efficiency(ax: Axes, result: EfficiencyMap, highest: float, lowest: float = 0.0) -> Any:
    """Draw a map with contour lines, colors from `lowest` to `highest` [-]; returns the image."""
    strain, force, eta = result.strain, result.force, result.efficiency
    # cividis reads alike to all eyes; a raster image, or a vector file would be megabytes
    style: dict[str, Any] = {"cmap": "cividis", "rasterized": True, "shading": "nearest"}
    image = ax.pcolormesh(strain, force, eta, vmin=lowest, vmax=highest, **style)
    for state in range(1, int(result.state.max()) + 1):
        # state by state: lines must not crowd where efficiency jumps
        inside = result.state == state
        if min(eta.shape) > 1:  # a single row or column has no lines
            lines: dict[str, Any] = {"colors": BLACK, "linewidths": 0.5}
            eta_inside = np.where(inside, eta, np.nan)
            contours = ax.contour(strain, force, eta_inside, _CONTOURS, **lines)
            ax.clabel(contours, fmt="%.1f", fontsize=6)
        if state < result.state.max():
            columns = inside.any(axis=0)
            edge = force[len(force) - 1 - np.argmax(inside[::-1], axis=0)]
            ax.plot(strain[columns], edge[columns], color=theme.WHITE, linewidth=1.0)
    ax.set(xlabel="Contraction ε [–]", ylabel="Force F [N]", xlim=(0, None), ylim=(0, None))
    ax.grid(False)
    ax.tick_params(color=GRAY)
    return image

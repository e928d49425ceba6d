"""The force-strain space of a bundle: curves at constant pressure, states, their overlap."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..bundle.space import Overlap, Space
from .style import (
    CYCLE,
    DOUBLE,
    SINGLE,
    force_strain_axes,
    letter,
    new_figure,
    styled,
)
from .theme import WHITE, YELLOW


_THIN, _THICK = 0.4, 2.2  # lines of the lowest and the highest pressure
_OVERLAP = YELLOW


@styled
def space(found: Space, overlap: Overlap | None = None) -> Figure:
    """A bundle's force-strain space, a color for each recruitment state.

    **Arguments:**

    - `found`: its curves and regions [-].
    - `overlap`: the points that two states reach, shaded [-]; left out, none.

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(width=SINGLE)
    draw_space(axes[0, 0], found, overlap)
    axes[0, 0].legend()
    return figure


@styled
def spaces(
    titled: dict[str, tuple[Space, Overlap | None]],
    near: tuple[tuple[float, float], tuple[float, float]],
    told: int = 2,
) -> Figure:
    """Force-strain spaces side by side, and below each its part `near` the largest strain.

    **Arguments:**

    - `titled`: spaces and overlaps by title [-], at most three.
    - `near`: limits of strain [-] and force [N] of the lower row.
    - `told`: the state whose curves bear their pressures there [-].

    **Returns:** the figure [-].
    """
    columns = len(titled)
    figure, axes = new_figure(2, columns, DOUBLE, 0.8 * DOUBLE)
    marks = iter("abcdef")
    for lower, row in enumerate(axes):
        for ax, (title, (found, overlap)) in zip(row, titled.items(), strict=True):
            draw_space(ax, found, overlap)
            letter(ax, next(marks), title + (", near the largest strain" if lower else ""))
    for ax, (found, _) in zip(axes[1], titled.values(), strict=True):
        ax.set(xlim=near[0], ylim=near[1])
        _tell_pressures(ax, found, told)
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    handles, labels = axes[0, -1].get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: labels[i].startswith("overlap"))
    handles, labels = [handles[i] for i in order], [labels[i] for i in order]
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def draw_space(ax: Axes, found: Space, overlap: Overlap | None = None) -> None:
    """Curves [N] of all states over strain [-], thicker for higher pressures, and `overlap`."""
    force_strain_axes(ax)
    if overlap is not None:
        for pair in range(len(overlap.states)):
            strain, force = overlap.outline(pair)
            if strain.size:
                label = "overlap of the states" if pair == 0 else None
                ax.fill(strain, force, color=_OVERLAP, alpha=0.6, linewidth=0, label=label)
    widths = np.linspace(_THIN, _THICK, found.level.size)
    for state, (curves, color) in enumerate(zip(found.force, CYCLE, strict=False), start=1):
        for i, (curve, width) in enumerate(zip(curves, widths, strict=True), start=1):
            label = f"recruitment state {state}" if i == len(curves) else None
            ax.plot(found.strain, curve, color=color, linewidth=width, label=label)
    ax.set_xlim(found.strain[0], found.strain[-1])
    ax.set_ylim(bottom=0)


def _tell_pressures(ax: Axes, found: Space, state: int) -> None:
    """Write the throttled pressures along the curves of a `state`, those of one line together."""
    (left, right), (_, top) = ax.get_xlim(), ax.get_ylim()
    inside = (found.strain >= left) & (found.strain <= right)
    strain, curves = found.strain[inside], found.force[state - 1][:, inside]
    lines: list[tuple[np.ndarray, list[str]]] = []
    for level, curve in zip(found.level, curves, strict=True):
        words = f"{level / 1e3:.4g}"
        if lines and np.abs(lines[-1][0] - curve).max() < 0.01 * top:
            lines[-1][1].append(words)
        else:
            lines.append((curve, [words]))
    box = {"facecolor": WHITE, "edgecolor": "none", "alpha": 0.85, "pad": 0.2}
    for i, (curve, words) in enumerate(lines):
        # the lowest beneath its line and further on, where no other crosses it
        height = (0.7 if i == 0 else 0.87) * top
        low = strain[curve <= height]
        place = max(float(low[0]) if low.size else right, left + 0.06 * (right - left))
        step = 0.01 * (right - left)
        ends = np.interp([place, place + step], strain, curve)
        ax.text(
            place, ends[0], f"{', '.join(words)} kPa", ha="center", fontsize=6,
            rotation=np.degrees(np.arctan2(ends[1] - ends[0], step)), rotation_mode="anchor",
            transform_rotates_text=True, va="top" if i == 0 else "center", bbox=box,
        )  # fmt: skip

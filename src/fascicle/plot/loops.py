"""Figures of a fit: strokes of its hysteresis loops, and a comparison of laws."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .theme import (
    BLACK,
    BLUE,
    CYCLE,
    DOUBLE,
    GRAY,
    WHITE,
    force_strain_axes,
    in_kilopascals,
    letters,
    new_figure,
    pressure_colors,
    styled,
)


_LAWS = 6  # with a color of their own: more would look alike
_LABEL = 48  # characters of a law's name in a line of the legend
_MARKS = 25  # of a stroke: more touch one another
_DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.2)))
_DOTS: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.8}


class Stroke(NamedTuple):
    """One stroke of a loop at a constant `level` [Pa] or [-].

    - `branch`: 1 contracting or inflating, −1 back.
    - `x`, `force`: strains [-] or pressures [Pa], and forces [N].
    """

    level: float
    branch: int
    x: np.ndarray
    force: np.ndarray


@dataclass(frozen=True, eq=False)
class LoopsPlot:
    """Loops of a record.

    - `kind`: the constant quantity of a loop, "pressure" or "strain".
    - `strokes`: a few loops.
    - `pressure`, `width`: mean width of the loops [N] at each pressure [Pa].
    - `fitted`: width of the fitted friction there [N], or `None`.
    """

    kind: str
    strokes: Sequence[Stroke]
    pressure: np.ndarray
    width: np.ndarray
    fitted: np.ndarray | None


@dataclass(frozen=True, eq=False)
class LawsPlot:
    """Laws compared at a few pressures.

    - `pressure`: of each panel [Pa].
    - `strain`, `force`, `censored`: of the readings [-], [N], a row for each panel.
    - `curve_strain`: of the curves [-], a row for each panel.
    - `laws`: label, error [N] and forces [N] of each law, the best first.
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    censored: np.ndarray
    curve_strain: np.ndarray
    laws: Sequence[tuple[str, float, np.ndarray]]


@styled
def loops(data: LoopsPlot) -> Figure:
    """Figure of loops with both strokes, and of their width over pressure."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.42 * DOUBLE)
    over, width = axes[0]
    levels = sorted({stroke.level for stroke in data.strokes})
    colors = dict(zip(levels, pressure_colors(len(levels)), strict=True))
    scale = 1.0 if data.kind == "pressure" else 1e3
    for stroke in data.strokes:
        contracting = stroke.branch > 0
        over.plot(
            stroke.x / scale, stroke.force, color=colors[stroke.level], marker="o", markersize=3,
            linewidth=0.9, linestyle="-" if contracting else (0, (4, 2)), markeredgewidth=0.7,
            markerfacecolor=colors[stroke.level] if contracting else WHITE,
            markevery=max(1, stroke.x.size // _MARKS),
        )  # fmt: skip
    force_strain_axes(over)
    isometric = data.kind == "strain"
    if isometric:
        over.set_xlabel("Pressure P [kPa]")
    dots = {**_DOTS, "color": BLACK, "label": "mean width"}
    width.plot(data.pressure / 1e3, data.width, **dots)
    if data.fitted is not None:
        width.plot(
            data.pressure / 1e3, data.fitted, color=BLUE, label="fitted friction, full width"
        )
    width.set(xlabel="Pressure P [kPa]", ylabel="Width of the loop [N]")
    width.set_ylim(bottom=min(0.0, float(np.min(data.width))))
    width.legend(loc="best")
    letters(axes, ("loops at one length each" if isometric else "loops at one pressure each",
                   "width of the loops"))  # fmt: skip
    stroke_names = ("inflating", "deflating") if isometric else ("contracting", "extending")
    handles = [
        Line2D([], [], color=GRAY, linewidth=0.9, marker="o", markersize=3, label=stroke_names[0]),
        Line2D([], [], color=GRAY, linewidth=0.9, marker="o", markersize=3, label=stroke_names[1],
               linestyle=(0, (4, 2)), markerfacecolor=WHITE),
        *(Line2D([], [], color=color, linewidth=2,
                 label=f"ε = {level:.3g}" if isometric else in_kilopascals(level))
          for level, color in colors.items()),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


@styled
def laws(data: LawsPlot) -> Figure:
    """Figure of the readings and all laws' curves, a panel for each pressure."""
    count = data.pressure.size
    columns = min(count, 3)
    rows = -(-count // columns)
    best = data.laws[:_LAWS]
    height = rows * 0.27 * DOUBLE + 0.16 * len(best) + 0.4
    figure, axes = new_figure(rows, columns, DOUBLE, height, sharex=True)
    for ax in axes.flat[count:]:
        ax.set_visible(False)
    for i, ax in enumerate(axes.flat[:count]):
        force_strain_axes(ax)
        for _, _, force in data.laws[_LAWS:]:
            ax.plot(data.curve_strain[i], force[i], color=GRAY, linewidth=0.5, alpha=0.6)
        for rank, (_, _, force) in reversed([*enumerate(best)]):
            ax.plot(data.curve_strain[i], force[i], color=CYCLE[rank], linewidth=1.1,
                    linestyle=_DASHES[rank % len(_DASHES)])  # fmt: skip
        for clipped, marker in ((False, "o"), (True, "v")):
            mask = np.isfinite(data.force[i]) & (data.censored[i] == clipped)
            ax.plot(data.strain[i][mask], data.force[i][mask], linestyle="", marker=marker,
                    color=BLACK, markersize=2.6, zorder=3,
                    markerfacecolor="none" if clipped else BLACK)  # fmt: skip
        # a law that is far off must not flatten the others
        low, high = float(np.nanmin(data.force[i])), float(np.nanmax(data.force[i]))
        margin = 0.25 * max(high - low, 1e-9)  # N: forces may all be equal
        ax.set_ylim(low - margin, high + margin)
        if i % columns:
            ax.set_ylabel("")
        if i + columns < count:
            ax.set_xlabel("")
    letters(axes, map(in_kilopascals, data.pressure))
    dots = {**_DOTS, "color": BLACK, "label": "measured (▽: clipped)"}
    handles = [Line2D([], [], **dots)]
    handles += [
        Line2D([], [], color=CYCLE[rank], linestyle=_DASHES[rank % len(_DASHES)],
               label=fill(f"{label}: {rmse:.3g} N", _LABEL))
        for rank, (label, rmse, _) in enumerate(best)
    ]  # fmt: skip
    if other_count := len(data.laws) - len(best):
        handles.append(Line2D([], [], color=GRAY, linewidth=0.5, label=f"{other_count} other laws"))
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure

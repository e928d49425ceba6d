"""Profile likelihoods: how fast a fit gets worse as a parameter is held away from its best.

A parabola that crosses 2.71 twice is a parameter that is known; where the data determine
nothing, all that rises is the prior, over decades.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .style import BLACK, BLUE, DOUBLE, GRAY, SINGLE, VERMILION, letter, new_figure, styled
from .theme import WHITE


CRITICAL = 2.705543454095404  # 90 % of a squared normal deviate
_TOP = 8.0
_DECADES = 20.0  # largest over least value, from which the axis is logarithmic


@dataclass(frozen=True, eq=False)
class Profiled:
    """A parameter's profile, in the unit that it is shown in.

    - `name`, `unit`: of the parameter [-].
    - `value`: where it was held [unit]. `rise`: of the squared deviations there [-].
    - `estimate`: the fitted value [unit].
    - `low`, `high`: ends of its 90 % interval by the covariance [unit].
    - `crosses`: where the profile crosses 2.71 [unit]; infinite where it doesn't.
    - `identifiable`: whether the data know it [-].
    """

    name: str
    unit: str
    value: np.ndarray
    rise: np.ndarray
    estimate: float
    low: float
    high: float
    crosses: tuple[float, float]
    identifiable: bool


@styled
def profiles(profiled: Sequence[Profiled]) -> Figure:
    """The profile of each parameter, a panel each.

    **Arguments:** `profiled`: at least one [-].

    **Returns:** the figure [-].
    """
    columns = 2 if len(profiled) == 4 else min(len(profiled), 3)
    rows = -(-len(profiled) // columns)
    width = SINGLE if columns == 1 else DOUBLE
    figure, axes = new_figure(rows, columns, width, rows * 0.27 * DOUBLE + 0.25, sharey=True)
    for ax in axes.flat[len(profiled) :]:
        ax.set_visible(False)
    for i, (ax, one) in enumerate(zip(axes.flat, profiled, strict=False)):
        _draw(ax, one)
        letter(ax, chr(ord("a") + i), one.name.replace("_", " "))
        if i % columns == 0:
            ax.set_ylabel("Rise of squares Δ [–]")
    figure.legend(handles=_legend(profiled), loc="outside lower center", ncols=len(profiled) + 2)
    return figure


def _draw(ax: Axes, one: Profiled) -> None:
    color = BLUE if one.identifiable else VERMILION
    style = "-" if one.identifiable else (0, (4, 2))
    order = np.argsort(one.value, kind="stable")
    value, rise = one.value[order], np.maximum(one.rise[order], 0.0)
    ax.axhline(CRITICAL, color=GRAY, linewidth=0.8, linestyle=(0, (1, 1.5)))
    ends = [np.clip(x, value[0], value[-1]) for x in one.crosses]
    ax.axvspan(ends[0], ends[1], color=color, alpha=0.12, linewidth=0)
    ax.plot(value, rise, color=color, linestyle=style, marker="o", markersize=2.2)
    # a value may lie outside of what was held, at the end of a step
    left, right = max(one.low, value[0]), min(one.high, value[-1])
    ax.plot([left, right], 2 * [_BAR], color=BLACK, linewidth=1.2, marker="|", markersize=5)
    ax.plot([one.estimate], [_BAR], color=BLACK, marker="o", markersize=3.2)
    if value[0] > 0 and value[-1] > _DECADES * value[0]:
        ax.set_xscale("log")
    ax.set_ylim(2 * _BAR, _TOP)
    ax.set_xlabel(f"[{one.unit or '–'}]", labelpad=1)
    if not one.identifiable:
        ax.text(
            0.5, 0.96, "unidentifiable", color=VERMILION, ha="center", va="top",
            transform=ax.transAxes, weight="bold",
            bbox={"facecolor": WHITE, "alpha": 0.85, "linewidth": 0, "pad": 1.5},
        )  # fmt: skip


_BAR = -0.55  # where the interval by the covariance is drawn, below the profile


def _legend(profiled: Sequence[Profiled]) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = []
    if any(one.identifiable for one in profiled):
        handles.append(Line2D([], [], color=BLUE, marker="o", markersize=2.2, label="profile"))
    if not all(one.identifiable for one in profiled):
        handles.append(Line2D([], [], color=VERMILION, linestyle=(0, (4, 2)), marker="o",
                              markersize=2.2, label="profile, unidentifiable"))  # fmt: skip
    return [
        *handles,
        Line2D([], [], color=GRAY, linewidth=0.8, linestyle=(0, (1, 1.5)), label="2.71"),
        Patch(color=GRAY, alpha=0.25, linewidth=0, label="90 % by profile"),
        Line2D([], [], color=BLACK, linewidth=1.2, marker="o", markersize=3.2,
               label="estimate, 90 % by covariance"),
    ]  # fmt: skip

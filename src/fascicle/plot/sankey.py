"""Where energy went, as bands as wide as it is much: Sankey's diagram, a panel for each balance.

**Source:** Sankey (1898), The thermal efficiency of steam-engines.
"""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

from ..units import figures
from .style import BLACK, CYCLE, DOUBLE, GRAY, letter, new_figure, styled


if TYPE_CHECKING:
    from ..dynamics import Balance

_LEAST = 1e-4  # share of the largest below which a term isn't drawn
_GAP = 0.11  # between labels, of a panel's height: a line of text
_IN, _NODE, _OUT = 0.0, (0.42, 0.46), 1.0


@styled
def energies(balances: "list[Balance]") -> Figure:
    """Balances as bands from what came in to where it went, each panel to a scale of its own.

    **Arguments:** `balances`: those in joules are drawn [J].

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(len(balances), 1, DOUBLE, 0.3 * DOUBLE * len(balances))
    for ax, mark, one in zip(axes[:, 0], "abcdefgh", balances, strict=False):
        total = _draw(ax, one)
        letter(ax, mark, f"{one.name}: {total:.3g} {one.unit} in all")
    return figure


def sides(balance: "Balance") -> tuple[dict[str, float], dict[str, float], list[str]]:
    """Terms that came in and that went out, of a `balance` [J], all positive, the largest first; a
    term that is negative comes in on the other side. With them go the names of those that are too
    small to be drawn.
    """
    into, went = dict(balance.into), dict(balance.went)
    came = {name: x for name, x in into.items() if x > 0}
    came |= {f"{name}, given back": -x for name, x in went.items() if x < 0}
    left = {name: x for name, x in went.items() if x > 0}
    left |= {f"{name}, taken back": -x for name, x in into.items() if x < 0}
    largest = max([*came.values(), *left.values()], default=0.0)
    small = [name for one in (came, left) for name, x in one.items() if x < _LEAST * largest]
    rows = ({k: x for k, x in one.items() if k not in small} for one in (came, left))
    first, second = (dict(sorted(one.items(), key=lambda entry: -entry[1])) for one in rows)
    return first, second, small


def _draw(ax: Axes, balance: "Balance") -> float:
    came, left, small = sides(balance)
    total = max(sum(came.values()), sum(left.values()))
    ax.set_axis_off()
    ax.set_xlim(-0.5, 1.5)
    if not total:
        ax.text(0.5, 0.5, "nothing moved", ha="center", va="center", color=GRAY)
        ax.set_ylim(0, 1)
        return 0.0
    ends = []
    for terms, x, node, side in ((came, _IN, _NODE[0], "right"), (left, _OUT, _NODE[1], "left")):
        widths = np.array(list(terms.values())) / total
        inner = 0.5 + np.sum(widths) / 2 - np.cumsum(widths) + widths / 2
        outer = _spread(widths)
        ends += [*(outer + widths / 2), *(outer - widths / 2)]
        colors = [GRAY] if side == "right" and len(terms) == 1 else CYCLE
        for i, (name, value) in enumerate(terms.items()):
            _band(ax, (x, outer[i]), (node, inner[i]), widths[i], colors[i % len(colors)])
            text = f"{name} {value:.3g} {balance.unit}, {figures(100 * value / total, 2)} %"
            where = x - 0.02 if side == "right" else x + 0.02
            ax.text(where, outer[i], text, ha=side, va="center")
    ax.add_patch(Rectangle((_NODE[0], 0), _NODE[1] - _NODE[0], 1, color=BLACK, linewidth=0))
    low, high = min(*ends, 0.0), max(*ends, 1.0)
    if small:
        ax.text(1.5, low - 0.1, f"too small to be drawn: {', '.join(small)}", ha="right",
                va="top", color=GRAY)  # fmt: skip
        low -= 0.12
    ax.set_ylim(low - 0.05, high + 0.05)
    return total


def _spread(widths: np.ndarray) -> np.ndarray:
    """Middles of bands from top to bottom, so far apart that their labels have room."""
    steps = np.maximum((widths[:-1] + widths[1:]) / 2 + 0.03, _GAP)
    middles = -np.concatenate([[0.0], np.cumsum(steps)])
    return middles - (middles[0] + middles[-1]) / 2 + 0.5


def _band(
    ax: Axes, end: tuple[float, float], node: tuple[float, float], width: float, color: str
) -> None:
    (x, y), (X, Y), h = end, node, width / 2
    middle = (x + X) / 2
    corners = [(x, y + h), (middle, y + h), (middle, Y + h), (X, Y + h), (X, Y - h),
               (middle, Y - h), (middle, y - h), (x, y - h), (x, y + h)]  # fmt: skip
    codes = [Path.MOVETO, *[Path.CURVE4] * 3, Path.LINETO, *[Path.CURVE4] * 3, Path.CLOSEPOLY]
    # a hairline of its own color: the thinnest can still be seen
    ax.add_patch(PathPatch(Path(corners, codes), facecolor=color, alpha=0.75, edgecolor=color,
                           linewidth=0.6))  # fmt: skip

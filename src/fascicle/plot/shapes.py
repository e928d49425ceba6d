r"""A muscle drawn to scale from its laws: tube, braid fibers at their real angle, fittings.

The centerline comes from the muscle's shape law. Fibers can't stretch, so the arc's length
fixes the tube's radius and the angle of the fibers, (2); along the arc a fiber turns by
$\mathrm{d}\varphi = \pm\tan\alpha\,\mathrm{d}s/r$ and is seen where it passes in front.
After collapse both keep their values at collapse, as the law keeps its mesh force, and at
the hinge the walls touch, $2t_0$ high, (23). How the tube goes over to the crease, within a
radius of it, and how many fibers there are, belong to the drawing alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from ..core.validation import to_si
from ..muscle import Muscle
from .style import BLACK, BLUE, DOUBLE, GRAY, new_figure, styled
from .theme import LIGHT, WHITE


ARC_POINTS = 241  # odd, so that one lies at the middle, where a hinge is
_FIBERS = 9  # each way around
Point = tuple[float | int, float | int]  # in millimeters, or points

_TUBE, _FITTING = LIGHT.tube, LIGHT.fitting
_AROUND, _CREASE = 41, 0.8  # points around the hinge; radii over which the tube folds in


@dataclass(frozen=True)
class Outline:
    """What is drawn of a muscle. In [m]: the centerline `z`, `y`, its length so far `along`,
    and how far the tube reaches above and below it; the `normal` [-]; the tube's `radius` [m]
    and the fibers' `angle` [rad].
    """

    z: np.ndarray
    y: np.ndarray
    along: np.ndarray
    above: np.ndarray
    below: np.ndarray
    normal: np.ndarray
    radius: float
    angle: float
    rest_radius: float

    @property
    def lowest(self) -> float:
        """Lowest point of the tube [m]."""
        return float(np.min(self.y - self.below * self.normal[1]))


def outlines(
    muscle: Muscle, pressures: Any, strains: Any, collapse_strains: Any = None
) -> list[Outline]:
    """Outlines of `muscle` at several `pressures` [Pa] and `strains` [-], lengths in [m].

    `collapse_strains` [-] at those pressures are computed if they aren't given.
    """
    P = np.asarray(to_si(pressures, "pressures", "Pa"), float)
    eps = np.asarray(to_si(strains, "strain", "-"), float)
    collapse = np.asarray(
        muscle.collapse_strain(P) if collapse_strains is None else collapse_strains
    )
    # the second of each pair is the last state whose arc the law knows
    pairs = np.stack([eps, np.minimum(eps, collapse)], axis=1)
    lines = muscle.shape(P[:, None], pairs, ARC_POINTS)
    z, y = np.asarray(lines.z), np.asarray(lines.y)
    arcs = np.hypot(np.diff(z[:, 1]), np.diff(y[:, 1])).sum(axis=1)
    arc_strains = 1 - arcs / float(muscle.length)
    radii = np.asarray(muscle.radius(arc_strains))
    angles = np.asarray(muscle.braid.angle_at(arc_strains))
    return [
        outline(
            muscle, z[i, 0], y[i, 0], float(radii[i]), float(angles[i]), bool(eps[i] > collapse[i])
        )
        for i in range(len(eps))
    ]


def outline(
    muscle: Muscle, z: np.ndarray, y: np.ndarray, radius: float, angle: float, collapsed: bool
) -> Outline:
    """The outline of `muscle` around `ARC_POINTS` points `z`, `y` of its centerline [m], its
    tube's `radius` [m] and its fibers' `angle` [rad] known.
    """
    along = np.r_[0.0, np.cumsum(np.hypot(np.diff(z), np.diff(y)))]
    slope = np.arctan2(np.gradient(y, along), np.gradient(z, along))
    above, below = np.full_like(z, radius), np.full_like(z, radius)
    if collapsed:
        # at the hinge one point stands for many, so that the outer wall goes around it
        middle = ARC_POINTS // 2
        repeat = np.ones(ARC_POINTS, int)
        repeat[middle] = _AROUND
        z, y, along, slope, below = (np.repeat(x, repeat) for x in (z, y, along, slope, below))
        turning = slice(middle, middle + _AROUND)
        slope[turning] = np.linspace(slope[middle - 2], slope[middle + _AROUND + 1], _AROUND)
        crease = 2 * float(muscle.wall_thickness) - radius
        away = np.clip(np.abs(along - along[-1] / 2) / (_CREASE * radius), 0, 1)
        above = crease + (radius - crease) * np.sin(np.pi / 2 * away)
    normal = np.stack([-np.sin(slope), np.cos(slope)])
    return Outline(z, y, along, above, below, normal, radius, angle, float(muscle.outer_radius))


@styled
def shapes(muscle: Muscle, states: Mapping[str, tuple[float, float]]) -> Figure:
    """A muscle in several states, one below the other, to one scale.

    **Arguments:**

    - `muscle`: the muscle [-].
    - `states`: pressure [Pa] and strain [-] by title.

    **Returns:** the figure [-].
    """
    pressures, strains = zip(*states.values(), strict=True)
    return draw_states(float(muscle.length), outlines(muscle, pressures, strains), list(states))


@styled
def draw_states(rest_length: float, drawn: list[Outline], titles: list[str]) -> Figure:
    """A figure of a muscle of `rest_length` [m], its outlines `drawn` [m] under `titles` [-]."""
    figure, ax, levels = stack(rest_length, drawn)
    for mark, title, one, level in zip("abcdefgh", titles, drawn, levels, strict=False):
        draw_muscle(ax, one, level)
        name_row(ax, one, level, mark, title)
    return figure


def stack(
    rest_length: float, several: list[Outline], gap: float = 8.0, right: float = 0.0
) -> tuple[Figure, Axes, list[float]]:
    """A figure with axes in millimeters, undistorted and without frame, for muscles of
    `rest_length` [m] one below the other, and their levels [mm]. `gap` and `right` [mm] leave
    room for text.
    """
    half = 1.3 * several[0].rest_radius * 1e3
    levels, level = [], 0.0
    for drawn in several:
        level -= half + gap
        levels.append(level)
        level += min(drawn.lowest * 1e3, -half) - 1
    low, width = level - 1, rest_length * 1e3 + 4 * half + right
    figure, axes = new_figure(1, 1, DOUBLE, DOUBLE * -low / width)
    figure.set_layout_engine("none")
    ax = axes[0, 0]
    ax.set_position((0, 0, 1, 1))
    ax.set_xlim(-2 * half, rest_length * 1e3 + 2 * half + right)
    ax.set_ylim(low, 0)
    ax.axis("off")
    return figure, ax, levels


def name_row(ax: Axes, drawn: Outline, level: float, mark: str, title: str) -> None:
    """A bold `mark` and a `title` above the muscle at `level` [mm]."""
    top = level + 1.3 * drawn.rest_radius * 1e3 + 2.0
    left = -2 * drawn.rest_radius * 1e3
    ax.text(left, top, rf"$\bf{{({mark})}}$  {title}", va="bottom", ha="left")


def draw_muscle(ax: Axes, drawn: Outline, level: float = 0.0, color: str = BLUE) -> None:
    """The tube, its fibers and its two fittings at `level` [mm]."""
    upper, lower = _across(drawn, drawn.above, level), _across(drawn, -drawn.below, level)
    border = np.concatenate([upper, lower[::-1]])
    ax.add_patch(Polygon(border, facecolor=_TUBE, edgecolor="none", zorder=2))
    lines = _fibers(drawn, level)
    fibers = LineCollection(lines, colors=color, linewidths=0.45, alpha=0.75, zorder=3)
    ax.add_collection(fibers, autolim=False)
    for edge in (upper, lower):
        ax.plot(edge[:, 0], edge[:, 1], color=color, linewidth=0.9, zorder=3)
    half, deep = 1.3 * drawn.rest_radius * 1e3, 1.1 * drawn.rest_radius * 1e3
    for corner in (-deep, drawn.z[-1] * 1e3):
        ax.add_patch(Rectangle((corner, level - half), deep, 2 * half, color=_FITTING, zorder=4))


def dimension(ax: Axes, start: Point, end: Point, text: str, side: int = 1) -> None:
    """A dimension line from `start` to `end` [mm], its `text` above or right of it (1), or
    below or left of it (-1).
    """
    arrow = {"arrowstyle": "<|-|>,head_width=0.12,head_length=0.25", "color": BLACK,
             "linewidth": 0.6, "shrinkA": 0, "shrinkB": 0}  # fmt: skip
    ax.annotate("", start, end, arrowprops=arrow, zorder=6)
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    if abs(end[1] - start[1]) > abs(end[0] - start[0]):
        label(ax, middle, text, (3 * side, 0), "left" if side > 0 else "right", "center")
    else:
        label(ax, middle, text, (0, 1.5 * side), "center", "bottom" if side > 0 else "top")


def label(
    ax: Axes,
    place: Point,
    text: str,
    offset: Point = (0, 0),
    ha: str = "left",
    va: str = "center",
) -> None:
    """A `text` at `place` [mm], `offset` by points, readable over the drawing."""
    box = {"facecolor": WHITE, "edgecolor": "none", "alpha": 0.85, "pad": 0.8}
    ax.annotate(
        text, place, offset, textcoords="offset points", ha=ha, va=va, bbox=box, zorder=7
    )  # fmt: skip


def guide(ax: Axes, start: Point, end: Point) -> None:
    """A thin dashed line [mm] that leads the eye."""
    ends = np.array([start, end])
    ax.plot(ends[:, 0], ends[:, 1], color=GRAY, linewidth=0.6, linestyle=(0, (3, 2)), zorder=5)


def _across(drawn: Outline, offset: np.ndarray, level: float) -> np.ndarray:
    """Points [mm] at `offset` [m] across the centerline, the muscle at `level` [mm]."""
    y = drawn.y + offset * drawn.normal[1]
    return np.stack([1e3 * (drawn.z + offset * drawn.normal[0]), 1e3 * y + level], axis=1)


def _fibers(drawn: Outline, level: float) -> list[np.ndarray]:
    """Visible pieces of the braid's fibers, as lists of points [mm]."""
    turns = drawn.along * np.tan(drawn.angle) / drawn.radius
    middle, half = (drawn.above - drawn.below) / 2, (drawn.above + drawn.below) / 2
    pieces = []
    for way in (1, -1):
        for start in 2 * np.pi * np.arange(_FIBERS) / _FIBERS:
            phase = start + way * turns
            points = _across(drawn, middle + half * np.cos(phase), level)
            front = np.sin(phase) >= 0
            cuts = np.flatnonzero(np.diff(front.astype(int))) + 1
            runs = np.split(np.arange(front.size), cuts)
            # one point further, so that a fiber reaches the edge behind which it goes on
            pieces += [points[run[0] : run[-1] + 2] for run in runs if front[run[0]]]
    return [piece for piece in pieces if len(piece) > 1]

r"""A muscle drawn to scale from its laws: tube, braid fibers at their real angle, fittings.

The centerline comes from the muscle's shape law. Fibers can't stretch, so the arc's length
fixes the tube's radius and the angle of the fibers, (2); along the arc a fiber turns by
$\mathrm{d}\varphi = \pm\tan\alpha\,\mathrm{d}s/r$ and is visible where it passes in front.
After collapse both keep their values at collapse, as the law keeps its mesh force, and at
the hinge the walls touch, $2t_0$ high, (23). How the tube goes over to the crease, within a
radius of it, and how many fibers there are, belong to the drawing alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from ..core.validation import to_si
from ..muscle import Muscle
from .theme import BLUE, DOUBLE, LIGHT, new_figure, styled


ARC_POINTS = 241  # odd, so that one lies at the middle, where a hinge is
_FIBERS = 9  # each way around: as many as stay apart in print
# JavaScript of the same in three dimensions: patches that a camera sees
PROJECTION = Path(__file__).with_name("projection.js").read_text(encoding="utf-8")
_HINGE_POINTS, _CREASE = 41, 0.8  # points around the hinge; radii over which the tube folds in


@dataclass(frozen=True)
class Outline:
    """Outline of a muscle. In [m]: the centerline `z`, `y`, its length `along` it, and the height
    of the tube `above` and `below` it; the `normal` [-]; the tube's `radius` [m], the fibers'
    `angle` [rad], and the tube's `rest_radius` [m].
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
    """Outlines to draw of a `muscle`, one at each pair of `pressures` [Pa] and `strains` [-].

    `collapse_strains`: at those pressures [-], past which it is creased; computed by default.
    """
    P = np.asarray(to_si(pressures, "pressures", "Pa"), float)
    eps = np.asarray(to_si(strains, "strain", "-"), float)
    collapse = muscle.collapse_strain(P) if collapse_strains is None else collapse_strains
    collapse = np.asarray(collapse)
    # the second of each pair is the last state with an arc by the law
    pairs = np.stack([eps, np.minimum(eps, collapse)], axis=1)
    centerlines = muscle.shape(P[:, None], pairs, ARC_POINTS)
    z, y = np.asarray(centerlines.z), np.asarray(centerlines.y)
    arcs = np.hypot(np.diff(z[:, 1]), np.diff(y[:, 1])).sum(axis=1)
    arc_strains = 1 - arcs / float(muscle.length)
    radii = np.asarray(muscle.radius(arc_strains)).tolist()
    angles = np.asarray(muscle.braid.angle_at(arc_strains)).tolist()
    rows = zip(z[:, 0], y[:, 0], radii, angles, (eps > collapse).tolist(), strict=True)
    return [outline(muscle, *row) for row in rows]


def outline(
    muscle: Muscle, z: np.ndarray, y: np.ndarray, radius: float, angle: float, collapsed: bool
) -> Outline:
    """Outline of a muscle, creased in the middle if it has `collapsed`. `z`, `y`: its centerline
    at `ARC_POINTS` points [m]; the tube's `radius` [m] and the fibers' `angle` [rad].
    """
    along = np.r_[0.0, np.cumsum(np.hypot(np.diff(z), np.diff(y)))]
    slope = np.arctan2(np.gradient(y, along), np.gradient(z, along))
    upper, below = np.full_like(z, radius), np.full_like(z, radius)
    if collapsed:
        # the hinge is repeated, so that the outer wall goes around it
        middle = ARC_POINTS // 2
        repeat = np.ones(ARC_POINTS, int)
        repeat[middle] = _HINGE_POINTS
        z, y, along, slope, below = (np.repeat(x, repeat) for x in (z, y, along, slope, below))
        end = middle + _HINGE_POINTS
        slope[middle:end] = np.linspace(slope[middle - 2], slope[end + 1], _HINGE_POINTS)
        crease = 2 * float(muscle.wall_thickness) - radius
        distance = np.clip(np.abs(along - along[-1] / 2) / (_CREASE * radius), 0, 1)
        upper = crease + (radius - crease) * np.sin(np.pi / 2 * distance)
    normal = np.stack([-np.sin(slope), np.cos(slope)])
    return Outline(z, y, along, upper, below, normal, radius, angle, float(muscle.outer_radius))


def shapes(muscle: Muscle, states: Mapping[str, tuple[float, float]]) -> Figure:
    """Figure of a muscle in several `states`, pressure [Pa] and strain [-] by title, one below the
    other, to one scale.
    """
    pressures, strains = zip(*states.values(), strict=True)
    return draw_states(float(muscle.length), outlines(muscle, pressures, strains), list(states))


@styled
def draw_states(rest_length: float, states: list[Outline], titles: list[str]) -> Figure:
    """Figure of outlines of a muscle of `rest_length` [m] under `titles`."""
    figure, ax, levels = shape_axes(rest_length, states)
    for mark, title, state, level in zip("abcdefgh", titles, states, levels, strict=False):
        draw_muscle(ax, state, level)
        name_row(ax, state, level, mark, title)
    return figure


def shape_axes(
    rest_length: float, states: list[Outline], gap: float = 8.0, right: float = 0.0
) -> tuple[Figure, Axes, list[float]]:
    """Figure with undistorted axes in millimeters, without frame, and the levels [mm] of muscles of
    a `rest_length` [m]; `gap`, `right`: room for text above each and at the right [mm].
    """
    half = 1.3 * states[0].rest_radius * 1e3
    levels, level = [], 0.0
    for state in states:
        level -= half + gap
        levels.append(level)
        level += min(state.lowest * 1e3, -half) - 1
    low, width = level - 1, rest_length * 1e3 + 4 * half + right
    figure, axes = new_figure(1, 1, DOUBLE, DOUBLE * -low / width)
    figure.set_layout_engine("none")
    ax = axes[0, 0]
    ax.set_position((0, 0, 1, 1))
    ax.set(xlim=(-2 * half, rest_length * 1e3 + 2 * half + right), ylim=(low, 0))
    ax.axis("off")
    return figure, ax, levels


def name_row(ax: Axes, state: Outline, level: float, mark: str, title: str) -> None:
    """Write a bold `mark` and a `title` above the muscle at `level` [mm]."""
    top = level + 1.3 * state.rest_radius * 1e3 + 2.0
    left = -2 * state.rest_radius * 1e3
    ax.text(left, top, rf"$\bf{{({mark})}}$  {title}", va="bottom", ha="left")


def draw_muscle(ax: Axes, state: Outline, level: float = 0.0, color: str = BLUE) -> None:
    """Draw the tube, its fibers and its two fittings at `level` [mm]."""
    upper, lower = _offset(state, state.above, level), _offset(state, -state.below, level)
    border = np.concatenate([upper, lower[::-1]])
    ax.add_patch(Polygon(border, facecolor=LIGHT.tube, edgecolor="none", zorder=2))
    fibers = LineCollection(_fibers(state, level), colors=color, linewidths=0.45, alpha=0.75)
    fibers.set_zorder(3)
    ax.add_collection(fibers, autolim=False)
    for edge in (upper, lower):
        ax.plot(edge[:, 0], edge[:, 1], color=color, linewidth=0.9, zorder=3)
    half, depth = 1.3 * state.rest_radius * 1e3, 1.1 * state.rest_radius * 1e3
    for corner in (-depth, state.z[-1] * 1e3):
        fitting = Rectangle((corner, level - half), depth, 2 * half, color=LIGHT.fitting, zorder=4)
        ax.add_patch(fitting)


def _offset(state: Outline, offset: np.ndarray, level: float) -> np.ndarray:
    """Points [mm] at an `offset` [m] from the centerline of a muscle at `level` [mm]."""
    y = state.y + offset * state.normal[1]
    return np.stack([1e3 * (state.z + offset * state.normal[0]), 1e3 * y + level], axis=1)


def _fibers(state: Outline, level: float) -> list[np.ndarray]:
    """Visible pieces of the braid's fibers, as lists of points [mm]."""
    turn = state.along * np.tan(state.angle) / state.radius
    middle, half = (state.above - state.below) / 2, (state.above + state.below) / 2
    pieces = []
    for sign in (1, -1):
        for start in 2 * np.pi * np.arange(_FIBERS) / _FIBERS:
            phase = start + sign * turn
            points = _offset(state, middle + half * np.cos(phase), level)
            front = np.sin(phase) >= 0
            cuts = np.flatnonzero(np.diff(front.astype(int))) + 1
            runs = np.split(np.arange(front.size), cuts)
            # one point further, so that a fiber reaches the edge behind which it goes on
            pieces += [points[run[0] : run[-1] + 2] for run in runs if front[run[0]]]
    return [piece for piece in pieces if len(piece) > 1]

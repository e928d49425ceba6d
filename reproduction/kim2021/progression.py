"""Four states of Fig. 6's muscle, from rest to past collapse, as in Figs 2 to 5."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.muscle import Muscle
from fascicle.plot.shapes import Outline, draw_muscle, name_row, outlines, shape_axes
from fascicle.plot.theme import BLACK, GRAY, WHITE

from . import setting


PRESSURE = float(setting.PRESSURES[1])  # the lower of Fig. 6's two pressures with all three regions
FREE, BENT, HINGED = 1, 2, 3  # indices of the states; rest is 0
JUST = 0.001  # of strain past the free strain, for the onset of buckling
_NARROW = 12.0  # mm, less than the length's text takes
_FRACTION = 0.9  # between free strain and collapse: clearly bent, not yet collapsed

Point = tuple[float | int, float | int]  # in millimeters, or points


@dataclass(frozen=True)
class Progression:
    """States in order: rest, free strain, post-buckling, post-collapse. Pressure [Pa],
    strain [-] and largest moment [N·m] of each; strains and moments of collapse; and the
    deflection [m] just past the free strain.
    """

    muscle: Muscle
    pressure: np.ndarray
    strain: np.ndarray
    moment: np.ndarray
    outlines: list[Outline]
    free_strain: float
    collapse_strain: float
    collapse_moment: float
    moment_at_collapse: float
    first_deflection: float

    @property
    def free_length(self) -> float:
        """$L_{fs}$ [m]."""
        return float(self.muscle.length) * (1 - self.free_strain)

    def compression(self, state: int) -> float:
        """Compression $x$ of a state past the free strain [m]."""
        return float(self.muscle.length) * (float(self.strain[state]) - self.free_strain)


@setting.cached
def progression() -> Progression:
    """The four states, computed once."""
    muscle = setting.muscle("figure_6")
    P = np.array([0.0, PRESSURE, PRESSURE, PRESSURE])
    collapse = setting.forces("figure_6").collapse_strain[[0, 1, 1, 1]]
    free = float(muscle.free_strain(PRESSURE))
    bent = free + _FRACTION * (collapse[1] - free)
    eps = np.array([0.0, free, bent, setting.tested(muscle)])
    # a fifth state: exactly at collapse, and just past free strain
    pressures = np.r_[P, PRESSURE]
    moments = setting.array(muscle.moment(pressures, np.r_[eps, collapse[1]]))
    shapes = outlines(muscle, pressures, np.r_[eps, free + JUST], np.r_[collapse, collapse[1]])
    return Progression(
        muscle, P, eps, moments[:4], shapes[:4], free, float(collapse[1]),
        float(muscle.collapse_moment(PRESSURE)), float(moments[4]), float(-shapes[4].y.min()),
    )  # fmt: skip


def draw_pair(p: Progression, state: int, title: str) -> tuple[Figure, Axes, float]:
    """Figure of the free strain, (a), and a `state`, (b), its axes, and the level of (b) [mm]."""
    shapes = [p.outlines[FREE], p.outlines[state]]
    figure, ax, (upper, lower) = shape_axes(float(p.muscle.length), shapes, gap=15.0)
    titles = f"free strain, ε = {p.free_strain:.3f}", f"{title}, ε = {p.strain[state]:.3f}"
    for shape, level, mark, text in zip(shapes, (upper, lower), "ab", titles, strict=True):
        draw_muscle(ax, shape, level)
        name_row(ax, shape, level + 6, mark, text)
    L_fs, x = p.free_length * 1e3, p.compression(state) * 1e3
    chord, height = L_fs - x, 1.3 * shapes[0].rest_radius * 1e3 + 3.5
    dimension(ax, (0, upper + height), (L_fs, upper + height), rf"$L_{{fs}}$ = {L_fs:.1f} mm")
    line = lower + height
    dimension(ax, (0, line), (chord, line), rf"$L = L_{{fs}} - x$ = {chord:.1f} mm")
    narrow = x < _NARROW
    dimension(ax, (chord, line), (L_fs, line), "" if narrow else f"$x$ = {x:.1f} mm")
    if narrow:
        ax.text(L_fs + 1.5, line, f"$x$ = {x:.1f} mm", va="center")
    guide(ax, (L_fs, upper - height), (L_fs, line + 1))
    guide(ax, (0, lower), (chord, lower))
    ax.plot(shapes[1].z * 1e3, shapes[1].y * 1e3 + lower, color=BLACK, linewidth=0.7, zorder=5)
    return figure, ax, lower


def dimension(ax: Axes, start: Point, end: Point, text: str, side: int = 1) -> None:
    """Draw a dimension line from `start` to `end` [mm], its `text` above or right of it (1), or
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
    position: Point,
    text: str,
    offset: Point = (0, 0),
    ha: str = "left",
    va: str = "center",
) -> None:
    """Write a `text` at a `position` [mm], `offset` by points, readable over the drawing."""
    box = {"facecolor": WHITE, "edgecolor": "none", "alpha": 0.85, "pad": 0.8}
    ax.annotate(
        text, position, offset, textcoords="offset points", ha=ha, va=va, bbox=box, zorder=7
    )


def guide(ax: Axes, start: Point, end: Point) -> None:
    """Draw a thin dashed guide line [mm]."""
    ends = np.array([start, end])
    ax.plot(ends[:, 0], ends[:, 1], color=GRAY, linewidth=0.6, linestyle=(0, (3, 2)), zorder=5)

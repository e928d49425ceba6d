"""A muscle at its free strain above one of its later states, with the lengths of both."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.plot.shapes import dimension, draw_muscle, guide, name_row, stack
from fascicle.plot.style import BLACK

from .progression import FREE, Progression


_NARROW = 12.0  # mm, too little for the length's text to stand inside


def draw_pair(p: Progression, state: int, title: str) -> tuple[Figure, Axes, float]:
    """The free strain as (a), `state` of the progression as (b); and the level of (b) [mm]."""
    drawn = [p.outlines[FREE], p.outlines[state]]
    figure, ax, (upper, lower) = stack(float(p.muscle.length), drawn, gap=15.0)
    titles = f"free strain, ε = {p.free_strain:.3f}", f"{title}, ε = {p.strain[state]:.3f}"
    for one, level, mark, text in zip(drawn, (upper, lower), "ab", titles, strict=True):
        draw_muscle(ax, one, level)
        name_row(ax, one, level + 6, mark, text)
    L_fs, x = p.free_length * 1e3, p.compression(state) * 1e3
    chord, above = L_fs - x, 1.3 * drawn[0].rest_radius * 1e3 + 3.5
    dimension(ax, (0, upper + above), (L_fs, upper + above), rf"$L_{{fs}}$ = {L_fs:.1f} mm")
    line = lower + above
    dimension(ax, (0, line), (chord, line), rf"$L = L_{{fs}} - x$ = {chord:.1f} mm")
    beside = x < _NARROW
    dimension(ax, (chord, line), (L_fs, line), "" if beside else f"$x$ = {x:.1f} mm")
    if beside:
        ax.text(L_fs + 1.5, line, f"$x$ = {x:.1f} mm", va="center")
    guide(ax, (L_fs, upper - above), (L_fs, line + 1))
    guide(ax, (0, lower), (chord, lower))
    axis = drawn[1]
    ax.plot(axis.z * 1e3, axis.y * 1e3 + lower, color=BLACK, linewidth=0.7, zorder=5)
    return figure, ax, lower

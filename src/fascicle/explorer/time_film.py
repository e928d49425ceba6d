"""Pictures of a run: its charts, and a film of its drawing and charts with a cursor, as a GIF.

The film runs in a worker process. There is no video: matplotlib writes one with a program that is
no dependency of fascicle.
"""

import io
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from PIL import Image

from ..plot.theme import DOUBLE, FIGURES, LIGHT, new_figure, styled
from .time_drawing import ALPHAS, HATCHED, STATES, Drawing, rigid_colors


MOST_FRAMES = 90  # of a film: some megabytes, and ten seconds to draw
_FASTEST = 25.0  # frames a second: browsers show few GIFs faster
_CHART_HEIGHT = 1.3  # inches, of a picture of charts
_SIZE, _DPI = (7.6, 4.8), 100  # inches, and pixels of each
_COLORS = 96  # of a frame: smooth edges, and a file of a megabyte
_LETTERS = 7.5  # points, of labels
_ABOVE = 44.0  # mm from the upper end of the drawing to its upper plate
_DASHES: dict[str, Any] = {
    "solid": "-", "dashed": (0, (4, 2)), "dotted": (0, (1, 1.2)), "dotdash": (0, (1, 2, 5, 2)),
    "dashdot": (0, (6, 2, 1, 2)),
}  # fmt: skip


class Curve(NamedTuple):
    """A curve of a chart: `values` at the samples in the unit shown, `label`, `color`, `dash`."""

    values: np.ndarray
    label: str
    color: str
    dash: str = "solid"
    width: float = 2.0


class ChartCurves(NamedTuple):
    """Curves of a chart with its `title` and `unit`."""

    title: str
    unit: str
    curves: list[Curve]


@styled
def charts_figure(time: np.ndarray, charts: Sequence[ChartCurves]) -> Figure:
    """Figure of `charts` over `time` [s], one below the other."""
    figure, axes = new_figure(len(charts), 1, DOUBLE, _CHART_HEIGHT * len(charts), sharex=True)
    for ax, chart in zip(axes[:, 0], charts, strict=True):
        _draw_chart(ax, time, chart)
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))  # beside the curves
    axes[-1, 0].set_xlabel("Time t [s]")
    return figure


@styled
def film(
    title: str,
    time: np.ndarray,
    drawing: Drawing,
    charts: Sequence[ChartCurves],
    colors: Sequence[str],
) -> bytes:
    """GIF of a run under a `title`, in its real time: `drawing` and `charts` at each `time` [s],
    with the `colors` of units.
    """
    figure, axes = new_figure(len(charts), 2, *_SIZE, width_ratios=[1.0, 1.25])
    figure.set_dpi(_DPI)
    grid = axes[0, 0].get_gridspec()
    for ax in axes[:, 0]:
        ax.remove()
    scene = figure.add_subplot(grid[:, 0])
    for ax, chart in zip(axes[:, 1], charts, strict=True):
        _draw_chart(ax, time, chart)
    cursors = [ax.axvline(time[0], color=LIGHT.ink, linewidth=0.9) for ax in axes[:, 1]]
    axes[-1, 1].set_xlabel("Time t [s]")
    left, right, low, high = drawing.extent
    scene.set(xlim=(left, right), ylim=(low, high), aspect="equal")
    scene.axis("off")
    fills = rigid_colors(LIGHT)
    for polygon, kind in zip(drawing.fixed, drawing.fixed_kinds, strict=True):
        scene.add_patch(Polygon(polygon, color=fills[kind]))
    rigid = [Polygon(drawing.rigid[0, i], color=fills[kind])
             for i, kind in enumerate(drawing.rigid_kinds)]  # fmt: skip
    tubes = [(unit, x, Polygon(drawing.tubes[0, unit], linewidth=0.9))
             for unit, x in drawing.muscles]  # fmt: skip
    for patch in (*rigid, *(tube for *_, tube in tubes)):
        scene.add_patch(patch)
    labels = [
        scene.text(x, high - _ABOVE, "", ha="center", va="bottom", fontsize=_LETTERS)
        for x, _ in drawing.labels
    ]
    clock = figure.suptitle("", fontsize=9, family=FIGURES)
    duration = float(time[-1] - time[0])
    count = min(MOST_FRAMES, len(time), max(2, round(_FASTEST * duration)))
    rows = np.unique(np.linspace(0, len(time) - 1, count).astype(int))

    def show(row: int) -> None:
        clock.set_text(f"{title}, t = {time[row]:.3f} s")
        for cursor in cursors:
            cursor.set_xdata([time[row]] * 2)
        for i, patch in enumerate(rigid):
            patch.set_xy(drawing.rigid[row, i])
        states = drawing.states[row]
        for unit, x, patch in tubes:
            patch.set_xy(drawing.tubes[row, unit] + (x, 0.0))
            state = states[unit]
            patch.set(facecolor=(colors[unit], ALPHAS[state]), edgecolor=colors[unit],
                      hatch="/////" if HATCHED[state] else None)  # fmt: skip
        for unit, label in enumerate(labels):
            label.set_text(f"unit {unit + 1}\n{STATES[states[unit]]}" if len(labels) <= 3
                           else f"{unit + 1}")  # fmt: skip

    artists: list[tuple[Any, Any]] = [(figure, clock), *zip(axes[:, 1], cursors, strict=True)]
    artists += [(scene, artist) for artist in (*rigid, *(tube for *_, tube in tubes), *labels)]
    show(0)
    canvas: Any = figure.canvas
    canvas.draw()
    figure.set_layout_engine("none")  # laid out once
    for _, artist in artists:
        artist.set_animated(True)
    canvas.draw()  # what stands still; a whole drawing of each frame takes ten times as long
    background, images = canvas.copy_from_bbox(figure.bbox), []
    for row in rows.tolist():
        show(row)
        canvas.restore_region(background)
        for owner, artist in artists:
            owner.draw_artist(artist)
        image = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
        images.append(image.quantize(_COLORS, dither=Image.Dither.NONE))
    out = io.BytesIO()
    step = round(100 * duration / len(rows)) * 10  # ms: GIF has hundredths of a second
    images[0].save(out, "GIF", save_all=True, append_images=images[1:], duration=step, loop=0)
    return out.getvalue()


def _draw_chart(ax: Any, time: np.ndarray, chart: ChartCurves) -> None:
    """Draw the curves of a chart."""
    for curve in chart.curves:
        ax.plot(time, curve.values, color=curve.color, linestyle=_DASHES[curve.dash],
                linewidth=curve.width * 0.6, label=curve.label)  # fmt: skip
    ax.set_title(chart.title, loc="left")
    ax.set_ylabel(f"[{chart.unit}]")
    ax.set_xlim(time[0], time[-1])
    ax.legend(loc="upper left")  # "best" takes long among so many points

"""One style for every figure: sizes in print, colors, lines, and axes with their units.

Figures are matplotlib's own objects and touch no global state that outlives a call: the
style is switched on while one is built and while it is drawn. Widths are those of a
journal's columns, so that text has its printed size, 7 to 8 points.

Colors and typeface are those of `plot.theme`.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .theme import BLACK, BLUE, FIGURES, GRAY, GREEN, GRID, ORANGE, PURPLE, SKY, VERMILION, WHITE


_MM = 1 / 25.4  # in inches, matplotlib's unit
SINGLE, DOUBLE = 88 * _MM, 180 * _MM  # a journal's one and two columns

CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)

_STYLE: Any = {
    "font.family": FIGURES,
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.5,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "figure.dpi": 200,
    "savefig.dpi": 200,
    "savefig.facecolor": WHITE,
    "mathtext.fontset": "dejavusans",
    "svg.hashsalt": "fascicle",  # the same drawing gives the same file
}
# no time of day, nor matplotlib's version
_METADATA = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": "fascicle"}}


class StyledFigure(Figure):
    """A figure that is drawn in the style, whoever saves it."""

    def draw(self, renderer: Any) -> None:
        """Draw onto any `renderer` (SVG's is none of matplotlib's base); ticks are made now."""
        with rc_context(_STYLE):
            super().draw(renderer)

    def _repr_png_(self) -> bytes:
        """As notebooks show it: matplotlib shows none before pyplot has made one of its own."""
        return to_bytes(self, "png")


def styled(function: Callable) -> Callable:
    """Run a function that builds a figure with the style switched on."""

    @wraps(function)
    def inside(*args: Any, **kwargs: Any) -> Any:
        with rc_context(_STYLE):
            return function(*args, **kwargs)

    return inside


@styled
def new_figure(
    rows: int = 1, columns: int = 1, width: float = SINGLE, height: float | None = None, **more: Any
) -> tuple[Figure, np.ndarray]:
    """A figure of `rows` × `columns` axes, `width` by `height` [inch], laid out by itself.

    `more` goes to matplotlib's `subplots`. Axes come as a two-dimensional array.
    """
    if height is None:
        height = 0.72 * width * rows / columns
    figure = StyledFigure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **more)


def force_strain_axes(axes: Axes) -> None:
    """Label `axes` as force over contraction, with a line at zero force."""
    axes.set_xlabel("Contraction ε [–]")
    axes.set_ylabel("Force F [N]")
    axes.axhline(0, color=GRAY, linewidth=0.6, zorder=1)


def letter(axes: Axes, mark: str, title: str = "") -> None:
    """Name a panel: a bold `mark` and a `title` above its left edge."""
    bold = rf"$\bf{{({mark})}}$"
    axes.set_title(f"{bold}  {title}" if title else bold, loc="left")


def pressure_colors(count: int) -> list[Any]:
    """Colors for `count` rising pressures, dark to light and never too light to see."""
    return [colormaps["viridis"](x) for x in np.linspace(0.0, 0.82, count)]


def in_kilopascals(pressure: float) -> str:
    """A pressure [Pa] as a label."""
    return f"{pressure / 1e3:.4g} kPa"


def to_bytes(figure: Figure, kind: str, dpi: float = 200) -> bytes:
    """A figure as the bytes of a "png", "svg" or "pdf" file, the same each time.

    `dpi`: dots per inch of what is not vectors.
    """
    import io

    out = io.BytesIO()
    with rc_context(_STYLE):
        figure.savefig(out, format=kind, dpi=dpi, metadata=_METADATA[kind])
    return out.getvalue()

"""Theme: colors, typeface and spacing of figures, reports, explorer and docs; style of figures.

Curves can be distinguished by the color-blind, too; text keeps a contrast of 4.5 : 1 on light and
dark pages. Figures are matplotlib's own objects, whose style is switched on while one is built and
drawn, and touches no global state. Widths are those of a journal's columns, so that text has its
printed size, 7 to 8 points.

**Source:** colors of Okabe and Ito (2008); contrast as in WCAG 2.2, 1.4.3.
"""

import io
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, TypeVar, cast

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler


BLACK, WHITE = "#000000", "#ffffff"
ORANGE, SKY, GREEN, YELLOW = "#e69f00", "#56b4e9", "#009e73", "#f0e442"
BLUE, VERMILION, PURPLE, GRAY = "#0072b2", "#d55e00", "#cc79a7", "#767676"
GRID = "#e4e7ea"
CLEAR = "rgba(0, 0, 0, 0)"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)  # of curves, in order
# lengths of dashes and gaps of curves, in order: without color, they can be told apart
DASHES = ((), (6, 2), (1.5, 1.5), (6, 1.5, 1.5, 1.5), (10, 2), (6, 1.5, 1.5, 1.5, 1.5, 1.5))

# of lines in figures, told apart without color; solid, dashed, dotted and dashed-dotted
LINE_STYLES = ("-", (0, (4, 2)), (0, (1, 1.2)), (0, (6, 2, 1, 2)))

SANS = '"DejaVu Sans", Verdana, "Bitstream Vera Sans", sans-serif'
MONO = '"DejaVu Sans Mono", ui-monospace, Menlo, Consolas, monospace'
FIGURES = "DejaVu Sans"  # comes with matplotlib: the same on every machine

# of a page, in pixels: sizes of text, widths of gaps, and the roundness of corners
SMALL, TEXT, LARGE, TITLE = 13, 14, 16, 22
NEAR, APART, WIDE, FAR = 4, 8, 16, 32
ROUND = 6

_INCH = 1 / 25.4  # of a millimeter: matplotlib's unit
SINGLE, DOUBLE = 88 * _INCH, 180 * _INCH  # a journal's one and two columns

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
    "axes.prop_cycle": cycler(color=CYCLE),
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
# neither the time of day nor matplotlib's version
_METADATA = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": "fascicle"}}

_Function = TypeVar("_Function", bound=Callable[..., Any])


def styled(function: _Function) -> _Function:
    """Decorator of a `function` that builds a figure: with the style of all figures."""

    @wraps(function)
    def build(*arguments: Any, **options: Any) -> Any:
        if pyplot := sys.modules.get("matplotlib.pyplot"):
            # a notebook's backend makes matplotlib interactive at its first use; in the context
            # below that would be undone, and the notebook would show no figure any more
            pyplot.draw_if_interactive()
        with rc_context(_STYLE):
            return function(*arguments, **options)

    return cast(_Function, build)


@dataclass(frozen=True)
class Colors:
    """Colors of a page: `ink` and `soft` text, `edge` of controls, faint `line`s, `raised` areas on
    `paper`; `accent` of links and `deep`, the ground of white text; `good`, `odd` and `bad` news,
    with `alarm` behind them. `curves` in order. Of a muscle, its `tube`, `fiber`s and `fitting`s.
    """

    dark: bool
    ink: str
    soft: str
    edge: str
    line: str
    raised: str
    paper: str
    accent: str
    deep: str
    good: str
    odd: str
    bad: str
    alarm: str
    curves: tuple[str, ...]
    tube: str
    fiber: str
    fitting: str


LIGHT = Colors(
    dark=False, ink="#16191d", soft="#545d67", edge="#7b858f", line=GRID, raised="#f3f6f8",
    paper=WHITE, accent="#00639c", deep="#00639c", good="#00664a", odd="#7d5200", bad="#a3000f",
    alarm="#fff0f0", curves=(BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK, GRAY),
    tube="#d6e8f5", fiber="#0b3d5c", fitting="#60666e",
)  # fmt: skip
# lighter where the light page's would sink into it
DARK = Colors(
    dark=True, ink="#eef1f4", soft="#a9b3bd", edge="#88929c", line="#30363c", raised="#22272c",
    paper="#15181b", accent=SKY, deep="#00639c", good="#2bc79b", odd=ORANGE, bad="#ff9a94",
    alarm="#3a1618",
    curves=(SKY, "#ff8a3d", "#2bc79b", "#e39fc6", ORANGE, "#7fa8ff", WHITE, "#9aa3ab"),
    tube="#88aac2", fiber="#0d2b3e", fitting="#7d858e",
)  # fmt: skip


def red_green_blue(color: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of a `color` such as `#0072b2`."""
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


def mix(first: str, second: str, fraction: float) -> str:
    """Mixture of two colors with a `fraction` of the second [-]."""
    channels = zip(red_green_blue(first), red_green_blue(second), strict=True)
    return "#" + "".join(f"{round(a + (b - a) * fraction):02x}" for a, b in channels)


def css_variables(colors: Colors) -> dict[str, str]:
    """CSS variables of a page: `--ink`, `--paper`, `--sans`, …"""
    variables = {name: value for name, value in vars(colors).items() if isinstance(value, str)}
    pixels = {"round": ROUND, "near": NEAR, "apart": APART, "wide": WIDE, "far": FAR}
    variables |= {name: f"{size}px" for name, size in pixels.items()}
    variables |= {"sans": SANS, "mono": MONO, "mark": VERMILION, "first": BLUE}
    return {f"--{name}": value for name, value in variables.items()}


def css(colors: Colors) -> str:
    """Declarations of `css_variables`, without a selector: `--ink: #…; --paper: #…; …`."""
    return " ".join(f"{name}: {value};" for name, value in css_variables(colors).items())


class StyledFigure(Figure):
    """A figure that is drawn in the style, whichever program saves it."""

    def draw(self, renderer: Any) -> None:
        """Draw onto any `renderer` (SVG's has no base class of matplotlib); ticks are made now."""
        with rc_context(_STYLE):
            super().draw(renderer)

    def _repr_png_(self) -> bytes:
        """PNG for notebooks: matplotlib shows none before pyplot has made a figure."""
        return to_bytes(self, "png")


@styled
def new_figure(
    rows: int = 1, columns: int = 1, width: float = SINGLE, height: float | None = None, **more: Any
) -> tuple[Figure, np.ndarray]:
    """Create a figure of `rows` × `columns` axes, `width` by `height` [inch], for `subplots`; where
    pyplot is in use, the figure is its current one, until `to_bytes` has written it.
    """
    height = 0.72 * width * rows / columns if height is None else height
    settings: Any = {"figsize": (width, height), "layout": "constrained"}
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is None:
        figure = StyledFigure(**settings)
        FigureCanvasAgg(figure)
    else:
        figure = pyplot.figure(FigureClass=StyledFigure, **settings)
    return figure, figure.subplots(rows, columns, squeeze=False, **more)


def single_axes(
    ax: Axes | None, width: float = SINGLE, height: float | None = None
) -> tuple[Figure, Axes]:
    """The figure of `ax` and `ax`, or a new figure's."""
    if ax is None:
        figure, axes = new_figure(width=width, height=height)
        return figure, axes[0, 0]
    figure = ax.get_figure(root=True)
    assert figure is not None  # of axes that were removed
    return figure, ax


def new_panels(
    count: int, columns: int, width: float, height: float | None = None, **more: Any
) -> tuple[Figure, np.ndarray]:
    """Create a figure of `count` axes in rows of `columns`; others as of `new_figure`."""
    figure, axes = new_figure(-(-count // columns), columns, width, height, **more)
    for spare in axes.flat[count:]:
        spare.set_visible(False)
    return figure, axes


def force_strain_axes(axes: Axes) -> None:
    """Label `axes` as force over contraction, with a line at zero force."""
    axes.set_xlabel("Contraction ε [–]")
    axes.set_ylabel("Force F [N]")
    axes.axhline(0, color=GRAY, linewidth=0.6, zorder=1)


def letter(axes: Axes, mark: str, title: str = "") -> None:
    """Name a panel: a bold `mark` and a `title` above its left edge."""
    bold = rf"$\bf{{({mark})}}$"
    axes.set_title(f"{bold}  {title}" if title else bold, loc="left")


def letters(axes: Any, titles: Any) -> None:
    """Name panels "(a)", "(b)", … with `titles`."""
    for ax, mark, title in zip(np.ravel(axes), "abcdefghijklmnopqrstuvwxyz", titles, strict=False):
        letter(ax, mark, title)


def pressure_colors(count: int) -> list[Any]:
    """Colors for `count` rising pressures, dark to light and never too light to see."""
    return [colormaps["viridis"](x) for x in np.linspace(0.0, 0.82, count)]


def in_kilopascals(pressure: float) -> str:
    """Label of a pressure [Pa]."""
    return f"{pressure / 1e3:.4g} kPa"


def to_bytes(figure: Figure, kind: str, dpi: float = 200) -> bytes:
    """Bytes of a figure's "png", "svg" or "pdf" file, the same each time; `dpi`: of pixels."""
    out = io.BytesIO()
    with rc_context(_STYLE):
        figure.savefig(out, format=kind, dpi=dpi, metadata=_METADATA[kind])
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close(figure)  # else a notebook would show it once more
    return out.getvalue()

"""Theme: typeface, spacing and palette of figures, reports, explorer and docs.

Colors stand here and nowhere else. Those of curves are told apart by the color-blind, too; text
keeps a contrast of 4.5 : 1 to what it stands on, on light pages and dark ones, which a test
computes. The typeface is the one that figures embed, DejaVu Sans; where a machine hasn't it,
Verdana, of which it has the widths and nearly the shapes.

**Source:** colors of Okabe and Ito (2008); contrast as in WCAG 2.2, 1.4.3.
"""

from dataclasses import dataclass


# what is drawn
BLACK, WHITE = "#000000", "#ffffff"
ORANGE, SKY, GREEN, YELLOW = "#e69f00", "#56b4e9", "#009e73", "#f0e442"
BLUE, VERMILION, PURPLE, GRAY = "#0072b2", "#d55e00", "#cc79a7", "#767676"
GRID = "#e4e7ea"
CLEAR = "rgba(0, 0, 0, 0)"

SANS = '"DejaVu Sans", Verdana, "Bitstream Vera Sans", sans-serif'
MONO = '"DejaVu Sans Mono", ui-monospace, Menlo, Consolas, monospace'
FIGURES = "DejaVu Sans"  # comes with matplotlib: the same on every machine

# of a page, in pixels: text from small to the largest, room, and the roundness of corners
SMALL, TEXT, LARGE, TITLE = 13, 14, 16, 22
NEAR, APART, WIDE, FAR = 4, 8, 16, 32
ROUND = 6


@dataclass(frozen=True)
class Colors:
    """A page's colors: `ink` and `soft` text, `edge` of what can be used, faint `line`s, `raised`
    areas on `paper`; `accent` of links and `deep`, what white text stands on; `good`, `odd` and
    `bad` news, with `alarm` behind them. `curves` in order. Of a muscle, its `tube`, `fiber`s
    and `fitting`s.
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
    """Shares of red, green and blue [-], 0 to 255, of a `color` [-] such as `#0072b2`."""
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


def mixed(color: str, other: str, share: float) -> str:
    """A `color` [-] with a `share` [-] of an `other` [-]."""
    pairs = zip(red_green_blue(color), red_green_blue(other), strict=True)
    return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in pairs)


def contrast(color: str, other: str) -> float:
    """The ratio [-] in which two colors' [-] luminances stand, from 1 to 21."""
    high, low = sorted((_luminance(color), _luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def variables(colors: Colors) -> dict[str, str]:
    """Theme of a page as CSS variables [-]: `--ink`, `--paper`, `--sans`, …"""
    named = ("ink", "soft", "edge", "line", "raised", "paper", "accent", "deep", "good", "odd",
             "bad", "alarm")  # fmt: skip
    return {
        **{f"--{name}": getattr(colors, name) for name in named},
        "--sans": SANS,
        "--mono": MONO,
        "--round": f"{ROUND}px",
        "--near": f"{NEAR}px",
        "--apart": f"{APART}px",
        "--wide": f"{WIDE}px",
        "--far": f"{FAR}px",
        "--mark": VERMILION,
        "--first": BLUE,
    }


def css(colors: Colors) -> str:
    """`variables` as declarations [-] of a style sheet."""
    return " ".join(f"{name}: {value};" for name, value in variables(colors).items())


def _luminance(color: str) -> float:
    parts = [channel / 255 for channel in red_green_blue(color)]
    linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

"""Fig. 5: the clamped-hinged-clamped shape after collapse, and its lengths."""

import numpy as np
from matplotlib.figure import Figure

from fascicle.plot.theme import BLACK, in_kilopascals, styled
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .progression import (
    HINGED,
    PRESSURE,
    Progression,
    dimension,
    draw_pair,
    guide,
    label,
    progression,
)
from .setting import claim


_REACH = 24.0  # mm, of the angle's arms


def compute() -> PaperFigure:
    """Fig. 2's (b) and (d) again, with the angle at the hinge."""
    p = progression()
    return PaperFigure(
        key="figure_05",
        title="Fig. 5. Parameters at free strain and after collapse",
        conditions=(
            f"Fig. 6's muscle: {setting.sizes(p.muscle)}; {in_kilopascals(PRESSURE)}.",
            f"(a) at the free strain {p.free_strain:.4f}, (b) at ε = {p.strain[HINGED]:.4f}, to "
            "scale. "
            "Reading `derived` of (25), whose halves have the slope of (24) at the hinge.",
        ),
        data=_data(p),
        draw=lambda: draw(p),
        claims=claims(*angles(p)),
    )


def angles(p: Progression) -> tuple[float, float]:
    """Angle at the hinge [rad], of the drawn shape and by (24)."""
    o, x = p.outlines[HINGED], p.compression(HINGED)
    first = int(np.argmin(o.y))  # the first of those at the hinge
    # one-sided, second order: the slope jumps there
    step = o.z[first] - o.z[first - 1]
    slope = (3 * o.y[first] - 4 * o.y[first - 1] + o.y[first - 2]) / (2 * step)
    return float(np.arctan(-slope)), float(np.arctan(np.sqrt(x / (p.free_length - x))))


def claims(drawn: float, printed: float) -> tuple[Claim, ...]:
    """Claims on the hinge, of its angle as `drawn` and as `printed` [rad]."""
    return (
        claim(
            "hinge_angle",
            (float(np.degrees(abs(drawn - printed))),),
            f"The drawn halves end at {np.degrees(drawn):.3f}°, (24) gives "
            f"{np.degrees(printed):.3f}°.",
        ),
    )


@styled
def draw(p: Progression) -> Figure:
    """The muscle at free strain and collapsed, with dimension lines and the hinge's angle."""
    figure, ax, level = draw_pair(p, HINGED, "post-collapse")
    bent = p.outlines[HINGED]
    theta, deep, middle = angles(p)[1], bent.y.min() * 1e3, bent.z[-1] * 1e3 / 2
    hinge = np.array([middle, level + deep])
    ax.plot(*hinge, "o", color=BLACK, markersize=3.5, zorder=6)
    turn = np.linspace(0, theta, 31)
    arc = hinge[:, None] + 0.8 * _REACH * np.stack([np.cos(turn), np.sin(turn)])
    ax.plot(*arc, color=BLACK, linewidth=0.7, zorder=6)
    for angle in (0.0, theta):
        end = hinge + _REACH * np.array([np.cos(angle), np.sin(angle)])
        guide(ax, tuple(hinge), tuple(end))
    label(ax, tuple(hinge + _REACH * np.array([0.86, 0.2])), rf"$θ_r$ = {np.degrees(theta):.1f}°")
    dimension(ax, (middle, level), (middle, level + deep), rf"$y_{{c,max}}$ = {-deep:.1f} mm", -1)
    return figure


def _data(p: Progression) -> dict[str, Variable]:
    o = p.outlines[HINGED]
    drawn, printed = angles(p)
    return {
        "point": Variable(("point",), np.arange(o.z.size), "-", "number, several at the hinge"),
        "z": Variable(("point",), o.z, "m", "centerline, along", "(22)"),
        "y": Variable(("point",), o.y, "m", "centerline, across", "(22)"),
        "free_length": Variable((), p.free_length, "m", "length at free strain"),
        "compression": Variable((), p.compression(HINGED), "m", "compression past it"),
        "deflection": Variable((), -o.y.min(), "m", "deflection at the hinge", "(22)"),
        "hinge_angle": Variable((), printed, "rad", "between a half's end and the axis", "(24)"),
        "drawn_angle": Variable((), drawn, "rad", "the same, from the drawn shape", "(22)"),
    }

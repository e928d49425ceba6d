"""Fig. 4: the equivalent springs that let the bladder's axis shorten, (13) to (16)."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.plot.theme import (
    BLACK,
    BLUE,
    DOUBLE,
    GRAY,
    VERMILION,
    in_kilopascals,
    new_figure,
    styled,
)
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .progression import BENT, PRESSURE, Progression, dimension, guide, label, progression
from .setting import claim


_COILS, _THICK = 9, 1.6  # of a drawn spring; its half width in mm
_GROUND = 23.0  # mm below the axis, where the transverse spring stands


@dataclass(frozen=True)
class Springs:
    """The spring system of one state: lengths [m], angle [rad], stiffnesses [N/m], forces [N].

    `shortening` is $l$, of each of the two axial springs.
    """

    free_length: float
    compression: float
    shortening: float
    deflection: float
    inextensible_deflection: float
    angle: float
    transverse_stiffness: float
    axial_stiffness: float
    inextensible_force: float
    force: float


def compute() -> PaperFigure:
    """The springs of the post-buckling state of Figs 2 and 3."""
    p = progression()
    s = springs(p)
    return PaperFigure(
        key="figure_04",
        title="Fig. 4. The equivalent spring system",
        conditions=(
            f"Fig. 6's muscle: {setting.sizes(p.muscle)}; {in_kilopascals(PRESSURE)}, "
            f"at the free strain and at ε = {p.strain[BENT]:.4f}.",
            "The bars have the lengths of (14), (L_fs − 2l)/2 each, between the ends' real "
            "distance; l and y'max are the law's. The angle θ's of (14) is the bars' against the "
            "axis (the text says the vertical, which its formula is not).",
            "The forces are projected, as in (13) to (16); a joint in equilibrium resolves them "
            "[R19]: see other laws and readings, below.",
        ),
        data=_data(s),
        draw=lambda: draw(p, s),
        claims=claims(s),
    )


def springs(p: Progression) -> Springs:
    """Springs (13) to (16) of the bent state, from the law's deflection."""
    bladder, E = p.muscle.bladder, float(p.muscle.material.youngs_modulus)
    L, x = p.free_length, p.compression(BENT)
    y, y_stiff = float(-p.outlines[BENT].y.min()), float(np.sqrt(4 * x * (L - x)) / np.pi)
    l = (x - (np.pi * y) ** 2 / (4 * (L - x))) / 2  # (10) with the shortened arc
    F_b = 4 * E * float(bladder.second_moment) * np.pi**2 * (L + x) / (L - x) ** 3
    stiff, bent = np.arccos((L - x) / L), np.arccos((L - x) / (L - 2 * l))
    return Springs(
        free_length=L,
        compression=x,
        shortening=float(l),
        deflection=y,
        inextensible_deflection=y_stiff,
        angle=float(bent),
        transverse_stiffness=float(2 * F_b / (y_stiff * np.sin(stiff) * np.cos(stiff))),
        axial_stiffness=float(E * bladder.area / L),
        inextensible_force=float(F_b),
        force=float(y * np.sin(2 * bent) / (y_stiff * np.sin(2 * stiff)) * F_b),
    )


@styled
def draw(p: Progression, s: Springs) -> Figure:
    """The springs at free strain, (a), and bent, (b), in millimeters."""
    L, x, l = s.free_length * 1e3, s.compression * 1e3, s.shortening * 1e3
    chord = L - x
    depth = np.sqrt((L - 2 * l) ** 2 - chord**2) / 2
    upper, lower = -17.0, -56.0
    low, width = lower - _GROUND - 3, float(p.muscle.length) * 1e3 + 33
    figure, axes = new_figure(1, 1, DOUBLE, DOUBLE * -low / width)
    figure.set_layout_engine("none")
    ax = axes[0, 0]
    ax.set_position((0, 0, 1, 1))
    ax.set(xlim=(-16.5, width - 16.5), ylim=(low, 0))
    ax.axis("off")
    ax.text(-13, -5, rf"$\bf{{(a)}}$  free strain, ε = {p.free_strain:.3f}", va="center")
    ax.text(-13, lower + 12, rf"$\bf{{(b)}}$  post-buckling, ε = {p.strain[BENT]:.3f}", va="center")
    _system(ax, L, 0.0, upper)
    _system(ax, chord, depth, lower)
    dimension(ax, (0, upper + 4), (L, upper + 4), rf"$L_{{fs}}$ = {L:.1f} mm")
    dimension(ax, (0, lower + 4), (chord, lower + 4), rf"$L_{{fs}} - x$ = {chord:.1f} mm")
    guide(ax, (0, lower), (chord, lower))
    turn = np.linspace(0, s.angle, 21)
    ax.plot(26 * np.cos(turn), lower - 26 * np.sin(turn), color=BLACK, linewidth=0.7)
    label(ax, (28, lower - 3.5), rf"$θ'_s$ = {np.degrees(s.angle):.1f}°")
    label(
        ax,
        (chord - 21, lower - depth / 2 - 8),
        rf"$k_2$ = {s.axial_stiffness / 1e3:.2f} kN/m, shorter by $l$ = {l:.2f} mm",
    )
    label(
        ax,
        (chord / 2 + 7, lower - _GROUND + 2.5),
        rf"$k_1$ = {s.transverse_stiffness / 1e3:.2f} kN/m, "
        rf"pressed in by $y'_{{max}}$ = {s.deflection * 1e3:.1f} mm",
    )
    return figure


def _system(ax: Axes, chord: float, depth: float, level: float) -> None:
    """Two axial springs over `chord` that meet `depth` below `level`, and the transverse one."""
    apex = np.array([chord / 2, level - depth])
    for end in (np.array([0.0, level]), np.array([chord, level])):
        ax.plot(*_coil(end, apex).T, color=BLUE, linewidth=1.1, solid_joinstyle="round")
    foot = np.array([chord / 2, level - _GROUND])
    ax.plot(*_coil(apex, foot).T, color=VERMILION, linewidth=1.1, solid_joinstyle="round")
    ax.plot(*apex, "o", color=BLACK, markersize=3.5, zorder=6)
    ax.plot(foot[0] + np.array([-5, 5]), foot[[1, 1]], color=GRAY, linewidth=2.5)
    for x in (-0.8, chord + 0.8):
        ax.plot([x, x], level + np.array([-5, 5]), color=GRAY, linewidth=3)


def _coil(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Points of a zigzag from `start` to `end` [mm] with straight tails."""
    fraction = np.r_[0, np.linspace(0.2, 0.8, 2 * _COILS + 1), 1]
    direction = (end - start) / np.hypot(*(end - start))
    normal = np.array([-direction[1], direction[0]])
    side = np.zeros_like(fraction)
    side[2:-2] = _THICK * np.where(np.arange(2 * _COILS - 1) % 2, 1, -1)
    return start + fraction[:, None] * (end - start) + side[:, None] * normal


def _data(s: Springs) -> dict[str, Variable]:
    rows = {
        "free_length": ("m", "length at free strain", ""),
        "compression": ("m", "compression past it", ""),
        "shortening": ("m", "of each axial spring, l", "(14)"),
        "deflection": ("m", "with axial springs", "(15)"),
        "inextensible_deflection": ("m", "without", "(10)"),
        "angle": ("rad", "between the bars and the axis", "(14)"),
        "transverse_stiffness": ("N/m", "k1", "(13)"),
        "axial_stiffness": ("N/m", "k2 = EA/L_fs", "section 3.2"),
        "inextensible_force": ("N", "without axial springs", "(12)"),
        "force": ("N", "with axial springs", "(16)"),
    }
    return {name: Variable((), getattr(s, name), *row) for name, row in rows.items()}


def claims(s: Springs) -> tuple[Claim, ...]:
    """Claims on the springs."""
    return (
        claim(
            "axis_shortens",
            (
                2 * s.shortening / s.compression,
                s.deflection / s.inextensible_deflection,
                s.force / s.inextensible_force,
            ),
            f"The axis shortens by 2l = {2 * s.shortening * 1e3:.2f} of "
            f"{s.compression * 1e3:.2f} mm; deflection {s.deflection * 1e3:.2f} instead of "
            f"{s.inextensible_deflection * 1e3:.2f} mm, force {s.force:.2f} instead of "
            f"{s.inextensible_force:.2f} N.",
        ),
    )

"""Fig. 3: the lengths of a muscle at its free strain and in the post-buckling state."""

import numpy as np
from matplotlib.figure import Figure

from fascicle.plot.theme import in_kilopascals, styled
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .progression import BENT, PRESSURE, Progression, dimension, draw_pair, progression
from .setting import claim


_NEAR = 0.05  # of the chord: where a moment still counts as at an end or in the middle


def compute() -> PaperFigure:
    """Fig. 2's (b) and (c) again, with what (8) to (12) call the lengths."""
    p = progression()
    return PaperFigure(
        key="figure_03",
        title="Fig. 3. Parameters at free strain and in the post-buckling state",
        conditions=(
            f"Fig. 6's muscle: {setting.sizes(p.muscle)}; {in_kilopascals(PRESSURE)}.",
            f"(a) at the free strain {p.free_strain:.4f}, (b) at ε = {p.strain[BENT]:.4f}, to "
            "scale.",
        ),
        data=_data(p),
        draw=lambda: draw(p),
        claims=claims(p),
    )


def lengths(p: Progression) -> dict[str, float]:
    """Lengths [m] of the bent state: $L_{fs}$, $x$, chord, and (10) with and without springs."""
    L_fs, x = p.free_length, p.compression(BENT)
    return {
        "free_length": L_fs,
        "compression": x,
        "chord": L_fs - x,
        "deflection": float(-p.outlines[BENT].y.min()),
        "inextensible_deflection": float(np.sqrt(4 * x * (L_fs - x)) / np.pi),
    }


@styled
def draw(p: Progression) -> Figure:
    """The muscle at free strain and bent, with dimension lines."""
    figure, ax, level = draw_pair(p, BENT, "post-buckling")
    size = lengths(p)
    middle, y_max = size["chord"] * 1e3 / 2, size["deflection"] * 1e3
    dimension(ax, (middle, level), (middle, level - y_max), rf"$y'_{{max}}$ = {y_max:.1f} mm")
    return figure


def _data(p: Progression) -> dict[str, Variable]:
    about = {
        "free_length": ("length at free strain", ""),
        "compression": ("compression past it", ""),
        "chord": ("distance of the ends", ""),
        "deflection": ("largest deflection, with the shortened arc", "(10), (15)"),
        "inextensible_deflection": ("largest deflection, if the axis kept its length", "(10)"),
    }
    bent = p.outlines[BENT]
    return {
        "point": Variable(("point",), np.linspace(0, 1, bent.z.size), "-", "share of the chord"),
        "z": Variable(("point",), bent.z, "m", "centerline, along", "(8)"),
        "y": Variable(("point",), bent.y, "m", "centerline, across", "(8)"),
        **{name: Variable((), value, "m", *about[name]) for name, value in lengths(p).items()},
    }


def claims(p: Progression) -> tuple[Claim, ...]:
    """Claims on the shape,."""
    bent = p.outlines[BENT]
    mode = bent.y.min() / 2 * (1 - np.cos(2 * np.pi * bent.z / bent.z[-1]))
    off = float(np.abs(bent.y - mode).max() / -bent.y.min())
    return (
        claim(
            "first_mode_shape",
            (off,),
            f"The drawn centerline is within {off:.0e} of its deflection from that cosine; "
            f"the deflection is {-bent.y.min() * 1e3:.2f} mm.",
        ),
        moment_claim(bent.z, moments(p), float(p.moment[BENT])),
    )


def moments(p: Progression) -> np.ndarray:
    """Bending moment [N·m] along the bent axis, from the curvature of its drawn shape, (7)."""
    bent, E = p.outlines[BENT], float(p.muscle.material.youngs_modulus)
    # the ends are clamped, so the shape goes on there as its mirror image
    y = np.r_[bent.y[1], bent.y, bent.y[-2]]
    curvature = np.diff(y, 2) / float(np.diff(bent.z).mean()) ** 2
    return E * float(p.muscle.bladder.second_moment) * curvature


def moment_claim(z: np.ndarray, moment: np.ndarray, largest: float) -> Claim:
    """Claims on the `moment` [N·m] along the axis `z` [m]; `largest` [N·m] by (8)."""
    size, position = np.abs(moment), z / z[-1]
    three = size[[0, z.size // 2, -1]]
    distant = np.min(np.abs(position[:, None] - np.array([0.0, 0.5, 1.0])), axis=1) > _NEAR
    return claim(
        "largest_moments_at_ends_and_middle",
        (
            abs(float(three.min() / size.max()) - 1),
            float(size[distant].max() / size.max()),
            abs(largest / float(size.max()) - 1),
        ),
        f"{three[0]:.4f} N·m at the ends, {three[1]:.4f} N·m in the middle, none a quarter "
        f"of the chord from them; the law's largest is {largest:.4f} N·m.",
    )

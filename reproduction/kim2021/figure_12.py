"""Fig. 12: Table 1's two muscles, at the five pressures that they were tuned with."""

import equinox as eqx
import numpy as np
from matplotlib.figure import Figure

from fascicle.muscle import Muscle
from fascicle.plot.curves import Components, components_of
from fascicle.plot.theme import (
    DOUBLE,
    GRAY,
    force_strain_axes,
    in_kilopascals,
    letter,
    new_figure,
    pressure_colors,
    styled,
)
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .figure_06 import least_force
from .setting import claim


NAMES = ("slenderness_8", "slenderness_10")
PRESSURES = setting.PRESSURES[setting.FIGURE_12]
_HIGHER = np.linspace(172.4e3, setting.HIGHEST, 6)  # Pa, above 137.9 kPa to the tests' end


def compute() -> PaperFigure:
    """Forces of the two muscles with Table 1's factors."""
    muscles = [setting.muscle(name) for name in NAMES]
    parts = [setting.forces(name).at(setting.FIGURE_12) for name in NAMES]
    reach = setting.tested(muscles[0])
    return PaperFigure(
        key="figure_12",
        title="Fig. 12. Table 1's two muscles",
        conditions=(
            *(f"{_name(m)}: {setting.sizes(m)}; {_factors(m)}." for m in muscles),
            f"{setting.UNTUNED} The tested range is taken to end at the free strain at 413.7 kPa, "
            f"ε = {reach:.4f} (dotted).",
        ),
        data=_data(parts),
        draw=lambda: draw(muscles, parts, reach),
        claims=claims(muscles, [untuned(m) for m in muscles], parts, reach),
        missing="The measurements, to which Table 1 was fitted, exist only in the paper's picture; "
        "none are drawn here, and how well the curves meet them can't be checked.",
    )


def _name(muscle: Muscle) -> str:
    return f"slenderness {float(muscle.slenderness):.0f}"


def _factors(muscle: Muscle) -> str:
    t = muscle.tuning
    return (
        f"factors on E {float(t.youngs_modulus_factor):g}, on the collapse moment "
        f"{float(t.collapse_moment_factor):g}, on the hinge's stiffness "
        f"{float(t.hinge_stiffness_slope) * 1e5:.3g} P/bar + {float(t.hinge_stiffness_factor):g}; "
        f"β {float(muscle.transition_rate):g}"
    )


@styled
def draw(muscles: list[Muscle], parts: list[Components], reach: float) -> Figure:
    """Two panels with one scale."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.43 * DOUBLE, sharey=True)
    for ax, mark, muscle, part in zip(axes.flat, "ab", muscles, parts, strict=True):
        force_strain_axes(ax)
        colors = pressure_colors(part.pressure.size)
        for row, pressure, color in zip(part.force, part.pressure, colors, strict=True):
            ax.plot(part.strain, row, color=color, label=in_kilopascals(pressure))
        ax.axvline(reach, color=GRAY, linewidth=0.8, linestyle=":")
        ax.set_xlim(0.0, 0.28)
        letter(ax, mark, _name(muscle))
    axes[0, 1].set_ylabel("")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    axes[0, 1].legend(handles[::-1], labels[::-1])
    return figure


def _data(parts: list[Components]) -> dict[str, Variable]:
    data = {"pressure": Variable(("pressure",), PRESSURES, "Pa", "gauge pressure")}
    for name, part in zip(NAMES, parts, strict=True):
        strain = f"strain_{name}"
        data[strain] = Variable((strain,), part.strain, "-", "contraction")
        data[f"force_{name}"] = Variable(("pressure", strain), part.force, "N", "force", "(27)")
        collapse = Variable(("pressure",), part.collapse_strain, "-", "collapse strain")
        data[f"collapse_strain_{name}"] = collapse
    return data


def untuned(muscle: Muscle) -> Components:
    """Forces of Fig. 6's muscle, without Table 1's factors, as long as another `muscle`."""
    plain = eqx.tree_at(lambda m: m.length, setting.muscle("figure_6"), muscle.length)
    return components_of(plain, PRESSURES, setting.STRAIN)


def claims(
    muscles: list[Muscle], plain: list[Components], parts: list[Components], reach: float
) -> tuple[Claim, ...]:
    """Claims on Table 1's two `muscles`, the stouter first [-].

    `plain` are their forces without the table's factors, `parts` with them, up to `reach` [-].
    """
    return (
        _stouter_claim("stouter_resists_more", plain, reach),
        _stouter_claim("stouter_resists_more_with_table_1", parts, reach),
        _calm_claim(muscles, reach),
        _high_claim(muscles, reach),
        blocked_claim(*at_zero_strain(muscles)),
        intercept_claim(muscles[0]),
    )


def _stouter_claim(key: str, parts: list[Components], reach: float) -> Claim:
    tuned = key.endswith("table_1")
    stout, slender = (least_force(part.strain, part.force, reach) for part in parts)
    model = "Largest resistance, slenderness 8 against 10: " + "; ".join(
        f"{-a:.1f} against {-b:.1f} N at {in_kilopascals(p)}"
        for p, a, b in zip(PRESSURES, stout, slender, strict=True)
    )
    ratio = float((stout / slender).min())  # fmt: skip
    return claim(
        key,
        (ratio,),
        f"{model}, with the factors." if tuned else f"{model}, without Table 1's factors.",
    )


def _calm_claim(muscles: list[Muscle], reach: float) -> Claim:
    ratios = [
        [setting.resistance_after(muscle, float(P), reach) for P in PRESSURES] for muscle in muscles
    ]
    worst = float(np.nanmax(ratios))
    return claim(
        "less_after_collapse_with_table_1",
        (worst,),
        "Over the tested range, where it collapses: "
        + "; ".join(
            f"slenderness {name}, at most {np.nanmax(row):.3f} of it"
            for name, row in zip((8, 10), ratios, strict=True)
        )
        + ".",
    )


def _high_claim(muscles: list[Muscle], reach: float) -> Claim:
    collapses = [float(m.collapse_strain(_HIGHER).min()) for m in muscles]
    return claim(
        "no_collapse_above_137_9_kpa",
        ((min(collapses) - reach, {"scale": reach}),),
        f"The earliest collapse, from {_HIGHER[0] / 1e3:g} to {_HIGHER[-1] / 1e3:g} kPa: "
        + " and ".join(f"ε = {x:.4f}" for x in collapses)
        + f" (slenderness 8 and 10); the range ends at {reach:.4f}.",
    )


def at_zero_strain(muscles: list[Muscle]) -> tuple[list[float], list[float]]:
    """Blocked forces and bladder forces at zero strain [N] of `muscles` [-] at 137.9 kPa."""
    P = PRESSURES[-1]
    return (
        [float(m.blocked_force(P)) for m in muscles],
        [float(m.response(P, 0.0).bladder) for m in muscles],
    )


def blocked_claim(blocked: list[float], bladder: list[float]) -> Claim:
    """Claims on the `blocked` forces and `bladder` forces at zero strain [N] of two muscles."""
    return claim(
        "unequal_blocked_forces",
        (100 * abs(bladder[0] - bladder[1]) / blocked[1],),
        f"The bladders have {abs(bladder[0]):.3f} and {abs(bladder[1]):.3f} N, the muscles "
        f"{blocked[0]:.3f} and {blocked[1]:.3f} N at 137.9 kPa.",
    )


def intercept_claim(muscle: Muscle) -> Claim:
    """Claims on a muscle's blocked force over pressure; `muscle`."""
    P = setting.TABLE[1:]
    blocked = setting.array(muscle.blocked_force(P))
    slope, least = np.polyfit(P, blocked, 1)
    intercept, off = -least / slope, np.abs(blocked - slope * P - least).max() / blocked.max()
    return claim(
        "blocked_force_intercept",
        (float(off), float(intercept)),
        f"A line to {off:.0e} of the largest, which is zero at {abs(intercept):.0e} Pa.",
    )

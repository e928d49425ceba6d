"""Fig. 12: Table 1's two muscles, at the five pressures that they were tuned with."""

import numpy as np
from matplotlib.figure import Figure

from ...describe.results import Variable
from ...muscle import Muscle
from ...plot.components import Components
from ...plot.style import (
    DOUBLE,
    GRAY,
    force_strain_axes,
    in_kilopascals,
    letter,
    new_figure,
    pressure_colors,
    styled,
)
from ..claims import Claim
from ..record import Record
from . import setting


NAMES = ("slenderness_8", "slenderness_10")
PRESSURES = setting.PRESSURES[setting.FIGURE_12]
_HIGHER = np.linspace(172.4e3, setting.HIGHEST, 6)  # Pa, above 137.9 kPa to the tests' end


def compute() -> Record:
    """Forces of the two muscles with Table 1's factors."""
    muscles = [setting.muscle(name) for name in NAMES]
    parts = [setting.forces(name).at(setting.FIGURE_12) for name in NAMES]
    reach = setting.tested(muscles[0])
    return Record(
        key="figure_12",
        title="Fig. 12. Table 1's two muscles",
        conditions=(
            *(f"{_name(m)}: {setting.sizes(m)}; {_factors(m)}." for m in muscles),
            f"{setting.UNTUNED} The tested range is taken to end at the free strain at 413.7 kPa, "
            f"ε = {reach:.4f} (dotted).",
        ),
        data=_data(parts),
        draw=lambda: draw(muscles, parts, reach),
        claims=_claims(muscles, parts, reach),
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


def _claims(muscles: list[Muscle], parts: list[Components], reach: float) -> tuple[Claim, ...]:
    least = [part.force[:, part.strain <= reach].min(axis=1) for part in parts]
    calm = [_calm(part, reach) for part in parts]
    collapses = [float(m.collapse_strain(_HIGHER).min()) for m in muscles]
    blocked = [float(m.blocked_force(PRESSURES[-1])) for m in muscles]
    return (
        Claim(
            "section 5.4",
            "The stouter muscle resists more.",
            "Largest resistance, slenderness 8 against 10: "
            + "; ".join(
                f"{-a:.1f} against {-b:.1f} N at {in_kilopascals(p)}"
                for p, a, b in zip(PRESSURES, *least, strict=True)
            )
            + ".",
            holds=bool(np.all(least[0] < least[1])),
            must_hold=True,
        ),
        Claim(
            "section 3.4",
            "After collapse the resistance stays below its value at collapse.",
            "Over the tested range: "
            + "; ".join(
                f"{_name(m)}, {'never above it' if worst < 1 else f'up to {worst:.3f} of it'}, and "
                f"down to {100 * end:.0f} % of it or less at the end"
                for m, (worst, end) in zip(muscles, calm, strict=True)
            )
            + " (with the hinge's factor read in bar).",
            holds=bool(max(worst for worst, _ in calm) < 1),
            must_hold=True,
        ),
        Claim(
            "section 5.4",
            "Above 137.9 kPa the bladder does not collapse within the tested range.",
            f"The earliest collapse, from {_HIGHER[0] / 1e3:g} to {_HIGHER[-1] / 1e3:g} kPa: "
            + " and ".join(f"ε = {x:.4f}" for x in collapses)
            + f" (slenderness 8 and 10); the range ends at {reach:.4f}.",
            holds=bool(min(collapses) > reach),
            why=""
            if min(collapses) > reach
            else "Table 1's lower collapse moment brings it earlier.",
        ),
        Claim(
            "section 5.4",
            "The two muscles have unequal blocked forces, though equal sections.",
            f"{blocked[0]:.3f} and {blocked[1]:.3f} N at 137.9 kPa: equal.",
            holds=bool(abs(blocked[0] / blocked[1] - 1) > 1e-3),
            why="At zero strain neither mesh nor bladder force depends on the length, and the "
            "bladder's is zero; a difference can come only from C₁ and C₂, that is, from the "
            "measurements themselves.",
        ),
    )


def _calm(part: Components, reach: float) -> tuple[float, float]:
    """Resistance after collapse over that at collapse [-]: the largest, and the largest at the
    end of the range, of all pressures that collapse before it.
    """
    worst, last = 0.0, 0.0
    for row, collapse in zip(part.force, part.collapse_strain, strict=True):
        after = (part.strain > collapse) & (part.strain <= reach)
        if after.any():
            ratio = row[after] / float(np.interp(collapse, part.strain, row))
            worst = max(worst, float(ratio.max()))
            last = max(last, float(ratio[-1]))
    return worst, last

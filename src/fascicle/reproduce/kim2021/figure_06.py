"""Fig. 6: force and its components at four pressures."""

import numpy as np
from matplotlib.figure import Figure

from ...describe.results import Variable
from ...plot.components import Components, components_legend, draw_components
from ...plot.style import DOUBLE, GRAY, in_kilopascals, letter, new_figure, styled
from ..claims import Claim
from ..record import Record
from . import setting


LOW, HIGH = slice(0, 2), slice(2, 4)  # of the four pressures


def compute() -> Record:
    """Forces and components of Fig. 6's muscle."""
    muscle = setting.muscle("figure_6")
    parts = setting.forces("figure_6").at(setting.FIGURE_6)
    reach = setting.tested(muscle)
    return Record(
        key="figure_06",
        title="Fig. 6. Force and its components",
        conditions=(
            f"{setting.sizes(muscle)}; ν 0.5; β {float(muscle.transition_rate):g}; collapse "
            "(17) as printed, `derived` after it.",
            f"The tested range ends at the free strain at 413.7 kPa, ε = {reach:.4f} (dotted).",
            "Without pressure the mesh has no force, so the bladder's is the total in (a).",
            "Dashed: the tension law continued past the free strain, as if the muscle stayed "
            "straight. Solid parts after collapse fade with the transition; their sum is the "
            "force.",
        ),
        data=_data(parts),
        draw=lambda: draw(parts, reach),
        claims=_claims(parts, reach),
        missing="The paper's measured points exist only in its picture; none are drawn here.",
    )


@styled
def draw(parts: Components, reach: float) -> Figure:
    """Four panels, (a) to (d)."""
    figure, axes = new_figure(2, 2, DOUBLE, 0.76 * DOUBLE)
    for i, (ax, mark) in enumerate(zip(axes.flat, "abcd", strict=True)):
        draw_components(ax, parts, i)
        ax.axvline(reach, color=GRAY, linewidth=0.8, linestyle=":")
        letter(ax, mark, in_kilopascals(parts.pressure[i]))
    for ax in axes[0]:
        ax.set_xlabel("")
    for ax in axes[:, 1]:
        ax.set_ylabel("")
    components_legend(figure, axes[0, 0])
    return figure


def _data(parts: Components) -> dict[str, Variable]:
    grid, line = ("pressure", "strain"), ("pressure",)
    return {
        "pressure": Variable(line, parts.pressure, "Pa", "gauge pressure"),
        "strain": Variable(("strain",), parts.strain, "-", "contraction"),
        "force": Variable(grid, parts.force, "N", "pulling force", "(27)"),
        "mesh": Variable(grid, parts.mesh, "N", "mesh force along the arc", "section 3.2"),
        "bladder_and_bending": Variable(grid, parts.wall, "N", "the rest of the force"),
        "straight_mesh": Variable(grid, parts.straight_mesh, "N", "mesh force, straight", "(3)"),
        "straight_bladder": Variable(grid, parts.straight_bladder, "N", "bladder force", "(4)"),
        "free_strain": Variable(line, parts.free_strain, "-", "zero force"),
        "collapse_strain": Variable(line, parts.collapse_strain, "-", "collapse; inf: never"),
    }


def _claims(parts: Components, reach: float) -> tuple[Claim, ...]:
    collapse = parts.collapse_strain
    inside = parts.strain <= reach
    least = parts.force[:, inside].min(axis=1)
    straight = parts.straight_force[:, inside].min(axis=1)
    after = [abs(parts.force[i][inside & (parts.strain > collapse[i])]).max() for i in (0, 1)]
    at = [abs(np.interp(collapse[i], parts.strain, parts.force[i])) for i in (0, 1)]
    last = [abs(np.interp(reach, parts.strain, parts.force[i])) for i in (0, 1)]
    names = [in_kilopascals(p) for p in parts.pressure]
    regime = reach - parts.free_strain
    return (
        Claim(
            "Fig. 6a, b",
            "At 0 and 34.5 kPa the bladder collapses within the tested range.",
            f"Collapse at ε = {collapse[0]:.4f} and {collapse[1]:.4f}; the range ends at "
            f"{reach:.4f}.",
            holds=bool(np.all(collapse[LOW] < reach)),
            must_hold=True,
        ),
        Claim(
            "Fig. 6c, d",
            "At 137.9 and 344.7 kPa it does not collapse within the tested range.",
            f"Collapse only at ε = {collapse[2]:.4f} and {collapse[3]:.4f}; the range ends at "
            f"{reach:.4f}.",
            holds=bool(np.all(collapse[HIGH] > reach)),
            must_hold=True,
        ),
        Claim(
            "section 3.4",
            "After collapse the resistance stays below its value at collapse.",
            "; ".join(
                f"{names[i]}: {at[i]:.2f} N at collapse, {last[i]:.2f} N at the end of the tested "
                f"range, {'never more' if after[i] < at[i] else f'up to {after[i]:.2f} N'} between"
                for i in (0, 1)
            )
            + ".",
            holds=bool(after[0] < at[0] and after[1] < at[1]),
            must_hold=True,
        ),
        Claim(
            "section 4",
            "Conventional models, continued past the free strain, predict far more resistance.",
            "Largest resistance within the tested range, straight against (27): "
            + "; ".join(
                f"{-s:.1f} against {-f:.1f} N at {name}"
                for name, s, f in zip(names, straight, least, strict=True)
            )
            + ".",
            # far more: at least double where the paper points to, more everywhere
            holds=bool(np.all(straight < least) and np.all(straight[LOW] < 2 * least[LOW])),
            must_hold=True,
        ),
        Claim(
            "section 3.4",
            "As pressure rises the free strain rises, and the range of resistance shrinks until it "
            "is of no concern.",
            "Resistance covers " + ", ".join(f"{x:.3f}" for x in regime)
            + " of strain within the tested range at " + ", ".join(names) + ".",
            holds=bool(np.all(np.diff(regime) < 0) and regime[-1] < 0.1 * regime[0]),
        ),
    )  # fmt: skip

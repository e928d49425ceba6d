"""Fig. 6: force and its components at four pressures."""

import numpy as np
from matplotlib.figure import Figure

from fascicle.muscle import Muscle
from fascicle.plot.curves import Components, components_legend, draw_components
from fascicle.plot.theme import DOUBLE, GRAY, in_kilopascals, letter, new_figure, styled
from fascicle.results.labelled import Variable

from ..claims import Claim, over
from ..figures import PaperFigure
from . import setting
from .setting import claim


LOW = slice(0, 2)  # of the four pressures


def compute() -> PaperFigure:
    """Forces and components of Fig. 6's muscle."""
    muscle = setting.muscle("figure_6")
    parts = setting.forces("figure_6").at(setting.FIGURE_6)
    reach = setting.tested(muscle)
    return PaperFigure(
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
        claims=claims(muscle, parts, reach),
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


def claims(muscle: Muscle, parts: Components, reach: float) -> tuple[Claim, ...]:
    """Claims on Fig. 6: of its `muscle` [-], whose forces `parts` [N] are at four
    pressures, up to `reach` [-].
    """
    names = [in_kilopascals(p) for p in parts.pressure]
    return (
        *_collapse_claims(parts, reach),
        _calm_claim(muscle, parts, reach, names),
        *_straight_claims(parts, reach, names),
        _range_claim(parts, reach, names),
        *tension_claims(parts, muscle.replace(tension="ideal")),
    )


def _collapse_claims(parts: Components, reach: float) -> tuple[Claim, ...]:
    collapse = parts.collapse_strain
    return (
        claim(
            "collapse_at_low_pressure",
            (reach - float(collapse[LOW].max()),),
            f"Collapse at ε = {collapse[0]:.4f} and {collapse[1]:.4f}; the range ends at "
            f"{reach:.4f}.",
        ),
        claim(
            "no_collapse_at_137_9_kpa",
            ((float(collapse[2]) - reach, {"scale": reach}),),
            f"Collapse at ε = {collapse[2]:.4f}; the range ends at {reach:.4f}. At 344.7 "
            f"kPa, of which the text says nothing, at {collapse[3]:.4f}.",
        ),
    )


def _calm_claim(muscle: Muscle, parts: Components, reach: float, names: list[str]) -> Claim:
    first = [
        -float(np.interp(parts.collapse_strain[i], parts.strain, parts.force[i])) for i in (0, 1)
    ]
    last = [-float(np.interp(reach, parts.strain, parts.force[i])) for i in (0, 1)]
    after = [setting.resistance_after(muscle, float(parts.pressure[i]), reach) for i in (0, 1)]
    return claim(
        "less_after_collapse",
        (float(np.max(after)),),
        "; ".join(
            f"{names[i]}: {first[i]:.2f} N at collapse, {last[i]:.2f} N at the end of the tested "
            "range, "
            f"{'never more' if after[i] <= 1 else f'up to {after[i] * first[i]:.2f} N'} between"
            for i in (0, 1)
        )
        + ".",
    )


def least_force(strain: np.ndarray, force: np.ndarray, reach: float) -> np.ndarray:
    """Least `force` [N] of each row over `strain` [-] up to `reach` [-], the end included."""
    ends = [np.interp(reach, strain, row) for row in force]
    return np.minimum(force[:, strain <= reach].min(axis=1), ends)


def _straight_claims(parts: Components, reach: float, names: list[str]) -> tuple[Claim, ...]:
    least = least_force(parts.strain, parts.force, reach)
    straight = least_force(parts.strain, parts.straight_force, reach)
    text = "; ".join(
        f"{-s:.1f} against {-f:.1f} N at {name}"
        for name, s, f in zip(names, straight, least, strict=True)
    )
    times = [over(s, f) for s, f in zip(straight[LOW], least[LOW], strict=True)]
    difference = least - straight
    past = [
        np.unique(parts.strain[(parts.strain >= free) & (parts.strain <= reach)])
        for free in parts.free_strain
    ]
    resistance = [
        -np.interp(strain, parts.strain, row)
        for strain, row in zip(past, parts.straight_force, strict=True)
    ]
    gains = [float(np.ptp(row)) if row.size else 0.0 for row in resistance]
    slopes = [np.diff(row) / np.diff(strain) for strain, row in zip(past, resistance, strict=True)]
    return (
        claim(
            "conventional_resistance_keeps_rising",
            (min((float(row.min()) for row in slopes if row.size), default=np.nan),),
            "From the free strain to the end of the range the tension law's resistance "
            f"rises by {', '.join(f'{x:.1f}' for x in gains)} N at {', '.join(names)}.",
        ),
        claim(
            "conventional_models_resist_much_more",
            (float(np.min(times)),),
            f"Largest resistance within the tested range, straight against (27): {text}. The "
            "paper says it of low pressures alone.",
        ),
        claim(
            "difference_grows_toward_low_pressure",
            (float(-np.diff(difference).max()),),
            "Largest resistances differ by "
            + ", ".join(f"{x:.1f}" for x in difference)
            + " N at "
            + ", ".join(names)
            + ".",
        ),
    )


def _range_claim(parts: Components, reach: float, names: list[str]) -> Claim:
    regime = reach - parts.free_strain
    return claim(
        "range_of_resistance_shrinks",
        (float(np.diff(parts.free_strain).min()), over(regime[-1], regime[0])),
        "Resistance covers "
        + ", ".join(f"{x:.3f}" for x in regime)
        + " of strain within the tested range at "
        + ", ".join(names)
        + ".",
    )


def tension_claims(parts: Components, ideal: Muscle) -> tuple[Claim, ...]:
    """Claims of section 2 on the forces `parts` [N], and on an `ideal` muscle of the mesh alone."""
    past = parts.strain > 0
    excess = parts.force[:, past] - parts.force[:, :1]
    mesh = float(np.abs(parts.mesh[0]).max())
    free = setting.array(ideal.free_strain(parts.pressure[1:]))
    return (
        claim(
            "largest_force_at_zero_strain",
            (float((excess / parts.strain[past]).max()),),
            f"{', '.join(f'{x:.1f}' for x in parts.force[:, 0])} N at zero strain, less at every "
            "other one."
            if excess.max() < 0
            else f"It is exceeded by {excess.max():.2g} N.",
        ),
        claim(
            "no_mesh_force_without_pressure",
            (mesh,),
            f"The largest mesh force at 0 kPa is {mesh:.2g} N, at every strain.",
        ),
        claim(
            "ideal_free_strain_is_constant",
            (float(np.ptp(free)),),
            f"{free[0]:.4f} at every pressure; with the bladder, "
            f"{', '.join(f'{x:.3f}' for x in parts.free_strain)}.",
        ),
    )

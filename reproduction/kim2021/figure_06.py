"""Fig. 6: force and its components at four pressures."""

import numpy as np
from matplotlib.figure import Figure

from fascicle.muscle import Muscle
from fascicle.plot.components import Components, components_legend, draw_components
from fascicle.plot.style import DOUBLE, GRAY, in_kilopascals, letter, new_figure, styled
from fascicle.results.labelled import Variable

from ..claims import Claim, Criterion, over
from ..reproduced import Record
from . import setting


LOW = slice(0, 2)  # of the four pressures
_TIMES = 2.0  # what a much greater resistance is, where the paper gives no number
_SMALL = 0.1  # of the widest range: what is of no concern, likewise


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
    """What the paper says of Fig. 6: of its `muscle` [-], whose forces `parts` [N] are at four
    pressures, up to `reach` [-].
    """
    names = [in_kilopascals(p) for p in parts.pressure]
    return (
        *_collapse_claims(parts, reach),
        _calm_claim(muscle, parts, reach, names),
        *_straight_claims(parts, reach, names),
        _range_claim(parts, reach, names),
    )


def _collapse_claims(parts: Components, reach: float) -> tuple[Claim, ...]:
    collapse = parts.collapse_strain
    return (
        Claim(
            key="collapse_at_low_pressure",
            where="section 3.4, Fig. 6a, b",
            kind="prediction",
            text="At 0 and 34.5 kPa the bladder collapses within the tested range.",
            quote="the resistive force shows a decrease in magnitude (i.e., becomes less negative)",
            criteria=(
                Criterion(
                    "strain from the later collapse to the end of the range",
                    reach - float(collapse[LOW].max()), ">", 0.0,
                ),
            ),
            model=f"Collapse at ε = {collapse[0]:.4f} and {collapse[1]:.4f}; the range ends at "
            f"{reach:.4f}.",
        ),
        Claim(
            key="no_collapse_at_137_9_kpa",
            where="section 3.4, Fig. 6c",
            kind="input",
            text="At 137.9 kPa the bladder does not collapse within the tested range.",
            quote="the bladder does not collapse before the maximum strain tested",
            criteria=(
                Criterion(
                    "strain from the end of the range to the collapse",
                    float(collapse[2]) - reach, ">", 0.0,
                    scale=reach, ours=setting.RANGE_END,
                ),
            ),
            model=f"Collapse at ε = {collapse[2]:.4f}; the range ends at {reach:.4f}. At 344.7 "
            f"kPa, of which the text says nothing, at {collapse[3]:.4f}.",
            chosen="C₁₀ and C₀₁ [R3]: with Klute and Hannaford's latex it would collapse before.",
        ),
    )  # fmt: skip


def _calm_claim(muscle: Muscle, parts: Components, reach: float, names: list[str]) -> Claim:
    at = [-float(np.interp(parts.collapse_strain[i], parts.strain, parts.force[i])) for i in (0, 1)]
    last = [-float(np.interp(reach, parts.strain, parts.force[i])) for i in (0, 1)]
    after = [setting.resistance_after(muscle, float(parts.pressure[i]), reach) for i in (0, 1)]
    return Claim(
        key="less_after_collapse",
        where="section 3.4",
        kind="prediction",
        text="After collapse the resistance never exceeds its value at collapse, up to the end of "
        "the tested range.",
        quote="the magnitude of resistive force remains less than its maximum value at collapse",
        criteria=(
            Criterion(
                "largest from collapse on over that at collapse", float(np.max(after)), "≤", 1.0
            ),
        ),
        model="; ".join(
            f"{names[i]}: {at[i]:.2f} N at collapse, {last[i]:.2f} N at the end of the tested "
            f"range, {'never more' if after[i] <= 1 else f'up to {after[i] * at[i]:.2f} N'} between"
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
    told = "; ".join(
        f"{-s:.1f} against {-f:.1f} N at {name}"
        for name, s, f in zip(names, straight, least, strict=True)
    )
    times = [over(s, f) for s, f in zip(straight[LOW], least[LOW], strict=True)]
    apart = least - straight
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
        Claim(
            key="conventional_resistance_keeps_rising",
            where="section 4",
            kind="prediction",
            text="By conventional models the resistance keeps rising past the free strain.",
            quote="the magnitude of the resistive force continues to increase as strain increases "
            "past free strain",
            criteria=(
                Criterion(
                    "least slope over strain, past the free strains of four pressures",
                    min((float(row.min()) for row in slopes if row.size), default=np.nan),
                    ">", 0.0, "N",
                ),
            ),
            model="From the free strain to the end of the range the tension law's resistance "
            f"rises by {', '.join(f'{x:.1f}' for x in gains)} N at {', '.join(names)}.",
        ),
        Claim(
            key="conventional_models_resist_much_more",
            where="section 4",
            kind="prediction",
            text="Of inactive and low-pressure muscles, conventional models predict a much greater "
            "resistance.",
            quote="conventional models would predict a much greater magnitude of resistive force "
            "than what is present",
            criteria=(
                Criterion(
                    "largest resistance, straight over (27), the lesser of 0 and 34.5 kPa",
                    float(np.min(times)), ">", _TIMES, ours="the paper gives no number",
                ),
            ),
            model=f"Largest resistance within the tested range, straight against (27): {told}. The "
            "paper says it of low pressures alone.",
        ),
        Claim(
            key="difference_grows_toward_low_pressure",
            where="section 3.4",
            kind="prediction",
            text="The lower the pressure, the further the resistive model and the conventional one "
            "are apart.",
            quote="during lower pressures when the discrepancy between the resistive model and "
            "Klute–Hannaford model is greater",
            criteria=(
                Criterion(
                    "least fall of the difference from one pressure to the next higher",
                    float(-np.diff(apart).max()), ">", 0.0, "N",
                ),
            ),
            model="Largest resistances differ by " + ", ".join(f"{x:.1f}" for x in apart)
            + " N at " + ", ".join(names) + ".",
        ),
    )  # fmt: skip


def _range_claim(parts: Components, reach: float, names: list[str]) -> Claim:
    regime = reach - parts.free_strain
    return Claim(
        key="range_of_resistance_shrinks",
        where="section 3.4, Fig. 6d",
        kind="prediction",
        text="As pressure rises the free strain rises, and the range of resistance shrinks until "
        "it is of no concern.",
        quote="the free strain increases, thus decreasing the resistive force regime until it is "
        "no longer of concern",
        criteria=(
            Criterion(
                "least rise of the free strain from one pressure to the next higher",
                float(np.diff(parts.free_strain).min()), ">", 0.0,
            ),
            Criterion(
                "range of resistance at 344.7 kPa over that at none",
                over(regime[-1], regime[0]), "<", _SMALL, ours="the paper gives no number",
            ),
        ),
        model="Resistance covers " + ", ".join(f"{x:.3f}" for x in regime)
        + " of strain within the tested range at " + ", ".join(names) + ".",
    )  # fmt: skip

"""Fig. 14: five muscles as two motor units or as five."""

import numpy as np
from matplotlib.figure import Figure

from fascicle.bundle import Bundle
from fascicle.bundle.reversal import Reversal, free_strain_curve, reversal
from fascicle.plot.theme import BLACK, CYCLE, SINGLE, new_figure, styled
from fascicle.results.labelled import Variable

from ..claims import Claim, over
from ..figures import PaperFigure
from . import setting
from .figure_13 import PRESSURES
from .setting import claim


UNITS = (2, 3, 4, 5)


def two(of: str = "slenderness_10") -> Bundle:
    """One muscle, then four."""
    return setting.bundle(setting.muscle(of), (1, 4), setting.UNIT_1)


def five(of: str = "slenderness_10") -> Bundle:
    """Five motor units of one muscle."""
    return setting.bundle(setting.muscle(of), (1,) * 5, setting.UNIT_1)


@setting.cached
def turns() -> tuple[Reversal, tuple[Reversal, ...]]:
    """Reversal points of the two, and of each transition of the five; computed once."""
    return reversal(two()), tuple(reversal(five(), n) for n in UNITS)


def compute() -> PaperFigure:
    """Free strains through the transitions of both bundles."""
    pair = free_strain_curve(two(), 2, PRESSURES)
    rows = np.array([free_strain_curve(five(), n, PRESSURES) for n in UNITS])
    single, several = turns()
    muscle = setting.muscle("slenderness_10")
    return PaperFigure(
        key="figure_14",
        title="Fig. 14. Five muscles as two motor units or as five",
        conditions=(
            f"Muscles of slenderness 10 with Table 1's factors: {setting.sizes(muscle)}. "
            + setting.UNTUNED,
            f"Earlier units at {setting.UNIT_1 / 1e3:g} kPa, later ones at none; P_n is unit n's "
            "pressure. Dots: reversal points; dotted: a jump, where a smaller free strain appears.",
        ),
        data={
            "unit": Variable(("unit",), UNITS, "-", "motor unit n whose pressure rises"),
            "pressure": Variable(("pressure",), PRESSURES, "Pa", "P_n"),
            "two_units": Variable(("pressure",), pair, "-", "free strain of 1 + 4"),
            "five_units": Variable(
                ("unit", "pressure"), rows, "-", "free strain of 1 + 1 + 1 + 1 + 1"
            ),
            "depth_two_units": Variable((), single.depth, "-", "fall up to the reversal point"),
            "depth_five_units": Variable(("unit",), [t.depth for t in several], "-", "the same"),
        },
        draw=lambda: draw(pair, rows),
        claims=claims(single, several, (reversal(two("figure_6")), reversal(five("figure_6")))),
    )


@styled
def draw(pair: np.ndarray, rows: np.ndarray) -> Figure:
    """One panel: 1 + 4 in black, the five's transitions in colors."""
    single, several = turns()
    figure, axes = new_figure(width=SINGLE, height=0.86 * SINGLE)
    ax = axes[0, 0]
    names = [f"five units, $P_{n}$" for n in UNITS]
    lines = [(pair, single, BLACK, "1 + 4, $P_2$"), *zip(rows, several, CYCLE, names, strict=False)]
    for strain, turn, color, name in lines:
        P, values = broken(PRESSURES, strain, turn)
        ax.plot(P / 1e3, values, color=color, label=name, linewidth=1.8 if color == BLACK else 1.2)
        ax.plot(turn.pressure / 1e3, turn.free_strain, "o", color=color, markersize=3.5)
        gap = np.flatnonzero(np.isnan(values))
        if gap.size:
            ends = gap[0] + np.array([-1, 1])
            ax.plot(P[ends] / 1e3, values[ends], color=color, linewidth=0.8, linestyle=":")
    ax.set(
        xlabel="Pressure $P_n$ [kPa]", ylabel="Free strain $ε_f$ [–]", xlim=(0, PRESSURES[-1] / 1e3)
    )
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def broken(
    pressures: np.ndarray, strain: np.ndarray, turn: Reversal
) -> tuple[np.ndarray, np.ndarray]:
    """A curve [Pa], [-] through its reversal point, with a gap where it jumps there."""
    after = int(np.searchsorted(pressures, turn.pressure))
    points, values = [turn.pressure], [turn.free_strain]
    if turn.jump:
        before = abs(strain[after - 1] - turn.free_strain) > abs(strain[after] - turn.free_strain)
        points = [turn.pressure, turn.pressure]
        values = [np.nan, turn.free_strain] if before else [turn.free_strain, np.nan]
    places = [after] * len(points)
    return np.insert(pressures, places, points), np.insert(strain, places, values)


def claims(
    single: Reversal, several: tuple[Reversal, ...], plain: tuple[Reversal, Reversal]
) -> tuple[Claim, ...]:
    """What the paper says of Fig. 14: of the reversal of 1 + 4, and of the five's transitions.

    `plain` are that of 1 + 4 and the first of the five's without Table 1's factors.
    """
    depths = [turn.depth for turn in several]
    return (
        claim(
            "reversal_deeper_with_two_units",
            (over(single.depth, max(depths)),),
            f"1 + 4: {single.depth:.3f}, at {single.pressure / 1e3:.0f} kPa"
            + (", by a jump" if single.jump else "")
            + "; five units: "
            + ", ".join(f"{depth:.4f}" for depth in depths)
            + f" for n = 2 to 5. Without Table 1's factors: {plain[0].depth:.3f} and "
            f"{plain[1].depth:.3f}.",
        ),
    )

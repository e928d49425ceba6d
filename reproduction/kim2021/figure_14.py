"""Fig. 14: five muscles as two motor units or as five."""

import numpy as np
from matplotlib.figure import Figure

from fascicle.bundle import Bundle
from fascicle.bundle.reversal import Reversal, free_strain_curve, reversal
from fascicle.plot.curves import split_at_reversal
from fascicle.plot.theme import BLACK, CYCLE, SINGLE, new_figure, styled
from fascicle.results.labelled import Variable

from ..claims import Claim, over
from ..figures import PaperFigure
from . import setting
from .figure_13 import PRESSURES
from .setting import claim


UNITS = (2, 3, 4, 5)


def two(name: str = "slenderness_10") -> Bundle:
    """One muscle, then four."""
    return setting.bundle(setting.muscle(name), (1, 4), setting.UNIT_1)


def five(name: str = "slenderness_10") -> Bundle:
    """Five motor units of one muscle."""
    return setting.bundle(setting.muscle(name), (1,) * 5, setting.UNIT_1)


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
    curves = [
        (pair, single, BLACK, "1 + 4, $P_2$"), *zip(rows, several, CYCLE, names, strict=False)
    ]  # fmt: skip
    for strain, turn, color, name in curves:
        (P, eps), (P_jump, eps_jump) = split_at_reversal(PRESSURES, strain, turn)
        ax.plot(P / 1e3, eps, color=color, label=name, linewidth=1.8 if color == BLACK else 1.2)
        ax.plot(turn.pressure / 1e3, turn.free_strain, "o", color=color, markersize=3.5)
        ax.plot(P_jump / 1e3, eps_jump, color=color, linewidth=0.8, linestyle=":")
    ax.set(
        xlabel="Pressure $P_n$ [kPa]", ylabel="Free strain $ε_f$ [–]", xlim=(0, PRESSURES[-1] / 1e3)
    )
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def claims(
    single: Reversal, several: tuple[Reversal, ...], plain: tuple[Reversal, Reversal]
) -> tuple[Claim, ...]:
    """Claims on Fig. 14, on the reversals of 1 + 4 and of the five's transitions.

    `plain`: reversals of 1 + 4 and of the five's first transition without Table 1's factors.
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

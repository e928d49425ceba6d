"""Fig. 7: the transition rate β."""

import equinox as eqx
import numpy as np
from matplotlib.figure import Figure

from ...muscle import Muscle
from ...plot.style import SINGLE, force_strain_axes, new_figure, pressure_colors, styled
from ...results.labelled import Variable
from ..claims import Claim, Criterion
from ..reproduced import Record
from . import setting


RATES = np.array([5.0, 10.0, 25.0, 50.0, 100.0])
ROW = 1  # 34.5 kPa


def compute() -> Record:
    """Forces of Fig. 6's muscle at 34.5 kPa for five rates."""
    muscle = setting.muscle("figure_6")
    parts = setting.forces("figure_6")
    strain, collapse = parts.strain, float(parts.collapse_strain[ROW])
    force = np.array([_force(muscle, rate, strain) for rate in RATES.tolist()])
    return Record(
        key="figure_07",
        title="Fig. 7. The transition rate β",
        conditions=(f"Fig. 6's muscle at 34.5 kPa: {setting.sizes(muscle)}.",),
        data={
            "rate": Variable(("rate",), RATES, "-", "transition rate β", "(26)"),
            "strain": Variable(("strain",), strain, "-", "contraction"),
            "force": Variable(("rate", "strain"), force, "N", "pulling force", "(27)"),
            "collapse_strain": Variable((), collapse, "-", "collapse"),
        },
        draw=lambda: draw(strain, force),
        claims=claims(strain, force, collapse),
    )


def _force(muscle: Muscle, rate: float, strain: np.ndarray) -> np.ndarray:
    changed = eqx.tree_at(lambda m: m.transition_rate, muscle, np.asarray(rate))
    return np.asarray(changed.force(setting.PRESSURES[ROW], strain))


@styled
def draw(strain: np.ndarray, force: np.ndarray) -> Figure:
    """One panel, a curve for each rate."""
    figure, axes = new_figure(width=SINGLE)
    ax = axes[0, 0]
    force_strain_axes(ax)
    for row, rate, color in zip(force, RATES, pressure_colors(len(RATES)), strict=True):
        ax.plot(strain, row, color=color, label=f"β = {rate:g}")
    ax.set_xlim(strain[0], strain[-1])
    ax.set_ylim(-7, 17.5)
    ax.legend()
    return figure


def claims(strain: np.ndarray, force: np.ndarray, collapse: float) -> tuple[Claim, ...]:
    """What the paper says of β: `force` [N] by rate over `strain` [-], with its `collapse` [-]."""
    before = strain <= collapse
    same = float(np.ptp(force[:, before], axis=0).max())
    place = collapse + 0.02
    soon = [float(np.interp(place, strain, row)) for row in force]
    return (
        Claim(
            key="lower_rate_is_more_gradual",
            where="section 3.4",
            kind="definition",
            text="A lower β makes the transition to the post-collapse state more gradual; nothing "
            "before the collapse depends on it.",
            quote="characterize a gradual transition to the post-collapse state",
            criteria=(
                Criterion(
                    "least gain of force from one β to the next higher, 0.02 past the collapse",
                    float(np.diff(soon).min()), ">", 0.0, "N",
                ),
                Criterion("difference before the collapse", same, "=", 0.0, "N"),
            ),
            model=f"At ε = {place:.3f}, 0.02 past the collapse, the force is "
            + ", ".join(f"{f:.2f}" for f in soon)
            + " N for β = "
            + ", ".join(f"{rate:g}" for rate in RATES)
            + "; before it the curves "
            + ("coincide." if same == 0 else f"differ by up to {same:.0e} N."),
        ),
    )  # fmt: skip

"""Fig. 7: the transition rate β."""

import equinox as eqx
import numpy as np
from matplotlib.figure import Figure

from fascicle.muscle import Muscle
from fascicle.plot.theme import SINGLE, force_strain_axes, new_figure, pressure_colors, styled
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .setting import claim


RATES = np.array([5.0, 10.0, 25.0, 50.0, 100.0])
ROW = 1  # 34.5 kPa
_STEP = 1e-9  # of strain past the collapse


def compute() -> PaperFigure:
    """Forces of Fig. 6's muscle at 34.5 kPa for five rates."""
    muscle = setting.muscle("figure_6")
    parts = setting.forces("figure_6")
    strain, collapse = parts.strain, float(parts.collapse_strain[ROW])
    force = np.array([_force(muscle, rate, strain) for rate in RATES.tolist()])
    return PaperFigure(
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
        claims=(*claims(strain, force, collapse), jump_claim(*ends(muscle, collapse))),
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
    """Claims on β: `force` [N] by rate over `strain` [-], with its `collapse` [-]."""
    before = strain <= collapse
    same = float(np.ptp(force[:, before], axis=0).max())
    later = collapse + 0.02
    forces = [float(np.interp(later, strain, row)) for row in force]
    return (
        claim(
            "lower_rate_is_more_gradual",
            (float(np.diff(forces).min()), same),
            f"At ε = {later:.3f}, 0.02 past the collapse, the force is "
            + ", ".join(f"{f:.2f}" for f in forces)
            + " N for β = "
            + ", ".join(f"{rate:g}" for rate in RATES)
            + "; before it the curves "
            + ("coincide." if same == 0 else f"differ by up to {same:.0e} N."),
        ),
    )


def ends(muscle: Muscle, collapse: float) -> tuple[float, float, float]:
    """Forces [N] at 34.5 kPa: at `collapse` [-], just after it by (25) alone, and by (26)."""
    strain = np.array([collapse, collapse + _STEP])
    first, second = _force(muscle, float(muscle.transition_rate), strain)
    # a transition that is over within the step leaves (25)
    return float(first), float(_force(muscle, 1e3 / _STEP, strain)[1]), float(second)


def jump_claim(first: float, hinged: float, second: float) -> Claim:
    """Claims on the force at the collapse of the bladder, `first`, just after it without a
    transition, `hinged`, and with one, `second` [N].
    """
    return claim(
        "jump_before_the_transition",
        (abs(hinged / first - 1), abs(second - first)),
        f"At 34.5 kPa the force is {first:.2f} N at collapse and would be {hinged:.2f} N just "
        f"after it; with (26) it changes by {abs(second - first):.0e} N.",
    )

"""Fig. 8: which motor unit has which pressure, as activation rises."""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.bundle.recruitment import pressures_of
from fascicle.plot.theme import BLUE, DOUBLE, GRAY, VERMILION, letter, new_figure, styled
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .setting import claim


STATES = UNITS = 2
LEVEL = np.linspace(0.0, 1.0, 51)  # of a state's throttled pressure, over the supply's
SCHEMES = ("orderly", "batch")


def compute() -> PaperFigure:
    """Pressures of two motor units through both recruitment states."""
    pressures = {scheme: activation(scheme) for scheme in SCHEMES}
    axis = np.r_[LEVEL, 1 + LEVEL]
    return PaperFigure(
        key="figure_08",
        title="Fig. 8. Activation of two motor units",
        conditions=(
            f"Supply pressure {setting.HIGHEST / 1e3:g} kPa. (a) orderly recruitment, the paper's; "
            "(b) batch recruitment, the other scheme that it names.",
            "Across: the state, and within it its throttled pressure from zero to the supply's.",
        ),
        data={
            "step": Variable(("step",), np.arange(axis.size), "-", "position along the sequence"),
            "unit": Variable(("unit",), np.arange(1, UNITS + 1), "-", "motor unit"),
            "activation": Variable(("step",), axis, "-", "states, each from 0 to 1"),
            **{
                f"{scheme}_pressure": Variable(("step", "unit"), P, "Pa", f"{scheme} recruitment")
                for scheme, P in pressures.items()
            },
        },
        draw=lambda: draw(axis, pressures),
        claims=claims(pressures["orderly"]),
    )


def activation(scheme: str) -> np.ndarray:
    """Pressures [Pa] of the units (columns), state after state, each from zero to full."""
    levels = LEVEL * setting.HIGHEST
    states = range(1, STATES + 1)
    return np.concatenate(
        [pressures_of(state, levels, setting.HIGHEST, UNITS, scheme) for state in states]
    )


@styled
def draw(axis: np.ndarray, pressures: dict[str, np.ndarray]) -> Figure:
    """Two panels, one for each scheme."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.36 * DOUBLE, sharey=True)
    for ax, mark, (scheme, P) in zip(axes.flat, "ab", pressures.items(), strict=True):
        _panel(ax, axis, P)
        letter(ax, mark, f"{scheme} recruitment")
    axes[0, 0].set_ylabel("Pressure P [kPa]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _panel(ax: Axes, axis: np.ndarray, P: np.ndarray) -> None:
    styles = ({"color": BLUE, "linewidth": 2.4}, {"color": VERMILION, "linewidth": 1.4})
    for unit, style in enumerate(styles):
        ax.plot(axis, P[:, unit] / 1e3, label=f"motor unit {unit + 1}", **style)
    edges = range(STATES + 1)
    for state, (left, right) in enumerate(pairwise(edges), start=1):
        ax.text((left + right) / 2, 452, f"RS {state}", ha="center", va="center", color=GRAY)
    ax.axvline(1, color=GRAY, linewidth=0.6)
    ax.set(xlim=(0, STATES), ylim=(-12, 480), xlabel="Activation, state by state [–]")
    ax.set_xticks([0, 0.5, 1, 1.5, 2], ["0", "½", "1 | 0", "½", "1"])


def claims(P: np.ndarray) -> tuple[Claim, ...]:
    """Claims on orderly recruitment, of pressures [Pa] by step and unit."""
    first, second = P[: LEVEL.size], P[LEVEL.size :]
    return (
        claim(
            "orderly_recruitment",
            (
                float(first[:, 1].max()) / 1e3,
                float(second[:, 0].min()) / 1e3,
                float(second[-1, 1]) / 1e3,
            ),
            f"State 1: unit 1 from {first[0, 0] / 1e3:g} to {first[-1, 0] / 1e3:g} kPa, "
            f"unit 2 at {first[:, 1].max() / 1e3:g}. State 2: unit 1 at "
            f"{second[:, 0].min() / 1e3:g}, unit 2 from {second[0, 1] / 1e3:g} to "
            f"{second[-1, 1] / 1e3:g} kPa.",
        ),
    )

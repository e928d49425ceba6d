"""Policies beside one another: what each one's dip costs, and what it misses in time."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from .simulated import Demanded, drawn, shown_in
from .style import BLACK, CYCLE, DOUBLE, GRAY, letter, new_figure, styled
from .theme import WHITE


if TYPE_CHECKING:
    from ..dynamics import Plant, Trajectory

_LINES = ("-", (0, (4, 2)), (0, (1, 1.2)), (0, (6, 2, 1, 2)))
_MARKS = "osD^vPX"


class Priced(NamedTuple):
    """Of each policy's run the `drawdown` [SI], the `energy` from the supply [J], and whether it is
    `best`, on the front of both [-].
    """

    drawdown: Sequence[float]
    energy: Sequence[float]
    best: Sequence[bool]


@styled
def compared(
    plant: "Plant", runs: Mapping[str, tuple["Trajectory", Demanded]], priced: Priced
) -> Figure:
    """The front of dip against energy, and the errors of all policies over time.

    **Arguments:**

    - `plant`: that ran [-].
    - `runs`: by policy, each with what it was to follow [SI].
    - `priced`: what each was worth [SI].

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(
        2, 1, DOUBLE, 0.75 * DOUBLE, height_ratios=[1.2, 1.0]
    )  # a panel below the other: names need room
    front, error = axes[:, 0]
    of = next(iter(runs.values()))[1].of
    factor, unit = shown_in(plant, of)
    dips, energies = factor * np.asarray(priced.drawdown), np.asarray(priced.energy)
    best = np.asarray(priced.best)
    order = np.flatnonzero(best)[np.argsort(energies[best])]
    front.step(
        energies[order], dips[order], where="post", color=GRAY, linewidth=0.8, zorder=1,
        label="front",
    )  # fmt: skip
    for k, (name, (run, demanded)) in enumerate(runs.items()):
        color, mark = CYCLE[k % len(CYCLE)], _MARKS[k % len(_MARKS)]
        # those that others better are hollow
        face = color if best[k] else WHITE
        front.plot(energies[k], dips[k], mark, color=color, markerfacecolor=face, label=name)
        missed = factor * np.where(demanded.can, demanded.done[1:] - demanded.demand, np.nan)
        kept = drawn(missed)
        style = _LINES[k % len(_LINES)]
        error.plot(np.asarray(run.time)[1:][kept], missed[kept], color=color, linestyle=style)
    front.set_xlabel("Energy from the supply [J]")
    front.set_ylabel(f"Drawdown [{unit}]")
    front.set_ylim(bottom=min(0.0, *dips))
    front.margins(x=0.1)
    error.axhline(0, color=BLACK, linewidth=0.6, zorder=1)
    error.set_xlabel("Time t [s]")
    error.set_ylabel(f"Error of {of} [{unit}]")
    letter(front, "a", "what a smaller dip costs; full marks: no other policy betters both")
    letter(error, "b", "what each policy does more or less than demanded")
    figure.legend(loc="outside right upper")
    return figure

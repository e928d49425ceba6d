"""A run in time: where the load was, pressures, forces, and which units were fed."""

import itertools
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .style import (
    BLACK,
    BLUE,
    CYCLE,
    DOUBLE,
    GRAY,
    ORANGE,
    SKY,
    VERMILION,
    letter,
    new_figure,
    styled,
)
from .theme import GRID


if TYPE_CHECKING:
    from ..dynamics import Plant, Trajectory

MOST = 3000  # moments that are drawn, of which every second one is a least or a largest
_OPEN = 1e-3  # of a valve, from which on it counts as open
_SHUT = GRID


class Demanded(NamedTuple):
    """What a run was to follow: `of` "force" or "position" [-]; the `demand` at each step, and what
    was `done` at each moment [SI]; whether any policy `can` [-].
    """

    of: str
    demand: np.ndarray
    done: np.ndarray
    can: np.ndarray


@styled
def traces(plant: "Plant", run: "Trajectory", demanded: Demanded | None = None) -> Figure:
    """Position, pressures and forces over time, and valves below them; above, what was demanded.

    **Arguments:**

    - `plant`: that ran [-].
    - `run`: one run, not a batch of them [SI].
    - `demanded`: what it was to follow [SI], or none.

    **Returns:** the figure [-].
    """
    more = 0 if demanded is None else 2
    heights = [*[1.3, 0.7][:more], 1.0, 1.0, 1.0, 0.12 + 0.13 * plant.units]
    figure, axes = new_figure(
        4 + more, 1, DOUBLE, 0.19 * DOUBLE * sum(heights) + 0.5, sharex=True, height_ratios=heights
    )
    position, pressure, force, valves = axes[more:, 0]
    if demanded is not None:
        follows(axes[0, 0], axes[1, 0], plant, run, demanded)
    _position(position, plant, run)
    _by_unit(pressure, run, np.asarray(run.seen.pressures) / 1e3)
    _line(
        pressure,
        run,
        np.asarray(run.seen.supply_pressure) / 1e3,
        BLACK,
        "supply",
        linestyle=(0, (4, 2)),
    )
    pressure.set_ylabel("Pressure P [kPa]")
    _by_unit(force, run, np.asarray(run.seen.forces))
    force.set_ylabel("Force F [N]")
    _valves(valves, run)
    titles = (
        *("what was demanded and what was done", "error")[:more], "position of the load",
        "gauge pressure of each unit, and of the supply", "pull of each unit's muscles together",
        "valve of each unit",
    )  # fmt: skip
    for ax, mark, title in zip(axes[:, 0], "abcdef", titles, strict=False):
        letter(ax, mark, title)
    for ax in (pressure, force):
        ax.axhline(0, color=GRAY, linewidth=0.6, zorder=1)
    valves.set_xlabel("Time t [s]")
    valves.set_xlim(float(run.time[0]), float(run.time[-1]))
    lines = [
        Line2D([], [], color=CYCLE[i % len(CYCLE)], label=_named(plant, i))
        for i in range(plant.units)
    ]
    supply = Line2D([], [], color=BLACK, linestyle=(0, (4, 2)), label="supply")
    patches = [
        Patch(color=SKY, label="open to the supply"),
        Patch(color=ORANGE, label="open to the room"),
        Patch(color=_SHUT, label="shut"),
    ]
    figure.legend(handles=[*lines, supply, *patches], loc="outside lower center", ncols=4)
    return figure


def drawn(values: np.ndarray) -> np.ndarray:
    """Moments of a row of `values` [any unit] that are drawn [-]: all, or of many equal parts the
    least and the largest of each, so that no peak is lost, the first and the last.
    """
    count = len(values)
    if count <= MOST:
        return np.arange(count)
    edges = np.linspace(0, count, MOST // 2 + 1).astype(int)
    ends = [
        a + place(values[a:b])
        for a, b in itertools.pairwise(edges)
        for place in (np.argmin, np.argmax)
    ]
    return np.unique([0, *ends, count - 1])


def _named(plant: "Plant", unit: int) -> str:
    name = f"unit {unit + 1}"
    if len(plant.bundles) > 1:
        name += f" (bundle {plant.sides[unit] + 1})"
    return f"{name}: {int(plant.counts[unit])} muscle{'s' if plant.counts[unit] > 1 else ''}"


def _line(
    ax: Axes, run: "Trajectory", values: np.ndarray, color: str, label: str, **more: Any
) -> None:
    kept = drawn(values)
    ax.plot(np.asarray(run.time)[kept], values[kept], color=color, label=label, **more)


def _by_unit(ax: Axes, run: "Trajectory", values: np.ndarray) -> None:
    units = values.shape[1]
    for unit in range(units):
        # the later the thinner, so that curves on top of one another can be told apart
        width = 1.0 + 1.2 * (units - 1 - unit) / max(units - 1, 1)
        color = CYCLE[unit % len(CYCLE)]
        _line(ax, run, values[:, unit], color, f"unit {unit + 1}", linewidth=width)


def _position(ax: Axes, plant: "Plant", run: "Trajectory") -> None:
    turns = plant.load.unit == "rad"
    factor, unit = (180 / np.pi, "°") if turns else (1e3, "mm")
    q = factor * np.asarray(run.seen.position)
    _line(ax, run, q, BLACK, "position")
    ax.axhline(q[0], color=GRAY, linewidth=0.8, linestyle=(0, (1, 1.5)))
    ax.annotate(
        "start", (1, q[0]), xycoords=("axes fraction", "data"), xytext=(3, 0),
        textcoords="offset points", va="center", color=GRAY,
    )  # fmt: skip
    ax.set_ylabel(f"{'Angle' if turns else 'Position'} q [{unit}]")
    stop = plant.load.stop
    if stop is None:
        return
    low, high = ax.get_ylim()
    band = {"facecolor": "none", "edgecolor": GRAY, "hatch": "////", "linewidth": 0}
    # only stops that it came near, so that the motion isn't squeezed into a line
    near = 0.5 * (high - low)
    if factor * float(stop.high) < high + near:
        ax.axhspan(factor * float(stop.high), high + near, **band)
        high = max(high, factor * float(stop.high) + 0.1 * near)
    if factor * float(stop.low) > low - near:
        ax.axhspan(low - near, factor * float(stop.low), **band)
        low = min(low, factor * float(stop.low) - 0.1 * near)
    ax.set_ylim(low, high)


def _valves(ax: Axes, run: "Trajectory") -> None:
    time = np.asarray(run.time)
    to_supply = np.asarray(run.seen.supply) > _OPEN
    to_room = np.asarray(run.seen.exhaust) > _OPEN
    units = to_supply.shape[1]
    for unit in range(units):
        what = np.where(to_supply[:, unit], 1, np.where(to_room[:, unit], 2, 0))
        changes = np.concatenate([[0], np.flatnonzero(np.diff(what)) + 1, [len(what) - 1]])
        for begin, end in itertools.pairwise(changes):
            span = (float(time[begin]), float(time[end] - time[begin]))
            color = (_SHUT, SKY, ORANGE)[what[begin]]
            ax.broken_barh([span], (unit + 0.6, 0.8), facecolors=color, linewidth=0)
    ax.set_yticks(range(1, units + 1), [f"unit {unit + 1}" for unit in range(units)])
    ax.set_ylim(units + 0.6, 0.4)
    ax.grid(visible=False)


def follows(ax: Axes, error: Axes, plant: "Plant", run: "Trajectory", demanded: Demanded) -> None:
    """Draw what a `run` [SI] of a `plant` [-] did of what was `demanded` [SI] onto `ax` [-], and
    what it missed onto `error` [-].
    """
    factor, unit = shown_in(plant, demanded.of)
    wanted, done = factor * demanded.demand, factor * demanded.done
    _line(ax, run, done, BLUE, "done")
    _line(ax, run, np.append(wanted, wanted[-1]), BLACK, "demanded", linestyle=(0, (4, 2)))
    # beyond what muscles can there is nothing to be followed
    missed = np.append(0.0, np.where(demanded.can, done[1:] - wanted, np.nan))
    _line(error, run, missed, VERMILION, "error")
    error.axhline(0, color=GRAY, linewidth=0.6, zorder=1)
    edges = np.flatnonzero(np.diff(np.r_[True, demanded.can, True]))
    for number, (begin, end) in enumerate(zip(edges[::2], edges[1::2], strict=True)):
        span = (float(run.time[begin]), float(run.time[end]))
        for one in (ax, error):
            label = "can't be reached" if number == 0 and one is ax else None
            one.axvspan(*span, facecolor="none", edgecolor=GRAY, hatch="////", linewidth=0,
                        label=label)  # fmt: skip
    ax.legend(loc="best")
    symbol = "F" if demanded.of == "force" else "q"
    ax.set_ylabel(f"{demanded.of.capitalize()} {symbol} [{unit}]")
    error.set_ylabel(f"Error [{unit}]")


def shown_in(plant: "Plant", of: str) -> tuple[float, str]:
    """Factor [-] and unit in which what a `plant` [-] is controlled `of` is drawn [-]."""
    turns = plant.load.unit == "rad"
    if of == "position":
        return (180 / np.pi, "°") if turns else (1e3, "mm")
    return 1.0, "N·m" if turns else "N"

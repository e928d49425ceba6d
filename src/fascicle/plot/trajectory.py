"""Runs in time: traces, policies compared, maps over sines, and energy balances as bands.

**Source:** the bands are Sankey's (1898), The thermal efficiency of steam-engines.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path

from ..units import figures
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
from .theme import GRID, WHITE


if TYPE_CHECKING:
    from ..dynamics import Balance, Plant, Trajectory

MOST = 3000  # moments that are drawn, of which every second one is a least or a largest
_OPEN = 1e-3  # of a valve, from which on it counts as open
_STYLES = ("-", (0, (4, 2)), (0, (1, 1.2)), (0, (6, 2, 1, 2)))
_MARKS = "osD^vPX"
_DASHED = (0, (4, 2))
_LEAST = 1e-4  # share of the largest below which a term isn't drawn
_GAP = 0.11  # between labels, of a panel's height: a line of text
_IN, _NODE, _OUT = 0.0, (0.42, 0.46), 1.0  # places of a balance's ends and its middle
_HATCHED: dict[str, Any] = {
    "facecolor": "none", "edgecolor": GRAY, "hatch": "////", "linewidth": 0,
}  # fmt: skip


class Demand(NamedTuple):
    """What a run was to follow: `quantity` "force" or "position"; the `demand` at each step, and
    the `output` at each moment [SI]; `reachable`: the demands that some policy can meet.
    """

    quantity: str
    demand: np.ndarray
    output: np.ndarray
    reachable: np.ndarray


class PolicyCosts(NamedTuple):
    """Of each policy's run the `drawdown` [SI], the `energy` from the supply [J], and whether it is
    on the `front` of both.
    """

    drawdown: Sequence[float]
    energy: Sequence[float]
    front: Sequence[bool]


class SineMap(NamedTuple):
    """A map over sines: its `title`, `values` with amplitudes in rows [any unit], whether they
    `diverge` from zero, and which cells are `doubtful`.
    """

    title: str
    values: np.ndarray
    diverge: bool
    doubtful: np.ndarray


@styled
def traces(plant: "Plant", run: "Trajectory", demand: Demand | None = None) -> Figure:
    """Position, pressures and forces over time, and valves below them; above, what was demanded.

    **Arguments:**

    - `plant`: that ran [-].
    - `run`: one run, not a batch of them [SI].
    - `demand`: what it was to follow [SI], or none.

    **Returns:** the figure [-].
    """
    more = 0 if demand is None else 2
    heights = [*[1.3, 0.7][:more], 1.0, 1.0, 1.0, 0.12 + 0.13 * plant.units]
    figure, axes = new_figure(
        4 + more, 1, DOUBLE, 0.19 * DOUBLE * sum(heights) + 0.5, sharex=True, height_ratios=heights
    )
    position, pressure, force, valves = axes[more:, 0]
    if demand is not None:
        draw_demand(axes[0, 0], axes[1, 0], plant, run, demand)
    _draw_position(position, plant, run)
    _draw_units(pressure, run, np.asarray(run.seen.pressures) / 1e3)
    supply_pressure = np.asarray(run.seen.supply_pressure) / 1e3
    _draw_line(pressure, run, supply_pressure, BLACK, "supply", linestyle=_DASHED)
    pressure.set_ylabel("Pressure P [kPa]")
    _draw_units(force, run, np.asarray(run.seen.forces))
    force.set_ylabel("Force F [N]")
    _draw_valves(valves, run)
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
        Line2D([], [], color=CYCLE[i % len(CYCLE)], label=_unit_label(plant, i))
        for i in range(plant.units)
    ]
    supply = Line2D([], [], color=BLACK, linestyle=_DASHED, label="supply")
    patches = [
        Patch(color=SKY, label="open to the supply"),
        Patch(color=ORANGE, label="open to the room"),
        Patch(color=GRID, label="shut"),
    ]
    figure.legend(handles=[*lines, supply, *patches], loc="outside lower center", ncols=4)
    return figure


def thinned(values: np.ndarray) -> np.ndarray:
    """Moments of a row of `values` [any unit] that are drawn [-]: all, or of many equal parts the
    least and the largest of each, so that no peak is lost, the first and the last.
    """
    count = len(values)
    if count <= MOST:
        return np.arange(count)
    edges = np.linspace(0, count, MOST // 2 + 1).astype(int)
    ends = [
        a + extreme(values[a:b])
        for a, b in itertools.pairwise(edges)
        for extreme in (np.argmin, np.argmax)
    ]
    return np.unique([0, *ends, count - 1])


def _unit_label(plant: "Plant", unit: int) -> str:
    name = f"unit {unit + 1}"
    if len(plant.bundles) > 1:
        name += f" (bundle {plant.sides[unit] + 1})"
    return f"{name}: {int(plant.counts[unit])} muscle{'s' if plant.counts[unit] > 1 else ''}"


def _draw_line(
    ax: Axes, run: "Trajectory", values: np.ndarray, color: str, label: str, **more: Any
) -> None:
    points = thinned(values)
    ax.plot(np.asarray(run.time)[points], values[points], color=color, label=label, **more)


def _draw_units(ax: Axes, run: "Trajectory", values: np.ndarray) -> None:
    units = values.shape[1]
    for unit in range(units):
        # the later the thinner, so that curves on top of one another can be told apart
        width = 1.0 + 1.2 * (units - 1 - unit) / max(units - 1, 1)
        color = CYCLE[unit % len(CYCLE)]
        _draw_line(ax, run, values[:, unit], color, f"unit {unit + 1}", linewidth=width)


def _draw_position(ax: Axes, plant: "Plant", run: "Trajectory") -> None:
    turns = plant.load.unit == "rad"
    factor, unit = (180 / np.pi, "°") if turns else (1e3, "mm")
    q = factor * np.asarray(run.seen.position)
    _draw_line(ax, run, q, BLACK, "position")
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
    # only stops that it came near, so that the motion isn't squeezed into a line
    near = 0.5 * (high - low)
    if factor * float(stop.high) < high + near:
        ax.axhspan(factor * float(stop.high), high + near, **_HATCHED)
        high = max(high, factor * float(stop.high) + 0.1 * near)
    if factor * float(stop.low) > low - near:
        ax.axhspan(low - near, factor * float(stop.low), **_HATCHED)
        low = min(low, factor * float(stop.low) - 0.1 * near)
    ax.set_ylim(low, high)


def _draw_valves(ax: Axes, run: "Trajectory") -> None:
    time = np.asarray(run.time)
    to_supply = np.asarray(run.seen.supply) > _OPEN
    to_room = np.asarray(run.seen.exhaust) > _OPEN
    units = to_supply.shape[1]
    for unit in range(units):
        state = np.where(to_supply[:, unit], 1, np.where(to_room[:, unit], 2, 0))
        changes = np.concatenate([[0], np.flatnonzero(np.diff(state)) + 1, [len(state) - 1]])
        for begin, end in itertools.pairwise(changes):
            span = (float(time[begin]), float(time[end] - time[begin]))
            color = (GRID, SKY, ORANGE)[state[begin]]
            ax.broken_barh([span], (unit + 0.6, 0.8), facecolors=color, linewidth=0)
    ax.set_yticks(range(1, units + 1), [f"unit {unit + 1}" for unit in range(units)])
    ax.set_ylim(units + 0.6, 0.4)
    ax.grid(visible=False)


def draw_demand(ax: Axes, error: Axes, plant: "Plant", run: "Trajectory", demand: Demand) -> None:
    """Draw what a `run` [SI] of a `plant` [-] did of what was `demand` [SI] onto `ax` [-], and
    what it missed onto `error` [-].
    """
    factor, unit = display_unit(plant, demand.quantity)
    target, output = factor * demand.demand, factor * demand.output
    _draw_line(ax, run, output, BLUE, "done")
    _draw_line(ax, run, np.append(target, target[-1]), BLACK, "demanded", linestyle=_DASHED)
    # beyond what muscles can there is nothing to be followed
    missed = np.append(0.0, np.where(demand.reachable, output[1:] - target, np.nan))
    _draw_line(error, run, missed, VERMILION, "error")
    error.axhline(0, color=GRAY, linewidth=0.6, zorder=1)
    edges = np.flatnonzero(np.diff(np.r_[True, demand.reachable, True]))
    for number, (begin, end) in enumerate(zip(edges[::2], edges[1::2], strict=True)):
        span = (float(run.time[begin]), float(run.time[end]))
        for panel in (ax, error):
            label = "can't be reached" if number == 0 and panel is ax else None
            panel.axvspan(*span, label=label, **_HATCHED)  # fmt: skip
    ax.legend(loc="best")
    symbol = "F" if demand.quantity == "force" else "q"
    ax.set_ylabel(f"{demand.quantity.capitalize()} {symbol} [{unit}]")
    error.set_ylabel(f"Error [{unit}]")


def display_unit(plant: "Plant", quantity: str) -> tuple[float, str]:
    """Factor [-] and unit in which what a `plant` [-] is controlled `of` is drawn [-]."""
    turns = plant.load.unit == "rad"
    if quantity == "position":
        return (180 / np.pi, "°") if turns else (1e3, "mm")
    return 1.0, "N·m" if turns else "N"


@styled
def policies(
    plant: "Plant", runs: Mapping[str, tuple["Trajectory", Demand]], costs: PolicyCosts
) -> Figure:
    """The front of dip against energy, and the errors of all policies over time.

    **Arguments:**

    - `plant`: that ran [-].
    - `runs`: by policy, each with what it was to follow [SI].
    - `costs`: what each was worth [SI].

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(
        2, 1, DOUBLE, 0.75 * DOUBLE, height_ratios=[1.2, 1.0]
    )  # a panel below the other: names need room
    front, error = axes[:, 0]
    quantity = next(iter(runs.values()))[1].quantity
    factor, unit = display_unit(plant, quantity)
    dips, energies = factor * np.asarray(costs.drawdown), np.asarray(costs.energy)
    best = np.asarray(costs.front)
    order = np.flatnonzero(best)[np.argsort(energies[best])]
    front.step(
        energies[order], dips[order], where="post", color=GRAY, linewidth=0.8, zorder=1,
        label="front",
    )  # fmt: skip
    for k, (name, (run, demand)) in enumerate(runs.items()):
        color, mark = CYCLE[k % len(CYCLE)], _MARKS[k % len(_MARKS)]
        # those that others better are hollow
        face = color if best[k] else WHITE
        front.plot(energies[k], dips[k], mark, color=color, markerfacecolor=face, label=name)
        missed = factor * np.where(demand.reachable, demand.output[1:] - demand.demand, np.nan)
        points = thinned(missed)
        style = _STYLES[k % len(_STYLES)]
        error.plot(np.asarray(run.time)[1:][points], missed[points], color=color, linestyle=style)
    front.set_xlabel("Energy from the supply [J]")
    front.set_ylabel(f"Drawdown [{unit}]")
    front.set_ylim(bottom=min(0.0, *dips))
    front.margins(x=0.1)
    error.axhline(0, color=BLACK, linewidth=0.6, zorder=1)
    error.set_xlabel("Time t [s]")
    error.set_ylabel(f"Error of {quantity} [{unit}]")
    letter(front, "a", "what a smaller dip costs; full marks: no other policy betters both")
    letter(error, "b", "what each policy does more or less than demanded")
    figure.legend(loc="outside right upper")
    return figure


@styled
def sine_maps(
    panels: Sequence[Sequence[SineMap]], amplitudes: Sequence[float], frequencies: Sequence[float]
) -> Figure:
    """Rows of maps.

    **Arguments:**

    - `panels`: rows of them [-].
    - `amplitudes`: of their rows [m].
    - `frequencies`: of their columns [Hz].

    **Returns:** the figure [-].
    """
    rows, columns = len(panels), len(panels[0])
    figure, axes = new_figure(rows, columns, DOUBLE, 0.27 * DOUBLE * rows, sharex=True, sharey=True)
    marks = iter("abcdefghijklmnopqrstuvwxyz")
    for line, row in zip(axes, panels, strict=True):
        for ax, panel in zip(line, row, strict=True):
            _draw_sines(ax, panel)
            letter(ax, next(marks), panel.title)
    for ax in axes[-1]:
        ax.set_xticks(range(len(frequencies)), [f"{f:g}" for f in frequencies])
        ax.set_xlabel("Frequency [Hz]")
    for ax in axes[:, 0]:
        ax.set_yticks(range(len(amplitudes)), [f"{1e3 * A:g}" for A in amplitudes])
        ax.set_ylabel("Amplitude [mm]")
    return figure


def _draw_sines(ax: Axes, panel: SineMap) -> None:
    values = np.asarray(panel.values, float)
    if panel.diverge:
        size = max(float(np.max(np.abs(values))), 1e-9)
        style: dict[str, Any] = {"cmap": "RdBu", "norm": TwoSlopeNorm(0.0, -size, size)}
    else:
        style = {"cmap": "Greys", "vmin": 0.0, "vmax": 1.5}
    ax.imshow(values, origin="lower", aspect="auto", alpha=0.6, **style)
    ax.grid(visible=False)
    for (i, j), value in np.ndenumerate(values):
        text = f"{value:+.0f} %" if panel.diverge else f"{value:.2f}"
        ax.text(j, i, text, ha="center", va="center", fontsize=6.5)
        if panel.doubtful[i, j]:
            ax.add_patch(
                Rectangle((j - 0.5, i - 0.5), 1, 1, **_HATCHED)
            )  # fmt: skip


@styled
def energy_balances(balances: "list[Balance]") -> Figure:
    """Balances as bands from what came in to where it went, each panel to a scale of its own.

    **Arguments:** `balances`: those in joules are drawn [J].

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(len(balances), 1, DOUBLE, 0.3 * DOUBLE * len(balances))
    for ax, mark, balance in zip(axes[:, 0], "abcdefgh", balances, strict=False):
        total = _draw_balance(ax, balance)
        letter(ax, mark, f"{balance.name}: {total:.3g} {balance.unit} in all")
    return figure


def sides(balance: "Balance") -> tuple[dict[str, float], dict[str, float], list[str]]:
    """Terms that came in and that went out, of a `balance` [J], all positive, the largest first; a
    term that is negative comes in on the other side. With them go the names of those that are too
    small to be drawn.
    """
    into, went = dict(balance.into), dict(balance.went)
    came = {name: x for name, x in into.items() if x > 0}
    came |= {f"{name}, given back": -x for name, x in went.items() if x < 0}
    left = {name: x for name, x in went.items() if x > 0}
    left |= {f"{name}, taken back": -x for name, x in into.items() if x < 0}
    largest = max([*came.values(), *left.values()], default=0.0)
    small = [name for terms in (came, left) for name, x in terms.items() if x < _LEAST * largest]
    rows = ({k: x for k, x in terms.items() if k not in small} for terms in (came, left))
    first, second = (dict(sorted(row.items(), key=lambda entry: -entry[1])) for row in rows)
    return first, second, small


def _draw_balance(ax: Axes, balance: "Balance") -> float:
    came, left, small = sides(balance)
    total = max(sum(came.values()), sum(left.values()))
    ax.set_axis_off()
    ax.set_xlim(-0.5, 1.5)
    if not total:
        ax.text(0.5, 0.5, "nothing moved", ha="center", va="center", color=GRAY)
        ax.set_ylim(0, 1)
        return 0.0
    ends = []
    for terms, x, node, side in ((came, _IN, _NODE[0], "right"), (left, _OUT, _NODE[1], "left")):
        widths = np.array(list(terms.values())) / total
        inner = 0.5 + np.sum(widths) / 2 - np.cumsum(widths) + widths / 2
        outer = _spread(widths)
        ends += [*(outer + widths / 2), *(outer - widths / 2)]
        colors = [GRAY] if side == "right" and len(terms) == 1 else CYCLE
        for i, (name, value) in enumerate(terms.items()):
            _band(ax, (x, outer[i]), (node, inner[i]), widths[i], colors[i % len(colors)])
            text = f"{name} {value:.3g} {balance.unit}, {figures(100 * value / total, 2)} %"
            place = x - 0.02 if side == "right" else x + 0.02
            ax.text(place, outer[i], text, ha=side, va="center")
    ax.add_patch(Rectangle((_NODE[0], 0), _NODE[1] - _NODE[0], 1, color=BLACK, linewidth=0))
    low, high = min(*ends, 0.0), max(*ends, 1.0)
    if small:
        ax.text(1.5, low - 0.1, f"too small to be drawn: {', '.join(small)}", ha="right",
                va="top", color=GRAY)  # fmt: skip
        low -= 0.12
    ax.set_ylim(low - 0.05, high + 0.05)
    return total


def _spread(widths: np.ndarray) -> np.ndarray:
    """Middles of bands from top to bottom, so far apart that their labels have room."""
    steps = np.maximum((widths[:-1] + widths[1:]) / 2 + 0.03, _GAP)
    middles = -np.concatenate([[0.0], np.cumsum(steps)])
    return middles - (middles[0] + middles[-1]) / 2 + 0.5


def _band(
    ax: Axes, end: tuple[float, float], node: tuple[float, float], width: float, color: str
) -> None:
    (x, y), (X, Y), h = end, node, width / 2
    middle = (x + X) / 2
    corners = [(x, y + h), (middle, y + h), (middle, Y + h), (X, Y + h), (X, Y - h),
               (middle, Y - h), (middle, y - h), (x, y - h), (x, y + h)]  # fmt: skip
    codes = [Path.MOVETO, *[Path.CURVE4] * 3, Path.LINETO, *[Path.CURVE4] * 3, Path.CLOSEPOLY]
    # a hairline of its own color: the thinnest can still be seen
    ax.add_patch(PathPatch(Path(corners, codes), facecolor=color, alpha=0.75, edgecolor=color,
                           linewidth=0.6))  # fmt: skip

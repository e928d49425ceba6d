"""Runs in time: traces, policies compared, and energy balances as bands.

**Source:** the bands are Sankey's (1898), The thermal efficiency of steam-engines.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path

from ..units import format_digits
from .theme import (
    BLACK,
    BLUE,
    CYCLE,
    DOUBLE,
    GRAY,
    GRID,
    ORANGE,
    SKY,
    VERMILION,
    WHITE,
    letters,
    new_figure,
    styled,
)


if TYPE_CHECKING:
    from ..dynamics import Balance, Plant, Trajectory

MOST = 3000  # moments of a curve: more than pixels across; half are minima, half maxima
_OPEN = 1e-3  # of a valve, from which on it counts as open
# of policies, told apart without color
_STYLES = ("-", (0, (4, 2)), (0, (1, 1.2)), (0, (6, 2, 1, 2)))
_MARKS = "osD^vPX"
_DASHED, _DOTTED = (0, (4, 2)), (0, (1, 1.5))
_LEAST = 1e-4  # share of the largest term below which a band is thinner than a hairline
_GAP = 0.11  # between labels, of a panel's height: a line of text
_IN, _NODE, _OUT = 0.0, (0.42, 0.46), 1.0  # abscissas of a balance's ends and its middle
_HATCHED: dict[str, Any] = {
    "facecolor": "none", "edgecolor": GRAY, "hatch": "////", "linewidth": 0,
}  # fmt: skip
_ZERO: dict[str, Any] = {"color": GRAY, "linewidth": 0.6, "zorder": 1}


class Tracking(NamedTuple):
    """Demand on a run and what was done: the `quantity`, "force" or "position"; `demand` at each
    step and `output` at each moment [SI]; `reachable`: steps whose demand some policy can meet.
    """

    quantity: str
    demand: np.ndarray
    output: np.ndarray
    reachable: np.ndarray


class PolicyCosts(NamedTuple):
    """Costs of each policy's run: `drawdown` [SI], `energy` from the supply [J], and its membership
    in the `front` of both.
    """

    drawdown: Sequence[float]
    energy: Sequence[float]
    front: Sequence[bool]


@styled
def traces(plant: "Plant", run: "Trajectory", tracking: Tracking | None = None) -> Figure:
    """Figure of position, pressures, forces and valves over time, below demand and error if given.

    **Arguments:**

    - `plant`: the plant.
    - `run`: one run of it, not a batch [SI].
    - `tracking`: its demand and output [SI], or none.
    """
    extra = 0 if tracking is None else 2
    heights = [*[1.3, 0.7][:extra], 1.0, 1.0, 1.0, 0.12 + 0.13 * plant.units]
    figure, axes = new_figure(
        4 + extra, 1, DOUBLE, 0.19 * DOUBLE * sum(heights) + 0.5, sharex=True, height_ratios=heights
    )
    position, pressure, force, valves = axes[extra:, 0]
    if tracking is not None:
        _draw_tracking(axes[0, 0], axes[1, 0], plant, run, tracking)
    _draw_position(position, plant, run)
    for ax, values in ((pressure, np.asarray(run.outputs.pressures) / 1e3),
                       (force, np.asarray(run.outputs.forces))):  # fmt: skip
        for unit in range(plant.units):
            # the later the thinner, so that curves on top of one another can be told apart
            width = 1.0 + 1.2 * (plant.units - 1 - unit) / max(plant.units - 1, 1)
            color = CYCLE[unit % len(CYCLE)]
            _draw_line(ax, run, values[:, unit], color, f"unit {unit + 1}", linewidth=width)
        ax.axhline(0, **_ZERO)
    supply = np.asarray(run.outputs.supply_pressure) / 1e3
    _draw_line(pressure, run, supply, BLACK, "supply", linestyle=_DASHED)
    pressure.set_ylabel("Pressure P [kPa]")
    force.set_ylabel("Force F [N]")
    _draw_valves(valves, run)
    valves.set(xlabel="Time t [s]", xlim=(float(run.time[0]), float(run.time[-1])))
    letters(axes, (
        *("what was demanded and what was done", "error")[:extra], "position of the load",
        "gauge pressure of each unit, and of the supply", "pull of each unit's muscles together",
        "valve of each unit",
    ))  # fmt: skip
    handles: list[Line2D | Patch] = []
    for unit in range(plant.units):
        count = int(plant.counts[unit])
        bundle = f" (bundle {plant.sides[unit] + 1})" if len(plant.bundles) > 1 else ""
        label = f"unit {unit + 1}{bundle}: {count} muscle{'s' if count > 1 else ''}"
        handles.append(Line2D([], [], color=CYCLE[unit % len(CYCLE)], label=label))
    handles += [
        Line2D([], [], color=BLACK, linestyle=_DASHED, label="supply"),
        Patch(color=SKY, label="open to the supply"),
        Patch(color=ORANGE, label="open to the room"),
        Patch(color=GRID, label="shut"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def thinned(values: np.ndarray) -> np.ndarray:
    """Indices of `values` [any unit] that are drawn: all, or the extremes of many equal parts.

    No peak is lost; the first and the last index are among them.
    """
    count = len(values)
    if count <= MOST:
        return np.arange(count)
    edges = np.linspace(0, count, MOST // 2 + 1).astype(int)
    extremes = [
        a + extreme(values[a:b])
        for a, b in itertools.pairwise(edges)
        for extreme in (np.argmin, np.argmax)
    ]
    return np.unique([0, *extremes, count - 1])


def _draw_line(
    ax: Axes, run: "Trajectory", values: np.ndarray, color: str, label: str, **style: Any
) -> None:
    points = thinned(values)
    ax.plot(np.asarray(run.time)[points], values[points], color=color, label=label, **style)


def _draw_position(ax: Axes, plant: "Plant", run: "Trajectory") -> None:
    factor, unit = display_unit(plant, "position")
    q = factor * np.asarray(run.outputs.position)
    _draw_line(ax, run, q, BLACK, "position")
    ax.axhline(q[0], color=GRAY, linewidth=0.8, linestyle=_DOTTED)
    ax.annotate(
        "start", (1, q[0]), xycoords=("axes fraction", "data"), xytext=(3, 0),
        textcoords="offset points", va="center", color=GRAY,
    )  # fmt: skip
    ax.set_ylabel(f"{'Angle' if plant.load.unit == 'rad' else 'Position'} q [{unit}]")
    if plant.load.stop is None:
        return
    low, high = ax.get_ylim()
    # only stops near the motion, so that it isn't squeezed into a line
    margin = 0.5 * (high - low)
    top, bottom = factor * float(plant.load.stop.high), factor * float(plant.load.stop.low)
    if top < high + margin:
        ax.axhspan(top, high + margin, **_HATCHED)
        high = max(high, top + 0.1 * margin)
    if bottom > low - margin:
        ax.axhspan(low - margin, bottom, **_HATCHED)
        low = min(low, bottom - 0.1 * margin)
    ax.set_ylim(low, high)


def _draw_valves(ax: Axes, run: "Trajectory") -> None:
    time = np.asarray(run.time)
    to_supply = np.asarray(run.outputs.supply) > _OPEN
    to_room = np.asarray(run.outputs.exhaust) > _OPEN
    states = np.where(to_supply, 1, np.where(to_room, 2, 0))
    units = states.shape[1]
    for unit, state in enumerate(states.T):
        changes = np.concatenate([[0], np.flatnonzero(np.diff(state)) + 1, [len(state) - 1]])
        spans = np.stack([time[changes[:-1]], np.diff(time[changes])], axis=1)
        colors = [(GRID, SKY, ORANGE)[state[begin]] for begin in changes[:-1]]
        ax.broken_barh(spans.tolist(), (unit + 0.6, 0.8), facecolors=colors, linewidth=0)
    ax.set_yticks(range(1, units + 1), [f"unit {unit + 1}" for unit in range(units)])
    ax.set_ylim(units + 0.6, 0.4)
    ax.grid(visible=False)


def _draw_tracking(
    ax: Axes, error: Axes, plant: "Plant", run: "Trajectory", tracking: Tracking
) -> None:
    """Draw demand and output of a `run` onto `ax`, and output less demand onto `error`."""
    factor, unit = display_unit(plant, tracking.quantity)
    target, output = factor * tracking.demand, factor * tracking.output
    _draw_line(ax, run, output, BLUE, "done")
    _draw_line(ax, run, np.append(target, target[-1]), BLACK, "demanded", linestyle=_DASHED)
    # an unreachable demand has no error
    difference = np.append(0.0, np.where(tracking.reachable, output[1:] - target, np.nan))
    _draw_line(error, run, difference, VERMILION, "error")
    error.axhline(0, **_ZERO)
    edges = np.flatnonzero(np.diff(np.r_[True, tracking.reachable, True]))
    label: str | None = "can't be reached"
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        span = (float(run.time[begin]), float(run.time[end]))
        ax.axvspan(*span, label=label, **_HATCHED)
        error.axvspan(*span, **_HATCHED)
        label = None
    ax.legend(loc="best")
    symbol = "F" if tracking.quantity == "force" else "q"
    ax.set_ylabel(f"{tracking.quantity.capitalize()} {symbol} [{unit}]")
    error.set_ylabel(f"Error [{unit}]")


def display_unit(plant: "Plant", quantity: str) -> tuple[float, str]:
    """Factor [-] and unit in which a "force" or "position" of a `plant` is drawn."""
    rotates = plant.load.unit == "rad"
    if quantity == "position":
        return (180 / np.pi, "°") if rotates else (1e3, "mm")
    return 1.0, "N·m" if rotates else "N"


@styled
def policies(
    plant: "Plant", runs: Mapping[str, tuple["Trajectory", Tracking]], costs: PolicyCosts
) -> Figure:
    """Figure of the front of drawdown against energy, and of all policies' errors over time.

    **Arguments:**

    - `plant`: the plant.
    - `runs`: by policy, each with its demand and output [SI].
    - `costs`: of each run [SI].
    """
    # one panel below the other: names need room
    figure, axes = new_figure(2, 1, DOUBLE, 0.75 * DOUBLE, height_ratios=[1.2, 1.0])
    front, error = axes[:, 0]
    quantity = next(iter(runs.values()))[1].quantity
    factor, unit = display_unit(plant, quantity)
    drawdowns, energies = factor * np.asarray(costs.drawdown), np.asarray(costs.energy)
    best = np.asarray(costs.front)
    order = np.flatnonzero(best)[np.argsort(energies[best])]
    front.step(
        energies[order], drawdowns[order], where="post", color=GRAY, linewidth=0.8, zorder=1,
        label="front",
    )  # fmt: skip
    for k, (name, (run, tracking)) in enumerate(runs.items()):
        color, mark = CYCLE[k % len(CYCLE)], _MARKS[k % len(_MARKS)]
        face = color if best[k] else WHITE  # dominated policies are hollow
        front.plot(energies[k], drawdowns[k], mark, color=color, markerfacecolor=face, label=name)
        difference = tracking.output[1:] - tracking.demand
        values = factor * np.where(tracking.reachable, difference, np.nan)
        points = thinned(values)
        style = _STYLES[k % len(_STYLES)]
        error.plot(np.asarray(run.time)[1:][points], values[points], color=color, linestyle=style)
    front.set(xlabel="Energy from the supply [J]", ylabel=f"Drawdown [{unit}]")
    front.set_ylim(bottom=min(0.0, *drawdowns))
    front.margins(x=0.1)
    error.axhline(0, color=BLACK, linewidth=0.6, zorder=1)
    error.set(xlabel="Time t [s]", ylabel=f"Error of {quantity} [{unit}]")
    letters(axes, (
        "what a smaller dip costs; full marks: no other policy betters both",
        "what each policy does more or less than demanded",
    ))  # fmt: skip
    figure.legend(loc="outside right upper")
    return figure


@styled
def energy_balances(balances: "list[Balance]") -> Figure:
    """Figure of balances [J] as bands from sources to sinks, each panel to a scale of its own."""
    figure, axes = new_figure(len(balances), 1, DOUBLE, 0.3 * DOUBLE * len(balances))
    totals = [_draw_balance(ax, balance) for ax, balance in zip(axes.flat, balances, strict=True)]
    letters(axes, (
        f"{balance.name}: {total:.3g} {balance.unit} in all"
        for balance, total in zip(balances, totals, strict=True)
    ))  # fmt: skip
    return figure


def sides(balance: "Balance") -> tuple[dict[str, float], dict[str, float], list[str]]:
    """Sources and sinks of a `balance` [J], all positive, the largest first, and the names of terms
    that are too small to be drawn. A negative term counts on the other side.
    """
    sources = {name: x for name, x in balance.inputs.items() if x > 0}
    sources |= {f"{name}, given back": -x for name, x in balance.outputs.items() if x < 0}
    sinks = {name: x for name, x in balance.outputs.items() if x > 0}
    sinks |= {f"{name}, taken back": -x for name, x in balance.inputs.items() if x < 0}
    limit = _LEAST * max([*sources.values(), *sinks.values()], default=0.0)
    small = [name for side in (sources, sinks) for name, x in side.items() if x < limit]
    first, second = (
        dict(sorted(((k, x) for k, x in side.items() if k not in small), key=lambda e: -e[1]))
        for side in (sources, sinks)
    )
    return first, second, small


def _draw_balance(ax: Axes, balance: "Balance") -> float:
    """Draw a balance; returns its total [J]."""
    sources, sinks, small = sides(balance)
    total = max(sum(sources.values()), sum(sinks.values()))
    ax.set_axis_off()
    ax.set_xlim(-0.5, 1.5)
    if not total:
        ax.text(0.5, 0.5, "nothing moved", ha="center", va="center", color=GRAY)
        ax.set_ylim(0, 1)
        return 0.0
    low, high = 0.0, 1.0
    for terms, x, node, side in (
        (sources, _IN, _NODE[0], "right"),
        (sinks, _OUT, _NODE[1], "left"),
    ):
        widths = np.array(list(terms.values())) / total
        inner = 0.5 + np.sum(widths) / 2 - np.cumsum(widths) + widths / 2
        # so far apart that labels have room
        steps = np.maximum((widths[:-1] + widths[1:]) / 2 + 0.03, _GAP)
        middles = -np.concatenate([[0.0], np.cumsum(steps)])
        outer = middles - (middles[0] + middles[-1]) / 2 + 0.5
        low, high = min(low, *(outer - widths / 2)), max(high, *(outer + widths / 2))
        colors = [GRAY] if side == "right" and len(terms) == 1 else CYCLE
        for i, (name, value) in enumerate(terms.items()):
            _draw_band(ax, (x, outer[i]), (node, inner[i]), widths[i], colors[i % len(colors)])
            text = f"{name} {value:.3g} {balance.unit}, {format_digits(100 * value / total, 2)} %"
            ax.text(x - 0.02 if side == "right" else x + 0.02, outer[i], text, ha=side, va="center")
    ax.add_patch(Rectangle((_NODE[0], 0), _NODE[1] - _NODE[0], 1, color=BLACK, linewidth=0))
    if small:
        ax.text(1.5, low - 0.1, f"too small to be drawn: {', '.join(small)}", ha="right",
                va="top", color=GRAY)  # fmt: skip
        low -= 0.12
    ax.set_ylim(low - 0.05, high + 0.05)
    return total


def _draw_band(
    ax: Axes, end: tuple[float, float], node: tuple[float, float], width: float, color: str
) -> None:
    (x, y), (X, Y), h = end, node, width / 2
    middle = (x + X) / 2
    corners = [(x, y + h), (middle, y + h), (middle, Y + h), (X, Y + h), (X, Y - h),
               (middle, Y - h), (middle, y - h), (x, y - h), (x, y + h)]  # fmt: skip
    codes = [Path.MOVETO, *[Path.CURVE4] * 3, Path.LINETO, *[Path.CURVE4] * 3, Path.CLOSEPOLY]
    # a hairline of its own color: the thinnest band can still be seen
    ax.add_patch(PathPatch(Path(corners, codes), facecolor=color, alpha=0.75, edgecolor=color,
                           linewidth=0.6))  # fmt: skip

"""Runs in time: traces, policies compared, and energy balances as bars."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..units import format_digits
from . import theme
from .theme import BLACK, CYCLE, DOUBLE, GRAY, LINE_STYLES, VERMILION, styled


if TYPE_CHECKING:
    from ..dynamics import Balance, Plant, Trajectory

_OPEN = 1e-3  # of a valve, from which on it counts as open
_MARKS = "osD^vPX"
_DASHED, _DOTTED = (0, (4, 2)), (0, (1, 1.5))
_HATCHES = ("", "////", "....")  # of terms beyond the colors
_HATCHED: dict[str, Any] = {"fc": "none", "ec": GRAY, "hatch": "////", "linewidth": 0}
_ZERO: dict[str, Any] = {"color": GRAY, "linewidth": 0.6, "zorder": 1}


class Tracking(NamedTuple):
    """Demand on a run and what was done: the `quantity`, "force" or "position"; `demand` at each
    step and `output` at each moment [SI]; `reachable`: steps whose demand some policy can meet.
    """

    quantity: str
    demand: np.ndarray
    output: np.ndarray
    reachable: np.ndarray


@styled
def traces(plant: "Plant", run: "Trajectory", tracking: Tracking | None = None) -> Figure:
    """Figure of a run's position, pressures, forces and valves, below demand and error if given."""
    extra = 0 if tracking is None else 2
    heights = [*[1.3, 0.7][:extra], 1.0, 1.0, 1.0, 0.12 + 0.13 * plant.units]
    height = 0.19 * DOUBLE * sum(heights) + 0.5
    options: dict[str, Any] = {"sharex": True, "height_ratios": heights}
    figure, axes = theme.new_figure(4 + extra, 1, DOUBLE, height, **options)
    position, pressure, force, valves = axes[extra:, 0]
    if tracking is not None:
        _draw_tracking(axes[0, 0], axes[1, 0], plant, run, tracking)
    _draw_position(position, plant, run)
    pressures, forces = np.asarray(run.outputs.pressures) / 1e3, np.asarray(run.outputs.forces)
    for ax, values in ((pressure, pressures), (force, forces)):
        for unit in range(plant.units):
            # the later the thinner, so that curves on top of one another can be told apart
            width = 1.0 + 1.2 * (plant.units - 1 - unit) / max(plant.units - 1, 1)
            ax.plot(run.time, values[:, unit], linewidth=width)
        ax.axhline(0, **_ZERO)
    supply = np.asarray(run.outputs.supply_pressure) / 1e3
    pressure.plot(run.time, supply, color=BLACK, linestyle=_DASHED)
    pressure.set_ylabel("Pressure P [kPa]")
    force.set_ylabel("Force F [N]")
    _draw_valves(valves, run)
    valves.set(xlabel="Time t [s]", xlim=(float(run.time[0]), float(run.time[-1])))
    titles = (
        *("what was demanded and what was done", "error")[:extra],
        "position of the load",
        "gauge pressure of each unit, and of the supply",
        "pull of each unit's muscles together",
        "valve of each unit",
    )
    theme.letters(axes, titles)
    handles: list[Line2D | Patch] = []
    for unit in range(plant.units):
        count = int(plant.counts[unit])
        bundle = f" (bundle {plant.sides[unit] + 1})" if len(plant.bundles) > 1 else ""
        label = f"unit {unit + 1}{bundle}: {count} muscle{'s' if count > 1 else ''}"
        handles.append(Line2D([], [], color=CYCLE[unit % len(CYCLE)], label=label))
    handles += [
        Line2D([], [], color=BLACK, linestyle=_DASHED, label="supply"),
        Patch(color=theme.SKY, label="open to the supply"),
        Patch(color=theme.ORANGE, label="open to the room"),
        Patch(color=theme.GRID, label="shut"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def _draw_position(ax: Axes, plant: "Plant", run: "Trajectory") -> None:
    factor, unit = display_unit(plant, "position")
    q = factor * np.asarray(run.outputs.position)
    ax.plot(run.time, q, color=BLACK)
    ax.axhline(q[0], color=GRAY, linewidth=0.8, linestyle=_DOTTED)
    offset: dict[str, Any] = {"xytext": (3, 0), "textcoords": "offset points", "va": "center"}
    ax.annotate("start", (1, q[0]), xycoords=("axes fraction", "data"), color=GRAY, **offset)
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
        colors = [(theme.GRID, theme.SKY, theme.ORANGE)[state[begin]] for begin in changes[:-1]]
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
    demand = np.append(target, target[-1])
    ax.plot(run.time, output, color=theme.BLUE, label="done")
    ax.plot(run.time, demand, color=BLACK, label="demanded", linestyle=_DASHED)
    # an unreachable demand has no error
    difference = np.append(0.0, np.where(tracking.reachable, output[1:] - target, np.nan))
    error.plot(run.time, difference, color=VERMILION)
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
    plant: "Plant",
    runs: Mapping[str, tuple["Trajectory", Tracking]],
    drawdown: Sequence[float],
    energy: Sequence[float],
    best: Sequence[bool],
) -> Figure:
    """Figure of the front of drawdown against energy, and of all policies' errors over time: `runs`
    by policy, the `drawdown` [SI] and `energy` from the supply [J] of each, and whether it is on
    the front.
    """
    # one panel below the other: names need room
    figure, axes = theme.new_figure(2, 1, DOUBLE, 0.75 * DOUBLE, height_ratios=[1.2, 1.0])
    front, error = axes[:, 0]
    quantity = next(iter(runs.values()))[1].quantity
    factor, unit = display_unit(plant, quantity)
    drawdowns, energies = factor * np.asarray(drawdown), np.asarray(energy)
    order = np.flatnonzero(best)[np.argsort(energies[np.asarray(best)])]
    style: dict[str, Any] = {"color": GRAY, "linewidth": 0.8, "zorder": 1, "label": "front"}
    front.step(energies[order], drawdowns[order], where="post", **style)
    for k, (name, (run, tracking)) in enumerate(runs.items()):
        color, mark = CYCLE[k % len(CYCLE)], _MARKS[k % len(_MARKS)]
        face = color if best[k] else theme.WHITE  # dominated policies are hollow
        front.plot(energies[k], drawdowns[k], mark, color=color, markerfacecolor=face, label=name)
        difference = tracking.output[1:] - tracking.demand
        values = factor * np.where(tracking.reachable, difference, np.nan)
        error.plot(run.time[1:], values, color=color, linestyle=LINE_STYLES[k % len(LINE_STYLES)])
    front.set(xlabel="Energy from the supply [J]", ylabel=f"Drawdown [{unit}]")
    front.set_ylim(bottom=min(0.0, *drawdowns))
    front.margins(x=0.1)
    error.axhline(0, color=BLACK, linewidth=0.6, zorder=1)
    error.set(xlabel="Time t [s]", ylabel=f"Error of {quantity} [{unit}]")
    title = "what a smaller dip costs; full marks: no other policy betters both"
    theme.letters(axes, (title, "what each policy does more or less than demanded"))
    figure.legend(loc="outside right upper")
    return figure


@styled
def energy_balances(balances: "list[Balance]") -> Figure:
    """Figure of balances [J], two bars each, inputs above outputs, on its own scale; a negative
    term counts on the other side, as "given back" or "taken back".
    """
    figure, axes = theme.new_figure(len(balances), 1, DOUBLE, 0.3 * DOUBLE * len(balances))
    for ax, mark, balance in zip(axes.flat, "abcdefgh", balances, strict=False):
        total = _draw_balance(ax, balance)
        theme.letter(ax, mark, f"{balance.name}: {total:.3g} {balance.unit} in all")
    return figure


def _draw_balance(ax: Axes, balance: "Balance") -> float:
    """Draw a balance; returns its total [J]."""
    inputs = {name: x for name, x in balance.inputs.items() if x > 0}
    inputs |= {f"{name}, given back": -x for name, x in balance.outputs.items() if x < 0}
    outputs = {name: x for name, x in balance.outputs.items() if x > 0}
    outputs |= {f"{name}, taken back": -x for name, x in balance.inputs.items() if x < 0}
    total = max(sum(inputs.values()), sum(outputs.values()))
    for row, terms in enumerate((inputs, outputs)):
        left = 0.0
        for i, (name, value) in enumerate(sorted(terms.items(), key=lambda term: -term[1])):
            amount = f"{value:.3g} {balance.unit}, {format_digits(100 * value / total, 2)} %"
            amount = amount if value > 1e-4 * total else "below 0.01 %"
            label = f"{'in' if row == 0 else 'out'}: {name} {amount}"
            color, hatch = CYCLE[(i + 3 * row) % len(CYCLE)], _HATCHES[i // len(CYCLE)]
            style = {"color": color, "alpha": 0.75, "hatch": hatch, "edgecolor": theme.WHITE}
            ax.barh(row, value, 0.7, left, linewidth=0.4, label=label, **style)
            left += value
    ax.set_yticks([0, 1], ["in", "out"])
    ax.set(ylim=(1.5, -0.5), xlim=(0, total or 1.0), xlabel=f"Energy [{balance.unit}]")
    ax.grid(visible=False)
    if total:
        ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    else:
        ax.text(0.5, 0.5, "nothing moved", ha="center", va="center", color=GRAY)
    return total

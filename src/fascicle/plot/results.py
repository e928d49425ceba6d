"""Pictures of results: forces, recruitment states, efficiencies, as commands draw them."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..bundle import Bundle
from ..bundle.space import Space, overlap
from ..energetics.efficiency import EfficiencyMap
from ..muscle import Muscle
from .curves import bundle_force_strain, force_strain
from .jumps import Curve, Jump, split_at_jumps
from .maps import draw_efficiency
from .style import BLACK, CYCLE, DOUBLE, GRAY, SINGLE, in_kilopascals, letter, new_figure, styled
from .style import force_strain_axes as label_axes


_POINTS = 301  # along a curve
_MOST_LABELS = 12
_FALL = 1e-4  # of a free strain: less is no reversal that anybody sees


def muscle_force(muscle: Muscle, pressures: list[float], strains: list[float]) -> Figure:
    """Force of `muscle` over the range of `strains` [-], a curve for each of `pressures` [Pa]."""
    return force_strain(muscle, np.unique(pressures), _smooth(strains))


@styled
def bundle_force(
    bundle: Bundle, states: list[list[float]], strains: list[float], resistance: bool
) -> Figure:
    """Force of `bundle` over the range of `strains` [-]: of one state with its units, or of many.

    `states` are pressures [Pa], one for each motor unit; `resistance` as for a bundle.
    """
    eps = _smooth(strains)
    if len(states) == 1:
        return bundle_force_strain(bundle, states[0], eps, resistance)
    force = bundle.force(np.asarray(states)[:, None, :], eps, resistance)
    figure, axes = new_figure(width=SINGLE)
    ax = axes[0, 0]
    label_axes(ax)
    for pressures, row, color in zip(states, force, _colors(len(states)), strict=True):
        label = ", ".join(f"{pressure / 1e3:.4g}" for pressure in pressures) + " kPa"
        ax.plot(eps, row, color=color, label=label)
    ax.margins(x=0)
    if len(states) <= _MOST_LABELS:
        ax.legend()
    return figure


@styled
def space(found: Space) -> Figure:
    """Regions of the recruitment states in `found`, their curves, and the overlaps."""
    figure, axes = new_figure(width=DOUBLE, height=0.45 * DOUBLE)
    ax = axes[0, 0]
    label_axes(ax)
    for state in range(1, len(found.force) + 1):
        color = CYCLE[(state - 1) % len(CYCLE)]
        ax.fill(*found.outline(state), color=color, alpha=0.15, linewidth=0)
        for level, row in enumerate(found.force[state - 1]):
            # where it would push, the bundle isn't loaded
            pulls = np.where(row >= 0, row, np.nan)
            label = f"state {state}" if level == len(found.level) - 1 else None
            width = 0.5 + 1.0 * level / max(len(found.level) - 1, 1)
            ax.plot(found.strain, pulls, color=color, linewidth=width, label=label)
    shared = overlap(found)
    for pair in range(len(shared.states)):
        strain, force = shared.outline(pair)
        hatched = {"facecolor": "none", "edgecolor": GRAY, "hatch": "////", "linewidth": 0}
        ax.fill(strain, force, label="overlap" if pair == 0 else None, **hatched)
    highest = in_kilopascals(found.supply_pressure)
    ax.set_title(f"{found.scheme} recruitment, up to {highest}", loc="left")
    ax.margins(x=0)
    ax.legend()
    return figure


@styled
def efficiency(maps: list[EfficiencyMap]) -> Figure:
    """Efficiency over force and strain, a panel for each of `maps`."""
    figure, axes = new_figure(1, len(maps), SINGLE * len(maps), 0.72 * SINGLE)
    for ax, mark, found in zip(axes[0], "ab", maps, strict=False):
        highest = float(np.nanmax(found.efficiency)) if found.state.any() else 1.0
        image = draw_efficiency(ax, found, highest)
        figure.colorbar(image, ax=ax, label="Efficiency η [–]")
        letter(ax, mark, f"{found.path}, {found.average:.3f} on average")
    return figure


@styled
def free_strain(
    found: Muscle | Bundle, pressures: np.ndarray, strains: np.ndarray, resistance: bool = True
) -> Figure:
    """Free strain over the pressure that varies most, a line for each state of the other units.

    **Arguments:**

    - `found`: the muscle or bundle [-].
    - `pressures`: of a muscle, or a row of all units' for each state [Pa].
    - `strains`: free strains there [-].
    - `resistance`: as for a bundle [-].

    **Returns:** the figure [-].
    """
    rows = np.reshape(pressures, (len(strains), -1))
    unit = int(np.argmax(np.ptp(rows, axis=0)))
    others = np.delete(rows, unit, axis=1)
    figure, axes = new_figure(width=SINGLE)
    ax = axes[0, 0]
    states = np.unique(others, axis=0)
    few = len(states) <= _MOST_LABELS
    lines: list[tuple[Curve, list[Jump]]] = []
    for state, color in zip(states, _colors(len(states)), strict=True):
        of_state = (others == state).all(axis=1)
        P, first = np.unique(rows[of_state, unit], return_index=True)
        eps = np.asarray(strains)[of_state][first]

        def curve(values: np.ndarray, state: np.ndarray = state) -> np.ndarray:
            if isinstance(found, Muscle):
                return np.asarray(found.free_strain(values))
            at = np.insert(np.tile(state, (len(values), 1)), unit, values, axis=1)
            return np.asarray(found.free_strain(at, resistance))

        between = _smooth(P.tolist()) if few else P
        line, jumps = split_at_jumps(between, curve(between) if few else eps, curve)
        lines.append((line, jumps))
        ax.plot(line[0] / 1e3, line[1], color=color, label=_label(state, unit))
        ax.plot(P / 1e3, eps, "o", color=color, markersize=2.4)
        for x, y in jumps:
            ax.plot(x / 1e3, y, color=color, linestyle=":", linewidth=1.0)
    turns = [turn for line, _ in lines if (turn := _turn(line))]
    if turns:
        x, y = np.transpose(turns)
        ax.plot(x / 1e3, y, "o", color=BLACK, markersize=4, zorder=6)
    symbol = f"P_{{{unit + 1}}}"
    of = "Pressure P" if isinstance(found, Muscle) else f"Pressure of unit {unit + 1}, ${symbol}$"
    ax.set_xlabel(f"{of} [kPa]")
    ax.set_ylabel("Free strain $ε_f$ [–]")
    ax.margins(x=0.02)
    signs = [Line2D([], [], color=GRAY, linestyle="", marker="o", markersize=2.4, label="computed")]
    if any(jumps for _, jumps in lines):
        signs.append(Line2D([], [], color=GRAY, linestyle=":", linewidth=1.0, label="jump"))
    if turns:
        signs.append(
            Line2D(
                [], [], color=BLACK, linestyle="", marker="o", markersize=4, label="reversal point"
            )
        )
    ax.legend(handles=[*(ax.get_legend_handles_labels()[0] if few else []), *signs])
    return figure


def _turn(line: Curve) -> tuple[float, float] | None:
    """Pressure [Pa] and strain [-] at which a curve that falls at first rises again, if it does."""
    P, eps = line
    at = int(np.nanargmin(eps))
    falls, rises = eps[0] - eps[at], np.nanmax(eps[at:]) - eps[at]
    return (float(P[at]), float(eps[at])) if min(falls, rises) > _FALL else None


def _label(state: np.ndarray, unit: int) -> str:
    """The pressures [Pa] of a `state`'s other units, `unit` [-] left out, in words."""
    names = [i + 1 for i in range(len(state) + 1) if i != unit]
    held = (f"$P_{{{i}}}$ = {in_kilopascals(P)}" for i, P in zip(names, state, strict=True))
    return ", ".join(held) or "free strain"


def _smooth(strains: list[float]) -> np.ndarray:
    """`strains` [-], and enough between them for curves that look like curves."""
    return np.union1d(strains, np.linspace(min(strains), max(strains), _POINTS))


def _colors(count: int) -> list[str]:
    """Colors for `count` lines [-], again from the first where there are too few."""
    return [CYCLE[i % len(CYCLE)] for i in range(count)]

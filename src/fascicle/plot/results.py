"""Pictures of results: forces, recruitment states, efficiencies, as commands draw them."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..bundle import Bundle
from ..bundle.space import Space, overlap
from ..energetics.efficiency import EfficiencyMap
from ..muscle import Muscle
from .curves import bundle_force_strain, force_strain
from .curves import free_strain as free_strain_curve
from .maps import draw_efficiency
from .style import CYCLE, DOUBLE, GRAY, SINGLE, in_kilopascals, letter, new_figure, styled
from .style import force_strain_axes as label_axes


_POINTS = 301  # along a curve
_MOST_LABELS = 12


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
def free_strain(pressures: Any, strains: Any) -> Figure:
    """Free `strains` [-] over `pressures` [Pa] of what varies."""
    order = np.argsort(pressures)
    return free_strain_curve(
        np.asarray(pressures)[order], {"free strain": np.asarray(strains)[order]}
    )


def _smooth(strains: list[float]) -> np.ndarray:
    """`strains` [-], and enough between them for curves that look like curves."""
    return np.union1d(strains, np.linspace(min(strains), max(strains), _POINTS))


def _colors(count: int) -> list[str]:
    """Colors for `count` lines [-], again from the first where there are too few."""
    return [CYCLE[i % len(CYCLE)] for i in range(count)]

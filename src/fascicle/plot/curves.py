"""Force over contraction, free strain over pressure: lines, labelled and with units."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..bundle import Bundle
from ..bundle.reversal import Reversal
from ..core.errors import InvalidInputError
from ..core.validation import to_si
from ..muscle import Muscle
from .components import components_legend, components_of, draw_components
from .jumps import broken
from .style import (
    BLACK,
    CYCLE,
    DOUBLE,
    SINGLE,
    force_strain_axes,
    in_kilopascals,
    letter,
    new_figure,
    pressure_colors,
    styled,
)


_SIDE_BY_SIDE = 4  # more panels than this are hard to read in one figure


@styled
def force_strain(muscle: Muscle, pressures: Any, strains: Any, components: bool = False) -> Figure:
    """A muscle's force over contraction, a curve for each pressure.

    **Arguments:**

    - `muscle`: the muscle [-].
    - `pressures`: gauge pressures [Pa].
    - `strains`: contractions [-], rising.
    - `components`: a panel for each pressure with the force's parts [-].

    **Returns:** the figure [-].

    **Raises:** `ValueError` for more than four pressures with components.
    """
    P = np.atleast_1d(np.asarray(to_si(pressures, "pressures", "Pa"), float))
    eps = np.asarray(to_si(strains, "strain", "-"), float)
    if components:
        if P.size > _SIDE_BY_SIDE:
            raise InvalidInputError(
                "pressures", f": at most {_SIDE_BY_SIDE} with components", P.size
            )
        columns = min(P.size, 2)
        rows = -(-P.size // columns)
        figure, axes = new_figure(rows, columns, DOUBLE if columns > 1 else SINGLE)
        for spare in axes.flat[P.size :]:
            spare.set_visible(False)
        parts = components_of(muscle, P, eps)
        for i, (ax, mark) in enumerate(zip(axes.flat, "abcd", strict=False)):
            if i < P.size:
                draw_components(ax, parts, i)
                letter(ax, mark, in_kilopascals(P[i]))
        components_legend(figure, axes.flat[0])
        return figure
    figure, axes = new_figure(width=SINGLE)
    draw_pressures(axes[0, 0], eps, np.asarray(muscle.force(P[:, None], eps)), P)
    return figure


@styled
def bundle_force_strain(
    bundle: Bundle, pressures: Any, strains: Any, resistance: bool = True
) -> Figure:
    """A bundle's force over contraction at given pressures, and what each unit adds.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: gauge pressures, one for each motor unit [Pa].
    - `strains`: contractions [-], rising.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** the figure [-].
    """
    P = np.asarray(to_si(pressures, "pressures", "Pa"), float)
    eps = np.asarray(to_si(strains, "strain", "-"), float)
    each = np.asarray(bundle.unit_forces(P, eps, resistance))
    figure, axes = new_figure(width=SINGLE)
    ax = axes[0, 0]
    force_strain_axes(ax)
    for i, unit in enumerate(bundle.motor_units):
        label = f"unit {i + 1}: {int(unit.count)} × {in_kilopascals(P[i])}"
        ax.plot(eps, each[:, i], color=CYCLE[i % len(CYCLE)], label=label, linewidth=1.0)
    ax.plot(eps, each.sum(axis=-1), color=BLACK, label="bundle", linewidth=1.6)
    ax.margins(x=0)
    ax.legend()
    return figure


@styled
def free_strain(
    pressures: Any,
    strains: Mapping[str, Any],
    pressure_of: str = "P",
    turns: Mapping[str, Reversal] | None = None,
) -> Figure:
    """Free strain over pressure, a line for each entry of `strains`.

    **Arguments:**

    - `pressures`: gauge pressures [Pa].
    - `strains`: free strains by label [-].
    - `pressure_of`: the pressure's symbol [-].
    - `turns`: where lines turn, by label [-]; those that jump there are open, with a dotted jump.

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(width=SINGLE)
    ax, P = axes[0, 0], np.asarray(pressures, float)
    draw_free_strain(ax, P, strains, pressure_of)
    for label, turn in (turns or {}).items():
        (line,) = (one for one in ax.get_lines() if one.get_label() == label)
        (at, eps), jump = broken(P, np.asarray(strains[label], float), turn)
        line.set_data(at / 1e3, eps)
        ax.plot(jump[0] / 1e3, jump[1], color=line.get_color(), linestyle=":", linewidth=1.0)
    if len(strains) > 1:
        ax.legend()
    return figure


def draw_pressures(ax: Axes, strain: np.ndarray, force: np.ndarray, pressures: np.ndarray) -> None:
    """Curves [N] over `strain` [-], a row and a color for each of `pressures` [Pa]."""
    force_strain_axes(ax)
    for row, pressure, color in zip(force, pressures, pressure_colors(len(force)), strict=True):
        ax.plot(strain, row, color=color, label=in_kilopascals(pressure))
    ax.margins(x=0)
    # highest pressure on top, as the curves lie
    handles, labels = ax.get_legend_handles_labels()
    ax.legend(handles[::-1], labels[::-1])


def draw_free_strain(
    ax: Axes, pressures: np.ndarray, strains: Mapping[str, Any], pressure_of: str = "P"
) -> None:
    """Free strains [-] by label over `pressures` [Pa]."""
    for (label, strain), color in zip(strains.items(), CYCLE * 3, strict=False):
        ax.plot(pressures / 1e3, np.asarray(strain), color=color, label=label)
    ax.set_xlabel(f"Pressure {pressure_of} [kPa]")
    ax.set_ylabel("Free strain $ε_f$ [–]")
    ax.margins(x=0)

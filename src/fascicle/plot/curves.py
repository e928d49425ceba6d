"""Force over contraction and free strain over pressure: curves, labeled and with units.

A force can be split into components, as in the paper's Fig. 6; dashed is the tension law continued
past the free strain. Curves of free strain that jump are open there, with the jump dotted.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..bundle import Bundle, recruitment
from ..bundle.recruitment import overlap
from ..bundle.reversal import Reversal
from ..core.errors import InvalidInputError
from ..core.types import Float
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN, to_si
from ..muscle import Muscle
from ..muscle.tuning import TunedTension
from . import theme
from .theme import BLACK, CYCLE, DOUBLE, GRAY, VERMILION, in_kilopascals, styled
from .workspace import workspace


Line = tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]]  # [Pa], [-]

_MAX_PANELS = 4  # more are hard to read in one figure
_MAX_LABELS = 12  # more hide the curves
_POINTS = 301  # along a curve: smooth in print
_HIGHEST = 400e3  # Pa, a usual supply, for a muscle whose tuning has no range of pressure
_VISIBLE = 1e-4  # of strain: a smaller step is no wider than the line
_HALVINGS = 40  # of an interval of pressure: to its last bits
_JUMP = 1e-6  # of strain: a smooth curve can't rise as much in the halved interval
_DASHED: dict[str, Any] = {"linestyle": (0, (4, 2)), "linewidth": 1.0}
_DOTTED: dict[str, Any] = {"linestyle": ":", "linewidth": 1.0}


@dataclass(frozen=True)
class Components:
    """Forces [N] over `pressure` [Pa] (rows) and `strain` [-] (columns): the law's `mesh`,
    `wall` (bladder and bending) and `force`; `straight_mesh` and `straight_bladder` of the
    tension law alone; `free_strain` and `collapse_strain` [-] by pressure.
    """

    pressure: np.ndarray
    strain: np.ndarray
    mesh: np.ndarray
    wall: np.ndarray
    force: np.ndarray
    straight_mesh: np.ndarray
    straight_bladder: np.ndarray
    free_strain: np.ndarray
    collapse_strain: np.ndarray

    @property
    def straight_force(self) -> np.ndarray:
        """Force of the tension law [N], continued past the free strain."""
        return self.straight_mesh + self.straight_bladder

    def at(self, rows: Sequence[int]) -> "Components":
        """Components at some of the pressures, by their `rows`."""
        names = [field.name for field in fields(self) if field.name != "strain"]
        return replace(self, **{name: getattr(self, name)[list(rows)] for name in names})


def components_of(muscle: Muscle, pressures: Any, strains: Any) -> Components:
    """Force and components [N] of `muscle` at all `pressures` [Pa] and `strains` [-], to which free
    and collapse strains are added, so that kinks are drawn sharp.
    """
    P, eps = np.asarray(pressures, float), np.asarray(strains, float)
    free, collapse = (np.asarray(x(P)) for x in (muscle.free_strain, muscle.collapse_strain))
    # a fixed number of points, whichever kinks lie inside
    kinks = np.clip(np.nan_to_num(np.r_[free, collapse], posinf=eps.max()), eps.min(), eps.max())
    eps = np.sort(np.r_[eps, kinks])
    response = muscle.response(P[:, None], eps)
    tension = TunedTension(muscle.tension, muscle.bladder, muscle.tuning, muscle.ends)
    pull = tension.pull(P[:, None], eps)[:2]
    mesh, bladder = (np.broadcast_to(np.asarray(x), (P.size, eps.size)) for x in pull)
    law, force = np.asarray(response.mesh), np.asarray(response.force)
    wall = np.asarray(response.bladder) + np.asarray(response.bending)
    return Components(P, eps, law, wall, force, mesh, bladder, free, collapse)


@styled
def force_strain(
    muscle: Muscle,
    pressures: Any = None,
    strains: Any = None,
    components: bool = False,
    ax: Axes | None = None,
) -> Figure:
    """Figure of a muscle's force over contraction, a curve for each pressure, on the axes `ax`, or
    with `components` a panel for each pressure with mesh and bladder force.

    `pressures` [Pa]; default: even ones up to the highest that was measured. `strains` [-], rising;
    default: from rest to past the largest free strain. `InvalidInputError` for arrays of muscles,
    values off the domain, and more than four pressures with components.
    """
    if np.ndim(muscle.length + muscle.outer_radius + muscle.wall_thickness + muscle.braid_angle):
        raise InvalidInputError("muscle", "must be a single one to be drawn, got an array", None)
    if pressures is None:
        rows = np.asarray(muscle.tuning.pressures)
        measured = float(np.max(rows)) + float(muscle.tuning.dead_band)
        highest = min(measured, HIGHEST_PRESSURE) if rows.size > 1 else _HIGHEST
        pressures = np.linspace(0.0, highest, 4 if components else 5)
    P = np.atleast_1d(np.asarray(to_si(pressures, "pressures", "Pa"), float))
    if strains is None:
        strains = _default_strains(float(np.max(muscle.free_strain(P))))
    eps = np.asarray(to_si(strains, "strain", "-"), float)
    if not components:
        figure, ax = theme.single_axes(ax)
        force = np.asarray(muscle.force(P[:, None], eps))
        theme.force_strain_axes(ax)
        for row, pressure, color in zip(force, P, theme.pressure_colors(len(force)), strict=True):
            ax.plot(eps, row, color=color, label=in_kilopascals(pressure))
        ax.margins(x=0)
        ax.legend(reverse=True)  # highest pressure on top, as the curves lie
        return figure
    if ax is not None:
        rule = "must be left out with components, which have a panel for each pressure"
        raise InvalidInputError("ax", rule, None)
    if P.size > _MAX_PANELS:
        raise InvalidInputError("pressures", f": at most {_MAX_PANELS} with components", P.size)
    columns = min(P.size, 2)
    figure, axes = theme.new_panels(P.size, columns, DOUBLE if columns > 1 else theme.SINGLE)
    forces = components_of(muscle, P, eps)
    for row, panel in enumerate(axes.flat[: P.size]):
        draw_components(panel, forces, row)
    theme.letters(axes, map(in_kilopascals, P))
    components_legend(figure, axes.flat[0])
    return figure


def draw_components(ax: Axes, components: Components, row: int) -> None:
    """Draw the curves at one pressure, a `row` of `components`."""
    eps = components.strain
    past = eps >= components.free_strain[row]
    theme.force_strain_axes(ax)
    for force, color, label in (
        (components.straight_mesh, theme.BLUE, r"$F_{mesh}$, straight"),
        (components.straight_bladder, VERMILION, r"$F_{bladder}$, straight"),
        (components.straight_force, GRAY, r"$F_{mesh} + F_{bladder}$, straight"),
    ):
        ax.plot(eps[past], force[row][past], color=color, label=label, **_DASHED)
    for force, color, width, label in (
        (components.mesh, theme.BLUE, None, r"$F'_{mesh}$, along the bent arc"),
        (components.wall, VERMILION, None, r"$F_{bladder}$ with bending $F'_b$"),
        (components.force, BLACK, 1.8, r"$F_{total}$"),
    ):
        ax.plot(eps, force[row], color=color, linewidth=width, label=label)
    ax.set_xlim(eps[0], eps[-1])


def components_legend(figure: Figure, ax: Axes) -> None:
    """Add one legend for all panels, below them, from the curves of `ax`."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=3)


@styled
def force_comparison(
    muscles: Mapping[str, Muscle],
    pressures: Any,
    strains: Any,
    chosen_strain: float,
    ax: Axes | None = None,
) -> Figure:
    """Figure of the force of several `muscles`, each at its own of the `pressures` [Pa], over
    rising `strains` [-], of which `chosen_strain` is marked; on the axes `ax`, or new ones.
    """
    figure, ax = theme.single_axes(ax)
    theme.force_strain_axes(ax)
    styles = itertools.cycle(zip(CYCLE, theme.DASHES, strict=False))
    rows = zip(muscles.items(), pressures, styles, strict=False)
    for (name, muscle), pressure, (color, dashes) in rows:
        label = name.replace("$", r"\$")  # else it would be a formula
        force = np.asarray(muscle.force(pressure, strains))
        ax.plot(strains, force, color=color, linestyle=(0, dashes), label=label)
    ax.axvline(chosen_strain, color=GRAY, linewidth=0.6)
    ax.margins(x=0)
    ax.legend()
    return figure


@styled
def bundle_force_strain(
    bundle: Bundle,
    pressures: Any = None,
    strains: Any = None,
    resistance: bool = True,
    ax: Axes | None = None,
) -> Figure:
    """Figure of a bundle's force over contraction: one state with its units, several states, or,
    without pressures, the workspace of all recruitment states; on the axes `ax`, or new ones.

    `pressures` [Pa]: one for each motor unit, or a row of them for each state. `strains` [-],
    rising; default: from rest to past the free strain. `resistance`: of units past their own free
    strain. `InvalidInputError` without pressures and without a supply pressure.
    """
    if pressures is None and bundle.supply_pressure is None:
        rule = "must be given in Pa, one for each motor unit"
        remedy = "the bundle has no supply pressure, for which its states would be drawn"
        raise InvalidInputError("pressures", rule, None, remedy)
    if pressures is None:
        space = recruitment.workspace(bundle, strain=strains, resistance=resistance)
        return workspace(space, overlap(space), ax)
    if strains is None:
        strains = _default_strains(float(bundle.free_strain(pressures, resistance=False)))
    P = np.asarray(to_si(pressures, "pressures", "Pa"), float)
    eps = np.asarray(to_si(strains, "strain", "-"), float)
    figure, ax = theme.single_axes(ax)
    theme.force_strain_axes(ax)
    if P.ndim == 1:
        forces = np.asarray(bundle.unit_forces(P, eps, resistance))
        for i, unit in enumerate(bundle.motor_units):
            label = f"unit {i + 1}: {int(unit.count)} × {in_kilopascals(P[i])}"
            ax.plot(eps, forces[:, i], color=CYCLE[i % len(CYCLE)], label=label, linewidth=1.0)
        ax.plot(eps, forces.sum(axis=-1), color=BLACK, label="bundle", linewidth=1.6)
    else:
        forces = np.asarray(bundle.force(P[:, None, :], eps, resistance))
        for i, (state, row) in enumerate(zip(P, forces, strict=True)):
            label = ", ".join(f"{pressure / 1e3:.4g}" for pressure in state) + " kPa"
            ax.plot(eps, row, color=CYCLE[i % len(CYCLE)], label=label)
    ax.margins(x=0)
    if len(P) <= _MAX_LABELS:
        ax.legend()
    return figure


@styled
def free_strain(
    pressures: Any,
    strains: Mapping[str, Any],
    pressure_of: str = "P",
    turns: Mapping[str, Reversal] | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Figure of free strain over `pressures` [Pa], a curve for each label of `strains` [-], on the
    axes `ax`, or new ones.

    `pressure_of`: the pressure's symbol; `turns`: reversal points by label, where jumps are dotted.
    """
    figure, ax = theme.single_axes(ax)
    P = np.asarray(pressures, float)
    draw_free_strain(ax, P, strains, pressure_of)
    for label, turn in (turns or {}).items():
        (line,) = (line for line in ax.get_lines() if line.get_label() == label)
        curve, jump = split_at_reversal(P, np.asarray(strains[label], float), turn)
        line.set_data(curve[0] / 1e3, curve[1])
        ax.plot(jump[0] / 1e3, jump[1], color=line.get_color(), **_DOTTED)
    if len(strains) > 1:
        ax.legend()
    return figure


def draw_free_strain(
    ax: Axes, pressures: np.ndarray, strains: Mapping[str, Any], pressure_of: str = "P"
) -> None:
    """Draw free strains [-] by label over `pressures` [Pa]."""
    for (label, strain), color in zip(strains.items(), CYCLE * 3, strict=False):
        ax.plot(pressures / 1e3, np.asarray(strain), color=color, label=label)
    ax.set(xlabel=f"Pressure {pressure_of} [kPa]", ylabel="Free strain $ε_f$ [–]")
    ax.margins(x=0)


@styled
def free_strain_states(
    system: Muscle | Bundle, pressures: np.ndarray, strains: np.ndarray, resistance: bool = True
) -> Figure:
    """Figure of free strain over the pressure that varies most, a curve for each state.

    `pressures`: of a muscle, or a row of all units' for each state [Pa]; `strains`: their free
    strains [-]; `resistance`: of units past their own free strain.
    """
    rows = np.reshape(pressures, (len(strains), -1))
    unit = int(np.argmax(np.ptp(rows, axis=0)))
    constant = np.delete(rows, unit, axis=1)
    states = np.unique(constant, axis=0)
    names = [f"$P_{{{i + 1}}}$" for i in range(rows.shape[1]) if i != unit]
    labeled = len(states) <= _MAX_LABELS
    figure, axes = theme.new_figure(width=theme.SINGLE)
    ax, jump_count, turn_points = axes[0, 0], 0, []
    for i, state in enumerate(states):
        mask = (constant == state).all(axis=1)
        P, first = np.unique(rows[mask, unit], return_index=True)
        eps = np.asarray(strains)[mask][first]

        def free_strain_at(values: np.ndarray, state: np.ndarray = state) -> np.ndarray:
            """Free strain [-]; varied unit at `values` [Pa], the others at `state` [Pa]."""
            if isinstance(system, Muscle):
                return np.asarray(system.free_strain(values))
            points = np.insert(np.tile(state, (len(values), 1)), unit, values, axis=1)
            return np.asarray(system.free_strain(points, resistance))

        points = smooth(P) if labeled else P
        line, jumps = split_at_jumps(
            points, free_strain_at(points) if labeled else eps, free_strain_at
        )
        color = CYCLE[i % len(CYCLE)]
        levels = (f"{n} = {in_kilopascals(p)}" for n, p in zip(names, state, strict=True))
        ax.plot(line[0] / 1e3, line[1], color=color, label=", ".join(levels) or "free strain")
        ax.plot(P / 1e3, eps, "o", color=color, markersize=2.4)
        for jump in jumps:
            ax.plot(jump[0] / 1e3, jump[1], color=color, **_DOTTED)
        jump_count += len(jumps)
        lowest = int(np.nanargmin(line[1]))
        # an invisible fall is no reversal
        if min(line[1][0], np.nanmax(line[1][lowest:])) - line[1][lowest] > _VISIBLE:
            turn_points.append((line[0][lowest] / 1e3, line[1][lowest]))
    dot: dict[str, Any] = {"linestyle": "", "marker": "o"}
    signs = [Line2D([], [], color=GRAY, markersize=2.4, label="computed", **dot)]
    if jump_count:
        signs.append(Line2D([], [], color=GRAY, label="jump", **_DOTTED))
    if turn_points:
        ax.plot(*np.transpose(turn_points), "o", color=BLACK, markersize=4, zorder=6)
        signs.append(Line2D([], [], color=BLACK, markersize=4, label="reversal point", **dot))
    symbol = "P" if isinstance(system, Muscle) else f"of unit {unit + 1}, $P_{{{unit + 1}}}$"
    ax.set(xlabel=f"Pressure {symbol} [kPa]", ylabel="Free strain $ε_f$ [–]")
    ax.margins(x=0.02)
    ax.legend(handles=[*(ax.get_legend_handles_labels()[0] if labeled else []), *signs])
    return figure


def split_at_jumps(
    pressure: np.ndarray, strain: np.ndarray, curve: Callable[[np.ndarray], np.ndarray]
) -> tuple[Line, list[Line]]:
    """Free `strain` [-] over rising `pressure` [Pa], with a gap (NaN) at each jump, and the two
    ends of each jump; `curve`: free strains [-] at any pressures [Pa].
    """
    steps = np.flatnonzero(np.abs(np.diff(strain)) > _VISIBLE)
    low, high = pressure[steps], pressure[steps + 1]
    before, after = strain[steps], strain[steps + 1]
    for _ in range(_HALVINGS if steps.size else 0):
        middle = (low + high) / 2
        value = curve(middle)
        left = np.abs(value - before) > np.abs(after - value)  # the larger step lies there
        low, before = np.where(left, low, middle), np.where(left, before, value)
        high, after = np.where(left, middle, high), np.where(left, value, after)
    jumps = np.flatnonzero(np.abs(after - before) > _JUMP)
    indices = np.repeat(steps[jumps] + 1, 3)
    gaps = np.full(jumps.size, np.nan)
    P = np.insert(pressure, indices, np.stack([low, high, high], axis=-1)[jumps].ravel())
    ends = np.stack([before[jumps], gaps, after[jumps]], axis=-1)
    line = (P, np.insert(strain, indices, ends.ravel()))
    return line, [(np.array([low[i], high[i]]), np.array([before[i], after[i]])) for i in jumps]


def split_at_reversal(
    pressure: np.ndarray, strain: np.ndarray, turn: Reversal
) -> tuple[Line, Line]:
    """Free `strain` [-] over rising `pressure` [Pa] through its reversal point `turn`, with a gap
    (NaN) if it jumps there, and the two ends of the jump, empty without one.
    """
    jump = (np.empty(0), np.empty(0))
    if turn.depth <= 0:
        return (pressure, strain), jump
    after = int(np.searchsorted(pressure, turn.pressure))
    P, eps = [turn.pressure], [turn.free_strain]
    if turn.jump:
        ends = [max(after - 1, 0), min(after, len(strain) - 1)]
        gaps = np.abs(strain[ends] - turn.free_strain)
        far = ends[int(gaps[1] >= gaps[0])]
        jump = np.array([turn.pressure, pressure[far]]), np.array([turn.free_strain, strain[far]])
        P, eps = P * 2, [np.nan, *eps] if gaps[0] > gaps[1] else [*eps, np.nan]
    indices = [after] * len(P)
    return (np.insert(pressure, indices, P), np.insert(strain, indices, eps)), jump


def _default_strains(largest_free_strain: float) -> np.ndarray:
    """Strains [-] from 0 to a quarter past it, to 0.05 at least and `LARGEST_STRAIN` at most."""
    return np.linspace(0.0, min(max(1.25 * largest_free_strain, 0.05), LARGEST_STRAIN), _POINTS)


def smooth(values: Any) -> np.ndarray:
    """Sorted `values`, and even points between them, enough for a smooth curve."""
    return np.union1d(values, np.linspace(np.min(values), np.max(values), _POINTS))

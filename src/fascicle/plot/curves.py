"""Force over contraction, free strain over pressure: lines, labeled and with units.

A force can be taken apart, as in the paper's Fig. 6: mesh, bladder with bending, and their sum.
Beside them, dashed, the tension law continued past the free strain: what a model without buckling
would give. Curves of free strain that jump are open there, with the jump dotted.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..bundle import Bundle
from ..bundle.reversal import Reversal
from ..core.errors import InvalidInputError
from ..core.types import Float
from ..core.validation import to_si
from ..muscle import Muscle
from ..muscle.tuning import TunedTension
from .style import (
    BLACK,
    BLUE,
    CYCLE,
    DOUBLE,
    GRAY,
    SINGLE,
    VERMILION,
    force_strain_axes,
    in_kilopascals,
    letter,
    new_figure,
    pressure_colors,
    styled,
)


Line = tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]]  # [Pa], [-]

_MOST_PANELS = 4  # more are hard to read in one figure
_MOST_LABELS = 12
_POINTS = 301  # along a curve
_VISIBLE = 1e-4  # of strain: a smaller step is no wider than the line
_HALVINGS = 40  # of an interval of pressure: to its last bits
_JUMP = 1e-6  # of strain: what a smooth curve can't rise in what is left of the interval
_DASHED: dict[str, Any] = {"linestyle": (0, (4, 2)), "linewidth": 1.0}


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
        """The tension law's force [N], continued past the free strain."""
        return self.straight_mesh + self.straight_bladder

    def at(self, rows: Sequence[int]) -> "Components":
        """Components at some of the pressures, by their `rows`."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Components(**{
            name: value if name == "strain" else value[list(rows)] for name, value in values.items()
        })  # fmt: skip


def components_of(muscle: Muscle, pressures: Any, strains: Any) -> Components:
    """Force and parts [N] of `muscle` at all `pressures` [Pa] and `strains` [-].

    Free and collapse strains join the strains, so that kinks are drawn sharp.
    """
    P, eps = np.asarray(pressures, float), np.asarray(strains, float)
    free, collapse = (np.asarray(x(P)) for x in (muscle.free_strain, muscle.collapse_strain))
    # a fixed number of points, whichever kinks lie inside
    kinks = np.clip(np.nan_to_num(np.r_[free, collapse], posinf=eps.max()), eps.min(), eps.max())
    eps = np.sort(np.r_[eps, kinks])
    response = muscle.response(P[:, None], eps)
    tension = TunedTension(muscle.tension, muscle.bladder, muscle.tuning, muscle.ends)
    mesh, bladder = (
        np.broadcast_to(np.asarray(x), (P.size, eps.size))
        for x in tension.components(P[:, None], eps)
    )
    wall = np.asarray(response.bladder) + np.asarray(response.bending)
    return Components(
        P, eps, np.asarray(response.mesh), wall, np.asarray(response.force), mesh, bladder,
        free, collapse,
    )  # fmt: skip


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
    if not components:
        figure, axes = new_figure(width=SINGLE)
        ax, force = axes[0, 0], np.asarray(muscle.force(P[:, None], eps))
        force_strain_axes(ax)
        for row, pressure, color in zip(force, P, pressure_colors(len(force)), strict=True):
            ax.plot(eps, row, color=color, label=in_kilopascals(pressure))
        ax.margins(x=0)
        # highest pressure on top, as the curves lie
        handles, labels = ax.get_legend_handles_labels()
        ax.legend(handles[::-1], labels[::-1])
        return figure
    if P.size > _MOST_PANELS:
        raise InvalidInputError("pressures", f": at most {_MOST_PANELS} with components", P.size)
    columns = min(P.size, 2)
    rows = -(-P.size // columns)
    figure, axes = new_figure(rows, columns, DOUBLE if columns > 1 else SINGLE)
    for spare in axes.flat[P.size :]:
        spare.set_visible(False)
    parts = components_of(muscle, P, eps)
    for i, (ax, mark) in enumerate(zip(axes.flat[: P.size], "abcd", strict=False)):
        draw_components(ax, parts, i)
        letter(ax, mark, in_kilopascals(P[i]))
    components_legend(figure, axes.flat[0])
    return figure


def draw_components(ax: Axes, parts: Components, row: int) -> None:
    """Draw the curves at one pressure, a `row` of `parts`."""
    eps = parts.strain
    past = eps >= parts.free_strain[row]
    force_strain_axes(ax)
    for force, color, label in (
        (parts.straight_mesh, BLUE, r"$F_{mesh}$, straight"),
        (parts.straight_bladder, VERMILION, r"$F_{bladder}$, straight"),
        (parts.straight_force, GRAY, r"$F_{mesh} + F_{bladder}$, straight"),
    ):
        ax.plot(eps[past], force[row][past], color=color, label=label, **_DASHED)
    wall = r"$F_{bladder}$ with bending $F'_b$"
    ax.plot(eps, parts.mesh[row], color=BLUE, label=r"$F'_{mesh}$, along the bent arc")
    ax.plot(eps, parts.wall[row], color=VERMILION, label=wall)
    ax.plot(eps, parts.force[row], color=BLACK, linewidth=1.8, label=r"$F_{total}$")
    ax.set_xlim(eps[0], eps[-1])


def components_legend(figure: Figure, ax: Axes) -> None:
    """Add one legend for all panels, below them, from the curves of `ax`."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=3)


@styled
def bundle_force_strain(
    bundle: Bundle, pressures: Any, strains: Any, resistance: bool = True
) -> Figure:
    """A bundle's force over contraction: of one state with each unit's share, or of several states.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: gauge pressures, one for each motor unit, or a row of them for each state [Pa].
    - `strains`: contractions [-], rising.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** the figure [-].
    """
    P = np.asarray(to_si(pressures, "pressures", "Pa"), float)
    eps = np.asarray(to_si(strains, "strain", "-"), float)
    figure, axes = new_figure(width=SINGLE)
    ax = axes[0, 0]
    force_strain_axes(ax)
    if P.ndim == 1:
        each = np.asarray(bundle.unit_forces(P, eps, resistance))
        for i, unit in enumerate(bundle.motor_units):
            label = f"unit {i + 1}: {int(unit.count)} × {in_kilopascals(P[i])}"
            ax.plot(eps, each[:, i], color=CYCLE[i % len(CYCLE)], label=label, linewidth=1.0)
        ax.plot(eps, each.sum(axis=-1), color=BLACK, label="bundle", linewidth=1.6)
    else:
        force = np.asarray(bundle.force(P[:, None, :], eps, resistance))
        for i, (state, row) in enumerate(zip(P, force, strict=True)):
            label = ", ".join(f"{pressure / 1e3:.4g}" for pressure in state) + " kPa"
            ax.plot(eps, row, color=CYCLE[i % len(CYCLE)], label=label)
    ax.margins(x=0)
    if len(P) <= _MOST_LABELS:
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
    - `turns`: reversal points of lines, by label [-]; a line that jumps there is open, with a
      dotted jump.

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(width=SINGLE)
    ax, P = axes[0, 0], np.asarray(pressures, float)
    draw_free_strain(ax, P, strains, pressure_of)
    for label, turn in (turns or {}).items():
        (line,) = (line for line in ax.get_lines() if line.get_label() == label)
        curve, jump = split_at_reversal(P, np.asarray(strains[label], float), turn)
        line.set_data(curve[0] / 1e3, curve[1])
        _draw_jump(ax, jump, line.get_color())
    if len(strains) > 1:
        ax.legend()
    return figure


def draw_free_strain(
    ax: Axes, pressures: np.ndarray, strains: Mapping[str, Any], pressure_of: str = "P"
) -> None:
    """Draw free strains [-] by label over `pressures` [Pa]."""
    for (label, strain), color in zip(strains.items(), CYCLE * 3, strict=False):
        ax.plot(pressures / 1e3, np.asarray(strain), color=color, label=label)
    ax.set_xlabel(f"Pressure {pressure_of} [kPa]")
    ax.set_ylabel("Free strain $ε_f$ [–]")
    ax.margins(x=0)


@styled
def free_strain_states(
    system: Muscle | Bundle, pressures: np.ndarray, strains: np.ndarray, resistance: bool = True
) -> Figure:
    """Free strain over the pressure that varies most, a line for each state of the other units.

    **Arguments:**

    - `system`: the muscle or bundle [-].
    - `pressures`: of a muscle, or a row of all units' for each state [Pa].
    - `strains`: free strains there [-].
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** the figure [-].
    """
    rows = np.reshape(pressures, (len(strains), -1))
    unit = int(np.argmax(np.ptp(rows, axis=0)))
    others = np.delete(rows, unit, axis=1)
    figure, axes = new_figure(width=SINGLE)
    ax = axes[0, 0]
    states = np.unique(others, axis=0)
    few = len(states) <= _MOST_LABELS
    any_jump, turns = False, []
    for i, state in enumerate(states):
        mask = (others == state).all(axis=1)
        P, first = np.unique(rows[mask, unit], return_index=True)
        eps = np.asarray(strains)[mask][first]

        def curve(values: np.ndarray, state: np.ndarray = state) -> np.ndarray:
            if isinstance(system, Muscle):
                return np.asarray(system.free_strain(values))
            points = np.insert(np.tile(state, (len(values), 1)), unit, values, axis=1)
            return np.asarray(system.free_strain(points, resistance))

        points = smooth(P) if few else P
        line, jumps = split_at_jumps(points, curve(points) if few else eps, curve)
        color = CYCLE[i % len(CYCLE)]
        ax.plot(line[0] / 1e3, line[1], color=color, label=_state_label(state, unit))
        ax.plot(P / 1e3, eps, "o", color=color, markersize=2.4)
        for jump in jumps:
            _draw_jump(ax, jump, color)
        any_jump |= bool(jumps)
        least = int(np.nanargmin(line[1]))
        # a fall that nobody sees is no reversal
        if min(line[1][0], np.nanmax(line[1][least:])) - line[1][least] > _VISIBLE:
            turns.append((line[0][least] / 1e3, line[1][least]))
    dot: dict[str, Any] = {"linestyle": "", "marker": "o"}
    signs = [Line2D([], [], color=GRAY, markersize=2.4, label="computed", **dot)]
    if any_jump:
        signs.append(Line2D([], [], color=GRAY, linestyle=":", linewidth=1.0, label="jump"))
    if turns:
        ax.plot(*np.transpose(turns), "o", color=BLACK, markersize=4, zorder=6)
        signs.append(Line2D([], [], color=BLACK, markersize=4, label="reversal point", **dot))
    symbol = "Pressure P" if isinstance(system, Muscle) else (
        f"Pressure of unit {unit + 1}, $P_{{{unit + 1}}}$"
    )  # fmt: skip
    ax.set(xlabel=f"{symbol} [kPa]", ylabel="Free strain $ε_f$ [–]")
    ax.margins(x=0.02)
    ax.legend(handles=[*(ax.get_legend_handles_labels()[0] if few else []), *signs])
    return figure


def split_at_jumps(
    pressure: np.ndarray, strain: np.ndarray, curve: Callable[[np.ndarray], np.ndarray]
) -> tuple[Line, list[Line]]:
    """A curve of free strain, open wherever it jumps between two of its points.

    **Arguments:**

    - `pressure`: of the unit that varies [Pa], rising.
    - `strain`: free strains there [-].
    - `curve`: free strains [-] at any pressures [Pa].

    **Returns:** pressures [Pa] and strains [-] of the curve, NaN in each gap; and the two ends of
    each jump.
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
    """A curve of free strain through its reversal point, open where it jumps there.

    **Arguments:**

    - `pressure`: of the second unit [Pa], rising.
    - `strain`: free strains there [-].
    - `turn`: the reversal point [-].

    **Returns:** pressures [Pa] and strains [-] of the curve, NaN in the gap of a jump; and those
    of the jump's two ends, or none.
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


def smooth(values: Any) -> np.ndarray:
    """`values`, and enough between them for curves that look like curves."""
    return np.union1d(values, np.linspace(np.min(values), np.max(values), _POINTS))


def _draw_jump(ax: Axes, jump: Line, color: Any) -> None:
    ax.plot(jump[0] / 1e3, jump[1], color=color, linestyle=":", linewidth=1.0)


def _state_label(state: np.ndarray, unit: int) -> str:
    """Pressures [Pa] of a `state`'s units other than `unit` [-], in words."""
    names = [i + 1 for i in range(len(state) + 1) if i != unit]
    pairs = zip(names, state, strict=True)
    return ", ".join(f"$P_{{{i}}}$ = {in_kilopascals(P)}" for i, P in pairs) or "free strain"

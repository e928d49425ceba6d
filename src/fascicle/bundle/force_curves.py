r"""Force over pressure of every recruitment state of a bundle, for its inverse.

In recruitment state $k$ the throttled units share one pressure $p$; with $w_{kj}$ muscles of kind
$j$ among them, and the other units at no or at supply pressure, the state's force is

$$F_k(p, \varepsilon) = H_k(\varepsilon) + \sum_j w_{kj} F_j(p, \varepsilon). \tag{B8}$$

Free and collapse strains of each kind of muscle are solved for once, on a grid of pressures;
forces at the grid's nodes are closed forms. A *level* is a pressure over the supply's.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.types import Numbers
from .pressurized import muscle_strain, unique_indices
from .states import States


if TYPE_CHECKING:
    from ..muscle import Muscle
    from ..muscle.piecewise import Pressurized

CELLS = 64  # of the grid, dense at low pressures, where free strains change fastest
COLUMNS = 129  # strains of the force table: a step is some 0.002, as fine as a transition
_END_INSET = 1e-6  # of the supply: nodes this near to both ends show the slope there
_NEWTON_STEPS = 8  # at most: from the grid's free strain three are enough
_NEWTON_TOLERANCE = 1e-9  # of strain: the step after it is within rounding

Residual = Callable[[np.ndarray, np.ndarray], np.ndarray]


class MuscleCurves:
    """Force of one kind of muscle over levels.

    `kinks`: for each kind of kink a residual of level and the plates' strain that changes its sign
    there, and the muscle's strain at the kink [-] at each node of the grid.
    """

    def __init__(self, muscle: "Muscle", ratio: float | None, supply: float, levels: np.ndarray):
        """**Arguments:** `muscle`; `ratio`: $L/L_i$ [-] or None; `supply`: $P_s$ [Pa]; `levels`:
        nodes of the grid [-].
        """
        self.law, self.ratio, self.supply, self.levels = muscle.law, ratio, supply, levels
        self.nodes = self.law.at(levels * supply)
        self.free_strain, self.collapse = self.nodes.column.free_strain, self.nodes.collapse
        self.kinks: list[tuple[Residual, np.ndarray]] = [(self._pull, self.free_strain)]
        for i, strains in enumerate(_kink_strains(self.nodes)):
            # most laws buckle at the free strain itself
            if strains is not self.free_strain and not np.all(np.isinf(strains)):
                nodes = np.broadcast_to(strains, levels.shape)
                self.kinks.append((self._kink_residual(i), nodes))

    def strain(self, plates: np.ndarray) -> np.ndarray:
        """Strain of the muscle [-] at the `plates`' [-]."""
        return plates if self.ratio is None else muscle_strain(self.ratio, plates)

    def force_at_nodes(self, node: np.ndarray, plates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] at nodes and the `plates`' strain [-], and its slope in that strain [N]."""
        picked = _pick_nodes(self.nodes, node, self.levels.size)
        return self._plate_slope(*picked.force(self.strain(plates)))

    def force(self, level: np.ndarray, plates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] at `level` and the `plates`' strain [-], and its slope in that strain [N].

        Free and collapse strain at a pressure are most of its cost. A muscle that surely pulls
        needs neither; one that surely has not collapsed, by the grid, needs the first alone.
        """
        strain, pressure = self.strain(plates), level * self.supply
        force, slope = np.zeros(level.shape), np.zeros(level.shape)
        cell = self._cell(level)
        pulls = strain < np.minimum(self.free_strain[cell], self.free_strain[cell + 1])
        if pulls.any():
            pull = self.law.tension.pull(pressure[pulls], strain[pulls])
            force[pulls], slope[pulls] = pull.force, pull.slope
            pulls[pulls] = pull.force > 0  # a free strain that falls with pressure within a cell
        buckles = ~pulls & (strain < np.minimum(self.collapse[cell], self.collapse[cell + 1]))
        for index, may_collapse in ((buckles, False), (~pulls & ~buckles, True)):
            if index.any():
                P = pressure[index]
                collapse = None if may_collapse else np.full(P.shape, np.inf)
                muscle = self.law.at(P, self._free_strain(level[index]), collapse)
                force[index], slope[index] = muscle.force(strain[index])
        return self._plate_slope(force, slope)

    def _cell(self, level: np.ndarray) -> np.ndarray:
        index = np.searchsorted(self.levels, level, "right") - 1
        return np.clip(index, 0, self.levels.size - 2)

    def _free_strain(self, level: np.ndarray) -> np.ndarray | None:
        """Free strain [-] by Newton's method from the grid's; `None` if that doesn't converge."""
        cell = self._cell(level)
        left, right = self.levels[cell], self.levels[cell + 1]
        weight = (level - left) / (right - left)
        free = (1 - weight) * self.free_strain[cell] + weight * self.free_strain[cell + 1]
        for _ in range(_NEWTON_STEPS):
            pull = self.law.tension.pull(level * self.supply, free)
            step = pull.force / pull.slope
            free = free - step
            if np.all(np.abs(step) <= _NEWTON_TOLERANCE):
                return free
        return None

    def _plate_slope(self, force: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return force, slope if self.ratio is None else slope * self.ratio

    def _pull(self, level: np.ndarray, plates: np.ndarray) -> np.ndarray:
        """Tension [N]: it has the sign of free strain less strain, and needs no root."""
        return self.law.tension.pull(level * self.supply, self.strain(plates)).force

    def _kink_residual(self, index: int) -> Residual:
        def residual(level: np.ndarray, plates: np.ndarray) -> np.ndarray:
            muscle = self.law.at(level * self.supply, self._free_strain(level))
            strain = np.broadcast_to(_kink_strains(muscle)[index], level.shape)
            return strain - self.strain(plates)

        return residual


class StateCurves:
    """Force over level of every state of a bundle, (B8), at any strain."""

    def __init__(self, bundle: Any, supply: float, states: States, resistance: bool):
        """**Arguments:** `bundle` of NumPy's numbers; `supply`: $P_s$ [Pa]; `states` of the scheme:
        if its units are independent, each unit is a state by itself; `resistance`: whether
        muscles push.
        """
        units = bundle.motor_units
        self.supply, self.resistance, self.scheme_states = float(supply), resistance, states
        unique, self.kind = unique_indices([unit.muscle for unit in units])
        self.levels = _grid([units[i].muscle.tuning for i in unique], self.supply)
        ratios = [None] * len(units) if bundle.ratios is None else [float(x) for x in bundle.ratios]
        self.muscles = [
            MuscleCurves(units[i].muscle, ratios[i], self.supply, self.levels) for i in unique
        ]
        counts = np.eye(len(unique))[list(self.kind)] * np.reshape(bundle.counts, (-1, 1))
        masks, self.owns_endpoints = (
            (states.throttled, states.vented, states.full), states.owns_endpoints
        )  # fmt: skip
        if states.independent:
            identity = np.eye(len(units), dtype=bool)
            masks, self.owns_endpoints = (
                (identity, 0 * identity, 0 * identity),
                (np.diag(identity), np.diag(identity)),
            )
        self.throttled, self.vented, self.full = (x.astype(float) @ counts for x in masks)
        self.states = len(self.throttled)
        self._table: tuple[float, float, np.ndarray] | None = None

    def fixed_force(self, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] of the units that each state doesn't throttle, states last, and its slope."""
        total = np.zeros((2, len(strain), self.states))
        for j, muscle in enumerate(self.muscles):
            for node, count in ((0, self.vented), (-1, self.full)):
                if count[:, j].any():
                    nodes = np.full(len(strain), node)
                    forces = self._without_pushing(*muscle.force_at_nodes(nodes, strain))
                    total += np.stack(forces)[..., None] * count[:, j]
        return total[0], total[1]

    def force(
        self, state: np.ndarray, level: np.ndarray, strain: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] of the units that each `state` throttles, at `level` and `strain` [-], and its
        slope in strain [N].
        """
        return self._sum(state, lambda muscle, i: muscle.force(level[i], strain[i]))

    def force_at_nodes(self, state: np.ndarray, node: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """Force [N] of the units that each `state` throttles, at a `node` of the grid."""
        return self._sum(state, lambda muscle, i: muscle.force_at_nodes(node[i], strain[i]))[0]

    def interpolate(self, state: np.ndarray, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] that a `state` throttles at each node, by a table over `strain` [-], and how
        much it changes between two columns of that table [N].
        """
        low, high, table = self._force_table(strain)
        position = (strain - low) / (high - low) * (COLUMNS - 1)
        column = np.clip(position.astype(int), 0, COLUMNS - 2)
        weight = (position - column)[:, None]
        left, right = table[column, state], table[column + 1, state]
        return (1 - weight) * left + weight * right, np.abs(right - left)

    def _force_table(self, strain: np.ndarray) -> tuple[float, float, np.ndarray]:
        """Least and largest strain [-] of the table, and forces [N] over strain, state and node."""
        low, high = (0.0, 0.3) if self._table is None else self._table[:2]
        if self._table is None or strain.min() < low or strain.max() > high:
            low, high = min(strain.min(), low), max(strain.max(), high)
            columns, nodes = np.linspace(low, high, COLUMNS), np.arange(len(self.levels))
            table = np.zeros((COLUMNS, self.states, len(self.levels)))
            for j, muscle in enumerate(self.muscles):
                forces = muscle.force_at_nodes(nodes, columns[:, None])
                force = self._without_pushing(*forces)[0]
                table += self.throttled[:, j, None] * force[:, None, :]
            self._table = (low, high, table)
        return self._table

    def _sum(self, state: np.ndarray, law: Callable) -> tuple[np.ndarray, np.ndarray]:
        force, slope = np.zeros(len(state)), np.zeros(len(state))
        for j, muscle in enumerate(self.muscles):
            count = self.throttled[state, j]
            index = np.flatnonzero(count)
            if len(index):
                muscle_force, muscle_slope = self._without_pushing(*law(muscle, index))
                force[index] += count[index] * muscle_force
                slope[index] += count[index] * muscle_slope
        return force, slope

    def _without_pushing(
        self, force: np.ndarray, slope: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        if self.resistance:
            return force, slope
        return np.where(force > 0, force, 0.0), np.where(force > 0, slope, 0.0)


def _kink_strains(muscle: "Pressurized") -> list[Numbers]:
    """Strains [-] past the free strain at which the force of a muscle has kinks."""
    return [muscle.onset, muscle.collapse, *muscle.law.buckling.folds(muscle.column)]


def _grid(tunings: list, supply: float) -> np.ndarray:
    """Levels of the grid [-], those of the tunings' kinks among them."""
    levels = (np.arange(CELLS + 1) / CELLS) ** 2
    kinks = [np.ravel((t.pressures + np.asarray(t.dead_band)[..., None]) / supply) for t in tunings]
    kinks = np.concatenate([*kinks, [0.0]])
    kinks = kinks[kinks < 1]
    levels = [levels, kinks, kinks + _END_INSET, kinks - _END_INSET, [1 - _END_INSET]]
    levels = np.concatenate(levels)
    return np.unique(levels[(levels >= 0) & (levels <= 1)])


def _pick_nodes(value: Any, node: np.ndarray, count: int) -> Any:
    """A muscle at the pressures of some of `count` nodes, which are on the last axis."""
    if isinstance(value, tuple):
        picked = [_pick_nodes(x, node, count) for x in value]
        return type(value)(*picked) if hasattr(value, "_fields") else tuple(picked)
    has_nodes = isinstance(value, np.ndarray) and value.shape[-1:] == (count,)
    return value[..., node] if has_nodes else value

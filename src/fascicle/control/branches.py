r"""A motor unit's rising branch as a table: from pressure to force and back, in microseconds.

Past its free strain a pressurized muscle resists more before it pulls: at a strain $\varepsilon$
its force is back to that of a vented one at the onset $p_{on}(\varepsilon)$, the last pressure at
which $F(p, \varepsilon) = F(0, \varepsilon)$, and from there on it gains. On that branch, up to the
supply's pressure, the inverse

$$p(f, \varepsilon): \quad F(p, \varepsilon) = f, \qquad p_{on} \le p \le P_s, \tag{K1}$$

is unique; where the force isn't monotonic beyond its onset, the largest pressure is meant. It is a
table in strain and $\varphi = (f - F(0))/(F(P_s) - F(0))$, from which steps of Newton's method on
the muscle's own table, (V3), lead to the root. For a force out of reach it is the nearest pressure.

**Sign:** as for a muscle. **Source:** derived here.
"""

import numpy as np

from ..bundle.bundle import Bundle
from ..bundle.states import resolve_supply_pressure
from ..core.array_namespace import array_namespace, maximum, minimum, sqrt, where
from ..core.jax_backend import iterate
from ..core.module import Module
from ..core.roots import guarded
from ..core.types import Numbers, Values, Whole
from ..dynamics.muscles import MuscleTables


SHAPE = (161, 201)  # of the muscles' tables, as a plant has them
_FRACTIONS = 65  # φ of tabulated pressures, even in √φ, as forces begin with p² at small strains
_FINE = 513  # pressures of a branch: eight times as many
_HALVINGS = 50  # of a bracket of pressure: to rounding
_NEWTON = 4  # from the table within some percent: below 1e-9 of the supply but at kinks


class Branches(Module):
    """Inverse of the force of a bundle's motor units, on the branch that rises with pressure.

    `muscles`: tables of one muscle of each unit; `top`: pressure at which branches end [Pa]. Of
    each different muscle, at its table's strains: `onsets` [Pa], `dips` [N] and `dip_pressures`
    [Pa], and the branch's `pressures` [Pa] at fractions of its force, even in √φ. Units are on the
    last axis of arguments and results; forces are those of a single muscle.
    """

    muscles: MuscleTables
    top: Numbers
    onsets: Numbers
    dips: Numbers
    dip_pressures: Numbers
    pressures: Numbers

    @classmethod
    def of(
        cls, bundle: Bundle, supply_pressure: Values = None, shape: tuple[int, int] = SHAPE
    ) -> "Branches":
        """Rising branches of the motor units of a `bundle` up to the `supply_pressure` [Pa], left
        out its own; `shape`: nodes of the muscles' tables in pressure and strain.
        """
        supply = resolve_supply_pressure(bundle, supply_pressure)
        key = "control.branches", supply, shape
        if key not in bundle.cache:
            muscles = [unit.muscle for unit in bundle.motor_units]
            tables = MuscleTables.from_muscles(muscles, supply, shape)
            bundle.cache[key] = cls.tabulated(tables, supply)
        return bundle.cache[key]

    @classmethod
    def tabulated(cls, muscles: MuscleTables, top: float) -> "Branches":
        """Rising branches of tabulated `muscles` up to a pressure `top` [Pa]."""
        _, first_units = np.unique(muscles.indices, return_index=True)
        rows = [_tabulate_branch(muscles, unit, top) for unit in first_units]
        return cls(muscles, np.float64(top), *map(np.stack, zip(*rows, strict=True)))

    def force(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Force of one muscle of each unit [N] at any `pressure` [Pa] and `strain` [-], on the
        rising branch or below it.
        """
        return self.muscles.at(pressure, strain).force

    def onset(self, strain: Numbers) -> Numbers:
        """Pressure $p_{on}$ [Pa] above which each unit pulls more at `strain` [-] than empty; the
        top if none does.
        """
        tabulated, empty = self._interpolate(self.onsets, strain), self.force(0.0 * strain, strain)

        def step(p: Numbers) -> Numbers:
            at = self.muscles.at(p, strain)
            rises = (tabulated > 0) & (at.force_by_pressure > 0)
            direction = (at.force - empty) / guarded(rises, at.force_by_pressure)
            # no pressure at all is a root as well, and past a kink a slope leads away
            reach = minimum(0.5 * tabulated, 2e-3 * self.top)
            guess = minimum(maximum(p - direction, tabulated - reach), tabulated + reach)
            return where(rises, guess, p)

        return minimum(maximum(iterate(step, tabulated, 2), 0.0), self.top)

    def dip(self, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Depth of the dip of one muscle of each unit [N] at a `strain` [-], and its pressure [Pa],
        both interpolated between the table's strains.
        """
        return self._interpolate(self.dips, strain), self._interpolate(self.dip_pressures, strain)

    def pressure(self, force: Numbers, strain: Numbers) -> Numbers:
        """Pressure [Pa] on the rising branch of each unit at which one muscle gives a `force` [N]
        at a `strain` [-], (K1): 0 for less force than an empty muscle's or one that gains nothing,
        the top for more force than a full muscle's.
        """
        force, strain = array_namespace(force, strain).broadcast_arrays(force, strain)
        zero = 0.0 * strain
        empty, full = self.force(zero, strain), self.force(zero + self.top, strain)
        gains = full > empty
        fraction = (force - empty) / guarded(gains, full - empty)
        inside = gains & (fraction > 0) & (fraction < 1)
        onset = self.onset(strain)

        def step(p: Numbers) -> Numbers:
            at = self.muscles.at(p, strain)
            rises = at.force_by_pressure > 0
            direction = (at.force - force) / guarded(rises, at.force_by_pressure)
            size = 0.1 * self.top
            direction = maximum(minimum(where(rises, direction, 0.0), size), -size)
            return minimum(maximum(p - direction, onset), self.top)

        guess = self._initial_pressure(where(inside, fraction, 0.5), strain)
        ends = where(gains & (fraction >= 1), self.top, 0.0)
        return where(inside, iterate(step, guess, _NEWTON), ends)

    def _table_column(self, strain: Numbers) -> tuple[Whole, Numbers]:
        """Index of the table's column below a `strain` [-], and fraction of the way to the next."""
        low, high = self.muscles.strains
        columns = self.onsets.shape[-1] - 1
        x = minimum(maximum((strain - low) / (high - low) * columns, 0.0), float(columns))
        j = minimum(array_namespace(strain).floor(x), columns - 1.0).astype(int)
        return j, x - j

    def _interpolate(self, table: Numbers, strain: Numbers) -> Numbers:
        """Value of a `table` [SI] of each unit's muscle at a `strain` [-]."""
        (j, w), i = self._table_column(strain), self.muscles.indices
        table = array_namespace(strain).asarray(table)
        return (1 - w) * table[i, j] + w * table[i, j + 1]

    def _initial_pressure(self, fraction: Numbers, strain: Numbers) -> Numbers:
        """First guess of the pressure [Pa] at a `fraction` of the branch's force [-]."""
        (j, w), indices = self._table_column(strain), self.muscles.indices
        xp, rows = array_namespace(fraction), self.pressures.shape[-1] - 1
        x = sqrt(fraction) * rows
        i = minimum(xp.floor(x), rows - 1.0).astype(int)
        u, p = x - i, xp.asarray(self.pressures)
        left, right = (
            (1 - u) * p[indices, j + side, i] + u * p[indices, j + side, i + 1] for side in (0, 1)
        )
        return (1 - w) * left + w * right


def _tabulate_branch(muscles: MuscleTables, unit: int, top: float) -> tuple[np.ndarray, ...]:
    """Onset [Pa], above which one muscle of a unit pulls more than empty, its dip [N] and the
    dip's pressure [Pa] at each tabulated strain, and the branch's pressures [Pa].
    """
    ends, columns = muscles.strains, muscles.table.coefficients.shape[-3]
    strain = np.linspace(float(ends[0][unit]), float(ends[1][unit]), columns + 1)

    def force(pressure: np.ndarray) -> np.ndarray:
        zeros = np.zeros(len(muscles.indices))
        points = (x[..., None] + zeros for x in np.broadcast_arrays(pressure, strain))
        return np.asarray(muscles.at(*points).force)[..., unit]

    with np.errstate(all="ignore"):  # of branches that aren't selected
        # even in √P, as the table is: a muscle changes most at low pressure
        grid = top * np.linspace(0.0, 1.0, _FINE) ** 2
        empty = force(0.0 * strain)
        dip = empty - force(grid[:, None])
        last = _FINE - 1 - np.argmax(~(dip[::-1] < 0), axis=0)
        low, high = grid[last], grid[np.minimum(last + 1, _FINE - 1)]
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            up = force(middle) > empty
            low, high = np.where(up, low, middle), np.where(up, middle, high)
        onset = np.where(last == _FINE - 1, top, np.where(last == 0, 0.0, high))
        branch = onset + (top - onset) * np.linspace(0.0, 1.0, _FINE)[:, None] ** 2
        pull = np.minimum.accumulate(force(branch)[::-1])[::-1]
    fractions = np.linspace(0.0, 1.0, _FRACTIONS) ** 2
    pressures = [
        np.interp(fractions * (f[-1] - f[0]) + f[0], f, p)
        if f[-1] > f[0]
        else np.full(_FRACTIONS, top)
        for f, p in zip(pull.T, branch.T, strict=True)
    ]
    dip_pressure = grid[np.argmax(dip, axis=0)]
    return onset, np.maximum(np.max(dip, axis=0), 0.0), dip_pressure, np.stack(pressures)

r"""A motor unit's rising branch as a table: from pressure to force and back, in microseconds.

Past its free strain a pressurized muscle resists more before it pulls: at a strain $\varepsilon$
its force is back to that of a vented one at the onset $p_{on}(\varepsilon)$, the last pressure at
which $F(p, \varepsilon) = F(0, \varepsilon)$, and from there on it gains. On that branch, up to the
supply's pressure, the inverse

$$p(f, \varepsilon): \quad F(p, \varepsilon) = f, \qquad p_{on} \le p \le P_s, \tag{K1}$$

is unique; where the force isn't monotonic beyond its onset, the largest pressure is meant. It is a
table in strain and $\varphi = (f - F(0))/(F(P_s) - F(0))$, from which steps of Newton's method on
the muscle's own table, (V3), lead to the root. A force out of reach has a status and the nearest
pressure.

**Sign:** as for a muscle. **Source:** derived here.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jax import lax

from ..bundle.bundle import Bundle
from ..bundle.states import resolve_supply_pressure
from ..core.array_namespace import array_namespace, maximum, minimum, sqrt, where
from ..core.module import Module
from ..core.roots import guarded
from ..core.types import Numbers, Values, Whole
from ..dynamics.muscles import MuscleTables


# of a force: it can be reached, is less than an empty unit's, more than a full one's, or the unit
# gains nothing at this strain up to the supply's pressure
REACHED, TOO_LITTLE, TOO_MUCH, HELPLESS = range(4)
STATUS = ("reached", "too_little", "too_much", "helpless")

_SHAPE = (161, 201)  # of the muscles' tables, as a plant has them
_FRACTIONS = 65  # φ of tabulated pressures, even in √φ, as forces begin with p² at small strains
_FINE = 513  # pressures of a branch: eight times as many
_HALVINGS = 50  # of a bracket of pressure: to rounding
_NEWTON = 4  # from the table within some percent: below 1e-9 of the supply but at kinks


class BranchPressures(NamedTuple):
    """Pressures [Pa] at which motor units pull with given forces, on their rising branches (K1).

    `pressure` [Pa] and `status`, an index of `STATUS`: of each motor unit, on the last axis.
    """

    pressure: Numbers
    status: Whole


class Branches(Module):
    """Inverse of the force of a bundle's motor units, on the branch that rises with pressure.

    Made by `Branches.of(bundle, supply)`.

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
        cls, bundle: Bundle, supply_pressure: Values = None, shape: tuple[int, int] = _SHAPE
    ) -> "Branches":
        """Tabulate the rising branches of a bundle's motor units.

        **Arguments:**

        - `bundle`: the bundle.
        - `supply_pressure`: at which they end [Pa]; left out, the bundle's own.
        - `shape`: nodes of the muscles' tables in pressure and strain.

        **Raises:** `InvalidInputError` for an invalid supply pressure.
        """
        supply = resolve_supply_pressure(bundle, supply_pressure)
        muscles = [unit.muscle for unit in bundle.motor_units]
        return cls.tabulated(MuscleTables.from_muscles(muscles, supply, shape), supply)

    @classmethod
    def tabulated(cls, muscles: Any, top: float) -> "Branches":
        """Rising branches of tabulated `muscles` up to a pressure `top` [Pa]."""
        rows = []
        for index in range(max(muscles.indices) + 1):
            unit = int(np.flatnonzero(muscles.indices == index)[0])
            low, high = (float(end[unit]) for end in muscles.strains)
            rows.append(
                _tabulate_branch(
                    muscles,
                    unit,
                    np.linspace(low, high, muscles.table.coefficients.shape[-3] + 1),
                    top,
                )
            )
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
        j, w, indices = self._table_column(strain)
        onsets = array_namespace(strain).asarray(self.onsets)
        between = (1 - w) * onsets[indices, j] + w * onsets[indices, j + 1]
        any_rising = between > 0
        empty = self.force(0.0 * strain, strain)

        def step(p: Numbers) -> Numbers:
            at = self.muscles.at(p, strain)
            rises = any_rising & (at.force_by_pressure > 0)
            direction = (at.force - empty) / guarded(rises, at.force_by_pressure)
            # no pressure at all is a root as well, and past a kink a slope leads away
            reach = minimum(0.5 * between, 2e-3 * self.top)
            guess = minimum(maximum(p - direction, between - reach), between + reach)
            return where(rises, guess, p)

        p = _iterate(step, between, 2)
        return minimum(maximum(p, 0.0), self.top)

    def dip(self, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Depth of the dip of one muscle of each unit [N] at a `strain` [-], and its pressure [Pa],
        both interpolated between the table's strains.
        """
        j, w, indices = self._table_column(strain)
        rows = (array_namespace(strain).asarray(row) for row in (self.dips, self.dip_pressures))
        depth, pressure = ((1 - w) * row[indices, j] + w * row[indices, j + 1] for row in rows)
        return depth, pressure

    def pressure(self, force: Numbers, strain: Numbers) -> BranchPressures:
        """Pressure on the rising branch of each unit that gives a force, and its status, (K1).

        **Arguments:**

        - `force`: of one muscle of each unit [N], units on the last axis.
        - `strain`: of each unit's muscles [-]; broadcasts against `force`.

        **Returns:** pressures [Pa] and statuses; a pressure of 0 for less force than an empty
        muscle's or a helpless muscle, the top for more force than a full muscle's.
        """
        xp = array_namespace(force, strain)
        force, strain = xp.broadcast_arrays(force, strain)
        zero = 0.0 * strain
        empty, full = self.force(zero, strain), self.force(zero + self.top, strain)
        gains = full > empty
        fraction = (force - empty) / guarded(gains, full - empty)
        high = fraction >= 1
        inside = gains & (fraction > 0) & ~high
        phi = where(inside, fraction, 0.5)
        onset = self.onset(strain)

        def step(p: Numbers) -> Numbers:
            at = self.muscles.at(p, strain)
            rises = at.force_by_pressure > 0
            direction = (at.force - force) / guarded(rises, at.force_by_pressure)
            size = 0.1 * self.top
            direction = maximum(minimum(where(rises, direction, 0.0), size), -size)
            return minimum(maximum(p - direction, onset), self.top)

        p = _iterate(step, self._initial_pressure(phi, strain), _NEWTON)
        ends = where(high & gains, self.top, 0.0)
        status = xp.where(
            ~gains,
            HELPLESS,
            xp.where(fraction < 0, TOO_LITTLE, xp.where(fraction > 1, TOO_MUCH, REACHED)),
        )
        return BranchPressures(where(inside, p, ends), status)

    def _table_column(self, strain: Numbers) -> tuple[Whole, Numbers, Whole]:
        """Index of the table's column below a `strain` [-], the fraction of the way to the next,
        and the index of each unit's muscle.
        """
        xp = array_namespace(strain)
        low, high = self.muscles.strains
        columns = self.onsets.shape[-1] - 1
        x = minimum(maximum((strain - low) / (high - low) * columns, 0.0), float(columns))
        j = minimum(xp.floor(x), columns - 1.0).astype(int)
        return j, x - j, self.muscles.indices

    def _initial_pressure(self, fraction: Numbers, strain: Numbers) -> Numbers:
        """First guess of the pressure [Pa] at a `fraction` of the branch's force [-], from the
        table.
        """
        j, w, indices = self._table_column(strain)
        rows = self.pressures.shape[-1] - 1
        x = sqrt(fraction) * rows
        i = minimum(array_namespace(fraction).floor(x), rows - 1.0).astype(int)
        u = x - i
        p = array_namespace(fraction).asarray(self.pressures)
        left, right = (
            (1 - u) * p[indices, j + side, i] + u * p[indices, j + side, i + 1] for side in (0, 1)
        )
        return (1 - w) * left + w * right


def _iterate(step: Callable[[Numbers], Numbers], begin: Numbers, times: int) -> Numbers:
    """Apply a `step` so many `times`; in JAX by a loop, which is compiled once."""
    if array_namespace(begin) is np:
        for _ in range(times):
            begin = step(begin)
        return begin
    return lax.fori_loop(0, times, lambda _, x: step(x), begin)


def _tabulate_branch(
    muscles: MuscleTables, unit: int, strain: np.ndarray, top: float
) -> tuple[np.ndarray, ...]:
    """Onset [Pa], dip [N] and its pressure [Pa] at each strain, and the branch's pressures [Pa]."""

    def force(pressure: np.ndarray) -> np.ndarray:
        P, eps = np.broadcast_arrays(pressure[..., None], strain[:, None])
        units = np.shape(muscles.indices)
        points = np.broadcast_to(P, (*P.shape[:-1], *units)), eps + np.zeros(units)
        return np.asarray(muscles.at(*points).force)[..., unit]

    with np.errstate(all="ignore"):  # of branches that aren't selected
        # even in √P, as the table is: a muscle changes most at low pressure
        grid = top * np.linspace(0.0, 1.0, _FINE) ** 2
        empty = force(0.0 * strain)
        dip = empty - force(np.broadcast_to(grid[:, None], (_FINE, len(strain))))
        gains, deepest = dip < 0, np.argmax(dip, axis=0)
        last = _FINE - 1 - np.argmax(~gains[::-1], axis=0)
        helpless = last == _FINE - 1
        low, high = grid[last], grid[np.minimum(last + 1, _FINE - 1)]
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            up = force(middle) > empty
            low, high = np.where(up, low, middle), np.where(up, middle, high)
        onset = np.where(helpless, top, np.where(last == 0, 0.0, high))
        branch = onset + (top - onset) * np.linspace(0.0, 1.0, _FINE)[:, None] ** 2
        pull = np.minimum.accumulate(force(branch)[::-1])[::-1]
    fractions = np.linspace(0.0, 1.0, _FRACTIONS) ** 2
    pressures = [
        np.interp(fractions * (f[-1] - f[0]) + f[0], f, p)
        if f[-1] > f[0]
        else np.full(_FRACTIONS, top)
        for f, p in zip(pull.T, branch.T, strict=True)
    ]
    return onset, np.maximum(np.max(dip, axis=0), 0.0), grid[deepest], np.stack(pressures)

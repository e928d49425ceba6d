r"""Force curves over the throttled pressure: what a recruitment state can change.

In a recruitment state some units are at no pressure, some at the supply's, and the rest
share one throttled pressure $p$. Over the level $u = p/P_s$, at one strain, the rest give

$$G_k(u, \varepsilon) = \sum_j w_{kj} F_j(u P_s, \varepsilon), \tag{B8}$$

with $w_{kj}$ muscles of kind $j$ in state $k$. Each unlike muscle is evaluated once for all
the states and units that have it.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from .._arrays import library, maximum, minimum, running_most, where
from .._types import Batch
from ..muscle import Muscle
from .alike import stacked, taken
from .plates import muscle_strain, plate_strain


_STEP = 1e-7  # of the level: for slopes where there are no derivatives to be had
_TABLE = (np.arange(513) / 512) ** 2  # levels, dense where free strain and collapse change fastest
_FINER, _ROUNDS = 16, 10  # finer and finer, to the level at which a kink is last seen
_BETWEEN = (0.1, 0.4)  # levels at which a stretch is cut anyway: no long one hides a dip


class Kinds(NamedTuple):
    """Unlike muscles of the same laws, in a row; $L/L_i$ [-] of each, where they aren't as long as
    the plates are apart.
    """

    muscles: Muscle
    ratios: Batch | None
    count: int

    def force(self, pressure: Batch, strain: Batch) -> tuple[Batch, Batch]:
        """Force [N] and its slope in the bundle's `strain` [-], at `pressure` [Pa], kinds last."""
        if self.ratios is None:
            return self.muscles._law().at(pressure).force(strain)
        value, slope = self.muscles._law().at(pressure).force(muscle_strain(self.ratios, strain))
        return value, slope * self.ratios

    def kinks(self, pressure: Batch) -> Batch:
        """Strains of the bundle [-] at which they have kinks, on a new first axis."""
        kinks = self.muscles._law().at(pressure).kinks
        return kinks if self.ratios is None else plate_strain(self.ratios, kinks)

    def picked(self, place: Any) -> "Kinds":
        """Those at `place` [-], as many as it has."""
        place = minimum(maximum(place, 0), self.count - 1)
        ratios = self.ratios if np.ndim(self.ratios) == 0 else self.ratios[place]
        return Kinds(taken(self.muscles, place), ratios, self.count)


class Kinks(NamedTuple):
    """At which levels the force of a row's muscles has kinks: the `levels` [-] at which they are,
    over `strain` [-], kink, place and kind; those `given` [-] by its tuning, whatever the strain.
    """

    levels: Batch
    strain: Batch
    given: Batch

    def at(self, strain: Batch) -> Batch:
        """Those levels at each `strain` [-], kinds and kinks on new last axes."""
        at_work = library(strain, self.levels)
        found = [
            [at_work.interp(strain, risen[:, kind], place[:, kind]) for kind in range(len(self.given))]
            for risen, place in zip(self.strain, self.levels, strict=True)
        ]
        moving = at_work.moveaxis(at_work.stack([at_work.stack(one) for one in found]), -1, 0)
        fixed = at_work.broadcast_to(self.given, (len(strain), *self.given.shape))
        every = at_work.concatenate([at_work.swapaxes(moving, 1, 2), fixed], axis=-1)
        return minimum(maximum(every, 0.0), 1.0)


class Bank(NamedTuple):
    """A bundle's kinds of muscle, and how many of each [-] a state has: `throttled`, at `no` and
    at `full` supply pressure $P_s$ [Pa]. `alone`: the one kind that each state throttles, if all
    throttle one.
    """

    rows: tuple[Kinds, ...]
    throttled: Batch
    no: Batch
    full: Batch
    alone: np.ndarray | None
    kinks: tuple["Kinks", ...]
    supply: Batch
    resistance: bool

    @property
    def states(self) -> int:
        """How many states there are [-]."""
        return len(self.throttled)

    def forces(self, level: Batch, strain: Batch) -> tuple[Batch, Batch]:
        """Force [N] of one muscle of each kind and its slope in strain [N], at `level` [-] and
        `strain` [-], kinds last.
        """
        at_work = library(level, strain, self.supply)
        P, eps = ((at_work.asarray(x) + 0.0)[..., None] for x in (level * self.supply, strain))
        found = [self._kept(row.force(P, eps)) for row in self.rows]
        return tuple(at_work.concatenate(parts, axis=-1) for parts in zip(*found, strict=True))

    def held(self, strain: Batch) -> tuple[Batch, Batch]:
        """What the units that a state doesn't throttle give [N] at each `strain` [-], states
        last, and its slope in strain [N].
        """
        (none, none_slope), (full, full_slope) = (
            self.forces(0.0 * strain + level, strain) for level in (0.0, 1.0)
        )
        return tuple(
            none @ self.no.T + full @ self.full.T
            for none, full in ((none, full), (none_slope, full_slope))
        )

    def state_force(self, state: Any, level: Batch, strain: Batch) -> tuple[Batch, Batch]:
        """Force [N] of the whole bundle in a `state` at `level` [-] and `strain` [-], and its slope
        in strain [N].
        """
        at_work = library(level, strain, self.supply)
        at = [self.forces(x + 0.0 * strain, strain) for x in (0.0, level, 1.0)]
        shares = (self.no[state], self.throttled[state], self.full[state])
        return tuple(
            sum(at_work.sum(share * part[i], axis=-1) for share, part in zip(shares, at, strict=True))
            for i in (0, 1)
        )

    def terms(self, state: Any, level: Batch, strain: Batch) -> tuple[Batch, Batch]:
        """Forces [N] of the kinds that a `state` throttles at `level` [-], places along a second
        axis, and `strain` [-]; kinds last; and their slopes by level [N].
        """

        def force(u: Batch) -> Batch:
            if self.alone is None:
                found, _ = self.forces(u, strain[:, None])
                return self.throttled[state][:, None, :] * found
            total, first = 0.0, 0
            kind = library(state).asarray(self.alone)[state]
            for row in self.rows:
                place = kind - first
                here = row.picked(place[:, None])
                found, _ = self._kept(here.force(u * self.supply, strain[:, None]))
                inside = (place >= 0) & (place < row.count)
                total = total + where(inside[:, None], found, 0.0)
                first += row.count
            return (self.throttled[state, kind][:, None] * total)[..., None]

        if library(level) is not np:
            return jax.jvp(force, (level,), (jnp.ones_like(level),))
        step = np.where(level < 0.5, _STEP, -_STEP)
        value, moved = np.split(force(np.concatenate([level, level + step], axis=1)), 2, axis=1)
        return value, (moved - value) / step[..., None]

    def ends(self, strain: Batch) -> Batch:
        """Levels [-] between which each state's curve is smooth at each `strain` [-], rising along
        a last axis, states ahead of it.
        """
        at_work = library(strain, self.supply)
        kinks = at_work.concatenate([kinks.at(strain) for kinks in self.kinks], axis=1)
        if self.alone is None:
            every = kinks.reshape(len(strain), 1, -1)
            own = at_work.broadcast_to(every, (len(strain), self.states, every.shape[-1]))
        else:
            own = kinks[:, self.alone]
        fixed = at_work.broadcast_to(
            at_work.asarray([0.0, *_BETWEEN, 1.0]), (*own.shape[:2], 2 + len(_BETWEEN))
        )
        return at_work.sort(at_work.concatenate([own, fixed], axis=-1), axis=-1)

    def _kept(self, found: tuple[Batch, Batch]) -> tuple[Batch, Batch]:
        if self.resistance:
            return found
        return tuple(where(found[0] > 0, x, 0.0) for x in found)


def bank(
    muscles: Sequence[Muscle],
    counts: Sequence[Any],
    places: Sequence[int],
    length: Batch | None,
    supply: Batch,
    scheme: str,
    resistance: bool,
) -> Bank:
    """The bank of a bundle whose units have `counts` of the `muscles` at `places`; `length`:
    between its plates [m], where that isn't the muscles' own; `supply` $P_s$ [Pa].
    """
    groups = stacked(muscles)
    rows = tuple(
        Kinds(one, None if length is None else length / one.length, len(row))
        for row, one in groups
    )
    order = [i for row, _ in groups for i in row]
    column = [order.index(place) for place in places]

    unit, state = np.arange(len(places)), np.arange(len(places))[:, None]
    active = unit <= state if scheme == "batch" else unit == state
    full = np.zeros_like(active) if scheme == "batch" else unit < state
    kinds = np.eye(len(order))[np.array(column)] * library(*counts).stack(counts)[:, None]
    throttled, no, full = (x.astype(float) @ kinds for x in (active, unit > state, full))
    members = [{column[i] for i in np.flatnonzero(row)} for row in active]
    alone = None
    if all(len(one) == 1 for one in members):
        alone = np.array([one.pop() for one in members])
    kinks = tuple(_kinks(row, supply) for row in rows)
    return Bank(rows, throttled, no, full, alone, kinks, supply, resistance)


def _kinks(row: Kinds, supply: Batch) -> Kinks:
    """The kinks of a row's muscles between no pressure and `supply` [Pa].

    Free strain, onset and collapse come later the higher the pressure; from some level on the
    last two come never, and there the force jumps.
    """
    at_work = library(supply, *jax.tree.leaves(row.muscles))
    one = at_work.ones(row.count)

    def seen(level: Batch) -> Batch:
        return row.kinks(level * supply * one)

    levels = at_work.asarray(_TABLE)[:, None] * one
    strain = seen(levels)
    there = at_work.isfinite(strain)
    last = at_work.argmin(there, axis=1) - 1  # of those before the first that is not
    jumps = ~at_work.all(there, axis=1) & (last >= 0)
    low, high = (at_work.asarray(_TABLE)[maximum(last + i, 0)] for i in (0, 1))
    if at_work is not np or np.any(jumps):
        for _ in range(_ROUNDS):
            share = np.arange(_FINER + 1)[:, None, None] / _FINER
            fine = low + (high - low) * share
            # each kink has its own bracket, and its own row among those that are seen
            ahead = at_work.stack(
                [at_work.isfinite(seen(fine[:, i]))[i] for i in range(len(strain))], axis=1
            )
            steps = at_work.sum(ahead[1:], axis=0)
            low, high = (low + (high - low) * (steps + i) / _FINER for i in (0, 1))
    end = at_work.stack([seen(low[i])[i] for i in range(len(strain))])
    beyond = (np.arange(len(_TABLE))[:, None] > last[:, None]) & jumps[:, None]
    place = where(beyond, high[:, None], levels)
    risen = where(beyond, where(jumps, end, 0.0)[:, None], where(there, strain, 0.0))
    return Kinks(place, running_most(risen, 1), _given(row, supply))


def _given(row: Kinds, supply: Batch) -> Batch:
    """Levels [-] at which the tuning's tables have kinks, a row for each kind."""
    tuning = row.muscles.tuning
    at_work = library(supply, tuning.pressures, tuning.dead_band)
    band = at_work.asarray(tuning.dead_band)[..., None]
    # the first row of a table is at zero, where the dead band ends
    return at_work.broadcast_to(
        (tuning.pressures + band) / supply, (row.count, tuning.pressures.shape[-1])
    )

r"""Force curves over the throttled pressure: what a recruitment state can change.

In a recruitment state some units are at no pressure, some at the supply's, and the rest
share one throttled pressure $p$. Over the level $u = p/P_s$, at one strain, the rest give

$$G_k(u, \varepsilon) = \sum_j w_{kj} F_j(u P_s, \varepsilon), \tag{B8}$$

with $w_{kj}$ muscles of kind $j$ in state $k$. Each unlike muscle is evaluated once for all
the states and units that have it.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from ...core.arrays import library, maximum, minimum, nodes, running_most, where
from ...core.types import Numbers
from ...muscle import Muscle
from ..alike import stacked
from ..states import States
from .guide import Guide
from .kinds import SINGLE, Kinds
from .single import LEVELS, Single


Forces = tuple[Numbers, ...]  # and their slopes in strain

_FEW = 2**13  # points that NumPy has sooner than a tile of a law that is compiled anyway
_STEP = 1e-7  # of the level: for slopes that only guide a search
_BETWEEN = (0.1, 0.4)  # levels at which a stretch is cut anyway: no long one hides a dip


class Kinks(NamedTuple):
    """At which levels the force of a row's muscles has kinks: the `levels` [-] at which they are,
    over `strain` [-], kink, place and kind; those `given` [-] by its tuning, whatever the strain.
    """

    levels: Numbers
    strain: Numbers
    given: Numbers

    def at(self, strain: Numbers) -> Numbers:
        """Those levels at each `strain` [-], kinds and kinks on new last axes."""
        at_work = library(strain, self.levels)
        found = [
            [
                at_work.interp(strain, risen[:, kind], place[:, kind])
                for kind in range(len(self.given))
            ]
            for risen, place in zip(self.strain, self.levels, strict=True)
        ]
        moving = at_work.moveaxis(at_work.stack([at_work.stack(one) for one in found]), -1, 0)
        fixed = at_work.broadcast_to(self.given, (len(strain), *self.given.shape))
        every = at_work.concatenate([at_work.swapaxes(moving, 1, 2), fixed], axis=-1)
        return minimum(maximum(every, 0.0), 1.0)


class Bank(NamedTuple):
    """A bundle's kinds of muscle, and how many of each [-] a state has: `throttled`, at `no` and
    at `full` supply pressure $P_s$ [Pa]. `alone`: the one kind that each state throttles, if all
    throttle one. `counted`: which states' beginnings and ends are solutions of their own [-]. Where
    units are independent each is a state by itself, and nothing beside it is `held`. `guide`: where
    to look for demands, where NumPy does. `spoken`: of each state the kind it throttles and how
    many of it, and how many of each are at no and at full pressure [-], in Python's numbers.
    """

    rows: tuple[Kinds, ...]
    throttled: Numbers
    no: Numbers
    full: Numbers
    alone: np.ndarray | None
    kinks: tuple["Kinks", ...]
    supply: Numbers
    resistance: bool
    counted: tuple[np.ndarray, np.ndarray]
    by_itself: bool
    guide: Any = None
    spoken: tuple = ()

    @property
    def states(self) -> int:
        """How many states there are [-]."""
        return len(self.throttled)

    @property
    def at_once(self) -> int:
        """Up to how many points [-] NumPy evaluates a law."""
        return self.rows[0].at_once

    def for_many(self) -> "Bank":
        """The same for so many demands that a compiled law is worth its compiling."""
        return self._replace(rows=tuple(row._replace(at_once=_FEW) for row in self.rows))

    def forces(self, level: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force [N] of one muscle of each kind and its slope in strain [N], at `level` [-] and
        `strain` [-], kinds last.
        """
        at_work = library(level, strain, self.supply)
        P, eps = ((at_work.asarray(x) + 0.0)[..., None] for x in (level * self.supply, strain))
        found = [self.kept(row.force(P, eps)) for row in self.rows]
        return tuple(at_work.concatenate(parts, axis=-1) for parts in zip(*found, strict=True))

    def beside(self, strain: Numbers) -> tuple[Forces, Forces]:
        """Forces [N] of one muscle of each kind at no and at supply pressure and each `strain` [-],
        and their slopes in strain [N], kinds last.
        """
        if self.guide is not None:
            return self.guide.ends(strain, np.size(strain) * self.throttled.shape[1] > self.at_once)
        value, slope = self.forces(nodes((0.0, 1.0), strain) + 0.0 * strain, strain)
        return (value[0], slope[0]), (value[1], slope[1])

    def held(self, beside: tuple[Forces, Forces]) -> Forces:
        """What the units that a state doesn't throttle give [N], states last, and its slope in
        strain [N]; `beside`: what `beside` gives [N].
        """
        if self.by_itself:
            nothing = 0.0 * (beside[0][0] @ self.throttled.T)
            return nothing, nothing
        none, full = beside
        return tuple(off @ self.no.T + on @ self.full.T for off, on in zip(none, full, strict=True))

    def throttled_force(self, state: Any, level: Numbers, strain: Numbers) -> Forces:
        """Force [N] of the units that each `state` throttles, at its `level` [-] and `strain` [-],
        and its slope in strain [N].
        """
        few = self.guide is not None and np.shape(state) == np.shape(level) == np.shape(strain)
        if self.alone is not None and few and len(state) <= SINGLE:
            found = [self.single(*one) for one in zip(state, level, strain, strict=True)]
            return tuple(np.reshape(found, (-1, 2)).T)
        if self.alone is not None:
            return self._alone(state, level, strain)
        share = library(level).asarray(self.throttled)[state]
        return tuple(library(x).sum(share * x, axis=-1) for x in self.forces(level, strain))

    def state_force(self, state: Any, level: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force [N] of the whole bundle in a `state` at `level` [-] and `strain` [-], and its slope
        in strain [N].
        """
        own = self.throttled_force(state, level, strain)
        if self.by_itself:
            return own
        held = self.held(self.beside(strain))
        at = library(level).arange(len(strain))
        return tuple(x + rest[at, state] for x, rest in zip(own, held, strict=True))

    def values(self, state: Any, level: Numbers, strain: Numbers) -> Numbers:
        """Forces [N] of the kinds that a `state` throttles at `level` [-], places along a second
        axis, and `strain` [-]; kinds last.
        """
        if self.alone is None:
            found, _ = self.forces(level, strain[:, None])
            return self.throttled[state][:, None, :] * found
        found, _ = self._alone(state[:, None], level, strain[:, None])
        return found[..., None]

    def single(self, state: Any, level: float, strain: float) -> tuple[float, float]:
        """The same of a single `state`, `level` and `strain` [-] where each throttles one kind, and
        its slope in strain [N].
        """
        every: Any = self.alone
        kind = every[state]
        row, place = self.guide.places[kind]
        force, slope = row.single(place, level * self.supply, strain)
        share = self.throttled[state, kind] if self.resistance or force > 0 else 0.0
        return share * force, share * slope

    def levels(self, state: int, nodes: Sequence[int], strain: float) -> list[float]:
        """Forces [N] of the one kind that a `state` throttles at numbered levels [-] and one
        `strain` [-].
        """
        every: Any = self.alone
        kind = every[state]
        row, place = self.guide.places[kind]
        share = float(self.throttled[state, kind])
        found = row.along(place, np.array(nodes), np.array(strain)).tolist()
        return [share * x if self.resistance or x > 0 else 0.0 for x in found]

    def along(self, state: np.ndarray, node: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """Force [N] of the units that each `state` throttles at numbered levels, these along a
        second axis [-], and `strain` [-].
        """
        total, kind = np.zeros(node.shape), 0
        for row in self.rows:
            for place in range(row.size):
                share = self.throttled[state, kind]
                some = np.flatnonzero(share)
                if len(some):
                    (found,) = self.kept((row.along(place, node[some], strain[some, None]),))
                    total[some] += share[some, None] * found
                kind += 1
        return total

    def terms(self, state: Any, level: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
        """The same forces [N] and their slopes by level [N]."""
        step = where(level < 0.5, _STEP, -_STEP)
        both = self.values(state, library(level).concatenate([level, level + step], axis=1), strain)
        value, moved = both[:, : level.shape[1]], both[:, level.shape[1] :]
        return value, (moved - value) / step[..., None]

    def ends(self, strain: Numbers, state: Any) -> Numbers:
        """Levels [-] between which the curve of each `state` is smooth at each `strain` [-], rising
        along a last axis.
        """
        at_work = library(strain, self.supply)
        found = [kinks.at(strain) for kinks in self.kinks]
        most = max(one.shape[2] for one in found)
        # a kind has as many kinks as its tuning has rows: the others' are all at the end
        more = [((0, 0), (0, 0), (0, most - one.shape[2])) for one in found]
        padded = (at_work.pad(x, n, constant_values=1.0) for x, n in zip(found, more, strict=True))
        kinks = at_work.concatenate(tuple(padded), axis=1)
        if self.alone is None:
            own = kinks.reshape(len(strain), -1)
        else:
            own = kinks[np.arange(len(strain)), at_work.asarray(self.alone)[state]]
        fixed = at_work.broadcast_to(
            at_work.asarray([0.0, *_BETWEEN, 1.0]), (len(own), 2 + len(_BETWEEN))
        )
        return at_work.sort(at_work.concatenate([own, fixed], axis=-1), axis=-1)

    def _alone(self, state: Any, level: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force [N] of the one kind that each `state` throttles, and its slope in strain [N]."""
        total, slope, first = 0.0, 0.0, 0
        kind = library(state).asarray(self.alone)[state]
        for row in self.rows:
            place = kind - first
            found = self.kept(row.picked(place).force(level * self.supply, strain))
            inside = (place >= 0) & (place < row.size)
            total, slope = (
                x + where(inside, more, 0.0) for x, more in zip((total, slope), found, strict=True)
            )
            first += row.size
        share = self.throttled[state, kind]
        return share * total, share * slope

    def kept(self, found: Forces) -> Forces:
        """Of forces and their slopes [N], what counts."""
        if self.resistance:
            return found
        return tuple(where(found[0] > 0, x, 0.0) for x in found)


def bank(
    muscles: Sequence[Muscle],
    counts: Sequence[Any],
    places: Sequence[int],
    length: Numbers | None,
    supply: Numbers,
    states: States,
    resistance: bool,
) -> Bank:
    """The bank of a bundle whose units have `counts` of the `muscles` at `places`; `length`:
    between its plates [m], where that isn't the muscles' own; `supply` $P_s$ [Pa]; `states` of the
    scheme [-].
    """
    groups = stacked(muscles)
    at_once = library(supply, *jax.tree.leaves(muscles)) is np
    rows = tuple(
        Kinds(
            one,
            None if length is None else length / one.length,
            len(row),
            each=tuple(Single(muscles[i], supply) for i in row) if at_once else (),
        )
        for row, one in groups
    )
    order = [i for row, _ in groups for i in row]
    column = [order.index(place) for place in places]

    kinds = np.eye(len(order))[np.array(column)] * library(*counts).stack(counts)[:, None]
    masks, counted = (states.throttled, states.unfed, states.full), states.counted
    if states.independent:
        # each unit by itself: what sets of them give is put together later
        each, none = np.eye(len(places), dtype=bool), np.zeros((len(places),) * 2, bool)
        masks, counted = (each, none, none), (np.diag(each), np.diag(each))
    throttled, no, full = (x.astype(float) @ kinds for x in masks)
    members = [{column[i] for i in np.flatnonzero(row)} for row in masks[0]]
    alone = None
    if all(len(one) == 1 for one in members):
        alone = np.array([one.pop() for one in members])
    kinks = tuple(_kinks(row, supply) for row in rows)
    made = Bank(
        rows, throttled, no, full, alone, kinks, supply, resistance, counted, states.independent
    )
    if not at_once:
        return made
    spoken = ()
    if alone is not None:
        own = throttled[np.arange(len(alone)), alone]
        spoken = tuple(zip(*(x.tolist() for x in (alone, own, no, full)), strict=True))
    return made._replace(guide=Guide(rows, supply, throttled, made.kept), spoken=spoken)


def _kinks(row: Kinds, supply: Numbers) -> Kinks:
    """The kinks of a row's muscles between no pressure and `supply` [Pa].

    Free strain, onset and collapse come later the higher the pressure; from some level on the
    last two come never, and the force jumps there: then the two levels of the table are given
    between which that happens.
    """
    at_work = library(supply, *jax.tree.leaves(row.muscles))
    levels = at_work.asarray(LEVELS)[:, None] * at_work.ones(row.size)
    strain = row.kinks(levels * supply)
    there = at_work.isfinite(strain)
    last = at_work.argmin(there, axis=1) - 1  # of those before the first that is not
    jumps = ~at_work.all(there, axis=1) & (last >= 0)
    place = np.arange(len(LEVELS))[:, None]
    beyond = (place > last[:, None]) & jumps[:, None]
    ends = [at_work.asarray(LEVELS)[maximum(last + i, 0)][:, None] for i in (0, 1)]
    found = [where(beyond, end, levels) for end in ends]
    # rounding apart from the last that was seen, so that all larger strains lie beyond it
    known = where(there & ~beyond, strain, -np.inf)
    risen = running_most(where(beyond, -np.inf, known), 1)
    return Kinks(
        at_work.concatenate(found), at_work.concatenate([risen, risen]), _given(row, supply)
    )


def _given(row: Kinds, supply: Numbers) -> Numbers:
    """Levels [-] at which the tuning's tables have kinks, a row for each kind."""
    tuning = row.muscles.tuning
    at_work = library(supply, tuning.pressures, tuning.dead_band)
    band = at_work.asarray(tuning.dead_band)[..., None]
    # the first row of a table is at zero, where the dead band ends
    return at_work.broadcast_to(
        (tuning.pressures + band) / supply, (row.size, tuning.pressures.shape[-1])
    )

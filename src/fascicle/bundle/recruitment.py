r"""Recruitment: which motor units are active at which pressure, and what that reaches.

A scheme says which units are held at supply pressure in recruitment state $k$ and which
are throttled: *orderly* recruitment holds $1 \dots k-1$ and throttles unit $k$, *batch*
recruitment gives all of $1 \dots k$ one pressure, *free* recruitment has one state, in
which each unit has a pressure of its own. As the throttled pressure goes from zero to the
supply's, a state sweeps a region of the force-strain space. The force isn't
monotone in that pressure where resistance counts, so a region's edges are the least and
the largest force over all pressures, and regions of different states overlap: points that
two states reach. `recruit` is the way back, from a force to the pressures that give it.

**Resolution:** regions are taken over a fixed number of pressures; their edges are exact
where the force is linear in pressure, that is, wherever the muscle pulls.
**Source:** Kim, Mazzoleni and Bryant (2021), sections 4 and 4.1, Figs. 8 and 9.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..core.arrays import given, library
from ..core.checks import as_given, concrete, finite, one_of, within
from ..core.domain import HIGHEST_PRESSURE
from ..core.evaluate import COMPILE_ABOVE, at_rest, evaluate, traced
from ..core.limits import plausible
from ..core.refused import Refused
from ..core.types import Numbers, Values
from .alike import unlike
from .bundle import Bundle
from .recruit.carried import carried
from .recruit.curves import Bank, bank
from .recruit.free import freed
from .recruit.inverse import Recruited, Solutions, recruited
from .schemes import AbstractScheme, scheme_of
from .states import common, states_of
from .tables import unit_tables
from .volumes import unit_volume_change


PREFERENCES = ("efficiency", "nearest")
_LEVELS = 241  # pressures over which a region's edges are taken
_PART, _LARGE_PART = 2**12, 2**14  # demands at once, where a law is compiled for them the second
_SETS = 2**22  # of a set of units and a demand at once: some 0.2 GB
LOOKS = 40  # points of a muscle's law that a demand takes of each unit, about
Forces = Float[np.ndarray, "state strain"]


@dataclass(frozen=True)
class Space:
    """Force-strain space of a bundle: curves at constant pressure, and regions.

    `force` [N] has state, level and strain axes; `low` and `high` [N] state and strain:
    the edges of each state's region. `level` [Pa] is the throttled pressure, `strain` [-].
    """

    scheme: str
    supply_pressure: float
    strain: Float[np.ndarray, " strain"]
    level: Float[np.ndarray, " level"]
    force: Float[np.ndarray, "state level strain"]
    low: Forces
    high: Forces

    def outline(self, state: int) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """Outline of the region of a `state`, counted from 1: strain [-] and force [N].

        Where the bundle would push, the outline is at zero force.
        """
        low, high = (np.maximum(edge[state - 1], 0.0) for edge in (self.low, self.high))
        reached = self.high[state - 1] >= 0
        strain = self.strain[reached]
        return np.r_[strain, strain[::-1]], np.r_[high[reached], low[reached][::-1]]


@dataclass(frozen=True)
class Overlap:
    """Points that two states reach. Row by row: `states`, counted from 1, the edges `low`
    and `high` [N] over `strain` [-] (NaN where there is no overlap), and the `area` [N].
    """

    states: tuple[tuple[int, int], ...]
    strain: Float[np.ndarray, " strain"]
    low: Float[np.ndarray, "pair strain"]
    high: Float[np.ndarray, "pair strain"]
    area: Float[np.ndarray, " pair"]

    @property
    def width(self) -> Float[np.ndarray, "pair strain"]:
        """Height of the overlap in force [N] at each strain, zero where there is none."""
        return np.nan_to_num(self.high - self.low)

    def outline(self, pair: int) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """Outline of a row `pair`: strain [-] and force [N], empty where there is none."""
        there = np.isfinite(self.low[pair])
        strain = self.strain[there]
        low, high = self.low[pair][there], self.high[pair][there]
        return np.r_[strain, strain[::-1]], np.r_[high, low[::-1]]


def pressures_of(
    state: int,
    level: Values,
    supply_pressure: Values,
    units: int,
    scheme: AbstractScheme | str = "orderly",
) -> Float[np.ndarray, "*levels unit"]:
    """Pressures of all units in a recruitment state.

    **Arguments:**

    - `state`: which [-], counted from 1.
    - `level`: the throttled pressure [Pa]: of unit `state` in orderly recruitment, of all
      active units in batch recruitment. Any shape.
    - `supply_pressure`: of the units before it in orderly recruitment [Pa].
    - `units`: number of motor units [-].
    - `scheme`: one of `fascicle.schemes`, by name or as an object [-]; all units of free
      recruitment have the one `level` here.

    **Returns:** pressures [Pa], units on a new last axis.

    **Raises:** `ValueError` for a state that doesn't exist or an unknown scheme.
    """
    states = states_of(scheme_of(scheme), units)
    if not 1 <= state <= states.size:
        raise Refused("state", f"must lie in [1, {states.size}]", state)
    throttled, full = states.throttled[state - 1], states.full[state - 1]
    level = np.asarray(level, dtype=float)[..., None]
    return np.where(throttled, level, np.where(full, float(supply_pressure), 0.0))


def space(
    bundle: Bundle,
    supply_pressure: Values = None,
    levels: Values = 7,
    strain: Values = None,
    resistance: bool = True,
    scheme: AbstractScheme | str | None = None,
) -> Space:
    """The force-strain space of every recruitment state.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `supply_pressure`: [Pa]; left out, the bundle's own.
    - `levels`: throttled pressures of the curves [Pa], or how many of them [-], evenly from
      zero to the supply's.
    - `strain`: rising strains [-]; left out, 201 from zero to the largest free strain.
    - `resistance`: whether units past their own free strain push back [-].
    - `scheme`: one of `fascicle.schemes`, by name or as an object [-]; left out, the bundle's own.

    **Returns:** a `Space`: forces [N], strains [-], pressures [Pa].

    **Raises:** `ValueError` where no supply pressure is known or a value is off.
    """
    supply = supply_of(bundle, supply_pressure)
    scheme = scheme_used(bundle, scheme)
    if np.ndim(levels) == 0:
        levels = np.linspace(0.0, supply, int(levels))
    levels = np.asarray(within(levels, 0.0, supply, "levels", "Pa", closed=(True, True)))
    if strain is None:
        full = np.full(len(bundle.motor_units), supply)
        strain = np.linspace(0.0, float(bundle.free_strain(full, resistance=False)), 201)
    strain = np.asarray(strain, dtype=float)
    fine = np.linspace(0.0, supply, _LEVELS)
    states = states_of(scheme, len(bundle.motor_units))
    region = unit_tables(bundle, supply, np.union1d(fine, levels), strain, resistance)
    curves = states.sums(*unit_tables(bundle, supply, levels, strain, resistance))
    return Space(scheme.name, supply, strain, levels, curves, *states.edges(*region))


def overlap(space: Space) -> Overlap:
    """Where the regions of two states overlap, at forces of zero and above.

    **Arguments:** `space`: a force-strain space [-].

    **Returns:** an `Overlap`, a row for each pair of states: forces [N], areas [N].
    """
    pairs = tuple(combinations(range(1, len(space.low) + 1), 2))
    shape = (len(pairs), len(space.strain))
    low, high = np.full(shape, np.nan), np.full(shape, np.nan)
    for row, (i, j) in enumerate(pairs):
        bottom, top = common(*((space.low[k - 1], space.high[k - 1]) for k in (i, j)))
        # regions that share an edge alone don't overlap: it is the same sum, rounded
        there = top - bottom > 1e-9 * np.abs(space.high).max()
        low[row, there], high[row, there] = bottom[there], top[there]
    area = np.trapezoid(np.nan_to_num(high - low), space.strain, axis=1)
    return Overlap(pairs, space.strain, low, high, area)


def recruit(
    bundle: Bundle,
    force: Values,
    strain: Values,
    supply: Values = None,
    scheme: AbstractScheme | str | None = None,
    prefer: str = "efficiency",
    *,
    present: Values = None,
    resistance: bool = True,
) -> Recruited:
    """Which state and pressures give a force at a strain, equation (B9).

    **Arguments:**

    - `bundle`: the bundle [-].
    - `force`: the demanded pulling force [N].
    - `strain`: the bundle's contraction [-]; broadcasts against `force`.
    - `supply`: the supply's pressure [Pa], one for all; left out, the bundle's own.
    - `scheme`: one of `fascicle.schemes`, by name or as an object [-]; left out, the bundle's own.
    - `prefer`: of several solutions, "efficiency" for the one that takes least fluid, or
      "nearest" for the one whose pressures are nearest to `present` [-].
    - `present`: the pressures now [Pa], units on the last axis; the rest broadcasts.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** `Recruited`: pressures [Pa], state [-], force [N] and status [-], and all
    solutions. Where the demanded force can't be reached, the nearest that can, and a status.

    **Raises:** `ValueError` for values off the domain, unknown names, no supply pressure, and
    "nearest" without `present`.
    """
    scheme = scheme_used(bundle, scheme)
    one_of(prefer, PREFERENCES, "prefer")
    F, eps = as_given(force, finite(force, "force", "N")), bundle._strain(strain)
    P = _supply(bundle, supply)
    now = None
    if prefer == "nearest":
        if scheme.independent:
            raise Refused(
                "prefer",
                f"must be 'efficiency' with scheme {scheme.name!r}",
                prefer,
                "its units' pressures are free, so what is nearest isn't one of a few solutions",
            )
        if present is None:
            raise Refused(
                "present",
                "must be given in Pa with `prefer` 'nearest'",
                None,
                f"a pressure for each of the {len(bundle.motor_units)} motor units",
            )
        now = bundle._pressures(present)
    points = int(np.size(F) * np.size(eps)) * LOOKS * len(bundle.motor_units)
    arrays = (F, eps, P) if now is None else (F, eps, P, now)
    static = (scheme, bool(resistance))
    if (rest := at_rest(bundle, *arrays)) is None:
        return evaluate(_in_parts, bundle, *arrays, points=points, static=static)
    found = evaluate(_in_parts, *rest, points=points, static=static)
    points = 2 * np.size(found.pressures)  # a force, and its slope
    return traced(_carried, bundle, *arrays[:3], found, points=points, static=static)


def _in_parts(bundle: Bundle, *arguments: Any) -> Recruited:
    """Many demands of NumPy's, part by part, so that they fit into memory."""
    *arrays, scheme, resistance = arguments
    force, strain, supply, *present = arrays
    shape = np.broadcast_shapes(
        np.shape(force), np.shape(strain), *(np.shape(now)[:-1] for now in present)
    )
    at_work, units = library(*arrays), len(bundle.motor_units)
    flat = {"force": force, "strain": strain}
    flat = {key: at_work.broadcast_to(x, shape).reshape(-1) for key, x in flat.items()}
    for now in present:
        flat["present"] = at_work.broadcast_to(now, (*shape, units)).reshape(-1, units)
    curves = _bank(bundle, supply, scheme, resistance)
    count = flat["force"].size
    step = max(1, count)
    if at_work is np and bundle.is_numpy:
        many = step * LOOKS * units > COMPILE_ABOVE
        step = _LARGE_PART if many else _PART
        curves = curves.for_many() if many else curves
    states = states_of(scheme, units)
    search: Callable[..., Recruited] = partial(recruited, states=states)
    if states.independent:
        alike = unlike(bundle.motor_units)[1]
        sets, owner = states.sets(alike)
        search = partial(freed, sets=sets, owner=owner, alike=alike)
        if at_work is np:
            step = max(1, min(step, _SETS // sets.size))
    if states.independent or not states.nested:
        # what each unit takes in decides which of them are fed
        flat["taken"] = unit_volume_change(bundle, flat["strain"])
    parts = [
        search(curves, **{key: x[start : start + step] for key, x in flat.items()})
        for start in range(0, max(1, count), step)
    ]
    whole = parts[0] if len(parts) == 1 else _joined(parts)
    whole = jax.tree.map(lambda leaf: leaf.reshape((*shape, *leaf.shape[1:])), whole)
    if at_work is np and bundle.is_numpy:
        return whole
    return _carried(bundle, force, strain, supply, whole, scheme, resistance)


def _carried(
    bundle: Bundle, force: Any, strain: Any, supply: Any, found: Recruited, *static: Any
) -> Recruited:
    """What was found without derivatives, with them."""
    scheme, resistance = static
    at_work, units = library(force, strain, found.unit), len(bundle.motor_units)
    states = states_of(scheme, units)
    throttled = np.arange(units) == found.unit[..., None] - 1
    if not states.independent:
        throttled = at_work.asarray(states.throttled)[found.state - 1]
    F, eps = (at_work.broadcast_to(x, found.state.shape) for x in (force, strain))
    return carried(bundle, F, eps, supply, found, throttled, resistance)


def _joined(parts: list[Recruited]) -> Recruited:
    slots = max(part.solutions.state.shape[1] for part in parts)
    wide = []
    for part in parts:
        more = ((0, 0), (0, slots - part.solutions.state.shape[1]))
        fills = (np.nan, 0, False)
        padded = (
            np.pad(x, more, constant_values=fill)
            for x, fill in zip(part.solutions, fills, strict=True)
        )
        wide.append(part._replace(solutions=Solutions(*padded)))
    return jax.tree.map(lambda *leaves: np.concatenate(leaves), *wide)


def _bank(bundle: Bundle, supply: Numbers, scheme: AbstractScheme, resistance: bool) -> Bank:
    """The curves of a bundle's states at `supply` [Pa]; kept, as they take longer than a demand."""
    key = (scheme, resistance)
    kept = bundle.store.setdefault("banks", {})
    if bundle.is_numpy and given(supply) and (known := kept.get(key)) and known[0] == supply:
        return known[1]
    muscles = [unit.muscle for unit in bundle.motor_units]
    few, places = unlike(muscles)
    counts = [unit.count for unit in bundle.motor_units]
    states = states_of(scheme, len(muscles))
    rows = [muscles[i] for i in few]
    made = bank(rows, counts, places, bundle.plate_distance, supply, states, resistance)
    if bundle.is_numpy and given(supply):
        kept[key] = (supply, made)
    return made


def scheme_used(bundle: Bundle, scheme: AbstractScheme | str | None) -> AbstractScheme:
    """The scheme that is asked for, or the bundle's own.

    **Arguments:** `bundle` [-]; `scheme`: by name or as an object [-], or `None`.

    **Returns:** the scheme [-].

    **Raises:** `ValueError` for an unknown name.
    """
    return bundle.scheme if scheme is None else scheme_of(scheme)


def supply_of(bundle: Bundle, supply_pressure: Values = None) -> float:
    """The supply pressure that holds: the one given, else the bundle's own.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `supply_pressure`: the one given [Pa], or None.

    **Returns:** supply pressure [Pa].

    **Raises:** `ValueError` where there is neither.
    """
    supply = bundle.supply_pressure if supply_pressure is None else supply_pressure
    if supply is None:
        raise Refused(
            "supply_pressure", "must be given in Pa", None, "the bundle has none of its own"
        )
    P = within(supply, 0.0, HIGHEST_PRESSURE, "supply_pressure", "Pa", "(gauge)", (False, True))
    return float(plausible(P, "supply_pressure"))


def _supply(bundle: Bundle, supply: Values) -> Numbers:
    supply = bundle.supply_pressure if supply is None else supply
    # a traced one can't be looked at, nor made a float
    return np.float64(supply_of(bundle, supply)) if concrete(supply) else jnp.asarray(supply)

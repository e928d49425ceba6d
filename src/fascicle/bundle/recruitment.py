r"""Recruitment: which motor units are active at which pressure.

A scheme says which units are held at supply pressure in recruitment state $k$ and which
are throttled: *orderly* recruitment holds $1 \dots k-1$ and throttles unit $k$, *batch*
recruitment gives all of $1 \dots k$ one pressure, *free* recruitment has one state, in
which each unit has a pressure of its own. `space` is what that reaches, `recruit` the way back,
from a force to the pressures that give it.

**Source:** Kim, Mazzoleni and Bryant (2021), section 4, Fig. 8.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..core.arrays import given, library
from ..core.checks import as_given, concrete, finite, one_of
from ..core.evaluate import COMPILE_ABOVE, at_rest, evaluate, traced
from ..core.refused import Refused
from ..core.shapes import common
from ..core.types import Numbers, Values
from ..core.written import in_si
from .alike import unlike
from .bundle import Bundle
from .own import scheme_used, supply_of
from .recruit.carried import carried
from .recruit.curves import Bank, bank
from .recruit.free import freed
from .recruit.inverse import Recruited, Solutions, recruited
from .recruit.one import one
from .schemes import AbstractScheme, scheme_of
from .space import Overlap, Space, overlap, space
from .states import states_of
from .volumes import unit_volume_change


__all__ = [
    "Overlap",
    "Recruited",
    "Solutions",
    "Space",
    "overlap",
    "pressures_of",
    "recruit",
    "space",
]

PREFERENCES = ("efficiency", "nearest")
_PART, _LARGE_PART = 2**12, 2**16  # demands at once, where a law is compiled for them the second
_SETS = 2**22  # of a set of units and a demand at once: some 0.2 GB
LOOKS = 8  # points of a muscle's law that a demand takes of each unit, about


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
    level = np.asarray(in_si(level, "level", "Pa"), dtype=float)[..., None]
    supply = float(in_si(supply_pressure, "supply_pressure", "Pa"))
    return np.where(throttled, level, np.where(full, supply, 0.0))


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
    before = {} if now is None else {"present": np.shape(now)[:-1]}
    common(force=np.shape(F), strain=np.shape(eps), **before)
    points = int(np.size(F) * np.size(eps)) * LOOKS * len(bundle.motor_units)
    arrays = (F, eps, P) if now is None else (F, eps, P, now)
    static = (scheme, bool(resistance))
    plain = bundle.is_numpy and given(*arrays)  # soon told
    if plain or (rest := at_rest(bundle, *arrays)) is None:
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
    flat = {
        key: (x if np.shape(x) == shape else at_work.broadcast_to(x, shape)).reshape(-1)
        for key, x in flat.items()
    }
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
    found = one(curves, **flat, states=states) if count == 1 and "taken" not in flat else None
    parts = (
        [found]
        if found is not None
        else [
            search(curves, **{key: x[start : start + step] for key, x in flat.items()})
            for start in range(0, max(1, count), step)
        ]
    )
    whole = parts[0] if len(parts) == 1 else _joined(parts)
    if shape != (count,):
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


def _supply(bundle: Bundle, supply: Values) -> Numbers:
    supply = bundle.supply_pressure if supply is None else supply
    # a traced one can't be looked at, nor made a float
    return np.float64(supply_of(bundle, supply)) if concrete(supply) else jnp.asarray(supply)

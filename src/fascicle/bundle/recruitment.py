r"""Recruitment: which motor units are active at which pressure.

A scheme says which units are held at supply pressure in recruitment state $k$ and which
are throttled: *orderly* recruitment holds $1 \dots k-1$ and throttles unit $k$, *batch*
recruitment gives all of $1 \dots k$ one pressure, *free* recruitment has one state, in
which each unit has a pressure of its own. `space` is what that reaches, `recruit` the way back,
from a force to the pressures that give it.

**Source:** Kim, Mazzoleni and Bryant (2021), section 4, Fig. 8.
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from ..core.array_namespace import is_numpy, where
from ..core.errors import InvalidInputError
from ..core.roots import guarded, stop_gradient
from ..core.types import Float, Numbers, Values
from ..core.validation import (
    broadcast_shape,
    check_choice,
    check_finite,
    is_concrete,
    match_array_type,
    to_si,
)
from .bundle import Bundle, resolve_scheme, resolve_supply_pressure
from .efficiency import unit_volume_change
from .inverse import PART, REACHED, ROOM, Curves, Recruited, Solutions, freed, recruited
from .pressurized import pressurized, unique_indices
from .schemes import AbstractScheme, scheme_of
from .states import States, states_of
from .workspace import Overlap, Space, overlap, space


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
_SETS = 2**22  # of a set of units and a demand at once: some 0.2 GB


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
        raise InvalidInputError("state", f"must lie in [1, {states.size}]", state)
    throttled, full = states.throttled[state - 1], states.full[state - 1]
    level = np.asarray(to_si(level, "level", "Pa"), dtype=float)[..., None]
    supply = float(to_si(supply_pressure, "supply_pressure", "Pa"))
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
    scheme = resolve_scheme(bundle, scheme)
    check_choice(prefer, PREFERENCES, "prefer")
    F, eps = match_array_type(force, check_finite(force, "force", "N")), bundle._strain(strain)
    P = _supply(bundle, supply)
    now = None
    if prefer == "nearest":
        if scheme.independent:
            raise InvalidInputError(
                "prefer",
                f"must be 'efficiency' with scheme {scheme.name!r}",
                prefer,
                "its units' pressures are free, so what is nearest isn't one of a few solutions",
            )
        if present is None:
            raise InvalidInputError(
                "present",
                "must be given in Pa with `prefer` 'nearest'",
                None,
                f"a pressure for each of the {len(bundle.motor_units)} motor units",
            )
        now = bundle._pressures(present)
    before = {} if now is None else {"present": np.shape(now)[:-1]}
    broadcast_shape(force=np.shape(F), strain=np.shape(eps), **before)
    arrays = (F, eps) if now is None else (F, eps, now)
    static = (scheme, bool(resistance))
    if bundle.is_numpy and is_numpy(P, *arrays):
        return _solved(bundle, P, *arrays, *static)
    return _traced(bundle, P, *arrays, static=static)


def _solved(bundle: Bundle, supply: Any, *arguments: Any) -> Recruited:
    """Demands of NumPy's, part by part, so that they fit into memory."""
    *arrays, scheme, resistance = arguments
    force, strain, *present = arrays
    units = len(bundle.motor_units)
    shape = np.broadcast_shapes(
        np.shape(force), np.shape(strain), *(np.shape(now)[:-1] for now in present)
    )
    flat: dict[str, Any] = {
        key: np.broadcast_to(x, shape).reshape(-1) + 0.0
        for key, x in (("force", force), ("strain", strain))
    }
    for now in present:
        flat["present"] = np.broadcast_to(now, (*shape, units)).reshape(-1, units)
    states, count = states_of(scheme, units), flat["force"].size
    with np.errstate(all="ignore"):  # of branches that aren't taken
        curves = _curves(bundle, float(supply), states, resistance)
        search: Callable[..., Recruited] = partial(recruited, curves, states=states)
        step = PART
        if states.independent:
            sets, owner = states.sets(unique_indices(bundle.motor_units)[1])
            search = partial(freed, curves, sets=sets, owner=owner)
            step = max(1, min(step, _SETS // sets.size))
        if states.independent or not states.nested:
            # what each unit takes in decides which of them are fed
            flat["taken"] = unit_volume_change(bundle, flat["strain"])
        parts = [
            search(**{key: x[start : start + step] for key, x in flat.items()})
            for start in range(0, max(1, count), step)
        ]
    whole = parts[0] if len(parts) == 1 else _joined(parts)
    return _each(whole, lambda x: x.reshape((*shape, *x.shape[1:]))[()])


def _each(found: Any, function: Callable[[Any], Any]) -> Any:
    """`function` of every array of what was `found`."""
    if isinstance(found, tuple):
        return type(found)(*(_each(x, function) for x in found))
    return function(found)


def _joined(parts: list[Recruited]) -> Recruited:
    slots = max(part.solutions.state.shape[1] for part in parts)
    wide = [part._replace(solutions=_wide(part.solutions, slots)) for part in parts]
    solutions = Solutions(*map(np.concatenate, zip(*(x.solutions for x in wide), strict=True)))
    names = [name for name in Recruited._fields if name != "solutions"]
    rest = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Recruited(solutions=solutions, **rest)


def _wide(solutions: Solutions, slots: int) -> Solutions:
    """The same with room for so many `slots` [-] on the last axis."""
    size = np.shape(solutions.state)[-1]
    more = [(0, 0)] * (np.ndim(solutions.state) - 1) + [(0, max(slots - size, 0))]
    fills = (np.nan, 0, False)
    return Solutions(*(
        np.pad(x, more, constant_values=fill)[..., :slots]
        for x, fill in zip(solutions, fills, strict=True)
    ))  # fmt: skip


def _curves(bundle: Bundle, supply: float, states: States, resistance: bool) -> Curves:
    """The curves of a bundle's states at `supply` [Pa]; kept, as they take longer than a demand."""
    kept, key = bundle.cache.setdefault("curves", {}), (states.scheme, resistance)
    known = kept.get(key)
    if known is None or known[0] != supply or known[1] is not states:
        kept[key] = known = (supply, states, Curves(bundle, supply, states, resistance))
    return known[2]


def _traced(bundle: Bundle, supply: Any, *arrays: Any, static: tuple) -> Recruited:
    """Demands of which JAX has some number: found by NumPy, and carried by JAX."""
    import jax
    import jax.numpy as jnp

    scheme, _ = static
    states, units = states_of(scheme, len(bundle.motor_units)), len(bundle.motor_units)
    force, strain, *present = arrays
    shape = np.broadcast_shapes(
        np.shape(force), np.shape(strain), *(np.shape(now)[:-1] for now in present)
    )
    force, strain = (jnp.broadcast_to(x, shape) for x in (force, strain))
    present = [jnp.broadcast_to(now, (*shape, units)) for now in present]
    slots = 1 if states.independent else ROOM * states.size + 2

    def answer(single: tuple, *arrays: Any) -> Recruited:
        found = _solved(*single, *arrays, *static)
        if states.independent:
            return found
        return found._replace(solutions=_wide(found.solutions, slots))

    number = jax.ShapeDtypeStruct(shape, float)
    whole, mark = (jax.ShapeDtypeStruct(shape, kind) for kind in (int, bool))
    rows = ((*shape, slots), (*shape, units))
    shapes = Recruited(
        jax.ShapeDtypeStruct(rows[1], float), whole, number, whole, mark,
        Solutions(*(jax.ShapeDtypeStruct(rows[0], kind) for kind in (float, int, bool))),
        whole, whole,
    )  # fmt: skip
    found = numpy_callback(
        answer, shapes, *stop_gradient(((bundle, supply), force, strain, *present))
    )
    return _carry(*static)(bundle, force, strain, supply, found)


@cache
def _carry(scheme: AbstractScheme, resistance: bool) -> Callable[..., Recruited]:
    import jax

    return jax.jit(partial(_carried, scheme=scheme, resistance=resistance))


def _carried(
    bundle: Bundle,
    force: Any,
    strain: Any,
    supply: Any,
    found: Recruited,
    scheme: AbstractScheme,
    resistance: bool,
) -> Recruited:
    r"""What was found without derivatives, with them: one step of Newton's from the root of (B9),

    $$\mathrm{d}p = (\mathrm{d}F_d - \mathrm{d}F|_p)/(\partial F/\partial p), \tag{B12}$$

    where $p$ is what the throttled units share. The others stay at their share of the supply, which
    also holds of those throttled where the demand wasn't reached.
    """
    import jax

    units, states = len(bundle.motor_units), states_of(scheme, len(bundle.motor_units))
    throttled = np.arange(units) == found.unit[..., None] - 1
    if not states.independent:
        throttled = jax.numpy.asarray(states.throttled)[found.state - 1]

    def total(bundle: Bundle, pressures: Any, strain: Any) -> Any:
        forces, _ = pressurized(bundle, pressures).unit_forces(strain)
        return where((forces > 0) | resistance, forces, 0.0).sum(axis=-1)

    P = found.pressures / stop_gradient(supply) * supply
    given_force = total(bundle, P, strain)
    fixed, eps = stop_gradient((bundle, strain))
    slope = jax.jvp(lambda p: total(fixed, p, eps), (stop_gradient(P),), (1.0 * throttled,))[1]
    reached = found.status == REACHED
    moves = reached & (slope != 0)
    short = where(moves, force - given_force, 0.0)
    step = (short - stop_gradient(short)) / guarded(moves, slope)
    return found._replace(
        pressures=P + where(throttled, step[..., None], 0.0),
        force=where(reached, force + stop_gradient(found.force - force), given_force),
    )


def _supply(bundle: Bundle, supply: Values) -> Numbers:
    supply = bundle.supply_pressure if supply is None else supply
    # a traced one can't be looked at, nor made a float
    return np.float64(resolve_supply_pressure(bundle, supply)) if is_concrete(supply) else supply


def numpy_callback(function: Callable[..., Any], shapes: Any, single: Any, *arrays: Any) -> Any:
    """`function(single, *arrays)` by NumPy, without derivatives, also under `jit` and `vmap`.

    **Arguments:**

    - `function`: of modules and arrays of NumPy's; elementwise in `arrays`.
    - `shapes`: a tree of `jax.ShapeDtypeStruct`, as the result is for these arguments.
    - `single`: a tree of modules and arrays, one at a time.
    - `arrays`: that may have more axes in front, where `vmap` adds them.

    **Returns:** the result, JAX's.
    """
    import jax

    leaves, structure = jax.tree.flatten(single)
    # in single precision results are, too; the search itself is not
    shapes = jax.tree.map(
        lambda x: jax.ShapeDtypeStruct(x.shape, jax.dtypes.canonicalize_dtype(x.dtype)), shapes
    )
    own = [np.ndim(x) for x in (*leaves, *arrays)]

    def answer(*values: Any) -> Any:
        numbers = [np.asarray(x, float if x.dtype.kind == "f" else None) for x in values]
        fronts = [x.shape[: x.ndim - n] for x, n in zip(numbers, own, strict=True)]
        batch, several = (
            np.broadcast_shapes(*some) for some in (fronts, fronts[: len(leaves)] or [()])
        )
        tails = [x.shape[len(front) :] for x, front in zip(numbers, fronts, strict=True)]
        asked = [
            np.broadcast_to(x, (*batch, *tail)) for x, tail in zip(numbers, tails, strict=True)
        ]
        if np.prod(several) == 1:  # one module, whatever it is asked
            one = [x.reshape(tail) for x, tail in zip(numbers[: len(leaves)], tails, strict=False)]
            found = function(jax.tree.unflatten(structure, one), *asked[len(leaves) :])
            return jax.tree.map(lambda x, like: np.asarray(x, like.dtype), found, shapes)
        rows = []
        for i in np.ndindex(batch):
            module = jax.tree.unflatten(structure, [x[i] for x in asked[: len(leaves)]])
            rows.append(function(module, *(x[i] for x in asked[len(leaves) :])))
        return jax.tree.map(
            lambda like, *x: np.reshape(x, (*batch, *like.shape)).astype(like.dtype), shapes, *rows
        )

    return jax.pure_callback(answer, shapes, *leaves, *arrays, vmap_method="expand_dims")

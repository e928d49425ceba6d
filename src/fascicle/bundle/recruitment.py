r"""Recruitment: the pressures of motor units in each recruitment state, and for a force.

A scheme says which units are held at supply pressure in recruitment state $k$ and which
are throttled: *orderly* recruitment holds $1 \dots k-1$ and throttles unit $k$, *batch*
recruitment gives all of $1 \dots k$ one pressure, *free* recruitment has one state, in
which each unit has a pressure of its own. `space` is the region that they reach, `recruit` the
inverse, from a force to the pressures that give it.

**Source:** Kim, Mazzoleni and Bryant (2021), section 4, Fig. 8.
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from ..core.array_namespace import is_numpy, where
from ..core.errors import InvalidInputError
from ..core.lazy import attach_lazy
from ..core.module import tree_map
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
from .force_curves import StateCurves
from .inverse import (
    REACHED,
    SLOTS_PER_STATE,
    RecruitmentResult,
    Solutions,
    minimum_energy_pressures,
    solve_inverse,
)
from .pressurized import pressurized, unique_indices
from .schemes import AbstractScheme, scheme_of
from .states import States, states_of
from .workspace import Overlap, Space, overlap, space


__all__ = [
    "Overlap",
    "RecruitmentResult",
    "Solutions",
    "Space",
    "overlap",
    "pressures_of",
    "recruit",
    "space",
]
__getattr__, _ = attach_lazy(__name__, {}, renamed={"Recruited": "RecruitmentResult"})

PREFERENCES = ("efficiency", "nearest")
_MAX_PAIRS = 2**22  # of a set of units and a demand at once: some 0.2 GB
_BATCH = 2**13  # demands at once, of independent units


def pressures_of(
    state: int,
    level: Values,
    supply_pressure: Values,
    units: int,
    scheme: AbstractScheme | str = "orderly",
) -> Float[np.ndarray, "*levels unit"]:
    """Pressures of all units in a recruitment state.

    **Arguments:**

    - `state`: number of the state, counted from 1.
    - `level`: the throttled pressure [Pa]: of unit `state` in orderly recruitment, of all
      pressurized units in batch and free recruitment. Any shape.
    - `supply_pressure`: of the units before it in orderly recruitment [Pa].
    - `units`: number of motor units.
    - `scheme`: one of `fascicle.schemes`, by name or as an object.

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
) -> RecruitmentResult:
    """State and pressures that give a force at a strain, equation (B9).

    **Arguments:**

    - `bundle`: the bundle.
    - `force`: the demanded pulling force [N].
    - `strain`: the bundle's contraction [-]; broadcasts against `force`.
    - `supply`: the supply's pressure [Pa], one for all; by default the bundle's own.
    - `scheme`: one of `fascicle.schemes`, by name or as an object; by default the bundle's own.
    - `prefer`: of several solutions, "efficiency" for the one that takes least fluid, or
      "nearest" for the one whose pressures are nearest to `present`.
    - `present`: the present pressures [Pa], units on the last axis; the rest broadcasts.
    - `resistance`: units past their own free strain push back.

    **Returns:** `RecruitmentResult`: pressures [Pa], state, force [N], status and all solutions.
    If the demanded force can't be reached, the nearest that can, and a status.

    **Raises:** `ValueError` for values off the domain, unknown names, no supply pressure, and
    "nearest" without `present`.
    """
    scheme = resolve_scheme(bundle, scheme)
    check_choice(prefer, PREFERENCES, "prefer")
    F = match_array_type(force, check_finite(force, "force", "N"))
    eps = bundle._check_strain(strain)
    supply = bundle.supply_pressure if supply is None else supply
    if is_concrete(supply):  # a traced one can't be checked
        supply = np.float64(resolve_supply_pressure(bundle, supply))
    arrays: tuple[Numbers, ...] = (F, eps)
    shapes = {"force": np.shape(F), "strain": np.shape(eps)}
    if prefer == "nearest":
        if scheme.independent:
            raise InvalidInputError(
                "prefer",
                f"must be 'efficiency' with scheme {scheme.name!r}",
                prefer,
                "its units' pressures are free: there is no list of solutions of which one is the"
                " nearest",
            )
        if present is None:
            raise InvalidInputError(
                "present",
                "must be given in Pa with `prefer` 'nearest'",
                None,
                f"pass a pressure for each of the {len(bundle.motor_units)} motor units",
            )
        arrays = (F, eps, bundle._check_pressures(present))
        shapes["present"] = np.shape(arrays[2])[:-1]
    shape, units = broadcast_shape(**shapes), len(bundle.motor_units)
    solve = _solve if bundle.is_numpy and is_numpy(supply, *arrays) else _solve_traced
    xp = np if solve is _solve else _jax_numpy()
    arrays = tuple(xp.broadcast_to(x, shape) for x in arrays[:2]) + tuple(
        xp.broadcast_to(x, (*shape, units)) for x in arrays[2:]
    )
    return solve(bundle, supply, *arrays, scheme=scheme, resistance=bool(resistance))


def _jax_numpy() -> Any:
    import jax.numpy as jnp

    return jnp


def _solve(
    bundle: Bundle,
    supply: Any,
    force: np.ndarray,
    strain: np.ndarray,
    *present: np.ndarray,
    scheme: AbstractScheme,
    resistance: bool,
) -> RecruitmentResult:
    """Result for demands of one shape, by NumPy."""
    shape, units = np.shape(force), len(bundle.motor_units)
    F, eps = (np.reshape(x, -1) + 0.0 for x in (force, strain))
    states = states_of(scheme, units)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        curves = _cached_curves(bundle, float(supply), states, resistance)
        if states.independent:
            volume = unit_volume_change(bundle, eps)
            sets, owner = states.sets(unique_indices(bundle.motor_units)[1])
            size = max(1, min(_BATCH, _MAX_PAIRS // sets.size))
            parts = [
                minimum_energy_pressures(curves, F[batch], eps[batch], volume[batch], sets, owner)
                for batch in (slice(i, i + size) for i in range(0, max(1, F.size), size))
            ]
            result = tree_map(lambda *x: np.concatenate(x), *parts)
        else:
            pressures = present[0].reshape(-1, units) if present else None
            # otherwise the order of states is that of their energies
            volume = None if states.nested else unit_volume_change(bundle, eps)
            result = solve_inverse(curves, F, eps, states, pressures, volume)
    return tree_map(lambda x: x.reshape((*shape, *x.shape[1:]))[()], result)


def _cached_curves(bundle: Bundle, supply: float, states: States, resistance: bool) -> StateCurves:
    """Force curves at a `supply` [Pa], kept with the bundle: they take longer than a demand."""
    cache, key = bundle.cache.setdefault("curves", {}), (states.scheme, resistance)
    curves = cache.get(key)
    if curves is None or curves.supply != supply or curves.scheme_states is not states:
        curves = cache[key] = StateCurves(bundle, supply, states, resistance)
    return curves


def _solve_traced(
    bundle: Bundle,
    supply: Any,
    force: Any,
    strain: Any,
    *present: Any,
    scheme: AbstractScheme,
    resistance: bool,
) -> RecruitmentResult:
    """Result for demands with arrays of JAX's: solved by NumPy, with derivatives by JAX."""
    import jax

    states, shape = states_of(scheme, len(bundle.motor_units)), np.shape(force)
    slots = 1 if states.independent else SLOTS_PER_STATE * states.size + 2

    def solve(*arguments: Any) -> RecruitmentResult:
        # in single precision only arguments and results are; the search itself is not
        arguments = tree_map(
            lambda x: np.asarray(x, float if x.dtype.kind == "f" else None), arguments
        )
        result = _solve(*arguments, scheme=scheme, resistance=resistance)
        result = result._replace(solutions=Solutions(*(x[..., :slots] for x in result.solutions)))
        return tree_map(lambda x, shape: np.asarray(x, shape.dtype), result, shapes)

    def array_spec(kind: type, *columns: int) -> Any:
        return jax.ShapeDtypeStruct((*shape, *columns), jax.dtypes.canonicalize_dtype(kind))

    solutions = Solutions(*(array_spec(kind, slots) for kind in (float, int, bool)))
    shapes = RecruitmentResult(
        pressures=array_spec(float, len(bundle.motor_units)),
        state=array_spec(int),
        force=array_spec(float),
        status=array_spec(int),
        stable=array_spec(bool),
        solutions=solutions,
        count=array_spec(int),
        unit=array_spec(int),
    )
    arguments = stop_gradient((bundle, supply, force, strain, *present))
    result = jax.pure_callback(solve, shapes, *arguments, vmap_method="sequential")
    return _derivatives_for(scheme, resistance)(bundle, force, strain, supply, result)


@cache
def _derivatives_for(scheme: AbstractScheme, resistance: bool) -> Callable[..., RecruitmentResult]:
    import jax

    return jax.jit(partial(_attach_derivatives, scheme=scheme, resistance=resistance))


def _attach_derivatives(
    bundle: Bundle,
    force: Any,
    strain: Any,
    supply: Any,
    result: RecruitmentResult,
    scheme: AbstractScheme,
    resistance: bool,
) -> RecruitmentResult:
    r"""A result with its derivatives, by one step of Newton's from the root of (B9),

    $$\mathrm{d}p = (\mathrm{d}F_d - \mathrm{d}F|_p)/(\partial F/\partial p), \tag{B12}$$

    where $p$ is the pressure that the throttled units share. The others stay at their fraction of
    the supply, and so do throttled units if the demand wasn't reached.
    """
    import jax

    units, states = len(bundle.motor_units), states_of(scheme, len(bundle.motor_units))
    throttled = np.arange(units) == result.unit[..., None] - 1
    if not states.independent:
        throttled = jax.numpy.asarray(states.throttled)[result.state - 1]

    def total(bundle: Bundle, pressures: Any, strain: Any) -> Any:
        forces, _ = pressurized(bundle, pressures).unit_forces(strain)
        return where((forces > 0) | resistance, forces, 0.0).sum(axis=-1)

    P = result.pressures / stop_gradient(supply) * supply
    value = total(bundle, P, strain)
    constant, eps = stop_gradient((bundle, strain))
    slope = jax.jvp(lambda p: total(constant, p, eps), (stop_gradient(P),), (1.0 * throttled,))[1]
    is_reached = result.status == REACHED
    moves = is_reached & (slope != 0)
    miss = where(moves, force - value, 0.0)
    step = (miss - stop_gradient(miss)) / guarded(moves, slope)
    return result._replace(
        pressures=P + where(throttled, step[..., None], 0.0),
        force=where(is_reached, force + stop_gradient(result.force - force), value),
    )

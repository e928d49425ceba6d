"""At once or compiled: how a law is evaluated for what its caller hands in.

Numbers and NumPy arrays are answered by NumPy, at once, up to `COMPILE_ABOVE` points; more
are cut into tiles of one size, for which a law is compiled once, so that a new length compiles
nothing. What is traced goes to the law as JAX compiles it, and so do JAX's own arrays where
they are many or on another device.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from .arrays import FLOATS, given
from .checks import concrete
from .derived import derived, followed
from .modules import Module, numbers
from .often import Often
from .outermost import Outermost
from .roots import still


# law points of one call. NumPy takes some 2 µs for each, a compiled law 0.05 µs and a second to
# compile, which half a million points are worth, and fewer where they come again and again
COMPILE_ABOVE = 200_000
# slopes of one call: NumPy takes some 5 µs for each, compiling a law and its slopes 3 to 10 s
SLOPES_AT_ONCE = 100_000

Function = Callable[..., Any]


def evaluate(
    law: Function,
    part: Module,
    *arrays: Any,
    points: int,
    cut: Function | None = None,
    static: tuple = (),
    at_once: bool = True,
) -> Any:
    """`law(part, *arrays, *static)`, at once or compiled.

    **Arguments:**

    - `law`: an elementwise function of the package's own [-].
    - `part`: the muscle or bundle that it is evaluated for [-].
    - `arrays`: numbers or arrays that broadcast [SI].
    - `points`: at how many points of a muscle's law, about [-].
    - `cut`: how many are cut: `fields` or `rows` of `tiles` [-]; left out, not at all.
    - `static`: what decides the result's shape [-].
    - `at_once`: whether NumPy can follow it for its derivatives [-]: not where the law
      differentiates itself.

    **Returns:** what the law gives [SI]: NumPy's where all came from NumPy, else JAX's.
    """
    many = points > COMPILE_ABOVE
    followable = SLOPES_AT_ONCE if at_once else 0
    if not part.is_numpy:
        return traced(law, part, *arrays, points=points, static=static, most=followable)
    if not given(*arrays):
        if many or not all(given(x) or _at_hand(x) for x in arrays):
            return traced(law, part, *arrays, points=points, static=static, most=followable)
        found = evaluate(law, part, *map(_numbers, arrays), points=points, static=static)
        return jax.tree.map(jnp.asarray, found)
    if many and cut is not None:
        return cut(compiled(law, static), part, *arrays)
    if points == 1 and at_once and not static and all(type(x) in FLOATS for x in arrays):
        return _numbers(_asked_often(law, part, len(arrays))(*arrays))
    with np.errstate(all="ignore"):  # of branches that aren't taken
        return _numbers(law(part, *arrays, *static))


def traced(
    law: Function,
    part: Module,
    *arrays: Any,
    points: int,
    static: tuple = (),
    most: int = SLOPES_AT_ONCE,
) -> Any:
    """What is traced: compiled, but at once where few numbers are followed for their derivatives.

    **Arguments:** as of `evaluate`; `arrays` may be trees of them; `most`: how many slopes are
    few [-].

    **Returns:** what the law gives [SI], JAX's.
    """
    whole = compiled(law, static)
    # NumPy computes in float64 alone, whose slopes JAX refuses for float32
    few = jax.config.jax_enable_x64 and max(points, 1) * followed(part, *arrays) <= most
    if not few or at_rest(part, *arrays) is None:
        return whole(part, *arrays)
    return derived(lambda *things: law(*things, *static), whole, part, *arrays)


def at_rest(*things: Any) -> tuple | None:
    """The same as NumPy's where they are traced for their derivatives alone, else `None`.

    **Arguments:** `things`: modules and arrays [SI].

    **Returns:** them without derivatives [SI].
    """
    if concrete(things) or not concrete(stopped := still(things)):
        return None
    return numbers(stopped)


@cache
def compiled(law: Function, static: tuple = ()) -> Callable:
    """`law` [-] compiled, with its `static` arguments [-] bound."""
    return Outermost(lambda part, *arrays: law(part, *arrays, *static))


def _asked_often(law: Function, part: Module, count: int) -> Often:
    """`law` [-] of a `part` [-] at single points; kept with it, as it is asked for them."""
    kept = part.store.setdefault("often", {})
    if law not in kept:
        kept[law] = Often(law, part, count)
    return kept[law]


def _at_hand(x: Any) -> bool:
    """Whether `x` [-] is an array of JAX's whose numbers lie in this processor's memory."""
    return not isinstance(x, Tracer) and all(one.platform == "cpu" for one in x.devices())


def _numbers(result: Any) -> Any:
    """The same as NumPy's arrays and scalars."""
    if isinstance(result, tuple):
        return type(result)(*map(_numbers, result))
    return np.asarray(result)[()]

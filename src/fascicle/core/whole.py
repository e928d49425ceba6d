"""Loops of small arrays that are compiled as one function.

On a CPU, XLA runs a compiled loop as a task for each of its operations, and to start one takes
longer than to add a few numbers. It knows how to compile a call as one function of machine code,
which it does by itself for the smallest loops alone, and where a call is marked. So a program is
marked here, on the versions of JAX that this was tried with and where all of its operations are
known to go: elsewhere XLA would end the process. Any other program is compiled as usual: it gives
the same numbers, slower.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.experimental.xla_metadata import set_xla_metadata


# a call of its own, and one function; the names are XLA's
_MARKS = {"inlineable": "false", "xla_cpu_small_call": "true"}
_TRIED = ((0, 10), (0, 12))  # versions of JAX

# what the elder of XLA's two ways of writing machine code knows: it has no scatter, sort, random
# numbers, nor calls into other libraries
_NAMES = """
abs acos add and argmax argmin asin atan atan2 broadcast_in_dim ceil clamp closed_call
concatenate cond convert_element_type copy copy_p cos cosh cumsum custom_jvp_call
custom_vjp_call div dot_general dynamic_slice dynamic_update_slice eq exp exp2 expand_dims expm1
floor gather ge gt integer_pow iota is_finite jit le log log1p logistic lt max min mul ne neg
not or pad pjit pow reduce_and reduce_max reduce_min reduce_or reduce_prod reduce_sum rem
reshape rev round rsqrt scan select_n sign sin sinh slice split sqrt square squeeze stack
stop_gradient sub tan tanh transpose while xor
"""
_GOES = frozenset(_NAMES.split())


def whole(function: Callable, given: tuple, fixed: tuple) -> Any:
    """What a `function` gives, compiled as one where that is known to work.

    **Arguments:**

    - `function`: a pure one [-], of all in `given` and then all in `fixed` [-].
    - `given`: trees of numbers [-].
    - `fixed`: what can be hashed, and isn't traced [-].

    **Returns:** what it returns [-].
    """
    return _called(function, given, fixed)[0]


@partial(jax.jit, static_argnums=(0, 2))
def _called(function: Callable, given: tuple, fixed: tuple) -> tuple[Any, Any]:
    """What it returns, and of each number that it is given one: of what nobody asks for, and so of
    what it doesn't ask for itself, XLA would leave out the place and look for it all the same.
    """
    leaves, kind = jax.tree.flatten(given)

    def filled(some: list) -> tuple[Any, Any]:
        rest = iter(some)
        every = [next(rest) if x.size else jnp.zeros(x.shape, x.dtype) for x in leaves]
        used = jnp.stack([jnp.ravel(x)[0].astype(float) for x in some])
        return function(*jax.tree.unflatten(kind, every), *fixed), used

    some = [x for x in leaves if x.size]
    call = jax.jit(filled)
    known = jax.make_jaxpr(call)(some)  # whose inside isn't traced again
    if not (some and _goes(known.jaxpr)):
        return call(some)
    found: Any = set_xla_metadata(call(some), **_MARKS)
    return found


def _goes(program: Any) -> bool:
    tried = jax.__version_info__[:2] in _TRIED and jax.default_backend() == "cpu"
    return tried and all(name in _GOES for name in operations(program))


def operations(program: Any) -> Iterator[str]:
    """Names of all operations [-] of a `program` [-] of JAX's, those in its loops as well."""
    for one in program.eqns:
        yield one.primitive.name
        for part in jax.tree.leaves(one.params, is_leaf=lambda x: hasattr(x, "eqns")):
            inner = getattr(part, "jaxpr", part)
            if hasattr(inner, "eqns"):
                yield from operations(inner)

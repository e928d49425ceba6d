"""Loops of small arrays that XLA compiles as one function, for one run or for many at once.

On a CPU, XLA runs a compiled loop as a task for each of its operations, and to start one takes
longer than to add a few numbers. It knows how to compile a call as one function of machine code,
which it does by itself for the smallest loops alone, and where a call is marked. So a program is
marked here, on the versions of JAX that this was tried with and where all of its operations are
known to go: elsewhere XLA would end the process. Any other program is compiled as usual: it gives
the same numbers, slower.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax
from jax.experimental.xla_metadata import set_xla_metadata
from jax.extend.core import ClosedJaxpr, jaxpr_as_fun

from .rows import in_rows


# a call of its own, and one function; the names are XLA's
_MARKS = {"inlineable": "false", "xla_cpu_small_call": "true"}
_TRIED = ((0, 10), (0, 12))  # versions of JAX
_ANYWHERE = ((0, 10),)  # those where this was tried inside of other programs, too

# what the elder of XLA's two ways of writing machine code knows: it has no scatter, sort, random
# numbers, nor calls into other libraries
_NAMES = """
abs acos add add_any and argmax argmin asin atan atan2 broadcast_in_dim ceil checkpoint clamp
closed_call concatenate cond convert_element_type copy copy_p cos cosh cumsum custom_jvp_call
custom_vjp_call div dot_general dynamic_slice dynamic_update_slice eq exp exp2 expand_dims expm1
floor gather ge gt integer_pow iota is_finite jit le log log1p logistic lt max min mul ne neg
not or pad pjit pow reduce_and reduce_max reduce_min reduce_or reduce_prod reduce_sum rem remat2
reshape rev round rsqrt scan select_n sign sin sinh slice split sqrt square squeeze stack
stop_gradient sub tan tanh transpose unstack while
xla_metadata_value xor
"""
_GOES = frozenset(_NAMES.split())
_TOGETHER = 32  # runs in a row: some registers of a processor, and all of a program in its cache
_FEW = 4  # runs, that aren't worth a row
_MOST = 5_000  # operations on rows: more take minutes to compile, as one function


def anywhere() -> bool:
    """Whether [-] programs go that are parts of others, batches and derivatives."""
    return jax.__version_info__[:2] in _ANYWHERE


def plainly(*given: Any, program: ClosedJaxpr, size: int | None, mapped: Sequence[bool]) -> Any:
    """What a `program` [-] for one run gives for all that is `given` [-], compiled as usual; for
    `size` [-] runs, on the first axis of what is `mapped` [-] and of the results, unless that is
    none.
    """
    function = jaxpr_as_fun(program)
    if size is None:
        return list(function(*given))
    if not any(mapped):
        return [jnp.broadcast_to(x, (size, *x.shape)) for x in function(*given)]
    axes = [0 if many else None for many in mapped]
    return list(jax.vmap(function, in_axes=axes)(*given))


def as_one(*given: Any, program: ClosedJaxpr, size: int | None, mapped: Sequence[bool]) -> Any:
    """The same, as one function where that is known to work: what is `given` [-] to a `program` [-]
    in `size` [-] runs, of what is `mapped` [-].
    """
    usual = partial(plainly, program=program, size=size, mapped=mapped)
    found = None
    if _goes(program.jaxpr):
        if size is None:
            found = _marked(usual, given)
        elif any(mapped):
            found = _many(given, program, size, mapped)
    return usual(*given) if found is None else found


def _many(
    given: Sequence[Any], program: ClosedJaxpr, size: int, mapped: Sequence[bool]
) -> list[Any] | None:
    """Many runs, a row of some at a time; one at a time where there are few, or that takes long to
    compile.
    """
    found = None
    if size >= _FEW:
        found = _in_turn(given, program, size, mapped, _TOGETHER)
    return _in_turn(given, program, size, mapped, 1) if found is None else found


def _in_turn(
    given: Sequence[Any], program: ClosedJaxpr, size: int, mapped: Sequence[bool], together: int
) -> list[Any] | None:
    """So many runs at a time, at most."""
    turns = -(-size // together)
    row = -(-size // turns)
    alone = together == 1

    def cut(x: Any) -> Any:
        # the last run again and again, where the last row isn't full
        x = jnp.concatenate([x, jnp.broadcast_to(x[-1:], (turns * row - size, *x.shape[1:]))])
        return jnp.moveaxis(x.reshape(turns, row, *x.shape[1:]), 1, -1)

    def function(*given: Any) -> list[Any]:
        def turn(some: list[Any]) -> list[Any]:
            rest = iter(some)
            args = [next(rest) if many else x for x, many in zip(given, mapped, strict=True)]
            if not alone:
                return in_rows(program, row, mapped, args)
            args = [x[..., 0] if many else x for x, many in zip(args, mapped, strict=True)]
            return [x[..., None] for x in jaxpr_as_fun(program)(*args)]

        return lax.map(turn, [x for x, many in zip(given, mapped, strict=True) if many])

    every = [cut(x) if many else x for x, many in zip(given, mapped, strict=True)]
    found = _marked(function, every, None if alone else _MOST)
    if found is None:
        return None
    return [jnp.moveaxis(x, -1, 1).reshape(turns * row, *x.shape[1:-1])[:size] for x in found]


def _marked(function: Callable, given: Sequence[Any], most: int | None = None) -> list[Any] | None:
    """What a function gives, as one; none where that wouldn't go, or takes more than so many
    operations.
    """
    some = [x for x in given if x.size]

    def filled(some: list[Any]) -> tuple[Any, Any]:
        rest = iter(some)
        every = [next(rest) if x.size else jnp.zeros(x.shape, x.dtype) for x in given]
        # of what nobody asks for XLA would leave out the place, and look for it all the same
        used = jnp.stack([jnp.ravel(x)[0].astype(float) for x in some])
        return function(*every), used

    call = jax.jit(filled)
    known = jax.make_jaxpr(call)(some).jaxpr  # whose inside isn't traced again
    if not (some and _goes(known)):
        return None
    if most is not None and sum(1 for _ in operations(known)) > most:
        return None
    # nor may it know what some of them are, and what isn't asked for
    found: Any = set_xla_metadata(call(lax.optimization_barrier(some)), **_MARKS)
    return lax.optimization_barrier(found)[0]


def _goes(program: Any) -> bool:
    tried = jax.__version_info__[:2] in _TRIED
    return tried and all(name in _GOES for name in operations(program))


def operations(program: Any) -> Iterator[str]:
    """Names of all operations [-] of a `program` [-] of JAX's, those in its loops as well."""
    for one in program.eqns:
        yield one.primitive.name
        if one.params.get("prevent_cse"):  # of a part that derivatives go through again
            yield "optimization_barrier"
        for part in jax.tree.leaves(one.params, is_leaf=lambda x: hasattr(x, "eqns")):
            inner = getattr(part, "jaxpr", part)
            if hasattr(inner, "eqns"):
                yield from operations(inner)

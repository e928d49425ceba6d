"""A program that stays whole until it is compiled.

What it is then compiled as, see `compiled`, depends on how many runs there are, on whether somebody
differentiates it, and on which of its results are asked for: in JAX that is known last of all. So
it is an operation of its own, `whole`, with a program for one run, that is written out late. A
batch of it is the same program with a number of runs. Its derivative is two programs, one for the
results and all that their slopes need, one that is linear in what moves; and backwards that one,
transposed. What nobody asks for is left out of each.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.core import Tracer
from jax.extend.core import ClosedJaxpr, Literal, Primitive
from jax.interpreters import ad, batching, mlir
from jax.interpreters import partial_eval as pe

from .checks import concrete
from .compiled import anywhere, as_one, plainly


def whole(function: Callable, given: tuple, fixed: tuple) -> Any:
    """What a `function` gives, compiled as one where that is known to work.

    **Arguments:**

    - `function`: a pure one [-], of all in `given` and then all in `fixed` [-].
    - `given`: trees of numbers [-].
    - `fixed`: what can be hashed, and isn't traced [-].

    **Returns:** what it returns [-].
    """
    kept = anywhere() or concrete(given)
    return (_called if kept else _usual)(function, given, fixed)


@partial(jax.jit, static_argnums=(0, 2))
def _usual(function: Callable, given: tuple, fixed: tuple) -> Any:
    return function(*given, *fixed)


@partial(jax.jit, static_argnums=(0, 2))
def _called(function: Callable, given: tuple, fixed: tuple) -> Any:
    leaves, kind = jax.tree.flatten(given)

    def of(*leaves: Any) -> Any:
        return function(*jax.tree.unflatten(kind, leaves), *fixed)

    shapes: list[Any] = []

    def flat(*leaves: Any) -> list[Any]:
        found, shape = jax.tree.flatten(of(*leaves))
        shapes.append(shape)
        return found

    found, _ = _bound(flat, leaves, None, [False] * len(leaves))
    return jax.tree.unflatten(shapes[0], found)


def _bound(
    function: Callable, given: Sequence[Any], size: int | None, mapped: Sequence[bool]
) -> tuple[list[Any], list[bool]]:
    """A function of one run as an operation: its results, and which of them are another in each."""
    one = [
        jax.ShapeDtypeStruct(x.shape[1:] if many else x.shape, x.dtype)
        for x, many in zip(given, mapped, strict=True)
    ]
    made = jax.make_jaxpr(function)(*one)
    outside, knowing = _opened(made)
    if outside:
        made = jax.make_jaxpr(knowing)(*outside, *one)
    inner, args = made.jaxpr, [*outside, *given]
    mapped = [*([False] * len(outside)), *mapped]
    # what is only handed on isn't copied for each run
    handed = dict(zip(inner.invars, zip(args, mapped, strict=True), strict=True))
    own = [isinstance(x, Literal) or x not in handed for x in inner.outvars]
    short, needed = pe.dce_jaxpr(inner, own)
    found = iter(
        _whole.bind(
            *_those(args, needed), program=ClosedJaxpr(short, made.consts), size=size,
            mapped=tuple(_those(mapped, needed)),
        )
    )  # fmt: skip
    pairs = [
        (next(found), size is not None) if here else handed[x]
        for x, here in zip(inner.outvars, own, strict=True)
    ]
    return [x for x, _ in pairs], [many for _, many in pairs]


def _opened(made: ClosedJaxpr) -> tuple[list[Any], Callable[..., list[Any]]]:
    """What of a program is traced outside of it, and it as a function of that and then the rest."""
    which = [isinstance(x, Tracer) for x in made.consts]
    others, count = _those(made.consts, [not here for here in which]), sum(which)

    def function(*every: Any) -> list[Any]:
        known = _among(which, every[:count], others)
        return _run(ClosedJaxpr(made.jaxpr, known), every[count:])

    return _those(made.consts, which), function


def _those(values: Sequence[Any], which: Sequence[bool]) -> list[Any]:
    return [x for x, here in zip(values, which, strict=True) if here]


def _among(which: Sequence[bool], these: Sequence[Any], others: Sequence[Any]) -> list[Any]:
    """Both in a row: `these` where it says so."""
    first, second = iter(these), iter(others)
    return [next(first if here else second) for here in which]


_whole = Primitive("whole")
_whole.multiple_results = True
_whole.def_impl(lambda *given, **how: jax.jit(partial(_whole.bind, **how))(*given))


@_whole.def_abstract_eval
def _shaped(*given: Any, program: ClosedJaxpr, size: int | None, mapped: tuple) -> list[Any]:
    del given, mapped
    more = () if size is None else (size,)
    return [x.update(shape=(*more, *x.shape)) for x in program.out_avals]


def _batched(
    given: Any, axes: Any, *, program: ClosedJaxpr, size: int | None, mapped: tuple
) -> Any:
    """Runs on the first axis; runs of runs are so many more runs."""
    new = [axis is not None for axis in axes]
    args = [
        jnp.moveaxis(x, axis, 0) if here else x
        for x, axis, here in zip(given, axes, new, strict=True)
    ]
    many = _those(args, new)[0].shape[0]
    if size is None:
        found = _whole.bind(*args, program=program, size=many, mapped=tuple(new))
        return found, [0] * len(found)

    def flat(x: Any, here: bool, before: bool) -> Any:
        if not (here or before):
            return x
        x = x if before and here else x[:, None] if here else x[None]
        return jnp.broadcast_to(x, (many, size, *x.shape[2:])).reshape(-1, *x.shape[2:])

    each = [flat(*one) for one in zip(args, new, mapped, strict=True)]
    either = tuple(x or y for x, y in zip(new, mapped, strict=True))
    found = _whole.bind(*each, program=program, size=many * size, mapped=either)
    return [x.reshape(many, size, *x.shape[1:]) for x in found], [0] * len(found)


def _slopes(
    given: Any, slopes: Any, *, program: ClosedJaxpr, size: int | None, mapped: tuple
) -> tuple[list[Any], list[Any]]:
    """What it gives with all that its slopes need; and the slopes, linear in those given."""
    moving = [not isinstance(x, ad.Zero) for x in slopes]
    moved = [jnp.issubdtype(x.dtype, jnp.inexact) for x in program.out_avals]
    linear: list[Callable] = []

    def ahead(*one: Any) -> list[Any]:
        still, some = _those(one, [not here for here in moving]), _those(one, moving)

        def of(*some: Any) -> list[Any]:
            return _those(_run(program, _among(moving, some, still)), moved)

        found, along = jax.linearize(of, *some)
        needed, function = _opened(jax.make_jaxpr(along)(*some))
        linear.append(function)
        counted = [] if all(moved) else _those(_run(program, one), [not x for x in moved])
        return [*_among(moved, found, counted), *needed]

    found, many = _bound(ahead, given, size, mapped)
    out, needed = found[: len(moved)], found[len(moved) :]
    out_slopes, each = _bound(
        linear[0], [*needed, *_those(slopes, moving)], size,
        [*many[len(moved) :], *_those(mapped, moving)],
    )  # fmt: skip
    # a slope that is handed on may be the same for all runs
    out_slopes = [
        x if size is None or here else jnp.broadcast_to(x, (size, *x.shape))
        for x, here in zip(out_slopes, each, strict=True)
    ]
    none = [ad.Zero(jax.typeof(x).to_tangent_aval()) for x in _those(out, [not x for x in moved])]
    return out, _among(moved, out_slopes, none)


def _turned(
    back: Any, *given: Any, program: ClosedJaxpr, size: int | None, mapped: tuple
) -> list[Any]:
    """A program that is linear in what isn't known, backwards."""
    linear = [ad.is_undefined_primal(x) for x in given]
    known = [not here for here in linear]
    asked = [not isinstance(x, ad.Zero) for x in back]
    kinds = [jax.ShapeDtypeStruct(x.shape, x.dtype) for x in _those(program.in_avals, linear)]
    count = sum(known)

    def turned(*one: Any) -> list[Any]:
        def of(*some: Any) -> list[Any]:
            return _those(_run(program, _among(linear, some, one[:count])), asked)

        return list(jax.linear_transpose(of, *kinds)(list(one[count:])))

    every = [*_those(given, known), *_those(back, asked)]
    which = [*_those(mapped, known), *([size is not None] * sum(asked))]
    found, many = _bound(turned, every, size, which)
    # what all runs have in common gets a share from each
    shares = [
        x.sum(axis=0) if here and not before else x
        for x, here, before in zip(found, many, _those(mapped, linear), strict=True)
    ]
    return _among(linear, shares, [None] * count)


def _run(program: ClosedJaxpr, given: Sequence[Any]) -> list[Any]:
    return plainly(*given, program=program, size=None, mapped=())


def _asked(used: Any, *more: Any) -> Any:
    """Only what somebody asks for."""
    one = more[-1]  # newer versions tell of what it is given, too
    if not any(used):
        return [False] * len(one.invars), None
    how = one.params
    inner, needed = pe.dce_jaxpr(how["program"].jaxpr, list(used))
    mapped = tuple(_those(how["mapped"], needed))
    program = ClosedJaxpr(inner, how["program"].consts)
    return needed, one.replace(
        invars=_those(one.invars, needed),
        outvars=_those(one.outvars, used),
        params={**how, "program": program, "mapped": mapped},
    )


batching.primitive_batchers[_whole] = _batched
ad.primitive_jvps[_whole] = _slopes
ad.primitive_transposes[_whole] = _turned
pe.dce_rules[_whole] = _asked
mlir.register_lowering(_whole, mlir.lower_fun(plainly, multiple_results=True))
mlir.register_lowering(_whole, mlir.lower_fun(as_one, multiple_results=True), platform="cpu")

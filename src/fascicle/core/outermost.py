"""Functions compiled as programs of their own, which may ask more of XLA than parts of others.

Where a processor's registers hold 512 bits XLA computes in half of each. In whole ones a law takes
a tenth to a fifth less time, and gives the same numbers. JAX takes such a wish for a whole program
alone, so it is made where nothing is traced. It says nothing to other processors, and isn't made
where XLA doesn't know it.
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import jax

from .checks import concrete


_WISHES = {"xla_cpu_prefer_vector_width": "512"}  # the name is XLA's


class Outermost:
    """A function [-], compiled; it is called, and has `lower`, as what `jax.jit` gives."""

    def __init__(self, function: Callable, *constants: Any):
        """**Arguments:** `function`: of trees of arrays [-]; `constants`: its first ones [SI]."""
        bound = partial(function, *constants)
        self._part = jax.jit(bound)
        self._whole = jax.jit(bound, compiler_options=_WISHES) if concrete(constants) else None
        self.lower = self._part.lower

    def __call__(self, *arrays: Any, **named: Any) -> Any:
        """What it gives for `arrays` and those that are `named` [SI]."""
        whole = self._whole
        if whole is None or not concrete(arrays, named) or not _granted(jax.default_backend()):
            return self._part(*arrays, **named)
        # a part of a program that depends on none of its arguments is one of its own, too
        with jax.ensure_compile_time_eval():
            return whole(*arrays, **named)


@cache
def _granted(backend: str) -> bool:
    """Whether XLA knows the wishes on this `backend` [-]."""
    if backend != "cpu":
        return False
    try:
        jax.jit(abs, compiler_options=_WISHES).lower(0.0).compile()
    except jax.errors.JaxRuntimeError:
        return False
    return True

"""Modules whose methods are plain ones.

Equinox binds a module's methods as modules, so that they can be passed as arrays are. That
takes 50 µs a call, more than a law does, and `jax.jit` can't hash what it binds, as it hashes
by the arrays. Bound as Python binds them, methods cost nothing and compile as they are:
`jax.jit(muscle.force)`.
"""

from functools import cached_property

import equinox as eqx
import jax

from ._arrays import given


class Module(eqx.Module):
    """An `equinox` module with plain methods."""

    __getattribute__ = object.__getattribute__

    @cached_property
    def is_numpy(self) -> bool:
        """Whether it holds NumPy's numbers and arrays alone [-]."""
        return given(*jax.tree.leaves(self))

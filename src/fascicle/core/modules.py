"""Modules whose methods are plain ones, and what they keep.

Equinox binds a module's methods as modules, so that they can be passed as arrays are. That
takes 50 µs a call, more than a law does, and `jax.jit` can't hash what it binds, as it hashes
by the arrays. Bound as Python binds them, methods cost nothing and compile as they are:
`jax.jit(muscle.force)`.

What a module works out about itself is kept beside its attributes: among them, it would be part
of its structure, by which modules are compared and compiled functions are found again.
"""

from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields
from inspect import signature
from typing import Any, Generic, TypeVar, overload

import equinox as eqx
import jax
import numpy as np

from .arrays import given
from .checks import concrete, one_of


Value = TypeVar("Value")
_FEW = 8  # numbers that a line shows


class kept(property, Generic[Value]):  # noqa: N801 as `property` is written
    """A property of a module that is worked out once."""

    def __init__(self, function: Callable[[Any], Value]):
        """**Arguments:** `function`: of the module [-]."""
        super().__init__(function)

    @overload
    def __get__(self, module: None, kind: type | None = None) -> "kept[Value]": ...

    @overload
    def __get__(self, module: "Module", kind: type | None = None) -> Value: ...

    def __get__(self, module: "Module | None", kind: type | None = None) -> "Value | kept[Value]":
        """The property of a `module` of that `kind` [-]."""
        if module is None:
            return self
        store = module.store
        if self not in store:
            store[self] = super().__get__(module, kind)
        return store[self]


class Module(eqx.Module):
    """An `equinox` module with plain methods."""

    __slots__ = ("_store",)
    __getattribute__ = object.__getattribute__

    @property
    def store(self) -> dict:
        """What it has worked out about itself [-]; no part of it, and not copied with it."""
        try:
            return self._store
        except AttributeError:
            object.__setattr__(self, "_store", {})
            return self._store

    def __getstate__(self) -> dict:
        """What is copied and pickled: its attributes."""
        return dict(self.__dict__)

    def __eq__(self, other: object) -> bool:
        """Whether it has the same structure and the same numbers, NumPy's or JAX's. Traced ones
        can't be looked at: they are equal to themselves alone.
        """
        if self is other:
            return True
        (ours, structure), (theirs, of_other) = jax.tree.flatten(self), jax.tree.flatten(other)
        return structure == of_other and all(map(_same, ours, theirs))

    def __hash__(self) -> int:
        """The same for what is equal."""
        leaves, structure = jax.tree.flatten(self)
        return hash((structure, *(_told(leaf) for leaf in leaves)))

    def __repr__(self) -> str:
        """Its fields with their numbers; traced ones have none."""
        return listed(self) if concrete(self) else super().__repr__()

    def __setattr__(self, name: str, value: Any) -> None:
        """Fields are set once, as it is made."""
        try:
            super().__setattr__(name, value)
        except FrozenInstanceError:
            kind = type(self).__name__
            remedy = "make another one"
            if hasattr(self, "replace") and name in signature(type(self)).parameters:
                remedy = f"write {kind.lower()} = {kind.lower()}.replace({name}=…)"
            raise FrozenInstanceError(
                f"`{name}` can't be set, a {kind} stays as it was made: {remedy}."
            ) from None

    @kept
    def is_numpy(self) -> bool:
        """Whether it holds NumPy's numbers and arrays alone [-]."""
        return given(*jax.tree.leaves(self))


def listed(module: Module) -> str:
    """The fields of a `module` [-] with their numbers, in one line [-]."""
    shown = (f"{field.name}={_shown(getattr(module, field.name))}" for field in fields(module))
    return f"{type(module).__name__}({', '.join(shown)})"


def _shown(value: Any) -> str:
    if not (given(value) or isinstance(value, jax.Array)):
        return repr(value)
    x = np.asarray(value)
    if x.size > _FEW:
        return f"<{' × '.join(map(str, x.shape))} numbers>"
    return repr(x.tolist())


def _same(one: Any, other: Any) -> bool:
    return one is other or (concrete(one, other) and np.array_equal(one, other))


def _told(leaf: Any) -> Any:
    """What is equal, and can be looked up, where numbers are."""
    return tuple(np.ravel(leaf).tolist()) if concrete(leaf) else id(leaf)


Tree = TypeVar("Tree")
Kind = TypeVar("Kind", bound=Module)


def numbers(tree: Tree) -> Tree:
    """The same `tree` of modules and arrays [-] with NumPy's numbers and arrays alone."""
    return jax.tree.map(lambda leaf: np.asarray(leaf)[()], tree)


def renewed(thing: Kind, changes: dict[str, Any], **held: Any) -> Kind:
    """The same with other arguments, checked as those of a new one are.

    **Arguments:**

    - `thing`: that has an attribute for each of its arguments [-].
    - `changes`: other values of arguments, by name [SI].
    - `held`: what it has of arguments that no attribute is named for [SI].

    **Returns:** a new object [-].

    **Raises:** `ValueError` for an unknown name and for what a new one refuses.
    """
    names = list(signature(type(thing)).parameters)
    for name in changes:
        one_of(name, names, "argument")
    kept = (name for name in names if name not in held)
    return type(thing)(**{name: getattr(thing, name) for name in kept} | held | changes)

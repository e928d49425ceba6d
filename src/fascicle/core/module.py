"""Modules: frozen dataclasses of numbers, arrays and other modules, which JAX treats as pytrees.

A `Module` is a dataclass whose fields are set once. Each class registers itself with JAX when JAX
is imported, before fascicle or after. Without JAX it is a dataclass and no more. Values that a
module caches (`functools.cached_property`) are no part of its structure.

`tree_leaves`, `tree_map` and their like do what JAX's functions of these names do, without JAX.
`evaluate` runs a law with NumPy or with JAX: the types of its arguments alone decide.
"""

from abc import ABC
from collections.abc import Callable, Iterable
from dataclasses import MISSING, FrozenInstanceError, dataclass, field, fields
from functools import cached_property
from inspect import signature
from types import ModuleType
from typing import Any, ClassVar, TypeVar, dataclass_transform

import numpy as np

from .array_namespace import (
    NUMPY_TYPES,
    array_namespace,
    imported_jax,
    is_jax_array,
    is_numpy,
    jax_backend,
)
from .lazy import call_on_import
from .validation import check_choice, is_concrete


def tree_leaves(tree: Any) -> list[Any]:
    """Numbers, arrays and other leaves of a `tree` [any unit], in JAX's order."""
    leaves: list[Any] = []
    _collect_leaves(tree, leaves)
    return leaves


def tree_map(function: Callable[..., Any], tree: Any, *others: Any) -> Any:
    """Apply a `function` to each leaf of a tree.

    **Arguments:**

    - `function`: of a leaf of each tree.
    - `tree`: modules, tuples, lists, dictionaries and leaves [any unit].
    - `others`: trees of the same structure [any unit].

    **Returns:** a tree of that structure [any unit].
    """
    if tree is None:
        return None
    if isinstance(tree, dict):
        return {
            key: tree_map(function, value, *(other[key] for other in others))
            for key, value in sorted(tree.items())
        }
    if isinstance(tree, tuple | list):
        parts = [tree_map(function, *entries) for entries in zip(tree, *others, strict=True)]
        return type(tree)(*parts) if hasattr(tree, "_fields") else type(tree)(parts)
    if not is_module(tree):
        return function(tree, *others)
    kind = type(tree)
    parts = {
        name: tree_map(function, getattr(tree, name), *(getattr(x, name) for x in others))
        for name in kind.leaf_names
    }
    return rebuild(kind, parts | {name: getattr(tree, name) for name in kind.static_names})


def tree_replace(tree: Any, leaves: Iterable[Any]) -> Any:
    """Replace the leaves of a `tree` by other `leaves`, in order [any unit]."""
    rest = iter(leaves)
    return tree_map(lambda _: next(rest), tree)


def tree_structure(tree: Any) -> Any:
    """Structure of a tree, hashable: types and static fields."""
    if isinstance(tree, dict):
        return dict, tuple((key, tree_structure(value)) for key, value in sorted(tree.items()))
    if isinstance(tree, tuple | list):
        return type(tree), tuple(map(tree_structure, tree))
    if not is_module(tree):
        return tree is None
    kind = type(tree)
    parts = (tree_structure(getattr(tree, name)) for name in kind.leaf_names)
    return kind, tuple(getattr(tree, name) for name in kind.static_names), tuple(parts)


def is_module(value: Any) -> bool:
    """True for a module of fascicle's."""
    return getattr(type(value), "is_fascicle_module", False)


def rebuild(kind: Any, values: dict[str, Any]) -> Any:
    """A module of a `kind` with `values` [any unit] that are not checked again."""
    module = object.__new__(kind)
    module.__dict__.update(values)
    return module


def _collect_leaves(tree: Any, leaves: list[Any]) -> None:
    if tree is None:
        return
    if isinstance(tree, dict):
        tree = dict(sorted(tree.items())).values()
    elif getattr(type(tree), "is_fascicle_module", False):  # a call fewer than `is_module`
        tree = map(vars(tree).__getitem__, type(tree).leaf_names)
    elif not isinstance(tree, tuple | list):
        leaves.append(tree)
        return
    for child in tree:
        if type(child) in NUMPY_TYPES:
            leaves.append(child)
        else:
            _collect_leaves(child, leaves)


_FEW = 8  # numbers that a line shows
_CLASSES: list[type[Any]] = []


def static(*, default: Any = MISSING, converter: Callable | None = None, **metadata: Any) -> Any:
    """A field that is part of a module's structure, such as the name of a law."""
    return record(default=default, converter=converter, static=True, **metadata)


def record(*, default: Any = MISSING, converter: Callable | None = None, **metadata: Any) -> Any:
    """A field of a module.

    **Arguments:**

    - `default`: its value where it is left out [any unit].
    - `converter`: function that checks a value as it is set, and returns it as numbers.
    - `metadata`: other properties of the field.

    **Returns:** the field.
    """
    if converter is not None:
        metadata["converter"] = converter
    return field(default=default, metadata=metadata)


class cached_number(cached_property):  # noqa: N801 as `cached_property`
    """A cached property of NumPy's numbers.

    Arrays of JAX are computed again: a tracer must not outlive its trace.
    """

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        if instance is None:
            return self
        value = self.func(instance)
        if type(value) in NUMPY_TYPES:
            vars(instance)[self.attrname] = value
        return value


@dataclass_transform(eq_default=False, field_specifiers=(static, record, field))
class Module(ABC):
    """A frozen record of numbers, arrays and other modules."""

    __dataclass_fields__: ClassVar[dict[str, Any]]
    is_fascicle_module: ClassVar[bool] = True
    leaf_names: ClassVar[tuple[str, ...]]
    static_names: ClassVar[tuple[str, ...]]
    _converters: ClassVar[dict[str, Callable]] = {}

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        inherited = next(k for k in cls.__mro__ if "__init__" in vars(k))
        written = inherited is not object and not vars(inherited).get("_generated_init", False)
        dataclass(eq=False, repr=False, init=not written)(cls)
        cls._generated_init = not written
        # a class variable that a subclass makes a field must not keep its place among the fields
        names = {field.name for field in fields(cls)}
        for name in set(cls.__dataclass_fields__) - names:
            del cls.__dataclass_fields__[name]
        metadata = {field.name: field.metadata for field in fields(cls)}
        cls.leaf_names = tuple(n for n, data in metadata.items() if not data.get("static"))
        cls.static_names = tuple(n for n, data in metadata.items() if data.get("static"))
        cls._converters = {
            name: data["converter"] for name, data in metadata.items() if data.get("converter")
        }
        _CLASSES.append(cls)
        if (jax := imported_jax()) is not None:
            _register(cls, jax)

    def __post_init__(self) -> None:
        # a check of all fields together is inherited
        for kind in reversed(type(self).__mro__):
            if "__check_init__" in vars(kind):
                vars(kind)["__check_init__"](self)

    def __setattr__(self, name: str, value: Any) -> None:
        """Fields are set once, as it is made."""
        if name in self.__dict__ or name not in type(self).__dataclass_fields__:
            kind = type(self).__name__
            remedy = "make another one"
            if hasattr(self, "replace") and name in signature(type(self)).parameters:
                remedy = f"write {kind.lower()} = {kind.lower()}.replace({name}=…)"
            raise FrozenInstanceError(
                f"`{name}` can't be set, a {kind} stays as it was made: {remedy}."
            )
        converter = self._converters.get(name)
        vars(self)[name] = value if converter is None else converter(value)

    def __delattr__(self, name: str) -> None:
        raise FrozenInstanceError(f"`{name}` can't be deleted.")

    @property
    def cache(self) -> dict:
        """Results by key that are computed once; no part of the module, and not copied with it."""
        return vars(self).setdefault("_cache", {})

    def __getstate__(self) -> dict:
        """Fields, which are copied and pickled; caches aren't."""
        return {field.name: self.__dict__[field.name] for field in fields(self)}

    def __setstate__(self, state: dict) -> None:
        vars(self).update(state)

    def __eq__(self, other: object) -> bool:
        """True for the same structure and numbers, NumPy's or JAX's. A traced module equals itself
        alone.
        """
        return self is other or _equal(self, other)

    def __hash__(self) -> int:
        """Equal for equal modules."""
        return hash((tree_structure(self), *map(_key, tree_leaves(self))))

    def __repr__(self) -> str:
        """Fields with their numbers; traced ones have none."""
        return repr_fields(self)

    @cached_property
    def is_numpy(self) -> bool:
        """True where all numbers and arrays are NumPy's."""
        return is_numpy(*tree_leaves(self))


def repr_fields(module: Module) -> str:
    """Fields of a `module` with their numbers, in one line."""
    shown = (f"{field.name}={_shown(getattr(module, field.name))}" for field in fields(module))
    return f"{type(module).__name__}({', '.join(shown)})"


def _register_all(jax: ModuleType) -> None:
    for kind in _CLASSES:
        _register(kind, jax)


call_on_import("jax", _register_all)


def _register(kind: type[Module], jax: Any) -> None:
    dynamic, structure = kind.leaf_names, kind.static_names
    keys = [jax.tree_util.GetAttrKey(name) for name in dynamic]

    def flatten(module: Any) -> tuple[tuple, tuple]:
        values = module.__dict__
        return tuple(values.get(n) for n in dynamic), tuple(values.get(n) for n in structure)

    def flatten_with_keys(module: Any) -> tuple[tuple, tuple]:
        leaves, aux = flatten(module)
        return tuple(zip(keys, leaves, strict=True)), aux

    def unflatten(aux: tuple, leaves: Any) -> Any:
        # leaves may be tracers, so nothing is checked again
        return rebuild(
            kind, dict(zip(dynamic, leaves, strict=True)) | dict(zip(structure, aux, strict=True))
        )

    jax.tree_util.register_pytree_with_keys(kind, flatten_with_keys, unflatten, flatten)


def _shown(value: Any) -> str:
    if is_jax_array(value) and not is_concrete(value):
        return f"{value.dtype}{list(value.shape)}"  # traced: it has no numbers yet
    if not (is_numpy(value) or is_jax_array(value)):
        return repr(value)
    x = np.asarray(value)
    if x.size > _FEW:
        return f"<{' × '.join(map(str, x.shape))} numbers>"
    return repr(x.tolist())


def _equal(module: Any, other: Any) -> bool:
    return tree_structure(module) == tree_structure(other) and all(
        map(_equal_leaves, tree_leaves(module), tree_leaves(other))
    )


def _equal_leaves(leaf: Any, other: Any) -> bool:
    return leaf is other or (is_concrete(leaf, other) and np.array_equal(leaf, other))


def _key(leaf: Any) -> Any:
    """Hashable key of a leaf: its numbers, or its identity where it is traced."""
    return tuple(np.ravel(leaf).tolist()) if is_concrete(leaf) else id(leaf)


Tree = TypeVar("Tree")
Kind = TypeVar("Kind", bound=Module)


def to_numpy(tree: Tree) -> Tree:
    """Convert a `tree` of modules and arrays [any unit] to NumPy's numbers and arrays."""
    return tree_map(lambda leaf: np.asarray(leaf)[()], tree)


def with_fields(module: Kind, **values: Any) -> Kind:
    """Replace `values` of some fields of a `module` [SI], without checks."""
    current = {field.name: getattr(module, field.name) for field in fields(module)}
    return rebuild(type(module), current | values)


def replace_checked(thing: Kind, changes: dict[str, Any], **held: Any) -> Kind:
    """Replace arguments of an object, checked as those of a new one are.

    **Arguments:**

    - `thing`: an object with an attribute for each of its arguments.
    - `changes`: other values of arguments, by name [SI].
    - `held`: values of arguments that no attribute is named for [SI].

    **Returns:** a new object.

    **Raises:** `ValueError` for an unknown name and for invalid values.
    """
    names = list(signature(type(thing)).parameters)
    for name in changes:
        check_choice(name, names, "argument")
    current = {name: getattr(thing, name) for name in names if name not in held}
    return type(thing)(**current | held | changes)


def evaluate(law: Callable[..., Any], part: Module, *arrays: Any, static: tuple = ()) -> Any:
    """Evaluate `law(part, *arrays, *static)` by NumPy, or compiled by JAX.

    **Arguments:**

    - `law`: a pure function of a module.
    - `part`: the muscle or bundle that it is evaluated for.
    - `arrays`: numbers or arrays that broadcast [SI].
    - `static`: hashable arguments that decide the result's shape.

    **Returns:** the law's result [SI]: NumPy's where all arguments are NumPy's, else JAX's.
    """
    if not (part.is_numpy and is_numpy(*arrays)):
        return jax_backend().compile_law(law, static)(part, *arrays)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        return _numpy(law(part, *arrays, *static))


def primal_numpy(*things: Any) -> tuple | None:
    """Values as NumPy's where they are traced for their derivatives alone, else `None`.

    **Arguments:** `things`: modules and arrays [SI].

    **Returns:** their values without derivatives [SI].
    """
    if is_concrete(things) or not is_concrete(stopped := stop_gradient(things)):
        return None
    return to_numpy(stopped)


def _numpy(result: Any) -> Any:
    """Convert a `result` to NumPy's arrays and scalars."""
    if isinstance(result, tuple):
        return type(result)(*map(_numpy, result))
    return np.asarray(result)[()]


def stop_gradient(values: Any) -> Any:
    """A tree of arrays without derivatives."""
    if type(values) in NUMPY_TYPES or is_numpy(*tree_leaves(values)):
        return values
    return tree_map(_stop_leaf, values)


def _stop_leaf(x: Any) -> Any:
    xp = array_namespace(x)
    if xp is np:
        return x
    return (jax_backend() if is_jax_array(x) else xp).stop_gradient(x)

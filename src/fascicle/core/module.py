"""Modules: frozen dataclasses of numbers, arrays and other modules, which JAX treats as pytrees.

A `Module` is a dataclass whose fields are set once. Each class registers itself with JAX when JAX
is imported, before fascicle or after. Without JAX it is a dataclass and no more. Values that a
module caches (`functools.cached_property`) are no part of its structure.

`tree_leaves`, `tree_map` and their like do what JAX's functions of these names do, without JAX.
`evaluate` runs a law with NumPy or with JAX: the types of its arguments alone decide.
"""

from abc import ABC
from collections.abc import Callable, Iterable, Sequence
from dataclasses import MISSING, FrozenInstanceError, dataclass, field, fields
from functools import cached_property
from inspect import signature
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


def _children(tree: Any) -> list[Any] | None:
    """Children of a node of a `tree`, in JAX's order; `None` for a leaf."""
    if hasattr(tree, "leaf_names"):
        return list(map(vars(tree).__getitem__, tree.leaf_names))
    if isinstance(tree, dict):
        return [tree[key] for key in sorted(tree)]
    if isinstance(tree, tuple | list):
        return list(tree)
    return [] if tree is None else None


def tree_leaves(tree: Any) -> list[Any]:
    """Numbers, arrays and other leaves of a `tree` [any unit], in JAX's order."""
    leaves, nodes = [], [tree]
    while nodes:
        node = nodes.pop()
        if type(node) in NUMPY_TYPES or (children := _children(node)) is None:
            leaves.append(node)
        else:
            nodes += reversed(children)
    return leaves


def tree_map(function: Callable[..., Any], tree: Any, *trees: Any) -> Any:
    """Tree of a `function` of the leaves of a `tree`, and of other `trees` of its structure."""
    if (children := _children(tree)) is None:
        return function(tree, *trees)
    nodes = zip(children, *map(_children, trees), strict=True)
    results = [tree_map(function, *node) for node in nodes]
    if hasattr(tree, "leaf_names"):
        fields = {name: vars(tree)[name] for name in tree.static_names}
        return _rebuild(type(tree), fields | dict(zip(tree.leaf_names, results, strict=True)))
    if isinstance(tree, dict):
        return dict(zip(sorted(tree), results, strict=True))
    if tree is None:
        return None
    return type(tree)(*results) if hasattr(tree, "_fields") else type(tree)(results)


def tree_replace(tree: Any, leaves: Iterable[Any]) -> Any:
    """Copy of a `tree` with other `leaves`, in order [any unit]."""
    leaf = iter(leaves)
    return tree_map(lambda _: next(leaf), tree)


def tree_structure(tree: Any) -> Any:
    """Structure of a `tree`, hashable: types, keys and static fields."""
    if tree is None or (children := _children(tree)) is None:
        return tree is None
    if isinstance(tree, dict):
        return dict, tuple(sorted(tree)), tuple(map(tree_structure, children))
    fixed = tuple(vars(tree)[name] for name in getattr(tree, "static_names", ()))
    return type(tree), fixed, tuple(map(tree_structure, children))


def _rebuild(kind: Any, values: dict[str, Any]) -> Any:
    """A module of a `kind` with `values` that are not checked again."""
    module = object.__new__(kind)
    module.__dict__.update(values)
    return module


_MAX_SHOWN = 8  # numbers of an array for which a line has room
_CLASSES: list[type[Any]] = []  # all modules, to be registered with JAX when it is imported


def static(*, default: Any = MISSING, converter: Callable | None = None, **metadata: Any) -> Any:
    """A field that is part of a module's structure, such as the name of a law."""
    return record(default=default, converter=converter, static=True, **metadata)


def record(*, default: Any = MISSING, converter: Callable | None = None, **metadata: Any) -> Any:
    """A field of a module: its `default` [any unit], a `converter` that validates a value as it is
    set and returns it as numbers [any unit], and other `metadata`.
    """
    if converter is not None:
        metadata["converter"] = converter
    return field(default=default, metadata=metadata)


class cached_number(cached_property):  # noqa: N801 as `cached_property`
    """A property, cached if its value is NumPy's: a tracer must not outlive its trace."""

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
    leaf_names: ClassVar[tuple[str, ...]]
    static_names: ClassVar[tuple[str, ...]]
    _converters: ClassVar[dict[str, Callable]] = {}

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        owner = next(kind for kind in cls.__mro__ if "__init__" in vars(kind))
        cls._has_generated_init = owner is object or vars(owner).get("_has_generated_init", False)
        dataclass(eq=False, repr=False, init=cls._has_generated_init)(cls)
        # a class variable that a subclass makes a field must not keep its place among the fields
        metadata = {x.name: x.metadata for x in fields(cls)}
        for name in set(cls.__dataclass_fields__) - set(metadata):
            del cls.__dataclass_fields__[name]
        cls.leaf_names = tuple(name for name, data in metadata.items() if not data.get("static"))
        cls.static_names = tuple(name for name, data in metadata.items() if data.get("static"))
        cls._converters = {
            name: data["converter"] for name, data in metadata.items() if "converter" in data
        }
        _CLASSES.append(cls)
        if (jax := imported_jax()) is not None:
            _register_pytree(cls, jax)

    def __post_init__(self) -> None:
        # a check of all fields together is inherited
        for kind in reversed(type(self).__mro__):
            if "__check_init__" in vars(kind):
                vars(kind)["__check_init__"](self)

    def __setattr__(self, name: str, value: Any) -> None:
        """Fields are set once, by the constructor."""
        if name in self.__dict__ or name not in type(self).__dataclass_fields__:
            kind = type(self).__name__
            remedy = "construct another one"
            if hasattr(self, "replace") and name in signature(type(self)).parameters:
                remedy = f"write {kind.lower()} = {kind.lower()}.replace({name}=…)"
            raise FrozenInstanceError(f"`{name}` can't be set, a {kind} is immutable: {remedy}.")
        converter = self._converters.get(name)
        vars(self)[name] = value if converter is None else converter(value)

    def __delattr__(self, name: str) -> None:
        raise FrozenInstanceError(f"`{name}` can't be deleted.")

    @property
    def cache(self) -> dict:
        """Cached results by key; no part of the module, and not copied with it."""
        return vars(self).setdefault("_cache", {})

    def __getstate__(self) -> dict:
        """Fields, which are copied and pickled; caches aren't."""
        return {name: vars(self)[name] for name in _field_names(self)}

    def __eq__(self, other_module: object) -> bool:
        """True for equal structures and numbers; a traced module equals only itself."""
        if self is other_module:
            return True
        return tree_structure(self) == tree_structure(other_module) and all(
            leaf is twin or (is_concrete(leaf, twin) and np.array_equal(leaf, twin))
            for leaf, twin in zip(tree_leaves(self), tree_leaves(other_module), strict=True)
        )

    def __hash__(self) -> int:
        """Hash of the numbers, or of the identity of traced ones: equal for equal modules."""
        leaves = (
            tuple(np.ravel(leaf).tolist()) if is_concrete(leaf) else id(leaf)
            for leaf in tree_leaves(self)
        )
        return hash((tree_structure(self), *leaves))

    def __repr__(self) -> str:
        return repr_fields(self)

    @cached_property
    def leaves(self) -> list[Any]:
        """All numbers and arrays, those of inner modules too."""
        return tree_leaves(self)

    @cached_property
    def is_numpy(self) -> bool:
        """True where all numbers and arrays are NumPy's."""
        return is_numpy(*self.leaves)


def _field_names(module: Module) -> list[str]:
    return [x.name for x in fields(module)]


def repr_fields(module: Module) -> str:
    """Fields of a `module` with their numbers, in one line."""
    values = (f"{name}={_value_text(getattr(module, name))}" for name in _field_names(module))
    return f"{type(module).__name__}({', '.join(values)})"


def _register_pytree(kind: type[Module], jax: Any) -> None:
    """Tell JAX the leaves and static values of a `kind` of module."""
    leaf_names, static_names = kind.leaf_names, kind.static_names
    keys = [jax.tree_util.GetAttrKey(name) for name in leaf_names]

    def flatten(module: Any) -> tuple[tuple, tuple]:
        values = module.__dict__
        return tuple(map(values.get, leaf_names)), tuple(map(values.get, static_names))

    def flatten_with_keys(module: Any) -> tuple[tuple, tuple]:
        leaves, static_values = flatten(module)
        return tuple(zip(keys, leaves, strict=True)), static_values

    def unflatten(static_values: tuple, leaves: Any) -> Any:
        # leaves may be tracers, so nothing is checked again
        values = dict(zip(leaf_names, leaves, strict=True))
        return _rebuild(kind, values | dict(zip(static_names, static_values, strict=True)))

    jax.tree_util.register_pytree_with_keys(kind, flatten_with_keys, unflatten, flatten)


call_on_import("jax", lambda jax: [_register_pytree(kind, jax) for kind in _CLASSES])


def _value_text(value: Any) -> str:
    """Numbers of a field; of many their count, of traced ones their type and shape."""
    if is_jax_array(value) and not is_concrete(value):
        return f"{value.dtype}{list(value.shape)}"  # traced: it has no numbers yet
    if not (is_numpy(value) or is_jax_array(value)):
        return repr(value)
    x = np.asarray(value)
    return f"<{' × '.join(map(str, x.shape))} numbers>" if x.size > _MAX_SHOWN else repr(x.tolist())


Tree = TypeVar("Tree")
Kind = TypeVar("Kind", bound=Module)


def unique_indices(objects: Sequence[Any]) -> tuple[list[int], tuple[int, ...]]:
    """Indices of the distinct `objects`, and for each object the position of its equal in them."""
    positions: dict[Any, int] = {}
    inverse = tuple(positions.setdefault(item, len(positions)) for item in objects)
    return [inverse.index(k) for k in range(len(positions))], inverse


def to_numpy(tree: Tree) -> Tree:
    """Convert a `tree` of modules and arrays [any unit] to NumPy's numbers and arrays."""
    return tree_map(lambda leaf: np.asarray(leaf)[()], tree)


def with_fields(module: Kind, **values: Any) -> Kind:
    """Copy of a `module` with other `values` of some fields [SI], without checks."""
    current = {name: getattr(module, name) for name in _field_names(module)}
    return _rebuild(type(module), current | values)


def replace_checked(module: Kind, changes: dict[str, Any], **values: Any) -> Kind:
    """Copy of a `module` with `changes` of its arguments by name, checked as a new one. `values`:
    of arguments that have no attribute of their name [SI].
    """
    names = list(signature(type(module)).parameters)
    for name in changes:
        check_choice(name, names, "argument")
    current = {name: getattr(module, name) for name in names if name not in values}
    return type(module)(**current | values | changes)


def evaluate(law: Callable[..., Any], module: Module, *arrays: Any, static: tuple = ()) -> Any:
    """Result of a pure function `law(module, *arrays, *static)`, by NumPy where all numbers are
    NumPy's, else compiled by JAX; `static`: hashable arguments.
    """
    if not (module.is_numpy and is_numpy(*arrays)):
        return jax_backend().compile_law(law, static)(module, *arrays)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        return _as_numpy(law(module, *arrays, *static))


def _as_numpy(result: Any) -> Any:
    if isinstance(result, tuple):
        return type(result)(*map(_as_numpy, result))
    return np.asarray(result)[()]


def stop_gradient(tree: Any) -> Any:
    """Copy of a `tree` of arrays [any unit] that is constant for derivatives."""
    if type(tree) in NUMPY_TYPES or is_numpy(*tree_leaves(tree)):
        return tree
    return tree_map(_stop_leaf, tree)


def _stop_leaf(x: Any) -> Any:
    xp = array_namespace(x)
    return x if xp is np else (jax_backend() if is_jax_array(x) else xp).stop_gradient(x)

"""Modules: frozen attrs classes of numbers, arrays and other modules.

A subclass of `Module` is an attrs class: converters check its fields as it is made, and they can't
be set afterwards. `import fascicle.jax` makes modules pytrees of JAX. Values that a module caches
(`functools.cached_property`) are no part of its structure.

`tree_leaves`, `tree_map` and their like do what JAX's functions of these names do, without JAX.
"""

import sys
from abc import ABC
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from inspect import signature
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, dataclass_transform

import attrs
import numpy as np

from .array_namespace import is_jax_array
from .types import PyTree, Values
from .validation import check_choice, is_concrete


def _children(tree: PyTree) -> list[PyTree] | None:
    """Children of a node of a `tree`, in JAX's order; `None` for a leaf."""
    if hasattr(tree, "leaf_names"):
        return list(map(vars(tree).__getitem__, tree.leaf_names))
    if isinstance(tree, dict):
        return [tree[key] for key in sorted(tree)]
    if isinstance(tree, tuple | list):
        return list(tree)
    return [] if tree is None else None


def tree_leaves(tree: PyTree) -> list[Values]:
    """Numbers, arrays and other leaves of a `tree` [any unit], in JAX's order."""
    leaves, nodes = [], [tree]
    while nodes:
        node = nodes.pop()
        if (children := _children(node)) is None:
            leaves.append(node)
        else:
            nodes += reversed(children)
    return leaves


def tree_map(function: Callable[..., Values], tree: PyTree, *trees: PyTree) -> PyTree:
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


def tree_replace(tree: PyTree, leaves: Iterable[Values]) -> PyTree:
    """Copy of a `tree` with other `leaves`, in order [any unit]."""
    leaf = iter(leaves)
    return tree_map(lambda _: next(leaf), tree)


def tree_structure(tree: PyTree) -> Hashable:
    """Structure of a `tree`, hashable: types, keys and static fields."""
    if tree is None or (children := _children(tree)) is None:
        return tree is None
    if isinstance(tree, dict):
        return dict, tuple(sorted(tree)), tuple(map(tree_structure, children))
    fixed = tuple(vars(tree)[name] for name in getattr(tree, "static_names", ()))
    return type(tree), fixed, tuple(map(tree_structure, children))


def _rebuild(kind: type["Kind"], values: dict[str, PyTree]) -> "Kind":
    """A module of a `kind` with `values` that are not checked again."""
    module = object.__new__(kind)
    vars(module).update(values)
    return module


_MAX_SHOWN = 8  # numbers of an array for which a line has room
_CLASSES: list[type["Module"]] = []


def modules() -> list[type["Module"]]:
    """All classes of modules that have been defined."""
    return list(_CLASSES)


def static(
    *, default: Values = attrs.NOTHING, converter: Callable | None = None, **metadata: Values
) -> Any:
    """A field that is part of a module's structure, such as the name of a law."""
    return record(default=default, converter=converter, static=True, **metadata)


def record(
    *,
    default: Values = attrs.NOTHING,
    converter: Callable | None = None,
    kw_only: bool = False,
    **metadata: object,
) -> Any:
    """A field of a module: its `default` [any unit], a `converter` that validates a value as it is
    set and returns it as numbers [any unit], and other `metadata`; `kw_only`: given by keyword.
    """
    return attrs.field(default=default, converter=converter, kw_only=kw_only, metadata=metadata)


@dataclass_transform(
    eq_default=False, frozen_default=True, field_specifiers=(static, record, attrs.field)
)
class Module(ABC):
    """A frozen record of numbers, arrays and other modules.

    A class that writes `__init__` itself ends it with `self.__attrs_init__(…)`, which converts
    and sets its fields. `__check_init__` of a class, and of each of its bases, then checks them
    together.
    """

    leaf_names: ClassVar[tuple[str, ...]]
    static_names: ClassVar[tuple[str, ...]]

    if TYPE_CHECKING:

        def __attrs_init__(self, *values: object, **fields: object) -> None: ...

    def __init_subclass__(cls, **options: object) -> None:
        super().__init_subclass__(**options)
        owner = next(kind for kind in cls.__mro__ if "__init__" in vars(kind))
        writes_init = owner is not object and "__attrs_init__" in vars(owner)
        makes_init = "__init__" not in vars(cls) and not writes_init
        attrs.define(cls, frozen=True, eq=False, repr=False, slots=False, init=makes_init)
        del cls.__setattr__, cls.__delattr__  # attrs' own, which name no remedy
        names = {field.name: bool(field.metadata.get("static")) for field in attrs.fields(cls)}
        cls.leaf_names = tuple(name for name, is_static in names.items() if not is_static)
        cls.static_names = tuple(name for name, is_static in names.items() if is_static)
        _CLASSES.append(cls)
        if fascicle_jax := sys.modules.get("fascicle.jax"):
            fascicle_jax.register(cls)

    def __attrs_post_init__(self) -> None:
        # a check of all fields together is inherited
        for kind in reversed(type(self).__mro__):
            if "__check_init__" in vars(kind):
                vars(kind)["__check_init__"](self)

    def __setattr__(self, name: str, value: object) -> None:
        """Fields are set once, by the constructor."""
        kind = type(self).__name__
        remedy = "construct another one"
        if hasattr(self, "replace") and name in signature(type(self)).parameters:
            remedy = f"write {kind.lower()} = {kind.lower()}.replace({name}=…)"
        raise AttributeError(f"`{name}` can't be set, a {kind} is immutable: {remedy}.")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"`{name}` can't be deleted.")

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


def _field_names(module: Module) -> list[str]:
    return [field.name for field in attrs.fields(type(module))]


def repr_fields(module: Module) -> str:
    """Fields of a `module` with their numbers, in one line."""
    values = (f"{name}={_value_text(getattr(module, name))}" for name in _field_names(module))
    return f"{type(module).__name__}({', '.join(values)})"


def _value_text(value: Values) -> str:
    """Numbers of a field; of many their count, of traced ones their type and shape."""
    if is_jax_array(value) and not is_concrete(value):
        return f"{value.dtype}{list(value.shape)}"  # traced: it has no numbers yet
    if not (isinstance(value, float | int | np.generic | np.ndarray) or is_jax_array(value)):
        return repr(value)
    x = np.asarray(value)
    return f"<{' × '.join(map(str, x.shape))} numbers>" if x.size > _MAX_SHOWN else repr(x.tolist())


Tree = TypeVar("Tree")
Kind = TypeVar("Kind", bound=Module)


def unique_indices(objects: Sequence[Hashable]) -> tuple[list[int], tuple[int, ...]]:
    """Indices of the distinct `objects`, and for each object the position of its equal in them."""
    positions: dict[Hashable, int] = {}
    inverse = tuple(positions.setdefault(item, len(positions)) for item in objects)
    return [inverse.index(k) for k in range(len(positions))], inverse


def to_numpy(tree: Tree) -> Tree:
    """A `tree` of modules and arrays [any unit] with NumPy's numbers and arrays for JAX's."""
    if not any(map(is_jax_array, tree_leaves(tree))):
        return tree
    return tree_map(lambda leaf: np.asarray(leaf)[()], tree)


def with_fields(module: Kind, **values: Values) -> Kind:
    """Copy of a `module` with other `values` of some fields [SI], without checks."""
    current = {name: getattr(module, name) for name in _field_names(module)}
    return _rebuild(type(module), current | values)


def replace_checked(module: Kind, changes: Mapping[str, Values], **values: Values) -> Kind:
    """Copy of a `module` with `changes` of its arguments by name, checked as a new one. `values`:
    of arguments that have no attribute of their name [SI].
    """
    names = list(signature(type(module)).parameters)
    for name in changes:
        check_choice(name, names, "argument")
    current = {name: getattr(module, name) for name in names if name not in values}
    return type(module)(**current | values | dict(changes))

"""Trees of numbers and arrays: modules, tuples, lists and dictionaries, without JAX.

JAX has the same for its pytrees; these work where it is not loaded, and on the same types.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields
from functools import cache
from typing import Any


def tree_leaves(tree: Any) -> list[Any]:
    """The numbers, arrays and other leaves of a `tree` [any unit], in JAX's order."""
    return list(_leaves(tree))


def tree_map(function: Callable[..., Any], tree: Any, *others: Any) -> Any:
    """A tree of what a `function` gives of each leaf [any unit].

    **Arguments:**

    - `function`: of a leaf of each tree [-].
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
    dynamic, structure = field_names(type(tree))
    parts = {
        name: tree_map(function, getattr(tree, name), *(getattr(x, name) for x in others))
        for name in dynamic
    }
    return rebuild(type(tree), parts | {name: getattr(tree, name) for name in structure})


def tree_replace(tree: Any, leaves: Iterable[Any]) -> Any:
    """The same `tree` with other `leaves`, in order [any unit]."""
    rest = iter(leaves)
    return tree_map(lambda _: next(rest), tree)


def tree_structure(tree: Any) -> Any:
    """What trees of one structure have in common [-], hashable: types and static fields."""
    if isinstance(tree, dict):
        return dict, tuple((key, tree_structure(value)) for key, value in sorted(tree.items()))
    if isinstance(tree, tuple | list):
        return type(tree), tuple(map(tree_structure, tree))
    if not is_module(tree):
        return tree is None
    dynamic, structure = field_names(type(tree))
    parts = (tree_structure(getattr(tree, name)) for name in dynamic)
    return type(tree), tuple(getattr(tree, name) for name in structure), tuple(parts)


def is_module(value: Any) -> bool:
    """Whether a `value` [-] is a module of fascicle's."""
    return getattr(type(value), "is_fascicle_module", False)


@cache
def field_names(kind: type) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the fields of a `kind` [-] of module that hold leaves, and of static ones [-]."""
    static = [bool(field.metadata.get("static")) for field in fields(kind)]
    names = [field.name for field in fields(kind)]
    pairs = list(zip(names, static, strict=True))
    return tuple(n for n, s in pairs if not s), tuple(n for n, s in pairs if s)


def rebuild(kind: Any, values: dict[str, Any]) -> Any:
    """A module of a `kind` [-] with `values` [any unit] that are not checked again."""
    module = object.__new__(kind)
    module.__dict__.update(values)
    return module


def _leaves(tree: Any) -> Iterator[Any]:
    if tree is None:
        return
    if isinstance(tree, dict):
        for key in sorted(tree):
            yield from _leaves(tree[key])
    elif isinstance(tree, tuple | list):
        for entry in tree:
            yield from _leaves(entry)
    elif is_module(tree):
        for name in field_names(type(tree))[0]:
            yield from _leaves(getattr(tree, name))
    else:
        yield tree

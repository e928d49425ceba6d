"""JAX arrays for fascicle: import this module before you pass one.

    import fascicle.jax

It does three things, and nothing else in fascicle changes JAX:

- switches JAX to 64-bit floats, without which roots lose digits;
- registers muscles, bundles and all other modules as pytrees, so that `jax.jit`, `jax.vmap` and
  `jax.grad` take them as arguments;
- asks XLA to compile each loop of a run as one kernel, unless `XLA_FLAGS` has an option of that
  kind: 10 s of a bundle then take 0.06 s instead of 1 s.

Under `jax.jit`, `jax.grad` and `jax.vmap` a value is traced and has no number yet, so its range is
not checked: a strain or pressure outside the domain gives a number without meaning, and no error.
"""

import os
from collections.abc import Iterable

from .core.errors import missing_extra
from .core.module import Module, modules


try:
    import jax
except ModuleNotFoundError as error:
    raise missing_extra(error) or error from None


# XLA compiles a small loop as one function of machine code, and runs a larger one as a task for
# each of its operations; the option says what is small [byte]. XLA reads it when it first compiles.
# It has no entry in `jax.config`, and `jit(compiler_options=…)` refuses it
_XLA_OPTION = "--xla_backend_extra_options"
_LOOP_SIZE = "xla_cpu_small_while_loop_byte_threshold=100000000"

_flags = os.environ.get("XLA_FLAGS", "")
if _XLA_OPTION not in _flags:  # a second one would replace the caller's
    os.environ["XLA_FLAGS"] = f"{_flags} {_XLA_OPTION}={_LOOP_SIZE}".strip()

jax.config.update("jax_enable_x64", True)


def register(kind: type[Module]) -> None:
    """Tell JAX the leaves and static values of a `kind` of module."""
    leaf_names, static_names = kind.leaf_names, kind.static_names
    keys = [jax.tree_util.GetAttrKey(name) for name in leaf_names]

    def flatten(module: Module) -> tuple[tuple, tuple]:
        values = vars(module)
        return tuple(map(values.get, leaf_names)), tuple(map(values.get, static_names))

    def flatten_with_keys(module: Module) -> tuple[tuple, tuple]:
        leaves, static_values = flatten(module)
        return tuple(zip(keys, leaves, strict=True)), static_values

    def unflatten(static_values: tuple, leaves: Iterable) -> Module:
        # leaves may be tracers, so nothing is checked again
        module = object.__new__(kind)
        vars(module).update(zip(leaf_names, leaves, strict=True))
        vars(module).update(zip(static_names, static_values, strict=True))
        return module

    jax.tree_util.register_pytree_with_keys(kind, flatten_with_keys, unflatten, flatten)


for _kind in modules():
    register(_kind)

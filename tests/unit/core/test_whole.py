"""Programs compiled as one: the same numbers, and XLA knows all that it is marked for.

Where it didn't, it would end the process: so what is marked runs in a process of its own.
"""

import subprocess
import sys
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax

from fascicle.core.types import Numbers
from fascicle.core.whole import _called, whole


MARK = 'xla_cpu_small_call = "true"'


def looped(inside: Callable) -> Callable:
    """A loop of 30 steps that goes on with what `inside` makes of a number and a row."""

    def function(x: jax.Array, row: jax.Array) -> jax.Array:
        return lax.scan(lambda y, _: ((z := inside(y, row)), z), x, length=30)[1]

    return function


# of each kind of operation that is said to go, one at least
GOES = {
    "arithmetic": lambda y, row: jnp.sum(row) / (2 + y**2) - y * row[1] + abs(y) ** 0.3,
    "powers": lambda y, row: jnp.sqrt(1 + y**2) ** row[0] + lax.rsqrt(2 + y),
    "exponentials": lambda y, row: jnp.log1p(jnp.exp(-y)) + jnp.expm1(-y) - jnp.log(2 + row[0]),
    "angles": lambda y, row: jnp.sin(y) + jnp.cos(row[0]) + jnp.arctan2(y, row[1]) + jnp.tanh(y),
    "choices": lambda y, row: jnp.where((y > 0.1) & (row > 0), y, -row).min() + jnp.clip(y, 0, 1),
    "rounding": lambda y, row: jnp.floor(3 * y) / 7 + jnp.ceil(row[0]) + y % 0.3 + jnp.sign(y),
    "shapes": lambda y, row: jnp.concatenate([row[::-1], y[None]]).reshape(2, -1).T.sum() / 9,
    "look-ups": lambda y, row: row[jnp.argmax(jnp.abs(row - y))] / 3 + jnp.cumsum(row)[2] / 9,
    "products": lambda y, row: jnp.tanh((jnp.outer(row, row) @ row)[0] * y + jnp.all(row > y)),
    "slices": lambda y, row: lax.dynamic_update_slice(row, y[None], (1,)).sum() / 5,
    "branches": lambda y, row: lax.cond(y > 0.2, lambda a, _: a / 2, lambda _, b: b[0], y, row),
    "loops": lambda y, row: lax.while_loop(lambda z: z > 0.5, lambda z: z / 2, y + row[0]),
}
GOES_NOT = {
    "sort": lambda y, row: jnp.sort(row)[1] + y / 2,
    "scatter": lambda y, row: row.at[jnp.array([0, 1])].add(y)[1] / 2,
    "random": lambda y, row: jax.random.uniform(jax.random.key(3)) * row[0] + y / 2,
}
GIVEN = np.float64(0.4), np.array([0.7, -0.2, 0.3])


def test_all_that_is_marked_is_compiled_and_gives_the_same() -> None:
    done = subprocess.run(
        [sys.executable, __file__], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.split() == [*GOES, "unused"]


@pytest.mark.parametrize("name", GOES_NOT)
def test_what_is_not_known_to_go_is_compiled_as_usual(name: str) -> None:
    function = looped(GOES_NOT[name])
    assert MARK not in _called.lower(function, GIVEN, ()).as_text()
    np.testing.assert_array_equal(whole(function, GIVEN, ()), jax.jit(function)(*GIVEN))


def test_a_version_that_was_not_tried_is_not_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    def text() -> str:
        return _called.lower(looped(GOES["arithmetic"]), GIVEN, ()).as_text()

    assert MARK in text()
    monkeypatch.setattr(jax, "__version_info__", (99, 0, 0))
    jax.clear_caches()
    assert MARK not in text()


def ignoring(x: Numbers, row: Numbers, other: Numbers, none: Numbers) -> Numbers:
    """Of what it is given, some isn't used, and some is empty."""
    del other
    return looped(GOES["arithmetic"])(x, row) + none.sum()


if __name__ == "__main__":
    jax.config.update("jax_enable_x64", True)
    for name, inside in GOES.items():
        function = looped(inside)
        assert MARK in _called.lower(function, GIVEN, ()).as_text(), name
        # an expression that is fused otherwise is rounded otherwise, and the loop goes on with it
        np.testing.assert_allclose(
            whole(function, GIVEN, ()), jax.jit(function)(*GIVEN), rtol=1e-12, err_msg=name
        )
        sys.stdout.write(f"{name}\n")
    given = (*GIVEN, np.array([True, False]), np.zeros((2, 0)))
    np.testing.assert_allclose(whole(ignoring, given, ()), ignoring(*given), rtol=1e-12)
    sys.stdout.write("unused\n")

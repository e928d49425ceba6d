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


def long(y: jax.Array, row: jax.Array) -> jax.Array:
    """What takes many operations."""
    z = y
    for k in range(8):
        z = 0.7 * z - row[k % 3] * (z + 0.1 * k) * y / 8
    return z


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
    "parts": lambda y, row: sum(jnp.unstack(jnp.stack([row, row * y], 1), axis=1)).mean() - y / 3,
    "again": jax.checkpoint(lambda y, row: jnp.sin(y) * row[0], prevent_cse=False),
    "slices": lambda y, row: lax.dynamic_update_slice(row, y[None], (1,)).sum() / 5,
    "branches": lambda y, row: lax.cond(y > 0.2, lambda a, _: a / 2, lambda _, b: b[0], y, row),
    "long": lambda y, row: (z := long(y, row)) * row[0] + z**2 - long(z / 3, row),
    "loops": lambda y, row: lax.while_loop(lambda z: z > 0.5, lambda z: z / 2, y + row[0]),
}
GOES_NOT = {
    "sort": lambda y, row: jnp.sort(row)[1] + y / 2,
    "scatter": lambda y, row: row.at[jnp.array([0, 1])].add(y)[1] / 2,
    "barriers": jax.checkpoint(lambda y, row: jnp.sin(y) * row[0]),
    "random": lambda y, row: jax.random.uniform(jax.random.key(3)) * row[0] + y / 2,
}
GIVEN = np.float64(0.4), np.array([0.7, -0.2, 0.3])
# their slopes are those of all that a run asks for
SLOPES = (
    "arithmetic",
    "powers",
    "exponentials",
    "choices",
    "shapes",
    "parts",
    "again",
    "long",
)
RUNS = {"turns": 3, "rows": 70}


@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.slow)])
def test_all_that_is_marked_is_compiled_and_gives_the_same(every: int) -> None:
    done = subprocess.run(
        [sys.executable, __file__, str(every)],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    said = [*[*GOES][::every], *SLOPES[::every], *RUNS, "nested", "shared", "counts", "unused"]
    assert done.stdout.split() == said


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
    _called.clear_cache()
    assert MARK not in text()


def test_of_a_version_that_was_not_tried_runs_and_slopes_are_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Under `vmap`, `grad` and `jit` of a caller's."""
    function, given = looped(GOES["arithmetic"]), runs(5)
    monkeypatch.setattr(jax, "__version_info__", (99, 0, 0))
    _called.clear_cache()
    for change in (jax.vmap, lambda f: jax.vmap(slopes(f))):
        ours = jax.jit(change(wholly(function)))
        assert MARK not in ours.lower(*given).as_text()
        for x, y in zip(
            jax.tree.leaves(ours(*given)), jax.tree.leaves(change(function)(*given)), strict=True
        ):
            np.testing.assert_allclose(x, y, rtol=1e-10, atol=1e-11)
    _called.clear_cache()


def ignoring(x: Numbers, row: Numbers, other: Numbers, none: Numbers) -> Numbers:
    """Of what it is given, some isn't used, and some is empty."""
    del other
    return looped(GOES["arithmetic"])(x, row) + none.sum()


def looked_up(x: Numbers, row: Numbers) -> Numbers:
    """A loop that looks cells up in a table, of which all runs have the same."""
    table = jnp.arange(24.0).reshape(4, 3, 2) / 24

    def inside(y: jax.Array, row: jax.Array) -> jax.Array:
        cells = jnp.floor(jnp.stack([y, row[0]]) * 7).astype(int)
        return jnp.tanh((table[cells, cells % 3] * row[:2, None]).sum() + y / 3)

    return looped(inside)(x, row)


def assert_same(this: Callable, other: Callable, *given: Numbers, name: str) -> None:
    """Both give the same, and the one is marked."""
    assert MARK in jax.jit(this).lower(*given).as_text(), name
    found, expected = jax.jit(this)(*given), jax.jit(other)(*given)
    # an expression that is fused otherwise is rounded otherwise, and the loop goes on with it; at
    # a number of 1e-3 the power of 0.3 takes a rounding of the others fifty times
    for x, y in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(x, y, rtol=1e-10, atol=1e-11, err_msg=name)


def runs(count: int) -> tuple[Numbers, Numbers]:
    """What so many runs are given."""
    return np.linspace(0.1, 0.5, count), np.linspace(-0.9, 0.8, 3 * count).reshape(count, 3)


def slopes(function: Callable) -> Callable:
    """Forward and reverse, of one run's sum."""

    def total(x: Numbers, row: Numbers) -> Numbers:
        return function(x, row).sum()

    def both(x: Numbers, row: Numbers) -> tuple:
        return jax.grad(total, (0, 1))(x, row), jax.jacfwd(total, 1)(x, row)

    return both


def wholly(function: Callable) -> Callable:
    """The function, as a whole."""
    return lambda *given: whole(function, given, ())


def main(every: int) -> None:
    """All that might end the process, and of operations every so many-th."""
    for name in [*GOES][::every]:
        function = looped(GOES[name])
        assert_same(wholly(function), function, *GIVEN, name=name)
        # an operation of many runs may be one that doesn't go: then it isn't marked
        found = jax.jit(jax.vmap(wholly(function)))(*runs(6))
        expected = jax.jit(jax.vmap(function))(*runs(6))
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-11, err_msg=name)
        sys.stdout.write(f"{name}\n")
    for name in SLOPES[::every]:
        function = looped(GOES[name])
        assert_same(slopes(wholly(function)), slopes(function), *GIVEN, name=name)
        sys.stdout.write(f"{name}\n")
    for name, count in RUNS.items():
        for function in (looped(GOES["long"]), looked_up, looped(GOES["arithmetic"])):
            assert_same(jax.vmap(wholly(function)), jax.vmap(function), *runs(count), name=name)
        sys.stdout.write(f"{name}\n")
    many, same = (
        jax.vmap(jax.vmap(slopes(one), (0, None)), (None, 0))
        for one in (wholly(function), function)
    )
    assert_same(many, same, runs(4)[0], runs(5)[1], name="nested")
    sys.stdout.write("nested\n")
    # a slope that is handed on as it is, and one that isn't
    for y, inside in ((GIVEN[1], lambda y, row: row + y), (GIVEN[0], function)):
        shared = [
            jax.grad(lambda y, one=one: jax.vmap(one, (None, 0))(y, runs(5)[1]).sum())
            for one in (wholly(inside), inside)
        ]
        np.testing.assert_allclose(shared[0](y), shared[1](y), rtol=1e-10)
    sys.stdout.write("shared\n")
    counted = wholly(lambda y, row: (y * row, (row > y).astype(int)))
    slope, count = jax.jacfwd(counted)(*GIVEN)[0], counted(*GIVEN)[1]
    np.testing.assert_array_equal(slope, GIVEN[1])
    np.testing.assert_array_equal(count, [1, 0, 0])
    sys.stdout.write("counts\n")
    given = (*GIVEN, np.array([True, False]), np.zeros((2, 0)))
    np.testing.assert_allclose(whole(ignoring, given, ()), ignoring(*given), rtol=1e-12)
    sys.stdout.write("unused\n")


if __name__ == "__main__":
    jax.config.update("jax_enable_x64", True)
    main(int(sys.argv[1]))

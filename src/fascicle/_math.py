r"""Roots and elliptic integrals, elementwise and differentiable.

Roots carry the implicit derivative: where $f(x, \theta) = 0$,

$$\frac{\mathrm{d}x}{\mathrm{d}\theta}
  = -\frac{\partial f/\partial\theta}{\partial f/\partial x},$$

so no iteration is ever differentiated. They carry no host callbacks and no error
checks: a compiled law stays a pure function.

**Source:** complete elliptic integrals, the amplitude and Jacobi's epsilon by the
arithmetic-geometric mean: Abramowitz and Stegun (1964), 16.4 and 17.6.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax

from ._types import Batch, BatchLike, BoolBatch


_STEPS = 100  # bisection alone would need 53 to reach float64's last bit in (0, 1)
_TINY = 4 * 2.0**-52
_AGM_STEPS = 6  # the mean's error squares at each step: 5 suffice up to m = 0.9


def guarded(condition: BoolBatch, value: BatchLike, safe: BatchLike = 1.0) -> Batch:
    """`value` where `condition`, else a harmless constant with no gradient.

    The inner half of the double `where`: a branch that isn't taken must still be
    finite, since its gradient is multiplied by zero, and 0 × ∞ is NaN.
    """
    return jnp.where(condition, value, safe)


def root(
    residual: Callable[[Batch], Batch],
    low: BatchLike,
    high: BatchLike,
    start: BatchLike,
    steps: int = 0,
) -> Batch:
    """The root of an elementwise `residual` that is positive below it, negative above.

    Newton's method, kept inside a shrinking bracket [`low`, `high`] and replaced by
    bisection where it leaves the bracket or fails to halve its step. From a good start give
    the number of `steps` that nearly always suffice: they are one pass over the points, and
    the loop, a pass for each step, has only the others left.
    """
    # where the search begins doesn't move the root; unstopped, zero cotangents would flow
    # back into how the bracket was found, and meet infinite slopes there
    low, high, start = (lax.stop_gradient(jnp.asarray(x, dtype=float)) for x in (low, high, start))

    # whether a search has ended is asked of numbers that are stored: the compiler may evaluate
    # an expression once for each of its uses, and differently in the last bits
    def ended(x: Batch, before: Batch) -> BoolBatch:
        return jnp.abs(x - before) <= (jnp.abs(x) + 1) * _TINY

    def solve(f: Callable[[Batch], Batch], x0: Batch) -> Batch:
        a, b = jnp.broadcast_to(low, x0.shape), jnp.broadcast_to(high, x0.shape)

        def keep_going(state: tuple) -> BoolBatch:
            n, x, before, _, _ = state
            return (n < _STEPS) & ~jnp.all(ended(x, before))

        def step(state: tuple) -> tuple:
            n, x, before, a, b = state
            value, slope = jax.jvp(f, (x,), (jnp.ones_like(x),))
            a, b = jnp.where(value > 0, x, a), jnp.where(value > 0, b, x)
            # no number where the residual is flat or vertical: bisect
            newton = jnp.where(jnp.isfinite(slope), x - value / slope, jnp.nan)
            newton = jnp.where(value == 0, x, newton)
            halved = jnp.abs(newton - x) < 0.5 * jnp.abs(x - before)
            good = (a <= newton) & (newton <= b) & halved
            here = ended(x, newton)  # within rounding, also of the bracket's ends
            new = jnp.where(good | here, jnp.clip(newton, a, b), 0.5 * (a + b))
            return n + 1, jnp.where(ended(x, before), x, new), x, a, b

        state = (0, x0, x0 + 4 * (b - a) + 1, a, b)
        for _ in range(steps):
            state = step(state)
        return lax.while_loop(keep_going, step, state)[1]

    def tangent_solve(linear: Callable[[Batch], Batch], y: Batch) -> Batch:
        slope = linear(jnp.ones_like(y))
        return y / jnp.where(slope == 0, jnp.inf, slope)  # a flat residual moves no root

    shape = jnp.broadcast_shapes(low.shape, high.shape, jax.eval_shape(residual, start).shape)
    x0 = jnp.broadcast_to(start, shape)
    # a bound method of a traced module can't be hashed, as `custom_root` does
    return lax.custom_root(lambda x: residual(x), x0, solve, tangent_solve)  # noqa: PLW0108


@partial(jax.custom_jvp, nondiff_argnums=(0, 2))
def newton(
    residual: Callable[..., Batch], start: BatchLike, steps: int, *parameters: BatchLike
) -> Batch:
    """The root of an elementwise `residual(x, *parameters)` by a fixed number of `steps`.

    For residuals that are known to converge from `start` all over their domain: no loop, no
    bracket, a few operations. `residual` must not close over what is differentiated.
    """
    x = jnp.asarray(start)
    for _ in range(steps):
        value, slope = jax.jvp(lambda x: residual(x, *parameters), (x,), (jnp.ones_like(x),))
        x = x - value / slope
    return x


@newton.defjvp
def _(residual: Callable[..., Batch], steps: int, primals: tuple, tangents: tuple) -> tuple:
    start, *parameters = primals
    x = newton(residual, start, steps, *parameters)
    _, slope = jax.jvp(lambda x: residual(x, *parameters), (x,), (jnp.ones_like(x),))
    _, moved = jax.jvp(lambda *p: residual(x, *p), tuple(parameters), tuple(tangents[1:]))
    return x, -moved / slope


class Elliptic(NamedTuple):
    """Complete elliptic integrals, and the mean's steps that give the incomplete ones."""

    K: Batch
    E: Batch
    means: tuple[Batch, ...]
    differences: tuple[Batch, ...]


def elliptic(m: BatchLike) -> Elliptic:
    """$K(m)$ and $E(m)$ of parameter $m = k^2$ in [0, 0.9], smooth at $m = 0$."""
    m = jnp.asarray(m, dtype=float)
    a, b = jnp.ones_like(m), jnp.sqrt(1 - m)
    means, differences, total = [a], [jnp.zeros_like(m)], m / 2
    for n in range(_AGM_STEPS):
        a, b, c = (a + b) / 2, jnp.sqrt(a * b), (a - b) / 2
        means.append(a)
        differences.append(c)
        total = total + 2**n * c**2
    K = jnp.pi / (2 * a)
    return Elliptic(K, K * (1 - total), tuple(means), tuple(differences))


def jacobi(u: BatchLike, integrals: Elliptic) -> tuple[Batch, Batch]:
    r"""Amplitude $\varphi = \mathrm{am}(u)$ and incomplete integral $E(\varphi)$ at $u$."""
    u = jnp.asarray(u, dtype=float)
    phase = 2.0**_AGM_STEPS * integrals.means[-1] * u
    epsilon = u * integrals.E / integrals.K
    for a, c in zip(integrals.means[:0:-1], integrals.differences[:0:-1], strict=True):
        epsilon = epsilon + c * jnp.sin(phase)
        phase = (phase + jnp.arcsin(c / a * jnp.sin(phase))) / 2
    return phase, epsilon

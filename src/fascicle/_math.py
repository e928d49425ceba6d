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
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax

from ._types import Batch, BatchLike, BoolBatch, IntBatch


_STEPS = 100  # bisection alone would need 53 to reach float64's last bit in (0, 1)
_AGM_STEPS = 6  # the mean's error squares at each step: 5 suffice up to m = 0.9


def guarded(condition: BoolBatch, value: BatchLike, safe: BatchLike = 1.0) -> Batch:
    """`value` where `condition`, else a harmless constant with no gradient.

    The inner half of the double `where`: a branch that isn't taken must still be
    finite, since its gradient is multiplied by zero, and 0 × ∞ is NaN.
    """
    return jnp.where(condition, value, safe)


def root(
    residual: Callable[[Batch], Batch], low: BatchLike, high: BatchLike, start: BatchLike
) -> Batch:
    """The root of an elementwise `residual` that is positive below it, negative above.

    Newton's method, kept inside a shrinking bracket [`low`, `high`] and replaced by
    bisection where it leaves the bracket or fails to halve its step.
    """
    # where the search begins doesn't move the root; unstopped, zero cotangents would flow
    # back into how the bracket was found, and meet infinite slopes there
    low, high, start = (lax.stop_gradient(jnp.asarray(x, dtype=float)) for x in (low, high, start))

    def solve(f: Callable[[Batch], Batch], x0: Batch) -> Batch:
        a, b = jnp.broadcast_to(low, x0.shape), jnp.broadcast_to(high, x0.shape)

        def keep_going(state: tuple) -> BoolBatch:
            n, _, _, _, _, done = state
            return (n < _STEPS) & ~jnp.all(done)

        def step(state: tuple) -> tuple:
            n, x, a, b, last, done = state
            value, slope = jax.jvp(f, (x,), (jnp.ones_like(x),))
            a, b = jnp.where(value > 0, x, a), jnp.where(value > 0, b, x)
            # no number where the residual is flat or vertical: bisect
            newton = jnp.where(jnp.isfinite(slope), x - value / slope, jnp.nan)
            inside = (a <= newton) & (newton <= b) & (jnp.abs(newton - x) < 0.5 * last)
            new = jnp.where(inside, newton, 0.5 * (a + b))
            new = jnp.where(done | (value == 0), x, new)
            moved = jnp.abs(new - x)
            tiny = 4 * jnp.finfo(x.dtype).eps * (jnp.abs(x) + 1)
            return n + 1, new, a, b, moved, done | (moved <= tiny)

        wide = 4 * (b - a) + 1
        done = jnp.zeros(x0.shape, bool)
        return lax.while_loop(keep_going, step, (0, x0, a, b, wide, done))[1]

    def tangent_solve(linear: Callable[[Batch], Batch], y: Batch) -> Batch:
        slope = linear(jnp.ones_like(y))
        return y / jnp.where(slope == 0, jnp.inf, slope)  # a flat residual moves no root

    shape = jnp.broadcast_shapes(low.shape, high.shape, jax.eval_shape(residual, start).shape)
    x0 = jnp.broadcast_to(start, shape)
    # a bound method of a traced module can't be hashed, as `custom_root` does
    return lax.custom_root(lambda x: residual(x), x0, solve, tangent_solve)  # noqa: PLW0108


def newton(residual: Callable[[Batch], Batch], start: BatchLike, steps: int) -> Batch:
    """The root of an elementwise `residual` by a fixed number of Newton `steps`.

    For residuals that are known to converge from `start` all over their domain: no loop,
    no bracket, a few operations. The last two steps carry the derivatives; at the root
    they give the implicit first and second ones exactly.
    """
    x = jnp.asarray(start, dtype=float)
    for step in range(steps):
        if step == steps - 2:
            x = lax.stop_gradient(x)
        value, slope = jax.jvp(residual, (x,), (jnp.ones_like(x),))
        x = x - value / slope
    return x


def maximum_of(
    function: Callable[[Batch], Batch], low: BatchLike, high: BatchLike, steps: int = 44
) -> Batch:
    """Where an elementwise function with one peak in [`low`, `high`] is largest.

    Golden-section search; the peak's place is known to the square root of the float's
    precision, its height to the precision. Not differentiable: differentiate at the place.
    """
    ratio = 0.6180339887498949  # 1/φ

    def shrink(_: IntBatch, bracket: tuple[Batch, Batch]) -> tuple[Batch, Batch]:
        a, b = bracket
        c, d = b - ratio * (b - a), a + ratio * (b - a)
        left = function(c) >= function(d)
        return jnp.where(left, a, c), jnp.where(left, d, b)

    a, b = jnp.broadcast_arrays(jnp.asarray(low, dtype=float), jnp.asarray(high, dtype=float))
    a, b = lax.fori_loop(0, steps, shrink, (lax.stop_gradient(a), lax.stop_gradient(b)))
    return lax.stop_gradient(0.5 * (a + b))


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

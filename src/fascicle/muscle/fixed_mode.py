r"""The paper's buckled shape in two numbers, and the roots it asks for, fast.

A column of fixed mode shape, compressed by $\xi$ of its free length, knows its slenderness
$c = EA L_{fs}^2/(4\pi^2 EI)$ and nothing else of the muscle. With $b = 1/a$ of (16),

$$b = c\, \xi \frac{(1 - \xi)^4}{1 + \xi}, \qquad
  u = 1 - w = \frac{b}{b + h(u)}, \qquad
  h = \frac{\sqrt{1 - w \xi/(2 - \xi)}}{1 - w \xi}, \tag{16a}$$

so that no modulus is left in the share $u$ of the compression that bows the column, and
its largest moment is

$$\hat m = \frac{M_b L_{fs}}{4 \pi EI} = \sqrt{\xi u}\, (1 - \xi)^{-3/2}. \tag{16b}$$

It rises with $\xi$ to one peak, at a $\xi$ that depends on $c$ alone, and falls to zero where
the ends meet. Given $\hat m$, (16b) says $u$, and (16a) is one equation for $r = \hat m/\xi$,
which stays finite as the moment vanishes: no root is nested in another.

**Speed:** Newton's steps are few and fixed, from starts whose error is known, so that one
pass over the points does them all; derivatives are implicit. The peak's place is a
Chebyshev series in $\ln c$, fitted when first asked for.
**Source:** Kim, Mazzoleni and Bryant (2021), (10)-(16), rearranged here.
"""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
from numpy.polynomial import chebyshev

from .._math import newton, root
from .._types import Batch, BatchLike, BoolBatch


_LEAST, _MOST = 0.1, 1e5  # slenderness c: outside, the peak is taken where it is at the end
_TERMS = 32  # of the peak's series: its place to 1e-7, its height to 1e-12


ANYWHERE, IN_DOMAIN = (5, 2), (2, 1)  # steps in float32, and in float64


def unshortened(c: BatchLike, xi: BatchLike, steps: tuple[int, int] = ANYWHERE) -> Batch:
    """$u/\\xi$ [-] at slenderness `c` [-] and compression `xi` [-]; finite as it vanishes.

    `steps` [-] may be `IN_DOMAIN` where $\\xi \\le 0.72$, as it is for every strain to 0.6.
    """
    c, xi = jnp.asarray(c, dtype=float), jnp.asarray(xi, dtype=float)
    per_xi = c * (1 - xi) ** 4 / (1 + xi)
    # off by up to 0.74 of itself in the domain; two steps take it to float32's precision,
    # where they cost half as much, and a last one from there to float64's
    f, x = (jax.lax.stop_gradient(a).astype(jnp.float32) for a in jnp.broadcast_arrays(per_xi, xi))
    rough = newton(_left_over, f * (1 + f * x) / ((1 + f * x) ** 2 + x / 2), steps[0], f, x)
    return newton(_undivided, rough.astype(per_xi.dtype), steps[1], per_xi, xi)


def moment(c: BatchLike, xi: BatchLike) -> Batch:
    """$\\hat m$ [-] at slenderness `c` [-] and compression `xi` [-], (16b)."""
    xi = jnp.asarray(xi, dtype=float)
    return xi * jnp.sqrt(unshortened(c, xi) / (1 - xi) ** 3)


def compression_at_moment(c: BatchLike, target: BatchLike) -> tuple[Batch, BoolBatch]:
    """First $\\xi$ [-] whose $\\hat m$ is `target` [-] at slenderness `c` [-], and whether
    there is one; where there is none, that of half the peak.
    """
    c, target = jnp.asarray(c, dtype=float), jnp.asarray(target, dtype=float)
    peak = _peak(c)
    highest = moment(c, peak)
    reached = target <= highest
    m = jnp.where(reached, target, 0.5 * jax.lax.stop_gradient(highest))

    def surplus(r: Batch) -> Batch:
        xi = m / r
        per_r = m * (1 - xi) ** 3
        u = r * per_r
        return c * (1 - xi) ** 4 / (1 + xi) * (1 - u) - r**2 * (1 - xi) ** 3 * _h(u, xi)

    r = root(surplus, m / peak, jnp.sqrt(c), _start(c, m, peak), steps=3)
    return m / r, reached


def _left_over(v: Batch, per_xi: Batch, xi: Batch) -> Batch:
    """What is left of (16a) at $v = u/\\xi$ [-], `per_xi` $b/\\xi$ [-] and `xi` [-]."""
    return per_xi / (xi * per_xi + _h(xi * v, xi)) - v


def _undivided(v: Batch, per_xi: Batch, xi: Batch) -> Batch:
    """The same times its denominators [-]: slower to converge, but a step costs less."""
    w = 1 - xi * v
    opened = 1 - w * xi
    return per_xi * opened * w - v * jnp.sqrt(1 - w * (xi / (2 - xi)))


def _h(u: Batch, xi: Batch) -> Batch:
    w = 1 - u
    return jnp.sqrt(1 - w * xi / (2 - xi)) / (1 - w * xi)


def _start(c: Batch, m: Batch, peak: Batch) -> Batch:
    """$r$ [-] with $h = 1$: the end of small $\\xi$, then one Newton step in logarithms."""
    g = jnp.maximum(m, 1e-100) ** 2  # no moment, no compression: but still their ratio
    small = 0.5 * (g + jnp.sqrt(g * (g + 4 / c)))
    xi = -jnp.expm1(-jnp.log1p(3 * small) / 3)
    per_xi = c * (1 - xi) ** 4 / (1 + xi)
    b = xi * per_xi
    short = jnp.log((1 + b) * g * (1 - xi) ** 3 / (xi * b))
    rise = 1 + (1 - 4 * xi / (1 - xi) - xi / (1 + xi)) / (1 + b) + 3 * xi / (1 - xi)
    return jnp.sqrt(g) / jnp.minimum(xi * jnp.exp(jnp.clip(short / rise, -1.0, 0.3)), peak)


def _peak(c: Batch) -> Batch:
    """The $\\xi$ [-] at which $\\hat m$ is largest, at slenderness `c` [-]."""
    low, high = np.log(_LEAST), np.log(_MOST)
    x = (2 * jnp.log(jnp.clip(jax.lax.stop_gradient(c), _LEAST, _MOST)) - low - high) / (high - low)
    # Clenshaw's recurrence
    last, before = jnp.zeros_like(x), jnp.zeros_like(x)
    for term in _series()[:0:-1]:
        last, before = 2 * x * last - before + term, last
    return x * last - before + _series()[0]


@cache
def _series() -> tuple[float, ...]:
    """Coefficients of the peak's place [-] over ln c, by golden sections at Chebyshev's points."""
    x = chebyshev.chebpts1(_TERMS)
    c = np.sqrt(_LEAST * _MOST) * (_MOST / _LEAST) ** (x / 2)

    def height(xi: np.ndarray) -> np.ndarray:
        b, u = c * xi * (1 - xi) ** 4 / (1 + xi), np.ones_like(xi)
        for _ in range(40):
            h = np.sqrt(1 - (1 - u) * xi / (2 - xi)) / (1 - (1 - u) * xi)
            u = b / (b + h)
        return xi * u / (1 - xi) ** 3

    low, high, ratio = np.zeros_like(c), np.full_like(c, 1 - 1e-6), (np.sqrt(5) - 1) / 2
    for _ in range(36):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        falls = height(left) >= height(right)
        low, high = np.where(falls, low, left), np.where(falls, right, high)
    return tuple(chebyshev.chebfit(x, (low + high) / 2, _TERMS - 1).tolist())

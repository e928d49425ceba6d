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
the ends meet. Given $\hat m$, (16b) says $u$, and (16a) is one equation for
$\tau = \xi/\kappa$ with $\kappa = \hat m/\sqrt c$, the compression of a small moment,

$$(1 - \xi)\, \tau \hat g\, (1 - \kappa \hat g) = (1 + \xi)\, h, \qquad
  \hat g = \frac{w \xi}{\kappa} = \tau - c \kappa (1 - \xi)^3, \tag{16c}$$

in which $\tau$ tends to 1 as the moment vanishes: no root is nested in another.

**Speed:** the steps of (16a) are few and fixed, from a start whose error is known, so that one
pass over the points does them all; divisions and roots cost as much as ten products. The peak's
place is a Chebyshev series in $1/(1 + \sqrt[4]{c})$, fitted when first asked for.
**Source:** Kim, Mazzoleni and Bryant (2021), (10)-(16), rearranged here.
"""

from functools import cache

import numpy as np
from numpy.polynomial import chebyshev

from ...core.array_namespace import chebyshev_sum, maximum, minimum, sqrt, where
from ...core.roots import root, stop_gradient
from ...core.types import Batch, BatchLike, BoolBatch


_LEAST, _MOST = 0.1, 1e5  # slenderness c: outside, the peak is taken where it is at the end
_TERMS = 16  # of the peak's series: its place to 6e-6, and so its height to 1e-8 of itself
_NOTHING = 1e-100  # no moment, no compression: but still their ratio
_EARLY = 0.25  # a compression well before any peak


def unshortened(c: BatchLike, xi: BatchLike) -> Batch:
    """$u/\\xi$ [-] at slenderness `c` [-] and compression `xi` [-]; finite as it vanishes.

    To rounding for $\\xi \\le 0.9$, to 1e-13 up to 0.999.
    """
    per = 1 / ((1 + xi) * (2 - xi))
    per_xi, share = c * (1 - xi) ** 4 * (2 - xi) * per, (1 + xi) * per
    # h is 1/ρ where b = 0, and 1 where b is large; between, the numbers are fitted to 2.4 % of
    # y = u/b, of which one step of Halley's leaves 3e-5, two rounding
    b, x = stop_gradient(xi * per_xi), stop_gradient(xi)
    rho = sqrt(0.5 * (1 - x) * (2 - x))
    under = rho + b * (0.51 + 0.755 * rho + 2.293 * b)
    y = under / (b * under + 1 + b * (1.825 - 0.615 * rho + 2.293 * b))
    for _ in range(2):  # here derivatives go along, right up to the third
        y = _nearer(xi * per_xi, xi, share, y)
    return per_xi * y


def _nearer(b: BatchLike, xi: BatchLike, share: BatchLike, y: BatchLike) -> Batch:
    """One step of Halley's from $y = u/b$ [-] for the squares of both sides of (16a), over $b^2$:
    without $h$ there is no root to draw, and one division. `share` is $1/(2 - \\xi)$ [-].
    """
    w = 1 - b * y
    g, bend = xi * w, b * xi
    opens, squared = (1 - g) * w, 1 - g * share
    rise, turn = b * (2 * g - 1), share * bend  # slopes in y of `opens` and `squared`
    value = opens**2 - y**2 * squared
    slope = opens * rise - y * (squared + 0.5 * y * turn)  # half of it, and of its own slope
    curve = rise**2 - 2 * b * bend * opens - squared - 2 * y * turn
    return y - 2 * value * slope / (4 * slope**2 - value * curve)


def left_over(per_xi: BatchLike, xi: BatchLike, v: BatchLike) -> tuple[Batch, Batch]:
    """What is left of (16a) times its denominators at $v = u/\\xi$ [-], and its slope in $v$ [-].

    `per_xi` is $b/\\xi$ [-], at compression `xi` [-].
    """
    w, g, share, squared = _opened(xi, v)
    per_h = 1 / sqrt(squared)
    h = squared * per_h
    return per_xi * (1 - g) * w - v * h, (
        per_xi * xi * (g - (1 - g)) - h - 0.5 * share * v * xi**2 * per_h
    )


def left_over_slope(per_xi: BatchLike, fall: BatchLike, xi: BatchLike, v: BatchLike) -> Batch:
    """Its slope [-] in `xi` [-], where $v$ [-] is held, at $b/\\xi$ of `per_xi` [-], whose own
    slope is `fall` [-].
    """
    w, g, share, squared = _opened(xi, v)
    g_slope = 1 - 2 * xi * v
    return (
        fall * (1 - g) * w
        - per_xi * (g_slope * w + (1 - g) * v)
        + (0.5 * v * share * (g_slope + g * share) * (1 / sqrt(squared)))
    )


def _opened(xi: BatchLike, v: BatchLike) -> tuple[Batch, Batch, Batch, Batch]:
    """$w$, $w \\xi$, $1/(2 - \\xi)$, and the square of $h$ times $1 - w \\xi$ [-]."""
    w = 1 - xi * v
    g, share = xi * w, 1 / (2 - xi)
    return w, g, share, 1 - g * share


def moment(c: BatchLike, xi: BatchLike) -> Batch:
    """$\\hat m$ [-] at slenderness `c` [-] and compression `xi` [-], (16b)."""
    return xi * sqrt(unshortened(c, xi) / (1 - xi) ** 3)


def compression_at_moment(c: BatchLike, target: BatchLike) -> tuple[Batch, BoolBatch]:
    """First $\\xi$ [-] whose $\\hat m$ is `target` [-] at slenderness `c` [-], and whether
    there is one; where there is none, that of half the peak.
    """
    peak = _peak(c)
    # at the peak's place (16c) says whether the moment there is larger than what is asked for
    asked = maximum(stop_gradient(target), _NOTHING) / sqrt(stop_gradient(c))
    reached = _short_of((stop_gradient(c), asked), peak / asked)[0] <= 0
    m = where(reached, target, _early_moment(stop_gradient(c)))
    kappa = m / sqrt(c)
    some = maximum(stop_gradient(m), _NOTHING) / sqrt(stop_gradient(c))
    start = _compressed(stop_gradient(c), stop_gradient(m), peak) / some
    return kappa * root(_short_of, (c, kappa), 1.0, peak / some, start), reached


def _short_of(theta: tuple, tau: Batch) -> tuple[Batch, Batch]:
    """What (16c) is short of at $\\tau$, and its slope, both times $h$: divisions count."""
    c, kappa = theta
    xi = kappa * tau
    free, share = 1 - xi, 1 / (2 - xi)
    bowed = c * kappa * free**2
    g_hat, g_slope = tau - bowed * free, 1 + 3 * kappa * bowed
    g = kappa * g_hat
    squared = 1 - g * share
    h, held = sqrt(squared), tau * g_hat
    rise = (1 - g) * (free * (g_hat + tau * g_slope) - kappa * held) - g_slope * kappa * free * held
    turn = squared - 0.5 * (1 + xi) * share * (g_slope + g * share)
    return (1 + xi) * squared - free * (1 - g) * held * h, kappa * turn - rise * h


def _compressed(c: Batch, m: Batch, peak: Batch) -> Batch:
    """About $\\xi$ [-]: the end of small $\\xi$, then Newton steps of (16a) times its denominators,
    with $h$ as it is for $b$ at the place before; near the peak they are kept short.
    """
    g = maximum(m, _NOTHING) ** 2
    small = 0.5 * (g + sqrt(g * (g + 4 / c)))
    xi = minimum(small / (1 + 2 * small), peak)  # of 1 - 1/cbrt(1 + 3 small)
    for _ in range(2):
        free = 1 - xi
        cubed = c * free**3
        b = cubed * free * xi
        held = xi * (1 + xi) / (1 + xi + b)  # w ξ
        h = (1 - 0.5 * held / (2 - xi)) / (1 - held)
        value = c * xi**2 * free - g * (h * (1 + xi) + b)
        slope = c * xi * (2 - 3 * xi) - g * (h + cubed * (1 - 5 * xi))
        step = value / where(slope > 0, slope, 1.0)
        new = minimum(maximum(xi - step, 0.3 * xi), minimum(1.5 * xi, peak))
        xi = where(slope > 0, new, peak)
    return xi


def _early_moment(c: Batch) -> Batch:
    """A moment that is surely reached [-]: of a compression before the peak, and too low."""
    xi, per_xi = _EARLY, c * (1 - _EARLY) ** 4 / (1 + _EARLY)
    # 1.5 is more than h, which is at most 1/(1 - ξ), and so leaves too little that bows
    return 0.5 * xi * sqrt(per_xi / (1.5 + xi * per_xi) / (1 - xi) ** 3)


def _peak(c: BatchLike) -> Batch:
    """The $\\xi$ [-] at which $\\hat m$ is largest at slenderness `c` [-], without derivatives."""
    low, high = _short(_MOST), _short(_LEAST)
    x = (2 * _short(minimum(maximum(stop_gradient(c), _LEAST), _MOST)) - low - high) / (high - low)
    return chebyshev_sum(_series(), x)


def _short(c: Batch) -> Batch:
    return 1 / (1 + sqrt(sqrt(c)))


@cache
def _series() -> tuple[float, ...]:
    """Series of the peak's place [-], by ever finer grids at Chebyshev's points."""
    x = chebyshev.chebpts1(_TERMS)
    low, high = _short(_MOST), _short(_LEAST)
    c = (2 / (low + high + (high - low) * x) - 1) ** 4
    left, right = np.full_like(c, 0.4), np.full_like(c, 0.96)
    for _ in range(5):  # each 16 times finer: to 1e-7
        xi = left + (right - left) * np.linspace(0, 1, 33)[:, None]
        v = unshortened(c, xi)
        for _ in range(2):  # it is near the end that they are needed
            value, slope = left_over(c * (1 - xi) ** 4 / (1 + xi), xi, v)
            v = v - value / slope
        best, step = np.argmax(xi**2 * v / (1 - xi) ** 3, axis=0), (right - left) / 32
        left, right = left + (best - 1) * step, left + (best + 1) * step
    return tuple(chebyshev.chebfit(x, (left + right) / 2, _TERMS - 1).tolist())

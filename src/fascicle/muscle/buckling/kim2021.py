r"""Post-buckling, the paper's law: how a muscle resists when pushed past its free strain.

Compressed by $x = (\varepsilon - \varepsilon_f) L_0$ from its length $L_{fs}$ at free
strain, the bladder bows out between its clamped ends, $y = \tfrac12 y_{max} (\cos(2\pi z/L) - 1)$
with $L = L_{fs} - x$. If its axis kept its length,

$$y_{max} = \frac{\sqrt{4 x (L_{fs} - x)}}{\pi}, \qquad
  F_b = \frac{4 \pi^2 E I (L_{fs} + x)}{(L_{fs} - x)^3}. \tag{10, 12}$$

The axis shortens by $2l$ (equivalent springs, (13)-(16), closed by (10) with the
shortened arc [R5]). With $\xi = x/L_{fs}$ and $w = 2l/x$,

$$w = \frac{a h}{1 + a h}, \quad a = \frac{F_b}{E A \xi (1 - \xi)}, \quad
  h(w) = \frac{\sqrt{1 - w \xi/(2 - \xi)}}{1 - w \xi}, \quad
  F'_b = E A \xi w \frac{1 - \xi}{1 - \xi w}, \tag{16}$$

and the mesh, which follows the arc, pulls with its force at
$\varepsilon_{arc} = \varepsilon_f + 2l/L_0$. $F'_b$ opposes contraction [R6]:

$$F = F'_{mesh} + F_{bladder}(\varepsilon_f) - F'_b. \tag{27}$$

In two numbers: a column of fixed mode shape, compressed by $\xi$ of its free length, knows its
slenderness $c = EA L_{fs}^2/(4\pi^2 EI)$ and nothing else of the muscle. With $b = 1/a$ of (16),

$$b = c\, \xi \frac{(1 - \xi)^4}{1 + \xi}, \qquad
  u = 1 - w = \frac{b}{b + h(u)}, \qquad
  h = \frac{\sqrt{1 - w \xi/(2 - \xi)}}{1 - w \xi}, \tag{16a}$$

so that no modulus is left in the share $u$ of the compression that bows the column, and
its largest moment is

$$\hat m = \frac{M_b L_{fs}}{4 \pi EI} = \sqrt{\xi u}\, (1 - \xi)^{-3/2}. \tag{16b}$$

It rises with $\xi$ to one peak, at a $\xi$ that depends on $c$ alone, and falls to zero where
the ends meet. Given $\hat m$, (16b) says $u$, and (16a) is one equation for
$\tau = \xi/\kappa$ with $\kappa = \hat m/\sqrt c$, the compression of a small moment,

$$(1 - \xi)\, \tau \hat g\, (1 - \kappa \hat g)
  = (1 + \xi) \sqrt{1 - \kappa \hat g/(2 - \xi)}, \qquad
  \hat g = \frac{w \xi}{\kappa} = \tau - c \kappa (1 - \xi)^3, \tag{16c}$$

in which $\tau$ tends to 1 as the moment vanishes: no root is nested in another.

**Sign:** tension positive. **Valid for** $\varepsilon \ge \varepsilon_f$.
**Assumes** the first mode's shape, small slopes; against the exact elastica (12) is 1.4
times too stiff at $\xi = 0.1$, twice at 0.2. **Source:** Kim, Mazzoleni and Bryant (2021), 3.2,
(8)-(16); (16a) to (16c) rearranged here.
"""

from typing import ClassVar

import numpy as np
from numpy.polynomial.chebyshev import chebval

from ...core.array_namespace import array_namespace, sqrt, where
from ...core.roots import root, stop_gradient
from ...core.types import Batch, BatchLike, BoolBatch
from . import BRAID_SHARE, SHEAR, AbstractBuckling, BucklingColumn, Push


_LEAST, _MOST = 0.1, 1e5  # slenderness c: outside, the peak of the nearer end is taken
_TINY_MOMENT = 1e-100  # instead of none: the ratio of compression to moment stays finite
# Chebyshev series of the peak's compression in 1/(1 + c^(1/4)), fitted to a search on ever finer
# grids: right to 6e-6, and so the peak's height to 1e-8 of itself (a test checks it)
_PEAK_SERIES = (
    0.64266812, -0.21418739, 0.08224031, -0.00212971, -0.01147222, 0.00214270, 0.00213243,
    -0.00074331, -0.00045913, 0.00024879, 0.00010188, -0.00008287, -0.00002187, 0.00002835,
    0.00000410, -0.00001198,
)  # fmt: skip


class Kim2021(AbstractBuckling):
    """The paper's law: a fixed mode shape and equivalent springs, equations (8)-(16)."""

    name: ClassVar[str] = "kim2021"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021)"

    braid_share: Batch = BRAID_SHARE.field()
    shear: str = SHEAR.field()

    def branch(self, column: BucklingColumn) -> Batch:
        """The bladder's force at the free strain [N], at which no ends yield."""
        tension = column.tension
        strain = column.free_strain * tension.strain_ratio
        return tension.bladder_pull(column.pressure, strain).bladder

    def push(self, column: BucklingColumn, strain: BatchLike) -> Push:
        """Components of the force [N], negative where it pushes, at `strain` [-], (16) and (27)."""
        eps_f, EA = column.free_strain, column.axial_stiffness
        xi = (strain - eps_f) / (1 - eps_f)  # x/L_fs
        v = bow_ratio(_slenderness(column), xi)  # (16a)
        shortening = xi * (1 - xi * v)  # ξ w = 2l/L_fs
        arc = eps_f + shortening * (1 - eps_f)
        pull = column.pull(arc)
        bending = -EA * shortening * (1 - xi) / (1 - shortening)  # -F'_b of (16)
        growth = shortening_slope(xi, v)
        stiffening = growth * (1 - xi) / (1 - shortening) ** 2 - shortening / (1 - shortening)
        return Push(
            mesh=pull.mesh,
            bladder=column.branch + 0.0 * shortening,
            bending=bending,
            slope=pull.mesh_slope * growth - EA * stiffening / (1 - eps_f),
            arc_strain=arc,
            straight=shortening < -np.inf,  # never
        )

    def bow(self, column: BucklingColumn, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection [m], (10) with the shortened arc, and moment [N·m] at `strain` [-]."""
        eps_f = column.free_strain
        xi = (strain - eps_f) / (1 - eps_f)
        v = bow_ratio(_slenderness(column), xi)
        y_max = 2 / np.pi * column.free_length * xi * sqrt(v * (1 - xi))
        return y_max, _moment_unit(column) * xi * sqrt(v / (1 - xi) ** 3)

    def onset(self, column: BucklingColumn) -> Batch:
        """Free strain [-]: the law lets the bladder bow at once."""
        return column.free_strain

    def strain_at_moment(self, column: BucklingColumn, moment: BatchLike) -> Batch:
        """First strain [-] at which $M_b$ reaches `moment` [N·m]; inf if it never does [R7]."""
        xi, exists = compression_at_moment(_slenderness(column), moment / _moment_unit(column))
        return where(exists, column.free_strain + xi * (1 - column.free_strain), np.inf)


def _slenderness(column: BucklingColumn) -> Batch:
    """Slenderness $c = EA L_{fs}^2/(4\\pi^2 EI)$ [-]."""
    EA, EI = column.axial_stiffness, column.bending_stiffness
    return EA * column.free_length**2 / (4 * np.pi**2 * EI)


def _moment_unit(column: BucklingColumn) -> Batch:
    """Unit of $\\hat m$, $4\\pi EI/L_{fs}$ [N·m]."""
    return 4 * np.pi * column.bending_stiffness / column.free_length


def bow_ratio(c: BatchLike, xi: BatchLike) -> Batch:
    """Ratio $u/\\xi$ [-] of the share that bows the column to the compression, at slenderness `c`
    [-] and compression `xi` [-], (16a).
    """
    # b and u vanish with ξ: of b/ξ and of y = u/b no digit is lost there
    per_xi = c * (1 - xi) ** 4 / (1 + xi)
    b = xi * per_xi
    return per_xi * root(_share_residual, (b, xi), 0.0, 1.0, 1 / (1 + b))


def _share_residual(theta: tuple, y: Batch) -> tuple[Batch, Batch]:
    """Residual of (16a), $1 - y (b + h)$, at $y = u/b$ [-], and its slope."""
    b, xi = theta
    w = 1 - b * y
    h = sqrt(1 - w * xi / (2 - xi)) / (1 - w * xi)
    h_slope = h * xi * (1 / (1 - w * xi) - 0.5 / (2 - xi - w * xi))
    return 1 - y * (b + h), b * y * h_slope - (b + h)


def shortening_slope(xi: BatchLike, v: BatchLike) -> Batch:
    """Slope of the shortening $\\xi w$ in the compression `xi` [-]; `v`: `bow_ratio` there [-]."""
    # u' from the slopes of ln b + ln w - ln u = ln h, (16a), times u, which vanishes with ξ
    u = xi * v
    w = 1 - u
    g, inverse = xi * w, 1 / (2 - xi)
    half = 0.5 * inverse / (1 - g * inverse)
    by_g = 1 / (1 - g) - half  # of ln h
    rise = v * (1 - xi * (5 + 3 * xi) / (1 - xi**2)) + u * (half * g * inverse - by_g * w)
    return w * (1 - xi * rise / (1 - by_g * u * g))


def compression_at_moment(c: BatchLike, target: BatchLike) -> tuple[Batch, BoolBatch]:
    """First compression [-] of a reduced moment `target` [-] at slenderness `c` [-], if any."""
    fixed_c, fixed_target = stop_gradient(c), stop_gradient(target)
    xp = array_namespace(c, target)
    root_c = sqrt(fixed_c)
    peak = _peak_compression(fixed_c)
    # at the peak's compression (16c) says whether the moment there is larger than the target
    scale = xp.maximum(fixed_target, _TINY_MOMENT) / root_c
    exists = _residual_of_tau((fixed_c, scale), peak / scale)[0] <= 0
    m = where(exists, target, 0.0)
    kappa = m / sqrt(c)
    fixed_m = xp.maximum(stop_gradient(m), _TINY_MOMENT)
    high = peak * root_c / fixed_m
    return kappa * root(_residual_of_tau, (c, kappa), 1.0, high, 1.0 + 0.0 * high), exists


def _residual_of_tau(theta: tuple, tau: Batch) -> tuple[Batch, Batch]:
    """Right side of (16c) less its left at $\\tau$ [-], and its slope."""
    c, kappa = theta
    xi = kappa * tau
    g_hat, g_slope = tau - c * kappa * (1 - xi) ** 3, 1 + 3 * c * kappa**2 * (1 - xi) ** 2
    g = kappa * g_hat  # w ξ
    h = sqrt(1 - g / (2 - xi))
    left, right = (1 - xi) * tau * g_hat * (1 - g), (1 + xi) * h
    left_slope = (1 - xi) * (1 - g) * (g_hat + tau * g_slope)
    left_slope = left_slope - kappa * tau * g_hat * (1 - g + (1 - xi) * g_slope)
    h_slope = -kappa * (g_slope + g / (2 - xi)) / (2 * h * (2 - xi))
    return right - left, kappa * h + (1 + xi) * h_slope - left_slope


def _peak_coordinate(c: BatchLike) -> Batch:
    """Variable $1/(1 + c^{1/4})$ [-] of `_PEAK_SERIES` at slenderness `c` [-]."""
    return 1 / (1 + sqrt(sqrt(c)))


_LOW, _HIGH = _peak_coordinate(_MOST), _peak_coordinate(_LEAST)


def _peak_compression(c: BatchLike) -> Batch:
    """Compression $\\xi$ [-] of the largest moment at slenderness `c` [-]."""
    xp = array_namespace(c)
    z = _peak_coordinate(xp.minimum(xp.maximum(c, _LEAST), _MOST))
    return chebval((2 * z - _LOW - _HIGH) / (_HIGH - _LOW), _PEAK_SERIES)

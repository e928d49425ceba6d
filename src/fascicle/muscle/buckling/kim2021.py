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

It rises with $\xi$ to one peak and falls to zero where the ends meet. Given $\hat m$, (16b) says
$u$, and (16a) the slenderness at which this moment is reached at $\xi$,

$$c(\xi) = \frac{(1 + \xi) \hat m^2 \sqrt{1 - g/(2 - \xi)}}{\xi g (1 - \xi) (1 - g)}, \qquad
  g = w \xi = \xi - \hat m^2 (1 - \xi)^3. \tag{16c}$$

A more slender column reaches it, first at a smaller $\xi$, a stubbier one than the least $c(\xi)$
never does. At a small moment the compression is $\kappa = \hat m/\sqrt c$: with
$\tau = \xi/\kappa$,

$$(1 - \xi)\, \tau \hat g\, (1 - \kappa \hat g)
  = (1 + \xi) \sqrt{1 - \kappa \hat g/(2 - \xi)}, \qquad
  \hat g = \frac{g}{\kappa} = \tau - c \kappa (1 - \xi)^3, \tag{16d}$$

is (16c) in a variable that tends to 1 as the moment vanishes. There two roots in $\xi$ meet, and
the slope would be lost.

**Sign:** tension positive. **Valid for** $\varepsilon \ge \varepsilon_f$.
**Assumes** the first mode's shape, small slopes; against the exact elastica (12) is 1.4
times too stiff at $\xi = 0.1$, twice at 0.2. **Source:** Kim, Mazzoleni and Bryant (2021), 3.2,
(8)-(16); (16a) to (16d) rearranged here.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import maximum, sqrt, where
from ...core.roots import find_root, root, stop_gradient
from ...core.types import Batch, BatchLike, BoolBatch
from . import BRAID_SHARE, SHEAR, AbstractBuckling, BucklingColumn, Push


_TINY_MOMENT = 1e-100  # instead of none: the ratio of compression to moment stays finite


class Kim2021(AbstractBuckling):
    """The paper's law: a fixed mode shape and equivalent springs, equations (8)-(16)."""

    name: ClassVar[str] = "kim2021"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021)"

    braid_share: Batch = BRAID_SHARE.field()
    shear: str = SHEAR.field()

    def branch(self, column: BucklingColumn) -> Batch:
        """The bladder's force at the free strain [N], at which no ends yield."""
        tension = column.tension
        return tension.bladder_pull(column.free_strain * tension.strain_ratio).bladder

    def push(self, column: BucklingColumn, strain: BatchLike) -> Push:
        """Components of the force [N], negative where it pushes, at `strain` [-], (16) and (27)."""
        eps_f, EA = column.free_strain, column.axial_stiffness
        xi = (strain - eps_f) / (1 - eps_f)  # x/L_fs
        v = bow_ratio(_slenderness(column), xi)
        s, s_slope = xi * (1 - xi * v), shortening_slope(xi, v)  # 2l/L_fs = ξ w
        arc = eps_f + s * (1 - eps_f)
        pull = column.pull(arc)
        cos, cos_slope = (1 - xi) / (1 - s), (s_slope * (1 - xi) / (1 - s) - 1) / (1 - s)  # (14)
        F_b = EA * s * cos  # 2 k2 l cos θ's, (16)
        F_b_slope = EA * (s_slope * cos + s * cos_slope) / (1 - eps_f)
        free_bladder_force = column.branch
        return Push(
            mesh=pull.mesh,
            bladder=free_bladder_force + 0.0 * s,
            bending=-F_b,
            slope=pull.mesh_slope * s_slope - F_b_slope,
            arc_strain=arc,
            straight=s < -np.inf,  # never
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
    peak, least = _peak(fixed_target)
    exists = least <= fixed_c
    m = where(exists, target, 0.0)
    kappa = m / sqrt(c)
    fixed_m = maximum(where(exists, fixed_target, 0.0), _TINY_MOMENT)
    high = peak * sqrt(fixed_c) / fixed_m
    return kappa * root(_residual_of_tau, (c, kappa), 1.0, high, 1.0 + 0.0 * high), exists


def _peak(target: BatchLike) -> tuple[Batch, Batch]:
    """Compression [-] at which the slenderness (16c) of a moment `target` [-] is least, and it."""
    m2 = target**2
    xi = find_root(_peak_residual, m2, 0.0, 1.0, 0.5 + 0.0 * m2)
    g = xi - m2 * (1 - xi) ** 3
    return xi, (1 + xi) * m2 * sqrt(1 - g / (2 - xi)) / (xi * g * (1 - xi) * (1 - g))


def _peak_residual(m2: Batch, xi: Batch) -> tuple[Batch, Batch]:
    """Fall of ln c, (16c), with $\\xi$, times g, which is regular where g vanishes; its slope."""
    g, g_slope, g_bend = xi - m2 * (1 - xi) ** 3, 1 + 3 * m2 * (1 - xi) ** 2, -6 * m2 * (1 - xi)
    exists = g > 0  # below, no slenderness gives the moment
    g = where(exists, g, 0.5)
    a, b, g_1 = 2 - xi - g, 2 - xi, g_slope / (1 - g)
    rise = 0.5 / b - 0.5 * (1 + g_slope) / a + 1 / (1 + xi) - 1 / xi + 1 / (1 - xi) + g_1
    rise_slope = 0.5 / b**2 - 0.5 * g_bend / a - 0.5 * ((1 + g_slope) / a) ** 2
    rise_slope = rise_slope - 1 / (1 + xi) ** 2 + 1 / xi**2 + 1 / (1 - xi) ** 2
    rise_slope = rise_slope + g_bend / (1 - g) + g_1**2
    value, slope = g_slope - g * rise, g_bend - g_slope * rise - g * rise_slope
    return where(exists, value, 1.0), where(exists, slope, 0.0)


def _residual_of_tau(theta: tuple, tau: Batch) -> tuple[Batch, Batch]:
    """Right side of (16d) less its left at $\\tau$ [-], and its slope."""
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

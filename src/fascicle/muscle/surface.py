r"""A muscle as a table of its co-energy, from which force and volume both follow.

A simulation evaluates a muscle thousands of times a second. A `UnitSurface` holds its co-energy
$\Pi^*$, (V2), on a grid, and between the grid's nodes as a bicubic polynomial whose value and
slopes are continuous,

$$F = \frac{1}{L_0} \frac{\partial \Pi^*}{\partial \varepsilon}, \qquad
  V^* = \frac{\partial \Pi^*}{\partial P}. \tag{V3}$$

Both come from one table, so that no cycle of pressure and strain makes energy, however coarse
the grid is: its error, which it states, is one of the law, not of the balance.

Lines of the grid are even in $\sqrt{P}$, since a muscle changes most at low pressure; within the
first of them the polynomial is one of $P$. Below $P = 0$ and above the table's end $\Pi^*$ goes on
linearly, $F(P) = F(0) + P\,\partial V^*/\partial x$ with $x = L_0 \varepsilon$, as of a fluid that
sucks; beyond the ends in strain, too.

**Source:** derived here; Hermite's bicubic: de Boor (1962).
"""

import math
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import absolute, array_namespace, maximum, minimum, sqrt, where
from ..core.errors import InvalidInputError
from ..core.module import Module, to_numpy
from ..core.types import Batch, Numbers, Values
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN, check_interval
from .coenergy import coenergy_at_rest, integrate_force
from .muscle import Muscle
from .piecewise import PressurizedMuscle
from .validation import lowest_strain


# share of the strain of straight fibers, near which the bladder stiffens beyond any grid
_LOWEST_SHARE = 0.75
_PUSH_STRAIN = 0.08  # past the strain at which no braid pulls: how far a load may push one
# Pa: a pressure is solved for to some 1e-9 Pa, so that a vented unit may be that far below zero.
# Its volume keeps the slope at zero there, or the first step of filling would go without one
PRESSURE_ROUNDING = 1e-6
_POINTS = 5  # of Gauss's rule, in short cells: 1e-12
# slope by values at five pressures from a node on, 3 Pa apart: rounding and order leave 1e-9 of it
_PRESSURE_STEP = 3.0
_FORWARD = np.array([-25, 48, -36, 16, -3]) / (12 * _PRESSURE_STEP)
# cubic Hermite: values at both ends, then slopes, to coefficients of rising powers
_HERMITE = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [-3, 3, -2, -1], [2, -2, 1, 1]], float)


class Surface(NamedTuple):
    """One muscle at a pressure and strain: co-energy [J], force [N], conjugate volume [m³], and
    their slopes: of the force in strain [N] and pressure [m²], of the volume in pressure [m³/Pa].
    """

    coenergy: Batch
    force: Batch
    volume: Batch
    force_by_strain: Batch
    force_by_pressure: Batch
    volume_by_pressure: Batch


class UnitSurface(Module):
    """A muscle's co-energy on a grid, (V3), from `UnitSurface.tabulate(muscle)`.

    `coefficients`: of the powers of both cell coordinates [J], cells first; `root_step`: between
    lines of pressure [√Pa]; `strains`: the table's ends [-]; `rest_length` [m]; `errors`: of its
    force against the law's, at the middles of all cells: median, 99 % and largest [N].
    """

    coefficients: Numbers
    root_step: Batch
    strains: tuple[Batch, Batch]
    rest_length: Batch
    errors: tuple[float, float, float]

    @classmethod
    def tabulate(
        cls,
        muscle: Muscle,
        highest_pressure: Values = HIGHEST_PRESSURE,
        strains: tuple[float, float] | None = None,
        shape: tuple[int, int] = (161, 201),
    ) -> "UnitSurface":
        """Tabulate a muscle's co-energy.

        **Arguments:**

        - `muscle`: one muscle, of numbers.
        - `highest_pressure`: the table's end [Pa], up to 1 MPa.
        - `strains`: its ends [-]; default: from 0.75 of the strain that straightens the fibers
          to 0.08 past the one at which no pressure pulls. The lower one is lowered by less than
          a step, so that zero strain is a node.
        - `shape`: numbers of nodes in pressure and in strain [-], at least 3 each.

        **Returns:** the table.

        **Raises:** `ValueError` for impossible ends and shapes.
        """
        top = check_interval(
            highest_pressure, 0.0, HIGHEST_PRESSURE, "highest_pressure", "Pa", closed=(False, True)
        )
        if len(shape) != 2 or min(shape) < 3:
            raise InvalidInputError("shape", "must be two whole numbers of at least 3", shape)
        strain = _strain_nodes(muscle, strains, int(shape[1]))
        roots = np.linspace(0.0, math.sqrt(float(top)), int(shape[0]))
        return _build_surface(to_numpy(muscle), tuple(roots.tolist()), tuple(strain.tolist()))

    @property
    def highest_pressure(self) -> Batch:
        """The table's end [Pa]."""
        return (self.root_step * self.coefficients.shape[-4]) ** 2

    def lookup_at(self, pressure: Batch, strain: Batch, index: Any = None) -> Surface:
        """Co-energy [J], force [N], volume [m³] and slopes at `pressure` [Pa] and `strain` [-],
        elementwise, without checks; `index`: of the muscle in a table of several.
        """
        xp = array_namespace(pressure, strain, self.coefficients)
        lines, columns = self.coefficients.shape[-4:-2]
        h, (low, high) = self.root_step, self.strains
        step = (high - low) / columns

        pressure, strain = xp.asarray(pressure), xp.asarray(strain)
        P = minimum(maximum(pressure, 0.0), self.highest_pressure)
        # a root has no slope at zero, where the first cell doesn't ask for it
        s = sqrt(where(h**2 < P, P, h**2))
        i = minimum(xp.floor(s / h), lines - 1.0)
        i = xp.where(h**2 < P, i, 0.0).astype(int)
        first = i == 0
        u = where(first, P / h**2, s / h - i)
        u_P = where(first, 1 / h**2, 1 / (2 * s * h))
        u_PP = where(first, 0.0, -1 / (4 * s**3 * h))

        eps = minimum(maximum(strain, low), high)
        j = minimum(xp.floor((eps - low) / step), columns - 1.0).astype(int)
        w = (eps - low) / step - j

        cell = (i, j) if index is None else (index, i, j)
        c = xp.asarray(self.coefficients)[cell]  # [..., power of u, power of w]
        value, slope, bend = _cubic(c, w[..., None])  # in w, for each power of u
        p, p_u, p_uu = _cubic(value, u)
        p_w, p_wu, _ = _cubic(slope, u)
        p_ww, _, _ = _cubic(bend, u)

        P_past, eps_past = pressure - P, strain - eps  # linear past the table's ends
        inside_P = absolute(P_past) <= PRESSURE_ROUNDING
        V, V_w = p_u * u_P, p_wu * u_P
        L0 = self.rest_length
        return Surface(
            coenergy=p + V * P_past + (p_w + V_w * P_past) * eps_past / step,
            force=(p_w + V_w * P_past) / (step * L0),
            volume=V + V_w * eps_past / step,
            force_by_strain=where(eps_past == 0, p_ww / (step**2 * L0), 0.0),
            force_by_pressure=V_w / (step * L0),
            volume_by_pressure=where(inside_P, p_uu * u_P**2 + p_u * u_PP, 0.0),
        )

    def force(self, pressure: Values, strain: Values) -> Batch:
        """Pulling force of one muscle $F$ [N], (V3), at `pressure` [Pa], from -101325 Pa, and
        `strain` [-], which broadcast; `ValueError` for concrete values outside the table.
        """
        return self.lookup_at(*self.validate_point(pressure, strain)).force

    def conjugate_volume(self, pressure: Values, strain: Values) -> Batch:
        """Volume $V^*$ [m³], (V3), at `pressure` [Pa] and `strain` [-], as `force`."""
        return self.lookup_at(*self.validate_point(pressure, strain)).volume

    def validate_point(self, pressure: Values, strain: Values) -> tuple[Batch, Batch]:
        """Return `pressure` [Pa] and `strain` [-] as floats if they lie in the table."""
        low, high = (float(x) for x in self.strains)
        why, closed = "of the table", (True, True)
        top = float(self.highest_pressure) * (1 + 1e-12)  # a rounding of its root
        remedy = "tabulate the muscle up to there"
        P = check_interval(pressure, -101325.0, top, "pressure", "Pa", why, closed, remedy)
        return P, check_interval(strain, low, high, "strain", "-", why, closed, remedy)


def _cubic(c: Numbers, x: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Value, slope and second derivative at `x` of cubics with coefficients on the last axis."""
    c0, c1, c2, c3 = (c[..., k] for k in range(4))
    value = ((c3 * x + c2) * x + c1) * x + c0
    return value, (3 * c3 * x + 2 * c2) * x + c1, 6 * c3 * x + 2 * c2


@lru_cache(maxsize=8)  # of 4 MB each: plants and policies that are compared have equal muscles
def _build_surface(
    muscle: Muscle, root_pressures: tuple[float, ...], strains: tuple[float, ...]
) -> UnitSurface:
    """The table of a `muscle` at roots of pressure [√Pa] and strains [-]."""
    roots, strain = np.array(root_pressures), np.array(strains)
    ends = (np.float64(strain[0]), np.float64(strain[-1]))
    with np.errstate(all="ignore"):  # of branches that aren't taken
        ends_of_spline = [0, 1, -1]
        nodes = _evaluate_nodes(muscle, roots**2, strain, ends_of_spline)
        coefficients = _coefficients(nodes, roots, strain)
        table = partial(UnitSurface, coefficients, np.float64(roots[1]), ends, muscle.length)
        P = ((roots[1:] + roots[:-1])[:, None] / 2) ** 2
        eps = (strain[1:] + strain[:-1])[None] / 2
        force = table((0.0, 0.0, 0.0)).lookup_at(P, eps).force
        errors = np.abs(force - muscle.law.at(P).force(eps)[0])
    return table(tuple(np.quantile(errors, (0.5, 0.99, 1.0)).tolist()))


def _evaluate_nodes(
    muscle: Muscle, pressure: np.ndarray, strain: np.ndarray, rows: Any = slice(None)
) -> list[np.ndarray]:
    """Co-energy and its slope by strain [J] at the grid's nodes, rows by pressure, and slopes of
    both by pressure [m³] in some `rows`.
    """
    values = _coenergy_and_slope(muscle, pressure, strain)
    # at a kink, slopes are those of higher pressures, as a law's are
    ahead = pressure[rows] + _PRESSURE_STEP * np.arange(len(_FORWARD))[:, None]
    slopes = np.tensordot(_FORWARD, [_coenergy_and_slope(muscle, P, strain) for P in ahead], 1)
    return [*values, *slopes]


def _coenergy_and_slope(muscle: Muscle, pressure: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Co-energy [J] and its slope by strain [J], rows by pressure, by the force's integral."""
    at: PressurizedMuscle = muscle.law.at(pressure)
    grid = np.broadcast_to(strain[:, None], (len(strain), len(pressure)))
    work = integrate_force(at, grid, _POINTS)
    work = work - work[np.argmin(np.abs(strain))]
    coenergy = coenergy_at_rest(at) + muscle.length * work
    return np.stack([coenergy.T, muscle.length * at.force(grid)[0].T])


def _coefficients(nodes: list[np.ndarray], roots: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Coefficients of each cell [J]: [line, column, power of u, power of w]."""
    coenergy, by_strain, by_pressure, by_both = nodes
    step, h = strain[1] - strain[0], roots[1]
    by_pressure = _pressure_slopes(roots, coenergy, by_pressure)
    by_both = _pressure_slopes(roots, by_strain, by_both)
    # dP/du at both ends of each cell: of P itself in the first one
    dP_du = np.stack([2 * roots[:-1] * h, 2 * roots[1:] * h])
    dP_du[:, 0] = h**2
    corners = np.empty((len(roots) - 1, len(strain) - 1, 4, 4))
    for a in (0, 1):
        rows, du = slice(a, len(roots) - 1 + a), dP_du[a][:, None]
        for b in (0, 1):
            cells = rows, slice(b, len(strain) - 1 + b)
            corners[..., a, b] = coenergy[cells]
            corners[..., a, 2 + b] = by_strain[cells] * step
            corners[..., 2 + a, b] = by_pressure[cells] * du
            corners[..., 2 + a, 2 + b] = by_both[cells] * du * step
    return _HERMITE @ corners @ _HERMITE.T


def _pressure_slopes(root_pressure: np.ndarray, value: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Slopes by pressure of a cubic spline over √P from the second node on, clamped to the second
    and last row of `slope` there and at the last node; its first row is kept.
    """
    # its second derivative is continuous: a volume whose slope in pressure jumps takes an
    # integrator ten times the steps
    from scipy.interpolate import CubicSpline  # 0.25 s that a force doesn't need

    per = 2 * root_pressure[1:, None]
    ends: Any = ((1, slope[1] * per[0]), (1, slope[-1] * per[-1]))
    spline = CubicSpline(root_pressure[1:], value[1:], bc_type=ends)
    return np.concatenate([slope[:1], spline(root_pressure[1:], 1) / per])


def table_error(table: UnitSurface, muscle: Muscle) -> tuple[np.ndarray, np.ndarray]:
    """Errors of a `table` against its `muscle`'s law, force [N] and volume [m³], a quarter of
    each cell from its sides: in the middle slopes are better than anywhere else.
    """
    lines, columns = table.coefficients.shape[-4:-2]
    low, high = (float(end) for end in table.strains)
    P = (float(table.root_step) * (np.arange(2 * lines) / 2 + 0.25)) ** 2
    # nodes as well, among which is no strain, where volumes are counted from
    eps = np.linspace(low, high, 4 * columns + 1)
    between = slice(1, None, 2)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        _, by_strain, by_pressure, _ = _evaluate_nodes(muscle, P, eps)
        surface = table.lookup_at(P[:, None], eps[between])
    force = by_strain[:, between] / float(muscle.length)
    return np.abs(surface.force - force), np.abs(surface.volume - by_pressure[:, between])


def default_strains(muscle: Muscle) -> tuple[float, float]:
    """Ends of a `muscle`'s table [-], if none are given."""
    straight = float(lowest_strain(muscle.law))
    high = min(LARGEST_STRAIN, float(muscle.braid.ideal_free_strain) + _PUSH_STRAIN)
    return _LOWEST_SHARE * straight, high


def _strain_nodes(muscle: Muscle, ends: tuple[float, float] | None, count: int) -> np.ndarray:
    """Evenly spaced strains [-] from end to end, zero among them."""
    straight = float(lowest_strain(muscle.law))
    if ends is None:
        low, high = default_strains(muscle)
    else:
        low, high = (
            check_interval(end, straight, LARGEST_STRAIN, "strains", "-", closed=(False, True))
            for end in ends
        )
        if not low < 0 < high:
            raise InvalidInputError("strains", "must enclose 0", ends)
    below = max(1, round(-low / (high - low) * (count - 1)))
    step = max(high / (count - 1 - below), -low / below)
    # a step that reaches past both ends still has to stop before the fibers are straight
    step = min(step, -straight / below)
    return step * (np.arange(count) - below)

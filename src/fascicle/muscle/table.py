r"""A muscle as a table of its co-energy, from which force and volume both follow.

A simulation evaluates a muscle thousands of times a second. A `MuscleTable` holds its co-energy
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

Free strain, onset and collapse are those of the lines, linear in between. A deflection grows as a
root of the strain past the onset, or as a hinge past the free strain. So the table holds the
deflection's square over that strain, which is smooth, for both shapes.

**Source:** derived here; Hermite's bicubic: de Boor (1962).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.module import Module, to_numpy, with_fields
from ..core.types import Batch, Numbers, Values, Whole
from ..core.validation import LARGEST_STRAIN, check_interval
from .coenergy import coenergy_at_rest, integrate_force, pressure_derivative
from .piecewise import Piecewise, PressurizedMuscle
from .validation import lowest_strain


# share of the strain of straight fibers, near which the bladder stiffens beyond any grid
_LOWEST_SHARE = 0.75
_PUSH_STRAIN = 0.08  # past the strain at which no braid pulls: how far a load may push one
# Pa: a pressure is solved for to some 1e-9 Pa, so that a vented unit may be that far below zero.
# Its volume keeps the slope at zero there, or the first step of filling would go without one
PRESSURE_ROUNDING = 1e-6
_BESIDE = 1e-9  # of strain, from a kink: on its side of a jump, and no distance for a slope
_POINTS = 5  # of Gauss's rule, in short cells: 1e-12
# of a cell: the leading error of a Hermite cubic's slope, u (1 - u) (1 - 2u), is largest there
_WORST = (3 - math.sqrt(3)) / 6
# cubic Hermite: values at both ends, then slopes, to coefficients of rising powers
_HERMITE = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [-3, 3, -2, -1], [2, -2, 1, 1]], float)


class MuscleState(NamedTuple):
    """One muscle at a pressure and strain: co-energy [J], force [N], conjugate volume [m³], and
    their slopes: of the force in strain [N] and pressure [m²], of the volume in pressure [m³/Pa].
    """

    coenergy: Batch
    force: Batch
    volume: Batch
    force_by_strain: Batch
    force_by_pressure: Batch
    volume_by_pressure: Batch


class MuscleTable(Module):
    """A muscle's co-energy on a grid, (V3), from `muscle.table(supply_pressure)`.

    `coefficients`: of the powers of both cell coordinates [J], cells first; `root_step`: between
    lines of pressure [√Pa]; `strains`: the table's ends [-]; `rest_length` [m]; `errors`: median,
    99 % and largest difference of its force from the law's [N], at points between its nodes and at
    the kinks. `kinks`: free strain, onset and collapse strain [-] of each line, infinite where
    there is none. `bows`: of the bowed and of the hinged shape, the square of the deflection over
    the strain past the onset, or past the free strain, at the nodes [m²]. A stack of tables has
    neither.
    """

    coefficients: Numbers
    root_step: Batch
    strains: tuple[Batch, Batch]
    rest_length: Batch
    errors: tuple[float, float, float]
    kinks: Numbers | None = None
    bows: Numbers | None = None

    @property
    def highest_pressure(self) -> Batch:
        """The table's end [Pa]."""
        return (self.root_step * self.coefficients.shape[-4]) ** 2

    def lookup_at(self, pressure: Batch, strain: Batch, index: Whole | None = None) -> MuscleState:
        """Co-energy [J], force [N], volume [m³] and slopes at `pressure` [Pa] and `strain` [-],
        elementwise, without checks; `index`: of the muscle in a table of several.
        """
        xp, L0 = array_namespace(pressure, strain, self.coefficients), self.rest_length
        lines, columns = self.coefficients.shape[-4:-2]
        h2, (low, high) = self.root_step**2, self.strains
        step = (high - low) / columns
        pressure, strain = xp.asarray(pressure), xp.asarray(strain)

        P = xp.minimum(xp.maximum(pressure, 0.0), self.highest_pressure)
        first = h2 >= P
        # a root has no slope at zero, where the first cell doesn't ask for it
        root = xp.sqrt(xp.where(first, h2, P) / h2)
        i = xp.where(first, 0.0, xp.minimum(xp.floor(root), lines - 1.0))
        u = xp.where(first, P / h2, root - i)
        u_P = xp.where(first, 1.0, 0.5 / root) / h2
        u_PP = xp.where(first, 0.0, -0.25 / root**3) / h2**2

        eps = xp.minimum(xp.maximum(strain, low), high)
        column = (eps - low) / step
        j = xp.minimum(xp.floor(column), columns - 1.0)
        w = column - j

        cell = i.astype(int), j.astype(int)
        c = xp.asarray(self.coefficients)[cell if index is None else (index, *cell)]
        in_w = xp.stack(_cubic(c, w[..., None]), axis=-2)  # [..., derivative by w, power of u]
        of_p, of_u, of_uu = _cubic(in_w, u[..., None])
        p, p_w, p_ww = (of_p[..., k] for k in range(3))
        p_u, p_wu, p_uu = of_u[..., 0], of_u[..., 1], of_uu[..., 0]

        P_past, eps_past = pressure - P, strain - eps  # linear past the table's ends
        inside_P = xp.absolute(P_past) <= PRESSURE_ROUNDING
        V, V_w, share = p_u * u_P, p_wu * u_P, eps_past / step
        by_strain = p_w + V_w * P_past
        return MuscleState(
            coenergy=p + V * P_past + by_strain * share,
            force=by_strain / (step * L0),
            volume=V + V_w * share,
            force_by_strain=xp.where(eps_past == 0, p_ww / (step**2 * L0), 0.0)[()],
            force_by_pressure=V_w / (step * L0),
            volume_by_pressure=xp.where(inside_P, p_uu * u_P**2 + p_u * u_PP, 0.0)[()],
        )

    def force(self, pressure: Values, strain: Values) -> Batch:
        """Pulling force of one muscle $F$ [N], (V3), at `pressure` [Pa], from -101325 Pa, and
        `strain` [-], which broadcast; `ValueError` for concrete values outside the table.
        """
        return self.lookup_at(*self.validate_point(pressure, strain)).force

    def conjugate_volume(self, pressure: Values, strain: Values) -> Batch:
        """Volume $V^*$ [m³], (V3), at `pressure` [Pa] and `strain` [-], as `force`."""
        return self.lookup_at(*self.validate_point(pressure, strain)).volume

    def free_strain(self, pressure: Values) -> Batch:
        """Strain [-] of no force at `pressure` [Pa], between the table's lines."""
        return self._kink(0, pressure)

    def onset(self, pressure: Values) -> Batch:
        """Strain [-] at which the muscle buckles at `pressure` [Pa]; inf where it never does."""
        return self._kink(1, pressure)

    def collapse_strain(self, pressure: Values) -> Batch:
        """Strain [-] at which the muscle folds at `pressure` [Pa]; inf where it never does."""
        return self._kink(2, pressure)

    def deflection(self, pressure: Values, strain: Values) -> np.ndarray:
        """Deflection of the axis [m] at `pressure` [Pa], from 0, and `strain` [-] of the table."""
        pressure, strain = np.broadcast_arrays(*self.validate_point(pressure, strain))
        free, onset, collapse = (self._kink(k, pressure) for k in range(3))
        (low, high), bows = self.strains, np.asarray(self.bows)
        columns = bows.shape[-1] - 1
        eps = (strain - low) / (high - low) * columns
        j = np.minimum(eps.astype(int), columns - 1)
        i, u = self._line(pressure)

        def bilinear(rows: np.ndarray) -> np.ndarray:
            """Value of the `rows` of a grid [m²] at the points."""
            left, right = ((1 - u) * rows[i, k] + u * rows[i + 1, k] for k in (j, j + 1))
            return left + (eps - j) * (right - left)

        collapsed = strain > collapse
        start = np.where(collapsed, free, onset)
        past = np.where(strain > start, strain - start, 0.0)
        return np.sqrt(np.where(collapsed, bilinear(bows[1]), bilinear(bows[0])) * past)

    def _kink(self, kind: int, pressure: Values) -> np.ndarray:
        """Strain [-] of a `kind` of kink at `pressure` [Pa], linear between lines."""
        i, u = self._line(np.asarray(pressure, float))
        rows = np.asarray(self.kinks)[kind]
        low, high = rows[i], rows[i + 1]
        # infinite beside a line that has none
        both = np.isfinite(low) & np.isfinite(high)
        inside = np.where(both, low, 0.0) + u * np.where(both, high - low, 0.0)
        return np.where(both, inside, np.where(u < 1, low, high))[()]

    def _line(self, pressure: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Line below a `pressure` [Pa], and the share of the cell above it [-]."""
        lines = self.coefficients.shape[-4]
        s = np.sqrt(np.clip(pressure, 0.0, self.highest_pressure)) / self.root_step
        i = np.minimum(s.astype(int), lines - 1)
        return i, s - i

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


def tabulate(
    law: Piecewise,
    highest_pressure: float,
    strains: tuple[float, float] | None,
    shape: tuple[int, int],
) -> MuscleTable:
    """Table of a muscle's `law` up to `highest_pressure` [Pa]; arguments as of `muscle.table`."""
    if len(shape) != 2 or min(shape) < 3:
        raise InvalidInputError("shape", "must be two whole numbers of at least 3", shape)
    law, strain = to_numpy(law), _strain_nodes(law, strains, int(shape[1]))
    roots = np.linspace(0.0, math.sqrt(highest_pressure), int(shape[0]))
    with np.errstate(all="ignore"):  # of branches that aren't taken
        ends_of_spline = [0, 1, -1]
        nodes = _evaluate_nodes(law, roots**2, strain, ends_of_spline)
        table = MuscleTable(
            _coefficients(nodes, roots, strain),
            np.float64(roots[1]),
            (np.float64(strain[0]), np.float64(strain[-1])),
            law.tension.bladder.braid.length,
            (0.0, 0.0, 0.0),
            *_kinks_and_bows(law, roots**2, strain),
        )
        errors = np.concatenate([error.ravel() for error in _force_errors(table, law)])
    return with_fields(table, errors=tuple(np.quantile(errors, (0.5, 0.99, 1.0)).tolist()))


def _evaluate_nodes(
    law: Piecewise, pressure: np.ndarray, strain: np.ndarray, rows: slice | Whole = slice(None)
) -> list[np.ndarray]:
    """Co-energy and its slope by strain [J] at the grid's nodes, rows by pressure, and slopes of
    both by pressure [m³] in some `rows`.
    """
    values = _coenergy_and_slope(law, pressure, strain)
    slopes = pressure_derivative(lambda P: _coenergy_and_slope(law, P, strain), pressure[rows])
    return [*values, *slopes]


def _kinks_and_bows(
    law: Piecewise, pressure: np.ndarray, strain: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Kinks [-] of each `pressure` [Pa], and bows [m²], deflection² over the strain past the
    onset, at the nodes with `strain` [-].
    """
    at: PressurizedMuscle = law.at(pressure[:, None])
    free, onset, collapse = (np.broadcast_to(k, (len(pressure), 1)) for k in at.kinks)
    step, bows = strain[1] - strain[0], []
    for start, deflect in (
        (onset, lambda eps: at.law.buckling.bow(at.column, eps)[0]),
        (free, lambda eps: at.law.post_collapse.deflection(at.column, eps)),
    ):
        # within a cell of the start the quotient of two small numbers is that of a cell further on
        eps = np.maximum(strain, np.where(np.isfinite(start), start, strain) + step)
        eps = np.minimum(eps, LARGEST_STRAIN)
        square = np.broadcast_to(deflect(eps), eps.shape) ** 2 / (eps - start)
        bows.append(np.where(np.isfinite(start) & (square > 0), square, 0.0))
    return np.stack([free, onset, collapse])[..., 0], np.stack(bows)


def _coenergy_and_slope(law: Piecewise, pressure: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Co-energy and its slope by strain $L_0 F$ [J] on the first axis, then rows by pressure."""
    at: PressurizedMuscle = law.at(pressure)
    grid = np.broadcast_to(strain[:, None], (len(strain), len(pressure)))
    work = integrate_force(at, grid, _POINTS)
    work = work - work[np.argmin(np.abs(strain))]
    coenergy = coenergy_at_rest(at) + at.column.rest_length * work
    return np.stack([coenergy.T, at.column.rest_length * at.pulling_force(grid).T])


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


def _check_points(table: MuscleTable) -> tuple[np.ndarray, np.ndarray]:
    """Pressures [Pa] and strains [-] in each cell, beside its middle: there slopes of a cubic are
    better than anywhere else.
    """
    lines, columns = table.coefficients.shape[-4:-2]
    low, high = (float(end) for end in table.strains)
    places = [0.25, 0.75], [_WORST, 1 - _WORST]
    i, j = (
        np.add.outer(np.arange(n), x).ravel() for n, x in zip((lines, columns), places, strict=True)
    )
    return (float(table.root_step) * i) ** 2, low + (high - low) * j / columns


def _force_errors(table: MuscleTable, law: Piecewise) -> list[np.ndarray]:
    """Errors of the force of a `table` against its muscle's `law` [N]: between its nodes, and on
    both sides of the kinks, where a polynomial is farthest from a law.
    """
    P, eps = _check_points(table)
    P, (low, high) = P[:, None], table.strains
    at: PressurizedMuscle = law.at(P)
    kinks = [np.broadcast_to(k, P.shape) for k in (*at.kinks, *at.law.buckling.folds(at.column))]
    beside = np.concatenate(kinks, axis=1)[..., None] + _BESIDE * np.array([-1.0, 1.0])
    beside = np.clip(beside.reshape(len(P), -1), low, high)
    return [np.abs(table.lookup_at(P, x).force - at.pulling_force(x)) for x in (eps, beside)]


def volume_errors(table: MuscleTable, law: Piecewise) -> np.ndarray:
    """Errors of the volume of a `table` against its muscle's `law` [m³], between its nodes."""
    # of a fine table not all cells: it takes five integrals each
    P, eps = (x[:: max(1, len(x) // 100)] for x in _check_points(table))
    # zero as well, from which volumes are counted
    eps = np.sort(np.append(eps, 0.0))
    with np.errstate(all="ignore"):  # of branches that aren't taken
        _, _, by_pressure, _ = _evaluate_nodes(law, P, eps)
        volume = table.lookup_at(P[:, None], eps).volume
    return np.abs(volume - by_pressure)


def default_strains(law: Piecewise) -> tuple[float, float]:
    """Ends of the table of a muscle's `law` [-], if none are given."""
    straight = float(lowest_strain(law))
    high = min(LARGEST_STRAIN, float(law.tension.bladder.braid.ideal_free_strain) + _PUSH_STRAIN)
    return _LOWEST_SHARE * straight, high


def _strain_nodes(law: Piecewise, ends: tuple[float, float] | None, count: int) -> np.ndarray:
    """Evenly spaced strains [-] from end to end, zero among them."""
    straight = float(lowest_strain(law))
    if ends is None:
        low, high = default_strains(law)
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

r"""Other readings of the paper's equivalent springs, (13) to (16).

Two links at the angle $\theta$ to the axis meet at the transverse spring, whose force is $k_1 y$.
With $\xi = x/L_{fs}$, $s = 2l/L_{fs}$ and $c = EA L_{fs}^2/(4 \pi^2 EI)$, links and transverse
spring balance where

$$\frac{s}{1 - s} \sqrt{1 - \frac{s}{2 - \xi}} = \frac{1 + \xi}{c (1 - \xi)^4}, \qquad
  (G + 1) s^2 - (2 G + 1) s + G \xi (2 - \xi) = 0, \quad
  G = \frac{\pi (1 + \xi)}{4 c\, \xi (1 - \xi)^{4.5} \sqrt{2 - \xi}},$$

the first if the joint is in equilibrium, `ResolvedSprings` [R19], and the second if it is projected
as in the paper and the deflection is that of the links themselves, `LinkedSprings` [R20]. Force and
moment then follow as in the paper, from the push $EA s (1 - \xi)/(1 - s)$ and the deflection.

**Sign:** tension positive. **Valid for** $\varepsilon \ge \varepsilon_f$.
**Source:** derived here from Kim, Mazzoleni and Bryant (2021), 3.2.
"""

import abc
from typing import Any, ClassVar, NamedTuple

import numpy as np

from fascicle.core.array_namespace import array_namespace, logical_and, sqrt, where
from fascicle.core.roots import guarded, root, stop_gradient
from fascicle.core.types import Batch, BatchLike
from fascicle.muscle.buckling import BRAID_SHARE, AbstractBuckling, BucklingColumn, Push
from fascicle.muscle.buckling.kim2021 import Kim2021

from .series import find_first_cell


class _Bend(NamedTuple):
    """Shortening $s$ of the links and the square of the deflection over $L_{fs}$, both [-], and
    their slopes in $\\xi$.
    """

    shortening: Batch
    shortening_slope: Batch
    square: Batch
    square_slope: Batch


class _Springs(AbstractBuckling):
    """Springs of the paper; how they balance is a subclass's."""

    braid_share: Batch = BRAID_SHARE.field()

    @abc.abstractmethod
    def bend(self, c: Batch, xi: Batch) -> _Bend:
        """State at slenderness `c` [-] and compression `xi` [-]."""

    def branch(self, column: BucklingColumn) -> Batch:
        """The bladder's force at the free strain [N]."""
        return column.pull(column.free_strain).bladder

    def push(self, column: BucklingColumn, strain: BatchLike) -> Push:
        """Components of the force [N] at `strain` [-], as (16) and (27)."""
        eps_f, EA = column.free_strain, column.axial_stiffness
        xi = _compression(column, strain)
        state = self.bend(_slenderness(column), xi)
        s, growth = state.shortening, state.shortening_slope
        arc = eps_f + s * (1 - eps_f)
        pull = column.pull(arc)
        stiffening = growth * (1 - xi) / (1 - s) ** 2 - s / (1 - s)
        return Push(
            mesh=pull.mesh,
            bladder=column.branch + 0.0 * s,
            bending=-EA * s * (1 - xi) / (1 - s),
            slope=pull.mesh_slope * growth - EA * stiffening / (1 - eps_f),
            arc_strain=arc,
            straight=state.square <= 0,
        )

    def bow(self, column: BucklingColumn, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection [m] and moment [N·m] at `strain` [-]."""
        xi = _compression(column, strain)
        square = self.bend(_slenderness(column), xi).square
        bent = square > 0
        y_max = where(bent, column.free_length * sqrt(guarded(bent, square)), 0.0)
        moment = 2 * np.pi**2 * column.bending_stiffness * y_max
        return y_max, moment / (column.free_length * (1 - xi)) ** 2

    def onset(self, column: BucklingColumn) -> Batch:
        """Free strain [-], from which on the muscle may bow."""
        return column.free_strain

    def strain_at_moment(self, column: BucklingColumn, moment: BatchLike) -> Batch:
        """First strain [-] at which the bending moment reaches `moment` [N·m]; inf if never."""
        unit = 2 * np.pi**2 * column.bending_stiffness / column.free_length
        theta = (_slenderness(column), (moment / unit) ** 2)
        exists, low, high = find_first_cell(
            self._moment_reserve, stop_gradient(theta), 0.0 * column.free_strain
        )
        xi = root(self._moment_reserve, theta, low, high, 0.5 * (low + high))
        return where(exists, column.free_strain + xi * (1 - column.free_strain), np.inf)

    def _moment_reserve(self, theta: Any, xi: Batch) -> tuple[Batch, Batch]:
        """Square of a moment over its unit, less that of the muscle at `xi` [-], and its slope."""
        c, target = theta
        state = self.bend(c, xi)
        value = state.square / (1 - xi) ** 4
        return target - value, -(state.square_slope + 4 * state.square / (1 - xi)) / (1 - xi) ** 4


class ResolvedSprings(_Springs):
    """Springs whose joint is in equilibrium [R19]: straight until nearly Euler's load."""

    name: ClassVar[str] = "resolved"

    def bend(self, c: Batch, xi: Batch) -> _Bend:
        """State at slenderness `c` [-] and compression `xi` [-]."""
        bent = _link_residual((c, xi), xi)[0] < 0
        inside = guarded(bent, xi, 0.5)
        load = _load(c, inside)
        start = array_namespace(c, xi).minimum(load / (1 + load), inside)  # s is small against 2
        s = root(_link_residual, (c, inside), 0.0 * inside, inside, start)
        by_s = _link_residual((c, inside), s)[1]
        s_slope = where(bent, -_residual_by_compression(c, inside, s) / by_s, 1.0)
        s = where(bent, s, xi)
        square = 4 / np.pi**2 * (xi - s) * (1 - xi)
        square_slope = 4 / np.pi**2 * ((1 - s_slope) * (1 - xi) - (xi - s))
        return _Bend(s, s_slope, where(bent, square, 0.0), where(bent, square_slope, 0.0))

    def _moment_reserve(self, theta: Any, xi: Batch) -> tuple[Batch, Batch]:
        """Load that the transverse spring holds, less what the links push with where they have the
        shortening of a given moment: no root is nested. And its slope in `xi` [-].
        """
        c, target = theta
        factor = np.pi**2 / 4 * target
        s, s_slope = xi - factor * (1 - xi) ** 3, 1 + 3 * factor * (1 - xi) ** 2
        value, by_s = _link_residual((c, xi), s)
        return value, _residual_by_compression(c, xi, s) + by_s * s_slope


class LinkedSprings(_Springs):
    """The paper's springs, projected, with the deflection of the links themselves [R20]."""

    name: ClassVar[str] = "linked"

    def bend(self, c: Batch, xi: Batch) -> _Bend:
        """State at slenderness `c` [-] and compression `xi` [-]."""
        past = xi > 0
        x = guarded(past, xi, 0.5)
        G = np.pi / 4 * (1 + x) / (c * x * (1 - x) ** 4.5 * sqrt(2 - x))
        G_slope = G * (1 / (1 + x) + 4.5 / (1 - x) - 1 / x + 0.5 / (2 - x))
        r, half = x * (2 - x), 2 * G + 1
        s = 2 * G * r / (half + sqrt(half**2 - 4 * (G + 1) * G * r))  # the smaller root
        s_slope = (G_slope * (s**2 - 2 * s + r) + 2 * G * (1 - x)) / (half - 2 * (G + 1) * s)
        square = ((1 - s) ** 2 - (1 - x) ** 2) / 4
        square_slope = (1 - x - (1 - s) * s_slope) / 2
        return _Bend(
            where(past, s, 0.0), where(past, s_slope, 1.0),
            where(logical_and(past, square > 0), square, 0.0), where(past, square_slope, 0.0),
        )  # fmt: skip


class StiffSprings(Kim2021):
    """The paper's springs with $k_2 = 2EA/L_{fs}$, that of half a bladder [R21]."""

    name: ClassVar[str] = "stiff"

    def solve(self, column: BucklingColumn) -> BucklingColumn:
        """The `column` with twice its axial stiffness, for the springs alone."""
        return super().solve(column._replace(axial_stiffness=2 * column.axial_stiffness))


def _compression(column: BucklingColumn, strain: BatchLike) -> Batch:
    """Compression $\\xi = x/L_{fs}$ [-] at `strain` [-]."""
    return (strain - column.free_strain) / (1 - column.free_strain)


def _slenderness(column: BucklingColumn) -> Batch:
    """Slenderness $c$ [-]."""
    euler = 4 * np.pi**2 * column.bending_stiffness
    return column.axial_stiffness * column.free_length**2 / euler


def _load(c: Batch, xi: Batch) -> Batch:
    """Load of the column, (12), over $EA (1 - \\xi)$ [-]."""
    return (1 + xi) / (c * (1 - xi) ** 4)


def _link_residual(theta: Any, s: Batch) -> tuple[Batch, Batch]:
    """Load that the transverse spring holds less what the links push with, at a shortening `s`
    [-] of theirs, and its slope.
    """
    c, xi = theta
    rest = sqrt(1 - s / (2 - xi))
    slope = -rest / (1 - s) * (1 / (1 - s) - 0.5 * s / (2 - xi - s))
    return _load(c, xi) - s / (1 - s) * rest, slope


def _residual_by_compression(c: Batch, xi: Batch, s: Batch) -> Batch:
    """Slope of `_link_residual` in the compression `xi` [-], at a fixed shortening `s` [-]."""
    push = s / (1 - s) * sqrt(1 - s / (2 - xi))
    growth = 0.5 * (1 / (2 - xi - s) - 1 / (2 - xi))
    return _load(c, xi) * (1 / (1 + xi) + 4 / (1 - xi)) + push * growth

"""Straight lines through readings, their scatter, and polynomials through what they tell.

Tables have a row for each level of pressure; a reading of no weight is not seen.
"""

from dataclasses import dataclass

import numpy as np


_ROUNDING = 1e-4  # of the largest value: as fine as bench files are written


@dataclass(frozen=True, eq=False)
class Line:
    """A weighted straight line through forces over the law's own, level by level.

    - `center`: where the line is held [N]; `value`: its height there [N]; `slope` [-].
    - `spread`: variances of height, both, and slope, over that of a reading [-], [1/N], [1/N²].
    """

    center: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    spread: tuple[np.ndarray, np.ndarray, np.ndarray]

    @property
    def offset(self) -> np.ndarray:
        """Where the line crosses zero [N]."""
        return self.center - self.value / safe(self.slope)

    def at(self, T: np.ndarray) -> np.ndarray:
        """Variance of the line at `T` [N], over that of a single reading [-]."""
        away = T - self.center
        a, b, c = self.spread
        return a + 2 * away * b + away**2 * c


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A polynomial through values with deviations.

    - `coefficients`: from the constant up [any]; `covariance`: theirs.
    - `squares`: squared deviations left, over their variances [-].
    - `misfit`: these over what chance lets expect [-]; 1 where chance explains them.
    """

    coefficients: np.ndarray
    covariance: np.ndarray
    squares: float
    misfit: float


def line(T: np.ndarray, F: np.ndarray, weight: np.ndarray, count: np.ndarray) -> Line:
    """The line of `F` [N] over `T` [N] with `weight` [-], of readings that average `count` [-]."""

    def mean(values: np.ndarray) -> np.ndarray:
        return np.sum(weight * values, axis=1) / total

    total = safe(np.sum(weight, axis=1))
    center, value = mean(T), mean(F)
    away = T - center[:, None]
    moment = np.sum(weight * away**2, axis=1)
    moment = np.where(moment > 0, moment, np.inf)
    slope = np.sum(weight * away * F, axis=1) / moment
    # readings differ in how many they average: variances add up by the weights' squares
    square = weight**2 / np.where(count > 0, count, np.inf)
    sums = [np.sum(square * away**power, axis=1) for power in range(3)]
    return Line(
        center, value, slope, (sums[0] / total**2, sums[1] / (total * moment), sums[2] / moment**2)
    )


def scatter(T: np.ndarray, F: np.ndarray, weight: np.ndarray) -> float:
    """Standard deviation of a reading of `F` [N], about a parabola in `T` [N] at each level."""
    t = T / safe(np.max(np.abs(T), axis=1, keepdims=True))
    basis = np.stack([np.ones_like(t), t, t**2], axis=-1) * np.sqrt(weight)[..., None]
    target = F * np.sqrt(weight)
    # the least that is added lets a level without readings be solved as well
    gram = np.einsum("lri,lrj->lij", basis, basis) + 1e-12 * np.eye(3)
    best = np.linalg.solve(gram, np.einsum("lri,lr->li", basis, target)[..., None])[..., 0]
    squares = np.sum((target - np.einsum("lri,li->lr", basis, best)) ** 2, axis=1)
    free = np.sum(weight > 0, axis=1) - 3
    left = np.sum(free[free > 0])
    if left > 0:
        return float(np.sqrt(np.sum(squares[free > 0]) / left))
    # too few readings to see any scatter: a hundredth of the largest force is a load cell's
    return 0.01 * max(float(np.max(np.abs(F))), 1e-9)


def polynomial(
    x: np.ndarray, y: np.ndarray, deviation: np.ndarray, order: int, size: int
) -> Polynomial:
    """A polynomial of this `order` [-] through `y` [any] with `deviation` [the same] at `x` [-],
    filled up with zeros to `size` coefficients [-].
    """
    if not x.size:
        return Polynomial(np.zeros(size), np.zeros((size, size)), 0.0, 1.0)
    # readings that agree to the last digit have no scatter: they are as sure as they are rounded
    weight = 1 / np.maximum(deviation, _ROUNDING * np.max(np.abs(y), initial=1e-9)) ** 2
    basis = x[:, None] ** np.arange(order + 1)
    scale = max(float(np.max(weight)), 1e-300)
    gram = np.einsum("l,li,lj->ij", weight / scale, basis, basis) + 1e-14 * np.eye(order + 1)
    if x.size < 2 and order > 0:
        gram[0, 0] += 1e9  # a single reading carries a line through the origin
    inverse = np.linalg.inv(gram)
    best = inverse @ np.einsum("l,li,l->i", weight / scale, basis, y)
    squares = float(np.sum(weight * (y - basis @ best) ** 2))
    free = x.size - (order + 1)
    ratio = squares / max(free, 1)
    # where the curve misses by more than chance lets the readings, it is that uncertain
    misfit = ratio if free > 0 and ratio > 1 + 3 * np.sqrt(2 / free) else 1.0
    pad = size - (order + 1)
    covariance = np.pad(misfit * inverse / scale, ((0, pad), (0, pad)))
    return Polynomial(np.pad(best, (0, pad)), covariance, squares, misfit)


def safe(values: np.ndarray) -> np.ndarray:
    """`values` [any] to divide by: 1 in place of 0."""
    return np.where(values == 0, 1.0, values)

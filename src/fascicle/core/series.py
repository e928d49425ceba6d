"""Sums of powers and of Chebyshev polynomials, in whatever array library is at work."""

from collections.abc import Sequence

from .types import Batch, BatchLike


def polynomial(coefficients: Sequence[float], x: BatchLike) -> tuple[Batch, Batch]:
    """A polynomial of `x`, lowest power first, and its slope, by Horner's scheme."""
    value, slope = coefficients[-1] + 0.0 * x, 0.0 * x
    for term in coefficients[-2::-1]:
        value, slope = value * x + term, slope * x + value
    return value, slope


def series(coefficients: Sequence[float], x: BatchLike) -> Batch:
    """The sum of Chebyshev polynomials of `x`, by Clenshaw's recurrence."""
    last, before, twice = 0.0 * x, 0.0 * x, 2 * x
    for term in coefficients[:0:-1]:
        last, before = twice * last - (before - term), last
    return x * last - before + coefficients[0]

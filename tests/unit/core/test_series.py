import numpy as np
from numpy.testing import assert_allclose

from fascicle.core.array_namespace import chebyshev_sum, polynomial


def test_polynomial_and_its_slope():
    x = np.linspace(-1, 1, 5)
    value, slope = polynomial((1.0, -2.0, 0.0, 3.0), x)
    assert_allclose(value, 1 - 2 * x + 3 * x**3, rtol=1e-15, atol=1e-15)
    assert_allclose(slope, -2 + 9 * x**2, rtol=1e-15, atol=1e-15)


def test_series_of_chebyshev_polynomials():
    x, coefficients = np.linspace(-1, 1, 9), (0.5, -1.0, 0.25, 2.0)
    expected = np.polynomial.chebyshev.chebval(x, coefficients)
    assert_allclose(chebyshev_sum(coefficients, x), expected, rtol=1e-15, atol=1e-15)

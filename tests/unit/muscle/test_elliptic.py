import jax
import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.muscle.buckling.elastica import elliptic, jacobi


@pytest.mark.parametrize("m", [-0.5, -1e-9, 0.0, 1e-12, 0.1, 0.5, 0.8261147659879693, 0.9])
def test_complete_integrals(m):
    ours = elliptic(m)
    assert_allclose(ours.K, float(mpmath.ellipk(m)), rtol=1e-15, atol=0)
    assert_allclose(ours.E, float(mpmath.ellipe(m)), rtol=2e-15, atol=0)


@pytest.mark.parametrize("m", [0.2, 0.6, 0.82])
def test_slopes_of_complete_integrals(m):
    K, E = float(mpmath.ellipk(m)), float(mpmath.ellipe(m))
    dK, dE = jax.grad(lambda m: elliptic(m).K)(m), jax.grad(lambda m: elliptic(m).E)(m)
    assert_allclose(dK, (E - (1 - m) * K) / (2 * m * (1 - m)), rtol=1e-13)
    assert_allclose(dE, (E - K) / (2 * m), rtol=1e-13)


def test_complete_integrals_are_smooth_at_zero():
    # K = π/2 (1 + m/4 + 9m²/64 …), E = π/2 (1 − m/4 − 3m²/64 …)
    K, E = (lambda m: elliptic(m).K), (lambda m: elliptic(m).E)
    assert_allclose([jax.grad(K)(0.0), jax.grad(E)(0.0)], [np.pi / 8, -np.pi / 8], rtol=1e-15)
    assert_allclose(jax.grad(jax.grad(K))(0.0), 9 * np.pi / 64, rtol=1e-14)


@pytest.mark.parametrize("m", [0.0, 0.3, 0.7, 0.82])
def test_amplitude_and_incomplete_integral(m):
    u = np.linspace(0, 4 * float(mpmath.ellipk(m)), 17)
    phase, epsilon = jacobi(u, elliptic(m))
    expected = [float(mpmath.ellipfun("sn", u=x, m=m)) for x in u]
    assert_allclose(np.sin(phase), expected, rtol=0, atol=3e-15)
    assert_allclose(phase[-1], 2 * np.pi, rtol=1e-15)  # four quarters are a full turn
    incomplete = [float(mpmath.ellipe(mpmath.mpf(float(p)), m)) for p in phase]
    assert_allclose(epsilon, incomplete, rtol=0, atol=1e-14)

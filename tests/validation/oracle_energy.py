"""The oracle, part 7: co-energy of a muscle and the volume that goes with its force.

Plain quadrature and differences of the oracle's own force; it never imports the library.

    W(P, e) = L0 * integral of F(P, e') from 0 to e
    V*(P, e) = V(0) + dW/dP
"""

from itertools import pairwise

import numpy as np
import oracle_force
import oracle_muscle
from scipy.integrate import quad


def kinks(muscle, pressure):
    """Strains [-] at which the force has a kink: free strain and collapse."""
    return oracle_muscle.free_strain(muscle, pressure), oracle_force.collapse_strain(
        muscle, pressure
    )


def work(muscle, pressure, strain):
    """W [J], by adaptive quadrature between the kinks."""
    stops = [0.0, *(k for k in kinks(muscle, pressure) if 0 < k < strain), strain]

    def pull(eps):
        return oracle_force.force(muscle, pressure, eps)

    # the square in the variable resolves the boundary layer just past each kink
    def stretch(a, b):
        return quad(
            lambda s: pull(a + (b - a) * s * s) * 2 * s * (b - a), 0, 1, epsabs=1e-14, epsrel=1e-12
        )[0]

    return muscle.length * sum(stretch(a, b) for a, b in pairwise(stops))


def conjugate_volume(muscle, pressure, strain, step=400.0):
    """V* [m3], by Richardson's extrapolation of differences: central, one-sided near P = 0."""

    def difference(h):
        if pressure >= h:
            up, down = (work(muscle, pressure + d, strain) for d in (h, -h))
            return (up - down) / (2 * h)
        at = [work(muscle, pressure + i * h, strain) for i in range(5)]
        return (-25 * at[0] + 48 * at[1] - 36 * at[2] + 16 * at[3] - 3 * at[4]) / (12 * h)

    order = 2 if pressure >= step else 4
    coarse, fine = difference(step), difference(step / 2)
    slope = fine + (fine - coarse) / (2**order - 1)
    return oracle_muscle.volume(muscle, 0.0) + slope


def cycle(volume, force, corners, points=400):
    """Work of fluid and of the ends [J] round a rectangle of `corners` (P0, P1, e0, e1), for a
    volume(P, e) and a force(P, e) that is already times L0.
    """
    low, high, begin, end = corners
    x, w = np.polynomial.legendre.leggauss(points)
    P = (low + high) / 2 + (high - low) / 2 * x
    e = (begin + end) / 2 + (end - begin) / 2 * x
    in_P = [
        np.sum(w * np.array([volume(p, at) for p in P])) * (high - low) / 2 for at in (begin, end)
    ]
    in_e = [
        np.sum(w * np.array([force(at, s) for s in e])) * (end - begin) / 2 for at in (low, high)
    ]
    # P dV round the loop is -V dP round it
    return in_P[1] - in_P[0], in_e[1] - in_e[0]

r"""Elliptic integrals by the arithmetic-geometric mean, in the array library of their arguments.

**Source:** Abramowitz and Stegun (1964), 17.6.
"""

from typing import NamedTuple

import numpy as np

from ...core.array_namespace import arcsin, sin, sqrt
from ...core.types import Batch, BatchLike


_AGM_STEPS = 6  # the mean's error squares at each step: 5 suffice up to m = 0.9


class Elliptic(NamedTuple):
    """Complete elliptic integrals, and the steps of the mean for the incomplete ones."""

    K: Batch
    E: Batch
    means: tuple[Batch, ...]
    differences: tuple[Batch, ...]


def elliptic(m: BatchLike) -> Elliptic:
    """$K(m)$ and $E(m)$ of parameter $m = k^2$ in [0, 0.9], smooth at $m = 0$."""
    a, b = 1.0 + 0.0 * m, sqrt(1.0 - m)
    means, differences, total = [a], [0.0 * m], 0.5 * m
    for n in range(_AGM_STEPS):
        a, b, c = (a + b) / 2, sqrt(a * b), (a - b) / 2
        means.append(a)
        differences.append(c)
        total = total + 2**n * c**2
    K = np.pi / (2 * a)
    return Elliptic(K, K * (1 - total), tuple(means), tuple(differences))


def jacobi(u: BatchLike, integrals: Elliptic) -> tuple[Batch, Batch]:
    r"""Jacobi's amplitude $\varphi = \mathrm{am}(u)$ and the incomplete integral $E(\varphi)$."""
    phase = 2.0**_AGM_STEPS * integrals.means[-1] * u
    epsilon = u * integrals.E / integrals.K
    for a, c in zip(integrals.means[:0:-1], integrals.differences[:0:-1], strict=True):
        epsilon = epsilon + c * sin(phase)
        phase = (phase + arcsin(c / a * sin(phase))) / 2
    return phase, epsilon

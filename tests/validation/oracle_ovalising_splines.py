"""A second oracle of a column that ovalizes: splines of the fifth degree, walls that touch exactly.

Nothing here imports the library, nor the first oracle. Half of the column, of length 1 and bending
stiffness 1, in `count` elements with Gauss's points; the walls in its middle touch at a point and
are held there by a force, not by a spring. `bowed`: amplitude of a slope [rad] that the column has
before any load, as a sine, which makes no bending.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline


_DEGREE = 5


@dataclass(frozen=True)
class Section:
    """What ovality costs: on its square, its slope's, its bend's; where walls touch, all [-]."""

    square: float
    slope: float
    bend: float
    touch: float


class Half:
    """Half a column from its clamped and round end to its middle."""

    def __init__(self, section, count=24, bowed=0.0):
        self.section = section
        knots = np.r_[[0.0] * _DEGREE, np.linspace(0, 0.5, count + 1), [0.5] * _DEGREE]
        gauss, weights = np.polynomial.legendre.leggauss(_DEGREE + 2)
        h = 0.5 / count
        at = (np.arange(count)[:, None] * h + h * (gauss + 1) / 2).ravel()
        self.weight = np.tile(weights * h / 2, count)
        splines = BSpline(knots, np.eye(count + _DEGREE), _DEGREE)
        value, slope, bend = splines(at), splines.derivative(1)(at), splines.derivative(2)(at)
        # the axis: no slope at the end nor in the middle
        self.T, self.T1 = value[:, 1:-1], slope[:, 1:-1]
        # ovality: none at the end, nor a slope there; none in the middle, where it is even
        kept = np.delete(np.eye(count + _DEGREE), [0, 1, -2], axis=1)
        kept[-2, -1] = 1.0
        self.Z, Z1, Z2 = value @ kept, slope @ kept, bend @ kept
        self.middle = splines(0.5) @ kept
        W = self.weight[:, None]
        self.stiff = 2 * (section.slope * Z1.T @ (W * Z1) + section.bend * Z2.T @ (W * Z2))
        self.start = bowed * np.sin(2 * np.pi * at)
        self.sine = np.linalg.lstsq(self.T, np.sin(2 * np.pi * at), rcond=None)[0]

    def residual(self, x, shortening, touching):
        """What isn't in balance at slopes, ovalities, load and the walls' force, and its slopes."""
        n, W = self.T.shape[1], self.weight
        m = n + self.Z.shape[1]
        theta, kappa, oval = self.start + self.T @ x[:n], self.T1 @ x[:n], self.Z @ x[n:m]
        load, force = x[m], x[m + 1]
        soft, soft1 = 1 - 1.5 * oval + 0.625 * oval**2, -1.5 + 1.25 * oval
        a = self.section.square
        sine = self.T.T @ (W * np.sin(theta))
        g = np.r_[
            self.T1.T @ (W * soft * kappa) - load * sine,
            self.Z.T @ (W * (0.5 * kappa**2 * soft1 + 2 * a * oval))
            + self.stiff @ x[n:m] + force * self.middle,
            (1 - shortening) / 2 - W @ np.cos(theta),
            self.middle @ x[n:m] - self.section.touch if touching else force,
        ]  # fmt: skip
        H = np.zeros((m + 2, m + 2))
        bending, turning = (W * soft)[:, None], (W * load * np.cos(theta))[:, None]
        H[:n, :n] = self.T1.T @ (bending * self.T1) - self.T.T @ (turning * self.T)
        H[:n, n:m] = self.T1.T @ ((W * soft1 * kappa)[:, None] * self.Z)
        H[n:m, :n] = H[:n, n:m].T
        H[n:m, n:m] = self.Z.T @ ((W * (0.625 * kappa**2 + 2 * a))[:, None] * self.Z) + self.stiff
        H[:n, m], H[m, :n], H[n:m, m + 1] = -sine, sine, self.middle
        if touching:
            H[m + 1, n:m] = self.middle
        else:
            H[m + 1, m + 1] = 1.0
        return g, H


def loads(half, shortenings):
    """End load [-] at each of rising shortenings; each state begins at the one before."""
    n = half.T.shape[1]
    x = np.zeros(n + half.Z.shape[1] + 2)
    x[:n], x[-2] = 2 * math.sqrt(shortenings[0]) * half.sine, 4 * math.pi**2
    touching, found = False, []
    for shortening in shortenings:
        x = _settled(half, x, shortening, touching)
        if not touching and half.middle @ x[n:-2] > half.section.touch:
            touching = True
            x = _settled(half, x, shortening, touching)
        # where walls press, they press at one point: elsewhere they are apart
        assert not touching or x[-1] > 0
        assert np.max(half.Z @ x[n:-2]) < half.section.touch + 1e-6
        found.append(x[-2])
    return np.array(found)


def _settled(half, x, shortening, touching):
    n = half.T.shape[1]
    for _ in range(60):
        value, slopes = half.residual(x, shortening, touching)
        step = np.linalg.solve(slopes, value)
        x = x - min(1.0, 0.3 / max(np.max(np.abs(step[:n])), 1e-300)) * step
        if np.max(np.abs(step[:-2])) < 1e-11:
            return x
    raise RuntimeError(f"no state at a shortening of {shortening:g}")

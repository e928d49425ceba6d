"""The oracle of a braid whose fibers stretch: one fiber's length, found by trying.

Written before the library's law, which it doesn't know: the helix as a triangle, energies as
sums, the least of them found by golden sections, forces as differences of it.
"""

import math
from dataclasses import dataclass

from scipy.optimize import minimize_scalar


@dataclass(frozen=True)
class Tube:
    """Sizes at rest [m, rad], rubber [Pa], and the tension per stretch of all fibers [N]."""

    length: float
    radius: float
    wall: float
    angle: float
    c10: float
    c01: float
    stiffness: float

    @property
    def fiber(self):
        return self.length / math.cos(self.angle)

    @property
    def way_around(self):
        """2π n r0 of a fiber of n turns."""
        return self.length * math.tan(self.angle)

    def radius_at(self, eps, stretched):
        """From L² + (2π n r)² = b²."""
        around = math.sqrt((self.fiber * stretched) ** 2 - (self.length * (1 - eps)) ** 2)
        return self.radius * around / self.way_around

    def volume(self, eps, stretched):
        return math.pi * self.radius_at(eps, stretched) ** 2 * self.length * (1 - eps)

    def rubber(self, eps, stretched):
        along, around = 1 - eps, self.radius_at(eps, stretched) / self.radius
        through = 1 / (along * around)
        squares = along**2, around**2, through**2
        I1 = sum(squares)
        I2 = sum(1 / square for square in squares)
        inner = self.radius - self.wall
        body = math.pi * (self.radius**2 - inner**2) * self.length
        return body * (self.c10 * (I1 - 3) + self.c01 * (I2 - 3))

    def potential(self, pressure, eps, stretched):
        """Fibers that a tension T lengthens to b (1 + T/EA), rubber, and the fluid's."""
        fibers = 0.5 * self.stiffness * self.fiber * (stretched - 1) ** 2
        return fibers + self.rubber(eps, stretched) - pressure * self.volume(eps, stretched)

    def stretch(self, pressure, eps, most=1.6):
        """The fibers' length over that at rest, where the potential is least."""
        least = math.cos(self.angle) * (1 - eps)
        found = minimize_scalar(
            lambda s: self.potential(pressure, eps, s),
            bounds=(least + 1e-9, most),
            method="bounded",
            options={"xatol": 1e-13, "maxiter": 500},
        )
        return found.x

    def least(self, pressure, eps):
        return self.potential(pressure, eps, self.stretch(pressure, eps))

    def force(self, pressure, eps, step=2e-3):
        """−dΠ/dε over L0, by a difference of sixth order."""
        weights = {1: 45, 2: -9, 3: 1}
        slope = sum(
            w * (self.least(pressure, eps + k * step) - self.least(pressure, eps - k * step))
            for k, w in weights.items()
        ) / (60 * step)
        return -slope / self.length

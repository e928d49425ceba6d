"""The law (27) as a good student writes it: NumPy over strain, `brentq` of SciPy for roots.

A floor under the library's times, written from the equations alone (`kim2021`'s buckling and
collapse, `derived` after it). Free and collapse strain are solved once for each pressure; then all
strains of that pressure are one array.

    python benchmarks/scipy_script.py
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar


@dataclass(frozen=True)
class Tube:
    """A muscle: sizes at rest [m, rad], rubber [Pa], β [-], and factors of a fit [-]."""

    L0: float
    r0: float
    t0: float
    a0: float
    c10: float
    c01: float
    E: float
    nu: float
    beta: float
    collapse_factor: float = 1.0
    hinge_factor: float = 1.0
    hinge_slope: float = 0.0  # by pressure [1/Pa]

    @classmethod
    def of(cls, muscle: Any) -> "Tube":
        """Constants of a muscle of the library."""
        rubber = muscle.material
        sizes = (muscle.length, muscle.outer_radius, muscle.wall_thickness, muscle.braid_angle)
        constants = (rubber.c10, rubber.c01, rubber.youngs_modulus, rubber.poisson_ratio)
        return cls(*(float(x) for x in (*sizes, *constants, muscle.transition_rate)))

    @property
    def area(self) -> float:
        """Cross-section of the wall [m²]."""
        return np.pi * (self.r0**2 - (self.r0 - self.t0) ** 2)

    @property
    def second_moment(self) -> float:
        """Second moment of the wall's area [m⁴]."""
        return np.pi / 4 * (self.r0**4 - (self.r0 - self.t0) ** 4)


def mesh_force(tube: Tube, P: float, eps: Any) -> Any:
    """Force of the braid [N]."""
    ideal = 3 * (1 - eps) ** 2 / np.tan(tube.a0) ** 2 - 1 / np.sin(tube.a0) ** 2
    return np.pi * tube.r0**2 * P * ideal


def bladder_force(tube: Tube, eps: Any) -> Any:
    """Force of the bladder [N]."""
    lam = 1 - eps
    p, q = lam**2, (1 - np.cos(tube.a0) ** 2 * lam**2) / np.sin(tube.a0) ** 2
    dp, dq = 2 * lam, -2 * lam / np.tan(tube.a0) ** 2
    cross = dp * q + p * dq
    slope = tube.c10 * (dp + dq - cross / (p * q) ** 2)
    slope = slope + tube.c01 * (-dp / p**2 - dq / q**2 + cross)
    return tube.area * slope


def find_root(function: Any, low: float, high: float) -> float:
    """Root between two bounds, to the last digits."""
    tolerance: Any = 1e-15
    root: Any = brentq(function, low, high, xtol=tolerance, rtol=tolerance)
    return root


class PressurizedTube:
    """A muscle at one pressure, its free and collapse strain solved."""

    def __init__(self, tube: Tube, P: float):
        self.tube, self.P = tube, P
        self.eps_f = 0.0
        if P > 0:
            self.eps_f = find_root(
                lambda e: mesh_force(tube, P, e) + bladder_force(tube, e), 0.0, 0.6
            )
        self.L_fs = tube.L0 * (1 - self.eps_f)
        stiffening = 1 / (1 - tube.nu**2) + 4 * P / tube.E * tube.r0 / tube.t0
        collapse = 2 * np.sqrt(2) / 9 * np.pi * tube.E * tube.r0 * tube.t0**2 * np.sqrt(stiffening)
        collapse *= tube.collapse_factor
        peak: Any = minimize_scalar(
            lambda xi: -self.moment(xi), bounds=(0.0, 1 - 1e-9), method="bounded"
        )
        self.eps_c, self.F_at_collapse = np.inf, 0.0
        if self.moment(peak.x) >= collapse:
            xi = find_root(lambda xi: self.moment(xi) - collapse, 1e-12, peak.x)
            self.eps_c = self.eps_f + xi * (1 - self.eps_f)
            self.F_at_collapse = self.buckled(self.eps_c)

    def unshortened(self, xi: Any) -> Any:
        """1 − w of (16), by Newton's method from h = 1."""
        tube = self.tube
        b = xi * (1 - xi) ** 4 / (1 + xi) * tube.E * tube.area * self.L_fs**2
        b = b / (4 * np.pi**2 * tube.E * tube.second_moment)  # 1/a
        u = b / (1 + b)
        for _ in range(20):
            below = 1 - (1 - u) * xi
            inside = 1 - (1 - u) * xi / (2 - xi)
            h = np.sqrt(inside) / below
            slope = xi * h * (0.5 / (2 - xi) / inside - 1 / below)  # of h in u
            step = (u * (b + h) - b) / (b + h + u * slope)
            u = u - step
            if np.max(np.abs(step)) < 1e-15:  # rounding
                break
        return u

    def moment(self, xi: Any) -> Any:
        """Bending moment [N m]."""
        y = 2 / np.pi * self.L_fs * np.sqrt(xi * self.unshortened(xi) * (1 - xi))
        EI = self.tube.E * self.tube.second_moment
        return 2 * np.pi**2 * EI * y / (self.L_fs * (1 - xi)) ** 2

    def buckled(self, eps: Any) -> Any:
        """Force between free strain and collapse [N]."""
        xi = (eps - self.eps_f) / (1 - self.eps_f)
        w = 1 - self.unshortened(xi)
        mesh = mesh_force(self.tube, self.P, self.eps_f + xi * w * (1 - self.eps_f))
        spring = self.tube.E * self.tube.area * xi * w * (1 - xi) / (1 - xi * w)
        return mesh + bladder_force(self.tube, self.eps_f) - spring

    def collapsed(self, eps: Any) -> Any:
        """Force after collapse [N]."""
        tube, L_fs = self.tube, self.L_fs
        x = (eps - self.eps_f) * tube.L0
        halves = tube.E * tube.second_moment * np.pi**2 * (L_fs + x) / (4 * (L_fs - x) ** 3)
        hinge = np.pi / 4 * tube.E * tube.r0 * tube.t0**2
        hinge *= tube.hinge_factor + tube.hinge_slope * self.P
        F_c = halves + hinge / np.sqrt(x * (L_fs - x))
        return -F_c + (self.F_at_collapse + F_c) * np.exp(-tube.beta * (eps - self.eps_c))

    def force(self, eps: np.ndarray) -> np.ndarray:
        """Force [N] over strain."""
        F = np.empty(eps.shape)
        pulls, collapsed = eps <= self.eps_f, eps > self.eps_c
        buckled = ~pulls & ~collapsed
        F[pulls] = mesh_force(self.tube, self.P, eps[pulls]) + bladder_force(self.tube, eps[pulls])
        if buckled.any():
            F[buckled] = self.buckled(eps[buckled])
        if collapsed.any():
            F[collapsed] = self.collapsed(eps[collapsed])
        return F


def force_field(tube: Tube, pressure: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Force [N], a row for each pressure; strains are one row, or a row for each."""
    strains = np.broadcast_to(strain, (len(pressure), np.shape(strain)[-1]))
    rows = [PressurizedTube(tube, float(P)).force(e)
            for P, e in zip(pressure, strains, strict=True)]  # fmt: skip
    return np.stack(rows)


def bundle_free_strain(tubes: list[Tube], pressures: np.ndarray, samples: int = 200) -> float:
    """Smallest strain at which the forces of all units add up to zero."""
    units = [PressurizedTube(tube, float(P)) for tube, P in zip(tubes, pressures, strict=True)]

    def total(eps: Any) -> Any:
        return sum(unit.force(np.atleast_1d(eps)) for unit in units)

    strains = [unit.eps_f for unit in units]
    grid = np.linspace(min(strains), max(strains), samples)
    first_push = np.flatnonzero(total(grid[1:]) <= 0)[0] + 1
    return find_root(lambda e: total(e)[0], float(grid[first_push - 1]), float(grid[first_push]))


if __name__ == "__main__":
    figure_6 = Tube(0.127, 6.35e-3, 1.6e-3, np.radians(33), 88.8e3, 79.3e3, 1.78e6, 0.5, 25.0)
    pressures = np.array([0.0, 34.5e3, 137.9e3])
    print(force_field(figure_6, pressures, np.linspace(0.0, 0.33, 12)).round(2))

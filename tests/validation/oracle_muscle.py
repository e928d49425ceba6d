"""The oracle, part 1: one muscle's sizes, tension law, tuning and collapse moments.

Plain scalar Python, written from the equations and nothing else; it never imports the
library that it judges. Numbers in brackets are the paper's equations, [R..] the readings
of its misprints. SI units; gauge pressure; contraction and pulling force are positive.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq


RTOL = 4 * np.finfo(float).eps  # the tightest that brentq accepts
XTOL = 1e-300  # so that the relative tolerance alone decides


@dataclass(frozen=True)
class Material:
    """Mooney-Rivlin constants [Pa], and the linear constants of bending [Pa, -]."""

    c10: float
    c01: float
    youngs_modulus: float
    poisson_ratio: float = 0.5


LATEX = Material(118.4e3, 105.7e3, 6 * (118.4e3 + 105.7e3))
SILICONE = Material(88.8e3, 79.3e3, 1.78e6)
TABLE = Material(118.4e3, 105.7e3, 1.78e6)  # the number tables' hybrid: latex, but E 1.78 MPa


@dataclass(frozen=True)
class Tuning:
    """C1 [N] and C2 [-] at pressures [Pa], and section 5's four factors."""

    pressures: tuple[float, ...] = ()
    c1: tuple[float, ...] = ()
    c2: tuple[float, ...] = ()
    youngs_modulus_factor: float = 1.0
    collapse_moment_factor: float = 1.0
    hinge_stiffness_factor: float = 1.0
    hinge_stiffness_slope: float = 0.0  # 1/Pa
    transition_rate: float | None = None


@dataclass(frozen=True)
class Muscle:
    """Sizes [m, rad], and the names of the laws."""

    length: float = 0.127
    outer_radius: float = 6.35e-3
    wall_thickness: float = 1.6e-3
    braid_angle: float = math.radians(33)
    material: Material = LATEX
    tension: str = "klute_hannaford"
    buckling: str = "kim2021"
    collapse: str = "kim2021"
    collapse_factor: float = 1.0
    post_collapse: str = "derived"
    transition_rate: float = 25.0
    tuning: Tuning = Tuning()


# ---- constants of a muscle


def modulus(muscle):
    """E with its factor: in EI, EA, (17) and k_r, never in C10 and C01."""
    return muscle.material.youngs_modulus * muscle.tuning.youngs_modulus_factor


def rate(muscle):
    """beta of (26): the tuned one replaces the muscle's own."""
    tuned = muscle.tuning.transition_rate
    return muscle.transition_rate if tuned is None else tuned


def area(muscle):
    r0, t0 = muscle.outer_radius, muscle.wall_thickness
    return math.pi * (r0**2 - (r0 - t0) ** 2)


def second_moment(muscle):
    r0, t0 = muscle.outer_radius, muscle.wall_thickness
    return math.pi * (r0**4 - (r0 - t0) ** 4) / 4


def ideal_free_strain(muscle):
    return 1 - 1 / (math.sqrt(3) * math.cos(muscle.braid_angle))


def lowest_strain(muscle):
    """Where the fibers are straight."""
    return 1 - 1 / math.cos(muscle.braid_angle)


# ---- kinematics


def radius_squared_ratio(muscle, strain):
    """(r/r0)^2 from (2)."""
    c, s = math.cos(muscle.braid_angle), math.sin(muscle.braid_angle)
    return (1 - c**2 * (1 - strain) ** 2) / s**2


def radius(muscle, strain):
    return muscle.outer_radius * math.sqrt(radius_squared_ratio(muscle, strain))


def volume(muscle, strain):
    """Fluid volume [R17]: pi r^2 L less the bladder's, which is incompressible."""
    r0, L0 = muscle.outer_radius, muscle.length
    outer = math.pi * r0**2 * L0 * radius_squared_ratio(muscle, strain) * (1 - strain)
    return outer - area(muscle) * L0


# ---- tension (these four take arrays of strain as well)


def mesh_untuned(muscle, pressure, strain):
    """(3) with its factor 3 [R1]."""
    t, s = math.tan(muscle.braid_angle), math.sin(muscle.braid_angle)
    lam = 1 - strain
    return math.pi * muscle.outer_radius**2 * pressure * (3 * lam**2 / t**2 - 1 / s**2)


def bladder_untuned(muscle, strain):
    """V_b dW/dL = A dW/dlambda [R2], differentiated by hand.

    With q = (r/r0)^2:  I1 = l^2 + q + 1/(l^2 q),  I2 = 1/l^2 + 1/q + l^2 q.
    """
    if muscle.tension == "ideal":
        return 0.0 * strain
    c, s = math.cos(muscle.braid_angle), math.sin(muscle.braid_angle)
    lam = 1 - strain
    q = radius_squared_ratio(muscle, strain)
    dq = -2 * c**2 * lam / s**2
    dI1 = 2 * lam + dq - 2 / (lam**3 * q) - dq / (lam**2 * q**2)
    dI2 = -2 / lam**3 - dq / q**2 + 2 * lam * q + lam**2 * dq
    return area(muscle) * (muscle.material.c10 * dI1 + muscle.material.c01 * dI2)


def c1_c2(muscle, pressure):
    """C1 [N] and C2 [-]: straight lines from (0 Pa, 0 N, 1) on, flat beyond the last."""
    tuning = muscle.tuning
    P = [0.0, *tuning.pressures]
    c1 = np.interp(pressure, P, [0.0, *tuning.c1])
    c2 = np.interp(pressure, P, [1.0, *tuning.c2])
    return float(c1), float(c2)


def mesh(muscle, pressure, strain):
    """(32)."""
    return c1_c2(muscle, pressure)[1] * mesh_untuned(muscle, pressure, strain)


def bladder(muscle, pressure, strain):
    """(33): what is left of (31)."""
    c1, c2 = c1_c2(muscle, pressure)
    return c2 * (bladder_untuned(muscle, strain) - c1)


def tension(muscle, pressure, strain):
    """(31), which is (4) where C1 = 0 and C2 = 1; goes on past the free strain."""
    return mesh(muscle, pressure, strain) + bladder(muscle, pressure, strain)


def blocked_force(muscle, pressure):
    return tension(muscle, pressure, 0.0)


@lru_cache(maxsize=8192)
def free_strain(muscle, pressure):
    """Root of the tension law between straight fibers and nearly no length."""
    if pressure == 0:
        return ideal_free_strain(muscle) if muscle.tension == "ideal" else 0.0
    if muscle.tension == "ideal" and not muscle.tuning.pressures:
        return ideal_free_strain(muscle)
    low = lowest_strain(muscle) * (1 - 1e-9)
    # shifted to strain + 1, so that a root near zero is held to 1e-16 absolute, not relative
    return brentq(lambda e: tension(muscle, pressure, e), low, 0.97, xtol=1e-16, rtol=RTOL)


# ---- collapse moments


def collapse_moment(muscle, pressure):
    """(17) as printed, and its alternatives by name [R8], with both factors."""
    E, nu = modulus(muscle), muscle.material.poisson_ratio
    r0, t0 = muscle.outer_radius, muscle.wall_thickness
    wood = 2 * math.sqrt(2) / 9 * math.pi * E * r0 * t0**2
    moment = {
        "kim2021": wood * math.sqrt(1 / (1 - nu**2) + 4 * pressure / E * (r0 / t0)),
        "wood1958": wood * math.sqrt(1 / (1 - nu**2) + 4 * pressure / E * (r0 / t0) ** 3),
        # 0.98731 is 2 sqrt(2) pi/9 to five digits: with it whole, this is (17) at P = 0
        "brazier1927": wood / math.sqrt(1 - nu**2),
        "stein_hedgepeth1961": math.pi * pressure * r0**3,
    }[muscle.collapse]
    return moment * muscle.collapse_factor * muscle.tuning.collapse_moment_factor

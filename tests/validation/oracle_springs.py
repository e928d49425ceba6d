"""The oracle of the paper's equivalent springs, (13) to (16), as they can be read.

Two links at the angle theta to the axis meet at the transverse spring, whose force is k1 y. The
paper *projects* it, F = k1 y/2 sin(theta) cos(theta). In equilibrium the joint *resolves* it: each
link holds N = k1 y/(2 sin(theta)), and pushes the ends apart with F = N cos(theta). The same from
virtual work: with y = a sin(theta), x = 2a (1 - cos(theta)), F = k1 y dy/dx = k1 y/2 cot(theta).

The transverse deflection is that of an arc that has shortened by 2l (`arc`), or that of the links
themselves (`links`). `stiffness` is k2 over EA/L_fs. Nothing here imports the library.
"""

import math

import numpy as np
from oracle_muscle import (
    Muscle,
    area,
    bladder,
    collapse_moment,
    free_strain,
    mesh,
    modulus,
    second_moment,
)
from scipy.optimize import brentq


def state(
    muscle: Muscle,
    pressure: float,
    strain: float,
    statics: str = "projected",
    closure: str = "arc",
    stiffness: float = 1.0,
) -> tuple[float, float, float]:
    """Force [N], deflection [m] and moment [N m], past the free strain."""
    free = free_strain(muscle, pressure)
    L, x = muscle.length * (1 - free), muscle.length * (strain - free)
    EI, EA = modulus(muscle) * second_moment(muscle), modulus(muscle) * area(muscle)
    k2 = stiffness * EA / L

    def deflection(l):
        if closure == "arc":
            return math.sqrt(4 * (x - 2 * l) * (L - x)) / math.pi
        return (L - 2 * l) / 2 * math.sin(angle(l))

    def angle(l):
        return math.acos((L - x) / (L - 2 * l))

    def lever(theta):
        if statics == "projected":
            return math.sin(theta) * math.cos(theta)
        return 1 / math.tan(theta)

    F_b = 4 * math.pi**2 * EI * (L + x) / (L - x) ** 3
    k1 = 2 * F_b / (math.sqrt(4 * x * (L - x)) / math.pi * lever(angle(0.0)))  # y_max by (10)

    def excess(l):  # of the links' push over what the transverse spring holds
        theta = angle(l)
        return 2 * k2 * l * math.cos(theta) - k1 * deflection(l) * lever(theta) / 2

    last = x / 2 * (1 - 1e-9)  # nearly straight: beyond it both angles are rounding
    l = brentq(excess, 0.0, last, xtol=1e-18, rtol=1e-14) if excess(last) > 0 else x / 2
    arc = free + 2 * l / muscle.length
    push = 2 * k2 * l * (L - x) / (L - 2 * l)
    y = 0.0 if l == x / 2 else deflection(l)
    force = mesh(muscle, pressure, arc) + bladder(muscle, pressure, free) - push
    return force, y, 2 * math.pi**2 * EI * y / (L - x) ** 2


def collapse(muscle: Muscle, pressure: float, **reading) -> tuple[float, float]:
    """Strain [-] at which the moment first reaches the collapse moment, and the force [N] there."""
    limit, free = collapse_moment(muscle, pressure), free_strain(muscle, pressure)

    def excess(strain):
        return state(muscle, pressure, strain, **reading)[2] - limit

    grid = np.linspace(free + 1e-6, 0.6, 400)
    values = [excess(strain) for strain in grid]
    after = next((i for i in range(400) if values[i] >= 0), None)
    if after is None:
        return math.inf, math.nan
    strain = brentq(excess, grid[after - 1], grid[after], xtol=1e-15, rtol=1e-14)
    return strain, state(muscle, pressure, strain, **reading)[0]

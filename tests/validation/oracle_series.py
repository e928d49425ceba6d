"""The oracle of the paper's bowed shape in series with the arc that the tension law compresses.

Nothing here imports the library.
"""

import math

from oracle_muscle import free_strain, modulus, second_moment, tension
from scipy.optimize import brentq


def state(muscle, pressure, strain):
    """Force [N], arc strain [-], deflection [m] and moment [N m], past the free strain."""
    EI, L0 = modulus(muscle) * second_moment(muscle), muscle.length
    free, d = free_strain(muscle, pressure), L0 * (1 - strain)

    def bow(arc):  # (12) of an arc of this length
        length = L0 * (1 - arc)
        x = length - d
        return 4 * math.pi**2 * EI * (length + x) / (length - x) ** 3

    def apart(arc):
        return bow(arc) + tension(muscle, pressure, arc)

    if apart(strain) >= 0:  # straight: it is not pressed enough to bow
        return tension(muscle, pressure, strain), strain, 0.0, 0.0
    arc = brentq(apart, free, strain, xtol=1e-15, rtol=1e-14)
    x = L0 * (1 - arc) - d
    y = math.sqrt(4 * x * d) / math.pi
    return -bow(arc), arc, y, 2 * math.pi**2 * EI * y / d**2

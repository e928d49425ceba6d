"""The oracle of ends that give: a force, and a co-energy, by bisection and quadrature.

Nothing here imports the library. The muscle is the oracle's own; its law is asked for the
bladder's strain.
"""

from oracle_muscle import tension
from scipy.integrate import quad
from scipy.optimize import brentq


def bladder_strain(muscle, pressure, strain, inactive, compliance):
    """The strain of the part that contracts [-], where that part and its ends hold one force."""
    active = muscle.length - inactive

    def apart(y):
        # shortening of the bladder, less what the ends tell and what they give
        give = compliance * tension(muscle, pressure, y)
        return y * active - strain * muscle.length - give

    unloaded = strain * muscle.length / active
    step = 1e-3
    low, high = unloaded, unloaded
    while apart(low) > 0:
        low -= step
    while apart(high) < 0:
        high += step
    return brentq(apart, low, high, xtol=1e-15, rtol=1e-14) if low < high else unloaded


def force(muscle, pressure, strain, inactive, compliance):
    """Pull of the ends [N]."""
    y = bladder_strain(muscle, pressure, strain, inactive, compliance)
    return tension(muscle, pressure, y)


def coenergy(muscle, pressure, strain, inactive, compliance):
    """What pressure and ends have given together [J], less the empty muscle's volume: of the
    bladder, from rest, less what its ends store.
    """
    y = bladder_strain(muscle, pressure, strain, inactive, compliance)
    active = muscle.length - inactive
    work = quad(lambda e: tension(muscle, pressure, e), 0, y, epsabs=1e-13, epsrel=1e-12)[0]
    return active * work - 0.5 * compliance * tension(muscle, pressure, y) ** 2


def volume_swept(muscle, pressure, strain, inactive, compliance, step=50.0):
    """What the pressure works on [m3], from the empty muscle at rest, by differences."""

    def at(P):
        return coenergy(muscle, P, strain, inactive, compliance)

    near, far = (
        at(pressure + step) - at(pressure - step),
        at(pressure + 2 * step) - at(pressure - 2 * step),
    )
    return (8 * near - far) / (12 * step)

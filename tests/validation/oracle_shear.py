"""The oracle of a column that bends and shears: cut into pieces, the load at which it gives way.

Written before the library's law, with nothing closed: slopes and turns of pieces, the energy as a
sum over them, and the load as an eigenvalue.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq


def volume_of_slices(section, length, angle, slices=1000):
    """Of a stack of round slices, each as thick as its length along the axis, that is drawn over by
    an angle while its slices stay as they face: they come nearer by its cosine.
    """
    return sum(section * length / slices * np.cos(angle) for _ in range(slices))


def load(bending, shear, length, pieces=400):
    """The least load [N] of a column between clamped ends that has a bent equilibrium.

    Unknowns are deflections w at the nodes between pieces and turns θ of the sections there, all
    zero at both ends; a piece shears by its slope less the mean turn of its ends.
    """
    h = length / pieces
    ahead, behind = np.eye(pieces, pieces - 1), np.eye(pieces, pieces - 1, -1)
    slope, mean, none = (ahead - behind) / h, (ahead + behind) / 2, np.zeros((pieces, pieces - 1))
    sheared = np.hstack([slope, -mean])
    turned, sloped = np.hstack([none, slope]), np.hstack([slope, none])
    held = h * (bending * turned.T @ turned + shear * sheared.T @ sheared)
    pushed = h * sloped.T @ sloped
    # the load does no work on turns alone: so the most of what it does, over what is stored
    last = 2 * (pieces - 1) - 1
    return 1 / eigh(pushed, held, eigvals_only=True, subset_by_index=[last, last])[0]


def push(bending, shear, length, shortening):
    """End load [N] of an inextensible column, bowed so far that its ends are nearer by a share of
    its length: EI θ'' = −N sin(θ + γ), S γ = N sin(θ + γ), from the clamped end to a quarter.
    """
    least = load(bending, shear, length, 100)
    # a third of the length, of one that doesn't shear, takes 8/length
    most = 9 / length * least * length**2 / (4 * np.pi**2 * bending)

    def quarter(N, curvature):
        def change(_, state):
            theta, turn, _chord = state
            gamma = brentq(lambda g: shear * g - N * np.sin(theta + g), -1.5, 1.5, xtol=1e-14)
            return turn, -N / bending * np.sin(theta + gamma), np.cos(theta + gamma)

        return solve_ivp(change, (0, length / 4), (0, curvature, 0), rtol=1e-9, atol=1e-12).y[:, -1]

    def chord_at(curvature):
        """The load that is straight again at a quarter, and the ends' distance then."""
        N = brentq(lambda N: quarter(N, curvature)[1], 0.5 * least, 1.6 * least)
        return N, 4 * quarter(N, curvature)[2]

    bent = brentq(lambda k: chord_at(k)[1] / length - 1 + shortening, 0.5 / length, most, xtol=1e-8)
    return chord_at(bent)[0]

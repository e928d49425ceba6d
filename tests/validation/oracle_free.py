"""Free recruitment by brute force: every unit at every pressure of a grid, NumPy alone.

What one unit gives is asked of a function, so that nothing here knows the laws, nor how the
library searches: all combinations of pressures are made, added up and looked through.
"""

from itertools import product

import numpy as np


def combinations(forces: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Sums over all combinations of grid pressures, and the places of these.

    Each of `forces` is one unit's [N] at the grid's pressures, the first of which is none.
    """
    places = np.array(list(product(*(range(len(one)) for one in forces))))
    total = sum(one[places[:, i]] for i, one in enumerate(forces))
    return np.asarray(total), places


def region(forces: list[np.ndarray]) -> tuple[float, float]:
    """The least and the largest force [N] of any combination."""
    total, _ = combinations(forces)
    return float(total.min()), float(total.max())


def cheapest(forces: list[np.ndarray], taken: list[float], wanted: float) -> float | None:
    """The least fluid [m³] with which a force [N] is reached; `None` where it isn't.

    For each choice of fed units the force moves continuously over the grid, so that whatever lies
    between the least and the largest of its combinations is reached. Where none is fed nothing is
    taken in; what flows back isn't counted.
    """
    best = None
    for fed in product([False, True], repeat=len(forces)):
        some = [one if on else one[:1] for one, on in zip(forces, fed, strict=True)]
        low, high = region(some)
        if low - 1e-9 <= wanted <= high + 1e-9:
            cost = sum(max(v, 0.0) for v, on in zip(taken, fed, strict=True) if on)
            best = cost if best is None else min(best, cost)
    return best

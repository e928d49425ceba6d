"""The oracle, part 4: bundles. A bundle is a tuple of (muscle, count), its motor units."""

import math
from functools import lru_cache

import numpy as np
from oracle_buckling import elastica
from oracle_force import collapse_strain, force
from oracle_muscle import RTOL, free_strain
from scipy.optimize import brentq, minimize_scalar


SCAN = 4001
HIGHEST = 0.6


@lru_cache(maxsize=1 << 20)
def _cached_force(muscle, pressure, strain):
    return force(muscle, pressure, strain)


def bundle_force(units, pressures, strain, resistance=True):
    """Sum over all muscles at one strain; max(F, 0) for each where resistance is neglected."""
    total = 0.0
    for (muscle, count), pressure in zip(units, pressures, strict=True):
        one = _cached_force(muscle, float(pressure), float(strain))
        total += count * (one if resistance else max(one, 0.0))
    return total


def kinks(units, pressures):
    """Strains where some unit's force has a corner."""
    found = []
    for (muscle, _), P in zip(units, pressures, strict=True):
        found += [free_strain(muscle, P), collapse_strain(muscle, P)]
        if muscle.buckling == "elastica":
            found.append(elastica(muscle, P).onset)
    return [e for e in found if 0 < e < HIGHEST]


def equilibria(units, pressures):
    """All strains in [0, 0.6] of zero force with resistance: list of (strain, stable).

    Stable: the force falls through zero. A force that jumps over zero is no equilibrium.
    """
    return _equilibria(units, tuple(float(P) for P in pressures))


@lru_cache(maxsize=1024)
def _equilibria(units, pressures):
    def f(e):
        return bundle_force(units, pressures, e)

    grid = sorted({*np.linspace(0, HIGHEST, SCAN).tolist(), *kinks(units, pressures)})
    values = [f(e) for e in grid]
    # a turn between grid points may still cross zero: put the turning point in
    extra = []
    for i in range(1, len(grid) - 1):
        a, b, c = values[i - 1 : i + 2]
        sign = 1.0 if b > 0 else -1.0
        if sign * b <= sign * a and sign * b <= sign * c and sign * a > 0 and sign * c > 0:
            best = minimize_scalar(
                lambda e, s=sign: s * f(e), bounds=(grid[i - 1], grid[i + 1]), method="bounded"
            )
            if best.fun <= 0:
                extra.append(float(best.x))
    grid = sorted({*grid, *extra})
    values = [f(e) for e in grid]
    roots = []
    if values[0] == 0 and values[1] < 0:
        roots.append((0.0, True))
    for e0, e1, f0, f1 in zip(grid, grid[1:], values, values[1:], strict=False):
        if f0 * f1 < 0 or (f1 == 0 and f0 != 0):
            root = brentq(f, e0, e1, xtol=1e-16, rtol=RTOL)
            if abs(f(root)) < 1e-6:
                roots.append((root, f0 > 0))
    return roots


def bundle_free_strain(units, pressures, resistance=True):
    """First strain where the force followed from strain 0 reaches zero [R16]."""
    if not resistance:
        return max(free_strain(muscle, P) for (muscle, _), P in zip(units, pressures, strict=True))
    roots = equilibria(units, pressures)
    return roots[0][0] if roots else math.inf


def reversal(units, supply, index, pressures):
    """Free strains against the pressure of one unit: earlier ones at supply, later ones at 0."""
    out = []
    for P in pressures:
        each = [supply] * index + [P] + [0.0] * (len(units) - index - 1)
        out.append(bundle_free_strain(units, tuple(each)))
    return np.array(out)

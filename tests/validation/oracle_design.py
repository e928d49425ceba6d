"""The oracle, part 6: what a design does for a task, point by point.

A design is a tuple of (muscle, count), its motor units in the order of recruitment; a task a
tuple of (force [N], strain [-], weight [-]). Regions are taken over the levels handed in.
"""

import math
from itertools import pairwise

import numpy as np
from oracle_buckling import elastica, kim2021
from oracle_bundle import _cached_force
from oracle_force import collapse_strain
from oracle_muscle import RTOL, blocked_force, free_strain, radius, volume
from scipy.optimize import brentq


def state_force(units, supply, k, level, strain, scheme="orderly"):
    """Force in recruitment state k, counted from 0, at a throttled level of the supply."""
    total = 0.0
    for i, (muscle, n) in enumerate(units):
        if scheme == "batch":
            P = level * supply if i <= k else 0.0
        else:
            P = supply if i < k else level * supply if i == k else 0.0
        total += n * _cached_force(muscle, float(P), float(strain))
    return total


def region(units, supply, k, strain, levels, scheme="orderly"):
    """Least and largest force of state k at a strain."""
    forces = [state_force(units, supply, k, u, strain, scheme) for u in levels]
    return min(forces), max(forces)


def visit(units, supply, point, levels, scheme="orderly"):
    """(state or None, shortfall, energy, efficiency or None) of one demanded point."""
    force, strain, _ = point
    shortfalls = []
    for k in range(len(units)):
        low, high = region(units, supply, k, strain, levels, scheme)
        shortfalls.append(max(low - force, force - high, 0.0))
    met = [k for k, s in enumerate(shortfalls) if s <= 1e-9]
    state = met[0] if met else None
    # what isn't reached is charged as if everything were fed
    active = len(units) if state is None else state + 1
    energy = supply * sum(
        n * (volume(muscle, strain) - volume(muscle, 0.0)) for muscle, n in units[:active]
    )
    work = force * strain * units[0][0].length
    efficiency = None if work <= 0 else 0.0 if state is None else work / energy
    return state, min(shortfalls), energy, efficiency


def spare(units, supply, point, levels, scheme="orderly"):
    """Force beyond what a point demands that some state still gives; negative where none does."""
    force, strain, _ = point
    tops = [region(units, supply, k, strain, levels, scheme)[1] for k in range(len(units))]
    return max(tops) - force


def reaches(units, supply, task, levels, scheme="orderly", may_miss=0.0):
    """Whether a design does a task: no more than a share of it missed, by points and by weight."""
    missed = [visit(units, supply, point, levels, scheme)[0] is None for point in task]
    total = sum(weight for *_, weight in task)
    by_weight = sum(w for (*_, w), miss in zip(task, missed, strict=True) if miss) / total
    return sum(missed) <= may_miss * len(task) and by_weight <= may_miss


def task_objectives(units, supply, task, levels, scheme="orderly"):
    """Objectives that look at the task."""
    total = sum(weight for *_, weight in task)
    largest = max(force for force, *_ in task)
    visits = [visit(units, supply, point, levels, scheme) for point in task]
    worked = [(w, eta) for (*_, w), (*_, eta) in zip(task, visits, strict=True) if eta is not None]
    return {
        "mean_efficiency": sum(w * eta for w, eta in worked) / sum(w for w, _ in worked),
        "peak_energy": max(energy for _, _, energy, _ in visits),
        "mean_energy": sum(w * v[2] for (*_, w), v in zip(task, visits, strict=True)) / total,
        "not_reached": sum(w for (*_, w), v in zip(task, visits, strict=True) if v[0] is None)
        / total,
        "shortfall": sum(w * v[1] for (*_, w), v in zip(task, visits, strict=True)) / total,
        "worst_shortfall": max(v[1] for v in visits),
        "points_not_reached": sum(v[0] is None for v in visits) / len(task),
        # of nothing there is no share: the largest force stands for it
        "relative_shortfall": max(
            v[1] / (f or largest) for (f, *_), v in zip(task, visits, strict=True)
        ),
        "margin": min(spare(units, supply, point, levels, scheme) for point in task),
        "relative_margin": min(
            spare(units, supply, point, levels, scheme) / (point[0] or largest) for point in task
        ),
    }


def first_zero(units, pressures, strains):
    """First strain of zero force on the way from rest; `strains` bracket it."""

    def force(e):
        return sum(
            n * _cached_force(muscle, float(P), float(e))
            for (muscle, n), P in zip(units, pressures, strict=True)
        )

    for a, b in pairwise(strains):
        if force(b) <= 0:
            return brentq(force, a, b, xtol=1e-14, rtol=RTOL) if force(a) > 0 else float(a)
    return float(strains[-1])


def reversal_depth(units, supply, levels, strains):
    """Largest fall of the free strain in any transition to a further unit, earlier ones on."""
    depth = 0.0
    for k in range(1, len(units)):
        curve = []
        for u in levels:
            P = [supply] * k + [u * supply] + [0.0] * (len(units) - k - 1)
            curve.append(first_zero(units, P, strains))
        depth = max(depth, curve[0] - min(curve))
    return depth


def overlap_width(units, supply, levels, strains, scheme="orderly"):
    """Largest height in force of what two successive states both reach, at no strain less."""
    widest = 0.0
    for e in strains:
        regions = [region(units, supply, k, e, levels, scheme) for k in range(len(units))]
        for (low, high), (next_low, next_high) in pairwise(regions):
            widest = max(widest, min(high, next_high) - max(low, next_low, 0.0))
    return widest


def largest_force(units, supply):
    return sum(n * blocked_force(muscle, supply) for muscle, n in units)


def force_resolution(units, supply):
    """Largest step of the blocked force between fully active states."""
    return max(n * blocked_force(muscle, supply) for muscle, n in units)


def deflection(muscle, strain):
    """How far an unpressurized muscle bows out, to its axis."""
    e_f = free_strain(muscle, 0.0)
    if strain <= e_f:
        return 0.0
    if strain <= collapse_strain(muscle, 0.0):
        if muscle.buckling == "elastica":
            return elastica(muscle, 0.0).state(strain).deflection
        return kim2021(muscle, 0.0, strain).deflection
    # (22)'s halves: their slope at the hinge, tan(theta_r), is pi y_max over the chord
    L_fs = muscle.length * (1 - e_f)
    x = (strain - e_f) * muscle.length
    tangent = {"derived": 1.0, "printed": 1.0, "consistent": 2.0}[muscle.post_collapse]
    return tangent * math.sqrt(x / (L_fs - x)) * (L_fs - x) / math.pi


def envelope(units, task, packed_radius):
    """Diameter around the contracted muscles, unfed ones bowed out; `packed_radius(radii)`."""
    largest = max(strain for _, strain, _ in task)
    radii = [radius(muscle, largest) for muscle, n in units for _ in range(n)]
    bulge = 0.0
    if len(units) > 1:
        for muscle, _ in units:
            stops = [*np.linspace(0, largest, 400), min(collapse_strain(muscle, 0.0), largest)]
            bulge = max(bulge, *(deflection(muscle, float(e)) for e in stops))
    return 2 * (packed_radius(radii) + bulge)


def equal_packing(count, rng, starts=30):
    """Radius of the smallest circle found around `count` unit circles: an upper bound."""
    from scipy.optimize import minimize

    if count == 1:
        return 1.0
    i, j = np.triu_indices(count, 1)
    best = math.inf
    for _ in range(starts):
        start = np.append(rng.normal(size=2 * count) * math.sqrt(count), 3 * math.sqrt(count))
        done = minimize(
            lambda z: z[-1],
            start,
            jac=lambda z: np.append(np.zeros(z.size - 1), 1.0),
            constraints=[
                {"type": "ineq", "fun": lambda z: _apart(z, i, j)},
                {"type": "ineq", "fun": _inside},
            ],
            method="SLSQP",
            options={"maxiter": 300},
        )
        if done.success and min(_apart(done.x, i, j).min(), _inside(done.x).min()) > -1e-6:
            best = min(best, float(done.x[-1]))
    return best


def _apart(z, i, j):
    x, y = z[:-1].reshape(2, -1)
    return (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 - 4


def _inside(z):
    x, y = z[:-1].reshape(2, -1)
    return (z[-1] - 1) ** 2 - x**2 - y**2

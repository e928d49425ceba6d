"""The oracle, part 5: work, fluid energy and average efficiency, by tables."""

import math

import numpy as np
from oracle_force import force
from oracle_muscle import blocked_force, volume


PER_UNIT_STRAIN = 375  # [R18] strains j/375
FORCES = 80  # forces F_max i/80


def fluid_energy(units, supply, active, strain):
    """(29), over the units 0 ... active, with [R17]'s volume."""
    return supply * sum(
        n * (volume(muscle, strain) - volume(muscle, 0.0)) for muscle, n in units[: active + 1]
    )


class Tables:
    """Force of one muscle over (pressure, strain), and its integral over strain."""

    def __init__(self, muscle, pressures, last, halvings=1):
        step = 2**halvings
        fine = np.arange(last * step + 1) / (PER_UNIT_STRAIN * step)
        F = np.array([[force(muscle, P, e) for e in fine] for P in pressures])
        for name, values in (("with", F), ("without", np.maximum(F, 0))):
            cells = (values[:, 1:] + values[:, :-1]) / 2 * np.diff(fine)
            area = np.concatenate([np.zeros((len(pressures), 1)), np.cumsum(cells, axis=1)], axis=1)
            setattr(self, "force_" + name, values[:, ::step])
            setattr(self, "area_" + name, area[:, ::step])

    def pick(self, resistance):
        kind = "with" if resistance else "without"
        return getattr(self, "force_" + kind), getattr(self, "area_" + kind)


def crossings(curve, level):
    """Cells of a sampled curve that pass a level, and where in the cell."""
    low, high = curve[:-1], curve[1:]
    hit = np.nonzero(((low <= level) & (high > level)) | ((low >= level) & (high < level)))[0]
    return hit, (level - low[hit]) / (high[hit] - low[hit])


def average_efficiency(
    units, supply, path="isobaric", resistance=True, scheme="orderly", nodes=415, last=140
):
    """Mean over the reached points of [R18]'s grid of the best state's efficiency (30)."""
    pressures = np.linspace(0, supply, nodes)
    tables = {}
    for muscle, _ in units:
        if muscle not in tables:
            tables[muscle] = Tables(muscle, pressures, last).pick(resistance)
    length = units[0][0].length
    F_max = sum(n * blocked_force(muscle, supply) for muscle, n in units)
    levels = F_max * np.arange(1, FORCES + 1) / FORCES
    best = np.full((FORCES, last + 1), -math.inf)
    for k in range(len(units)):
        F, area = 0.0, 0.0
        for i, (muscle, n) in enumerate(units):
            f, a = tables[muscle]
            if scheme == "orderly":
                rows = slice(None) if i == k else ([-1] if i < k else [0])
            else:  # batch: the first k + 1 units together
                rows = slice(None) if i <= k else [0]
            F, area = F + n * f[rows], area + n * a[rows]
        for j in range(1, last + 1):
            strain = j / PER_UNIT_STRAIN
            E = fluid_energy(units, supply, k, strain)
            for i, level in enumerate(levels):
                cells, share = crossings(F[:, j], level)
                if cells.size == 0:
                    continue
                if path == "isobaric":
                    W = length * (area[cells, j] * (1 - share) + area[cells + 1, j] * share).max()
                else:
                    W = level * strain * length
                best[i, j] = max(best[i, j], W / E)
    return float(np.mean(best[np.isfinite(best)])), best

"""The oracle of a column that ovalizes as it bends: its energy on a fine grid, made stationary.

Nothing here imports the library. Half of the column, from its clamped end to its middle, by
differences: slopes of the axis at nodes, ovality at nodes, and the end load that holds the chord.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve


@dataclass(frozen=True)
class Tube:
    """A bladder: bending stiffness [N m2], mid radius, wall [m], E [Pa], ratio; pressure [Pa]."""

    bending: float
    radius: float
    wall: float
    modulus: float
    ratio: float
    pressure: float

    @property
    def plate(self):
        return self.modulus * self.wall**3 / (12 * (1 - self.ratio**2))

    @property
    def of_ovality(self):
        """a, b, g: on the square of ovality, of its slope, of its bend."""
        E, t, r, nu, P, D = (
            self.modulus, self.wall, self.radius, self.ratio, self.pressure, self.plate
        )  # fmt: skip
        a = 3 * math.pi * E * t**3 / (8 * (1 - nu**2) * r) + 1.5 * math.pi * P * r**2
        b = 9 / 4 * math.pi * r * D * (1 - nu)
        g = math.pi * E * t * r**5 / 32 + math.pi * r**3 * D / 2
        return a, b, g


def softening(z):
    """What is left of the bending stiffness at an ovality, and its slopes."""
    return 1 - 1.5 * z + 0.625 * z**2, -1.5 + 1.25 * z, 1.25 + 0 * z


class Column:
    """Half a column of a length [m], on `count` cells."""

    def __init__(self, tube, length, count=160):
        self.tube, self.length, self.n = tube, length, count
        self.h = length / 2 / count
        n = count
        # slopes of the axis at nodes 1 to n - 1: there is none at the end and in the middle
        self.bend = sparse.diags_array([1.0, -1.0], offsets=[0, -1], shape=(n, n - 1)) / self.h
        # ovality at nodes 1 to n: node 0 is round, and its mirror too, since its slope is none
        self.first = sparse.diags_array([1.0, -1.0], offsets=[0, -1], shape=(n, n)) / self.h
        self.to_cells = sparse.diags_array([0.5, 0.5], offsets=[0, -1], shape=(n, n))
        second = sparse.lil_array((n + 1, n))
        for i in range(n + 1):  # at node i, of nodes i - 1, i, i + 1, mirrored at both ends
            for j, weight in ((i - 1, 1.0), (i, -2.0), (i + 1, 1.0)):
                k = -j if j < 0 else (2 * n - j if j > n else j)
                if k > 0:
                    second[i, k - 1] += weight / self.h**2
        self.second = second.tocsr()
        # nodes weigh a cell, the first and the middle one half of it
        self.ends = np.ones(n + 1)
        self.ends[[0, -1]] = 0.5
        self.share = self.ends[1:]
        self.touch = 1 - tube.wall / (2 * tube.radius)
        a, b, g = tube.of_ovality
        self.stiff = 2 * self.h * (
            a * sparse.diags_array(self.share)
            + b * self.first.T @ self.first
            + g * self.second.T @ sparse.diags_array(self.ends) @ self.second
        )  # fmt: skip

    def energy(self, x):
        """Of the whole column [J]."""
        n, h, EI = self.n, self.h, self.tube.bending
        kappa, oval = self.bend @ x[: n - 1], x[n - 1 : 2 * n - 1]
        over, hard = np.maximum(oval - self.touch, 0.0), 1e4 * self.tube.of_ovality[0]
        soft, _, _ = softening(self.to_cells @ oval)
        held = oval @ self.stiff @ oval + 2 * h * hard * np.sum(self.share * over**2)
        return h * EI * np.sum(kappa**2 * soft) + held

    def residual(self, x, chord):
        """Gradient and Hessian of energy less load times chord; x: slopes, ovality, load."""
        n, h, EI = self.n, self.h, self.tube.bending
        slope, oval, load = x[: n - 1], x[n - 1 : 2 * n - 1], x[-1]
        kappa, mid = self.bend @ slope, self.to_cells @ oval
        soft, soft1, soft2 = softening(mid)
        # past touching a wall as stiff as it takes
        over, hard = np.maximum(oval - self.touch, 0.0), 1e4 * self.tube.of_ovality[0]
        held = h * (np.sum(np.cos(slope)) + 1) - chord / 2  # the ends weigh half each
        g = np.concatenate([
            h * EI * self.bend.T @ (soft * kappa) + load * h * np.sin(slope),
            self.to_cells.T @ (0.5 * h * EI * kappa**2 * soft1)
            + self.stiff @ oval + 2 * h * hard * self.share * over,
            [-held],
        ])  # fmt: skip
        diagonal = sparse.diags_array
        ss = h * EI * self.bend.T @ diagonal(soft) @ self.bend + diagonal(load * h * np.cos(slope))
        sz = h * EI * self.bend.T @ diagonal(soft1 * kappa) @ self.to_cells
        zz = (
            self.to_cells.T @ diagonal(0.5 * h * EI * kappa**2 * soft2) @ self.to_cells
            + self.stiff + diagonal(2 * h * hard * self.share * (over > 0))
        )  # fmt: skip
        by_load = sparse.csr_array((h * np.sin(slope))[:, None])
        return g, sparse.block_array(
            [[ss, sz, by_load], [sz.T, zz, None], [by_load.T, None, None]], format="csc"
        )


def bent(column, ratios, whole=False):
    """States at falling chords over the arc's length: load [N] and largest ovality of each, or
    each state as a `whole`.

    Of an arc of the column's own length. Each begins at the one before; the load counts positive
    where it pushes.
    """
    n, L = column.n, column.length
    found = []
    x = np.zeros(2 * n)
    for i, ratio in enumerate(ratios):
        chord = ratio * L
        if i == 0:
            s = np.arange(1, n) * column.h
            x[: n - 1] = 2 * math.sqrt(1 - ratio) * np.sin(2 * math.pi * s / L)
            x[-1] = -4 * math.pi**2 * column.tube.bending / L**2
        for _ in range(60):
            g, H = column.residual(x, chord)
            step = spsolve(H, g)
            size = np.max(np.abs(step[: 2 * n - 1]))
            x = x - min(1.0, 0.3 / max(size, 1e-300)) * step
            if size < 1e-11:
                break
        else:
            raise RuntimeError(f"no state at a chord of {ratio:g}")
        found.append(x if whole else (-x[-1], float(np.max(x[n - 1 : 2 * n - 1]))))
    return np.array(found)

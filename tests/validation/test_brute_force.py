"""Bundles against a fine grid: no zero and no reachable force is missed, whatever the laws.

Of many bundles, trials once found free strains that no zero had, each with a `kothera2009` unit,
and batch demands that were called unreachable. The grid knows the force alone.
"""

import math

import numpy as np
import pytest

import fascicle as fs


LAWS = (
    {}, {}, {"buckling": "elastica"}, {"tension": "kothera2009"}, {"collapse": "wood1958"}
)  # fmt: skip
GRID = 4001
DOMAIN = 0.6
pytestmark = pytest.mark.filterwarnings("ignore:the tuning was measured up to")


def muscle(rng, length, **laws):
    radius = rng.uniform(3e-3, 15e-3)
    tuning = None
    if rng.random() < 0.3:
        table = np.sort(rng.uniform(20e3, 420e3, 3))
        tuning = fs.Tuning(
            table, rng.uniform(0.01, 0.06, 3) * table * 3e-5, rng.uniform(0.7, 1.3, 3),
            collapse_moment_factor=rng.uniform(0.6, 1.2),
        )  # fmt: skip
    c10, c01 = rng.uniform(60e3, 200e3), rng.uniform(20e3, 160e3)
    return fs.Muscle(
        length, radius, radius * rng.uniform(0.12, 0.35), math.radians(rng.uniform(20, 45)),
        fs.MooneyRivlin(c10, c01, rng.uniform(4, 9) * (c10 + c01)), tuning=tuning,
        transition_rate=rng.uniform(5, 120), **laws,
    )  # fmt: skip


def bundle(rng, laws=LAWS):
    length = rng.uniform(0.06, 0.4)
    units = [
        fs.MotorUnit(muscle(rng, length, **laws[rng.integers(len(laws))]), int(rng.integers(1, 5)))
        for _ in range(rng.integers(2, 5))
    ]
    return fs.Bundle(units, supply_pressure=6e5)


def crossings(made, P):
    """Ends of the cells of a grid in which the force changes its sign, snaps left out."""
    # before the least free strain all units pull
    low = min(
        float(unit.muscle.free_strain(p)) for unit, p in zip(made.motor_units, P, strict=True)
    )
    eps = np.linspace(low + 1e-9, DOMAIN, GRID)
    force = np.asarray(made.force(P, eps))
    (cells,) = np.nonzero((force[1:] > 0) != (force[:-1] > 0))
    step, size = eps[1] - eps[0], np.abs(force).max()
    # what jumps between two strains is no zero: it is a snap of the elastica
    real = [i for i in cells if abs(force[i + 1] - force[i]) < 0.02 * size + step * 1e3 * size]
    return [(eps[i], eps[i + 1]) for i in real], size


@pytest.mark.parametrize(("seed", "count"), [(0, 4), pytest.param(1, 200, marks=pytest.mark.slow)])
def test_no_zero_is_missed(seed, count):
    rng, seen = np.random.default_rng(seed), 0
    for _ in range(count):
        made = bundle(rng)
        units = len(made.motor_units)
        for P in rng.uniform(0, 6e5, (4, units)) * (rng.random((4, units)) > 0.25):
            cells, size = crossings(made, P)
            found = made.equilibria(P)
            zeros = np.asarray(found.strain)[np.isfinite(found.strain)]
            snaps = np.any(np.asarray(made.force(P, zeros[zeros <= DOMAIN])) > 1e-6 * size)
            for low, high in cells:
                seen += 1
                # a grid's end may be the zero itself
                near = (zeros >= low - 1e-9) & (zeros <= high + 1e-9)
                assert np.any(near) or snaps, (made, P, low)
            first = float(made.free_strain(P))
            if cells:
                assert first <= cells[0][1] + 1e-9, (made, P)
            if first <= DOMAIN and not snaps:
                assert abs(float(made.force(P, first))) <= 1e-6 * (size + 1), (made, P)
    assert seen > 2 * count


@pytest.mark.parametrize("scheme", ["orderly", "batch"])
@pytest.mark.parametrize(
    ("seed", "count", "laws"),
    # the elastica, which looks for its folds, takes ten times as long
    [(2, 1, (*LAWS[:2], *LAWS[3:])), pytest.param(3, 10, LAWS, marks=pytest.mark.slow)],
)
def test_no_reachable_force_is_denied(scheme, seed, count, laws):
    rng, levels = np.random.default_rng(seed), np.linspace(0, 1, 1001)
    for _ in range(count):
        made = bundle(rng, laws)
        strain = rng.uniform(0.0, 0.4, 5)
        # every pressure that the scheme has, on a grid
        units, grid = len(made.motor_units), []
        for state in range(units):
            full = np.arange(units) < state if scheme == "orderly" else np.zeros(units, bool)
            moved = np.arange(units) == state if scheme == "orderly" else np.arange(units) <= state
            shares = np.where(moved, levels[:, None], np.where(full, 1.0, 0.0))
            grid.append(np.asarray(made.force(6e5 * shares[:, None], strain)))
        forces = np.stack(grid)
        for i, eps in enumerate(strain):
            least, most = forces[..., i].min(), forces[..., i].max()
            wanted = np.r_[rng.uniform(least, most, 20), least - 5.0, most + 5.0]
            found = fs.recruitment.recruit(made, wanted, eps, scheme=scheme)
            for j, F in enumerate(wanted):
                here = forces[..., i]
                between = np.any((here[:, 1:] > F) != (here[:, :-1] > F))
                # a sign that changes in one cell of the grid may be a snap, and no answer
                steps = np.abs(np.diff(here, axis=1)).max()
                best = np.abs(here - F).min()
                reached = bool(found.status[j] == 0)
                assert reached or not between or steps > 0.05 * (most - least), (made, eps, F)
                # what is given is never further off than the grid's best
                off = abs(float(found.force[j]) - F)
                assert off <= best + 1e-6 * (abs(F) + 1), (made, eps, F)

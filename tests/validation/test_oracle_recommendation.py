"""Recommended designs against plain NumPy: 30 random tasks, designs by their muscles' forces.

The oracle takes forces from `Muscle.force` at no and at full pressure, where all demanded points of
these tasks are pulls, draws its own scatter, and knows dominance by its definition.
"""

import itertools

import numpy as np
import pytest

import fascicle as fs
from fascicle.design import Limit, Space, Task, Uncertainty, judge_safety, search, spread


SENSES = {"mean_efficiency": "max", "envelope": "min", "valves": "min"}
DRAWS = 600
# a share of so many draws, and that of 2000 of the search: four standard errors of their difference
TOLERANCE = 4 * np.sqrt(0.95 * 0.05 * (1 / DRAWS + 1 / 2000))


def largest_forces(muscle, counts, strain, supply):
    """Largest force [N] of a bundle in any orderly state, by points."""
    none, full = (np.asarray(muscle.force(P, strain)) for P in (0.0, supply))
    totals = [sum(counts[: k + 1]) * full + sum(counts[k + 1 :]) * none for k in range(len(counts))]
    return np.max(totals, axis=0)


SAMPLE = 6  # the others by `make slow`


@pytest.mark.parametrize(
    "seed", [*range(SAMPLE), *(pytest.param(x, marks=pytest.mark.slow) for x in range(SAMPLE, 30))]
)
def test_recommendation(seed):
    rng = np.random.default_rng(seed)
    muscle = fs.example("kim2021_slenderness_10")
    strain = rng.uniform(0.02, 0.14, 2)
    force = rng.uniform(0.1, 0.5, 2) * 900 * (1 - strain / 0.25)
    supply = rng.uniform(300e3, 600e3)
    task = Task.of(force, strain, supply)
    space = Space({"m": muscle}, (1, 2, 3, 4), radius=(5e-3, 6.5e-3, 8e-3), length=(0.1, 0.14))
    limits = {"envelope": Limit(most=rng.uniform(0.03, 0.08))}
    uncertainty = Uncertainty()
    result = judge_safety(search(space, task, SENSES, limits), uncertainty)
    if result.best is None:
        assert result.nearest is not None
        return
    scatter = uncertainty.scatter
    z = rng.standard_normal((DRAWS, 4))
    volume = []
    for index, design in enumerate(result.front):
        counts = [int(n) for n in result.designs.counts[index] if n]
        built = result.designs.muscle(index)
        # every load case is met
        largest = largest_forces(built, counts, strain, supply)
        assert np.all(largest >= force)
        np.testing.assert_allclose(
            result.values["margin"][design], np.min(largest - force), rtol=1e-6, atol=1e-6
        )
        volume.append(sum(counts) * float(built.outer_radius) ** 2 * float(built.length))
    row = result.recommended
    counts = [int(n) for n in result.designs.counts[row] if n]
    built = result.designs.muscle(row)
    held = []
    for a, b, c, d in z:
        drawn = built.replace(
            length=built.length * (1 + scatter.length * a),
            wall_thickness=built.wall_thickness * max(1 + scatter.wall_thickness * b, 0.05),
            braid_angle=built.braid_angle + scatter.braid_angle * c,
        )
        factor = np.exp(scatter.model_error * d)
        held.append(np.all(factor * largest_forces(drawn, counts, strain, supply) >= force))
    # safe within sampling error; the envelope may fail in further draws
    assert np.mean(held) >= 0.95 - TOLERANCE
    # no listed design dominates another; of equal ones the smallest is listed
    front = [{n: float(result.values[n][i]) for n in SENSES} for i in result.front]

    def as_good(a, b):
        return all(a[n] >= b[n] if s == "max" else a[n] <= b[n] for n, s in SENSES.items())

    for (i, a), (j, b) in itertools.permutations(enumerate(front), 2):
        assert not as_good(a, b) or (a == b and np.isclose(volume[i], volume[j]))
    # to any other safe design one of the list is as good, up to rounding
    others = np.setdiff1d(np.flatnonzero(result.allowed), result.front)
    shares = spread(result.all_designs(others), task, (), limits, scatter, draws=256).probability
    for other in others[shares > 0.99]:
        worse = {
            n: result.values[n][other] * (1 - 1e-9 if s == "max" else 1 + 1e-9)
            for n, s in SENSES.items()
        }
        assert any(as_good(a, worse) for a in front)
    # the recommended one has the least bad worst objective, by its definition
    worst = []
    for design in front:
        losses = []
        for name, sense in SENSES.items():
            values = [other[name] for other in front]
            best, bad = (max, min) if sense == "max" else (min, max)
            span = abs(bad(values) - best(values)) or 1.0
            losses.append(abs(design[name] - best(values)) / span)
        worst.append(max(losses))
    assert worst[row] == pytest.approx(min(worst), abs=1e-9)
    ties = [i for i in range(len(front)) if worst[i] < worst[row] + 1e-9 and front[i] == front[row]]
    assert volume[row] <= min(volume[i] for i in ties) * (1 + 1e-9)

"""Every objective of a design against the slow computation, on random designs."""

import math

import numpy as np
import oracle_design as oracle
import pytest
from from_oracle import library_muscle
from oracle_muscle import LATEX, SILICONE, Muscle, free_strain

from fascicle.design import Designs, Task, evaluate
from fascicle.design.designs import packed_radius, packing_ratio
from fascicle.design.evaluation import MIXED, Resolution
from fascicle.design.objectives import OBJECTIVES


NAMES = tuple(OBJECTIVES)
UNITS, POINTS = 3, 8  # one shape for all designs, so that little is compiled
COARSE = Resolution(17, 65)  # the oracle takes a second for every ten thousand forces


def random_muscle(rng, length, **laws):
    radius = rng.uniform(4e-3, 9e-3)
    return Muscle(
        length=length,
        outer_radius=radius,
        wall_thickness=radius * rng.uniform(0.15, 0.3),
        braid_angle=math.radians(rng.uniform(25, 38)),
        transition_rate=40.0,
        **laws,
    )


def random_designs(seed, count, alike):
    """Bundles of up to three units, of one muscle or of unlike ones, and a task for each."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        length = rng.uniform(80e-3, 200e-3)
        material = (LATEX, SILICONE)[rng.integers(2)]
        units = rng.integers(1, UNITS + 1)
        muscles = [random_muscle(rng, length, material=material) for _ in range(units)]
        if alike:
            muscles = muscles[:1] * units
        counts = rng.integers(1, 5, units)
        design = tuple(zip(muscles, counts.tolist(), strict=True))
        supply = rng.uniform(200e3, 450e3)
        strain = np.sort(rng.uniform(0.005, 0.24, POINTS))
        # forces up to what the bundle has at rest, fewer where it has contracted
        force = oracle.largest_force(design, supply) * rng.uniform(0, 1, POINTS) ** 2
        task = [(float(f), float(e), float(rng.uniform(0.5, 2))) for f, e in
                zip(force * (1 - strain / 0.3), strain, strict=True)]  # fmt: skip
        yield design, supply, tuple(task)


def library(design, supply, task, alike, resolution, scheme="orderly", by_stroke=False):
    force, strain, weight = map(np.array, zip(*task, strict=True))
    if by_stroke:
        stroke = strain * design[0][0].length
        asked = Task.of(force, None, supply, weight, scheme, stroke=stroke)
    else:
        asked = Task.of(force, strain, supply, weight, scheme)
    counts = np.zeros((1, UNITS), int)
    counts[0, : len(design)] = [n for _, n in design]
    muscles = [muscle for muscle, _ in design]
    muscles += muscles[:1] * (UNITS - len(muscles))
    sizes = (
        np.array([[getattr(m, name) for m in muscles]])
        for name in ("outer_radius", "wall_thickness", "braid_angle")
    )
    drawing, length = library_muscle(muscles[0]), np.array([muscles[0].length])
    designs = Designs({"muscle": drawing}, np.zeros(1, int), counts, length, *sizes)
    assert bool(designs.uniform[0]) is (alike or len(design) == 1)
    values = evaluate(designs, asked, NAMES, resolution)
    return {name: float(values[name][0]) for name in NAMES}


def expected(design, supply, task, resolution, scheme="orderly"):
    levels = resolution.level.tolist()
    top = max(free_strain(muscle, supply) for muscle, _ in design)
    strains = np.linspace(0, 1, resolution.strains) * top
    return {
        **oracle.task_objectives(design, supply, task, levels, scheme),
        "reversal_depth": oracle.reversal_depth(design, supply, levels, strains.tolist()),
        "overlap_width": oracle.overlap_width(design, supply, levels, strains.tolist(), scheme),
        "largest_force": oracle.largest_force(design, supply),
        "force_resolution": oracle.force_resolution(design, supply),
        "valves": len(design),
        "envelope": oracle.envelope(design, task, _packed),
    }


def _packed(radii):
    return float(packed_radius(np.asarray(radii), np.ones(len(radii), int)))


def compare(design, supply, task, alike, resolution, scheme="orderly", by_stroke=False):
    got = library(design, supply, task, alike, resolution, scheme, by_stroke)
    want = expected(design, supply, task, resolution, scheme)
    assert got.keys() == want.keys()
    step = free_strain(design[0][0], supply) / (resolution.strains - 1)
    for name, value in want.items():
        # forces agree to 1e-8 of themselves and a newton, each muscle; so does all made of them
        tolerance = 1e-7 * (1 + abs(value))
        if name == "reversal_depth":
            # a zero between two strains is taken on the chord: a kink there moves it by less
            # than a quarter of the step, at either end of the fall
            tolerance = 0.5 * step
        elif name == "envelope":
            tolerance = 1e-9  # m
        assert abs(got[name] - value) <= tolerance, (name, got[name], value, design, task)


@pytest.mark.parametrize("alike", [True, False])
@pytest.mark.parametrize("count", [8, pytest.param(25, marks=pytest.mark.slow)])
def test_every_objective_of_random_designs(alike, count):
    for design, supply, task in random_designs(21 + alike, count, alike):
        compare(design, supply, task, alike, COARSE)


@pytest.mark.parametrize("alike", [True, False])
def test_a_task_of_strokes_is_one_of_strains_for_each_length(alike):
    for design, supply, task in random_designs(51 + alike, 4, alike):
        compare(design, supply, task, alike, COARSE, by_stroke=True)


@pytest.mark.parametrize("alike", [True, False])
def test_what_reaches_is_what_the_oracle_says_reaches(alike):
    """Points a hair inside and a hair outside of what the design gives, of hardly any weight."""
    levels = COARSE.level.tolist()
    for design, supply, task in random_designs(61 + alike, 3, alike):
        strain = 0.05
        top = max(oracle.region(design, supply, k, strain, levels)[1] for k in range(len(design)))
        # forces agree to 1e-8 of themselves and a newton, each muscle
        hair = 1e-6 * (1 + top)
        easy = tuple((0.5 * top, strain, weight) for *_, weight in task)
        for force, reached in ((top - hair, True), (top + hair, False)):
            asked = (*easy[1:], (force, strain, 1e-9))
            assert oracle.reaches(design, supply, asked, levels) is reached
            got = library(design, supply, asked, alike, COARSE)
            assert (got["points_not_reached"] == 0) is reached
            assert (got["margin"] >= 0) is reached
            # as much as an eighth of the points may be missed, and of the weight much less is
            assert oracle.reaches(design, supply, asked, levels, may_miss=0.2)
            assert got["not_reached"] < 1e-6


@pytest.mark.parametrize(
    ("alike", "count"),
    [(True, 1), (False, 1), *(pytest.param(x, 5, marks=pytest.mark.slow) for x in (True, False))],
)
def test_batch_recruitment(alike, count):
    for design, supply, task in random_designs(31 + alike, count, alike):
        compare(design, supply, task, alike, COARSE, "batch")


def test_levels_are_fine_enough_for_the_task():
    """Regions over 33 levels against 8 times as many: what is missed at their lower edges."""
    missed = []
    for design, supply, task in random_designs(41, 3, True):
        for _, strain, _ in task:
            for k in range(len(design)):
                fine = np.linspace(0, 1, 8 * (MIXED.levels - 1) + 1) ** 1.5
                low, high = oracle.region(design, supply, k, strain, MIXED.level.tolist())
                lower, higher = oracle.region(design, supply, k, strain, fine.tolist())
                assert high == higher  # at full pressure
                missed.append((low - lower) / oracle.largest_force(design, supply))
    # the least force may lie between two levels, where it has a kink
    assert 0 <= max(missed) < 0.01


# the proved ones among them are known to all their digits; a search finds no denser packing
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6, 7, 8, 9])
def test_circles_are_packed_as_densely_as_a_search_finds(count):
    found = oracle.equal_packing(count, np.random.default_rng(count))
    # four decimals are kept
    assert float(packing_ratio(count)) == pytest.approx(found, rel=0, abs=6e-5)

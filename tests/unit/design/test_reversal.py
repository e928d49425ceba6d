"""Reversal and overlap of compositions, against every level told apart everywhere."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.bundle.schemes import Batch, Orderly
from fascicle.design import Task
from fascicle.design.designs import Sizes
from fascicle.design.evaluation import Resolution, every_level_table
from fascicle.design.outcome import Demand, existing_states, recruitment_states
from fascicle.design.reversal import (
    chord_zero,
    first_push,
    largest_overlap,
    reversal_depth,
    uniform_reversal_depths,
)
from fascicle.design.space import compositions


SUPPLY, N, COARSE = 413.7e3, 6, Resolution(33, 65)


@pytest.fixture(scope="module", params=[(1.0, 1.0, 1.0, 1.0), (1.5, 1.2, 1.1, 0.8)], ids=str)
def sizes(request, muscle):
    own = (muscle.length, muscle.outer_radius, muscle.wall_thickness, muscle.braid_angle)
    return Sizes(*(float(x) * by for x, by in zip(own, request.param, strict=True)))


@pytest.fixture
def curves(muscle, sizes):
    top = float(sizes.muscle(muscle).free_strain(SUPPLY))
    demand = Demand.from_task(Task.of(1.0, 0.01, SUPPLY))
    one = Sizes(*(np.array([size]) for size in sizes))
    return every_level_table(muscle, one, demand, (), COARSE, top)[1][..., 0], top


def test_curves_are_those_of_the_muscle(muscle, sizes, curves):
    force, top = curves
    twin = sizes.muscle(muscle)
    expected = twin.force(COARSE.level[:, None] * SUPPLY, top * np.linspace(0, 1, 65))
    assert_allclose(force, expected, rtol=1e-12, atol=1e-9)


def first_zero(force, top):
    """First strain at which a force over even strains vanishes, on the chord."""
    right = first_push(force)
    left, right_force = (np.take_along_axis(force, (right + i)[:, None], 1)[:, 0] for i in (-1, 0))
    return top * (right - 1 + chord_zero(left, right_force)) / (force.shape[-1] - 1)


def test_every_depth(curves):
    (force, top), counts = curves, compositions(N).T
    states = recruitment_states(Orderly(), N)
    depths = uniform_reversal_depths(counts, force, top, states)
    for design, depth in zip(counts.T, depths, strict=True):
        falls = [0.0]
        for before, n in zip(np.cumsum(design) - design, design, strict=True):
            if before and n:
                total = before * force[-1] + n * force + (N - before - n) * force[0]
                zeros = first_zero(total, top)
                falls.append(zeros[0] - zeros.min())
        assert depth == pytest.approx(max(falls), rel=1e-12, abs=1e-15)
        alone = reversal_depth(design, np.repeat(force[..., None], N, axis=-1), top, states)
        assert alone == pytest.approx(depth, rel=1e-12, abs=1e-14)
    assert depths.max() > 0


@pytest.mark.parametrize("scheme", [Orderly(), Batch()], ids=str)
def test_every_overlap(curves, scheme):
    force, counts = curves[0], compositions(N).T
    states = recruitment_states(scheme, N)
    ends = np.stack([force.min(axis=0), force.max(axis=0)])[..., None, None]
    exists = existing_states(scheme, counts > 0)
    widths = largest_overlap(counts, force[..., None, None], ends, states, exists)

    def state(before, own):
        total = before * force[-1] + own * force + (N - before - own) * force[0]
        return total.min(axis=0), total.max(axis=0)

    for design, width in zip(counts.T, widths, strict=True):
        units = design[design > 0]
        before = np.cumsum(units) - units
        if scheme == Orderly():
            edges = [state(a, n) for a, n in zip(before, units, strict=True)]
        else:
            edges = [state(0, a + n) for a, n in zip(before, units, strict=True)]
        expected = 0.0
        for (low, high), (next_low, next_high) in pairwise(edges):
            bottom = np.maximum(np.maximum(low, next_low), 0.0)
            expected = max(expected, float(np.max(np.minimum(high, next_high) - bottom)))
        assert width == pytest.approx(expected, rel=1e-10, abs=1e-9)
    assert widths.max() > 0

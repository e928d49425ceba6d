"""Pairs of unlike muscles against the bundle that they are."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.core.module import with_fields
from fascicle.records.dynamometer import Pairs, Scatter, agreements, fabricated_pairs


muscle = fs.example("kim2021_slenderness_10")
FIRST, SECOND = 344.7e3, np.array([0.0, 69e3, 200e3])
SCATTER = Scatter(0.02, 0.01)
P = np.stack(np.broadcast_arrays(FIRST, SECOND), axis=-1)


@pytest.fixture(scope="module")
def found():
    return fabricated_pairs(muscle, SCATTER, FIRST, SECOND, draws=3, seed=4)


def test_the_drawing_s_pair_is_two_equal_muscles(found):
    bundle = fs.Bundle([fs.MotorUnit(muscle)] * 2)
    # roots to 1e-13, compiled apart
    assert_allclose(found.nominal, bundle.free_strain(P), atol=1e-11)
    still = fabricated_pairs(muscle, Scatter(), FIRST, SECOND, draws=3)
    assert_array_equal(still.deviation, 0)


def test_a_pair_starts_where_it_neither_pulls_nor_pushes(found):
    made = SCATTER.draw(muscle, np.random.default_rng(4), (3, 2))
    for row, lengths, angles in zip(found.free_strain, made.length, made.braid_angle, strict=True):
        units = [
            fs.MotorUnit(with_fields(muscle, length=lengths[i], braid_angle=angles[i]))
            for i in range(2)
        ]
        # from a distance of its own: only the pair's own rest counts
        bundle = fs.Bundle(units, length=0.126)
        rest = 0.126 * (1 - float(bundle.free_strain([0.0, 0.0])))
        moved = 0.126 * (1 - np.asarray(bundle.free_strain(P)))
        assert_allclose(row, 1 - moved / rest, atol=1e-11)
        assert np.all(np.abs(row - found.nominal) > 1e-6)


def test_seeds_fix_the_pairs(found):
    again = fabricated_pairs(muscle, SCATTER, FIRST, SECOND, draws=3, seed=4)
    assert_array_equal(again.free_strain, found.free_strain)
    other = fabricated_pairs(muscle, SCATTER, FIRST, SECOND, draws=3, seed=5)
    assert np.all(other.free_strain != found.free_strain)


def test_agreement_lets_one_point_out():
    off = np.array([
        [0.09, -0.09, 0.0],  # better than the paper's
        [0.09, -0.14, 0.0],  # just so
        [0.11, -0.14, 0.0],  # two out
        [0.00, 0.16, 0.0],  # one too far out
    ])  # fmt: skip
    pairs = Pairs(np.arange(3.0), np.full(3, 0.25), 0.25 * (1 + off))
    assert pairs.agreement() == (0.5, 0.25)
    assert pairs.agreement(most=0.2, outlier=0.2) == (1.0, 0.0)


def test_more_scatter_agrees_less():
    shares = agreements(muscle, [Scatter(), Scatter(0.05, 0.05)], FIRST, SECOND, draws=60)
    assert_array_equal(shares[0], [1.0, 0.0])
    assert shares[1, 0] < 0.9 and shares[1, 1] <= shares[1, 0]


def test_a_long_muscle_beside_a_short_one_is_solved_for():
    """At rest the long one's plates would pull the short one's fibers past straight; the pair's
    own distance is between.
    """
    pressures = np.array([0.0, FIRST])
    pairs = fabricated_pairs(muscle, Scatter(length=0.08), FIRST, pressures, draws=60)
    made = Scatter(length=0.08).draw(muscle, np.random.default_rng(0), (60, 2)).length
    assert np.any(made.max(axis=1) >= made.min(axis=1) / np.cos(muscle.braid_angle))
    assert np.all(np.isfinite(pairs.free_strain))

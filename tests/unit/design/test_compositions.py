"""Reversal and overlap of compositions, against every level told apart everywhere."""

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.design.designs import Rows
from fascicle.design.every_level import first_zeros
from fascicle.design.reversal import curves_of, depths, overlaps
from fascicle.design.tables import Resolution


SUPPLY, N = 413.7e3, 6


@pytest.fixture(scope="module")
def curves(muscle):
    sizes = ((1.0, 1.5), (1.0, 1.2), (1.0, 1.1), (1.0, 0.8))
    own = (muscle.length, muscle.outer_radius, muscle.wall_thickness, muscle.braid_angle)
    rows = Rows(muscle, *(x * np.array(by) for x, by in zip(own, sizes, strict=True)))
    return curves_of(rows, SUPPLY, Resolution(33, 65))


def test_curves_are_those_of_each_muscle(muscle, curves):
    level = Resolution(33, 65).level
    top = float(muscle.free_strain(SUPPLY))
    force = muscle.force(level[:, None] * SUPPLY, top * np.linspace(0, 1, 65))
    assert_allclose(curves[0].force, force, rtol=1e-12, atol=1e-9)
    assert curves[0].top == pytest.approx(top, rel=1e-14)
    assert not np.allclose(curves[0].force, curves[1].force)


def test_every_depth(curves):
    for one in curves:
        found = depths(one, N, 8)
        full, none = one.force[-1], one.force[0]
        for a in range(9):
            for n in range(9):
                want = 0.0
                if a >= 1 and n >= 1 and a + n <= N:
                    force = a * full + n * one.force + (N - a - n) * none
                    zeros = np.asarray(first_zeros(jnp.asarray(force), jnp.asarray(one.top)))
                    want = zeros[0] - zeros.min()
                assert found[a, n] == pytest.approx(want, rel=1e-12, abs=1e-15)
        assert found.max() > 0


@pytest.mark.parametrize("scheme", ["orderly", "batch"])
def test_every_overlap(curves, scheme):
    one = curves[0]
    found = overlaps(one, N, 8, held=scheme == "orderly")
    full, none = one.force[-1], one.force[0]

    def state(before, own):
        if scheme == "batch":
            before, own = 0, before + own
        force = before * full + own * one.force + (N - before - own) * none
        return force.min(axis=0), force.max(axis=0)

    for a, n, m in np.ndindex(found.shape):
        want = 0.0
        if n >= 1 and m >= 1 and a + n + m <= N:
            (low, high), (next_low, next_high) = state(a, n), state(a + n, m)
            bottom = np.maximum(np.maximum(low, next_low), 0.0)
            want = max(0.0, float(np.max(np.minimum(high, next_high) - bottom)))
        assert found[a, n, m] == pytest.approx(want, rel=1e-10, abs=1e-9)
    assert found.max() > 0

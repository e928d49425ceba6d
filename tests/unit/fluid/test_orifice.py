import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid


A, RHO, CD, CR = 1e-6, 850.0, 0.611, 1e3
orifice = fluid.Orifice(A, RHO)
hosed = fluid.Orifice(A, RHO, line=fluid.Line(2.0, 0.004))
both = pytest.mark.parametrize("of", [orifice, hosed], ids=["alone", "with a hose"])


def test_root_law_far_above_the_transition():
    drop = np.array([1e5, 4e5, 1e6])
    expected = CD * A * np.sqrt(2 * RHO * drop)
    # the transition takes (Δp_cr/Δp)²/4 of it
    assert_allclose(orifice.flow(drop, 0.0), expected, rtol=3e-5)
    assert_allclose(orifice.flow(drop + 1e6, 1e6), orifice.flow(drop, 0.0), rtol=1e-13)


def test_linear_at_equal_pressures():
    drop = np.array([1e-3, 1.0, 10.0])
    slope = CD * A * np.sqrt(2 * RHO / CR)
    assert_allclose(orifice.flow(drop, 0.0), slope * drop, rtol=1e-4)
    assert orifice.flow(3e5, 3e5) == 0


@both
def test_flow_back_is_flow_the_other_way(of):
    drop = np.geomspace(1e-3, 1e6, 40)
    flows = of.flow(drop, 0.0)
    assert np.all(of.flow(0.0, drop) == -flows)
    assert np.all(np.diff(flows) > 0)


@both
def test_closed_is_shut(of):
    assert np.all(of.flow(np.array([0.0, 1e5, 1e6]), 1e5, opening=0.0) == 0)


def test_a_hose_takes_its_share():
    assert 0 < hosed.flow(4e5, 0.0) < orifice.flow(4e5, 0.0)
    # laminar where little flows: Hagen and Poiseuille in series with the linear end
    own = orifice.flow(1e-3, 0.0) / 1e-3
    a = hosed.line.laminar_resistance(RHO)
    both_ends = 2 / (a + np.sqrt(a**2 + 4 / own**2))
    assert_allclose(hosed.flow(1e-3, 0.0) / 1e-3, both_ends, rtol=1e-3)


@both
@pytest.mark.parametrize("opening", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("sides", [(0.0, 0.0), (4e5, 0.0), (0.0, 4e5), (3e5, 3e5), (500.0, 0.0)])
def test_slopes_are_finite_and_those_of_differences(of, sides, opening):
    def flow(p1, p2, o):
        return of.flow(p1, p2, opening=o)

    at = (*sides, opening)
    backward = jax.grad(flow, (0, 1, 2))(*at)
    assert_allclose(backward, jax.jacfwd(flow, (0, 1, 2))(*at), rtol=1e-12, atol=1e-20)
    by_numbers = jax.tree.leaves(jax.grad(lambda v: v.flow(*sides, opening=opening))(of))
    assert all(np.all(np.isfinite(x)) for x in by_numbers)
    for i, step in enumerate((1.0, 1.0, 1e-6)):
        up, down = list(at), list(at)
        up[i], down[i] = at[i] + step, at[i] - step
        measured = (flow(*up) - flow(*down)) / (2 * step)
        assert_allclose(backward[i], measured, rtol=1e-5, atol=1e-13 / step)

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid
from fascicle.fluid.flow_elements import in_series


C, B, T = 1e-8, 0.3, 293.15
HIGH = 6e5
valve = fluid.SonicValve(C, B)
hosed = fluid.SonicValve(C, B, line=fluid.Line(1.0, 0.004))
both = pytest.mark.parametrize("of", [valve, hosed], ids=["alone", "with a hose"])


def through(of, high, low, opening=1.0):
    return of.flow(high, low, T, T, opening)


@both
def test_flow_is_continuous(of):
    edges = [B, 0.999]
    if of is hosed:
        edges[0] = float(of.hose_series(True, 1.0)[1])
    for edge in edges:
        below, above = through(of, HIGH, HIGH * (edge + np.array([-1e-12, 1e-12])))
        # the steepest slope is some 1e3 of the flow
        assert_allclose(below, above, rtol=1e-8)


@both
def test_flow_falls_as_the_pressure_downstream_rises(of):
    flows = through(of, HIGH, HIGH * np.linspace(0, 1, 5001))
    assert np.all(np.diff(flows) <= 1e-18) and flows[-1] == 0


def test_flow_back_is_flow_the_other_way():
    low = HIGH * np.linspace(0.01, 1, 50)
    assert np.all(valve.flow(low, HIGH, 400.0, T) == -valve.flow(HIGH, low, T, 400.0))
    # it is as warm as where it comes from
    assert_allclose(valve.flow(HIGH, 1e5, 4 * T, T), valve.flow(HIGH, 1e5, T, T) / 2, rtol=1e-14)


def test_flow_back_meets_the_hose_first():
    onward, back = through(hosed, HIGH, 1e5), -through(hosed, 1e5, HIGH)
    hose = (hosed.line.conductance, hosed.line.critical_pressure_ratio)
    for flow, pair in ((onward, in_series(C, B, *hose)), (back, in_series(*hose, C, B))):
        assert_allclose(flow, through(fluid.SonicValve(*pair), HIGH, 1e5), rtol=1e-14)
    assert onward < through(valve, HIGH, 1e5) and onward != back


@both
def test_closed_is_shut(of):
    pressures = np.array([1e3, 1e5, HIGH, 1e6])
    assert np.all(through(of, HIGH, pressures, 0.0) == 0)


def test_a_wide_hose_is_no_hose():
    wide = fluid.SonicValve(C, B, line=fluid.Line(0.05, 0.05))
    low = HIGH * np.linspace(0.01, 0.998, 50)
    # it conducts 250 times as well
    assert_allclose(through(wide, HIGH, low), through(valve, HIGH, low), rtol=1e-4)


def test_a_valve_that_hardly_opens_feels_no_hose():
    low = np.array([1e5, 4e5])
    for flows in ((HIGH, low), (low, HIGH)):
        ratio = through(hosed, *flows, 1e-5) / through(valve, *flows, 1e-5)
        assert_allclose(ratio, 1, rtol=1e-4)


SIDES = [(HIGH, HIGH), (HIGH, 1e5), (1e5, HIGH), (HIGH, 0.9995 * HIGH), (HIGH, 0.7 * HIGH),
         (101325.0, 101325.0), (HIGH, 0.0)]  # fmt: skip


@both
@pytest.mark.parametrize("opening", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("sides", SIDES)
def test_slopes_are_finite_and_those_of_differences(of, sides, opening):
    def flow(p1, p2, o):
        return of.flow(p1, p2, T, T, o)

    at = (*sides, opening)
    backward = jax.grad(flow, (0, 1, 2))(*at)
    forward = jax.jacfwd(flow, (0, 1, 2))(*at)
    by_numbers = jax.tree.leaves(jax.grad(lambda v: v.flow(*sides, T, T, opening))(of))
    assert all(np.all(np.isfinite(x)) for x in (*backward, *forward, *by_numbers))
    assert_allclose(backward, forward, rtol=1e-12, atol=1e-20)
    steps = (1.0, 1.0, 1e-6)
    for i, step in enumerate(steps):
        up, down = list(at), list(at)
        up[i], down[i] = at[i] + step, at[i] - step
        measured = (flow(*up) - flow(*down)) / (2 * step)
        # of flows of 5e-3 kg/s, whose rounding the step divides
        assert_allclose(backward[i], measured, rtol=1e-4, atol=1e-14 / step)


def test_numpy_and_jax_agree_and_batch():
    rng = np.random.default_rng(0)
    p1, p2, o = rng.uniform(1e5, 1e6, (3, 4, 5))
    o = o / 1e6
    for of in (valve, hosed):
        plain = of.flow(p1, p2, T, 310.0, o)
        assert type(plain) is np.ndarray and plain.shape == (4, 5)
        compiled = jax.jit(of.flow)(p1, p2, T, 310.0, o)
        assert_allclose(plain, compiled, rtol=1e-12)
        one_by_one = jax.vmap(jax.vmap(lambda a, b, c: of.flow(a, b, T, 310.0, c)))(p1, p2, o)  # noqa: B023
        assert_allclose(plain, one_by_one, rtol=1e-12)
    many = fluid.SonicValve(np.array([1e-8, 2e-8]), B)
    assert_allclose(through(many, HIGH, 1e5)[1], 2 * through(valve, HIGH, 1e5), rtol=1e-14)
    assert through(many, jnp.full((3, 1), HIGH), 1e5).shape == (3, 2)

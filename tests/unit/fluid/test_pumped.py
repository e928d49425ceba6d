"""A pump that keeps an accumulator charged."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from fascicle import fluid
from fascicle.core.errors import InvalidInputError


STORE = fluid.Accumulator(1e-3, 3e5, 4e5)
FIXED = fluid.FixedPump(2e-6, 20.0, 0.9, 0.85)
SWITCHED = fluid.FixedPump(2e-6, 20.0, 0.9, 0.85, switch_on=4.5e5, switch_off=5.5e5)


def _ran(supply, drawn, end=2.0):
    """Its state after some seconds of a flow that is drawn [kg/s], the band not looked at."""

    def rates(_, state):
        return supply.rates(state, -drawn, 0.0)

    return solve_ivp(rates, (0, end), supply.initial_state(), "DOP853", rtol=1e-11, atol=1e-14).y.T


@pytest.mark.parametrize("drawn", [0.0, 0.02])
def test_what_the_shaft_does_is_stored_given_or_lost(drawn):
    supply = fluid.PumpedAccumulator(STORE, FIXED)
    states = _ran(supply, drawn)
    begin, end = states[0], states[-1]
    spent = supply.drive_energies(end)
    # what is drawn takes its energy along at the pressure of then, integrated apart
    given = solve_ivp(
        lambda _, y: [*supply.rates(y[:-1], -drawn, 0.0),
                      drawn * fluid.OIL.flow_energy(supply.pressure_at(y[:-1]))],
        (0, 2.0), [*begin, 0.0], "DOP853", rtol=1e-11, atol=1e-14,
    ).y[-1, -1]  # fmt: skip
    left = spent["shaft_work"] - spent["pump_lost"] - given
    stored = supply.stored_energy(end) - supply.stored_energy(begin)
    # of the shaft's work: what the integration leaves
    assert_allclose(left, stored, rtol=0, atol=1e-8 * spent["shaft_work"])
    assert spent["shaft_work"] > 0 and spent["pump_lost"] > 0


def test_pressure_switches_a_pump():
    supply = fluid.PumpedAccumulator(STORE, SWITCHED)
    state = supply.initial_state()
    assert state[1] == 1
    full = fluid.PumpedAccumulator(fluid.Accumulator(1e-3, 3e5, 5.6e5), SWITCHED)
    off = supply.update_switch(np.array([full.initial_state()[0], 1.0, 1.0, 2.0]))
    assert off.tolist() == [full.initial_state()[0], 0.0, 1.0, 2.0]
    assert supply.rates(off, -1e-3, 0.0).tolist() == [-1e-3, 0.0, 0.0, 0.0]
    between = fluid.Accumulator(1e-3, 3e5, 5e5).initial_state()[0]
    for on in (0.0, 1.0):  # what it was
        assert supply.update_switch(np.array([between, on, 0.0, 0.0]))[1] == on
    always = fluid.PumpedAccumulator(STORE, FIXED)
    assert always.update_switch(state).tolist() == state.tolist()


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"pump": fluid.FixedPump(1e-6, 10.0, liquid=fluid.WATER)},
         "`pump` must be for the accumulator's liquid"),
        ({"pump": STORE}, "`pump` must be `FixedPump`"),
    ],
)  # fmt: skip
def test_parts_that_don_t_go_together_are_refused(parts, words):
    with pytest.raises(InvalidInputError) as refused:
        fluid.PumpedAccumulator(STORE, **parts)
    assert str(refused.value).startswith(words)

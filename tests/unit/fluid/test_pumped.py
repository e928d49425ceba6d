"""A pump that keeps an accumulator charged."""

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from fascicle import fluid
from fascicle.core.errors import InvalidInputError


STORE = fluid.Accumulator(1e-3, 3e5, 4e5)
FIXED = fluid.FixedPump(2e-6, 20.0, 0.9, 0.85)
SWIVEL = fluid.VariablePump(2e-6, 20.0, 6e5, 5e4, 0.9, 0.85)
BAND = fluid.PressureBand(4.5e5, 5.5e5)
RELIEF = fluid.Relief(4.02e5, 1e-7)


def _ran(supply, drawn, end=2.0):
    """Its state after some seconds of a flow that is drawn [kg/s], the band not looked at."""

    def rates(_, state):
        return supply.rates(state, -drawn, 0.0)

    return solve_ivp(rates, (0, end), supply.initial_state(), "DOP853", rtol=1e-11, atol=1e-14).y.T


@pytest.mark.parametrize(
    ("supply", "drawn"),
    [(fluid.PumpedAccumulator(STORE, FIXED), 0.02), (fluid.PumpedAccumulator(STORE, SWIVEL), 0.0),
     (fluid.PumpedAccumulator(STORE, FIXED, relief=RELIEF), 0.0),
     (fluid.PumpedAccumulator(STORE, SWIVEL, relief=RELIEF), 0.01)],
)  # fmt: skip
def test_what_the_shaft_does_is_stored_given_or_lost(supply, drawn):
    states = _ran(supply, drawn)
    begin, end = states[0], states[-1]
    spent = supply.drive_energies(end)
    # what is drawn takes its energy along at the pressure of then, integrated apart
    given = solve_ivp(
        lambda _, y: [*supply.rates(y[:-1], -drawn, 0.0),
                      drawn * fluid.OIL.flow_energy(supply.pressure_at(y[:-1]))],
        (0, 2.0), [*begin, 0.0], "DOP853", rtol=1e-11, atol=1e-14,
    ).y[-1, -1]  # fmt: skip
    left = spent["shaft_work"] - spent["pump_lost"] - spent["relief_lost"] - given
    stored = supply.stored_energy(end) - supply.stored_energy(begin)
    # of the shaft's work: what the integration leaves
    assert_allclose(left, stored, rtol=0, atol=1e-8 * spent["shaft_work"])
    assert spent["shaft_work"] > 0 and spent["pump_lost"] > 0
    assert (spent["relief_lost"] > 0) == (supply.relief is not None)


def test_a_variable_pump_stops_at_its_setting():
    supply = fluid.PumpedAccumulator(STORE, SWIVEL)
    # 0.05 s is the slowest of its time constants there
    assert supply.pressure_at(_ran(supply, 0.0, 60.0)[-1]) == pytest.approx(6e5, rel=1e-3)


def test_the_band_switches_a_fixed_pump():
    supply = fluid.PumpedAccumulator(STORE, FIXED, BAND)
    state = supply.initial_state()
    assert state[1] == 1
    full = fluid.PumpedAccumulator(fluid.Accumulator(1e-3, 3e5, 5.6e5), FIXED, BAND)
    off = supply.update_switch(np.array([full.initial_state()[0], 1.0, 1.0, 2.0, 3.0]))
    assert off.tolist() == [full.initial_state()[0], 0.0, 1.0, 2.0, 3.0]
    assert supply.rates(off, -1e-3, 0.0).tolist() == [-1e-3, 0.0, 0.0, 0.0, 0.0]
    between = fluid.Accumulator(1e-3, 3e5, 5e5).initial_state()[0]
    for on in (0.0, 1.0):  # what it was
        assert supply.update_switch(np.array([between, on, 0.0, 0.0, 0.0]))[1] == on
    assert fluid.PumpedAccumulator(STORE, FIXED).update_switch(state) is state


def test_it_is_batched_and_differentiated():
    supply = fluid.PumpedAccumulator(STORE, FIXED, BAND, RELIEF)
    states = np.stack([supply.initial_state(), supply.initial_state()])
    many = jax.vmap(lambda s: supply.rates(supply.update_switch(s), -1e-3, 0.0))(states)
    assert_allclose(many[1], supply.rates(supply.initial_state(), -1e-3, 0.0), rtol=1e-12)
    slopes = jax.grad(lambda s: supply.rates(s, 0.0, 0.0)[2])(states[0])
    assert np.all(np.isfinite(slopes))


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"pump": SWIVEL, "band": BAND}, "`band` must be left out with a VariablePump"),
        ({"pump": fluid.FixedPump(1e-6, 10.0, liquid=fluid.WATER)},
         "`pump` must be for the accumulator's liquid"),
        ({"pump": BAND}, "`pump` must be `FixedPump` or `VariablePump`"),
        ({"pump": FIXED, "relief": BAND}, "`relief` must be `Relief`"),
    ],
)  # fmt: skip
def test_parts_that_don_t_go_together_are_refused(parts, words):
    with pytest.raises(InvalidInputError) as refused:
        fluid.PumpedAccumulator(STORE, **parts)
    assert str(refused.value).startswith(words)

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid


V, ROOM, WARM = 1e-4, 101325.0, 293.15
CHAMBERS = [
    fluid.AdiabaticWall(), fluid.AdiabaticWall(0.5, gas=fluid.NITROGEN, dead_volume=1e-5),
    fluid.Isothermal(),
    fluid.Isothermal(dead_volume=2e-5, room_pressure=8e4),
    fluid.LiquidChamber(), fluid.LiquidChamber(fluid.WATER, 2e-13, dead_volume=1e-5),
]  # fmt: skip
every = pytest.mark.parametrize("of", CHAMBERS, ids=lambda of: type(of).__name__)
PRESSURES = np.array([-5e4, 0.0, 1e3, 4e5])


@every
def test_state_has_names_and_units(of):
    assert len(of.names) == len(of.units) == of.count == of.state_at(1e5, V).shape[-1]
    assert of.state_at(PRESSURES[:, None], np.array([V, 2 * V])).shape == (4, 2, of.count)


@every
def test_start_is_in_balance_and_found_again(of):
    state = of.state_at(PRESSURES, V)
    at = of.state_residual(state, PRESSURES, V)
    # of p V, 10 to 50 J, or of 0.1 kg
    assert_allclose(at.value, 0, atol=1e-13)
    assert_allclose(of.static_pressure(state, V), PRESSURES, rtol=1e-12, atol=1e-6)
    assert np.all(of.lowest_pressure < PRESSURES)
    assert_allclose(of.temperature(state, PRESSURES), WARM, rtol=1e-14)


@every
def test_slopes_of_the_balance(of):
    for P in PRESSURES:
        state = of.state_at(P, V) * 1.01

        def value(s, P, V, of=of):
            return of.state_residual(s, P, V).value

        at = of.state_residual(state, P, V)
        by_state, by_pressure, by_volume = jax.grad(value, (0, 1, 2))(state, P, V)
        assert_allclose(at.by_state, by_state, rtol=1e-12)
        assert_allclose(at.by_pressure, by_pressure, rtol=1e-12)
        assert_allclose(at.by_volume, by_volume, rtol=1e-12)
        assert at.by_pressure > 0 and at.by_volume > 0
        assert at.by_state.shape == state.shape


def test_temperature_and_heat():
    of = fluid.AdiabaticWall(0.5)
    state = of.state_at(3e5, V) * np.array([1.0, 1.1])
    assert_allclose(of.temperature(state), 1.1 * WARM, rtol=1e-13)
    assert_allclose(of.heat_flow(state, 3e5, 0.0, 0.0, 0.0), 0.05 * WARM, rtol=1e-12)
    assert_allclose(of.rates(state, 3e5, 0.0, 0.0, 0.0), [0, -0.05 * WARM], rtol=1e-12)
    # compressed at one temperature, all work leaves as heat
    held = fluid.Isothermal()
    work = (3e5 + ROOM) * 1e-5
    assert_allclose(held.heat_flow(held.state_at(3e5, V), 3e5, 0.0, 0.0, -1e-5), work, rtol=1e-13)
    # what comes in and is as warm already leaves R T of flow work
    flow = 1e-3
    heat = held.heat_flow(held.state_at(3e5, V), 3e5, flow, fluid.AIR.c_p * WARM * flow, 0.0)
    assert_allclose(heat, flow * fluid.AIR.specific_gas_constant * WARM, rtol=1e-12)


def test_stored_is_zero_as_the_room_is():
    for of in CHAMBERS:
        assert_allclose(of.stored_energy(of.state_at(0.0, V), 0.0), 0, atol=1e-13)
        assert of.stored_energy(of.state_at(4e5, V), 4e5) > 0
        assert of.stored_energy(of.state_at(-5e4, V), -5e4) > 0  # a vacuum is worth something


@every
@pytest.mark.parametrize("pressure", [-ROOM, 0.0, 4e5])
def test_everything_is_finite_with_its_slopes(of, pressure):
    """As empty as can be, too, and without any mass."""
    state = of.state_at(max(pressure, -0.999 * float(of.room_pressure)), V)
    for s in (state, 0.0 * state):

        def all_of_it(s, P, V, of=of):
            out = [of.static_pressure(s, V), of.temperature(s, P), of.stored_energy(s, P),
                   *of.state_residual(s, P, V), *of.rates(s, P, 1e-4, 30.0, 1e-5),
                   of.per_volume_rate(s, P)]  # fmt: skip
            return sum(np.sum(x) if isinstance(x, np.ndarray) else x.sum() for x in out)

        slopes = jax.grad(all_of_it, (0, 1, 2))(s, pressure, V)
        assert all(np.all(np.isfinite(x)) for x in slopes)
        by_numbers = jax.grad(lambda c: all_of_it(s, pressure, V, c))(of)  # noqa: B023
        assert all(np.all(np.isfinite(x)) for x in jax.tree.leaves(by_numbers))


@every
def test_numpy_and_jax_agree(of):
    state = of.state_at(PRESSURES, V)
    assert type(state) is np.ndarray
    for name, arguments in (
        ("state_residual", (state, PRESSURES, V)), ("static_pressure", (state, V)),
        ("stored_energy", (state, PRESSURES)), ("temperature", (state, PRESSURES)),
        ("rates", (state, PRESSURES, 1e-4, 30.0, 1e-5)),
    ):  # fmt: skip
        plain = getattr(of, name)(*arguments)
        compiled = jax.jit(getattr(of, name))(*arguments)
        for one, other in zip(jax.tree.leaves(plain), jax.tree.leaves(compiled), strict=True):
            # pressures of oil have the rounding of its bulk modulus, 1.4e9 Pa
            assert_allclose(
                one, other, rtol=1e-12, atol=1e-6 if name == "static_pressure" else 1e-12
            )

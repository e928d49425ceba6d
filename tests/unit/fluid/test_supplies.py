import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid


WARM = 293.15
SUPPLIES = [
    fluid.ConstantSupply(6e5), fluid.Tank(fluid.Isothermal(), 1e-2, 6e5),
    fluid.Tank(fluid.AdiabaticWall(1.0), 1e-2, 6e5), fluid.Accumulator(1e-3, 2e5, 6e5),
    fluid.Accumulator(1e-3, 2e5, 6e5, 1.0),
]  # fmt: skip
every = pytest.mark.parametrize("of", SUPPLIES, ids=lambda of: type(of).__name__)


@every
def test_starts_at_its_pressure(of):
    state = of.initial_state()
    assert state.shape == (of.count,) and len(of.names) == len(of.units) == of.count
    assert_allclose(of.pressure_at(state), 6e5, rtol=1e-12)
    assert_allclose(of.temperature_at(state), WARM, rtol=1e-14)
    assert not of.empty(state)


@every
def test_what_is_drawn_is_missing(of):
    state = of.initial_state()
    rates = of.rates(state, -1e-3, -1e-3 * fluid.AIR.c_p * WARM)
    assert rates.shape == state.shape
    if of.count:
        assert rates[0] == -1e-3
        later = of.pressure_at(state + 0.1 * rates)
        assert later < 6e5
        assert of.stored_energy(state) > of.stored_energy(state + 0.1 * rates)


def test_a_tank_empties_to_the_room():
    of = fluid.Tank(fluid.Isothermal(), 1e-2, 6e5)
    left = of.chamber.state_at(0.0, 1e-2)
    assert of.empty(left) and not of.empty(1.001 * left)


@pytest.mark.parametrize("share", [-0.5, 0.0, 0.5, 0.98, 2.0])
@pytest.mark.parametrize("n", [1.0, 2.0])
def test_an_accumulator_over_its_ends_is_finite(n, share):
    of = fluid.Accumulator(1e-3, 2e5, 6e5, n)
    mass = jnp.array([share * 1e-3 * 850.0])

    def all_of_it(of, mass):
        return of.pressure_at(mass) + of.stored_energy(mass)

    slopes = jax.grad(all_of_it, (0, 1))(of, mass)
    assert all(np.all(np.isfinite(x)) for x in jax.tree.leaves(slopes))

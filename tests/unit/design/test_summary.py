"""A design as whoever buys it looks at it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.design import Catalog, Designs, Product, Task, evaluate
from fascicle.design.summary import ATMOSPHERE, summarize


@pytest.fixture(scope="module")
def designs(muscle):
    return Designs.of(muscle, [(1, 2)])


@pytest.fixture(scope="module")
def task():
    return Task.of([40.0, 150.0, 0.0], [0.2, 0.1, 0.05], 413.7e3)


def test_size_mass_and_margin(muscle, designs, task):
    summary = summarize(designs, 0, task, Catalog(density=1100.0))
    r, t, length = 6.35e-3, 1.6e-3, 0.127
    assert_allclose(summary.mass, 1100 * 3 * np.pi * (r**2 - (r - t) ** 2) * length, rtol=1e-12)
    assert (summary.muscles, summary.valves, summary.label) == (3, 2, "1+2")
    assert_allclose(summary.diameter_at_rest, 2 * r * (1 + 2 / np.sqrt(3)), rtol=1e-12)
    names = ["envelope", "margin"]
    judged = evaluate(designs, task, names)
    assert_allclose(
        [summary.diameter, summary.cases.spare.min()], [judged[n][0] for n in names], rtol=1e-9
    )
    assert (summary.price, summary.cost_of_a_cycle, summary.product) == (None, None, None)
    assert summarize(designs, 0, task, Catalog(valve=10.0)).price is None


def test_prices_and_a_products_mass(designs, task):
    catalog = Catalog({"muscle": Product("p", price=20.0, mass=0.05)}, "EUR", 90.0, density=1100.0)
    summary = summarize(designs, 0, task, catalog)
    assert summary.price == 3 * 20.0 + 2 * 90.0
    # the maker's is that of whole muscles
    assert_allclose(summary.mass, 0.15)
    assert summary.product.name == "p"


def test_cost_of_a_cycle(designs, task):
    air = summarize(designs, 0, task, Catalog(currency="EUR", air=0.02, energy=1e-7))
    volume = air.cases.fluid_of_a_cycle
    assert_allclose(air.cost_of_a_cycle, 0.02 * volume, rtol=1e-12)
    energy = summarize(designs, 0, task, Catalog(currency="EUR", energy=1e-7)).cost_of_a_cycle
    ratio = (413.7e3 + ATMOSPHERE) / ATMOSPHERE
    assert_allclose(energy, 1e-7 * ATMOSPHERE * volume * np.log(ratio), rtol=1e-12)
    wet = Task.of(task.force, task.strain, task.supply_pressure, fluid="liquid")
    liquid = summarize(designs, 0, wet, Catalog(currency="EUR", air=0.02, energy=1e-7))
    assert_allclose(liquid.cost_of_a_cycle, 1e-7 * 413.7e3 * liquid.cases.fluid_of_a_cycle)
    assert summarize(designs, 0, wet, Catalog(currency="EUR", air=0.02)).cost_of_a_cycle is None

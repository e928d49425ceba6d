"""Which design is the cheapest, and which products may be used."""

from dataclasses import replace

import numpy as np
import pytest

from fascicle.design import Catalog, Product, Space, Task, search
from fascicle.design.catalog import cheapest, describe_cheapest


TASK = Task.of([40.0, 150.0], [0.2, 0.1], 413.7e3)
ONE_VALVE = {"valves": "min"}


@pytest.fixture(scope="module")
def space(muscle):
    return Space({"small": muscle, "large": muscle}, (2, 3))


@pytest.fixture(scope="module")
def found(space):
    return search(space, TASK, ONE_VALVE)


def chosen(found, catalog):
    return cheapest(
        np.flatnonzero(found.allowed), found.values, found.all_designs, catalog,
        found.space.drawings,
    )  # fmt: skip


def told(found, catalog):
    one = found.all_designs(np.array([chosen(found, catalog)]))
    return list(one.drawings)[one.kind[0]], one.labels[0]


def test_without_prices_valves_count_first_then_muscles(found):
    assert told(found, Catalog()) == ("small", "2")
    assert describe_cheapest(Catalog(), found.space.drawings).startswith(
        "fewest valves, then fewest muscles"
    )


def test_the_price_decides_where_all_of_it_is_known(found):
    dear = Catalog(
        {"small": Product("s", price=50.0), "large": Product("l", price=9.0)}, "EUR", 5.0
    )
    assert told(found, dear) == ("large", "2")
    assert describe_cheapest(dear, found.space.drawings).startswith(
        "lowest price of muscles and valves"
    )
    prices = dear.price(found.all_designs(np.arange(12)))
    assert prices.min() == 2 * 9.0 + 5.0 and prices.max() == 3 * 50.0 + 3 * 5.0


def test_a_price_that_is_missing_is_not_guessed(found):
    """Of one product alone, or of muscles without a valve's: valves count first again."""
    half = Catalog({"large": Product("l", price=0.01)}, "EUR", 5.0)
    assert half.known_prices(found.space.drawings) == (False, False)
    assert told(found, half) == ("small", "2")
    assert np.all(np.isnan(half.price(found.all_designs(np.arange(6)))))
    muscles = Catalog({"small": Product("s", price=50.0), "large": Product("l", price=9.0)}, "EUR")
    assert muscles.known_prices(found.space.drawings) == (True, False)
    assert told(found, muscles) == ("large", "2")
    assert "no price of a valve" in describe_cheapest(muscles, found.space.drawings)


def test_cheap_valves_do_not_make_muscles_free(muscle):
    """With its own price a third muscle is worth a valve less."""
    space = Space({"m": muscle}, (2, 3))
    found = search(space, TASK, ONE_VALVE)
    catalog = Catalog({}, "EUR", valve=0.0, muscle=1.0)
    label = found.all_designs(np.array([chosen(found, catalog)])).labels[0]
    assert label == "2"


def test_of_equal_price_the_one_with_the_largest_margin(muscle):
    """The share of what is demanded counts, whatever is known of prices."""
    space = Space({"m": muscle}, splits=((2,),), radius=(7e-3, 9e-3, 8e-3))
    found = search(space, TASK, ONE_VALVE)
    margin, energy = found.values["relative_margin"], found.values["mean_energy"]
    assert np.argmax(margin) == 1 != np.argmin(energy)
    alike = Catalog({"m": Product("m", price=9.0)}, "EUR", 5.0)
    for catalog in (Catalog(), replace(alike, valve=None), alike):
        assert chosen(found, catalog) == 1
        assert "then largest margin" in describe_cheapest(catalog, space.drawings)


def test_of_equals_the_one_that_takes_least_fluid(muscle):
    # the length moves no force at a strain, where the muscle pulls
    space = Space({"m": muscle}, splits=((3,),), length=(0.15, 0.1, 0.12))
    found = search(space, TASK, ONE_VALVE)
    energy = found.values["mean_energy"]
    assert chosen(found, Catalog()) == np.argmin(energy) == 1


def test_none_to_take(found):
    nothing = replace(found, allowed=np.zeros(len(found.index), bool))
    assert chosen(nothing, Catalog()) is None


def test_products_that_must_not_be_used(space):
    task = Task.of([40.0], None, 413.7e3, stroke=[0.02])
    catalog = Catalog({"small": Product("s", largest_pressure=400e3),
                       "large": Product("l", largest_strain=0.02 / 0.127)})  # fmt: skip
    assert list(catalog.excluded(space.drawings, task)) == ["small"]
    assert "413.7 kPa, it is made for 400 kPa" in catalog.excluded(space.drawings, task)["small"]
    found = search(space, task, ONE_VALVE, catalog=catalog)
    assert set(found.designs.kind[: len(found.front)]) == {1}
    # none is left, though all reach it
    catalog = Catalog({name: Product(name, largest_strain=0.1) for name in space.drawings})
    found = search(space, task, ONE_VALVE, catalog=catalog)
    assert found.recommended is None and np.all(found.reaches_task)
    assert "contracts by up to 10 %, the task asks for 15.7 %" in found.excluded_products["large"]

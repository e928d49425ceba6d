"""Which design is the cheapest, and which products may be used."""

import re
from dataclasses import replace

import numpy as np
import pytest

from fascicle.design import Catalog, Product, Space, Task, search
from fascicle.design.catalog import cheapest


TASK = Task.of([40.0, 150.0], [0.2, 0.1], 413.7e3)
ONE_VALVE = {"valves": "min"}


@pytest.fixture(scope="module")
def space(muscle):
    return Space({"small": muscle, "large": muscle}, (2, 3))


@pytest.fixture(scope="module")
def result(space):
    return search(space, TASK, ONE_VALVE)


def cheapest_index(result, catalog):
    return cheapest(np.flatnonzero(result.allowed), result.values, result.all_designs, catalog)


def cheapest_label(result, catalog):
    design = result.all_designs(np.array([cheapest_index(result, catalog)]))
    return list(design.drawings)[design.kind[0]], design.labels[0]


def test_without_prices_valves_count_first_then_muscles(result):
    assert cheapest_label(result, Catalog()) == ("small", "2")


def test_known_prices_decide(result):
    dear = Catalog(
        {"small": Product("s", price=50.0), "large": Product("l", price=9.0)}, "EUR", 5.0
    )
    assert cheapest_label(result, dear) == ("large", "2")
    prices = dear.price(result.all_designs(np.arange(12)))
    assert prices.min() == 2 * 9.0 + 5.0 and prices.max() == 3 * 50.0 + 3 * 5.0


def test_missing_price_is_nan(result):
    """Of one product alone, or of muscles without a valve's: valves count first again."""
    half = Catalog({"large": Product("l", price=0.01)}, "EUR", 5.0)
    assert half.known_prices(result.space.drawings) == (False, False)
    assert cheapest_label(result, half) == ("small", "2")
    assert np.all(np.isnan(half.price(result.all_designs(np.arange(6)))))
    muscles = Catalog({"small": Product("s", price=50.0), "large": Product("l", price=9.0)}, "EUR")
    assert muscles.known_prices(result.space.drawings) == (True, False)
    assert cheapest_label(result, muscles) == ("large", "2")


def test_cheap_valves_do_not_make_muscles_free(muscle):
    """With its own price a third muscle is worth a valve less."""
    space = Space({"m": muscle}, (2, 3))
    result = search(space, TASK, ONE_VALVE)
    catalog = Catalog({}, "EUR", valve=0.0, muscle=1.0)
    label = result.all_designs(np.array([cheapest_index(result, catalog)])).labels[0]
    assert label == "2"


def test_equal_price_is_decided_by_size(muscle):
    """The smaller one, whatever is known of prices."""
    space = Space({"m": muscle}, splits=((2,),), radius=(7e-3, 9e-3, 8e-3))
    result = search(space, TASK, ONE_VALVE)
    assert np.argmax(result.values["relative_margin"]) == 1
    alike = Catalog({"m": Product("m", price=9.0)}, "EUR", 5.0)
    for catalog in (Catalog(), replace(alike, valve=None), alike):
        assert cheapest_index(result, catalog) == 0


def test_equal_size_is_decided_by_fluid(muscle):
    space = Space({"m": muscle}, splits=((3,),), braid_angle=(0.5, 0.6, 0.55))
    result = search(space, TASK, ONE_VALVE)
    energy = result.values["mean_energy"]
    assert result.allowed.all() and cheapest_index(result, Catalog()) == np.argmin(energy)


def test_no_candidates_give_none(result):
    nothing = replace(result, allowed=np.zeros(len(result.index), bool))
    assert cheapest_index(nothing, Catalog()) is None


def test_excluded_products(space):
    task = Task.of([40.0], None, 413.7e3, stroke=[0.02])
    catalog = Catalog({"small": Product("s", largest_pressure=400e3),
                       "large": Product("l", largest_strain=0.02 / 0.127)})  # fmt: skip
    assert list(catalog.excluded(space.drawings, task)) == ["small"]
    result = search(space, task, ONE_VALVE, catalog=catalog)
    assert set(result.designs.kind[: len(result.front)]) == {1}
    # none is left, though all reach it
    catalog = Catalog({name: Product(name, largest_strain=0.1) for name in space.drawings})
    result = search(space, task, ONE_VALVE, catalog=catalog)
    assert result.recommended is None and np.all(result.reaches_task)
    assert set(result.excluded_products) == {"small", "large"}


def test_a_limit_is_not_rounded_to_what_exceeds_it():
    reason = Product("s", largest_pressure=600e3).exclusion_reason(
        Task.of([40.0], [0.1], 600_000.01), 0.1
    )
    given, allowed = re.findall(r"([\d.]+) kPa", reason)
    assert float(given) > float(allowed) == 600

"""Which design is the cheapest, and which products may be used."""

import re
from dataclasses import replace

import numpy as np
import pytest

from fascicle.design import Catalog, Product, Space, Task, search
from fascicle.report.words import words


TASK = Task.of([40.0, 150.0], [0.2, 0.1], 413.7e3)
ONE_VALVE = {"valves": "min"}


@pytest.fixture(scope="module")
def space(muscle):
    return Space({"small": muscle, "large": muscle}, (2, 3))


def recommended(result):
    design = result.all_designs(np.array([result.best]))
    return list(design.drawings)[design.kind[0]], design.labels[0]


def test_known_prices_decide(space):
    dear = Catalog(
        {"small": Product("s", price=50.0), "large": Product("l", price=9.0)}, "EUR", 5.0
    )
    result = search(space, TASK, ONE_VALVE, catalog=dear)
    assert next(iter(result.offers)) == "cheapest" and recommended(result) == ("large", "2")
    prices = dear.price(result.all_designs(np.arange(12)))
    assert prices.min() == 2 * 9.0 + 5.0 and prices.max() == 3 * 50.0 + 3 * 5.0
    assert prices[result.allowed].min() == prices[result.best]


def test_a_missing_price_is_not_guessed(space):
    """Of one product alone, or of muscles without a valve's."""
    half = Catalog({"large": Product("l", price=0.01)}, "EUR", 5.0)
    muscles = Catalog({"small": Product("s", price=50.0), "large": Product("l", price=9.0)}, "EUR")
    for catalog in (half, muscles):
        assert not catalog.is_priced(space.drawings)
        result = search(space, TASK, ONE_VALVE, catalog=catalog)
        assert "cheapest" not in result.offers and recommended(result)[1] == "2"
    assert np.all(np.isnan(half.price(result.all_designs(np.arange(6)))))


def test_cheap_valves_do_not_make_muscles_free(muscle):
    """With its own price a third muscle is worth a valve less."""
    catalog = Catalog({}, "EUR", valve=0.0, muscle=1.0)
    result = search(Space({"m": muscle}, (2, 3)), TASK, ONE_VALVE, catalog=catalog)
    assert recommended(result)[1] == "2"


def test_equal_designs_are_decided_by_size(muscle):
    """The smaller one, whatever is known of prices; it alone is listed."""
    space = Space({"m": muscle}, splits=((2,),), radius=(7e-3, 9e-3, 8e-3), wall_ratio=(0.2, 0.25))
    alike = Catalog({"m": Product("m", price=9.0)}, "EUR", 5.0)
    for catalog in (Catalog(), replace(alike, valve=None), alike):
        result = search(space, TASK, ONE_VALVE, catalog=catalog)
        assert result.all_designs(np.array([result.best])).radius[0, 0] == 7e-3
        assert len(result.front) == 1 and set(result.offers.values()) == {0}


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
    assert set(result.catalog.excluded(result.space.drawings, result.task)) == {"small", "large"}


def test_a_limit_is_not_rounded_to_what_exceeds_it():
    task = Task.of([40.0], [0.1], 600_000.01)
    finding = Product("s", largest_pressure=600e3).exclusion("s", task, 0.1)
    given, allowed = re.findall(r"([\d.]+) kPa", words(finding))
    assert float(given) > float(allowed) == 600

"""What is told of a design, and of a task that none does."""

import re

import numpy as np
import pytest

from fascicle.design import Catalog, Limit, Product, Space, Task, search
from fascicle.reports.design import report
from fascicle.reports.design_summary import (
    MISSED,
    REACHED,
    InfeasibleResult,
    case_rows,
    design_facts,
    headline,
    margin_warning,
    summarize_search,
)


SENSES = {"valves": "min"}


@pytest.fixture(scope="module")
def muscle():
    import fascicle as fs

    return fs.example("kim2021_figure_6")


@pytest.fixture(scope="module")
def space(muscle):
    return Space({"m": muscle}, splits=((1, 2), (3,)))


def found_of(space, force, strain, catalog=None, limits=None, **more):
    task = Task.of(force, strain, 400e3, **more)
    return search(space, task, SENSES, limits, catalog=catalog)


def test_of_many_load_cases_those_with_least_to_spare_are_shown(space):
    found = found_of(space, np.linspace(10, 200, 50), 0.08)
    rows, caption = case_rows(summarize_search(found), 5)
    assert [row[0] for row in rows] == ["46", "47", "48", "49", "50"]
    assert caption == "the 5 of 50 with least to spare; 50 of 50 reached"
    assert {row[-1] for row in rows} == {REACHED}


def test_the_margin_names_the_case_and_what_it_could_lift(space):
    found = found_of(space, [50.0, 200.0], [0.15, 0.08])
    summary = summarize_search(found)
    told = headline(found, summary)[1]
    share, spare, case, lift, more = re.match(
        r"margin: ([\d.]+) %, ([\d.]+) N to spare at case (\d), which could lift ([\d.]+) N,"
        r" ([\d.]+) kg more",
        told,
    ).groups()
    assert float(spare) == pytest.approx(summary.margin, rel=1e-3)
    i = int(case) - 1
    asked = summary.cases.task.force[i]
    assert float(share) == pytest.approx(100 * float(spare) / asked, rel=1e-2)
    assert float(share) == pytest.approx(100 * summary.relative_margin, rel=1e-2)
    assert float(lift) == pytest.approx(summary.cases.largest[i], rel=1e-3)
    assert float(more) == pytest.approx(float(spare) / 9.80665, rel=1e-2)


def test_the_only_design_is_called_so(muscle):
    found = found_of(Space({"m": muscle}, splits=((3,),)), 100.0, 0.08)
    assert "the only one of 1 designs" in headline(found, summarize_search(found))[2]


def test_prices_and_products_are_told_as_far_as_they_are_known(space):
    product = Product("P", price=20.0, mass=0.05, source="made up")
    catalog = Catalog({"m": product}, "EUR", air=0.02)
    found = found_of(space, 100.0, 0.08, catalog)
    told = design_facts(found, summarize_search(found))
    assert told["price"] == "muscles 60 EUR; no price of a valve given"
    assert told["mass"] == "0.15 kg of muscles, by the catalog"
    assert told["product"] == "3 × P, 127 mm; figures: made up"
    assert told["cost of air"].endswith(" EUR for 1000 cycles")
    losses = found_of(space, 100.0, 0.08, Catalog({}, "EUR", 90.0, 20.0, energy=1e-7))
    told = design_facts(losses, summarize_search(losses))
    assert told["price"] == "150 EUR, of muscles and valves"
    assert "a compressor takes more" in told["cost of air"]


def test_what_would_reach_is_rounded_up(space):
    """A reader who types it in must not be a hair short."""
    found = found_of(space, 600.0, 0.04)
    none = summarize_search(found)
    assert isinstance(none, InfeasibleResult)
    lines = dict(line.split(": ", 1) for line in none.remedies())
    pressure = float(re.match(r"([\d.]+) kPa", lines["supply pressure"])[1])
    (exact,) = (one.value for one in none.changes if one.what == "supply_pressure")
    assert exact <= 1e3 * pressure < exact * 1.001
    assert found_of(space, 600.0, 0.04).recommended is None
    task = Task.of(600.0, 0.04, 1e3 * pressure)
    assert search(space, task, SENSES).recommended is not None


def test_a_broken_limit_is_told_with_the_change(space):
    found = found_of(space, 600.0, 0.04, limits={"envelope": Limit(most=0.03)})
    radius = next(line for line in summarize_search(found).remedies() if line.startswith("radius"))
    assert "it breaks a limit then: envelope " in radius and "limited to 30 mm" in radius


def test_a_load_of_nothing_has_no_percentage(space):
    found = found_of(space, [100.0, 0.0], [0.08, 0.4])
    none = summarize_search(found)
    rows, caption = case_rows(none.summary, 10)
    assert [row[-1] for row in rows] == [REACHED, MISSED] and caption == "1 of 2 reached"
    assert "worst case 2 by" in none.nearest() and "only pushes" in none.nearest()
    assert "%)" not in none.nearest()


def test_a_small_margin_is_warned_of_with_the_cheapest_that_has_more(muscle):
    space = Space({"m": muscle}, splits=((2,), (1, 2), (3,)))
    found = found_of(space, 190.0, 0.08)
    summary = summarize_search(found)
    assert 0 < summary.relative_margin < 0.3
    for least, warned in ((0.0, False), (summary.relative_margin, False), (0.3, True)):
        found = search(space, found.task, SENSES, least_margin=least)
        assert bool(margin_warning(found, summary)) is warned
    # of those with enough the cheapest has one valve, too
    assert found.all_designs(np.array([found.cheapest_with_margin])).labels == ["3"]
    assert "is 3, " in margin_warning(found, summary)
    page = report(found, "2026-05-04", [])
    assert margin_warning(found, summary).split(":")[0] in page
    # where none has it
    found = search(space, found.task, SENSES, least_margin=9.0)
    assert found.cheapest_with_margin is None and "No design" in margin_warning(found, summary)

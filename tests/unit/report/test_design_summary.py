"""Summaries of a design, and of a task without one."""

import re
import sys
from dataclasses import replace

import numpy as np

import fascicle as fs
from fascicle.design import Catalog, Product, Space, Task, search
from fascicle.design.cycle import Cycle, run_cycle
from fascicle.report.design_summary import (
    InfeasibleResult,
    design_facts,
    margin_warning,
    run_cycle_of,
    summarize_search,
)


SENSES = {"valves": "min"}
MUSCLE = fs.example("kim2021_figure_6")
SPACE = Space({"m": MUSCLE}, splits=((1, 2), (3,)))


def summarize(force, strain, catalog=None, space=SPACE):
    result = search(space, Task.of(force, strain, 400e3), SENSES, catalog=catalog)
    return result, summarize_search(result)


def test_valves_are_enlarged_until_the_run_is_in_time_and_its_overshoot_fails_it():
    result = search(SPACE, Task.of([200.0, 60.0], [0.08, 0.12], 400e3), SENSES)
    result = replace(result, cycle=Cycle(0.25, 30.0))
    summary = summarize_search(result)
    ran = run_cycle_of(result, summary)
    assert np.all(ran.sizing.conductance > summary.sizing.conductance)
    bundle = result.designs.bundle(result.recommended, result.task)
    stroke = float(result.task.stroke_of(ran.cases.length)[1])
    first, last = (run_cycle(bundle, 60.0, stroke, s.sizing) for s in (summary, ran))
    assert last.released <= 0.25 < first.released
    # the load flies on by half of the stroke: it isn't where it was to go
    assert last.overshoot > 0.5 and not last.passes(0.25) and ran.run_failure


def test_a_case_that_does_work_is_run():
    """The second one needs the largest valve, but has no load."""
    result = search(SPACE, Task.of([200.0, 0.0], [0.08, 0.12], 400e3), SENSES)
    result = replace(result, cycle=Cycle(0.4, 30.0))
    ran = run_cycle_of(result, summarize_search(result))
    assert (ran.sizing.case, ran.sizing.run_case) == (1, 0)
    assert ran.sizing.time == 0.4


def test_run_is_left_out_without_jax(monkeypatch):
    class NoJax:
        def find_spec(self, name, *_):
            if name == "fascicle.dynamics":
                raise ModuleNotFoundError("No module named 'jax'", name="jax")

    result, _ = summarize(100.0, 0.08)
    result = replace(result, cycle=Cycle(1.0, 30.0))
    monkeypatch.delitem(sys.modules, "fascicle.dynamics", raising=False)
    monkeypatch.setattr(sys, "meta_path", [NoJax(), *sys.meta_path])
    assert "left out" in run_cycle_of(result, summarize_search(result)).run
    assert "fascicle[jax]" in run_cycle_of(result, summarize_search(result)).run


def test_facts_list_known_prices_and_products():
    product = Product("P", price=20.0, mass=0.05, source="made up")
    facts = design_facts(*summarize(100.0, 0.08, Catalog({"m": product}, "EUR", air=0.02)))
    assert facts["price"].startswith("60 EUR, of muscles;")
    assert facts["mass"] == "0.15 kg of muscles, by the catalog"
    assert facts["product"] == "3 × P, 127 mm; figures: made up"
    assert facts["cost of air"].endswith(" EUR for 1000 cycles")
    facts = design_facts(*summarize(100.0, 0.08, Catalog({}, "EUR", 90.0, 20.0, energy=1e-7)))
    assert facts["price"] == "150 EUR, of muscles and valves"


def test_a_remedy_is_rounded_up():
    """A reader who types it in must not be a hair short."""
    result, summary = summarize(600.0, 0.04)
    assert isinstance(summary, InfeasibleResult) and result.recommended is None
    lines = dict(line.split(": ", 1) for line in summary.remedies())
    pressure = 1e3 * float(re.match(r"([\d.]+) kPa", lines["supply pressure"])[1])
    (exact,) = (remedy.value for remedy in summary.changes if remedy.what == "supply_pressure")
    assert exact <= pressure < exact * 1.001
    assert search(SPACE, Task.of(600.0, 0.04, pressure), SENSES).recommended is not None


def test_small_margin_warning_names_the_cheapest_larger_one():
    space = Space({"m": MUSCLE}, splits=((2,), (1, 2), (3,)))
    result, summary = summarize(190.0, 0.08, space=space)
    assert 0 < summary.relative_margin < 0.3
    for least, warns in ((0.0, False), (summary.relative_margin, False), (0.3, True)):
        result = search(space, result.task, SENSES, least_margin=least)
        assert bool(margin_warning(result, summary)) is warns
    # of those with enough the cheapest has one valve, too
    assert result.all_designs(np.array([result.cheapest_with_margin])).labels == ["3"]
    # no design has such a margin
    result = search(space, result.task, SENSES, least_margin=9.0)
    assert result.cheapest_with_margin is None

"""Summaries of a design, and of a task without one."""

import re
import sys
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

import fascicle as fs
from fascicle.design import Catalog, Limit, Product, Space, Task, search
from fascicle.design.cycle import Cycle, run_cycle
from fascicle.reports.design import report
from fascicle.reports.design_summary import (
    MISSED,
    REACHED,
    InfeasibleResult,
    case_rows,
    design_facts,
    headline,
    margin_warning,
    run_cycle_of,
    summarize_search,
    summary_lines,
)


SENSES = {"valves": "min"}
MUSCLE = fs.example("kim2021_figure_6")
SPACE = Space({"m": MUSCLE}, splits=((1, 2), (3,)))


def summarize(force, strain, catalog=None, limits=None, space=SPACE):
    result = search(space, Task.of(force, strain, 400e3), SENSES, limits, catalog=catalog)
    return result, summarize_search(result)


def test_case_rows_show_the_tightest_cases():
    rows, caption = case_rows(summarize(np.linspace(10, 200, 50), 0.08)[1], 5)
    assert [row[0] for row in rows] == ["46", "47", "48", "49", "50"]
    assert caption == "the 5 of 50 with the least force to spare; 50 of 50 reached"
    assert {row[-1] for row in rows} == {REACHED}


def test_the_margin_names_the_case_and_its_largest_force():
    result, summary = summarize([50.0, 200.0], [0.15, 0.08])
    percent, case, available, spare, mass = map(float, re.match(
        r"margin: ([\d.]+) % at case (\d): [\d.]+ N demanded, ([\d.]+) N available,"
        r" ([\d.]+) N to spare \(weight of ([\d.]+) kg\)",
        headline(result, summary)[1],
    ).groups())  # fmt: skip
    assert spare == pytest.approx(summary.margin, rel=1e-3)
    i = int(case) - 1
    assert percent == pytest.approx(100 * spare / summary.cases.task.force[i], rel=1e-2)
    assert percent == pytest.approx(100 * summary.relative_margin, rel=1e-2)
    assert available == pytest.approx(summary.cases.largest[i], rel=1e-3)
    assert mass == pytest.approx(spare / 9.80665, rel=1e-2)


def test_single_design_has_its_reason():
    result, summary = summarize(100.0, 0.08, space=Space({"m": MUSCLE}, splits=((3,),)))
    assert "the only one of 1 designs" in headline(result, summary)[2]


def test_valves_and_the_run_are_a_line():
    result, _ = summarize([50.0, 200.0], [0.15, 0.08])
    result = replace(result, cycle=Cycle(1.0, 30.0, 1.0))
    summary = summarize_search(result)
    ran = run_cycle_of(result, summary)
    lines = summary_lines(result, ran)
    (line,) = (line for line in lines if line.startswith("valves: "))
    assert len(lines) <= 12 and "; run over time: passes" in line
    pattern = r"C of ([\d.]+) L.* at least ([\d.]+) mm wide; .*; ([\d.]+) normal liters"
    C, bore, rate = map(float, re.search(pattern, line).groups())
    assert pytest.approx(1e8 * summary.sizing.conductance.max(), rel=5e-3) == C
    assert bore == pytest.approx(1e3 * summary.sizing.bore)
    assert rate == pytest.approx(6e4 * summary.flow, rel=5e-3)
    assert "valves: each needs" in unescape(report(result, "2026-05-04", [], answer=ran))


def test_valves_are_enlarged_until_the_run_is_in_time_and_its_overshoot_fails_it():
    result = search(SPACE, Task.of([200.0, 60.0], [0.08, 0.12], 400e3), SENSES)
    result = replace(result, cycle=Cycle(0.25, 30.0))
    summary = summarize_search(result)
    ran = run_cycle_of(result, summary)
    assert "without inertia, as the load swings" in design_facts(result, ran)["valves"]
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
    assert "at case 1, " in ran.run
    assert ran.sizing.time == 0.4 and "inertia" not in design_facts(result, ran)["valves"]


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
    assert "a compressor takes more" in facts["cost of air"]


def test_a_remedy_is_rounded_up():
    """A reader who types it in must not be a hair short."""
    result, summary = summarize(600.0, 0.04)
    assert isinstance(summary, InfeasibleResult) and result.recommended is None
    lines = dict(line.split(": ", 1) for line in summary.remedies())
    pressure = 1e3 * float(re.match(r"([\d.]+) kPa", lines["supply pressure"])[1])
    (exact,) = (remedy.value for remedy in summary.changes if remedy.what == "supply_pressure")
    assert exact <= pressure < exact * 1.001
    assert search(SPACE, Task.of(600.0, 0.04, pressure), SENSES).recommended is not None
    assert "Changes that would reach the task" in report(result, "2026-05-04", [])


def test_a_remedy_names_the_limit_that_it_breaks():
    _, summary = summarize(600.0, 0.04, limits={"envelope": Limit(most=0.03)})
    radius = next(line for line in summary.remedies() if line.startswith("radius"))
    assert "breaks a limit: envelope " in radius and "limited to 30 mm" in radius


def test_zero_load_has_no_percentage():
    _, summary = summarize([100.0, 0.0], [0.08, 0.4])
    rows, caption = case_rows(summary.summary, 10)
    assert [row[-1] for row in rows] == [REACHED, MISSED] and caption == "1 of 2 reached"
    assert "worst case 2 by" in summary.nearest() and "only pushes" in summary.nearest()
    assert "%)" not in summary.nearest()


def test_a_failed_cycle_is_a_warning_before_the_reasons():
    result, summary = summarize([50.0, 200.0], [0.15, 0.08])
    passed = replace(summary, run="run over time: passes, released after 0.7 s")
    text = "not released within 2 s"
    failed = replace(summary, run=f"run over time: FAILS, {text}", run_failure=text)
    lines = summary_lines(result, failed)
    assert "not released within 2 s" in lines[2] and lines[2].startswith("warning: it fails")
    assert not any("fails" in line for line in summary_lines(result, passed))


def test_small_margin_warning_names_the_cheapest_larger_one():
    space = Space({"m": MUSCLE}, splits=((2,), (1, 2), (3,)))
    result, summary = summarize(190.0, 0.08, space=space)
    assert 0 < summary.relative_margin < 0.3
    for least, warns in ((0.0, False), (summary.relative_margin, False), (0.3, True)):
        result = search(space, result.task, SENSES, least_margin=least)
        assert bool(margin_warning(result, summary)) is warns
    # of those with enough the cheapest has one valve, too
    assert result.all_designs(np.array([result.cheapest_with_margin])).labels == ["3"]
    assert "is 3, " in margin_warning(result, summary)
    assert margin_warning(result, summary).split(":")[0] in report(result, "2026-05-04", [])
    # no design has such a margin
    result = search(space, result.task, SENSES, least_margin=9.0)
    assert result.cheapest_with_margin is None and "No design" in margin_warning(result, summary)

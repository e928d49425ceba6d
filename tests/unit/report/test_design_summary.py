"""Words and tables of a search: what is recommended, and what is missing."""

import builtins
import re
from dataclasses import replace

import numpy as np

import fascicle as fs
from fascicle.design import Catalog, Limit, Product, Space, Task, answer_search, search
from fascicle.design.cycle import Cycle
from fascicle.report import design_summary as summary


SENSES = {"valves": "min"}
MUSCLE = fs.example("kim2021_figure_6")
SPACE = Space({"m": MUSCLE}, splits=((1, 2), (3,)))


def answer(force, strain, catalog=None, cycle=None, pressure=400e3):
    result = search(SPACE, Task.of(force, strain, pressure), SENSES, catalog=catalog)
    return answer_search(replace(result, cycle=cycle))


def codes(answered):
    return [finding.code for finding in answered.findings]


def test_a_swinging_load_fails_its_cycle():
    ran = answer([200.0, 60.0], [0.08, 0.12], cycle=Cycle(0.03, 0.05, 30.0))
    assert ran.run.overshoot > 0.1 and codes(ran)[0] == "design.cycle_failed"
    assert not ran.is_recommended and not summary.parts(ran) and len(summary.headline(ran)) == 2
    slow = answer([200.0, 60.0], [0.08, 0.12], cycle=Cycle(3.0, 3.0, 5.0))
    assert slow.run.passes(slow.summary.sizing.cycle) and slow.is_recommended
    assert "design.cycle_failed" not in codes(slow)
    assert "passes" in summary.facts(slow)["run over time"]


def test_a_case_that_does_work_is_run():
    """The second one needs the largest valve, but has no load."""
    ran = answer([200.0, 0.0], [0.08, 0.12], cycle=Cycle(0.4, 0.4, 30.0))
    assert (ran.summary.sizing.case, ran.summary.sizing.run_case) == (1, 0)


def test_run_is_left_out_without_jax(monkeypatch):
    load = builtins.__import__

    def without_jax(name, *arguments, **more):
        if name == "dynamics":
            raise ModuleNotFoundError("No module named 'jax'", name="jax")
        return load(name, *arguments, **more)

    monkeypatch.setattr(builtins, "__import__", without_jax)
    ran = answer(100.0, 0.08, cycle=Cycle(1.0, 1.0, 20.0))
    assert ran.run is None and ran.summary.sizing.feasible


def test_a_design_without_a_valve_that_is_fast_enough_is_not_recommended():
    found = answer(100.0, 0.08, cycle=Cycle(0.01, 0.01, 20.0, hose_length=90.0))
    assert codes(found)[0] == "design.no_valve" and not found.is_recommended


def test_facts_list_known_prices_and_products():
    product = Product("P", price=20.0, mass=0.05, source="made up")
    found = answer(100.0, 0.08, Catalog({"m": product}, "EUR", 90.0, air=0.02))
    assert [line.split(" × ")[0] for line in summary.parts(found)] == ["3", "1"]
    assert "20 EUR" in summary.parts(found)[0] and "made up" in summary.parts(found)[0]
    known = summary.facts(answer(100.0, 0.08, Catalog({"m": product}, "EUR", air=0.02)))
    assert known["mass"].startswith("0.15 kg")
    assert "EUR for 1000 cycles" in known["air"] and "price" in known["unknown"]
    known = summary.facts(answer(100.0, 0.08, Catalog({}, "EUR", 90.0, 20.0, energy=1e-7)))
    assert known["price"].startswith("150 EUR")


def test_a_remedy_is_rounded_to_what_is_enough():
    """A reader who types it in must not be a hair short."""
    missing = answer(600.0, 0.04)
    assert codes(missing) == ["design.out_of_reach"] and not missing.is_recommended
    _, *lines = summary.remedy_lines(missing)
    pressure = 1e3 * float(re.match(r"- supply pressure: ([\d.]+) kPa", lines[0])[1])
    (exact,) = (x.value for x in missing.changes if x.what == "supply_pressure")
    assert exact <= pressure < exact * 1.001
    assert answer(600.0, 0.04, pressure=pressure).is_recommended


def test_a_limit_says_how_many_designs_it_costs():
    task = Task.of(100.0, 0.08, 400e3)
    found = answer_search(search(SPACE, task, SENSES, {"valves": Limit(most=1)}))
    (finding,) = (x for x in found.findings if x.code == "design.limit_costs")
    assert (finding.data["costs"], finding.data["reaching"]) == (1, 2)


def test_each_load_case_has_its_pressures_and_where_an_open_valve_leads():
    found = answer([60.0, 150.0], [0.1, 0.08])
    bundle = found.result.designs.bundle(found.result.recommended, found.result.task)
    open_pressures = np.where(found.summary.cases.pressures > 0, 400e3, 0.0)
    position = found.summary.held_open / 0.127
    force = [bundle.force(P, x) for P, x in zip(open_pressures, position, strict=True)]
    np.testing.assert_allclose(force, [60.0, 150.0], rtol=1e-6)
    table = summary.cases_table(found.summary, 10)
    assert [row[4] for row in table.rows] == [
        summary.pretty(P, "pressure") for P in found.summary.cases.pressures[:, 0]
    ]
    assert "design.held_open" in codes(found)


def test_more_units_are_compared_with_the_same_muscles():
    splits = answer([60.0, 150.0], [0.1, 0.08]).splits
    assert splits.designs.labels[0] == "3" and splits.designs.units.tolist() == [1, 2, 3]
    assert np.all(splits.designs.counts.sum(axis=1) == 3)
    assert np.all(np.diff(splits.values["mean_energy"]) <= 0)


def test_robustness_is_what_is_left():
    found = answer([60.0, 150.0], [0.1, 0.08])
    weaker = 0.9 * (1 + found.summary.relative_margin) - 1
    np.testing.assert_allclose(found.robustness["weaker"], weaker, rtol=1e-6)
    assert found.robustness["failure"] < found.robustness["weaker"]


def test_large_shares_are_factors():
    assert [summary.percent(x) for x in (0.12, 1.5, 14.5)] == ["12 %", "150 %", "14.5×"]

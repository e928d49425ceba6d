"""The tab of a simulation: its setup and link, its numbers, its drawing, and its jobs."""

import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle import control
from fascicle.core.errors import InvalidInputError
from fascicle.dynamics.audit import TABULATED
from fascicle.explorer import time_run
from fascicle.explorer.link import from_query, to_query
from fascicle.explorer.scenario_setup import Setup, open_setup
from fascicle.explorer.state import Session, view_of
from fascicle.explorer.tab import LatestResult, run_job, stop_jobs
from fascicle.explorer.time_run import sample_rows
from fascicle.explorer.time_tab import TimeView
from fascicle.files import dumps, example_text, loads_scenario
from fascicle.plot.theme import LIGHT
from fascicle.results.tables import simulated
from refusing import refuses, refuses_at


NAME = "raise_1_4"
START = replace(view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6"), tab="time")
CHANGED = Setup(NAME).with_value("load.mass", 5.5).with_value("valve.C.1", 5e-9)


@pytest.fixture(scope="module")
def result():
    text = CHANGED.text()
    return time_run.run_policies(text, NAME, ("threshold", "hand_over"))


@pytest.fixture
def tab(result):
    view = TimeView(Session(START), LIGHT)
    view.session.change(setup=Setup(NAME))
    view.refresh()
    view._show_result((CHANGED.text(), result))
    return view


def test_a_change_keeps_every_other_key_and_comment():
    setup = Setup("ramp_1_4").with_value("valve.C.1", 5e-9).with_value("supply.pressure", 4e5)
    before, after = example_text("ramp_1_4"), setup.text("threshold")
    lines = [pair for pair in zip(before.splitlines(), after.splitlines(), strict=True)
             if pair[0] != pair[1]]  # fmt: skip
    assert [new.partition("#")[0].strip() for _, new in lines] == [
        'pressure = "400 kPa"', 'C = ["0.1 L/(s*bar)", "0.5 L/(s*bar)"]', 'policy = "threshold"',
    ]  # fmt: skip
    assert all(old.partition("#")[2] == new.partition("#")[2] for old, new in lines)
    assert setup.with_value("valve.C.1", 4e-9).with_value("supply.pressure", 413.7e3) == Setup(
        "ramp_1_4"
    )


def test_a_link_holds_the_setup_and_a_visitors_file():
    own = open_setup("# mine\n" + example_text("lift_gas"), "mine.toml")
    for setup in (
        Setup(),
        Setup("ramp_1_4", policies=("threshold", "hand_over")).with_value("load.mean", 0.02),
        own.with_value("load.mass", 9.0).with_value("valve.C", 2e-9),
    ):
        view = replace(START, setup=setup)
        again, _, errors = from_query(to_query(view), START)
        assert again.setup.text() == setup.text() and not errors
        assert (again.setup.name, again.setup.policies) == (setup.name, setup.policies)


@pytest.mark.parametrize(
    "change",
    [
        ("kim2021_bundle_1_4", "../secret.toml"),
        ("[run]", '[hysteresis]\nkind = "measured"\nmuscle = "a.toml"\n\n[run]'),
        ('"kim2021_bundle_1_4"', '["kim2021_bundle_1_1", "kim2021_bundle_1_1"]'),
        ("format = 1", "format = 2"),
        ("[load]", "[load"),
    ],
)
def test_a_file_that_the_page_cant_run_is_refused(change):
    text = example_text("lift_gas")
    assert change[0] in text
    with refuses_at("mine.toml: "):
        open_setup(text.replace(*change), "mine.toml")


def test_the_pages_bundle_runs_in_place_of_a_scenarios():
    five = view_of(fs.example("kim2021_bundle_five"), "five").bundle
    (bundle,) = loads_scenario(Setup("lift_oil").text(bundle=five), "lift_oil").plant.bundles
    assert dumps(bundle) == dumps(five)
    assert Setup(NAME).text() == example_text(NAME)


@pytest.mark.parametrize(
    ("name", "path", "value"), [(NAME, "load.mass", 8.0), ("ramp_1_4", "load.mean", 0.015)]
)
def test_a_run_begins_in_equilibrium_with_the_load_that_is_set(name, path, value):
    scenario = loads_scenario(Setup(name).with_value(path, value).text(), name)
    plant, start, first = scenario.plant, scenario.start, scenario.control.reference[0]
    force = float(plant.bundles[0].force(start.pressures, float(plant.strains(start.position)[0])))
    if path == "load.mass":
        assert force == pytest.approx(value * 9.80665, rel=1e-4)  # the table's error
        assert float(start.position) == pytest.approx(first, abs=1e-6)
    else:
        assert force == pytest.approx(first, abs=1e-6)


def test_the_saved_scenario_gives_the_numbers_of_the_page(tab, result, tmp_path):
    tab.session.change(setup=replace(CHANGED, policies=("threshold", "hand_over")))
    tab.drawn.value = "threshold"
    name, raw = tab.inputs._scenario_file()
    path = tmp_path / name
    path.write_bytes(raw)
    scenario = fs.load(path)
    assert scenario.control.policy == "threshold"
    run = scenario.run()
    rows = sample_rows(len(run.time))
    pressures = np.array(tab.curves[2].data["ys"][:2])  # kPa
    demand, position, *_ = tab.curves[1].data["ys"]
    reference = scenario.control.reference[np.minimum(rows, len(run.time) - 2)]
    force = np.sum(run.outputs.forces, axis=1)[rows]
    for shown, expected in (
        (pressures.T, run.outputs.pressures[rows] / 1e3),
        (demand, 1e3 * reference),
        (position, 1e3 * run.outputs.position[rows]),
        (tab.curves[0].data["ys"][0], force),
    ):
        np.testing.assert_allclose(shown, expected, rtol=1e-12, atol=1e-12)  # rounding of units
    metrics = control.control_metrics(scenario.control.controller, run, scenario.control.reference)
    assert f"<td>{1e3 * metrics.drawdown:.4g}</td>" in tab._table.object
    table = simulated(scenario.plant, run, fs.dynamics.audit(scenario.plant, run),
                      scenario.control.controller, scenario.control.reference)  # fmt: skip
    assert tab.export().content("csv").decode() == table.to_csv()


def test_energies_of_the_chart_are_balanced(tab):
    supplied, lost, stored, work = map(np.array, tab.curves[4].data["ys"])
    assert supplied[-1] > 1.0
    left = np.abs(supplied - lost - stored - work)
    # two balances of tabulated muscles, each of which closes so far
    assert left.max() < 2 * TABULATED * np.abs(supplied).max()


def test_the_drawing_is_the_laws(result):
    run = result.runs[1]
    scenario = loads_scenario(CHANGED.text("hand_over"), NAME)
    muscle = scenario.plant.bundles[0].motor_units[1].muscle
    strain = run.table["strain"].values[run.rows, 1]
    pressure = np.maximum(run.table["pressure"].values[run.rows, 1], 0.0)
    regions = np.array([int(muscle.response(P, eps).region) for P, eps in
                        zip(pressure[::50], strain[::50], strict=True)])  # fmt: skip
    np.testing.assert_array_equal(run.drawing.states[::50, 1], regions)
    assert len(set(regions.tolist())) > 1  # it is collapsed, and pulls later
    ends = run.drawing.tubes[:, 1, [0, -1, 24, 25], 1].astype(float)
    length = ends[:, :2].mean(axis=1) - ends[:, 2:].mean(axis=1)
    np.testing.assert_allclose(length, 1e3 * 0.127 * (1 - strain), atol=1e-3)  # single precision
    assert [unit for unit, _ in run.drawing.muscles] == [0, 1, 1, 1, 1]


def test_jobs_that_end_together_and_a_process_that_dies_leave_the_next_ones_alone():
    with ThreadPoolExecutor(2) as threads:
        roots = threads.map(lambda x: run_job(math.sqrt, x), [float(x) for x in range(40)])
        assert list(roots) == [math.sqrt(x) for x in range(40)]
    for function, argument in ((math.sqrt, -1.0), (os._exit, 1)):
        with refuses_at(""):
            run_job(function, argument)
    assert run_job(math.sqrt, 4.0) == 2.0
    stop_jobs()


def test_a_canceled_run_is_not_shown(tab, monkeypatch):
    before = tab.result
    monkeypatch.setattr(LatestResult, "request", lambda *_: None)
    tab.start_run()
    assert tab.job.run.disabled and not tab.job.cancel.disabled
    tab.job.stop()
    assert tab.job.cancel.disabled and not tab.job.run.disabled and tab.result is before


def test_a_long_run_is_refused():
    text = example_text("lift_gas").replace('"6 s"', '"60 s"')
    with refuses_at("long.toml: "):
        time_run.run_policies(text, "long.toml", ())


def test_the_explorer_starts_without_jax():
    code = (
        "import sys, fascicle as fs; from fascicle.explorer import server, page, state;"
        "view = state.view_of(fs.example('kim2021_figure_6'), 'kim2021_figure_6');"
        "session = state.Session(view); page.Page(session); session.change(tab='time');"
        "print('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr


def test_a_file_is_opened_and_refused(tab):
    tab.inputs.file.param.update(value=example_text("lift_oil").encode(), filename="mine.toml")
    assert tab.session.view.setup.name == "mine.toml"
    assert not tab.inputs.policies.visible
    tab.inputs.file.param.update(value=b"\xff\xfe", filename="bad.toml")
    assert "bad.toml" in str(tab.message.text)
    assert tab.session.view.setup.name == "mine.toml"
    for path, value in (("run.duration", 1.0), ("load.mass", -1.0), ("supply.pressure", 9e9)):
        with pytest.raises(InvalidInputError):
            tab.session.view.setup.with_value(path, value)
    name, raw = tab.inputs._scenario_file()
    (bundle,) = loads_scenario(raw.decode(), name).plant.bundles
    assert name != "mine.toml"
    assert dumps(bundle) == dumps(tab.session.view.bundle)
    assert dumps(bundle) == dumps(fs.example("kim2021_bundle_1_4"))


@pytest.mark.parametrize(
    "table", ['[control]\nmodel = "/etc/passwd"', "[control]\nmodel = 'm.toml'"]
)
def test_a_visitors_scenario_reads_no_file_of_the_server(table, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.toml").write_text(example_text("kim2021_bundle_1_4"))
    text = example_text("ramp_1_4").replace("[control]", table)
    with refuses("control.model"):
        loads_scenario(text, "visitor.toml")

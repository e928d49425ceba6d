"""A short run as labelled values, as a picture, and as a page."""

import re

import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.dynamics import audit
from fascicle.files import example_text, loads_scenario
from fascicle.report.simulation import report


SHORT = (
    example_text("lift_gas")
    .replace('duration = "6 s"', 'duration = "40 ms"')
    .replace('time = "1 s"', 'time = "20 ms"')
    .partition('[[schedule]]\ntime = "2 s"')[0]
)


@pytest.fixture(scope="module")
def ran():
    read = loads_scenario(SHORT)
    run = read.run()
    return read, run, audit(read.plant, run)


def test_run_table_has_units(ran):
    read, run, audited = ran
    data = fs.tables.simulated(read.plant, run, audited).dataset(title="t", source="s")
    assert data.sizes == {"time": 41, "motor_unit": 2, "valve": 2, "balance": 5, "event": 0}
    units = {"position": "m", "velocity": "m/s", "pressure": "Pa", "temperature": "K",
             "strain": "1", "force": "N", "fluid_mass": "kg", "supply_opening": "1",
             "drawn": "kg/s", "command": "1", "status": "1", "account_supplied": "J",
             "account_mass": "kg", "stored_load": "J"}  # fmt: skip
    assert {name: data[name].attrs["units"] for name in units} == units
    assert all(data[name].attrs["long_name"] for name in data.variables)
    assert_allclose(data["pressure"][-1], run.outputs.pressures[-1])
    assert_allclose(data["command"][[0, 19, 20, -1], 0], [1, 1, 0, 0])
    assert data["closes"].values.all()
    # a term of the account is the one of its name: the mass that came in is what is there
    came = data["account_mass"][-1] - data["account_mass"][0]
    held = data["fluid_mass"].sum("motor_unit")
    assert_allclose(came, held[-1] - held[0], rtol=1e-9)
    potential = 10 * 9.80665 * (data["position"][-1] - data["position"][0])
    assert_allclose(data["stored_load"][-1] - data["stored_load"][0], potential, rtol=1e-9)


def test_a_table_of_a_joint_has_radians():
    text = example_text("joint_step").replace('duration = "3 s"', 'duration = "1 ms"')
    read = loads_scenario(text)
    table = fs.tables.simulated(read.plant, read.run())
    assert table["position"].unit == "rad" and table["velocity"].unit == "rad/s"
    assert table["bundle"].values.tolist() == [1, 1, 2, 2]
    assert "balance" not in table


def test_page_reports_whether_the_balances_close(ran):
    read, run, audited = ran
    page = report(read, run, audited, "2026-05-04")
    assert not audited.findings
    assert "http" not in re.sub(r'href="data:[^"]*"|src="data:[^"]*"', "", page)
    balance = audited.balances[0]._replace(name="<a fit>", tolerance=0.0)
    doubted = report(read, run, audited._replace(balances=(balance,)), "2026-05-04")
    assert "&lt;a fit&gt;" in doubted and "<a fit>" not in doubted

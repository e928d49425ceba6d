"""A scenario takes the friction that a calibration found; one without any runs to the bit."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.calibrate import fit
from fascicle.calibrate.findings import calibration_findings
from fascicle.dynamics import Damping, MaxwellSlip, audit
from fascicle.files import lift_scenario, load_scenario, loads_scenario
from fascicle.files.calibration_files import provenance_of
from fascicle.records import Record, Source, VirtualDynamometer, join
from fascicle.report.calibration_words import damping_message
from refusing import refuses


SCENARIO = """
format = 1
bundle = "muscle.toml"
[load]
kind = "hanging_mass"
mass = "3 kg"
damping = "100 N*s/m"
[fluid]
conductance = "0.2 W/K"
dead_volume = "2e-6 m^3"
[supply]
kind = "constant"
pressure = "413.7 kPa"
[valve]
kind = "sonic_valve"
C = "0.06 L/(s*bar)"
b = 0.3
[hysteresis]
kind = "measured"
[run]
duration = "0.05 s"
[[schedule]]
time = "0 s"
command = 1
"""
FRICTION = '[hysteresis]\nkind = "measured"\n'
NOMINAL = fs.example("kim2021_slenderness_10").replace(tuning=None)


@pytest.fixture(scope="module", params=[0.06, 0.0], ids=["rubs", "smooth"])
def calibration(request):
    record = VirtualDynamometer(
        pressures=[1e5, 2e5, 4e5], hysteresis=request.param, samples=40, noise=0.002
    ).record(NOMINAL, seed=3)
    return fit(record, NOMINAL, ["c10"], whole=False)


def saved(calibration, folder):
    report = provenance_of(calibration, "2026-11-22")
    fs.save(calibration.muscle, folder / "muscle.toml", report)
    (folder / "scenario.toml").write_text(SCENARIO, encoding="utf-8")
    return load_scenario(folder / "scenario.toml")


def test_plant_has_the_measured_springs(calibration, tmp_path):
    scenario = saved(calibration, tmp_path)
    if calibration.friction.law is None:
        plain = loads_scenario(SCENARIO.replace(FRICTION, ""), folder=tmp_path)
        assert scenario.plant.hysteresis is None
        # to the bit
        assert_array_equal(scenario.run().outputs.position, plain.run().outputs.position)
        return
    friction, law = scenario.plant.hysteresis, calibration.friction.law
    assert isinstance(friction, MaxwellSlip)
    for name in ("stiffness", "slip_force", "slip_force_slope"):
        # the file has four digits of each
        short = [float(f"{x:.4g}") for x in getattr(law, name)]
        assert_allclose(getattr(friction, name), short, rtol=1e-14)
    half = calibration.friction.half_width(4e5)
    assert_allclose(half, 0.03 * NOMINAL.blocked_force(4e5), rtol=0.03)


def test_unmeasured_friction_is_refused(tmp_path):
    fs.save(NOMINAL, tmp_path / "muscle.toml")
    for friction, key in ((FRICTION, "kind"), (FRICTION + 'muscle = "none.toml"\n', "muscle")):
        with refuses(f"hysteresis.{key}"):
            loads_scenario(SCENARIO.replace(FRICTION, friction), folder=tmp_path)


def two_speeds(speeds):
    """A synthetic record of both ways at each pressure and speed [m/s], damped by 80 N·s/m."""
    rng, rows, clock = np.random.default_rng(2), [], 0.0
    for speed in speeds:
        for P in (1e5, 2e5, 4e5):
            for way in (1, -1):
                strain = np.linspace(0, 0.15, 40)[::way]
                time = clock + np.abs(strain - strain[0]) * float(NOMINAL.length) / speed
                force = NOMINAL.force(P, strain) - way * (1.0 + 80.0 * speed)
                rows.append((np.full(40, P), strain, force + 0.1 * rng.normal(size=40), time))
                clock = time[-1] + 0.01
    P, strain, force, time = map(np.concatenate, zip(*rows, strict=True))
    return Record.of(P, strain, force, time=time, rest_length=0.127, synthetic=True)


DAMPING = '[damping]\nkind = "measured"\n'


@pytest.fixture(scope="module")
def damped():
    """A calibration to a file for each speed, with a clock of its own."""
    parts = [two_speeds([speed]) for speed in (5e-3, 50e-3)]
    named = [replace(x, sources=(Source(f"{i}", "0" * 64),)) for i, x in enumerate(parts)]
    return fit(join(named), NOMINAL, ["c10"], whole=False)


def test_plant_has_the_measured_damping_beside_springs_without_it(damped, tmp_path):
    calibration = damped
    fs.save(calibration.muscle, tmp_path / "muscle.toml", provenance_of(calibration, "2026-11-22"))
    scenario = loads_scenario(SCENARIO.replace("[run]", f"{DAMPING}[run]"), folder=tmp_path)
    law, fitted = scenario.plant.damping, calibration.damping.law
    assert isinstance(law, Damping)
    for way in (0.05, -0.05):
        # four digits in the file; 240 readings of 0.1 N over 45 mm/s give 80 to 0.5
        assert_allclose(law.force(way, 2e5), fitted.force(way, 2e5), rtol=1e-3)
        assert_allclose(law.coefficient(way, 2e5), 80, atol=2.5)
    # the loops' half width without the damper's part
    assert_allclose(calibration.friction.half_width(2e5), 1.0, atol=0.1)
    assert "use.damping_unknown" not in {x.code for x in calibration_findings(calibration)}
    assert damping_message(calibration)


def test_a_calibrated_muscle_lifts_a_mass_with_its_friction(damped, tmp_path):
    calibration, path, units = damped, tmp_path / "muscle.toml", (2, 1)
    fs.save(calibration.muscle, path, provenance_of(calibration, "2026-11-22"))
    bundle = fs.Bundle([fs.MotorUnit(calibration.muscle, count) for count in units])
    scenario = lift_scenario(bundle, "muscle", path)
    plant = scenario.plant
    assert isinstance(plant.hysteresis, MaxwellSlip) and isinstance(plant.damping, Damping)
    assert plant.counts.tolist() == list(units)
    half = units[0] * calibration.muscle.blocked_force(plant.supply_pressure) / 2
    # the file has three digits of the mass
    assert_allclose(plant.load.mass * plant.load.gravity, half, rtol=5e-3)
    assert lift_scenario(bundle, "muscle", path, mass=1.2345).plant.load.mass == 1.2345
    run = scenario.run()
    assert audit(plant, run).closes
    position = run.outputs.position
    assert np.max(position) > position[0] + 0.1 * float(calibration.muscle.length)
    assert position[-1] < np.max(position)


def test_one_speed_leaves_damping_unknown(tmp_path):
    calibration = fit(two_speeds([5e-3]), NOMINAL, ["c10"], whole=False)
    data = {x.code: x.data for x in calibration_findings(calibration)}["use.damping_unknown"]
    assert data["directions"] == ["shortening", "lengthening"]
    assert_allclose([data["slowest"], data["fastest"]], 5e-3, rtol=1e-6)
    fs.save(calibration.muscle, tmp_path / "muscle.toml", provenance_of(calibration, "2026-11-22"))
    with refuses("damping.kind"):
        loads_scenario(SCENARIO.replace("[run]", f"{DAMPING}[run]"), folder=tmp_path)

"""A scenario takes the friction that a calibration found; one without any runs to the bit."""

import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.calibrate import fit
from fascicle.dynamics import MaxwellSlip
from fascicle.files import load_scenario, loads_scenario
from fascicle.files.calibration_files import provenance_of
from fascicle.records import VirtualDynamometer


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
    for friction, message in (
        (FRICTION, "muscle.toml has no friction"),
        (FRICTION + 'muscle = "none.toml"\n', "must name the"),
    ):
        with pytest.raises(ValueError, match=message):
            loads_scenario(SCENARIO.replace(FRICTION, friction), folder=tmp_path)

"""A scenario takes the friction that a calibration found; one without any runs to the bit."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

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
    fs.save(
        calibration.muscle,
        folder / "muscle.toml",
        calibration=provenance_of(calibration, "2026-11-22"),
    )
    (folder / "scenario.toml").write_text(SCENARIO, encoding="utf-8")
    return load_scenario(folder / "scenario.toml")


def test_plant_has_the_measured_springs(calibration, tmp_path):
    scenario = saved(calibration, tmp_path)
    if calibration.friction.law is None:
        plain = loads_scenario(SCENARIO.replace(FRICTION, ""), folder=tmp_path)
        assert scenario.plant.hysteresis is None
        # today's result, to the bit
        ours, theirs = scenario.run(), plain.run()
        assert np.array_equal(ours.outputs.position, theirs.outputs.position)
        return
    friction, law = scenario.plant.hysteresis, calibration.friction.law
    assert isinstance(friction, MaxwellSlip)
    for name in ("stiffness", "slip_force", "slip_force_slope"):
        # the file has four digits of each
        short = [float(f"{x:.4g}") for x in getattr(law, name)]
        np.testing.assert_allclose(getattr(friction, name), short, rtol=1e-14)
    assert_allclose(
        calibration.friction.half_width(4e5), 0.03 * NOMINAL.blocked_force(4e5), rtol=0.03
    )


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (('bundle = "muscle.toml"', 'bundle = "nominal.toml"'), "nominal.toml has no friction"),
        (('kind = "measured"', 'kind = "measured"\nmuscle = "none.toml"'), "must name the"),
    ],
)
def test_unmeasured_friction_is_refused(edit, message, tmp_path):
    fs.save(NOMINAL, tmp_path / "nominal.toml")
    fs.save(NOMINAL, tmp_path / "muscle.toml")
    with pytest.raises(ValueError, match=message):
        loads_scenario(SCENARIO.replace(*edit), folder=tmp_path)

"""Values that functions of bundles and muscles refuse, with the name of the argument."""

import math
from importlib.util import find_spec

import numpy as np
import pytest

import fascicle as fs
from fascicle import energetics, recruitment, reversal


MUSCLE = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33))
BUNDLE = fs.Bundle([fs.MotorUnit(MUSCLE), fs.MotorUnit(MUSCLE, 4)], supply_pressure=413.7e3)
LONGER = MUSCLE.replace(length=0.131)
PLATES = fs.Bundle([fs.MotorUnit(MUSCLE), fs.MotorUnit(LONGER)], 4e5, length=0.13)
NEEDS_MATPLOTLIB = pytest.mark.skipif(find_spec("matplotlib") is None, reason="no matplotlib")
BATCH = BUNDLE.replace(
    motor_units=[fs.MotorUnit(MUSCLE.replace(braid_angle=np.array([0.55, 0.6])))]
)
SUPPLIES = [1e5, 2e5]


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("supply", lambda: BUNDLE.recruit(10.0, 0.1, supply=SUPPLIES)),
        ("supply_pressure", lambda: BUNDLE.workspace(SUPPLIES)),
        ("supply_pressure", lambda: BUNDLE.reversal(2, SUPPLIES)),
        ("supply_pressure", lambda: BUNDLE.efficiency_map(SUPPLIES)),
        ("supply_pressure", lambda: BUNDLE.average_efficiency(SUPPLIES)),
        ("supply_pressure", lambda: recruitment.pressures_of(1, 1e5, math.nan, 2)),
        ("supply_pressure", lambda: energetics.fluid_energy(BUNDLE, 0.1, -1.0, [1, 1])),
        ("active", lambda: energetics.fluid_energy(BUNDLE, 0.1, 4e5, [1])),
        ("active", lambda: energetics.fluid_energy(BUNDLE, 0.1, 4e5, 1)),
        ("level", lambda: recruitment.pressures_of(1, -1.0, 4e5, 2)),
        ("level", lambda: recruitment.pressures_of(1, math.nan, 4e5, 2)),
        ("levels", lambda: BUNDLE.workspace(levels=0)),
        ("levels", lambda: BUNDLE.workspace(levels=math.nan)),
        ("pressures", lambda: reversal.free_strain_curve(BUNDLE, 2, [0.0, 2e6])),
        ("present", lambda: BUNDLE.recruit(10.0, 0.1, prefer="nearest", present=[0.0])),
        ("present", lambda: BUNDLE.recruit(10.0, 0.1, prefer="nearest", present=[0.0, -1.0])),
        ("unit", lambda: BUNDLE.reversal(True)),
        ("strain", lambda: reversal.onset_pressure(BUNDLE, [0.1, 0.2])),
        ("units", lambda: fs.Bundle.constant_cross_section(MUSCLE, 1.5)),
        ("units", lambda: fs.Bundle.constant_cross_section(MUSCLE, "two")),
        ("units", lambda: fs.Bundle.constant_cross_section(MUSCLE, 0)),
        ("motor_units", lambda: fs.Bundle([])),
        ("motor_units", lambda: fs.Bundle([fs.MotorUnit(MUSCLE), fs.MotorUnit(LONGER)])),
        ("length", lambda: fs.Bundle(PLATES.motor_units, length=-1.0)),
        ("length", lambda: fs.Bundle(PLATES.motor_units, length=0.17)),
        ("count", lambda: fs.MotorUnit(MUSCLE, 0)),
        ("count", lambda: fs.MotorUnit(MUSCLE, 1.5)),
        ("scheme", lambda: BUNDLE.replace(scheme="ordrly")),
        ("supply_pressure", lambda: BUNDLE.replace(supply_pressure=-1.0)),
        ("pressures", lambda: BUNDLE.force([1e5], 0.1)),
        ("pressures", lambda: BUNDLE.force(1e5, 0.1)),
        ("pressures", lambda: BUNDLE.free_strain([1e5, math.nan])),
        ("strain", lambda: BUNDLE.force([1e5, 1e5], 0.7)),
        ("strain", lambda: PLATES.force([1e5, 1e5], 0.7)),
        ("strain", lambda: energetics.fluid_energy(PLATES, -0.25, 4e5, [1, 1])),
        ("force", lambda: BUNDLE.recruit(math.nan, 0.1)),
        ("strain", lambda: BUNDLE.recruit(10.0, 0.7)),
        ("scheme", lambda: BUNDLE.recruit(10.0, 0.1, scheme="ordrly")),
        ("prefer", lambda: BUNDLE.recruit(10.0, 0.1, prefer="cheap")),
        ("present", lambda: BUNDLE.recruit(10.0, 0.1, prefer="nearest")),
        ("supply", lambda: fs.Bundle(BUNDLE.motor_units).recruit(10.0, 0.1)),
        ("supply_pressure", lambda: fs.Bundle(BUNDLE.motor_units).workspace()),
        ("levels", lambda: BUNDLE.workspace(levels=[0.0, 5e5])),
        ("state", lambda: recruitment.pressures_of(3, 1e5, 4e5, 2)),
        ("unit", lambda: BUNDLE.reversal(3)),
        ("unit", lambda: reversal.onset_pressure(BUNDLE, 0.1, unit="3 bar")),
        ("path", lambda: BUNDLE.average_efficiency(path="isobar")),
        ("strain", lambda: BUNDLE.efficiency_map(strain=[0.0])),
        ("bundle", lambda: BATCH.recruit(50.0, 0.1)),
        ("bundle", BATCH.reversal),
        ("bundle", BATCH.average_efficiency),
        pytest.param("bundle", lambda: fs.plot.bundle_force_strain(BATCH), marks=NEEDS_MATPLOTLIB),
        ("bundle", lambda: reversal.reversal(MUSCLE)),
        ("points", lambda: MUSCLE.shape(1e5, 0.3, 2)),
        ("points", lambda: MUSCLE.shape(1e5, 0.3, math.nan)),
        ("points", lambda: MUSCLE.at(1e5).shape(0.3, None)),
    ],
)
def test_refused_arguments(argument, call):
    with pytest.raises(fs.InvalidInputError) as error:
        call()
    assert error.value.argument == argument
    assert error.value.rule
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("method", ["force", "stiffness", "deflection", "moment"])
def test_empty_arrays(method):
    curve = getattr(MUSCLE, method)
    assert curve(np.zeros(0), 0.1).shape == (0,)
    assert curve(np.zeros((3, 1)), np.zeros(0)).shape == (3, 0)

"""Values that functions of bundles and muscles refuse, with the name of the argument."""

import math

import numpy as np
import pytest

import fascicle as fs
from fascicle import energetics, recruitment, reversal


MUSCLE = fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(33))
BUNDLE = fs.Bundle([fs.MotorUnit(MUSCLE), fs.MotorUnit(MUSCLE, 4)], supply_pressure=413.7e3)
SUPPLIES = [1e5, 2e5]


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("supply_pressure", lambda: BUNDLE.recruit(10.0, 0.1, supply=SUPPLIES)),
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
        ("units", lambda: energetics.constant_cross_section(MUSCLE, 1.5)),
        ("units", lambda: energetics.constant_cross_section(MUSCLE, "two")),
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

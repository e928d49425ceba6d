"""Extension, whose commonest cause is a sign error, is warned about; tiny pressures have forces."""

import math
import warnings

import numpy as np
import pytest

import fascicle as fs
from fascicle.muscle.laws import LAWS
from refusing import warns


MUSCLE = fs.Muscle(0.18, 5e-3, 1e-3, math.radians(25))
BUNDLE = fs.Bundle([fs.MotorUnit(MUSCLE, 1), fs.MotorUnit(MUSCLE, 2)], supply_pressure=4e5)
UNEQUAL = fs.Bundle(
    [fs.MotorUnit(MUSCLE, 1), fs.MotorUnit(MUSCLE.replace(length=0.175), 2)],
    supply_pressure=4e5,
    length=0.18,
)

# unlike braid angles
ROWS = fs.Muscle(0.18, 5e-3, 1e-3, np.radians([25.0, 40.0]))

CALLS = {
    "force": lambda strain: MUSCLE.force(2e5, strain),
    "response": lambda strain: MUSCLE.response(2e5, strain),
    "stiffness": lambda strain: MUSCLE.stiffness(2e5, strain),
    "volume": MUSCLE.volume,
    "at": lambda strain: MUSCLE.at(2e5).force(strain),
    "bundle": lambda strain: BUNDLE.force([2e5, 0.0], strain),
    "bundle of unequal lengths": lambda strain: UNEQUAL.force([2e5, 0.0], strain),
    "bundle of unequal angles": lambda strain: fs.Bundle(
        [fs.MotorUnit(MUSCLE), fs.MotorUnit(MUSCLE.replace(braid_angle=0.6))], supply_pressure=4e5
    ).force([2e5, 0.0], strain),
    "rows": lambda strain: ROWS.force(2e5, strain),
}


@pytest.mark.parametrize("name", CALLS)
def test_an_extension_past_two_percent_warns_at_the_callers_line(name):
    for strain in (-0.05, np.array([0.1, -0.05])):
        with warns("-0.05") as warned:
            CALLS[name](strain)
        assert len(warned) == 1 and "src/fascicle" not in warned[0].filename
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        CALLS[name](-0.02)
        CALLS[name](np.array([-0.01, 0.2]))


@pytest.mark.parametrize(("kind", "name"), [(kind, law) for kind in LAWS for law in LAWS[kind]])
@pytest.mark.filterwarnings("ignore")
def test_subnormal_pressures_have_finite_forces(kind, name):
    muscle = MUSCLE.replace(**{kind: name})
    pressures = np.array([5e-324, 1e-322, 1e-310, 1e-300])[:, None]
    strains = np.array([-0.05, 0.0, 1e-9, 0.05, 0.2, 0.5])
    for quantity in (muscle.force, muscle.stiffness, muscle.moment, muscle.deflection):
        assert np.all(np.isfinite(quantity(pressures, strains)))
    assert np.all(np.isfinite(muscle.free_strain(pressures)))


# -0.2 is within reach of 40 deg (-0.305), and not of 25 deg (-0.103)
ROW_CALLS = {
    "force": (ROWS.force, lambda muscle: muscle.force),
    "stiffness": (ROWS.stiffness, lambda muscle: muscle.stiffness),
    "volume": (lambda _, eps: ROWS.volume(eps), lambda m: lambda _, eps: m.volume(eps)),
    "at": (lambda P, eps: ROWS.at(P).force(eps), lambda m: lambda P, eps: m.at(P).force(eps)),
    "bundle": (
        lambda P, eps: fs.Bundle([fs.MotorUnit(ROWS)], supply_pressure=4e5).force([P], eps),
        lambda m: m.force,
    ),
}


@pytest.mark.parametrize("name", ROW_CALLS)
@pytest.mark.filterwarnings("ignore")
def test_each_row_of_muscles_has_its_own_domain(name):
    rows, of = ROW_CALLS[name]
    expected = [
        of(MUSCLE)(2e5, 0.1), of(MUSCLE.replace(braid_angle=math.radians(40)))(2e5, -0.2)
    ]  # fmt: skip
    np.testing.assert_allclose(rows(2e5, np.array([0.1, -0.2])), expected, rtol=1e-12)
    for strain in (np.array([-0.15, -0.2]), np.full(3, 0.1)):  # off the first's domain; of 3 rows
        with pytest.raises(fs.InvalidInputError):
            rows(2e5, strain)

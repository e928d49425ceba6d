"""Text and quantities with units are accepted wherever a number in SI is, and to the bit."""

import math
import warnings

import jax
import numpy as np
import pint
import pytest

import fascicle as fs
from fascicle.core.validation import to_si
from fascicle.records import VirtualDynamometer
from refusing import warns


ureg = pint.UnitRegistry()
MUSCLE = fs.example("kim2021_figure_6")
BUNDLE = fs.example("kim2021_bundle_1_4")
SIZES = {"length": 0.127, "outer_radius": 6.35e-3, "wall_thickness": 1.6e-3}


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        ("2 bar", "Pa", 2e5), ("6.35 mm", "m", 6.35e-3), ("33 deg", "rad", math.radians(33)),
        (["1 bar", 0.0], "Pa", [1e5, 0.0]), (np.array(["1 bar", "2 bar"]), "Pa", [1e5, 2e5]),
        ((("1 bar", "2 bar"), (3e5, "4 bar")), "Pa", [[1e5, 2e5], [3e5, 4e5]]),
        (np.array("1 bar"), "Pa", 1e5), (2 * ureg.m, "m", 2.0),
        ([2 * ureg.m, "3 m"], "m", [2.0, 3.0]),
    ],
)  # fmt: skip
def test_values_with_units_become_si_numbers(value, unit, expected):
    assert to_si(value, "x", unit) == expected


@pytest.mark.parametrize("plain", [1.0, np.float64(2.0), [1.0, 2.0], np.ones(3), None, [[1, 2.0]]])
def test_numbers_pass_as_they_are(plain):
    assert to_si(plain, "x", "Pa") is plain


def test_a_muscle_is_made_and_evaluated_in_any_unit():
    written = fs.Muscle("127 mm", "0.25 in", "1.6 mm", "33 deg")
    numbers = fs.Muscle(**SIZES, braid_angle=math.radians(33))
    assert written == numbers
    of_pint = fs.Muscle(127 * ureg.mm, 6.35 * ureg.mm, 1.6 * ureg.mm, 33 * ureg.deg)
    assert of_pint.force(1e5, 0.1) == pytest.approx(numbers.force(1e5, 0.1), rel=1e-12)
    assert written.replace(wall_thickness="1 mm") == numbers.replace(wall_thickness=1e-3)
    assert fs.MooneyRivlin("118.4 kPa", "105.7 kPa") == fs.materials.LATEX
    tuning = fs.Tuning(["1 bar", "2 bar"], ["1 N", "2 N"], [1.1, 1.2], dead_band="5 kPa")
    assert tuning == fs.Tuning([1e5, 2e5], [1.0, 2.0], [1.1, 1.2], dead_band=5e3)


@pytest.mark.parametrize(
    "call",
    [
        lambda P: MUSCLE.force(P, 0.1), lambda P: MUSCLE.response(P, 0.1).mesh,
        lambda P: MUSCLE.stiffness(P, 0.1), lambda P: MUSCLE.at(P).force(0.1),
        MUSCLE.free_strain, MUSCLE.blocked_force, MUSCLE.collapse_strain, MUSCLE.collapse_moment,
        lambda P: MUSCLE.conjugate_volume(P, 0.1), lambda P: MUSCLE.deflection(P, 0.3),
        lambda P: MUSCLE.moment(P, 0.3), lambda P: MUSCLE.shape(P, 0.3, 5).y[2],
        lambda P: BUNDLE.force([P, 0.0], 0.1), lambda P: BUNDLE.unit_forces([[P, P]], 0.1).sum(),
        lambda P: BUNDLE.free_strain([P, P]), lambda P: BUNDLE.equilibria([P, 0.0]).strain[0],
        lambda P: BUNDLE.strain_at(20.0, [P, 0.0]).strain[0],
        lambda P: BUNDLE.replace(supply_pressure=P).supply_pressure,
        lambda P: fs.recruitment.recruit(BUNDLE, 20.0, 0.05, P).pressures[0],
        lambda P: fs.recruitment.pressures_of(2, P, P, 2)[1],
        lambda P: fs.recruitment.workspace(BUNDLE, P, [P]).force.sum(),
        lambda P: fs.reversal.free_strain_curve(BUNDLE, 2, [P], P)[0],
        lambda P: fs.energetics.work(BUNDLE, [P, P], 0.1),
        lambda P: fs.energetics.fluid_energy(BUNDLE, 0.1, P, [1, 1]),
        lambda P: fs.tables.muscle_free_strain(MUSCLE, [P])["blocked_force"].values[0],
        lambda P: VirtualDynamometer([P], samples=3, noise=0.0).record(MUSCLE).force[0],
    ],
)  # fmt: skip
def test_a_pressure_is_accepted_with_its_unit(call):
    expected = call(2e5)
    assert call("2 bar") == call("200 kPa") == expected
    np.testing.assert_allclose(call(2 * ureg.bar), expected, rtol=1e-12)


def test_strains_and_forces_are_accepted_with_their_units():
    assert MUSCLE.force("2 bar", "10 %") == MUSCLE.force(2e5, 0.1)
    eps = BUNDLE.strain_at("20 N", ["2 bar", 0.0]).strain[0]
    assert eps == BUNDLE.strain_at(20.0, [2e5, 0.0]).strain[0]


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        *(("pressure", lambda P=P: MUSCLE.force(P, 0.1))
          for P in ("2 mm", 2 * ureg.mm, "2", "20 bar")),
        ("braid_angle", lambda: fs.Muscle(**SIZES, braid_angle="60 deg")),
    ],
)  # fmt: skip
def test_another_quantity_is_refused(argument, call):
    with pytest.raises(fs.InvalidInputError) as error:
        call()
    assert error.value.argument == argument


@pytest.mark.parametrize(
    ("call", "guess"),
    [
        (lambda: MUSCLE.force(2.0, 0.1), "2 bar"), (lambda: MUSCLE.at(400.0), "400 kPa"),
        (lambda: MUSCLE.force(200.0, 0.1), "200 kPa"),
        (lambda: MUSCLE.free_strain(np.array([0.0, 1.0, 4.0])), "4 bar"),
        (lambda: BUNDLE.force([3.4, 0.0], 0.1), "3.4 bar"),
    ],
)  # fmt: skip
def test_a_low_pressure_warns_at_the_users_line(call, guess):
    with warns(guess) as caught:
        call()
    assert [warning.filename for warning in caught] == [__file__]


def test_intended_low_pressures_do_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        MUSCLE.force(np.linspace(0.0, 4e5, 1000), 0.1)  # begins low
        MUSCLE.force(0.0, 0.1)
        MUSCLE.force("0.5 kPa", 0.1)
        BUNDLE.force(["344.7 kPa", 0.0], 0.1)
        jax.jit(MUSCLE.force)(2.0, 0.1)  # traced: not checked


def test_the_unit_decides_on_a_texts_dimension_whatever_the_arguments_name():
    assert to_si("12 %", "strain", "-") == to_si("12 %", "share", "-") == 0.12
    assert to_si("2 bar", "strain", "Pa") == 2e5

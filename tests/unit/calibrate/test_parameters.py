import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate import fit
from fascicle.calibrate.parameters import PARAMETERS, coordinates, put, select_parameters
from fascicle.calibrate.parameters import values as values_of
from fascicle.muscle.tension import TENSION_LAWS, Meller2014
from fascicle.records.record import Record


TUNING = fs.Tuning(
    youngs_modulus_factor=0.95,
    collapse_moment_factor=0.75,
    hinge_stiffness_factor=0.83,
    hinge_stiffness_slope=0.92e-5,
    transition_rate=90.0,
    dead_band=20e3,
)
SIZES = (0.127, 6.35e-3, 1.6e-3, np.radians(33))
muscle = fs.Muscle(*SIZES, tuning=TUNING)
LAWS = {law.name: [one.name for one in law.constants()] for law in TENSION_LAWS.values()}
WILD = (-50.0, -5.0, 0.0, 5.0, 50.0)


def leaves(a):
    return [np.asarray(leaf) for leaf in jax.tree.leaves(a)]


@pytest.mark.parametrize("name", PARAMETERS)
def test_round_trip(name):
    one = PARAMETERS[name]
    again = one.put(muscle, one.coordinate(muscle))
    # a logarithm and its exponential cost some ulps; near 1 MPa the slope's softplus more
    for was, is_now in zip(leaves(muscle), leaves(again), strict=True):
        assert_allclose(is_now, was, rtol=1e-12, atol=0)
    for away in (-2.0, 0.3, 2.0):
        z = one.coordinate(muscle) + away
        moved = one.put(muscle, z)
        # what cancels in the slope's coordinate, far from the factor at zero, is 1e-14 or so
        assert_allclose(one.coordinate(moved), z, rtol=1e-10)
        back = one.put(moved, one.coordinate(muscle))
        assert_allclose(one.value(back), one.value(muscle), rtol=1e-12)


@pytest.mark.parametrize("name", PARAMETERS)
def test_wherever_the_search_goes_the_muscle_can_be(name):
    for z in WILD:
        check_muscle(PARAMETERS[name].put(muscle, jnp.asarray(z)))


def check_muscle(moved):
    assert all(np.all(np.isfinite(leaf)) for leaf in leaves(moved))
    tuning = moved.tuning
    sizes = moved.length, moved.wall_thickness, moved.outer_radius, moved.braid_angle
    moduli = moved.material.c10, moved.material.c01, moved.material.youngs_modulus
    factors = tuning.youngs_modulus_factor, tuning.collapse_moment_factor
    hinge = tuning.hinge_stiffness_factor, tuning.transition_rate
    assert all(value > 0 for value in (*sizes, *moduli, *factors, *hinge))
    # e^-50 is lost beside 1: the wall may fill the radius to the last bit, not more
    assert moved.wall_thickness <= moved.outer_radius
    assert moved.braid_angle <= np.arctan(np.sqrt(2))


@pytest.mark.parametrize("factor", WILD)
@pytest.mark.parametrize("slope", WILD)
def test_hinge_stays_positive_up_to_the_highest_pressure(factor, slope):
    both = select_parameters(["hinge_stiffness_factor", "hinge_stiffness_slope"], muscle)
    tuning = put(both, muscle, jnp.asarray([factor, slope])).tuning
    # affine: its ends bound it; what e^50 leaves of e^-50 at 1 MPa is rounding
    top = float(tuning.hinge_stiffness_at(1e6))
    assert tuning.hinge_stiffness_at(0.0) > 0
    assert top > -1e-15 * float(tuning.hinge_stiffness_factor)
    if factor <= 5:
        assert_allclose(top, np.logaddexp(slope, 0), rtol=1e-9, atol=1e-13)


def test_a_modulus_that_follows_the_constants_follows_them():
    def moved(of, names, values):
        return put(select_parameters(names, muscle), of, jnp.log(jnp.asarray(values))).material

    two = moved(muscle, ["c10", "c01"], [2e5, 3e5])
    assert_allclose(two.youngs_modulus, 6 * 5e5, rtol=1e-14)
    own = fs.Muscle(*SIZES, material=fs.MooneyRivlin(1e5, 1e5, 1.78e6))
    apart = moved(own, ["c10", "c01"], [2e5, 3e5])
    assert_allclose(apart.youngs_modulus, 1.78e6, rtol=0)
    assert_allclose([apart.c10, apart.c01], [2e5, 3e5], rtol=1e-14)
    # named itself, it is what it is named
    named = moved(muscle, ["youngs_modulus", "c10", "c01"], [2e5, 3e5, 4e5])
    assert_allclose(named.youngs_modulus, 4e5, rtol=1e-14)


def test_a_radius_and_its_wall_together_can_be():
    both = select_parameters(["wall_thickness", "outer_radius"], muscle)
    for z in np.array(np.meshgrid(WILD, WILD)).reshape(2, -1).T:
        moved = put(both, muscle, jnp.asarray(z))
        assert 0 < moved.wall_thickness <= moved.outer_radius


def test_no_transition_rate_in_the_tuning_is_the_muscles_own():
    bare = fs.Muscle(*SIZES, transition_rate=30.0)
    rate = PARAMETERS["transition_rate"]
    assert float(rate.value(bare)) == 30.0
    moved = rate.put(bare, jnp.log(40.0))
    assert_allclose(moved.tuning.transition_rate, 40.0, rtol=1e-14)
    assert float(moved.transition_rate) == 30.0


# the last is a constant of a law that this muscle doesn't have
@pytest.mark.parametrize("names", [["braid_angel"], [], ["strain_factor"]])
def test_names_that_the_muscle_has_not_are_refused(names):
    with pytest.raises(fs.InvalidInputError) as error:
        select_parameters(names, muscle)
    assert error.value.argument == "fit"


@pytest.mark.parametrize(("law", "names"), [one for one in LAWS.items() if one[1]])
def test_a_tension_laws_own_constants(law, names):
    other = fs.Muscle(*SIZES, tension=law)
    own = [one.name for one in other.tension.constants()]
    assert set(names) <= set(own)
    free = select_parameters(names, other)
    assert [one.name for one in free] == [n for n in own if n in names]
    z = coordinates(free, other)
    assert_allclose(values_of(free, put(free, other, z)), values_of(free, other), rtol=1e-12)
    for one, constant in zip(free, other.tension.constants(), strict=True):
        least, _, high, largest = constant.bounds
        for z in WILD:  # the search may go beyond the bounds, the law may not
            assert least <= one.value(one.put(other, jnp.asarray(z))) <= largest
        usual = constant.transform.coordinate(high)
        assert_allclose(one.coordinate(one.put(other, jnp.asarray(usual))), usual, rtol=1e-12)


def test_a_fitted_constant_stays_within_its_bounds(monkeypatch):
    limited = tuple(
        dataclasses.replace(one, bounds=(0.01, 0.3, 1.0, 1.0)) for one in Meller2014.constants()
    )
    monkeypatch.setattr(Meller2014, "constants", lambda *_: limited)
    muscle = fs.Muscle(*SIZES, tension=Meller2014(1.0, 1.0))
    P, strain = np.linspace(1.5e5, 5e5, 4)[:, None], np.linspace(0.0, 0.12, 8)
    for factor, expected in ((1.3, 1.0), (0.5, 0.5)):  # the second one leaves its bound
        force = factor * muscle.force(P, strain)
        record = Record.of(P, strain, force, rest_length=SIZES[0])
        (fitted,) = fit(record, muscle, ["force_factor"], whole=False).parameters
        assert_allclose(fitted.value, expected, rtol=1e-3)
        assert fitted.value <= 1.0


def test_everything_moves_and_nothing_else():
    for one in PARAMETERS.values():
        moved = one.put(muscle, one.coordinate(muscle) + 0.1)
        changed = {
            other.name
            for other in PARAMETERS.values()
            if other is not one
            and not np.isclose(other.value(moved), other.value(muscle), 1e-12, 0)
        }
        follow = {"c10": {"youngs_modulus"}, "c01": {"youngs_modulus"}}
        assert changed == follow.get(one.name, set()), one.name
        assert not np.isclose(one.value(moved), one.value(muscle), rtol=1e-3, atol=0)

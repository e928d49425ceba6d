"""What muscles can be made of: refused, warned about, or taken without a word, at every door."""

import math
import warnings

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle.core.validation import RANGES, check_signed, check_size


SIX = {"length": 0.127, "outer_radius": 6.35e-3, "wall_thickness": 1.6e-3, "braid_angle": 0.576}


def muscle(**other):
    return fs.Muscle.from_dimensions(**(SIX | other))


@pytest.mark.parametrize("name", [*RANGES])
def test_every_range_is_in_order_and_names_what_it_refuses(name):
    known = RANGES[name]
    assert known.least <= known.low < known.high <= known.largest
    check = check_signed if known.least < 0 else check_size
    for value in (known.low, known.high, 0.5 * (known.low + known.high)):
        if value > 0:
            assert check(value, name) == value
    with pytest.raises(ValueError, match=rf"^`{name}` must lie in \[.*: check its unit\.$"):
        check(np.array([0.5 * (known.low + known.high), 2 * known.largest]), name)
    if known.largest > known.high:
        with pytest.warns(UserWarning, match=rf"^`{name}` of .* is unusual, most lie in \["):
            check(1.01 * known.high, name)


@pytest.mark.parametrize(
    "make",
    [
        lambda x: muscle(length=x),
        lambda x: muscle(outer_radius=x),
        lambda x: muscle(wall_thickness=x),
        lambda x: muscle(transition_rate=x),
        lambda x: fs.MooneyRivlin(x, 1e5),
        lambda x: fs.MooneyRivlin(1e5, x),
        lambda x: fs.MooneyRivlin(1e5, 1e5, x),
        fs.MooneyRivlin.from_youngs_modulus,
        lambda x: fs.Tuning(youngs_modulus_factor=x),
        lambda x: fs.Tuning(collapse_moment_factor=x),
        lambda x: fs.Tuning(hinge_stiffness_factor=x),
        lambda x: fs.Tuning(hinge_stiffness_slope=x),
        lambda x: fs.Tuning(transition_rate=x),
        lambda x: fs.Tuning([1e5], [x], [1.0]),
        lambda x: fs.Tuning([1e5], [0.0], [x]),
        lambda x: fs.MotorUnit(muscle(), int(x / 1e293)),
        lambda x: fs.design.Space({"m": muscle()}, (2,), length=(x,)),
        lambda x: fs.design.Space({"m": muscle()}, (2,), radius=(x,)),
        lambda x: fs.Bundle([fs.MotorUnit(muscle())], length=x),
    ],
)
def test_every_door_refuses_what_has_no_sense_of_scale(make):
    with pytest.raises(ValueError, match=r"must lie in .*, got|must be less than"):
        make(1e300)


@pytest.mark.parametrize(
    "values",
    [
        # De Volder, Moers and Reynaerts (2011); a thin one; Festo's longest; one that moves walls
        {"length": 22e-3, "outer_radius": 0.75e-3, "wall_thickness": 0.2e-3},
        {"length": 5e-3, "outer_radius": 0.25e-3, "wall_thickness": 0.05e-3},
        {"length": 9.0, "outer_radius": 10e-3, "wall_thickness": 2e-3},
        {"length": 3.0, "outer_radius": 0.1, "wall_thickness": 5e-3},
    ],
)
def test_muscles_that_exist_are_taken_without_a_word(values):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = muscle(**values)
    assert np.isfinite(made.force(2e5, 0.05))


def test_a_muscle_shorter_than_wide_is_unusual():
    with pytest.warns(UserWarning, match="is 1.57 times `outer_radius`"):
        muscle(length=0.01)


@pytest.mark.parametrize("degrees", [0.5, 1e-9])
def test_fibers_along_the_axis_are_refused_in_degrees(degrees):
    with pytest.raises(ValueError, match=r"`braid_angle` must lie in \[1, inf\] deg, got"):
        muscle(braid_angle=math.radians(degrees))


def test_traced_values_are_the_callers_affair():
    found = jax.jit(lambda x: muscle(length=x).force(1e5, 0.1))(1e6)
    assert np.isfinite(found)


@pytest.mark.parametrize("degrees", [1.0, 5.0, 11.5, 20.0, 33.0, 45.0, 54.0, 54.7])
@pytest.mark.parametrize("law", ["kim2021", "elastica"])
@pytest.mark.filterwarnings("ignore:`braid_angle` of")
def test_every_strain_that_is_taken_has_a_finite_force(degrees, law):
    """Down to the very end, where forces grow without bound as fibers become straight."""
    made = muscle(braid_angle=math.radians(degrees), buckling=law)
    straight = 1 - 1 / math.cos(float(made.braid_angle))
    pressures = np.array([0.0, 1e-300, 1.0, 2e5, 1e6])[:, None]
    for over in (1.0001e-9, 1e-8, 1e-4):
        found = made.response(pressures, np.array([straight + over]))
        for part in (found.force, found.mesh, found.bladder, found.bending):
            assert np.all(np.isfinite(part))
    for short in (5e-13, 1e-12, 0.0, -1e-12):
        with pytest.raises(ValueError, match=r"`strain` must lie in .*fibers straight"):
            made.force(2e5, straight + short)
        with pytest.raises(ValueError, match=r"`strain` must lie in"):
            fs.Bundle([fs.MotorUnit(made)]).force([2e5], straight + short)

"""Sizes of muscles: impossible ones are refused, unusual ones warn, wherever they enter."""

import math
import warnings

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle.core.validation import RANGES
from refusing import refuses, warns


SIZES = {"length": 0.127, "outer_radius": 6.35e-3, "wall_thickness": 1.6e-3, "braid_angle": 0.576}


def muscle(**changes):
    return fs.Muscle(**(SIZES | changes))


@pytest.mark.parametrize(
    "make",
    [
        *(lambda x, name=name: muscle(**{name: x})
          for name in ("length", "outer_radius", "wall_thickness", "transition_rate")),
        lambda x: fs.MooneyRivlin(x, 1e5), lambda x: fs.MooneyRivlin(1e5, x),
        lambda x: fs.MooneyRivlin(1e5, 1e5, x), fs.MooneyRivlin.from_youngs_modulus,
        *(lambda x, name=name: fs.Tuning(**{name: x})
          for name in ("youngs_modulus_factor", "collapse_moment_factor", "hinge_stiffness_factor",
                       "hinge_stiffness_slope", "transition_rate")),
        lambda x: fs.Tuning([1e5], [x], [1.0]), lambda x: fs.Tuning([1e5], [0.0], [x]),
        lambda x: fs.MotorUnit(muscle(), int(x / 1e293)),
        lambda x: fs.design.Space({"m": muscle()}, (2,), length=(x,)),
        lambda x: fs.design.Space({"m": muscle()}, (2,), radius=(x,)),
        lambda x: fs.Bundle([fs.MotorUnit(muscle())], length=x),
    ],
)  # fmt: skip
def test_impossible_sizes_are_refused_everywhere(make):
    with pytest.raises(fs.InvalidInputError):
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
def test_existing_muscles_do_not_warn(values):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isfinite(muscle(**values).force(2e5, 0.05))


def test_an_unusual_size_warns():
    with warns("outer_radius"):
        muscle(outer_radius=1.01 * RANGES["outer_radius"].high, length=5.0)
    with warns("1.57", "outer_radius"):
        muscle(length=0.01)


@pytest.mark.parametrize("degrees", [0.5, 1e-9])
def test_fibers_along_the_axis_are_refused(degrees):
    with pytest.raises(fs.InvalidInputError) as error:
        muscle(braid_angle=math.radians(degrees))
    assert error.value.argument == "braid_angle"


def test_traced_values_are_not_checked():
    assert np.isfinite(jax.jit(lambda x: muscle(length=x).force(1e5, 0.1))(1e6))


@pytest.mark.parametrize("degrees", [1.0, 11.5, 33.0, 54.0, 54.7])
@pytest.mark.parametrize("law", ["kim2021", "elastica"])
@pytest.mark.filterwarnings("ignore:`braid_angle` of")
def test_every_accepted_strain_has_a_finite_force(degrees, law):
    """Down to the very end, where forces grow without bound as fibers become straight."""
    steep = muscle(braid_angle=math.radians(degrees), buckling=law)
    straight = 1 - 1 / math.cos(float(steep.braid_angle))
    pressures = np.array([0.0, 1e-300, 1.0, 2e5, 1e6])[:, None]
    response = steep.response(pressures, straight + np.array([1.0001e-9, 1e-8, 1e-4]))
    for force in (response.force, response.mesh, response.bladder, response.bending):
        assert np.all(np.isfinite(force))
    for margin in (5e-13, 1e-12, 0.0, -1e-12):
        with refuses("strain"):
            steep.force(2e5, straight + margin)
        with refuses("strain"):
            fs.Bundle([fs.MotorUnit(steep)]).force([2e5], straight + margin)

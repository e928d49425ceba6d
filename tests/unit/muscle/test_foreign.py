"""A law that has another muscle's constants says so; one with its own doesn't."""

import warnings

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle.muscle.tension import TENSION_LAWS
from fascicle.muscle.validation import published_range_message


FESTO_20 = {"outer_radius": 11e-3, "wall_thickness": 1e-3, "braid_angle": np.radians(28.6)}
MADE = {name: law for name, law in TENSION_LAWS.items() if law.reference_muscle}


def of_its_size(law):
    """A muscle as wide and long as that of a `law`'s constants."""
    radius = 0.5 * law.reference_diameter + 1e-3
    return fs.Muscle(law.reference_length or 0.25, radius, 1e-3, np.radians(28.6))


@pytest.mark.parametrize("law", MADE.values(), ids=MADE)
def test_published_constants_warn_on_another_muscle_and_not_on_their_own(law):
    own = of_its_size(law)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not published_range_message(own.replace(tension=law.name))
    fitted = f"`{law.name}` was fitted to {law.reference_muscle}"
    with pytest.warns(UserWarning, match=fitted) as told:
        own.replace(tension=law.name, outer_radius=2 * own.outer_radius, wall_thickness=1e-3)
    wide = f"{2e3 * law.reference_diameter + 4:g} mm in diameter"
    assert f"this muscle is {wide}" in str(told[0].message)


@pytest.mark.parametrize("law", [law for law in MADE.values() if law.reference_length], ids=str)
def test_another_length_is_told_with_it(law):
    with pytest.warns(UserWarning, match="this muscle is 100 mm long"):
        of_its_size(law).replace(tension=law.name, length=0.1)


@pytest.mark.parametrize(("length", "told"), [(0.21, False), (0.23, True)])
def test_a_tenth_of_a_size_is_what_names_leave_open(length, told):
    muscle = fs.Muscle(length, **FESTO_20)
    assert bool(published_range_message(muscle, TENSION_LAWS["sarosi"])) is told


def test_fitted_constants_are_the_muscles_own():
    law = fs.tension.Sarosi(exponent=-0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fs.Muscle(0.127, 6.35e-3, 1.6e-3, np.radians(33), tension=law)


def test_laws_of_any_muscle_and_traced_sizes_say_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in TENSION_LAWS.keys() - MADE.keys():
            assert not published_range_message(
                fs.Muscle(0.127, 6.35e-3, 1.6e-3, 0.5), TENSION_LAWS[name]
            )
        own = fs.Muscle(0.2, **FESTO_20, tension="sarosi")
        jax.jit(lambda length: own.replace(length=length).force(1e5, 0.1))(0.4)

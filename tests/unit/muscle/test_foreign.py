"""A law that has another muscle's constants says so; one with its own doesn't."""

import warnings

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle.muscle.tension import TENSION_LAWS
from refusing import warns


FESTO_20 = {"outer_radius": 11e-3, "wall_thickness": 1e-3, "braid_angle": np.radians(28.6)}
MADE = {name: law for name, law in TENSION_LAWS.items() if law.reference_muscle}


@pytest.mark.parametrize("law", MADE.values(), ids=MADE)
def test_published_constants_warn_on_another_muscle_and_not_on_their_own(law):
    radius = 0.5 * law.reference_diameter + 1e-3
    own = fs.Muscle(law.reference_length or 0.25, radius, 1e-3, np.radians(28.6))
    others = [{"outer_radius": 2 * radius, "wall_thickness": 1e-3}]
    others += [{"length": 0.1}] if law.reference_length else []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        own.replace(tension=law.name)
    for sizes in others:
        with warns(law.name):
            own.replace(tension=law.name, **sizes)


def test_fitted_constants_any_muscles_laws_and_traced_sizes_do_not_warn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fs.Muscle(0.127, 6.35e-3, 1.6e-3, np.radians(33), tension=fs.tension.Sarosi(exponent=-0.3))
        for name in TENSION_LAWS.keys() - MADE.keys():
            fs.Muscle(0.127, 6.35e-3, 1.6e-3, 0.5, tension=name)
        own = fs.Muscle(0.21, **FESTO_20, tension="sarosi")  # within a tenth of its own length
        jax.jit(lambda length: own.replace(length=length).force(1e5, 0.1))(0.4)

"""Slopes stand beside forces in closed form: each is held to differences of its force."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.laws import LAWS
from fascicle.muscle.materials import MooneyRivlin


SIX = fs.example("kim2021_figure_6")
PRESSURES = np.array([0.0, 34.5e3, 137.9e3, 344.7e3])[:, None]
STRAIN = np.linspace(-0.05, 0.5, 90) + 1e-4 * np.sin(np.arange(90))  # on no corner
STEP = 1e-6


def agree(muscle, regions):
    """Stiffness against central differences, wherever no corner lies between."""
    here = muscle.response(PRESSURES, STRAIN).region
    low, high = muscle.response(PRESSURES, STRAIN - STEP), muscle.response(PRESSURES, STRAIN + STEP)
    smooth = (low.region == here) & (high.region == here)
    assert set(np.unique(here[smooth])) >= set(regions)
    slope = -(high.force - low.force) / (2 * STEP * muscle.length)
    stiffness = muscle.stiffness(PRESSURES, STRAIN)
    # differences err by rounding of the parts, 1e-13 of some 100 N over the step and length, 1e-4
    # N/m, and by a third of the step's square of the third derivative
    assert_allclose(stiffness[smooth], slope[smooth], rtol=2e-5, atol=5e-3)


@pytest.mark.parametrize(("kind", "name"), [(kind, law) for kind in LAWS for law in LAWS[kind]])
def test_the_stiffness_is_the_forces_slope(kind, name):
    agree(SIX.replace(**{kind: name}), {0, 2})


def test_also_of_a_muscle_that_is_tuned_and_stiff():
    tuning = fs.Tuning(
        [5e4, 4e5], [0.2, 1.0], [1.1, 0.9], youngs_modulus_factor=1.2, collapse_moment_factor=0.7,
        hinge_stiffness_factor=0.8, hinge_stiffness_slope=1e-6, transition_rate=60.0,
    )  # fmt: skip
    material = MooneyRivlin(90e3, 70e3, 1.1e6, 0.4)
    agree(SIX.replace(tuning=tuning, material=material), {0, 2})

import jax.numpy as jnp
import numpy as np
from numpy.testing import assert_allclose

import fascicle as fs


muscle = fs.Muscle.from_dimensions(
    0.127, 6.35e-3, 1.6e-3, np.radians(33), tuning=fs.Tuning(youngs_modulus_factor=1.25)
)


def test_column_has_the_muscles_stiffness():
    column = muscle.law.at(jnp.asarray(1e5)).column
    E = 1.25 * 6 * (118.4e3 + 105.7e3)
    assert_allclose(column.bending_stiffness, E * np.pi / 4 * (6.35e-3**4 - 4.75e-3**4), rtol=1e-14)
    assert_allclose(column.axial_stiffness, E * np.pi * (6.35e-3**2 - 4.75e-3**2), rtol=1e-14)
    assert column.rest_length == 0.127
    assert_allclose(column.free_strain, muscle.free_strain(1e5), rtol=1e-15)
    assert_allclose(column.free_length, 0.127 * (1 - muscle.free_strain(1e5)), rtol=1e-15)

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

import fascicle as fs
from fascicle.bundle.energetics import unit_work_along


thin = fs.example("kim2021_figure_6")
LEVELS = np.array([0.0, 1e4, 2e5])
STRAINS = np.array([0.3, 0.01, 0.19, -0.05])


@pytest.mark.parametrize("resistance", [True, False])
def test_works_along_a_path_are_areas_under_the_curve(resistance):
    bundle = fs.Bundle([fs.MotorUnit(thin, 2)])
    result = unit_work_along(bundle, LEVELS[:, None], STRAINS, resistance)
    assert result.shape == (3, 4, 1)
    for i, P in enumerate(LEVELS):
        kinks = [float(thin.free_strain(P)), float(thin.collapse_strain(P))]

        def pull(eps, P=P, end=kinks[0]):
            return float(thin.force(P, eps)) if resistance or eps <= end else 0.0

        for j, eps in enumerate(STRAINS):
            stops = [0.0, *(k for k in sorted(kinks) if 0 < k < eps), eps]
            parts = [
                quad(pull, a, b, epsabs=1e-14, epsrel=1e-12, limit=200)[0]
                for a, b in pairwise(stops)
            ]
            # 1e-12 of some 5 J; the module promises 1e-13 of a piece
            assert_allclose(result[i, j, 0], 2 * 0.127 * sum(parts), rtol=0, atol=5e-12)


def test_units_of_unequal_length_have_strains_of_their_own():
    short = fs.Muscle(0.12, 6.35e-3, 1.6e-3, 0.576, "silicone_kim2021")
    bundle = fs.Bundle([fs.MotorUnit(thin), fs.MotorUnit(short, 2)], length=0.125)
    P = np.array([[1e5, 2e5], [0.0, 3e5]])
    whole = fs.energetics.unit_work(bundle, P[:, None, :], STRAINS)
    assert_allclose(unit_work_along(bundle, P, STRAINS, True), whole, rtol=0, atol=1e-8)

"""Single points by CasADi: the library's force and its slopes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs


pytest.importorskip("casadi")
random = np.random.default_rng(0)


@pytest.mark.parametrize("buckling", ["kim2021", "elastica"])
def test_a_muscle_function_equals_the_muscle(buckling):
    muscle = fs.example("kim2021_figure_6").replace(buckling=buckling)
    force = muscle.compile(backend="casadi")
    pressure, strain = random.uniform(1e3, 4e5, 40), random.uniform(-0.02, 0.35, 40)
    result = [force(P, eps) for P, eps in zip(pressure, strain, strict=True)]
    assert_allclose(result, muscle.force(pressure, strain), rtol=1e-10, atol=1e-10)
    F, by_pressure, by_strain = force.with_slopes(2e5, 0.1)
    h = 1.0  # Pa: a millionth of the domain, where differences are good to 1e-9
    assert force(2e5, 0.1) == F
    ahead, behind = muscle.force(2e5 + h, 0.1), muscle.force(2e5 - h, 0.1)
    assert_allclose(by_pressure, [(ahead - behind) / (2 * h)], rtol=1e-7)
    assert_allclose(by_strain, -muscle.stiffness(2e5, 0.1) * muscle.length, rtol=1e-10)


@pytest.mark.parametrize("length", [None, 0.13])
def test_a_bundle_function_equals_the_bundle(length):
    bundle = fs.example("kim2021_bundle_1_4")
    if length is not None:
        bundle = fs.Bundle(bundle.motor_units, length=length)
    force = bundle.compile(backend="casadi")
    pressures, strain = random.uniform(1e3, 4e5, (20, 2)), random.uniform(0.03, 0.3, 20)
    result = [force(P, eps) for P, eps in zip(pressures, strain, strict=True)]
    assert_allclose(result, bundle.force(pressures, strain), rtol=1e-10, atol=1e-9)
    _, by_pressures, by_strain = force.with_slopes([2e5, 1e5], 0.1)
    for i, step in enumerate(np.eye(2)):
        ahead, behind = (bundle.force([2e5, 1e5] + s * step, 0.1) for s in (1.0, -1.0))
        assert_allclose(by_pressures[i], (ahead - behind) / 2, rtol=1e-7)
    h = 1e-6  # far above rounding of a strain, and far below where a force bends
    slope = (bundle.force([2e5, 1e5], 0.1 + h) - bundle.force([2e5, 1e5], 0.1 - h)) / (2 * h)
    assert_allclose(by_strain, slope, rtol=1e-6)


def test_an_unknown_backend_is_refused():
    with pytest.raises(fs.InvalidInputError) as caught:
        fs.example("kim2021_figure_6").compile(backend="numba")
    assert caught.value.argument == "backend"

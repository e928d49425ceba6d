"""Hanging masses and free contraction: loads are set, contractions are read. Synthetic records."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import least_squares
from scipy.stats import t as student

import fascicle as fs
from fascicle.calibrate import fit, select_model
from fascicle.calibrate.findings import calibration_findings, judge
from fascicle.calibrate.readings import invert_force
from fascicle.records.record import Record


L, WALL = 0.07, 2e-3
TRUE = fs.Muscle(L, 9e-3, WALL, np.radians(25), "latex")
NOMINAL = fs.Muscle(L, 9.5e-3, WALL, np.radians(27), "latex")
SIZES = ["braid_angle", "outer_radius"]
PRESSURES = np.arange(1e5, 6.1e5, 0.5e5)


def hanging(loads, seed=0, noise=0.2e-3):
    """Contractions under `loads` [N], three times at each pressure, with `noise` [m]."""
    P, F = (x.ravel() for x in np.meshgrid(np.repeat(PRESSURES, 3), loads))
    strain = invert_force(TRUE, P, F)
    strain = strain + noise / L * np.random.default_rng(seed).normal(size=P.size)
    return Record.of(P, strain, F, rest_length=L, synthetic=True)


@pytest.mark.parametrize("loads", [(0.0,), (0.0, 25.0), (5.0, 10.0, 20.0, 40.0)])
def test_contractions_are_fitted_as_scipy_fits_them(loads):
    record = hanging(loads)

    def errors(x):
        sizes = L, x[1] * 1e-3, WALL, np.radians(x[0])
        muscle = fs.Muscle(*sizes, "latex")
        return 1e3 * L * (invert_force(muscle, record.pressure, record.force) - record.strain)

    expected = least_squares(errors, [27.0, 9.5])
    fitted = fit(record, NOMINAL, SIZES, whole=False)
    angle, radius = fitted.parameters
    assert_allclose([np.degrees(angle.value), 1e3 * radius.value], expected.x, rtol=1e-4)
    # millimeters, and the noise with the degrees of freedom of two constants
    assert_allclose(1e3 * fitted.contraction_rmse, np.sqrt(np.mean(expected.fun**2)), rtol=1e-3)
    inverse = np.linalg.inv(expected.jac.T @ expected.jac)
    deviation = np.sqrt(np.diag(inverse) * 2 * expected.cost / (expected.fun.size - 2))
    widths = [np.degrees(angle.high - angle.low), 1e3 * (radius.high - radius.low)]
    quantile = student.ppf(0.95, expected.fun.size - 2)
    assert_allclose(widths, 2 * quantile * deviation, rtol=0.02)


@pytest.mark.parametrize("noise", [0.1e-3, 0.4e-3])
def test_intervals_hold_the_truth(noise):
    inside = []
    for seed in range(20):
        fitted = fit(hanging((0.0, 25.0), seed, noise), NOMINAL, SIZES, starts=1, whole=False)
        angle, radius = fitted.parameters
        inside += [angle.low < np.radians(25) < angle.high, radius.low < 9e-3 < radius.high]
    # 90 % of 20 records, whose two constants are nearly one: three deviations
    assert 0.7 <= np.mean(inside) <= 1


def test_the_plain_selection_judges_contractions():
    choice = select_model(hanging((0.0, 25.0)), NOMINAL, starts=1, given_laws=["material"])
    verdict = judge(choice.calibration, choice)
    assert set(choice.calibration.names) == set(SIZES)
    assert verdict.fit == "noise" and verdict.contraction_rmse == pytest.approx(0.2e-3, rel=0.2)


def test_forces_of_a_sweep_are_no_set_loads():
    strain = np.linspace(0, 0.2, 40)
    force = np.round(np.asarray(TRUE.force(PRESSURES[:, None], strain)), 0)
    record = Record.of(PRESSURES[:, None], strain, force, rest_length=L)
    assert not fit(record, NOMINAL, SIZES, starts=1).fit_data.reads_contraction


def test_cycles_of_free_contraction_are_fitted():
    P = np.tile(np.concatenate([PRESSURES, PRESSURES[-2::-1]]), 4)
    noise = 0.1e-3 / L * np.random.default_rng(1).normal(size=P.size)
    strain = invert_force(TRUE, P, 0 * P) + noise
    branch = np.tile(np.repeat([1, -1], [PRESSURES.size, PRESSURES.size - 1]), 4)
    record = Record.of(P, strain, 0 * P, branch=branch, time=1.0 * np.arange(P.size), rest_length=L)
    choice = select_model(record, NOMINAL, starts=1, given_laws=["material"])
    assert choice.calibration.muscle.braid_angle == pytest.approx(np.radians(25), rel=0.01)
    # the given rubber is what scales the force; a free one leaves the radius as it was given
    assert "outer_radius" in choice.calibration.names
    choice = select_model(record, NOMINAL, starts=1)
    assert "outer_radius" not in choice.calibration.names
    codes = [finding.code for finding in calibration_findings(choice.calibration)]
    assert "use.no_force" in codes

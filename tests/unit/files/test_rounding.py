"""A calibrated muscle's file is the muscle that was fitted, rounded far below its uncertainty."""

import numpy as np
import pytest

import fascicle as fs
from fascicle.calibrate import fit
from fascicle.files import dumps, loads
from fascicle.files.calibration_files import calibrated_text, rounded_muscle
from fascicle.records import Record
from fascicle.report.calibration_figures import curves_csv
from refusing import refuses, warns


P, EPS = np.linspace(1e5, 4e5, 4), np.linspace(0, 0.12, 12)


def calibration(noise):
    # synthetic: a muscle a little thicker and steeper than the one that is fitted to it
    start = fs.Muscle(0.2, 10e-3, 1.7e-3, np.radians(27), "latex")
    built = start.replace(outer_radius=10.4e-3, braid_angle=np.radians(27.777))
    force = np.asarray(built.force(P[:, None], EPS))
    force = force + noise * np.random.default_rng(3).normal(size=force.shape)
    record = Record.of(P[:, None], EPS, force, synthetic=True)
    return start, fit(record, start, ["outer_radius", "braid_angle"], whole=False)


@pytest.fixture(scope="module")
def noisy():
    return calibration(2.0)


def text_of(fitted):
    return calibrated_text(fitted, "2026-01-02")


def test_file_reads_back_within_the_uncertainty(noisy, tmp_path):
    _, fitted = noisy
    path = tmp_path / "m.toml"
    path.write_text(text_of(fitted), encoding="utf-8")
    read = fs.load(path)
    for one, value in zip(fitted.parameters, (read.braid_angle, read.outer_radius), strict=True):
        assert one.name in ("braid_angle", "outer_radius")
        assert abs(float(value) - one.value) <= 0.01 * (one.high - one.low)
    off = np.abs(read.force(P[:, None], EPS) - fitted.muscle.force(P[:, None], EPS)).max()
    assert 0 < off <= 0.01 * fitted.rmse


def test_file_has_the_fitted_length(noisy, tmp_path):
    text = text_of(noisy[1])
    assert loads(text).replace(wall_thickness=1.6e-3).length == 0.2
    with warns("200 mm", "300 mm"):
        loads(text).replace(length=0.3)
    # whoever writes another length into the file is told as it is read
    with warns("200 mm", "100 mm"):
        loads(text.replace('length = "200 mm"', 'length = "100 mm"', 1))
    # and who saves it again keeps it, also as a bundle of such muscles
    for again in (loads(text), fs.Bundle([fs.MotorUnit(loads(text))])):
        with warns("200 mm", "100 mm"):
            loads(dumps(again).replace('length = "200 mm"', 'length = "100 mm"', 1))
    with refuses("calibration.fitted_length"):
        loads(text.replace('fitted_length = "200 mm"', 'fitted_length = "long"'), "m.toml")


def test_unfitted_constants_stay_unchanged(noisy):
    start, fitted = noisy
    rounded = rounded_muscle(fitted.muscle)
    assert rounded.wall_thickness == start.wall_thickness
    assert rounded.length == start.length
    assert rounded.material == start.material


@pytest.mark.parametrize("pushes", [False, True])
def test_a_fit_of_strains_of_the_wrong_sign_has_files(pushes):
    # synthetic: fitted fibers would be straight where the record says that it was stretched
    muscle = fs.Muscle(0.2, 8e-3, 1e-3, np.radians(25), "latex")
    strain = np.append(np.linspace(0, 0.24, 30), np.linspace(0.24, 0, 30))
    pressure, branch = np.array([[1e5], [2e5], [3e5]]), np.tile([1] * 30 + [-1] * 30, (3, 1))
    force = np.asarray(muscle.force(pressure, strain)) - 30.0 * pushes
    noise = np.random.default_rng(0).normal(0, 1, force.shape)
    record = Record.of(pressure, -strain, force + noise, branch=branch, rest_length=0.2)
    fitted = fit(record, muscle, ["c10", "braid_angle", "outer_radius"], whole=pushes)
    low = 1 - 1 / np.cos(float(fitted.muscle.braid_angle))
    assert np.min(record.strain) < low  # off the domain of the fitted muscle
    assert "length" in calibrated_text(fitted, "2026-01-02")
    assert "nan" not in curves_csv(fitted)
    assert np.isfinite(fitted.half_way_rmse)

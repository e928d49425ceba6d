"""The page of a calibration, and the provenance that is saved with its muscle."""

import re

import numpy as np
import pytest

import fascicle as fs
from fascicle import units
from fascicle.calibrate.calibration import Calibration, Profile
from fascicle.calibrate.comparison import LawComparison, Row
from fascicle.calibrate.data import select_fit_data
from fascicle.calibrate.diagnostics import Diagnosis
from fascicle.calibrate.least_squares import Linearization, Minimum, Problem, SearchEnds
from fascicle.calibrate.parameters import coordinates, select_parameters
from fascicle.calibrate.posterior import Posterior
from fascicle.files import provenance
from fascicle.files.calibration_files import provenance_of
from fascicle.records import Record, Source
from fascicle.report.calibration import CalibrationResult, report
from fascicle.report.calibration_figures import figures, fit_plot


DATE = "2026-05-04"
SHA = "0123456789abcdef" * 4


def calibration(**changes):
    """A calibration by hand: no fit is needed to describe one."""
    muscle = fs.example("kim2021_slenderness_10")
    P, eps = np.array([100e3, 200e3, 300e3]), np.linspace(0, 0.2, 6)
    force = np.asarray(muscle.force(P[:, None], eps))
    record = Record.of(
        P[:, None], eps, np.maximum(force, 0), censored=force < 0, rest_length=0.127,
        synthetic=True, sources=(Source("a <b>.csv", SHA),), notes=("column `F` read as force",),
    )  # fmt: skip
    free = select_parameters(["c10", "outer_radius"], muscle)
    of = select_fit_data(record)
    data, center = of.grid, np.asarray(coordinates(free, muscle))
    problem = Problem(
        muscle, data, np.ones(data.force.shape), 0.5, center, np.full(2, 3.0), free, 0.127,
    )  # fmt: skip
    # the first is known to 5 %, the second no better than its prior
    covariance = np.array([[0.05**2, 0.0], [0.0, 2.99**2]])
    none = np.zeros(data.force.shape)
    place = Linearization(
        np.zeros(none.size + 2), np.zeros((none.size + 2, 2)), force, np.zeros((*none.shape, 2)),
        none,
    )  # fmt: skip
    minimum = Minimum(covariance, np.zeros((2, 2)), 0.5, 0.5, place)
    solutions = SearchEnds(
        np.stack([center, center]), np.array([1.0, 2.0]), np.array([0, 1]), np.array([7, 100])
    )
    fit = {
        "muscle": muscle, "start": muscle, "fit_data": of,
        "problem": problem, "coordinates": center, "readings": None, "minimum": minimum,
        "free_strain": np.array([0.1, 0.2, 0.3]), "solutions": solutions,
        "diagnosis": Diagnosis(),
    }  # fmt: skip
    return Calibration(**{**fit, **changes})


@pytest.fixture(scope="module")
def fit():
    return calibration()


@pytest.fixture(scope="module")
def profiles(fit):
    x = np.linspace(-3, 3, 11)
    return tuple(
        Profile(entry.name, entry.value * np.exp(entry.deviation * x), x**2, low, np.inf)
        for entry, low in zip(fit.parameters, (80e3, -np.inf), strict=True)
    )


@pytest.fixture(scope="module")
def plots(fit, profiles):
    return figures(fit, profiles)


@pytest.fixture(scope="module")
def page(fit, profiles, plots):
    rows = [Row("a <law>", 2, 1.25, np.nan, 0.01, np.nan, 0.0, 3.5, "converged")]
    posterior = Posterior(
        fit.names, np.tile([[90e3, 6e-3]], (10, 1)), np.tile(fit.coordinates, (10, 1)),
        np.zeros((10, 0)), np.full(10, 0.5), np.array([1.0, 1.25]), np.array([999.0, 12.0]), 3,
    )  # fmt: skip
    html = report(
        CalibrationResult(fit, None, profiles, posterior, LawComparison(rows, {})), DATE, plots
    )
    return re.sub(r">\s+<", "><", html)


def test_the_page_names_what_was_fitted_and_how(page, fit):
    assert "a &lt;b&gt;.csv" in page and SHA in page and "a &lt;law&gt;" in page
    assert f"{fit.points} readings at 3 pressures from 100 to 300 kPa" in page
    undetermined = page[page.index('id="undetermined"') : page.index('id="parameters"')]
    assert "outer_radius" in undetermined and "c10" not in undetermined


def test_nothing_is_asked_for_from_outside(page):
    addresses = re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', page)
    assert sum(address.startswith("data:image/svg+xml") for address in addresses) == 3
    assert all(address.startswith(("data:", "#")) for address in addresses)


def test_only_the_date_changes_the_page(fit, profiles, plots):
    first, again, later = (
        report(CalibrationResult(fit, None, profiles), date, plots)
        for date in (DATE, DATE, "2027-01-01")
    )
    assert first == again
    assert first.replace(DATE, "2027-01-01") == later


def test_curves_are_those_of_the_fitted_muscle(fit, plots):
    assert set(plots) == {"fit", "residuals", "profiles"}
    fitted = fit_plot(fit)
    # each curve ends where its readings do
    np.testing.assert_array_equal(fitted.curve_strain[:, [0, -1]], [[0, 0.2]] * 3)
    np.testing.assert_allclose(
        fitted.curve_force[0], fit.muscle.force(100e3, fitted.curve_strain[0]), rtol=1e-9
    )


def test_provenance_is_read_back_as_it_was_saved(fit, tmp_path):
    path = tmp_path / "muscle.toml"
    fs.save(fit.muscle, path, calibration=provenance_of(fit, DATE))
    assert float(fs.load(path).outer_radius) == float(fit.muscle.outer_radius)
    saved = provenance(path)
    assert saved == provenance_of(fit, DATE)
    assert saved["record"] == [{"file": "a <b>.csv", "sha256": SHA}]
    assert [entry["identifiable"] for entry in saved["parameter"]] == [True, False]
    assert saved["rmse"] == units.pretty(fit.rmse, "force", 4)

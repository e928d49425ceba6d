"""Curves and factors in one fit."""

import numpy as np
import pytest

import fascicle as fs
from fascicle.calibrate import fit
from fascicle.calibrate.readings import SmoothCurves
from fascicle.muscle.tuning import Tuning
from fascicle.records import VirtualDynamometer
from fascicle.records.record import Record


TRUE = fs.example("kim2021_slenderness_10")
DRAWN = fs.Muscle(
    TRUE.length, TRUE.outer_radius, TRUE.wall_thickness, TRUE.braid_angle, material=TRUE.material
)
MACHINE = VirtualDynamometer(
    pressures=[0.0, 82.7e3, 165.5e3, 248.2e3, 344.7e3], samples=60, both_ways=False
)


@pytest.mark.parametrize("quotient", [(0.94, 0.1, 0.0, 0.0), (0.9, 0.3, -0.18, 0.0)])
def test_no_order_is_chosen(quotient):
    # a synthetic truth whose free strain is the law's times a polynomial of this order
    rows = np.linspace(2e4, 344.7e3, 300)
    line = [0.0, float(TRUE.blocked_force(344.7e3))]
    c1, c2 = SmoothCurves(DRAWN, rows, 344.7e3).corrections(np.array([*quotient, *line]))
    truth = DRAWN.replace(tuning=Tuning(rows, c1, c2, collapse_moment_factor=0.75))
    made = fit(MACHINE.record(truth, seed=2), DRAWN)
    share = np.array([0.25, 0.5, 0.75, 1.0])
    powers = share[:, None] ** np.arange(4)
    found, C = made.readings.coefficients[:4], made.readings.covariance[:4, :4]
    away = powers @ (found - np.array(quotient))
    spread = np.sqrt(np.einsum("li,ij,lj->l", powers, C, powers))
    assert np.all(np.abs(away) < 4 * spread) and np.all(spread < 0.02)


def test_where_the_law_misses_the_pull_readings_stay_as_read():
    P, eps = np.linspace(1e5, 4e5, 5)[:, None], np.linspace(0, 0.3, 30)
    force = np.asarray(DRAWN.force(P, eps)) + 20 * np.sin(14 * eps)  # no law's
    noise = 0.2 * np.random.default_rng(0).normal(size=force.shape)
    made = fit(Record.of(P, eps, force + noise, rest_length=0.127), DRAWN)
    assert made.readings.pulling is None

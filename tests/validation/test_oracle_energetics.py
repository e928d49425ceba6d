"""The library's average efficiencies against the oracle's, and both against the spec."""

import math
from functools import cache

import oracle_energetics as oracle
import pytest
from from_oracle import library_bundle
from oracle_muscle import TABLE, Muscle

import fascicle as fs


SUPPLY = 413.7e3
SPEC = {"isobaric": (0.517, 0.622, 0.680), "isotonic": (0.360, 0.446, 0.495)}


def family(n):
    """n motor units of one muscle in the cross-section of two of 9 mm radius."""
    radius = 9e-3 * math.sqrt(2 / n)
    return ((Muscle(outer_radius=radius, wall_thickness=radius / 4, material=TABLE), 1),) * n


@cache
def expected(n, path, resistance, scheme="orderly"):
    # 104 pressures: against 415 of them the averages move by 1e-6
    return oracle.average_efficiency(family(n), SUPPLY, path, resistance, scheme, nodes=104)[0]


@pytest.mark.parametrize("path", SPEC)
@pytest.mark.parametrize("n", [1, 2, pytest.param(3, marks=pytest.mark.slow)])
def test_oracle_gives_the_published_averages(n, path):
    assert expected(n, path, True) == pytest.approx(SPEC[path][n - 1], rel=0, abs=5.01e-4)


@pytest.mark.parametrize("path", SPEC)
@pytest.mark.parametrize("n", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_oracle_says_resistance_costs_under_2_percent(n, path):
    assert 0.98 < expected(n, path, True) / expected(n, path, False) < 1


@pytest.mark.parametrize(
    ("n", "path", "resistance", "scheme"),
    [
        (1, "isobaric", True, "orderly"),
        (1, "isotonic", True, "orderly"),
        (2, "isobaric", True, "orderly"),
        (2, "isobaric", True, "batch"),
        (2, "isotonic", False, "orderly"),
        pytest.param(2, "isobaric", False, "orderly", marks=pytest.mark.slow),
        pytest.param(2, "isotonic", True, "orderly", marks=pytest.mark.slow),
        pytest.param(2, "isotonic", True, "batch", marks=pytest.mark.slow),
        pytest.param(3, "isobaric", True, "orderly", marks=pytest.mark.slow),
        pytest.param(3, "isotonic", True, "orderly", marks=pytest.mark.slow),
    ],
)
def test_library_agrees(n, path, resistance, scheme):
    got = fs.energetics.average_efficiency(
        library_bundle(family(n)), SUPPLY, path=path, resistance=resistance, scheme=scheme
    )
    # a grid point at the edge, in for one and out for the other, moves the mean of some
    # 3300 points by up to 2e-4; interpolation in tables by 1e-5
    assert float(got) == pytest.approx(expected(n, path, resistance, scheme), rel=0, abs=2e-4)

"""The published and the independently computed numbers, asked of the library.

A number printed to so many digits is matched to half a unit of its last one: that is all
that it says.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from from_oracle import library_bundle, library_muscle
from oracle_muscle import LATEX, SILICONE, TABLE, Muscle, Tuning


FIGURE_6 = Muscle(material=TABLE)  # latex constants, but E 1.78 MPa
SILICONE_6 = replace(FIGURE_6, material=SILICONE)
FIGURE_9 = Muscle(outer_radius=9e-3, wall_thickness=2.25e-3)
BAR = 1e5
SLENDERNESS_8 = replace(
    SILICONE_6,
    length=0.102,
    tuning=Tuning(
        youngs_modulus_factor=1.25,
        collapse_moment_factor=1.1,
        hinge_stiffness_factor=1.25,
        hinge_stiffness_slope=0.87 / BAR,
        transition_rate=100.0,
    ),
)


def printed(value, digits):
    """Half a unit of the last digit printed (a hair more, for a tie rounded either way)."""
    return pytest.approx(value, rel=0, abs=0.501 * 10.0**-digits)


class LibraryBundle:
    """The library's bundle, its padded equilibria as pairs."""

    def __init__(self, units):
        self.bundle = library_bundle(units)

    def free_strain(self, pressures):
        return float(self.bundle.free_strain(np.array(pressures)))

    def equilibria(self, pressures):
        found = self.bundle.equilibria(np.array(pressures))
        pairs = zip(np.asarray(found.strain), np.asarray(found.stable), strict=True)
        return [(float(e), bool(s)) for e, s in pairs if not np.isnan(e)]


# P kPa: free strain, collapse strain, collapse moment, forces at strains 0, 0.03 ... 0.33
TABLE_ROWS = {
    0.0: (
        0,
        0.0674,
        0.0330,
        [0, -1.77, -2.71, -2.07, -1.47, -1.20, -1.09, -1.08, -1.12, -1.19, -1.30, -1.44],
    ),
    34.5: (
        0.0459,
        0.1173,
        0.0366,
        [16.36, 4.56, -1.74, -3.83, -4.91, -2.85, -1.88, -1.45, -1.28, -1.25, -1.31, -1.41],
    ),
    137.9: (
        0.1664,
        0.2427,
        0.0457,
        [65.37, 48.07, 34.75, 23.67, 13.89, 4.81, -3.47, -8.18, -11.76, -6.71, -3.84, -2.54],
    ),
}


@pytest.mark.parametrize("kilopascal", TABLE_ROWS)
def test_figure_6_table(kilopascal):
    muscle, P = library_muscle(FIGURE_6), kilopascal * 1e3
    free, collapse, moment, forces = TABLE_ROWS[kilopascal]
    assert float(muscle.free_strain(P)) == printed(free, 4)
    assert float(muscle.collapse_strain(P)) == printed(collapse, 4)
    assert float(muscle.collapse_moment(P)) == printed(moment, 4)
    strains = np.arange(12) * 0.03
    assert list(np.asarray(muscle.force(P, strains))) == [printed(F, 2) for F in forces]


@pytest.mark.parametrize(
    ("kilopascal", "free", "collapse"),
    [(34.5, 0.0634, 0.1326), (137.9, 0.1920, 0.2645), (344.7, 0.2515, 0.3423)],
)
def test_silicone_strains(kilopascal, free, collapse):
    muscle = library_muscle(SILICONE_6)
    assert float(muscle.free_strain(kilopascal * 1e3)) == printed(free, 4)
    assert float(muscle.collapse_strain(kilopascal * 1e3)) == printed(collapse, 4)


@pytest.mark.parametrize(("material", "free"), [(LATEX, 0.223), (SILICONE, 0.240)])
def test_figure_9_free_strain(material, free):
    muscle = library_muscle(replace(FIGURE_9, material=material))
    assert float(muscle.free_strain(275.8e3)) == printed(free, 3)


def test_which_bladder_collapses_within_the_tested_range():
    # 0.75 times latex (the silicone, to rounding) doesn't at 137.9 kPa; latex does
    silicone, latex = library_muscle(SILICONE_6), library_muscle(FIGURE_6)
    assert float(silicone.free_strain(413.7e3)) == printed(0.2598, 4)
    assert float(latex.free_strain(413.7e3)) == printed(0.2462, 4)
    assert float(latex.collapse_strain(137.9e3)) < float(latex.free_strain(413.7e3))
    assert float(silicone.collapse_strain(137.9e3)) > float(silicone.free_strain(413.7e3))


def test_fifth_pressure_of_table_1_misses_collapse_by_little():
    # the reason for taking (17) as printed: four of five pressures collapse in range
    muscle = library_muscle(SLENDERNESS_8)
    limit = float(muscle.free_strain(413.7e3))
    for kilopascal in (0.0, 34.5, 68.9, 103.4):
        assert float(muscle.collapse_strain(kilopascal * 1e3)) < limit
    assert float(muscle.collapse_strain(137.9e3)) - limit == printed(0.0007, 4)


# P kPa: (force, moment) at strains 0.03, 0.12, 0.24
ELASTICA_ROWS = {
    0.0: [(-3.9067, 0.02002), (-4.0951, 0.05200), (-4.3806, 0.07781)],
    34.5: [(7.0478, 0.0), (-4.5622, 0.02955), (-4.8880, 0.06943)],
    137.9: [(50.5601, 0.0), (19.7488, 0.0), (-6.1192, 0.03493)],
}


@pytest.mark.parametrize("kilopascal", ELASTICA_ROWS)
def test_elastica_table(kilopascal):
    # a factor on the collapse moment puts collapse out of the way
    never = replace(SILICONE_6, buckling="elastica", collapse_factor=1e6)
    muscle, P = library_muscle(never), kilopascal * 1e3
    strains = np.array([0.03, 0.12, 0.24])
    forces = np.asarray(muscle.force(P, strains))
    for strain, force, (F, M) in zip(strains, forces, ELASTICA_ROWS[kilopascal], strict=True):
        assert force == printed(F, 4)
        if strain > float(muscle.free_strain(P)):
            assert float(muscle.moment(P, float(strain))) == printed(M, 5)


@pytest.mark.parametrize(
    ("second", "strain"), [(0.0, 0.2343), (103.4, 0.2230), (137.9, 0.2201), (344.7, 0.2362)]
)
def test_bundle_of_two(second, strain):
    bundle = LibraryBundle(((FIGURE_6, 1), (FIGURE_6, 1)))
    assert bundle.free_strain((344.7e3, second * 1e3)) == printed(strain, 4)


def test_bundle_with_three_equilibria():
    found = LibraryBundle(((SLENDERNESS_8, 1), (SLENDERNESS_8, 4))).equilibria((344.7e3, 69e3))
    # the middle one is 0.1959 here; .195, which the table prints, is that number cut
    assert [e for e, _ in found] == [printed(0.186, 3), printed(0.196, 3), printed(0.230, 3)]
    assert [stable for _, stable in found] == [True, False, True]


def test_one_unit_of_two_against_four_of_five():
    two, five = (
        library_muscle(
            replace(
                FIGURE_9,
                material=SILICONE,
                outer_radius=math.sqrt(2 / n) * 9e-3,
                wall_thickness=math.sqrt(2 / n) * 2.25e-3,
            )
        )
        for n in (2, 5)
    )
    strains = np.array([0.05, 0.14, 0.15])
    one, four = np.asarray(two.force(0.0, strains)), 4 * np.asarray(five.force(0.0, strains))
    assert one[0] == printed(-6.5, 1)
    assert four[0] == printed(-6.9, 1)
    assert one[1] > four[1]  # at 0.14 the four still resist more
    assert one[2] < four[2]

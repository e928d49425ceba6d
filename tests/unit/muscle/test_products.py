"""Muscles from what is sold and counted, in Python, in files and by `fascicle init`."""

import math

import numpy as np
import pytest

import fascicle as fs
from fascicle.core.errors import InvalidInputError
from fascicle.files.muscle_files import loads
from fascicle.muscle.products import sleeve_angle
from refusing import refuses


MUSCLE = """format = 1
[muscle]
length = "264.1 mm"
wall_thickness = "1 mm"
tension = "ideal"
"""


def test_a_thread_and_its_turns_are_the_braid():
    b, n, L = 0.2771, 1.5, 0.2641
    muscle = fs.Muscle.from_thread(L, b, n, "1 mm", tension="ideal")
    assert float(muscle.outer_radius) == pytest.approx(math.sqrt(b**2 - L**2) / (2 * math.pi * n))
    # Chou and Hannaford's force at rest, whose sizes these are
    assert float(muscle.force(5e5, 0.0)) == pytest.approx(
        5e5 * (3 * L**2 - b**2) / (4 * math.pi * n**2)
    )
    assert float(muscle.force(5e5, 0.0)) == pytest.approx(2342.44, abs=0.005)
    assert loads(MUSCLE + 'thread_length = "277.1 mm"\nturns = 1.5\n').braid_angle == pytest.approx(
        float(muscle.braid_angle), rel=1e-12
    )


def test_diameters_are_taken_as_diameters():
    text = MUSCLE.replace('wall_thickness = "1 mm"\n', "")
    sizes = 'outer_diameter = "9 mm"\ninner_diameter = "7 mm"\nbraid_angle = "25 deg"\n'
    muscle = loads(text + sizes)
    assert (float(muscle.outer_radius), float(muscle.wall_thickness)) == pytest.approx(
        (4.5e-3, 1e-3)
    )


@pytest.mark.parametrize(
    "sizes",
    [
        'thread_length = "277.1 mm"\n',
        'thread_length = "200 mm"\nturns = 1.5\n',
        'thread_length = "277.1 mm"\nturns = 1.5\nbraid_angle = "20 deg"\n',
        'outer_diameter = "9 mm"\nouter_radius = "4.5 mm"\nbraid_angle = "20 deg"\n',
        'outer_diameter = "9"\nbraid_angle = "20 deg"\n',
    ],
)
def test_sizes_that_are_missing_or_contradict_are_refused(sizes):
    with refuses("muscle"):
        loads(MUSCLE + sizes)


def test_a_sleeve_keeps_its_threads():
    # r / sin(angle) is that of a thread, whatever the tube
    tubes = np.array([6e-3, 9e-3, 12e-3])
    angles = sleeve_angle(12e-3, np.radians(40.0), tubes)
    np.testing.assert_allclose(tubes / np.sin(angles), 12e-3 / np.sin(np.radians(40.0)))
    with pytest.raises(InvalidInputError) as error:
        sleeve_angle("5 mm", "70 deg", "9 mm")
    assert error.value.argument == "tube_diameter"


def test_thinner_tubes_of_one_wall_contract_less():
    """9/7, 7/5 and 5/3 mm in sleeves of one kind: reported as some 30, 15 and 10 %."""
    muscles = [
        fs.Muscle.from_sleeve("200 mm", 1.3 * d, "40 deg", d, "1 mm") for d in (9e-3, 7e-3, 5e-3)
    ]
    strains = [float(muscle.free_strain("3 bar")) for muscle in muscles]
    assert strains == sorted(strains, reverse=True)


def test_constants_per_length_and_extensors_are_refused():
    law = '[muscle.tension]\nlaw = "martens2017"\nmodulus_2 = "2e10 Pa/m^2"\n'
    sizes = 'outer_radius = "10 mm"\nbraid_angle = "25 deg"\n'
    with refuses("muscle.tension.modulus_2"):
        loads(MUSCLE.replace('tension = "ideal"\n', "") + sizes + law)
    with refuses("muscle.braid_angle"):
        loads(MUSCLE + sizes.replace("25", "72"))


def test_moduli_per_length_become_those_of_the_stretch():
    moduli = (7.4085e07, -6.892e08, 1.837e09, -8.4879e08)  # oracle_festo has them over meters
    law = fs.tension.Martens2017.from_published("250 mm", moduli, -0.1)
    assert law == fs.tension.Martens2017()
    assert law.modulus_3 == pytest.approx(0.25**3 * moduli[3], rel=1e-15)


@pytest.mark.parametrize("pressure", [2e6, "5 MPa", [1e5, 2e6], np.nextafter(1e6, 2e6)])
def test_a_hydraulic_pressure_names_a_remedy(pressure):
    with pytest.raises(fs.InvalidInputError) as raised:
        fs.example("kim2021_figure_6").force(pressure, 0.1)
    assert raised.value.argument == "pressure"
    assert raised.value.value > 1e6
    assert "got 1e6 Pa" not in str(raised.value)  # its digits tell it from the limit
    assert raised.value.remedy

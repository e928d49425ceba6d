import math

import pytest
from numpy.testing import assert_array_equal

from fascicle.bundle import Bundle
from fascicle.files import example, example_text, examples, load, loads
from fascicle.muscle import Muscle
from fascicle.muscle.collapse import COLLAPSE_LAWS
from fascicle.muscle.materials import SILICONE_KIM2021
from refusing import refuses_at


MUSCLE = """format = 1
[muscle]
length = "127 mm"
outer_radius = "6.35 mm"
wall_thickness = "1.6 mm"
braid_angle = "33 deg"
"""
COLLAPSE, TUNING = "[muscle.collapse]\n", "[muscle.tuning]\n"
UNIT = "[[bundle.motor_unit]]\n"
BUNDLE = "[bundle]\n" + UNIT
TONDU = 'tension = { law = "tondu_lopez", '
TWO = MUSCLE.replace("[muscle]", "[muscle.thin]") + MUSCLE.replace("format = 1\n", "").replace(
    "[muscle]", "[muscle.thick]"
).replace("6.35", "9")


def test_sizes_are_the_floats_that_python_would_write():
    muscle = loads(MUSCLE)
    assert isinstance(muscle, Muscle)
    assert (muscle.length, muscle.outer_radius) == (0.127, 6.35e-3)
    assert (muscle.wall_thickness, muscle.braid_angle) == (1.6e-3, math.radians(33))


def test_every_law_by_name():
    text = MUSCLE + (
        'material = "silicone_kim2021"\ntension = "ideal"\nbuckling = "elastica"\n'
        'post_collapse = "printed"\n[muscle.collapse]\nlaw = "wood1958"\nfactor = 0.5\n'
        "transition_rate = 40\n"
    )
    muscle = loads(text)
    names = (muscle.tension, muscle.buckling, muscle.post_collapse, muscle.collapse)
    assert [law.name for law in names] == ["ideal", "elastica", "printed", "wood1958"]
    assert muscle.material.c10 == SILICONE_KIM2021.c10
    assert (muscle.collapse.factor, muscle.transition_rate) == (0.5, 40)


def test_a_tension_law_with_its_numbers():
    tension = loads(MUSCLE + TONDU + 'strain_factor = 1.2, decay_pressure = "2 bar" }').tension
    assert tension.name == "tondu_lopez"
    assert (tension.strain_factor, tension.decay_pressure) == (1.2, 2e5)
    assert tension.strain_factor_rise == 0
    section = loads(MUSCLE + '[muscle.tension]\nlaw = "meller2014"\nforce_factor = 0.9\n').tension
    assert (section.name, section.force_factor, section.strain_factor) == ("meller2014", 0.9, 1)
    by_term = loads(MUSCLE + 'tension = { law = "kothera2009", pressure_term = "ideal" }').tension
    assert by_term.pressure_term == "ideal"


def test_a_factor_on_any_collapse_law():
    for law in COLLAPSE_LAWS:
        collapse = loads(MUSCLE + COLLAPSE + f'law = "{law}"\nfactor = 0.785\n').collapse
        assert (collapse.name, collapse.factor) == (law, 0.785)


def test_a_material_of_its_own():
    inline = 'material = { c10 = "118.4 kPa", c01 = "105.7 kPa", youngs_modulus = "1.78 MPa" }'
    material = loads(MUSCLE + inline).material
    assert (material.c10, material.c01) == (118.4e3, 105.7e3)
    assert (material.youngs_modulus, material.poisson_ratio) == (1.78e6, 0.5)
    by_modulus = loads(MUSCLE + 'material = { youngs_modulus = "1.78 MPa" }').material
    assert float(6 * (by_modulus.c10 + by_modulus.c01)) == pytest.approx(1.78e6, rel=1e-15)


def test_tuning():
    text = MUSCLE + TUNING + (
        'pressure = ["50 kPa", "1 bar"]\nc1 = ["1 N", "-2 N"]\nc2 = [0.9, 1.1]\n'
        "youngs_modulus_factor = 1.25\ncollapse_moment_factor = 1.1\ntransition_rate = 100\n"
        'hinge_stiffness_factor = { constant = 1.25, slope = "0.87 1/bar" }\n'
    )  # fmt: skip
    tuning = loads(text).tuning
    assert_array_equal(tuning.pressures, [0, 50e3, 100e3])
    assert_array_equal(tuning.c1, [0, 1, -2])
    assert_array_equal(tuning.c2, [1, 0.9, 1.1])
    # Table 1's row, at 1 bar: 0.87 + 1.25
    assert float(tuning.hinge_stiffness_at(1e5)) == pytest.approx(2.12, rel=1e-15)
    assert (tuning.youngs_modulus_factor, tuning.collapse_moment_factor) == (1.25, 1.1)
    assert (tuning.transition_rate, tuning.dead_band) == (100, 0)
    assert loads(MUSCLE + TUNING + 'dead_band = "12 kPa"').tuning.dead_band == 12e3
    plain = loads(MUSCLE + TUNING + "hinge_stiffness_factor = 0.5").tuning
    assert (plain.hinge_stiffness_factor, plain.hinge_stiffness_slope) == (0.5, 0)


def test_bundles():
    bundle = loads(MUSCLE + '[bundle]\nsupply_pressure = "60 psi"\n' + UNIT + UNIT + "count = 4\n")
    assert isinstance(bundle, Bundle)
    assert [int(unit.count) for unit in bundle.motor_units] == [1, 4]
    assert float(bundle.supply_pressure) == pytest.approx(413.7e3, rel=1e-3)
    assert bundle.scheme == "orderly"
    unlike = loads(f'{TWO}{BUNDLE}muscle = "thick"\n{UNIT}muscle = "thin"\n')
    radii = [float(unit.muscle.outer_radius) for unit in unlike.motor_units]
    assert radii == [9e-3, 6.35e-3]


def test_windows_files_and_byte_order_marks(tmp_path):
    path = tmp_path / "m.toml"
    path.write_bytes(b"\xef\xbb\xbf" + MUSCLE.replace("\n", "\r\n").encode())
    assert isinstance(load(path), Muscle)


def test_a_binary_file_is_refused(tmp_path):
    path = tmp_path / "b.toml"
    for raw in (bytes(range(256)), b"\x00" * 50):
        path.write_bytes(raw)
        with refuses_at(f"{path}: "):
            load(path)


@pytest.mark.parametrize("name", examples())
def test_examples_load_and_name_their_source(name):
    text = example_text(name)
    assert isinstance(example(name), Bundle if "bundle" in name else Muscle)
    assert "# Source: Actuators 10, 42 (2021)" in text and len(examples()[name]) < 100


def test_examples_are_the_papers():
    six, nine = example("kim2021_figure_6"), example("kim2021_figure_9")
    assert (six.length, six.outer_radius, six.wall_thickness) == (0.127, 6.35e-3, 1.6e-3)
    assert nine.wall_thickness / nine.outer_radius == 0.25
    stout, slender = example("kim2021_slenderness_8"), example("kim2021_slenderness_10")
    # the paper rounds 8.03 and 10
    assert [round(float(muscle.slenderness)) for muscle in (stout, slender)] == [8, 10]
    for t, factors in ((stout.tuning, [1.25, 1.1, 2.12]), (slender.tuning, [0.95, 0.75, 1.75])):
        found = [t.youngs_modulus_factor, t.collapse_moment_factor, t.hinge_stiffness_at(1e5)]
        assert [round(float(x), 12) for x in found] == factors  # 1 bar: Table 1's numbers add up
    for name, counts in (("1_1", [1, 1]), ("1_4", [1, 4]), ("five", [1] * 5)):
        units = example(f"kim2021_bundle_{name}").motor_units
        assert [int(unit.count) for unit in units] == counts

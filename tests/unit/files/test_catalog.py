"""Catalogs: from what a data sheet says to muscles and products."""

import numpy as np
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.files import descriptions
from fascicle.files.task import load_task, loads_task


PLAIN = """format = 1
[task]
force = "60 N"
stroke = "10 mm"
supply_pressure = "5 bar"
[design]
muscle = "kim2021_figure_6"
muscles = 2
"""
THIN = """[[design.catalog]]
name = "thin"
outer_radius = "6 mm"
length = ["100 mm", "200 mm"]
price = "12 EUR"
price_per_length = "10 EUR/m"
mass = "30 g"
mass_per_length = "50 g/m"
largest_pressure = "6 bar"
largest_strain = "25 %"
source = "made up"
"""


def test_a_product_of_two_lengths_is_two_drawings():
    file = loads_task(PLAIN + THIN)
    assert list(file.space.drawings) == ["thin, 100 mm", "thin, 200 mm"]
    own = fs.example("kim2021_figure_6")
    first = file.space.drawings["thin, 100 mm"]
    assert float(first.length) == 0.1 and float(first.outer_radius) == 6e-3
    # what it doesn't say is the drawing's, the wall in proportion
    assert float(first.braid_angle) == float(own.braid_angle)
    ratio = float(own.wall_thickness / own.outer_radius)
    assert_allclose(float(first.wall_thickness), 6e-3 * ratio, rtol=1e-12)
    assert first.material == own.material
    product = file.catalog.products["thin, 200 mm"]
    assert_allclose([product.price, product.mass], [12 + 10 * 0.2, 0.030 + 0.050 * 0.2])
    assert (product.largest_pressure, product.largest_strain) == (6e5, 0.25)
    assert (product.name, product.source, file.catalog.currency) == ("thin", "made up", "EUR")
    assert len(file.space) == 2 * 2
    (finding,) = file.findings
    assert finding.code == "product.parts_borrowed" and finding.data["products"] == ["thin"]


def test_product_has_the_laws_of_its_base(tmp_path):
    ends = fs.ends.Compliant(inactive_length=4e-3)
    own = fs.example("kim2021_figure_6").replace(ends=ends, buckling="elastica")
    fs.save(own, tmp_path / "own.toml")
    (tmp_path / "task.toml").write_text(PLAIN.replace("kim2021_figure_6", "own.toml") + THIN)
    for muscle in load_task(tmp_path / "task.toml").space.drawings.values():
        assert muscle.ends == ends and muscle.buckling == own.buckling


def test_a_catalog_of_one_table_and_of_diameters():
    def drawn(sizes):
        table = f'[design.catalog]\nname = "a"\n{sizes}\n'
        (muscle,) = loads_task(PLAIN + table).space.drawings.values()
        return muscle

    inner = 'inner_diameter = "20 mm"\n'
    assert_allclose(drawn(inner + 'wall_thickness = "2 mm"').outer_radius, 12e-3)
    assert_allclose(drawn(inner).outer_radius - drawn(inner).wall_thickness, 10e-3)
    outer = drawn('outer_diameter = "20 mm"\nbraid_angle = "25 deg"')
    assert_allclose([outer.outer_radius, outer.braid_angle], [0.01, np.radians(25)])


def test_cut_lengths_are_those_of_the_design():
    lengths = 'length = ["20 mm", "100 mm", "2 m"]\n'
    table = '[[design.catalog]]\nname = "a"\nouter_radius = "6 mm"\nleast_length = "40 mm"\n'
    file = loads_task(PLAIN + lengths + table)
    assert list(file.space.drawings) == ["a, 100 mm", "a, 2000 mm"]


def test_shipped_catalog_has_its_source():
    assert "festo_dmsp" in descriptions("catalogs")
    file = loads_task(PLAIN + 'length = ["100 mm", "300 mm"]\ncatalog = "festo_dmsp"\n')
    names = {product.name for product in file.catalog.products.values()}
    assert names == {"DMSP-10", "DMSP-20", "DMSP-40"} and len(file.space.drawings) == 6
    for name, product in file.catalog.products.items():
        assert product.source and product.price is None
        muscle = file.space.drawings[name]
        if product.name == "DMSP-40":
            inner = 2e3 * float(muscle.outer_radius - muscle.wall_thickness)
            assert_allclose(inner, 40.0, rtol=1e-12)


def test_a_calibrated_product_is_the_measured_muscle():
    """Made 300 mm long, as it was measured; else by its active share of the length."""
    lengths = 'length = ["300 mm", "600 mm"]\ncatalog = "festo_dmsp"\n'
    drawings = loads_task(PLAIN + lengths).space.drawings
    measured = fs.catalog["festo-dmsp-20-300"].muscle
    product = drawings["DMSP-20, 300 mm"]
    assert_allclose(product.force(600e3, 0.17), measured.force(600e3, 0.17), rtol=1e-9)
    assert_allclose(drawings["DMSP-20, 600 mm"].length, 2 * measured.length, rtol=1e-12)


def test_catalog_file_with_its_own_muscles(tmp_path):
    fs.save(fs.example("kim2021_slenderness_8"), tmp_path / "fitted.toml")
    (tmp_path / "makers.toml").write_text(
        'format = 1\n[[product]]\nname = "a"\nouter_radius = "6 mm"\nmuscle = "fitted.toml"\n'
        '[[product]]\nname = "b"\nouter_radius = "7 mm"\n'
    )
    (tmp_path / "task.toml").write_text(PLAIN + 'catalog = "makers.toml"\n')
    a, b = load_task(tmp_path / "task.toml").space.drawings.values()
    assert float(a.tuning.youngs_modulus_factor) == 1.25
    assert float(b.tuning.youngs_modulus_factor) == 1.0

"""The catalog of measured muscles: its checks run over all entries, so a new one needs no code."""

import re
from pathlib import Path

import numpy as np
import pytest

import fascicle as fs
from fascicle.design import answer_search, search
from fascicle.files.measured_muscles import read_entry
from fascicle.files.task import loads_task
from refusing import refuses


FOLDER = Path(fs.files.__file__).parent / "measured"
TEMPLATE = Path(__file__).parents[3] / "docs" / "_static" / "measured-muscle.toml"
# licenses under which readings may be passed on; quoted constants need none
OPEN = re.compile(r"CC0|CC BY( \d|$)|public domain|ODC-BY|MIT|BSD|Apache", re.IGNORECASE)
LARGEST_FILE = 100_000  # bytes: a record of a few thousand readings


@pytest.fixture(params=fs.catalog)
def entry(request):
    return fs.catalog[request.param]


def test_an_entry_says_where_its_numbers_come_from(entry):
    assert re.fullmatch(r"[a-z0-9-]+", entry.name)
    for text in (entry.title, entry.maker, entry.source, entry.license, entry.sizes):
        assert text.strip()
    assert re.search(r"\b(19|20)\d\d\b", entry.source), "the source has no year"
    assert entry.url.startswith("https://")
    assert all(text.endswith(".") for text in entry.assumed)
    assert entry.toml.startswith("# ") and "\nlog = " not in entry.toml
    if entry.record_file is not None:
        assert OPEN.search(entry.license), "readings need a license that allows to pass them on"
        assert (FOLDER / entry.record_file).stat().st_size <= LARGEST_FILE


def test_its_muscle_is_the_files(entry):
    assert fs.load(FOLDER / f"{entry.name}.toml") == entry.muscle
    assert fs.example(entry.name) == entry.muscle


def test_force_is_finite_over_its_range(entry):
    highest, largest = (ends and ends[1] for ends in entry.range)
    pressure = np.linspace(0.0, highest or 600e3, 20)[:, None]  # 6 bar is a usual supply
    strain = np.linspace(0.0, largest or 0.3, 40)
    force = np.asarray(entry.muscle.force(pressure, strain))
    assert np.all(np.isfinite(force))
    assert np.all(np.diff(force[-1]) < 0) or largest is None  # it pulls less as it contracts
    assert np.all(np.isfinite(np.asarray(entry.muscle.free_strain(pressure[1:]))))


def test_a_fit_has_its_error_and_range(entry):
    if entry.basis == "fit":
        assert entry.error.rmse > 0 and 0 < entry.error.relative_rmse <= 0.05
        assert None not in entry.range


def test_errors_are_those_of_the_record(entry):
    if (record := entry.record) is None:
        pytest.skip("no readings in the entry")
    residuals, top = entry.residuals(), record.force.max()
    rmse = np.sqrt(np.mean(residuals**2))
    # the file has as few digits as three of the first and two of the second
    np.testing.assert_allclose([rmse, rmse / top], entry.error[:2], rtol=0.01)
    assert np.abs(residuals).max() / top <= entry.error.largest
    np.testing.assert_allclose(entry.range.pressure, [record.pressure.min(), record.pressure.max()])
    strain = record.strain * entry.strain_ratio
    np.testing.assert_allclose(entry.range.strain, [strain.min(), strain.max()], atol=1e-4)


def test_its_picture_has_the_readings(entry):
    (axes,) = entry.plot().axes
    points = [line for line in axes.lines if line.get_marker() == "o"]
    assert bool(points) == (entry.record is not None)
    assert "Contraction" in axes.get_xlabel()


def test_the_catalog_is_a_mapping():
    assert len(fs.catalog) == len(list(fs.catalog)) >= 9
    assert "festo-dmsp-20-300" in fs.catalog and "none" not in fs.catalog and 3 not in fs.catalog
    assert fs.catalog.get("none") is None
    with refuses("name"):
        fs.catalog["festo-dmps-20-300"]


def test_strains_of_a_fitted_muscle_refer_to_its_own_length():
    entry = fs.catalog["festo-dmsp-20-300"]
    assert entry.rest_length == 0.3
    # 296 and 222 mm were measured: 4 and 78 mm of 273.835 mm
    np.testing.assert_allclose(entry.range.strain, [4 / 273.835, 78 / 273.835], rtol=1e-3)
    assert entry.error.relative_rmse <= 0.008


def test_kims_muscles_are_those_of_the_examples():
    for number, slenderness in ((1, 8), (2, 10)):
        example = fs.example(f"kim2021_slenderness_{slenderness}")
        assert fs.catalog[f"kim2021-fam-{number}"].muscle == example


def test_what_lies_beyond_the_measured_range_is_extrapolated():
    entry = fs.catalog["festo-dmsp-20-300"]
    assert entry.extrapolations(600e3, 0.2) == []
    codes = [finding.code for finding in entry.extrapolations(700e3, 0.3)]
    assert codes == ["muscle.pressure_extrapolated", "muscle.strain_extrapolated"]
    assert fs.catalog["festo-20-400-sarosi"].extrapolations(1e6, 0.5) == []


TASK = """format = 1
[task]
force = "300 N"
strain = 0.1
supply_pressure = "{pressure}"
[design]
muscle = {muscle}
muscles = [1, 2]
"""


def test_a_design_draws_from_the_catalog():
    names = '["festo-dmsp-20-300", "festo-dmsp-10-250-rigid"]'
    file = loads_task(TASK.format(pressure="6 bar", muscle=names))
    assert list(file.space.drawings) == ["festo-dmsp-20-300", "festo-dmsp-10-250-rigid"]
    assert file.space.drawings["festo-dmsp-20-300"] == fs.catalog["festo-dmsp-20-300"].muscle
    with refuses("design.muscle"):
        loads_task(TASK.format(pressure="6 bar", muscle='"festo-dmsp-20-30"'))


@pytest.mark.parametrize("catalog", ["", 'catalog = "festo_dmsp"\n'])
def test_a_design_beyond_what_was_measured_says_so(catalog):
    text = TASK.format(pressure="7 bar", muscle='"festo-dmsp-20-300"') + 'length = "200 mm"\n'
    file = loads_task(text + catalog)
    assert file.uncertainty.basis == ("product" if catalog else "fit")
    answer = answer_search(search(file.space, file.task, catalog=file.catalog))
    findings = {x.code: x.data for x in answer.findings if x.code.startswith("muscle.")}
    assert list(findings) == ["muscle.pressure_extrapolated", "muscle.length_extrapolated"]
    assert findings["muscle.pressure_extrapolated"]["value"] == 7e5
    product = answer.summary.product
    name = f"{product.name}, 200 mm" if product else "festo-dmsp-20-300"
    assert findings["muscle.length_extrapolated"]["muscle"] == name


def test_the_template_is_an_entry():
    entry = read_entry(TEMPLATE.read_text(encoding="utf-8"), "template")
    assert entry.basis == "fit" and entry.error.rmse == 2.4
    np.testing.assert_allclose(entry.strain_ratio, 150 / 141)
    # the keys in comments are valid, too
    text = re.sub(r"^# (record|rmse|relative_rmse)", r"\1", entry.toml, flags=re.MULTILINE)
    assert read_entry(text, "template").record_file == "NAME.csv"

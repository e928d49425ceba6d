"""Files in the manner of people's own, and what they were refused or misread for."""

import numpy as np
import pytest
from measured import measured

import fascicle as fs
from asked import asked
from fascicle.calibrate import select_model
from fascicle.records import load, runs
from fascicle.records.headers import MissingMetadataError
from refusing import refuses_at


LENGTH = {"rest_length": 0.18}
PLACES = {"columns": "force[N],pressure[kPa],time,branch", "constants": {"length": "180 mm"}}
READ = {
    "01_headerless.csv": (60, PLACES), "02_isometric_floor.csv": (200, {}),
    "02b_repeats_at_rest.csv": (192, {}), "03_in_mm_header.csv": (6, {}),
    "04_bluehill_200kPa.csv": (5, {"constants": {"pressure": "200 kPa"}}),
    "04b_bluehill_raw_only_200kPa.csv": (5, {"name_pattern": "{pressure}kPa"}),
    "05_labview.lvm": (5, {}), "06_timestamps.csv": (5, {}),
    "07_hanging_mass.csv": (8, {}), "07b_mass_kg.csv": (8, {}),
    "09_whitespace.dat": (4, {}), "12b_zero_offset.csv": (4, {"zeros": {"pressure": "8.2 kPa"}}),
    "13_isometric_two_branches.csv": (480, {}),
    "20_short_zero_sweep_german.csv": (540, {"rest_length": 0.2}), "21_zugversuch.csv": (1600, {}),
    "22_isometric_steps.csv": (1700, {}), "26_hanging_mass_light.csv": (66, {"rest_length": 0.07}),
    "27_free_contraction.csv": (33, {"rest_length": 0.07}),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_every_file_is_read(name):
    readings, options = READ[name]
    record = load(measured(f"field-cases/{name}"), **LENGTH | options)
    assert len(record) == readings
    assert 1e5 <= record.pressure.max() < 1e6
    assert record.force.max() > 1 or name == "27_free_contraction.csv"
    assert all(run.kind != "mixed" for run in runs(record))


@pytest.mark.parametrize(
    ("name", "choice"),
    [
        ("01_headerless.csv", ("columns", "")),
        ("04_bluehill_200kPa.csv", ("constants", "pressure")),
    ],
)  # fmt: skip
def test_what_a_file_lacks_is_offered(name, choice):
    assert asked(measured(f"field-cases/{name}"), **LENGTH)[0][:2] == choice


def test_a_rigs_clock_gives_the_time():
    record = load(measured("field-cases/06_timestamps.csv"), **LENGTH)
    assert record.time == pytest.approx([0, 0.1, 0.2, 0.3, 0.4])


@pytest.mark.parametrize("name", ["07_hanging_mass", "07b_mass_kg"])
def test_hanging_masses_are_weights(name):
    record = load(measured(f"field-cases/{name}.csv"), rest_length=0.18)
    assert record.force.min() == pytest.approx(0.2 * 9.80665)  # N: the lightest mass, of 200 g


@pytest.mark.parametrize("name", ["08_arduino_monitor.txt", "28_wide.csv"])
def test_what_is_not_read_is_refused(name):
    path = measured(f"field-cases/{name}")
    with refuses_at(f"{path}, line 1: "):
        load(path, constants={"force": "2.55 kgf"}, **LENGTH)


def test_channels_with_a_clock_each_are_refused_with_the_choice():
    path = measured("field-cases/23_three_clocks.csv")
    choices = asked(path, **LENGTH)
    assert [choice[:2] for choice in choices] == [("resample", ""), ("columns", "time")]
    record = load(path, **LENGTH, resample=choices[0][2])
    assert record.time == pytest.approx(0.05 * np.arange(len(record)))
    rows = np.genfromtxt(path, delimiter=",", skip_header=1)
    for values, clock, column, unit in ((record.force, 0, 1, 1), (record.pressure, 4, 5, 1e3)):
        expected = unit * np.interp(record.time, rows[:, clock], rows[:, column])
        np.testing.assert_allclose(values, expected)


@pytest.mark.parametrize(
    "name", ["21_zugversuch.csv", pytest.param("22_isometric_steps.csv", marks=pytest.mark.slow)]
)
def test_zeros_of_both_gauges_are_found(name):
    record = load(measured(f"field-cases/{name}"), **LENGTH)
    start = fs.Muscle(0.18, 6e-3, 1.2e-3, np.radians(25.0))
    gauge = select_model(record, start).calibration.gauge
    assert gauge.force_zero == pytest.approx(5.0, abs=1.0)
    assert gauge.pressure_zero == pytest.approx(2e3, abs=500.0)


def test_signals_with_a_scale_are_quantities():
    path = measured("field-cases/29_volts.csv")
    assert asked(path, rest_length=0.24)[0][:2] == ("scales", "pressure")
    record = load(
        path, rest_length=0.24, zeros={"pressure": "0.2V", "force": "-0.9V"},
        scales={"pressure": "1.475bar/V", "force": "12N/V"},
    )  # fmt: skip
    volts = np.genfromtxt(path, delimiter=",", skip_header=1)
    np.testing.assert_allclose(record.pressure, 147.5e3 * (volts[:, 0] - 0.2))
    np.testing.assert_allclose(record.force, 12 * (volts[:, 2] + 0.9))


def test_cells_that_nothing_reads_are_refused():
    with pytest.raises(MissingMetadataError) as error:
        load(
            measured("field-cases/28_wide.csv"), columns="contraction[mm]",
            constants={"force": "2.55 kgf"}, rest_length="70 mm",
        )  # fmt: skip
    assert error.value.argument == "columns"

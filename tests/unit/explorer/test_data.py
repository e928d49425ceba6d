"""The data tab and the records that it reads: its content is the last record's, or nothing."""

import numpy as np
import pytest

import fascicle as fs
from fascicle.explorer.data_tab import (
    KINDS,
    LARGEST_FILE,
    MOST_ROWS,
    TUNING,
    DataView,
    curves_at_levels,
    example_record,
    fit_record,
    mismatch_reason,
    read_record,
)
from fascicle.explorer.state import Session, view_of
from fascicle.plot.theme import LIGHT
from fascicle.records.record import Record
from fascicle.report.calibration_figures import measured_with_curves
from refusing import refuses_at


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")
MUSCLE = fs.example("kim2021_bundle_1_1").motor_units[0].muscle
HEAD = b"pressure [kPa],strain [-],force [N]\n"
GOOD = HEAD + b"".join(b"%d,%g,%d\n" % (P, i / 50, P // 4) for P in (100, 200) for i in range(5))
HALF = b"pressure [kPa],displacement [mm],force [N]\n200,0,90\n200,40,70\n200,75,50\n"


@pytest.fixture
def tab():
    tab = DataView(Session(SIX), LIGHT)
    tab.refresh()
    return tab


def send(tab, raw, name="a.csv"):
    """Send a file as Panel does: one of no bytes has a name alone."""
    tab.file.param.update(value=raw or None, filename=name)


def enabled(tab):
    """Readings drawn, fit enabled, and the empty state hidden."""
    has_readings = tab._figure.visible and len(tab.readings.data["x"]) > 0
    return has_readings, not tab.job.run.disabled, not tab.empty_state.visible


@pytest.mark.parametrize(
    ("raw", "expected"), [(HEAD + b"100,0,40\n100,-0.2,40\n", "-0.2"), (b"", "bad.csv")]
)
def test_a_refused_file_drops_the_earlier_record(tab, raw, expected):
    assert enabled(tab) == (False,) * 3
    send(tab, GOOD)
    assert enabled(tab) == (True,) * 3
    tab.table.object = tab.fit_notes.object = "a fit"
    for button in (tab.use, *tab.saves):
        button.disabled = False
    send(tab, raw, "bad.csv")
    assert expected in tab.message.text
    assert enabled(tab) == (False,) * 3
    assert tab.record is None and not tab.notes.object
    assert all(button.disabled for button in (tab.use, *tab.saves))
    assert not tab.table.object and not tab.fit_notes.object
    send(tab, GOOD, "again.csv")
    assert enabled(tab) == (True,) * 3 and not tab.message.text


def test_a_fit_to_an_earlier_record_is_not_shown(tab, monkeypatch):
    send(tab, GOOD)
    job, started = tab.job, []
    monkeypatch.setattr(job._latest, "request", started.append)
    tab.start_fit()
    assert job.run.disabled and job.bar.visible and not job.cancel.disabled
    send(tab, GOOD.replace(b"200", b"300"), "b.csv")
    assert not job.run.disabled and not job.bar.visible and job.cancel.disabled
    job._end(started[0]())  # it ends at its next step
    assert tab.fit is None and tab.use.disabled and not tab.message.text


def test_a_file_read_after_another_was_opened_is_not_shown(tab, monkeypatch):
    monkeypatch.setattr(tab._reads, "request", lambda _: None)
    tab.open_record(GOOD, "a.csv")
    tab.open_record(b"none", "b.csv")
    tab._show_record((GOOD, read_record(GOOD, "a.csv", MUSCLE)))
    assert tab.record is None


def test_readings_are_read_and_have_curves():
    record = read_record(GOOD, "d.csv", MUSCLE)
    assert len(record) == 10
    curves = curves_at_levels(MUSCLE, record)
    assert curves.pressure == pytest.approx([1e5, 2e5])
    force = np.asarray(MUSCLE.force(2e5, curves.strain))
    assert curves.force[1] == pytest.approx(force, abs=1e-9)


def test_curves_of_a_record_whose_strains_refer_to_another_length():
    strain = np.linspace(0.0, 0.1, 121)
    force = np.asarray(MUSCLE.force(2e5, 1.5 * strain))
    record = Record.of(2e5, strain, force, rest_length=1.5 * float(MUSCLE.length))
    curves = curves_at_levels(MUSCLE, record)
    np.testing.assert_allclose(curves.force[0], force, atol=1e-9)
    np.testing.assert_allclose(measured_with_curves(record, MUSCLE).residual, 0.0, atol=1e-9)


def test_a_large_file_is_refused_with_its_limit():
    rows = HEAD + b"100,0,20\n" * (MOST_ROWS + 1)
    for raw, limit in ((b"x" * (LARGEST_FILE + 1), LARGEST_FILE), (rows, MOST_ROWS)):
        with refuses_at("d.csv: ") as error:
            read_record(raw, "d.csv", MUSCLE)
        assert str(limit) in str(error.value)


def test_spreadsheets_and_mat_files_are_read_within_limits(tmp_path):
    from openpyxl import Workbook
    from scipy.io import savemat

    P, F, x = [100.0] * 5, [40.0, 30, 20, 10, 5], [0.0, 0.02, 0.04, 0.06, 0.08]
    book = Workbook()
    book.active.append(["pressure [kPa]", "force [N]", "strain"])
    for row in zip(P, F, x, strict=True):
        book.active.append(row)
    path = tmp_path / "d.xlsx"
    book.save(path)
    assert read_record(path.read_bytes(), path.name, MUSCLE).force.tolist() == F
    book.active["XFD1048576"] = 1
    book.save(path)
    with refuses_at("d.xlsx, line 1048576: "):
        read_record(path.read_bytes(), path.name, MUSCLE)
    path = tmp_path / "d.mat"
    columns = {"pressure_kPa": P, "force_N": F, "strain": x}
    savemat(path, columns, do_compression=True)
    assert read_record(path.read_bytes(), path.name, MUSCLE).force.tolist() == F
    savemat(path, {"image": np.zeros(6_000_000)}, do_compression=True)
    assert path.stat().st_size < LARGEST_FILE
    with refuses_at("d.mat: "):
        read_record(path.read_bytes(), path.name, MUSCLE)


def test_a_name_is_never_opened():
    with refuses_at("/etc/passwd, line 1: "):
        read_record(b"a,b\n1,2\n", "/etc/passwd", MUSCLE)


def test_a_rest_length_is_refused_at_its_field(tab):
    field = tab.read_inputs.length
    send(tab, HALF)
    before = tab.record
    for text in ("-1", "three"):
        field.input.value = text
        assert field.message.text and tab.record is before
    field.input.value = "1 m"
    assert not field.message.text and tab.record.strain.max() == pytest.approx(0.075)


def test_a_refused_fit_has_a_remedy_that_the_page_has():
    record = read_record(HEAD + b"100,0,40\n200,0,90\n", "a.csv", MUSCLE)
    with pytest.raises(fs.InvalidInputError) as error:
        fit_record(record, MUSCLE, lambda _: None, TUNING)
    assert any(label in error.value.remedy for label in KINDS)


def test_columns_and_units_can_be_given():
    raw = b"A,B,C\n0,10,100\n5,8,100\n10,5,100\n"
    options = {
        "columns": {"displacement": "A", "force": "B", "pressure": "C"},
        "units": {"displacement": "mm", "force": "N", "pressure": "kPa"},
    }
    record = read_record(raw, "w.csv", MUSCLE, options | {"rest_length": 0.2})
    np.testing.assert_allclose(record.strain, [0, 0.025, 0.05])
    np.testing.assert_allclose(record.pressure, 100e3)
    np.testing.assert_allclose(record.force, [10, 8, 5])
    record = read_record(raw, "w.csv", MUSCLE.replace(length=0.1), options)
    np.testing.assert_allclose(record.strain, [0, 0.05, 0.1])


def test_a_record_of_another_length_does_not_match():
    record = read_record(example_record(MUSCLE), "example.csv", MUSCLE)
    assert record.synthetic and mismatch_reason(MUSCLE, record) == ""
    assert mismatch_reason(MUSCLE, read_record(HALF, "a.csv", MUSCLE))
    long = read_record(HALF, "a.csv", MUSCLE, {"rest_length": 1.0})
    assert mismatch_reason(MUSCLE, long)  # the same displacements, over the muscle's own length
    assert mismatch_reason(MUSCLE.replace(length=1.0), long) == ""


@pytest.mark.parametrize(
    ("key", "wrong", "right"),
    [(("columns", "force"), "pull", "force"), (("units", "force"), "furlong", "lbf"),
     (("units", "pressure"), "psia", "psi")],
)  # fmt: skip
def test_a_wrong_column_or_unit_is_refused_at_its_field(tab, key, wrong, right):
    send(tab, GOOD)
    field, before = tab.read_inputs.fields[key], tab.record
    field.input.value = wrong
    assert field.message.text and len(field.input.stylesheets) == 2  # with a red border
    assert not tab.message.text and tab.record is before
    other = tab.read_inputs.fields["columns", "pressure"]
    other.input.value = "pressure"  # the error stays where it is
    assert not other.message.text
    field.input.value = right
    assert not field.message.text and tab.record is not before

"""Files in the manner of instruments and loggers, all with the same four readings."""

import sys
import tomllib
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest
from numpy.testing import assert_allclose

from asked import asked
from fascicle.core.errors import MissingExtraError
from fascicle.records import load, loads, runs
from refusing import refuses_at


TIME = [0.0, 0.1, 0.2, 0.3]
PRESSURE = [200.1, 200.3, 199.9, 200.0]  # kPa
FORCE = [118.4, 95.2, 70.8, 48.9]  # N
LENGTH = [180.0, 176.0, 171.9, 168.0]  # mm
REST = 0.18  # m
CONTRACTION = [180 - x for x in LENGTH]  # mm
ROWS = list(zip(TIME, PRESSURE, FORCE, LENGTH, strict=True))


def table(separator, columns, header="", decimal="."):
    rows = zip(*columns, strict=True)
    lines = [separator.join(str(x).replace(".", decimal) for x in row) for row in rows]
    return "\n".join([*([header] if header else []), *lines, ""])


def check(record, *, pressure=True, time=True):
    assert_allclose(record.force, FORCE, rtol=1e-9)
    assert_allclose(record.strain, np.array(CONTRACTION) / 180, atol=1e-9)
    if pressure:
        assert_allclose(record.pressure, np.array(PRESSURE) * 1e3, rtol=1e-9)
    if time:
        assert_allclose(record.time, TIME, atol=1e-9)


FORMATS = Path(__file__).parent / "formats"
OPTIONS = tomllib.loads((FORMATS / "options.toml").read_text())
FILES = sorted(path.name for path in FORMATS.iterdir() if path.suffix != ".toml")


@pytest.mark.parametrize("name", FILES)
def test_exports_of_instruments(tmp_path, name):
    options = OPTIONS.get(name, {})
    text = (FORMATS / name).read_text().replace("\n", "\r\n")
    path = tmp_path / name
    # by the name, so that a new file changes no other one's
    encoding = ("utf-8-sig", "utf-16", "cp1252")[crc32(name.encode()) % 3]
    path.write_bytes(text.encode(encoding))
    check(load(path, rest_length=REST, **options), pressure="constants" not in options)


def test_unmarked_encodings_and_a_reserved_end():
    text = "t [s],p [kPa],F [N],Länge [mm]\n" + table(",", [TIME, PRESSURE, FORCE, LENGTH])
    for raw in (text.encode("utf-16-le"), text.encode("utf-16-be"), text.encode() + b"\0" * 64):
        check(loads(raw, rest_length=REST))


@pytest.mark.parametrize("name", ["labview", "labview_a_time_for_each", "labview_without_times"])
def test_segments_of_labview_are_read_if_their_units_and_names_are_those_of_the_first(name):
    text = (FORMATS / f"{name}.lvm").read_text()
    segment = text[text.index("Channels") :]
    record = loads(f"{text}\n{segment}", rest_length=REST)
    assert_allclose(record.force, FORCE * 2)
    assert_allclose(record.pressure, np.array(PRESSURE * 2) * 1e3)
    for old, new in (("\tN\t", "\tkN\t"), ("Force", "Torque")):
        choices = asked(f"{text}\n{segment.replace(old, new)}", rest_length=REST)
        first = loads(text + segment.replace(old, new), rest_length=REST, rows=choices[0][2])
        check(first, time=name != "labview_without_times")


def test_constants_come_from_options_sidecar_and_name(tmp_path):
    text = "force [N],pressure [kPa]\n" + table(",", [FORCE, PRESSURE])
    path = tmp_path / "run_16.7cm_up.csv"
    path.write_text(text)
    strain = (180 - 167) / 180
    for options in (
        {"constants": {"length": 0.167}}, {"constants": {"length": "167 mm"}},
        {"name_pattern": "{length}cm"}, {"name_pattern": "run_{length:cm}*up"},
    ):  # fmt: skip
        assert_allclose(load(path, rest_length=REST, **options).strain, strain)
    path.with_suffix(".toml").write_text('rest_length = "180 mm"\nlength = "167 mm"\n')
    assert_allclose(load(path).strain, strain)
    for options in (
        {"name_pattern": "{pressure}kPa"}, {"name_pattern": "{mass}kg"},
        {"constants": {"pressure": "3 MPa"}},
    ):  # fmt: skip
        with refuses_at(""):
            load(path, **options)
    columns = 'columns = ["force [N]", "pressure [kPa]"]\n'
    path.with_suffix(".toml").write_text(columns + 'strain = 0.1\nrows = "2:"\n')
    path.write_text(text.partition("\n")[2])
    record = load(path)
    assert_allclose(record.strain, 0.1)
    assert record.force.tolist() == FORCE[1:]


def test_grams_in_a_name_are_a_weight(tmp_path):
    path = tmp_path / "m=500g.csv"
    path.write_text("P [kPa],x [mm]\n" + table(",", [PRESSURE, CONTRACTION]))
    record = load(path, name_pattern="m={force}g", rest_length=REST)
    assert_allclose(record.force, 4.903325)


def test_files_by_pattern(tmp_path):
    for length in (180, 170):
        for pressure in (100, 200):
            path = tmp_path / f"{length}mm_{pressure}kPa.csv"
            path.write_text(table(",", [TIME, [f + length + pressure for f in FORCE]]))
    how = {"columns": "time,force[N]", "name_pattern": "{length}mm_{pressure}kPa"}
    record = load(str(tmp_path / "*.csv"), rest_length=REST, **how)
    assert len(record) == 16 and len(record.sources) == 4
    assert sorted(set(record.pressure)) == [100e3, 200e3]
    assert_allclose(sorted(set(record.strain)), [0, 10 / 180])
    with refuses_at(f"{tmp_path / '*.txt'}: "):
        load(str(tmp_path / "*.txt"))


def test_channels_at_two_rates_are_refused(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    channels = {"p_kPa": (PRESSURE, 0.1), "F_N": (FORCE, 0.1), "L_mm": (LENGTH, 0.1),
                "T_degC": (FORCE, 0.2), "x_V": (FORCE, 0.2)}  # fmt: skip
    with nptdms.TdmsWriter(tmp_path / "m.tdms") as writer:
        writer.write_segment([
            nptdms.ChannelObject("Log", name, np.array(values), {"wf_increment": step})
            for name, (values, step) in channels.items()
        ])  # fmt: skip
    choices = asked(tmp_path / "m.tdms", rest_length=REST)
    check(load(tmp_path / "m.tdms", rest_length=REST, table=choices[0][2]))


def test_scales_of_gauges_stand_in_the_sidecar(tmp_path):
    columns = [[0.2 + x / 147.5 for x in PRESSURE], [x / 12 for x in FORCE], LENGTH]
    path = tmp_path / "m.csv"
    path.write_text("P_sens [V],F_sens [V],L [mm]\n" + table(",", columns))
    path.with_suffix(".toml").write_text(
        'rest_length = "180 mm"\npressure_at_rest = "0.2 V"\n[scales]\n'
        'pressure = "1.475 bar/V"\nforce = "12 N/V"\n'
    )
    check(load(path), time=False)


def test_thousands_far_below_the_start_are_seen():
    text = "p [kPa];L [mm];F [N]\n" + "200;180;980\n" * 5000 + "200;180;1.180\n200;176;1.050\n"
    choices = asked(text, rest_length=REST)
    assert {choice[::2] for choice in choices} == {("decimal", "."), ("decimal", ",")}


def test_a_mat_file_with_a_bare_matrix_or_a_constant(tmp_path):
    from scipy.io import savemat

    path = tmp_path / "m.mat"
    savemat(path, {"d": np.array([TIME, PRESSURE, FORCE, LENGTH]).T})
    check(load(path, rest_length=REST, columns="time[s],pressure[kPa],force[N],length[mm]"))
    savemat(path, {"force_N": FORCE, "pressure_kPa": PRESSURE, "length_mm": 171.0})
    assert_allclose(load(path, rest_length=REST).strain, 0.05)
    named = {"force_N": FORCE, "pressure_kPa": PRESSURE, "length_mm": LENGTH}
    savemat(path, named)
    check(load(path, rest_length=REST), time=False)
    matrix = np.array([PRESSURE, FORCE, LENGTH]).T
    two = {"up": matrix, "down": matrix}
    for refused in ({"rec": named}, {"log": {"Y": [{"Name": "p", "Data": PRESSURE}]}},
                    named | {"force_N": FORCE[1:]}, two):  # fmt: skip
        savemat(path, refused)
        with refuses_at(f"{path}: "):
            load(path, rest_length=REST)
    columns = "pressure[kPa],force[N],length[mm]"
    check(load(path, rest_length=REST, table="down", columns=columns), time=False)


def test_cells_that_excel_shows_in_percent(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    strain = np.array(CONTRACTION) / 180
    percent = [("strain [%]", 1, "0.0%"), ("strain", 1, "0.0%"), ("strain [%]", 100, "General")]
    for header, factor, form in percent:
        book = openpyxl.Workbook()
        rows = [[header, "p [kPa]", "F [N]"], *zip(strain * factor, PRESSURE, FORCE, strict=True)]
        for row in rows:
            book.active.append(list(row))
        for cell in book.active["A"]:
            cell.number_format = form
        book.save(tmp_path / "m.xlsx")
        check(load(tmp_path / "m.xlsx"), time=False)


def test_xlsx_files(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "Info"
    book.active.append(["made by", "a bench"])
    sheet = book.create_sheet("Data")
    for row in (["Tensile test"], [], ["Operator", "K. Müller"], ["Gauges", None, "Frame", None],
                ["Time\n[s]", "Pressure", "Force", "Length", "Remark"], ["s", "kPa", "N", "mm"],
                *ROWS, ["Mean", 200.1, 83.3, 174.0]):  # fmt: skip
        sheet.append(list(row))
    for cells in ("A1:D1", "A4:B4", "C4:D4"):
        sheet.merge_cells(cells)
    path = tmp_path / "m.xlsx"
    book.save(path)
    check(load(path, rest_length=REST))
    book.copy_worksheet(sheet).title = "Data 2"
    book.save(path)
    assert asked(path, rest_length=REST)[0][::2] == ("table", "Data")
    check(load(path, rest_length=REST, table="data 2"))


@pytest.mark.parametrize(
    "start", [b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", b"\x89HDF\r\n\x1a\n", b"\x1f\x8b", b"%PDF-1.4",
              b"PK\3\4broken", b"TDSmbroken", b"MATLAB 5.0 broken"],
)  # fmt: skip
def test_binary_files_that_cannot_be_read(tmp_path, start):
    path = tmp_path / "m.bin"
    path.write_bytes(start + bytes(200))
    with refuses_at(f"{path}: "):
        load(path)


def test_a_missing_reader_is_named(tmp_path, monkeypatch):
    path = tmp_path / "m.bin"
    path.write_bytes(b"PK\3\4" + bytes(200))
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(MissingExtraError) as error:
        load(path)
    assert error.value.name == "openpyxl"


def test_isometric_and_isotonic_records_have_runs():
    P = np.r_[np.linspace(0, 400, 30), np.linspace(400, 0, 30)]
    length, p = (x.ravel() for x in np.meshgrid([180, 170, 160], P, indexing="ij"))
    isometric = table(",", [p + 0.1, length, 0.3 * p * (length - 150) / 30], "p [kPa],L [mm],F [N]")
    found = runs(loads(isometric, rest_length=REST))
    assert [(run.kind, run.branch) for run in found] == [("strain", 1), ("strain", -1)] * 3
    mass, p = (x.ravel() for x in np.meshgrid([200, 500], P, indexing="ij"))
    isotonic = table(",", [p, mass, 180 - p / 8 + mass / 100], "p [kPa],load [gf],L [mm]")
    found = runs(loads(isotonic, rest_length=REST))
    assert [(run.kind, run.branch) for run in found] == [("force", 1), ("force", -1)] * 2
    assert found[0].level == pytest.approx(0.2 * 9.80665)


def test_groups_that_state_pressures_are_one_record(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "run_180mm.tdms"
    with nptdms.TdmsWriter(path) as writer:
        for P in (100, 200):
            writer.write_segment([
                nptdms.ChannelObject(f"P={P}kPa", name, np.array(values), {"unit_string": unit})
                for name, values, unit in (
                    ("Force", np.add(FORCE, P), "N"), ("Length", LENGTH, "mm"))
            ])  # fmt: skip
    assert [choice[2] for choice in asked(path, rest_length=REST)] == ["P=100kPa", "*"]
    record = load(path, rest_length=REST, table="*", name_pattern="{pressure}kPa")
    assert_allclose(record.pressure, [1e5] * 4 + [2e5] * 4)
    assert_allclose(record.force, [*np.add(FORCE, 100), *np.add(FORCE, 200)])
    # the pattern may begin in the file's name
    record = load(path, table="P=2*", name_pattern="{rest_length}mm P={pressure}kPa")
    assert (record.rest_length, set(record.pressure)) == (REST, {2e5})
    for wrong in ({"table": "*", "name_pattern": "{pressure}bar"}, {"table": "Q*"}):
        with refuses_at(f"{path}: "):
            load(path, rest_length=REST, **wrong)

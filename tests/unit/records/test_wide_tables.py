"""Tables with columns for each pressure, as digitized figures have them. All data are synthetic."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.records import load, loads, runs
from fascicle.records.columns import MissingMetadataError


STRAIN = [0.0, 5.0, 10.0]  # %
FORCES = {100: [50.0, 25.0, 1.0], 200: [100.0, 60.0, 30.0]}  # N by kPa
SHARED = "0,50,100\n5,25,60\n10,1,30\n"
PAIRS = "0,50,0,100\n5,25,5,60\n10,1,10,30\n"
FORCE = {"units": {"force": "N"}}


def check(record):
    assert_allclose(record.pressure, np.repeat([100e3, 200e3], 3))
    assert_allclose(record.strain, np.tile(STRAIN, 2) / 100)
    assert_allclose(record.force, np.concatenate(list(FORCES.values())))


@pytest.mark.parametrize(
    ("text", "options"),
    [
        # one column for each pressure
        ("strain [%],100 kPa,200 kPa\n" + SHARED, FORCE),
        ("strain [%],P = 1 bar,P = 2 bar\n" + SHARED, FORCE),
        ("strain [%],F @ 1 bar [N],F @ 2 bar [N]\n" + SHARED, {}),
        ("Contraction (%),Force_100kPa_N,Force_200kPa_N\n" + SHARED, {}),
        ("strain [%],100 kPa,0.2 MPa\n" + SHARED, FORCE),
        ("strain,100 kPa,200 kPa\n%,N,N\n" + SHARED, {}),
        ("# synthetic\nFigure 3\n\nstrain [%],100 kPa [N],200 kPa [N]\n" + SHARED, {}),
        ("Pressure [kPa],100,200\nstrain [%],F [N],F [N]\n" + SHARED, {}),
        ("strain [%],F [N],F [N]\nPressure [kPa],100,200\n" + SHARED, {}),
        ("strain [%],100,200\n" + SHARED, {"units": {"force": "N", "pressure": "kPa"}}),
        ("Strain [%],Force at pressure [N],\n,100 kPa,200 kPa\n" + SHARED, {}),
        ("Contraction (%)\tPressure (kPa)\t\n\t100\t200\n" + SHARED.replace(",", "\t"), FORCE),
        ("Dehnung;100 kPa;200 kPa\n" + SHARED.replace(",", ";"),
         {"columns": "strain[%],force[N]"}),
        # pairs, as WebPlotDigitizer writes them
        ("100 kPa,,200 kPa,\nX,Y,X,Y\n" + PAIRS, {"columns": "strain[%],force[N]"}),
        ("100 kPa,,200 kPa,\n" + PAIRS, {"columns": "strain[%],force[N]"}),
        ("100 kPa,100 kPa,200 kPa,200 kPa\nstrain [%],F [N],strain [%],F [N]\n" + PAIRS, {}),
        ("strain_100kPa [%],F_100kPa [N],strain_200kPa [%],F_200kPa [N]\n" + PAIRS, {}),
        ("100 kPa,,,200 kPa,,\nX [%],Y [N],,X [%],Y [N],\n"
         "0,50,,0,100,\n5,25,,5,60,\n10,1,,10,30,\n",
         {"columns": "strain,force"}),
        ("100 kPa,,200 kPa,\nX,Y,X,Y\n" + PAIRS,
         {"columns": {"strain": "X"}, "units": {"strain": "%", "force": "N"}}),
    ],
)  # fmt: skip
def test_wide_tables(text, options):
    record = loads(text, "w.csv", **options)
    check(record)
    assert "w.csv: columns for each pressure read as readings at these pressures" in record.notes
    assert record.synthetic is text.startswith("# synthetic")
    assert [run.kind for run in runs(record)] == ["pressure", "pressure"]


def test_series_of_different_lengths_keep_their_lines():
    text = "100 kPa,,200 kPa,\nX,Y,X,Y\n0,50,0,100\n5,25,5,60\n,,9,3x\n"
    with pytest.raises(ValueError, match="line 5, column `force`: '3x'"):
        loads(text, "w.csv", columns="strain[%],force[N]")
    record = loads(text.replace("3x", "3"), columns="strain[%],force[N]")
    assert_allclose(record.force, [50, 25, 100, 60, 3])
    record = loads(text.replace("9,3x", "9,"), "w.csv", columns="strain[%],force[N]")
    assert len(record) == 4
    assert "w.csv: 1 row with holes left out, the first in line 5" in record.notes


@pytest.mark.parametrize(
    ("text", "choice", "words"),
    [
        ("100 kPa,,200 kPa,\nX,Y,X,Y\n" + PAIRS, ("columns", "", "strain[%],force[N]"),
         "or length[mm] or displacement[mm] instead"),
        ("load [N],100 kPa,200 kPa\n" + SHARED, ("columns", "", "force[N],strain[%]"), "`value`"),
        ("strain [%],100 kPa,200 kPa\n" + SHARED, ("units", "force", "N"), "no unit"),
        ("strain [%],100,200\n" + SHARED, ("units", "pressure", "kPa"), "no unit"),
        ("a,,b,\nX,Y,X,Y\n" + PAIRS, ("constants", "pressure", "200 kPa"),
         "write above each `X` its pressure"),
        ("strain [%],20 psia [N],30 psia [N]\n" + SHARED, ("atmosphere", "", "1.013 bar"),
         "absolute"),
    ],
)  # fmt: skip
def test_a_choice_is_one_line_with_its_options(text, choice, words):
    with pytest.raises(MissingMetadataError, match=words.replace("[", r"\[")) as error:
        loads(text)
    assert error.value.choices[0][:3] == choice
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Pressure (kPa),0.5 kg,1 kg\n100,170,175\n200,160,168\n", "a column for each of `0.5 kg`"),
        ("Pressure (kPa),0%,10%\n100,50,25\n200,90,60\n", "a column for each of `0%`, `10%`"),
        ("Force (N),Pressure (kPa),\nContraction (%),100,200\n" + SHARED, "such as `100 kPa`"),
    ],
)
def test_other_wide_tables_are_refused_with_a_remedy(text, words):
    with pytest.raises(ValueError, match=words):
        loads(text, rest_length=0.18)


def test_deviations_beside_means_are_no_forces():
    text = "strain [%],100 kPa mean [N],100 kPa std [N],200 kPa mean [N],200 kPa std [N]\n"
    check(loads(text + "0,50,2,100,3\n5,25,2,60,3\n10,1,2,30,3\n"))
    unknown = text.replace("mean", "left").replace("std", "right")
    with pytest.raises(MissingMetadataError) as error:
        loads(unknown + "0,50,2,100,3\n5,25,2,60,3\n")
    assert error.value.choices[0][:2] == ("columns", "force")


def test_both_ways_of_loops_at_each_pressure_are_read():
    text = "strain [%],100 kPa up,100 kPa down,200 kPa up,200 kPa down\n"
    record = loads(text + "0,50,49,100,99\n5,25,24,60,59\n", **FORCE)
    assert_allclose(record.force, [50, 25, 49, 24, 100, 60, 99, 59])
    assert_allclose(record.pressure, np.repeat([100e3, 200e3], 4))


def test_pressures_with_different_columns_are_refused():
    with pytest.raises(ValueError, match="line 2: its pressures have 1 to 2 columns"):
        loads("100 kPa,,200 kPa\nX,Y,Y\n0,50,100\n5,25,60\n")


def test_other_tables_stay_as_they_are():
    rest = {"rest_length": 0.2, "constants": {"pressure": "100 kPa"}}
    record = loads("name,F [N],L [mm]\nrun1,50,180\nrun1,40,170\n", **rest)
    assert_allclose(record.force, [50, 40])
    text = "Channels,1,2,4\nt [s],P (0-10 bar) [kPa],F (200 kPa cell) [N],L [mm]\n0,100,50,180\n"
    assert_allclose(loads(text, rest_length=0.2).pressure, 100e3)
    # one pair of a wide table
    text = "100 kPa,,200 kPa,\nX,Y,X,Y\n" + PAIRS
    pair = {"columns": "-,-,strain[%],force[N]", "constants": {"pressure": "200 kPa"}}
    assert_allclose(loads(text, **pair).force, FORCES[200])


def test_columns_for_each_length():
    text = "P [kPa],F at 180 mm [N],F at 170 mm [N]\n0,0,0\n100,50,25\n200,100,60\n"
    record = loads(text, rest_length=0.18)
    assert_allclose(record.strain, np.repeat([0, 10 / 180], 3), atol=1e-12)
    assert_allclose(record.force, [0, 50, 100, 0, 25, 60])
    assert [run.kind for run in runs(record)] == ["strain", "strain"]


def test_a_sheet_with_merged_pressures(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    sheet = book.active
    for row in (["Figure 4, digitized (synthetic)"], [], [None, "100 kPa", None, "200 kPa", None],
                [None, *["Contraction [%]", "Force [N]"] * 2]):  # fmt: skip
        sheet.append(row)
    for x, *forces in zip(STRAIN, *FORCES.values(), strict=True):
        sheet.append([None, x, forces[0], x, forces[1]])
    sheet.merge_cells("B3:C3")
    sheet.merge_cells("D3:E3")
    path = tmp_path / "w.xlsx"
    book.save(path)
    check(load(path))

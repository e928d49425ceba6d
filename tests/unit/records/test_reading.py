import hashlib

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from asked import asked
from fascicle.core.errors import InvalidInputError
from fascicle.records import load, loads
from refusing import refuses, refuses_at, warns


GOOD = """pressure [kPa],length [mm],force [N]
100,300,50.5
100,270,20.25
200,300,120
"""


def refusal(text, **given):
    with refuses_at("m.csv") as caught:
        loads(text, source="m.csv", **given)
    message = str(caught.value)
    assert len(message) < 300
    return message


def same(a, b):
    for name in ("pressure", "strain", "force", "censored", "branch"):
        assert_array_equal(getattr(a, name), getattr(b, name))


def test_a_record_is_in_si_and_in_one_sign():
    record = loads(GOOD, rest_length=0.3)
    assert_array_equal(record.pressure, [100e3, 100e3, 200e3])
    # to the last bit: a millimeter is divided by, and (300 − 270)/300 rounds once
    assert_array_equal(record.strain, [0, (0.3 - 0.27) / 0.3, 0])
    assert_array_equal(record.force, [50.5, 20.25, 120])
    assert (record.rest_length, record.time, record.synthetic) == (0.3, None, False)
    assert not record.censored.any()
    assert not record.branch.any()


@pytest.mark.parametrize(
    "text",
    [
        GOOD.replace(",", ";"), GOOD.replace("\n", "\r\n"), GOOD.replace("\n", "\r"),
        GOOD.replace("\n", "\n\n"), GOOD.removesuffix("\n"), GOOD.replace(",", " , "),
        GOOD + ",,\n,,\n", "# a remark, with a comma\n\n" + GOOD,
        GOOD.replace("\n100,270", "\n# in between\n100,270"), GOOD.replace("50.5", '"50.5"'),
        GOOD.replace("50.5", '50.5,"up, or so"').replace("[N]", "[N],note").replace("25", "25,a")
        .replace("120", '120, "a ""b"""'),
        GOOD.replace("[kPa],length [mm],force [N]", ",length,force\n(kPa),(mm),(N)"),
        GOOD.replace("pressure [kPa]", '"Pressure, kPa"'),
        GOOD.replace(",", ";").replace(".", ","), GOOD.replace(",", "\t").replace(".", ","),
        "pressure [Pa],length [m],force [kN],note [a; b]\n1e5,.3,0.0505,a\n1E+5,27e-2,0.02025,\n"
        "200000.,3.0e-1,0.12,'c'\n",
    ],
)  # fmt: skip
def test_one_record_in_many_spellings(text):
    # kN scale the decimals, which rounds once more
    record, expected = loads(text, rest_length=0.3), loads(GOOD, rest_length=0.3)
    assert_array_equal(record.pressure, expected.pressure)
    np.testing.assert_allclose(record.strain, expected.strain, rtol=0, atol=1e-16)
    np.testing.assert_allclose(record.force, expected.force, rtol=1e-15)


def test_encodings(tmp_path):
    text = "#  µ\n" + GOOD.replace("length", "Länge")
    for encoding in ("utf-8-sig", "utf-16", "latin-1", "utf-8"):
        (tmp_path / "m.csv").write_bytes(text.encode(encoding))
        same(load(tmp_path / "m.csv", rest_length=0.3), loads(GOOD, rest_length=0.3))


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        # cells
        ("20.25", "20.25 N", "line 3, column `force [N]`"),
        ("20.25", "2_0", "line 3, column `force [N]`"),
        ("20.25", "0x14", "line 3, column `force [N]`"),
        ("20.25", "٢", "line 3, column `force [N]`"),
        ("20.25", '"20,25"', "line 3, column `force [N]`"),
        ("20.25", "20,25", "line 3: 4 cells"),
        ("\n200", "\n\n# remark\n200x", "line 6, column `pressure [kPa]`"),
        # whole files
        (GOOD, "", "empty"),
        (GOOD, "# only remarks\n\n", "empty"),
        (GOOD, GOOD.splitlines()[0], "no readings"),
        (GOOD, "\0\1\2", "not a text file"),
        (GOOD, "x" * 200_000, "line 1"),
        (GOOD, GOOD.split("\n", 1)[1], "line 1: no header"),
        # columns and units
        ("pressure [kPa]", "junk", "no column of pressure"),
        ("length [mm]", "force [N]", "column `force [N]`"),
        ("length [mm]", "load [N]", "several columns could be force"),
        ("force [N]", "force", "column `force`: no unit"),
        ("pressure [kPa]", "pressure [N]", "'N'"),
        ("pressure [kPa]", "pressure [psia]", "absolute"),
        # plausibility
        ("[kPa]", "[Pa]", "did you mean kPa?"),
        ("[kPa]", "[bar]", "did you mean kPa?"),
        ("200,", "413700,", "did you mean Pa?"),
        ("200,", "-3,", "line 4, column `pressure [kPa]`"),
        ("[N]", "[kN]", "did you mean N?"),
        ("270", "390", "line 3, column `length [mm]`"),
        ("270", "12", "line 3, column `length [mm]`"),
        ("270", "-1", "line 3, column `length [mm]`"),
        ("[mm]", "[cm]", "line 2, column `length [cm]`"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_refused_in_one_line(old, new, where):
    assert where in refusal(GOOD.replace(old, new, 1), rest_length=0.3)


def test_lengths_need_the_rest_length():
    assert asked(GOOD)[0][0] == "rest_length"
    for wrong in (0.0, -1.0, np.nan, np.inf):
        with refuses("rest_length"):
            loads(GOOD, rest_length=wrong)


def test_percent_is_asked_for():
    text = "pressure [kPa],strain,force [N]\n100,{},50\n200,{},80\n"
    percent, length = asked(text.format(12, 3))
    record = loads(text.format(12, 3), units={percent[1]: percent[2]})
    assert_array_equal(record.strain, [0.12, 0.03])
    given = {"columns": {length[1]: length[2]}, "units": {"displacement": "mm"}}
    assert_array_equal(loads(text.format(12, 3), rest_length=0.1, **given).strain, [0.12, 0.03])
    assert_array_equal(loads(text.format(0.12, 0.03)).strain, [0.12, 0.03])
    assert "0.95" in refusal(text.format(0.95, 0))
    assert "-0.25" in refusal(text.format(-0.25, 0))


def test_displacements_and_what_grows_as_the_muscle_lengthens():
    text = "p [bar],{},F [lbf]\n1,0,10\n1,30,5\n"
    for header, end in (("displacement (mm)", 0.1), ("extension [mm]", -0.1)):
        record = loads(text.format(header), rest_length=0.3)
        assert_array_equal(record.strain, [0, end])


@pytest.mark.parametrize("first", ["0", "-1"])
def test_a_length_that_begins_at_zero_or_below_may_be_a_displacement(first):
    text = f"pressure [kPa],length [mm],force [N]\n100,{first},50\n100,5,20\n"
    assert asked(text, rest_length=0.25)[0] == ("columns", "displacement", "length [mm]")


@pytest.mark.parametrize(
    ("first", "step"),
    [(1709633472000, 50), (1709633472000000, 50000), (1709633472 * 10**9, 5 * 10**7),
     (45356.42444444, 0.05 / 86400), (1709633472, 0.05)],
)  # fmt: skip
def test_dates_that_are_numbers(first, step):
    times = [first + i * step for i in range(4)]
    text = "time,p [kPa],strain,F [N]\n" + "".join(f"{t!r},100,0.1,50\n" for t in times)
    assert np.diff(loads(text).time) == pytest.approx(0.05, rel=1e-3)


def test_a_transducers_noise_around_zero_is_no_suction():
    record = loads(GOOD.replace("100,270", "-1.5,270"), rest_length=0.3)
    assert_array_equal(record.pressure, [100e3, 0, 200e3])
    counts = {finding.code: finding.data.get("count") for finding in record.findings}
    assert counts["record.pressures_below_zero"] == 1


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("2026-03-05 18:00:00", "2026-03-06 09:00:00"), ("05.03.26 18:00:00", "06.03.26 09:00:00"),
        ("2026-03-05T18:00:00.0Z", "2026-03-06T09:00:00.0Z"),
        ("3/15/2026 6:00:00 PM", "3/16/2026 9:00:00 AM"), ("15/3/26 18:00:00", "16/3/26 09:00:00"),
    ],
)  # fmt: skip
def test_dates_of_clock_times_count(first, second):
    text = f"time,p [kPa],strain,F [N]\n{first},100,0,50\n{second},100,0.1,40\n"
    assert loads(text).time.tolist() == [0, 15 * 3600]
    # day and month may be swapped
    swapped = text.replace(first, "3/5/2026 18:00:00").replace(second, "3/6/2026 09:00:00")
    assert loads(swapped).time is None


def test_branches_times_and_clipped_readings():
    text = (
        "time [ms],branch,pressure [kPa],strain [%],force [N],clipped\n"
        "0,inflating,100,0,50,no\n500,UP,100,10,0,Yes\n1000,-1,100,5,30,0\n1500,,100,0,40,false\n"
    )
    record = loads(text)
    assert_array_equal(record.time, [0, 0.5, 1, 1.5])
    assert_array_equal(record.branch, [1, 1, -1, 0])
    assert_array_equal(record.censored, [False, True, False, False])
    strange = text.replace("UP", "sideways")
    assert not loads(strange).branch.any()
    assert "line 3, column `branch`" in refusal(strange, columns={"branch": "branch"})
    assert "column `clipped`" in refusal(text.replace("Yes", "maybe"))


def test_zeros_are_clipped_only_where_that_is_given():
    text = GOOD.replace("20.25", "0")
    for given in (False, True):
        record = loads(text, rest_length=0.3, clipped_at_zero=given)
        assert_array_equal(record.censored, [False, given, False])


def test_columns_and_units_can_be_given():
    text = "A,B,Load cell 2,Load cell 1\n100,300,50,1\n100,270,20,1\n"
    given = {"pressure": "A", "length": "B", "force": "load cell 2"}
    units = {"pressure": "kPa", "length": "mm", "force": "N"}
    record = loads(text, columns=given, units=units, rest_length=0.3)
    assert_array_equal(record.force, [50, 20])
    refusal(text, columns=given | {"force": "Load cell 3"}, units=units)
    for wrong in ({"columns": {"forc": "A"}}, {"units": {"colour": "red"}}):
        with refuses(*wrong):
            loads(text, **wrong)
    # a given unit wins over the header's
    record = loads(GOOD, units={"force": "lbf"}, rest_length=0.3)
    assert record.force[2] == pytest.approx(120 * 4.4482216152605, rel=1e-15)


def test_remarks_of_the_file():
    remarks = "# synthetic: made by a model\n# rest_length = 300 mm\n# source: a paper\n"
    record = loads(remarks + GOOD)
    assert record.synthetic and not loads(GOOD, rest_length=0.3).synthetic
    # what is given wins
    assert record.rest_length == 0.3
    assert loads(remarks + GOOD, rest_length=0.31).rest_length == 0.31
    refusal("# rest_length = 300\n" + GOOD)


def test_several_files_are_one_record(tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text(GOOD)
        (tmp_path / f"{name}.toml").write_text('rest_length = "300 mm"')
    with warns("a.csv", "b.csv"):
        record = load([tmp_path / "a.csv", tmp_path / "b.csv"])
    assert len(record) == 6
    assert [source.name for source in record.sources] == ["a.csv", "b.csv"]
    assert record.sources[0].sha256 == hashlib.sha256(GOOD.encode()).hexdigest()
    with refuses("path"):
        load([])


def test_the_default_length_of_one_file_does_not_hold_for_another(tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text(GOOD)
    assert load(tmp_path / "a.csv", default_length=0.31).rest_length == 0.31
    (tmp_path / "b.toml").write_text('rest_length = "300 mm"')
    with pytest.raises(InvalidInputError) as error:
        load([tmp_path / "a.csv", tmp_path / "b.csv"], default_length=0.31)
    assert error.value.argument == "records"


def test_files_that_cannot_be_read(tmp_path, monkeypatch):
    none = tmp_path / "none.csv"
    for path, place in ((none, none), (tmp_path, tmp_path), ("a\0b.csv", r"'a\x00b.csv'")):
        with refuses_at(f"{place}: "):
            load(path)
    (tmp_path / "m.csv").write_text(GOOD)
    for place, value in (("reading.LARGEST_FILE", 10), ("tables.MAX_ROWS", 2)):
        with monkeypatch.context() as patch:
            patch.setattr(f"fascicle.records.{place}", value)
            with refuses_at(f"{tmp_path / 'm.csv'}: "):
                load(tmp_path / "m.csv", rest_length=0.3)


def test_a_regular_table_and_one_with_a_gap_read_to_the_same_floats():
    rng = np.random.default_rng(4)
    columns = rng.uniform(0, 4e5, 3000), rng.uniform(0, 0.3, 3000), rng.normal(0, 10, 3000)
    rows = np.column_stack(columns)
    text = "pressure [Pa],strain [-],force [N],branch\n" + "".join(
        f"{p!r},{s!r},{f!r},{'up' if f > 0 else 'down'}\n" for p, s, f in rows.tolist()
    )
    regular = loads(text)
    assert_array_equal(regular.pressure, rows[:, 0])
    lines = text.splitlines()
    same(regular, loads("\n".join([*lines[:2000], "", "# a pause", *lines[2000:]])))
    far = text.replace(f"{rows[2700, 1].item()!r},", "0.99,")
    assert "line 2702, column `strain [-]`: 0.99" in refusal(far)
    lines[2500] = lines[2500].replace(",", ",x", 1)
    assert "line 2501, column `strain [-]`" in refusal("\n".join(lines))


_TITLED = """Test bench 3; report
Operator: A; date 12.03.2024
pressure [bar];strain [%];force [N]
1,5;0,5;812,25
1,5;2,5;640,75
"""


def test_title_lines_and_decimal_commas_are_read():
    columns = "pressure [bar];strain [%];force [N]"
    unit_row = _TITLED.replace(columns, "pressure;strain;force\nbar;%;N")
    for text, options in (
        (_TITLED, {}), (_TITLED, {"header": 3}), (_TITLED.replace("\n", "\r\n"), {}), (unit_row, {})
    ):  # fmt: skip
        record = loads(text, **options)
        np.testing.assert_allclose(record.pressure, 1.5e5)
        np.testing.assert_allclose(record.strain, [0.005, 0.025])
        np.testing.assert_allclose(record.force, [812.25, 640.75])
    for line in (2, 99):
        assert f"line {line}" in refusal(_TITLED, header=line)
    assert "line 4: 6 cells" in refusal(_TITLED.replace(";", ","))


OTHERS = [
    ("Time", ("2024-03-05 10:11:12.1", "2024-03-05 10:11:12.2", "x")), ("t [s]", "1-2"),
    ("Time", ("10:11", "10:12", "")), ("Time [hh:mm]", "123"), ("t", ("1", "nan", "3")),
    ("time,elapsed", ("1,1", "2,2", "3,3")), ("Sweep", "123"), ("phase", ("1.0", "2.0", "9")),
]  # fmt: skip


@pytest.mark.parametrize(("header", "cells"), OTHERS)
def test_a_column_that_nothing_needs_does_not_stop_the_reading(header, cells):
    lines = [f"{a},{b}" for a, b in zip((header, *cells), GOOD.splitlines(), strict=True)]
    record = loads("\n".join(lines), source="m.csv", rest_length=0.3)
    same(record, loads(GOOD, rest_length=0.3))
    assert record.time is None
    data = {finding.code: finding.data for finding in record.findings}
    unread = [*data.get("record.unread_columns", {}).get("names", ())]
    if "record.misread_column" in data:  # a column that was taken for it is to check
        unread.append(data["record.misread_column"]["column"])
    assert header.partition(",")[0] in unread


def test_a_time_that_was_asked_for_stops_it():
    lines = zip(("when", "x", "2", "3"), GOOD.splitlines(), strict=True)
    text = "\n".join(",".join(cells) for cells in lines)
    for units in ({}, {"time": "s"}):
        message = refusal(text, rest_length=0.3, columns={"time": "when"}, units=units)
        assert "line 2, column `when`" in message


@pytest.mark.parametrize("cells", [["100", *[""] * 11], ["100", "", ""] * 4])
def test_blanks_of_a_slower_transducer_are_not_filled(cells):
    lines = [f"{cell},{0.01 * i},{50 - i}" for i, cell in enumerate(cells)]
    with refuses_at("<text>, line 3"):
        loads("\n".join(["pressure [kPa],strain [-],force [N]", *lines]))


SWEEP = "".join(f"{p},{p / 2},{180 - p / 20}\n" for p in range(100, 300, 4))  # 50 rows
HEADER = "p [kPa],F [N],L [mm]\n"


def test_a_quote_without_end_loses_no_readings():
    rows = SWEEP.splitlines(keepends=True)
    whole = ('" new level', '"5 inch tube,100,50,170')
    for odd in (*whole, '200,100,170,"a"" ,', '200,100,"170""\n3,"4"'):
        text = HEADER + "".join([*rows[:20], f"{odd}\n", *rows[20:]])
        with refuses_at("<text>"):
            loads(text, rest_length=0.18)


@pytest.mark.parametrize("row", ["99999,50,175", "100,-9999,175", "100,50,-999"])
def test_a_number_that_marks_an_error_is_refused(row):
    with refuses_at("<text>, line 52"):
        loads(f"{HEADER}{SWEEP}{row}\n", rest_length=0.18)


@pytest.mark.parametrize(
    "text",
    ['[{"p_kPa": 1, "F_N": 2}, {"p_kPa": 2, "F_N": 2}]', '{"p_kPa": [1, 2], "F_N": [1, 2]}',
     "\n<html><table><tr><td>p [kPa]</td></tr></table></html>"],
)  # fmt: skip
def test_other_json_and_web_pages_are_refused(text):
    with refuses_at("<text>"):
        loads(text)


def test_one_comma_in_a_remark_is_no_decimal():
    text = f"{HEADER[:-1]},note\n{SWEEP.replace(chr(10), ',' + chr(10))}100,50,175,slipped, again\n"
    with refuses_at("<text>, line 52"):
        loads(text, rest_length=0.18)

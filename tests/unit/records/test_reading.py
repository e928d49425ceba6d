import hashlib

import numpy as np
import pytest
from numpy.testing import assert_array_equal

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


def test_one_comma_in_a_remark_is_no_decimal():
    text = f"{HEADER[:-1]},note\n{SWEEP.replace(chr(10), ',' + chr(10))}100,50,175,slipped, again\n"
    with refuses_at("<text>, line 52"):
        loads(text, rest_length=0.18)

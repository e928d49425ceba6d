"""Further forms of a board's or a program's output, read right or refused with the right remedy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.records import loads


PRESSURE = np.repeat([100e3, 200e3], 6)
STRAIN = np.tile(np.linspace(0, 0.2, 6), 2)
FORCE = 1.2e-3 * PRESSURE * (0.28 - STRAIN)
ROWS = list(zip(PRESSURE, STRAIN, FORCE, strict=True))


def read(text, rtol=1e-3, **options):
    record = loads(text, **options)
    for values, expected in ((record.pressure, PRESSURE), (record.force, FORCE)):
        assert_allclose(values, expected, rtol=rtol)
    assert_allclose(record.strain, STRAIN, atol=1e-4)
    return record


def test_rare_units():
    lines = [f"{p / 9806.65:.6f},{100 * e:.4f},{f / 4448.2216152605:.8f}" for p, e, f in ROWS]
    read("\n".join(["pressure [mH2O],strain [%],force [kip]", *lines]))


@pytest.mark.parametrize("cells", [["100", *[""] * 11], ["100", "", ""] * 4])
def test_blanks_of_a_slower_transducer_are_not_filled(cells):
    lines = [f"{cell},{e:.5f},{f:.4f}" for cell, (_, e, f) in zip(cells, ROWS, strict=True)]
    with pytest.raises(ValueError, match="of 12 rows have"):
        loads("\n".join(["pressure [kPa],strain [-],force [N]", *lines]))


SWEEP = "".join(f"{p},{p / 2},{180 - p / 20}\n" for p in range(100, 300, 4))  # 50 rows
HEADER = "p [kPa],F [N],L [mm]\n"


def test_a_quote_without_end_loses_no_readings():
    rows = SWEEP.splitlines(keepends=True)
    for odd in (
        '" new level',
        '"5 inch tube,100,50,170',
        '200,100,170,"a"" ,',
        '200,100,"170""\n3,"4"',
    ):
        text = HEADER + "".join([*rows[:20], f"{odd}\n", *rows[20:]])
        with pytest.raises(ValueError, match=r"quote|EOF|no finite number"):
            loads(text, rest_length=0.18)


@pytest.mark.parametrize("row", ["99999,50,175", "100,-9999,175", "100,50,-999"])
def test_a_number_that_marks_an_error_is_refused(row):
    with pytest.raises(ValueError, match="line 52"):
        loads(f"{HEADER}{SWEEP}{row}\n", rest_length=0.18)


@pytest.mark.parametrize(
    "text",
    ['[{"p_kPa": 1, "F_N": 2}, {"p_kPa": 2, "F_N": 2}]', '{"p_kPa": [1, 2], "F_N": [1, 2]}',
     "\n<html><table><tr><td>p [kPa]</td></tr></table></html>"],
)  # fmt: skip
def test_other_json_and_web_pages_are_refused(text):
    with pytest.raises(ValueError, match="CSV"):
        loads(text)


def test_clock_units():
    text = "t [hh:mm:ss];p [kPa];F [N];L [mm]\n"
    text += "00:00:59,5;100,5;-2,5;175\n00:01:00,0;99,5;1,5;170\n"
    record = loads(text, rest_length=0.18)
    assert record.time == pytest.approx([0, 0.5])
    assert (record.pressure.tolist(), record.force.tolist()) == ([100.5e3, 99.5e3], [-2.5, 1.5])


def test_one_comma_in_a_remark_is_no_decimal():
    text = f"{HEADER[:-1]},note\n{SWEEP.replace(chr(10), ',' + chr(10))}100,50,175,slipped, again\n"
    with pytest.raises(ValueError, match="header has 4: quote or drop"):
        loads(text, rest_length=0.18)

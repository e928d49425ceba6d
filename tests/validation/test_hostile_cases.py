"""Small files that attack a reader, refused in one line, whatever memory or time they ask for."""

import os

import pytest
from measured import measured

from fascicle.records import load, loads
from fascicle.report.words import record_lines
from refusing import refuses_at


@pytest.mark.parametrize(
    "name",
    ["segfault_184_bytes.mat", "cells_528_bytes.mat", "corner20m.xlsx", "deep.json",
     "header_redos.csv", "surrogate_note.json"],
)  # fmt: skip
def test_a_file_that_attacks_is_refused(name):
    path = measured(f"hostile-cases/{name}")
    with refuses_at(str(path)) as error:
        load(path)
    str(error.value).encode()


def test_a_merged_range_far_below_the_readings_takes_no_memory():
    assert len(load(measured("hostile-cases/merged.xlsx"))) == 12


def test_names_of_columns_are_not_searched_without_a_limit():
    header = f"force_{' _' * 20_000}[N],pressure [kPa],strain"
    with refuses_at("<text>, line 1"):
        loads(f"{header}\n50,100,0\n40,100,0.1\n")


def test_a_name_of_other_bytes_than_utf_8_can_be_written(tmp_path):
    path = os.fsencode(tmp_path) + b"/a\xff.csv"
    try:
        with open(path, "wb") as file:  # noqa: PTH123 no path of text
            file.write(b"force [N],pressure [kPa],strain\n50,100,0\n40,100,0.1\n")
    except OSError:
        pytest.skip("this file system has names in UTF-8 alone")
    record = load(os.fsdecode(path))
    "".join((*record_lines(record), record.sources[0].name)).encode()

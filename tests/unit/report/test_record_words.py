"""Words of what was noticed while a record was read."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

import fascicle
from fascicle.core.findings import Severity
from fascicle.records import Record, loads
from fascicle.records.record import note, warning
from fascicle.report.words import record_doubts, record_lines


SOURCES = Path(fascicle.__file__).parent
CODES = ["rows_with_holes", "rows_of_words"]
for path in (*sorted((SOURCES / "records").glob("*.py")), SOURCES / "calibrate/data.py"):
    CODES += re.findall(r"\b(?:note|warning|_warn)\(\"(\w+)\"", path.read_text("utf-8"))
DATA = {
    "file": "m.csv", "sidecar": "m.toml", "values": {"pressure": 1e5, "rest_length": 0.2},
    "length": 0.2, "names": ["a", "b"], "unit": "N", "role": "moment_arm", "column": "t",
    "count": 1, "line": 4, "step": 0.1, "least": 0.1, "largest": 0.03, "lowest": -0.1,
    "readings": 9, "nearest": "5 mm", "first": "a", "second": "b", "loops": 1, "levels": 2,
    "header": "F", "has_unit": True, "replaced_unit": "kN", "sign": -1, "absolute": True,
}  # fmt: skip


@pytest.mark.parametrize("code", CODES)
def test_each_finding_has_words(code):
    record = Record.of(1e5, [0.1], [2.0], findings=(note(code, **DATA),), notes=("by hand",))
    (line, text), doubts = record_lines(record), record_doubts(record)
    assert line.startswith("m.csv: ") and not re.search(r"[{}]", line)
    assert (text, doubts) == ("by hand", [])
    doubtful = replace(record, findings=(warning(code, **DATA),))
    assert record_doubts(doubtful) == [line]


def test_a_table_s_findings_name_its_file_and_its_columns():
    table = "p [kPa],F [N],x [mm],y\n100,20,0,1\n100,10,20,1\n,5,30,1\n100,-1,40,1\n"
    record = loads(table, source="m.csv", rest_length=0.2)
    columns = {x.data["role"]: x.data["header"] for x in record.findings if "role" in x.data}
    assert columns == {"pressure": "p [kPa]", "force": "F [N]", "displacement": "x [mm]"}
    assert all(x.data["file"] == "m.csv" for x in record.findings)
    codes = {x.code for x in record.findings if x.severity is Severity.WARNING}
    assert codes == {"record.rows_with_holes"}
    assert len(record_lines(record)) == 5

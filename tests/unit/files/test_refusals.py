"""Files of `refusals.toml` are refused at a key, in one line that begins with their name."""

import tomllib
from pathlib import Path

import pytest

from fascicle.files import example_text, loads, loads_scenario
from fascicle.files.measured_muscles import read_entry
from fascicle.files.task import loads_task
from refusing import refuses_at


READ = {"muscle": loads, "scenario": loads_scenario, "task": loads_task, "entry": read_entry}
TABLE = tomllib.loads((Path(__file__).parent / "refusals.toml").read_text(encoding="utf-8"))
CASES = [
    pytest.param(file["kind"], file.get("text") or example_text(file["example"]), case, id=name)
    for name, file in TABLE.items()
    for case in file["refused"]
]


@pytest.mark.parametrize(("kind", "text", "case"), CASES)
def test_a_file_is_refused_at_its_key(kind, text, case):
    for old, new in case.get("replace", []):
        assert old in text
        text = text.replace(old, new, 1)
    with refuses_at("t.toml: ") as error:
        READ[kind](text + case.get("add", ""), "t.toml")
    assert getattr(error.value, "argument", "") == case["at"]


def test_a_text_of_many_brackets_is_refused():
    with refuses_at("t.toml: "):
        loads("x = " + "[" * 5000, "t.toml")

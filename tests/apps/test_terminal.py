"""Texts from files reach the terminal as characters that do nothing to it."""

import io
import json
import re
import sys

import pytest

from fascicle.files import example_text
from small_task import TASK


# turns red, clears the screen, sets the title; the same for terminals of 8 bits; turns the line
EVIL = "\\u001b[31m\\u001b[2J\\u001b]0;x\\u0007\\u009b31m\\u202e\\u0008"
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]")
SIX = "kim2021_figure_6"
DESIGN = TASK.replace("[task]", '[task]\nname = "task EVIL"\nsource = "source EVIL"')


def harmless(fascicle, *command):
    """A command's exit code, and all that it printed, in which nothing controls a terminal."""
    code, out, err = fascicle(*command)
    assert not CONTROL.search(out + err)
    return code, out, err


@pytest.fixture
def written(tmp_path):
    def write(name, text):
        (tmp_path / name).write_text(text.replace("EVIL", EVIL))

    return write


LIFT = example_text("lift_gas").replace("format = 1", 'format = 1\nname = "lift EVIL"')
LIFT = LIFT.replace('"6 s"', '"100 ms"').partition('[[schedule]]\ntime = "1 s"')[0]
WRONG = ['format = 1\n"EVIL" = 1\n[muscle]', '[muscle]\nmaterial = "EVIL"', 'x = "EVIL" y']
COMMANDS = [
    *(("simulate", LIFT, options, 0) for options in ([], ["--json"], ["--csv"])),
    ("simulate", re.sub(r"dt = .*", 'dt = "20 ms"', LIFT), [], 1),
    *(("design", DESIGN, options, 0) for options in (["--out", "made"], ["--json"])),
    ("design", DESIGN.replace("60 N", "9000 N"), [], 3),
    *((command, text, [], 2) for command in ("force", "simulate", "design") for text in WRONG),
]


@pytest.mark.parametrize(("command", "text", "options", "expected"), COMMANDS)
def test_of_a_file(fascicle, written, command, text, options, expected):
    written("a.toml", text)
    code, out, err = harmless(fascicle, command, "a.toml", *options)
    assert code == expected
    if command == "simulate" and "lift" in text and not options:
        assert "x1b[31m" in out + err
    if options == ["--json"]:
        json.loads(out)


@pytest.mark.parametrize("options", [["--out", "made"], ["--json"]])
def test_of_a_record(fascicle, written, tmp_path, options):
    assert fascicle("record", SIX, "-p", "34.5kPa", "--samples", "9", "-o", "d.csv")[0] == 0
    evil = json.loads(f'"{EVIL}"')
    text = (tmp_path / "d.csv").read_text()
    title = f"a title {evil},,\n"
    (tmp_path / "d.csv").write_text(f"# note: a note {evil}\n{title}{text}")
    written("d.toml", 'notes = ["another EVIL"]\nsource = "EVIL"')
    command = ["calibrate", "d.csv", "-m", SIX, "--fit", "c10", "--no-profile", *options]
    code, out, _ = harmless(fascicle, *command)
    assert code == 0
    if options == ["--json"]:  # a program reads what the file says
        assert any("\x1b[31m" in note for note in json.loads(out)["notes"])


def test_of_a_files_own_name(fascicle, tmp_path):
    evil = "m\x1b[31m.toml"
    assert harmless(fascicle, "init", evil)[0] == 0
    assert harmless(fascicle, "force", evil, "-p", "1kPa", "-s", "0")[0] == 0
    assert harmless(fascicle, "force", evil, "-s", "x")[0] == 2
    assert harmless(fascicle, "force", SIX, "-p", "1kPa", "--out", "\x1b[31m.csv")[0] == 0


def test_of_what_is_being_done(monkeypatch):
    """On a terminal, where a line moves by escape sequences of its own."""
    from fascicle.cli.terminal import status

    class Terminal(io.StringIO):
        def isatty(self):
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with status("reading \x1b]0;x\x07 [red]a.csv") as tell:
        tell("now \x1b]0;y\x07 [/]")
    shown = terminal.getvalue()
    assert "\x1b]0" not in shown and "\x07" not in shown
    assert "[red]a.csv" in shown

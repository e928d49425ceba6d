"""Sweeps that are cut off at a file operation, each resumed and begun anew; for its own process.

    python killed_sweep.py FOLDER STEP

The process dies often among the first operations, then at every STEP-th: from there on an audit
hook lets it touch no file under FOLDER, as if it weren't there any more, and its locks are taken
off as the system does. Prints a line for each moment that failed, then how many there were.
"""

import contextlib
import io
import os
import shutil
import sys
from pathlib import Path

from fascicle.cli import main
from fascicle.design.sweep import DATA


TASK = """format = 1
[task]
force = ["60 N", "150 N"]
strain = [0.1, 0.05]
supply_pressure = "413.7 kPa"
[design]
muscle = "kim2021_slenderness_10"
muscles = [2, 3]
[objectives]
mean_efficiency = "max"
[sweep]
block = 4
"""
HANDLES = Path("/proc/self/fd")
FIRST = 20  # operations until the folder is laid out
TOUCHING = {"os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.truncate", "os.chmod"}


class Dead(BaseException):
    """What ends a run, past every handler of exceptions."""


class Killer:
    """An audit hook that counts file operations under a folder, and ends the run at one."""

    def __init__(self, root):
        self.root, self.left = str(root), -1  # operations until the end; -1: never
        self.dead = False

    def __call__(self, event, arguments):
        if self.left < 0 or not (event in TOUCHING or event == "open"):
            return
        path = os.fsdecode(arguments[0]) if isinstance(arguments[0], str | bytes) else ""
        # what is removed in a folder that is open already is named without it
        if not path or (path.startswith(os.sep) and not path.startswith(self.root)):
            return
        if event == "open" and not arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            return
        if self.left == 0:
            self.dead = True
            raise Dead
        self.left -= 1


def run(*options):
    """What the command ends with, and what it says on stderr."""
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            main(["sweep", *options, "--workers", "0"])
        except SystemExit as end:
            return end.code or 0, said.getvalue()
    return 0, said.getvalue()


def killed_at(killer, moment, *options):
    """Whether a run dies at a moment; what it leaves behind is on the disk."""
    handles = set(HANDLES.iterdir())
    killer.left, killer.dead = moment, False
    try:
        run(*options)
    except Dead:
        pass
    finally:
        killer.left = -1
    for handle in set(HANDLES.iterdir()) - handles:
        with contextlib.suppress(OSError):
            if str(handle.readlink()).startswith(killer.root):
                os.close(int(handle.name))
    return killer.dead


def content(folder):
    """Every file of the arrays, and the names of all others that aren't the journal's."""
    arrays = {
        p.relative_to(folder): p.read_bytes() for p in (folder / DATA).rglob("*") if p.is_file()
    }
    return arrays, sorted(entry.name for entry in folder.iterdir())


def fault(task, left, whole):
    """What is wrong with what a killed run has `left`; empty if it goes on both ways."""
    options, backup, faults = (str(task), "--out", str(left)), left.with_name("backup"), []
    was_there = left.exists()
    if was_there:
        left.rename(backup)
    for way in ("resumed", "begun anew"):
        if was_there:
            shutil.copytree(backup, left)
        elif way == "resumed":
            continue
        code, said = run(*options, *(["--resume"] if way == "resumed" else []))
        if "continue with --resume" in said:
            code, said = run(*options, "--resume")
        if code:
            faults.append(f"{way}: {said}")
        elif content(left) != content(whole):
            faults.append(f"{way}: other files, {content(left)[1]}\n")
        shutil.rmtree(left, ignore_errors=True)
    shutil.rmtree(backup, ignore_errors=True)
    return "".join(faults)


def killed(root, step):
    """Kill often at the first operations, then at every `step`-th, until a run gets to its end."""
    os.environ["XDG_STATE_HOME"] = str(root / "state")
    task, whole = root / "task.toml", root / "whole"
    task.write_text(TASK)
    code, said = run(str(task), "--out", str(whole))
    assert code == 0, said
    killer, faults, moment, moments = Killer(root), [], 0, 0
    sys.addaudithook(killer)
    while killed_at(killer, moment, str(task), "--out", str(root / "killed")):
        if wrong := fault(task, root / "killed", whole):
            faults.append(f"{moment}: {wrong}")
        moment, moments = moment + (max(step // 6, 1) if moment < FIRST else step), moments + 1
    sys.stdout.write("".join(faults) + f"{moments} moments, {len(faults)} faults\n")


if __name__ == "__main__":
    killed(Path(sys.argv[1]).resolve(), int(sys.argv[2]))

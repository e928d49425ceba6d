"""How commands end: at Ctrl-C, without streams, out of memory, at a bug; one line, and a code."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest


SIX, PAIR = "kim2021_figure_6", "kim2021_bundle_1_1"
BEGIN = "from fascicle.cli import main\nprint('ready', flush=True)\nmain({arguments!r})"
# stops at the line of standard error that begins so, until a signal comes: however slow or fast a
# machine is, the command is still at work then
HELD = """
import sys, time
write = sys.stderr.write

def held(text):
    write(text)
    if text.startswith({line!r}):
        time.sleep(3600)

sys.stderr.write = held
"""


def started(folder, *arguments, held_at=None):
    """A process that runs a command in `folder`, once it has begun; it stops at the line of
    standard error that begins with `held_at`.
    """
    begin = BEGIN.format(arguments=list(arguments))
    process = subprocess.Popen(
        [sys.executable, "-c", (HELD.format(line=held_at) if held_at else "") + begin],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        start_new_session=True,
        env=os.environ | {"FASCICLE_NO_CACHE": "1"},
    )
    assert process.stdout.readline() == "ready\n"
    return process


def interrupted(process):
    """What a process writes to standard error from Ctrl-C on, which its children hear too."""
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=180)
    return process.returncode, err


def waits(some, more):
    """Moments [s] of a process, each most of a second of work: more of them by `make slow`."""
    return [*some, *(pytest.param(one, marks=pytest.mark.slow) for one in more)]


@pytest.mark.skipif(sys.platform == "win32", reason="has no process groups")
@pytest.mark.parametrize("wait", waits([0.05, 0.8], [0.02, 0.1, 0.2, 0.4, 1.6]))
def test_control_c_is_quiet_from_the_first_moment(tmp_path, wait):
    process = started(tmp_path, "force", SIX, "-o", "x.json")
    time.sleep(wait)
    code, err = interrupted(process)
    assert (code, err) in [(130, ""), (0, "")]
    assert [one.name for one in tmp_path.iterdir()] in ([], ["x.json"])


@pytest.mark.skipif(sys.platform == "win32", reason="has no process groups")
@pytest.mark.parametrize("wait", waits([0.01], [0.0, 0.005, 0.02, 0.05, 0.1]))
def test_control_c_after_the_last_word_changes_nothing(tmp_path, wait):
    process = started(tmp_path, "free-strain", SIX, "-p", "34.5kPa")
    while "34.5" not in process.stdout.readline():
        pass
    time.sleep(wait)  # Python is going down now
    code, err = interrupted(process)
    assert (code, err) in [(130, ""), (0, "")]


TASK = """format = 1
[task]
force = "60 N"
strain = 0.1
supply_pressure = "413.7 kPa"
[design]
muscle = "kim2021_slenderness_10"
muscles = [9]
length = "100 mm:150 mm:10 mm"
[objectives]
mean_efficiency = "max"
[sweep]
block = 16
"""


@pytest.mark.skipif(sys.platform == "win32", reason="has no process groups")
@pytest.mark.parametrize("workers", ["0", pytest.param("2", marks=pytest.mark.slow)])
def test_control_c_in_a_sweep_is_a_line_and_the_sweep_goes_on(tmp_path, workers):
    pytest.importorskip("distributed", reason="needs the extra `sweep`")
    (tmp_path / "task.toml").write_text(TASK)
    process = started(tmp_path, "sweep", "task.toml", "--workers", workers, held_at="10 of 96")
    lines = [process.stderr.readline()]
    while not lines[-1].startswith("10 of 96"):
        lines.append(process.stderr.readline())
        assert lines[-1].strip().endswith("a worker"), lines
    code, err = interrupted(process)
    told = err.splitlines()
    assert code == 130 and told[-1].startswith(
        "interrupted; finished blocks are kept in swept-task"
    )
    assert all(" blocks, " in line for line in told[:-1]), err
    process = started(tmp_path, "sweep", "task.toml", "--workers", "0", "--resume")
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0 and int(err.split(" of ")[0]) >= 10


@pytest.mark.parametrize("error", [ConnectionError("no worker has been there for 60 s"),
                                   OSError(28, "No space left on device", "swept/x")])  # fmt: skip
def test_a_sweep_that_is_stopped_says_how_it_goes_on(fascicle, monkeypatch, tmp_path, error):
    pytest.importorskip("zarr", reason="needs the extra `sweep`")

    def stopped(*_, **__):
        raise error

    (tmp_path / "task.toml").write_text(TASK)
    monkeypatch.setattr("fascicle.design.sweep.sweep", stopped)
    code, out, err = fascicle("sweep", "task.toml", "--workers", "0")
    assert (code, out) == (1 if error.errno is None else 2, "") and err.count("\n") == 1
    assert "finished blocks are kept in swept-task, --resume goes on with them" in err


def closed(*arguments, streams=">&-"):
    command = f'exec "$0" -m fascicle {" ".join(arguments)} {streams}'
    return subprocess.run(
        ["/bin/sh", "-c", command, sys.executable],
        capture_output=True,
        text=True,
        env=os.environ | {"FASCICLE_NO_CACHE": "1"},
    )


@pytest.mark.skipif(not Path("/bin/sh").exists(), reason="needs a shell")
def test_streams_that_are_closed():
    done = closed("muscles", SIX)
    assert done.returncode == 2
    assert done.stderr.startswith("error: standard output") and done.stderr.count("\n") == 1
    # the answer still comes where only the complaints have no place
    assert closed("muscles", SIX, streams="2>&-").stdout.startswith("# ")
    assert closed("muscles", SIX, streams="<&-").returncode == 0
    assert closed("muscles", "nobody", streams=">&- 2>&-").returncode == 2


@pytest.mark.parametrize("platform", ["nobody", "cuda"])
def test_a_device_that_is_not_there_is_one_line(platform):
    done = subprocess.run(
        [sys.executable, "-m", "fascicle", "simulate", "lift_gas"],
        capture_output=True,
        text=True,
        env=os.environ | {"FASCICLE_NO_CACHE": "1", "JAX_PLATFORMS": platform},
    )
    if platform == "cuda" and done.returncode == 0:
        pytest.skip("it is there")
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert f"JAX_PLATFORMS={platform}: JAX finds no such device" in done.stderr


def test_names_of_files_are_shown_as_plainly_as_messages(fascicle, tmp_path):
    code, out, _ = fascicle("init", "a\u202elmot.toml")
    assert (code, out) == (0, "wrote a\\u202elmot.toml\n")
    assert (tmp_path / "a\u202elmot.toml").exists()


def test_a_message_has_an_end(refused, tmp_path):
    (tmp_path / "m.toml").write_text("format = 1\n" + "".join(f"k{i} = 1\n" for i in range(5000)))
    lines = ["force", "x" * 9000], ["force", SIX, "-p", "9" * 9000], ["--" + "x" * 9000]
    for words in (*lines, ["force", "m.toml"], ["force", "a\u202etxt"], ["force", "a\x1b\x00b"]):
        assert len(refused(*words)) < 650  # and printable


def test_more_motor_units_than_fit(refused, tmp_path):
    muscle = """format = 1
[muscle]
length = "127 mm"
outer_radius = "6.35 mm"
wall_thickness = "1.6 mm"
braid_angle = "33 deg"
[bundle]
supply_pressure = "413.7 kPa"
"""
    (tmp_path / "many.toml").write_text(muscle + 990 * "[[bundle.motor_unit]]\n")
    for line in ("bundle many.toml -s 0", "free-strain many.toml", "space many.toml"):
        assert "990 x 990" in refused(line)


@pytest.mark.parametrize("error", [
    MemoryError("Unable to allocate 86.0 GiB for an array with shape (9, 9)"),
    RuntimeError("RESOURCE_EXHAUSTED: Out of memory allocating 92341796864 bytes."),
])  # fmt: skip
def test_memory_that_was_not_foreseen(fascicle, monkeypatch, error):
    def full(*_):
        raise error

    monkeypatch.setattr("fascicle.files.shipped_files.example_text", full)
    code, _, err = fascicle("muscles", SIX)
    assert code == 2 and err.count("\n") == 1
    assert (
        "more memory than there is, "
        + ("86.0 GiB" if isinstance(error, MemoryError) else "92341796864 bytes")
        in err
    )


def test_a_bug_is_one_line_that_says_so_and_can_be_looked_into(fascicle, monkeypatch):
    def broken(*_):
        raise KeyError("x")

    monkeypatch.setattr("fascicle.files.shipped_files.example_text", broken)
    code, _, err = fascicle("muscles", SIX)
    assert code == 70 and err.count("\n") == 1
    assert "KeyError: 'x'. That is a bug in fascicle" in err and "FASCICLE_TRACEBACK=1" in err
    monkeypatch.setenv("FASCICLE_TRACEBACK", "1")
    with pytest.raises(KeyError):
        fascicle("muscles", SIX)

"""How commands end: at Ctrl-C, without streams, out of memory, at a bug; one line, and a code."""

import os
import signal
import subprocess
import sys
import time

import pytest

from small_task import SWEPT


SIX = "kim2021_figure_6"
ENVIRONMENT = os.environ | {"FASCICLE_NO_CACHE": "1"}
# a shell that puts the tests into the background lets them, and their children, ignore Ctrl-C
BEGIN = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from fascicle.cli import main
print('ready', flush=True)
main({arguments!r})
"""
# stops at the line of standard error that begins so, until a signal comes: however slow or fast a
# machine is, the command is still at work then
PAUSE = """
import sys, time
write = sys.stderr.write

def pause(text):
    write(text)
    if text.startswith({line!r}):
        time.sleep(3600)

sys.stderr.write = pause
"""
needs_process_groups = pytest.mark.skipif(sys.platform == "win32", reason="has no process groups")


def start(folder, *arguments, pause_at=None):
    """A process that runs a command in `folder`, once it has begun; it stops at the line of
    standard error that begins with `pause_at`.
    """
    begin = BEGIN.format(arguments=list(arguments))
    process = subprocess.Popen(
        [sys.executable, "-c", (PAUSE.format(line=pause_at) if pause_at else "") + begin],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder,
        start_new_session=True, env=ENVIRONMENT,
    )  # fmt: skip
    assert process.stdout.readline() == "ready\n"
    return process


def interrupt(process):
    """Exit code and standard error of a process, and of its children, after Ctrl-C."""
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=180)
    return process.returncode, err


@needs_process_groups
@pytest.mark.parametrize("moment", [0.05, 0.8])
def test_control_c_is_quiet_from_the_first_moment(tmp_path, moment):
    process = start(tmp_path, "force", SIX, "-o", "x.json")
    time.sleep(moment)
    assert interrupt(process) in [(130, ""), (0, "")]
    assert [path.name for path in tmp_path.iterdir()] in ([], ["x.json"])


@needs_process_groups
@pytest.mark.parametrize("workers", ["0", pytest.param("2", marks=pytest.mark.slow)])
def test_a_sweep_resumes_after_control_c(tmp_path, workers):
    pytest.importorskip("distributed", reason="needs the extra `sweep`")
    (tmp_path / "task.toml").write_text(SWEPT)
    process = start(tmp_path, "sweep", "task.toml", "--workers", workers, pause_at="3 of 12")
    line = process.stderr.readline()
    while not line.startswith("3 of 12"):
        line = process.stderr.readline()
        assert line.endswith(" blocks\n"), line
    code, err = interrupt(process)
    *progress, last = err.splitlines()
    assert code == 130 and last.startswith("interrupted; the finished blocks are in swept-task")
    assert all(line.split()[1:3] == ["of", "12"] for line in progress), err
    process = start(tmp_path, "sweep", "task.toml", "--workers", "0", "--resume")
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0 and int(err.split(" of ")[0]) >= 3


def test_a_closed_pipe_is_quiet():
    command = [sys.executable, "-m", "fascicle", "muscles", SIX]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 1


@pytest.mark.parametrize("platform", ["nobody", "cuda"])
def test_a_missing_device_is_one_line(platform):
    done = subprocess.run(
        [sys.executable, "-m", "fascicle", "simulate", "lift_gas"], capture_output=True, text=True,
        env=ENVIRONMENT | {"JAX_PLATFORMS": platform},
    )  # fmt: skip
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert f"JAX_PLATFORMS={platform}" in done.stderr


def test_a_message_has_an_end(refused, tmp_path):
    (tmp_path / "m.toml").write_text("format = 1\n" + "".join(f"k{i} = 1\n" for i in range(5000)))
    for line in (["force", "x" * 9000], ["force", "m.toml"], ["force", "a\x1b\x00b\u202e"]):
        assert len(refused(*line)) < 650  # and printable


@pytest.mark.parametrize(("error", "expected", "texts"), [
    (KeyboardInterrupt(), 130, []),
    (MemoryError("Unable to allocate 86.0 GiB for an array with shape (9, 9)"), 2, ["86.0 GiB"]),
    (RuntimeError("RESOURCE_EXHAUSTED: Out of memory allocating 92341796864 bytes."), 2,
     ["92341796864 bytes"]),
    (KeyError("x"), 70, ["KeyError: 'x'", "bug in fascicle", "FASCICLE_TRACEBACK=1"]),
])  # fmt: skip
def test_an_unforeseen_error_is_one_line(fascicle, monkeypatch, error, expected, texts):
    def fail(*_):
        raise error

    monkeypatch.setattr("fascicle.files.example_text", fail)
    code, out, err = fascicle("muscles", SIX)
    assert (code, out, err.count("\n")) == (expected, "", bool(texts))
    assert all(text in err for text in texts)
    if isinstance(error, KeyError):
        monkeypatch.setenv("FASCICLE_TRACEBACK", "1")
        with pytest.raises(KeyError):
            fascicle("muscles", SIX)

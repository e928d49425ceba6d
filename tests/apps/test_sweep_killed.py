"""A sweep that is killed at any moment goes on, or begins anew, and ends as one that wasn't."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest


pytest.importorskip("zarr", reason="needs the extra `sweep`")
pytestmark = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")

SCRIPT = Path(__file__).parent / "killed_sweep.py"
LONGEST = 600.0  # s; a machine that is busy with other things takes many times what it needs


@pytest.mark.parametrize("step", [25, pytest.param(1, marks=pytest.mark.slow)])
def test_killed_at_each_file_operation(tmp_path, step):
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(tmp_path), str(step)],
        capture_output=True, text=True, timeout=LONGEST * 5 / step**0.5,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    *faults, last = done.stdout.splitlines()
    moments = int(last.split()[0])
    assert moments > 5 and not faults, done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_killed_by_the_system(tmp_path, seed):
    """At a time by chance after its folder is there, and again as it goes on."""
    sys.path.insert(0, str(SCRIPT.parent))
    from killed_sweep import TASK

    (tmp_path / "task.toml").write_text(TASK)
    folder, chance = tmp_path / "swept-task", random.Random(seed)
    command = [sys.executable, "-m", "fascicle", "sweep", "task.toml", "--workers", "0"]
    environment = {**os.environ, "XDG_STATE_HOME": str(tmp_path / "state")}
    for options in ([], ["--resume"]):
        run = subprocess.Popen(
            [*command, *options], cwd=tmp_path, env=environment,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        until = time.monotonic() + LONGEST
        while not folder.exists() and run.poll() is None and time.monotonic() < until:
            time.sleep(0.001)
        time.sleep(chance.choice([0.0, 0.01, 0.1, 0.5]) * chance.random())
        run.send_signal(signal.SIGKILL)
        assert run.wait(LONGEST) in (-signal.SIGKILL, 0)
    done = subprocess.run(
        [*command, "--resume"], cwd=tmp_path, env=environment, capture_output=True, text=True,
        timeout=LONGEST,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads((folder / "manifest.json").read_text())["blocks"] == 2
    assert sorted(path.name for path in folder.iterdir()) == [
        "designs.zarr", "finished.jsonl", "front.nc", "manifest.json",
    ]  # fmt: skip

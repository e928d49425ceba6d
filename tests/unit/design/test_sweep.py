"""A sweep that is stopped or killed ends with the bits of one that wasn't."""

import os
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

from fascicle.design import Space, Study, Task, evaluate
from fascicle.design.sweep import (
    DATA,
    check_scheduler,
    missing_blocks,
    open_client,
    open_folder,
    sweep,
)
from refusing import refuses
from small_task import SWEPT


zarr = pytest.importorskip("zarr", reason="needs the extra `sweep`")
pytest.importorskip("distributed", reason="needs the extra `sweep`")

NAMES = ("mean_efficiency", "valves")


def study_of(muscle, task, block=16, lengths=(0.1, 0.12, 0.14)):
    return Study(Space({"m": muscle}, (6,), length=lengths), task, NAMES, block)


@pytest.fixture(scope="module")
def study(muscle, task):
    return study_of(muscle, task)


@pytest.fixture(scope="module")
def whole(study, tmp_path_factory):
    """Array of a sweep that wasn't stopped."""
    path = open_folder(tmp_path_factory.mktemp("sweep") / "whole", study)
    sweep(study, path)
    return path


def files(path):
    """Every file of an array, as bytes."""
    return {file.relative_to(path): file.read_bytes() for file in path.rglob("*") if file.is_file()}


def test_blocks_equal_a_single_evaluation(study, whole):
    assert study.blocks == 6 and len(study.space) == 96 and missing_blocks(whole, study) == []
    values = evaluate(study.space.at(np.arange(96)), study.task, NAMES)
    array = zarr.open_array(whole, mode="r")
    assert array.attrs["objectives"] == list(NAMES) and array.attrs["units"] == ["-", "-"]
    for column, name in zip(array[:].T, NAMES, strict=True):
        # rounding of other batches
        np.testing.assert_allclose(column, values[name], rtol=1e-12)


def test_stopped_at_a_block_and_resumed(study, whole, tmp_path):
    class Stopped(Exception):  # noqa: N818 as Ctrl-C is
        pass

    def stop(done, _):
        if done == 2:
            raise Stopped

    path = open_folder(tmp_path / "stopped", study)
    with pytest.raises(Stopped):
        sweep(study, path, watch=stop)
    # as killed writers leave them: a file under another name, and one that isn't whole
    (path / "c" / "3").mkdir()
    (path / "c" / "3" / "0.0123.partial").write_bytes(b"half")
    (path / "c" / "0" / "0").write_bytes(b"half")
    reports = []
    assert open_folder(tmp_path / "stopped", study, resume=True) == path
    sweep(study, path, watch=lambda *report: reports.append(report))
    assert reports[0] == (1, 6) and reports[-1] == (6, 6)
    assert files(path) == files(whole)


def test_results_of_another_study_stay_unchanged(muscle, task, study, whole):
    before = files(whole)
    other_task = Task.of(task.force, task.strain, 400e3, task.weight)
    for other in (study_of(muscle, task, 8), study_of(muscle, other_task)):
        with refuses("folder"):
            open_folder(whole.parent, other, resume=True)
    with refuses("folder"):
        open_folder(whole.parent, study)
    assert files(whole) == before


def test_a_folder_with_other_content_is_refused(study, tmp_path):
    with refuses("folder"):
        open_folder(tmp_path / "new", study, resume=True)
    (tmp_path / "thesis.txt").write_text("kept")
    (tmp_path / DATA).mkdir()
    for resume in (False, True):
        with refuses("folder"):
            open_folder(tmp_path, study, resume)
    (tmp_path / "thesis.txt").unlink()
    (tmp_path / DATA / "zarr.json").write_text("[" * 100_000)
    with refuses("folder"):
        open_folder(tmp_path, study, resume=True)
    (tmp_path / DATA / "zarr.json").unlink()
    os.mkfifo(tmp_path / DATA / "zarr.json")
    with pytest.raises(OSError, match=DATA):
        open_folder(tmp_path, study, resume=True)


@pytest.mark.parametrize("address", ["", "tcp://", "ws://localhost:80", "tcp://localhost:99999"])
def test_an_impossible_scheduler_is_one_line(address):
    with refuses("scheduler"):
        check_scheduler(address)


def test_a_port_that_never_answers_is_no_scheduler(monkeypatch):
    monkeypatch.setattr("fascicle.design.sweep._CONNECTION_TIME", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with refuses("scheduler"):
            check_scheduler(address)


def running_workers(process):
    """The worker processes of a command."""
    psutil = pytest.importorskip("psutil")
    children = psutil.Process(process.pid).children(recursive=True)
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


def wait_for_block(process, array):
    """Wait until a command has written one more block."""
    count = len(list(array.glob("c/*/0")))
    until = time.monotonic() + 300  # a busy machine takes many times what it needs
    while len(list(array.glob("c/*/0"))) <= count and process.poll() is None:
        assert time.monotonic() < until
        time.sleep(0.01)


@pytest.mark.slow
def test_two_workers_killed_and_everything_killed_twice(tmp_path):
    (tmp_path / "task.toml").write_text(SWEPT.replace("= 16", "= 4"))
    command = [sys.executable, "-m", "fascicle", "sweep", "task.toml", "--overwrite"]
    subprocess.run([*command, "--workers", "0", "-o", "whole"], cwd=tmp_path, check=True)
    folder, array = tmp_path / "killed", tmp_path / "killed" / DATA
    command += ["--workers", "2", "-o", "killed"]
    for options in ([], ["--resume"]):
        process = subprocess.Popen([*command, *options], cwd=tmp_path, start_new_session=True)
        wait_for_block(process, array)
        for worker in running_workers(process)[:2]:
            worker.kill()
        wait_for_block(process, array)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait(300)
    subprocess.run([*command, "--resume"], cwd=tmp_path, check=True)
    assert files(array) == files(tmp_path / "whole" / DATA)
    assert sorted(entry.name for entry in folder.iterdir()) == [DATA, "front.nc"]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_local_scheduler_refuses_other_clients(tmp_path):
    with open_client(None, 1) as client:
        address = client.scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        for stranger in (address, address.replace("tls", "tcp")):
            # in a process of its own, as a client that gets no answer leaves itself behind
            knock = f"import distributed; distributed.Client({stranger!r}, timeout=3)"
            command = [sys.executable, "-W", "ignore", "-c", knock]
            result = subprocess.run(command, capture_output=True, text=True, timeout=120)
            assert result.returncode == 1

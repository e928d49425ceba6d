"""A sweep that is stopped, killed or torn ends with the bits of one that wasn't."""

import os
import signal
import socket
import subprocess
import sys

import numpy as np
import pytest

from fascicle.design import Space, Task
from fascicle.design.cluster import local, remote
from fascicle.design.store import DATA, JOURNAL, MANIFEST, Store
from fascicle.design.study import Study
from fascicle.design.sweep import run_block, sweep


zarr = pytest.importorskip("zarr", reason="needs the extra `sweep`")

SENSES = {"mean_efficiency": "max", "valves": "min"}


def study_of(muscle, task, block=16, lengths=(0.1, 0.12, 0.14)):
    return Study.of(Space({"m": muscle}, (6,), length=lengths), task, SENSES, block=block)


@pytest.fixture(scope="module")
def study(muscle, task):
    return study_of(muscle, task)


@pytest.fixture(scope="module")
def undisturbed(study, tmp_path_factory):
    return sweep(study, tmp_path_factory.mktemp("sweep") / "whole")


def chunks(folder):
    """Every file of the store, as bytes."""
    root = folder / DATA
    return {path.relative_to(root): path.read_bytes() for path in root.rglob("*") if path.is_file()}


def test_blocks_make_the_whole(study, undisturbed):
    assert study.blocks == 6 and len(study.space) == 96
    values = undisturbed.all()
    whole = Study.values(study_of(study.space.drawings["m"], study.task, block=96), 0)
    for name, one in whole.items():
        np.testing.assert_allclose(values[name], one, rtol=1e-12)
    assert undisturbed.finished() == set(range(6))


def test_stopped_at_any_block_and_resumed(study, undisturbed, tmp_path):
    class Stopped(Exception):  # noqa: N818 as Ctrl-C is
        pass

    def stop(progress):
        if progress.designs:
            raise Stopped

    folder = tmp_path / "stopped"
    with pytest.raises(Stopped):
        sweep(study, folder, watch=stop)
    told = []
    sweep(study, folder, resume=True, watch=told.append)
    # what was done isn't done again
    assert told[0].done == 1 and told[-1].done == 6 and told[-1].designs == 80
    assert chunks(folder) == chunks(undisturbed.folder)


def test_a_torn_line_and_a_torn_chunk_are_computed_again(study, undisturbed, tmp_path):
    folder = tmp_path / "torn"
    store = sweep(study, folder)
    journal = folder / JOURNAL
    journal.write_text(journal.read_text()[:-20])
    chunk = next(path for path in sorted((folder / DATA / "valves").rglob("2")) if path.is_file())
    chunk.write_bytes(b"\0" * len(chunk.read_bytes()))
    assert store.finished() == set(range(6)) - {2, 5}
    sweep(study, folder, resume=True)
    assert chunks(folder) == chunks(undisturbed.folder)
    assert store.finished() == set(range(6))


def test_another_studys_results_are_left_alone(muscle, task, study, undisturbed):
    before = chunks(undisturbed.folder)
    for other in (study_of(muscle, task, lengths=(0.1, 0.12, 0.15)), study_of(muscle, task, 8)):
        assert other.digest != study.digest
        with pytest.raises(ValueError, match="another study's results; nothing was changed"):
            sweep(other, undisturbed.folder, resume=True)
        with pytest.raises(ValueError, match="holds a sweep already; another study's"):
            sweep(other, undisturbed.folder)
    with pytest.raises(ValueError, match="--resume goes on"):
        sweep(study, undisturbed.folder)
    assert chunks(undisturbed.folder) == before


def test_a_folder_of_something_else(study, tmp_path):
    (tmp_path / "thesis.txt").write_text("kept")
    with pytest.raises(ValueError, match="no sweep of ours"):
        sweep(study, tmp_path)
    with pytest.raises(ValueError, match="no sweep to resume"):
        sweep(study, tmp_path, resume=True)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


def test_the_digest_tells_what_makes_the_numbers(muscle, task, study):
    assert study_of(muscle, task).digest == study.digest
    other = Task.of(task.force, task.strain, 400e3, task.weight)
    assert study_of(muscle, other).digest != study.digest


def test_a_manifest_and_units(undisturbed):
    import json

    manifest = json.loads((undisturbed.folder / MANIFEST).read_text())
    assert manifest["designs"] == 96 and manifest["block"] == 16
    group = zarr.open_group(str(undisturbed.folder / DATA), mode="r")
    assert dict(group["mean_efficiency"].attrs)["units"] == "1"
    assert group["mean_efficiency"].chunks == (16,)


def test_a_full_disk_keeps_what_is_done(study, undisturbed, tmp_path, monkeypatch):
    import errno

    write, folder = Store.write, tmp_path / "full"

    def full(self, block, values):
        if block == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(self, block, values)

    monkeypatch.setattr(Store, "write", full)
    with pytest.raises(OSError, match="No space left"):
        sweep(study, folder)
    monkeypatch.setattr(Store, "write", write)
    # as a writer leaves it that is killed before the chunk is moved to its place
    (folder / "designs.zarr" / study.names[0] / "c" / "1.0123.partial").write_bytes(b"half")
    told = []
    sweep(study, folder, resume=True, watch=told.append)
    assert told[0].done == 2
    assert chunks(folder) == chunks(undisturbed.folder)


# dask's own threads and sockets, cut off by the kills, warn as they go
@pytest.mark.filterwarnings("ignore")
def test_killed_workers(muscle, task, tmp_path):
    pytest.importorskip("distributed", reason="needs the extra `sweep`")
    study = study_of(muscle, task, block=4)
    whole = sweep(study, tmp_path / "alone")
    generator = np.random.default_rng(3)
    killed = []

    def kill(progress):
        # the process that has just finished a block is at its next one
        if progress.last is not None and len(killed) < 3 and generator.integers(4) == 0:
            killed.append(progress.last.process)
            os.kill(progress.last.process, signal.SIGKILL)

    with local(2) as client:
        store = sweep(study, tmp_path / "killed", client, watch=kill)
    assert killed and os.getpid() not in killed
    assert chunks(store.folder) == chunks(whole.folder)
    assert store.finished() == set(range(24))


def test_a_block_tells_what_it_took(study, tmp_path):
    import pickle

    Store.created(tmp_path / "one", study)
    done = run_block(pickle.dumps(study), str(tmp_path / "one"), 3)
    assert done.block == 3 and done.process == os.getpid() and done.memory > 2**20


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_killed_scheduler(muscle, task, tmp_path):
    pytest.importorskip("distributed", reason="needs the extra `sweep`")
    study = study_of(muscle, task, block=4)
    whole = sweep(study, tmp_path / "alone")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    dask = [sys.executable, "-m"]
    head = [*dask, "distributed.cli.dask_scheduler", "--host", address, "--no-dashboard"]
    hand = [*dask, "distributed.cli.dask_worker", address, "--nworkers", "1", "--no-dashboard"]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(head, **silent) as scheduler, subprocess.Popen(hand, **silent) as worker:

        def kill(progress):
            if progress.done == 5:
                scheduler.kill()

        try:
            with remote(address) as client:
                client.wait_for_workers(1, timeout=60)
                with pytest.raises(ConnectionError, match="is lost"):
                    sweep(study, tmp_path / "lost", client, watch=kill)
        finally:
            scheduler.kill()
            worker.terminate()
    told = []
    store = sweep(study, tmp_path / "lost", resume=True, watch=told.append)
    assert told[0].done >= 5
    assert chunks(store.folder) == chunks(whole.folder)

"""A sweep that is stopped, killed or torn ends with the bits of one that wasn't."""

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request

import numpy as np
import pytest

from fascicle.design import Space, Task
from fascicle.design.cluster import local_client, scheduler_client
from fascicle.design.sweep import DATA, JOURNAL, MANIFEST, Store, Study, run_block, sweep


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


def test_blocks_equal_a_single_evaluation(study, undisturbed):
    assert study.blocks == 6 and len(study.space) == 96
    values = undisturbed.all()
    whole = Study.values(study_of(study.space.drawings["m"], study.task, block=96), 0)
    for name, column in whole.items():
        np.testing.assert_allclose(values[name], column, rtol=1e-12)
    assert undisturbed.finished() == set(range(6))


def test_searches_and_sweeps_load_no_jax(tmp_path):
    """So that a first design, and each worker, starts fast."""
    code = """
import sys, pathlib, fascicle as fs
from fascicle.design import Space, Study, Task, Uncertainty, evolve, judge_safety, search
from fascicle.design.sweep import sweep
space = Space({"m": fs.example("kim2021_figure_6")}, (2, 3))
task = Task.of([60.0], [0.1], 413.7e3)
judge_safety(search(space, task), Uncertainty(draws=20))
evolve(space, task, {"valves": "min"}, population=4, generations=1)
sweep(Study.of(space, task, {"valves": "min"}), pathlib.Path(sys.argv[1]))
assert "jax" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "sweep")], check=True)


def test_stopped_at_any_block_and_resumed(study, undisturbed, tmp_path):
    class Stopped(Exception):  # noqa: N818 as Ctrl-C is
        pass

    def stop(progress):
        if progress.designs:
            raise Stopped

    folder = tmp_path / "stopped"
    with pytest.raises(Stopped):
        sweep(study, folder, watch=stop)
    progress_reports = []
    sweep(study, folder, resume=True, watch=progress_reports.append)
    # what was done isn't done again
    assert (
        progress_reports[0].done == 1
        and progress_reports[-1].done == 6
        and progress_reports[-1].designs == 80
    )
    assert chunks(folder) == chunks(undisturbed.folder)


def test_torn_line_and_torn_chunk_are_recomputed(study, undisturbed, tmp_path):
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


def emptied(root):
    (root / "valves" / "c" / "2").write_bytes(b"")


def cut(root):
    chunk = root / "valves" / "c" / "2"
    chunk.write_bytes(chunk.read_bytes()[:-3])


def folder_instead(root):
    (root / "valves" / "c" / "2").unlink()
    (root / "valves" / "c" / "2").mkdir()
    (root / "valves" / "c" / "2").rmdir()


def no_array(root):
    shutil.rmtree(root / "valves")


def no_description(root):
    (root / "valves" / "zarr.json").unlink()


def broken_description(root):
    (root / "valves" / "zarr.json").write_text('{"zarr_format": 3, "node_type"')


def another_description(root):
    path = root / "valves" / "zarr.json"
    path.write_text(path.read_text().replace("float64", "int16"))


def nested_description(root):
    (root / "zarr.json").write_text("[" * 100_000)


def odd_journal(root):
    journal = root.parent / JOURNAL
    lines = journal.read_text().splitlines()
    odd = ['{"block": Infinity, "bits": "x"}', '{"block": 1e999, "bits": "x"}', "[" * 100_000,
           '{"block": -1, "bits": "x"}', '{"block": 99, "bits": "x"}', '{"block": null}', "null",
           '{"block": true, "bits": "x"}', '{"block": 3, "bits": NaN}', "\udc80"]  # fmt: skip
    raw = "\n".join([*odd, *lines]).encode("utf-8", "surrogateescape")
    journal.write_bytes(raw)


def no_manifest(root):
    (root.parent / MANIFEST).unlink()


def broken_manifest(root):
    (root.parent / MANIFEST).write_bytes(b"\xff{")


@pytest.mark.parametrize(
    ("damage", "again"),
    [(emptied, 1), (cut, 1), (folder_instead, 1), (no_array, 6), (no_description, 0),
     (broken_description, 0), (another_description, 0), (nested_description, 0), (odd_journal, 0),
     (no_manifest, 0), (broken_manifest, 0)],
    ids=lambda case: getattr(case, "__name__", ""),
)  # fmt: skip
def test_crashed_sweep_resumes(study, undisturbed, tmp_path, damage, again):
    """What can't be read counts as not done, and no more than that is done again."""
    folder = tmp_path / "crashed"
    shutil.copytree(undisturbed.folder, folder)
    damage(folder / DATA)
    progress_reports = []
    sweep(study, folder, resume=True, watch=progress_reports.append)
    assert progress_reports[0].done == 6 - again
    assert chunks(folder) == chunks(undisturbed.folder)
    assert json.loads((folder / MANIFEST).read_text())["study"] == study.digest


def test_results_of_an_unknown_study_are_refused(study, undisturbed, tmp_path):
    folder = tmp_path / "crashed"
    shutil.copytree(undisturbed.folder, folder)
    no_manifest(folder / DATA)
    nested_description(folder / DATA)
    with pytest.raises(ValueError, match="can't read the study of these results"):
        sweep(study, folder, resume=True)


def test_sweep_of_an_older_version_names_that_version(study, undisturbed, tmp_path):
    folder = tmp_path / "older"
    shutil.copytree(undisturbed.folder, folder)
    manifest = json.loads((folder / MANIFEST).read_text())
    progress_reports = manifest | {"fascicle": "0.0.9", "study": "0" * 64}
    (folder / MANIFEST).write_text(json.dumps(progress_reports))
    with pytest.raises(ValueError, match=r"go on with fascicle 0\.0\.9, which began it"):
        sweep(study, folder, resume=True)


def test_results_of_another_study_stay_unchanged(muscle, task, study, undisturbed):
    before = chunks(undisturbed.folder)
    for other in (study_of(muscle, task, lengths=(0.1, 0.12, 0.15)), study_of(muscle, task, 8)):
        assert other.digest != study.digest
        with pytest.raises(ValueError, match="another study's results; nothing was changed"):
            sweep(other, undisturbed.folder, resume=True)
        with pytest.raises(ValueError, match="holds a sweep already; another study's"):
            sweep(other, undisturbed.folder)
    with pytest.raises(ValueError, match="continue with --resume"):
        sweep(study, undisturbed.folder)
    assert chunks(undisturbed.folder) == before


def test_folder_with_other_files_is_refused(study, tmp_path):
    (tmp_path / "thesis.txt").write_text("kept")
    with pytest.raises(ValueError, match="exists and is no sweep"):
        sweep(study, tmp_path)
    with pytest.raises(ValueError, match="no sweep to resume"):
        sweep(study, tmp_path, resume=True)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


def test_digest_depends_on_the_numbers(muscle, task, study):
    assert study_of(muscle, task).digest == study.digest
    other = Task.of(task.force, task.strain, 400e3, task.weight)
    assert study_of(muscle, other).digest != study.digest


def test_manifest_and_units(undisturbed):
    manifest = json.loads((undisturbed.folder / MANIFEST).read_text())
    assert manifest["designs"] == 96 and manifest["block"] == 16
    group = zarr.open_group(str(undisturbed.folder / DATA), mode="r")
    assert dict(group["mean_efficiency"].attrs)["units"] == "1"
    assert group["mean_efficiency"].chunks == (16,)


def test_full_disk_keeps_finished_blocks(study, undisturbed, tmp_path, monkeypatch):
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
    progress_reports = []
    sweep(study, folder, resume=True, watch=progress_reports.append)
    assert progress_reports[0].done == 2
    assert chunks(folder) == chunks(undisturbed.folder)


# dask's own threads and sockets, cut off by the kills, warn as they go
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_killed_workers(muscle, task, tmp_path):
    pytest.importorskip("distributed", reason="needs the extra `sweep`")
    study = study_of(muscle, task, block=4)
    whole = sweep(study, tmp_path / "alone")
    generator = np.random.default_rng(3)
    killed = []

    def kill(progress):
        # the process that has just finished a block is at its next one; one killed before this
        # block was reported is gone already
        if progress.last is not None and len(killed) < 3 and generator.integers(4) == 0:
            with contextlib.suppress(ProcessLookupError):
                os.kill(progress.last.process, signal.SIGKILL)
                killed.append(progress.last.process)

    with local_client(2) as client:
        store = sweep(study, tmp_path / "killed", client, watch=kill)
    assert killed and os.getpid() not in killed
    assert chunks(store.folder) == chunks(whole.folder)
    assert store.finished() == set(range(24))


def test_block_reports_its_process_and_memory(study, tmp_path):
    Store.begin(tmp_path / "one", study)
    result = run_block(study, str(tmp_path / "one"), 3)
    assert result.block == 3 and result.process == os.getpid() and result.memory > 2**20


def workers():
    """The workers of this process, however often they were started again."""
    psutil = pytest.importorskip("psutil")
    for process in psutil.Process().children(recursive=True):
        try:
            if "spawn_main" in " ".join(process.cmdline()):
                yield process
        except psutil.Error:
            continue


class Storm(threading.Thread):
    """Kills all workers twice a second for so many `seconds`."""

    def __init__(self, seconds):
        super().__init__(daemon=True)
        self.until, self.killed = time.monotonic() + seconds, 0

    def run(self):
        while time.monotonic() < self.until:
            for process in list(workers()):
                process.kill()
                self.killed += 1
            time.sleep(0.5)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_all_workers_killed_again_and_again(muscle, task, tmp_path):
    study = study_of(muscle, task, block=4)
    whole = sweep(study, tmp_path / "alone")
    with local_client(2) as client:
        storm = Storm(15)
        storm.start()
        store = sweep(study, tmp_path / "killed", client)
    assert storm.killed > 4
    assert chunks(store.folder) == chunks(whole.folder)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_sweep_ends_without_workers(muscle, task, tmp_path):
    study, storm = study_of(muscle, task, block=4), Storm(120)
    with local_client(2) as client:
        storm.start()
        with pytest.raises(ConnectionError, match="no worker for 6 s"):
            sweep(study, tmp_path / "killed", client, worker_timeout=6.0)
        storm.until = 0
    assert not list(workers())
    # and none from the start
    storm = Storm(60)
    storm.start()
    with pytest.raises(ConnectionError, match="no worker can be started"), local_client(2):
        pass
    storm.until = 0


@pytest.mark.filterwarnings("ignore")
def test_local_scheduler_refuses_other_clients(study, tmp_path):
    distributed = pytest.importorskip("distributed", reason="needs the extra `sweep`")
    psutil = pytest.importorskip("psutil")
    with local_client(1) as client:
        address = client.scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        for stranger in (address, address.replace("tls", "tcp")):
            # in a process of its own, as a client that gets no answer leaves itself behind: as
            # Dask's scheduler, and for the garbage collection to wait for
            knock = f"import distributed; distributed.Client({stranger!r}, timeout=3)"
            command = [sys.executable, "-W", "ignore", "-c", knock]
            result = subprocess.run(command, capture_output=True, text=True, timeout=120)
            assert result.returncode == 1
            message = result.stderr.strip().splitlines()[-1]
            assert any(name in message for name in ("OSError", "CommClosedError", "TypeError")), (
                message
            )
        me = psutil.Process()
        ports = [
            connection.laddr
            for process in (me, *me.children(recursive=True))
            for connection in process.net_connections()
            if connection.status == "LISTEN"
        ]
        assert ports and all(port.ip == "127.0.0.1" and port.port != 8787 for port in ports)
        for port in ports:
            with pytest.raises(OSError):  # noqa: PT011 no page, or no HTTP at all
                urllib.request.urlopen(f"http://127.0.0.1:{port.port}/status", timeout=3)
        sweep(study, tmp_path / "swept", client)
    # what reads and writes files afterwards doesn't ask a cluster that is gone
    with pytest.raises(ValueError, match=""):  # noqa: PT011 distributed's own: nobody is to be asked
        distributed.get_client()


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
            with scheduler_client(address) as client:
                client.wait_for_workers(1, timeout=180)
                with pytest.raises(ConnectionError, match="is lost"):
                    sweep(study, tmp_path / "lost", client, watch=kill)
        finally:
            scheduler.kill()
            worker.terminate()
    progress_reports = []
    store = sweep(study, tmp_path / "lost", resume=True, watch=progress_reports.append)
    assert progress_reports[0].done >= 5
    assert chunks(store.folder) == chunks(whole.folder)

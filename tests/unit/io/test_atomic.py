"""Files appear whole or not at all, and killed writers leave nothing for good."""

import os
import resource
import signal
import subprocess
import sys

import pytest

from fascicle.io import atomic


# writes a file, or replaces a folder, and is killed at the moment that is named
KILLED = """
import os, shutil, signal, sys
from pathlib import Path
from fascicle.io import atomic

when, path = sys.argv[1], Path(sys.argv[2])

def kill(*_):
    os.kill(os.getpid(), signal.SIGKILL)

if when == "before":
    Path.replace = kill
    atomic._exchange = kill
if when == "between":  # on a system that can't exchange two folders
    atomic._exchange = lambda *_: False
    steps = [Path.replace, kill]
    Path.replace = lambda one, other: steps.pop(0)(one, other)
if when == "after":
    remove = shutil.rmtree

    def kill_once_written(*given, **named):
        there = path / "0" if path.suffix == ".zarr" else path
        if there.exists() and there.read_text() == "new":
            kill()
        remove(*given, **named)

    shutil.rmtree = kill_once_written

def fill(draft):
    if path.suffix == ".zarr":
        draft.mkdir()
        draft = draft / "0"
    draft.write_text("new")

atomic.write(path, fill, folder=path.suffix == ".zarr")
"""


def killed(when, path):
    done = subprocess.run([sys.executable, "-c", KILLED, when, str(path)], timeout=120)
    assert done.returncode == -signal.SIGKILL


def names(folder):
    return [entry.name for entry in folder.iterdir()]


def write_store(path, text):
    def fill(draft):
        draft.mkdir()
        (draft / "0").write_text(text)

    atomic.write(path, fill, folder=True)


@pytest.mark.parametrize(
    ("when", "text"), [("before", "old"), ("between", "old"), ("after", "new")]
)
def test_a_store_whose_writer_is_killed_stands_under_its_name(tmp_path, when, text):
    store = tmp_path / "x.zarr"
    write_store(store, "old")
    killed(when, store)
    if when == "between":
        # the one moment without it; whoever writes in this folder next puts it back
        assert not store.exists()
        atomic.check_writable(tmp_path / "y.csv")
    assert (store / "0").read_text() == text
    write_store(store, "again")
    assert (store / "0").read_text() == "again"
    assert names(tmp_path) == ["x.zarr"]


def test_folders_are_exchanged_in_one_step_here(tmp_path):
    for name in "ab":
        (tmp_path / name).mkdir()
        (tmp_path / name / name).touch()
    if not atomic._exchange(tmp_path / "a", tmp_path / "b"):
        pytest.skip("this system exchanges no folders")
    assert (tmp_path / "a" / "b").exists() and (tmp_path / "b" / "a").exists()


@pytest.mark.parametrize("when", ["before", "after"])
def test_drafts_of_a_killed_run_are_removed_by_the_next(tmp_path, when):
    killed(when, tmp_path / "x.csv")
    assert any(name.startswith(".") for name in names(tmp_path))
    atomic.write_text(tmp_path / "another.csv", "x")
    assert not any(name.startswith(".") for name in names(tmp_path))


def test_drafts_of_others_that_still_write_stay(tmp_path):
    with atomic.open_draft(tmp_path / "x.csv") as draft:
        draft.write_text("half")
        atomic.write_text(tmp_path / "x.csv", "other")
        assert draft.read_text() == "half"
        draft.replace(tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == "half"
    assert names(tmp_path) == ["x.csv"]


def test_a_draft_that_is_removed_before_it_is_locked_is_made_anew(tmp_path, monkeypatch):
    lock, removed = atomic._lock, []

    def late(folder, wait):
        if wait and not removed:
            removed.append(folder)
            folder.rmdir()
        return lock(folder, wait)

    monkeypatch.setattr(atomic, "_lock", late)
    atomic.write_text(tmp_path / "x.csv", "x")
    assert removed and names(tmp_path) == ["x.csv"]


@pytest.mark.parametrize("linked", [False, True])
def test_on_a_full_disk_the_former_file_stays(tmp_path, linked):
    """Stood for by the largest file that the process may write."""
    path = target = tmp_path / "x.csv"
    target.write_text("old")
    if linked:
        path = tmp_path / "link.csv"
        path.symlink_to(target)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match=rf"{path.name}: can't be written: File too large\."):
            atomic.write_text(path, "x" * 100_000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert target.read_text() == "old" and path.is_symlink() == linked
    assert not any(name.startswith(".") for name in names(tmp_path))


@pytest.mark.parametrize("kind", ["loop", "pipe", "folder"])
def test_what_is_no_regular_file_is_refused(tmp_path, kind):
    path = tmp_path / "x"
    if kind == "loop":
        path.symlink_to(path)
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        path.mkdir()
    with pytest.raises(OSError, match=r"x: can't be written: "):
        atomic.write_text(path, "x")
    assert names(tmp_path) == ["x"]


def fill(**texts):
    def inside(draft):
        for name, text in texts.items():
            (draft / f"{name}.txt").write_text(text)

    return inside


def test_an_existing_file_is_refused_unless_it_may_be_overwritten(tmp_path):
    atomic.check_overwrite(tmp_path / "d.csv")
    (tmp_path / "d.csv").write_text("measured")
    with pytest.raises(FileExistsError, match=r"d\.csv: already exists; use --replace"):
        atomic.check_overwrite(tmp_path / "d.csv", flag="--replace")
    atomic.check_overwrite(tmp_path / "d.csv", overwrite=True)


def test_a_folder_with_files_is_refused_unless_they_may_be_overwritten(tmp_path):
    folder = tmp_path / "made"
    folder.mkdir()
    (folder / ".DS_Store").write_text("")
    atomic.write_folder(folder, fill(a="1"))
    with pytest.raises(FileExistsError, match=r"already holds a\.txt"):
        atomic.write_folder(folder, fill(a="2"))
    (folder / "mine.txt").write_text("mine")
    atomic.write_folder(folder, fill(a="3", b="4"), overwrite=True)
    texts = {name: (folder / name).read_text() for name in ("a.txt", "b.txt", "mine.txt")}
    assert texts == {"a.txt": "3", "b.txt": "4", "mine.txt": "mine"}


def test_a_folder_that_can_not_be_filled_stays_as_it_was(tmp_path):
    def broken(draft):
        (draft / "a.txt").write_text("2")
        raise OSError(28, "No space left on device")

    atomic.write_folder(tmp_path / "made", fill(a="1"))
    for name in ("made", "new"):
        with pytest.raises(OSError, match="can't be written: No space left"):
            atomic.write_folder(tmp_path / name, broken, overwrite=True)
    assert names(tmp_path) == ["made"] and (tmp_path / "made" / "a.txt").read_text() == "1"
    (tmp_path / "made" / "b.txt").mkdir()
    with pytest.raises(IsADirectoryError, match=r"b\.txt: is a folder"):
        atomic.write_folder(tmp_path / "made", fill(a="2", b="2"), overwrite=True)
    assert (tmp_path / "made" / "a.txt").read_text() == "1"

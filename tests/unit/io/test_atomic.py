"""Files appear whole or not at all, and nothing is replaced unasked."""

import os
import resource
import signal
import subprocess
import sys

import pytest

from fascicle.io import atomic
from refusing import refuses_at


# writes a file and is killed before it is moved to its name
KILLED = """
import os, signal, sys
from fascicle.io import atomic

with atomic.open_replacement(sys.argv[1]) as draft:
    draft.write_text("new")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def names(folder):
    return sorted(entry.name for entry in folder.iterdir())


def test_a_killed_writer_changes_nothing_and_its_draft_is_removed(tmp_path):
    (tmp_path / "x.csv").write_text("old")
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "x.csv")], timeout=120)
    assert done.returncode == -signal.SIGKILL and (tmp_path / "x.csv").read_text() == "old"
    (draft,) = (entry for entry in tmp_path.iterdir() if entry.name.startswith("."))
    atomic.write_text(tmp_path / "y.csv", "x")
    assert draft.exists()  # another may still write
    yesterday = draft.stat().st_mtime - 25 * 3600
    os.utime(draft, (yesterday, yesterday))
    atomic.write_text(tmp_path / "z.csv", "x")
    assert names(tmp_path) == ["x.csv", "y.csv", "z.csv"]


@pytest.mark.parametrize("other", ["file", "folder"])
@pytest.mark.parametrize("ours", ["file", "files"])
def test_a_target_that_appears_meanwhile_stays(tmp_path, other, ours):
    target = tmp_path / "x.nc"
    mine = target if other == "file" else target / "thesis.txt"

    def fill(draft):
        if ours == "file":
            draft.write_text("ours")
        else:
            draft.mkdir(exist_ok=True)
            (draft / "thesis.txt").write_text("ours")
        if other == "folder":
            target.mkdir()
        mine.write_text("mine")

    def write():
        if ours == "files":
            atomic.write_folder(target, fill)
            return
        with atomic.open_replacement(target, overwrite=False) as draft:
            fill(draft)

    with pytest.raises(FileExistsError) as raised:
        write()
    assert "already" in str(raised.value) and ".draft" not in str(raised.value)
    assert mine.read_text() == "mine" and names(tmp_path) == ["x.nc"]


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
        with refuses_at(f"{path}: "):
            atomic.write_text(path, "x" * 100_000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert target.read_text() == "old" and path.is_symlink() == linked
    assert not any(name.startswith(".") for name in names(tmp_path))


@pytest.mark.parametrize("make", [lambda path: path.symlink_to(path), os.mkfifo, os.mkdir])
def test_what_is_no_regular_file_is_refused(tmp_path, make):
    path = tmp_path / "x"
    make(path)
    with refuses_at(f"{path}: "):
        atomic.write_text(path, "x")
    assert names(tmp_path) == ["x"]


def fill(**texts):
    def inside(draft):
        for name, text in texts.items():
            (draft / f"{name}.txt").write_text(text)

    return inside


def test_a_folder_with_files_is_refused_unless_they_may_be_overwritten(tmp_path):
    folder = tmp_path / "made"
    folder.mkdir()
    (folder / ".DS_Store").write_text("")
    atomic.write_folder(folder, fill(a="1"))
    with refuses_at(f"{folder}: "):
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
        with refuses_at(f"{tmp_path / name}: "):
            atomic.write_folder(tmp_path / name, broken, overwrite=True)
    assert names(tmp_path) == ["made"] and (tmp_path / "made" / "a.txt").read_text() == "1"
    (tmp_path / "made" / "b.txt").mkdir()
    with refuses_at(f"{tmp_path / 'made' / 'b.txt'}: "):
        atomic.write_folder(tmp_path / "made", fill(a="2", b="2"), overwrite=True)
    assert (tmp_path / "made" / "a.txt").read_text() == "1"

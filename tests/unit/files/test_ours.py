"""Nothing is lost: what isn't ours, or was changed since, is replaced by nobody unasked."""

import json
from pathlib import Path

import pytest

from fascicle.files import ours


def write(path, text="ours"):
    with ours.replacing(path) as draft:
        draft.write_text(text)


def fill(**files):
    def inside(draft):
        for name, text in files.items():
            (draft / f"{name}.txt").write_text(text)

    return inside


def texts(folder):
    return {path.name: path.read_text() for path in folder.iterdir() if path.name != ours.MANIFEST}


def test_a_file_of_somebody_else_is_kept(tmp_path):
    path = tmp_path / "d.csv"
    path.write_text("measured")
    with pytest.raises(FileExistsError, match=r"d.csv: is there already, .*; --force replaces it"):
        write(path)
    with pytest.raises(FileExistsError, match="--overwrite replaces it"):
        ours.check_file(path, flag="--overwrite")
    assert path.read_text() == "measured"
    with ours.replacing(path, force=True) as draft:
        draft.write_text("forced")
    write(path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["d.csv"]


def test_a_file_of_ours_is_replaced_until_it_is_changed(tmp_path):
    path = tmp_path / "x.nc"
    write(path)
    write(path, "again")
    path.write_text("edited")
    with pytest.raises(FileExistsError):
        write(path)
    # what it held before is ours again
    path.write_text("again")
    write(path)


def test_a_file_is_ours_however_soon_after_its_place_is_taken_a_run_is_stopped(
    tmp_path, monkeypatch
):
    path, replace = tmp_path / "x.nc", Path.replace

    def stopped(draft, target):
        replace(draft, target)
        raise KeyboardInterrupt

    for text in ("one", "two"):
        monkeypatch.setattr(Path, "replace", stopped)
        with pytest.raises(KeyboardInterrupt):
            write(path, text)
        monkeypatch.undo()
        assert path.read_text() == text
        ours.check_file(path)


def test_a_copy_is_not_the_file_that_was_written(tmp_path):
    write(tmp_path / "x.nc")
    (tmp_path / "kept.nc").write_bytes((tmp_path / "x.nc").read_bytes())
    with pytest.raises(FileExistsError):
        ours.check_file(tmp_path / "kept.nc")


def test_a_store_is_known_by_all_that_is_in_it(tmp_path):
    store = tmp_path / "x.zarr"
    with ours.replacing(store, folder=True) as draft:
        (draft / "c").mkdir(parents=True)
        (draft / "c" / "0").write_text("chunk")
    ours.check_file(store)
    (store / "c" / "1").write_text("another")
    with pytest.raises(FileExistsError):
        ours.check_file(store)


@pytest.mark.parametrize("base", ["relative", "{tmp}/file"])
def test_where_nothing_can_be_kept_everything_is_somebody_elses(tmp_path, monkeypatch, base):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", base.format(tmp=tmp_path))
    write(tmp_path / "x.nc")
    with pytest.raises(FileExistsError):
        ours.check_file(tmp_path / "x.nc")


def test_the_list_stays_short_and_tells_nobody_what_was_written(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(ours, "_MOST", 10)
    for i in range(50):
        write(tmp_path / f"x{i}.nc")
    kept = (tmp_path / "state" / "fascicle" / "written").read_text()
    assert 10 <= len(kept.splitlines()) <= 20 and "x4" not in kept
    ours.check_file(tmp_path / "x49.nc")
    with pytest.raises(FileExistsError):
        ours.check_file(tmp_path / "x0.nc")


def test_a_folder_is_replaced_and_what_is_no_longer_written_removed(tmp_path):
    folder = tmp_path / "made"
    ours.write_folder(folder, "design", fill(a="1", b="2"))
    ours.write_folder(folder, "design", fill(a="3", c="4"))
    assert texts(folder) == {"a.txt": "3", "c.txt": "4"}
    assert [entry.name for entry in tmp_path.iterdir()] == ["made"]
    told = json.loads((folder / ours.MANIFEST).read_text())
    assert list(told["files"]) == ["a.txt", "c.txt"] and told["command"] == "design"


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [("a.txt", "edited", "a.txt, which was changed since"), ("mine.txt", "x", "mine.txt, which")],
)
def test_a_folder_with_more_than_ours_is_kept(tmp_path, name, text, told):
    folder = tmp_path / "made"
    ours.write_folder(folder, "design", fill(a="1", b="2"))
    (folder / name).write_text(text)
    before = texts(folder)
    with pytest.raises(FileExistsError, match=rf"made: holds {told}.*--force"):
        ours.write_folder(folder, "design", fill(a="3"))
    assert texts(folder) == before
    ours.write_folder(folder, "design", fill(a="3"), force=True)
    # a forced run replaces what it writes, and still removes nothing that isn't ours
    assert texts(folder) == {"a.txt": "3"} | ({name: text} if name != "a.txt" else {})


def test_a_folder_of_another_command_or_of_nobody(tmp_path):
    ours.write_folder(tmp_path / "made", "calibrate", fill(a="1"))
    with pytest.raises(FileExistsError, match="holds what `fascicle calibrate` wrote"):
        ours.check_folder(tmp_path / "made", "design")
    (tmp_path / "mine").mkdir()
    ours.check_folder(tmp_path / "mine", "design")
    (tmp_path / "mine" / ".DS_Store").write_text("")
    ours.check_folder(tmp_path / "mine", "design")
    (tmp_path / "mine" / "thesis.txt").write_text("years")
    with pytest.raises(FileExistsError, match=r"holds thesis\.txt, which fascicle didn't write"):
        ours.check_folder(tmp_path / "mine", "design")


@pytest.mark.parametrize(
    "manifest",
    ["", "{", "[]", "null", '{"command": 1, "files": {}}', '{"files": []}', "[" * 100_000,
     '{"command": "design", "files": {"thesis.txt": null}}',
     '{"command": "design", "files": {"thesis.txt": ["x"]}, "before": 3}'],
)  # fmt: skip
def test_a_list_that_says_nothing_makes_nothing_ours(tmp_path, manifest):
    (tmp_path / "thesis.txt").write_text("years")
    (tmp_path / ours.MANIFEST).write_text(manifest)
    with pytest.raises(FileExistsError, match=r"thesis\.txt"):
        ours.check_folder(tmp_path, "design")


def test_a_link_to_what_is_somebody_elses_is_not_followed(tmp_path):
    folder = tmp_path / "made"
    ours.write_folder(folder, "design", fill(a="1"))
    (tmp_path / "thesis.txt").write_text("1")
    (folder / "a.txt").unlink()
    (folder / "a.txt").symlink_to(tmp_path / "thesis.txt")
    with pytest.raises(FileExistsError):
        ours.write_folder(folder, "design", fill(a="3"))
    ours.write_folder(folder, "design", fill(a="3"), force=True)
    assert (tmp_path / "thesis.txt").read_text() == "1"


def test_a_run_that_fails_leaves_what_was_there(tmp_path):
    def full(draft):
        (draft / "a.txt").write_text("half")
        raise OSError(28, "No space left on device")

    folder = tmp_path / "made"
    with pytest.raises(OSError, match="made: can't be written: No space left on device"):
        ours.write_folder(folder, "design", full)
    assert list(tmp_path.iterdir()) == []
    ours.write_folder(folder, "design", fill(a="1"))
    with pytest.raises(OSError, match="No space left"):
        ours.write_folder(folder, "design", full)
    assert texts(folder) == {"a.txt": "1"}


def test_stopped_between_two_files_all_of_it_is_still_ours(tmp_path, monkeypatch):
    folder = tmp_path / "made"
    ours.write_folder(folder, "design", fill(a="1", b="2", c="3"))
    remove = ours._remove

    def stopped(path):
        remove(path)
        raise KeyboardInterrupt

    monkeypatch.setattr(ours, "_remove", stopped)
    with pytest.raises(KeyboardInterrupt):
        ours.write_folder(folder, "design", fill(a="4"))
    monkeypatch.undo()
    # one file is new, one gone, one old
    assert texts(folder) == {"a.txt": "4", "c.txt": "3"}
    ours.write_folder(folder, "design", fill(b="5"))
    assert texts(folder) == {"b.txt": "5"}

"""What is read is a regular file of a limited size."""

import os
import socket

import pytest

from fascicle.io.input_file import read_bytes


def test_a_file_is_read(tmp_path):
    (tmp_path / "x").write_bytes(b"abc")
    assert read_bytes(tmp_path / "x", 3, "muscle file") == b"abc"
    with pytest.raises(ValueError, match="larger than 2 bytes, not a muscle file"):
        read_bytes(tmp_path / "x", 2, "muscle file")


@pytest.mark.parametrize("kind", ["pipe", "socket", "device", "folder", "loop", "none", "NUL"])
def test_anything_else_is_refused_at_once(tmp_path, monkeypatch, kind):
    path = tmp_path / ("x\0" if kind == "NUL" else "x")
    monkeypatch.chdir(tmp_path)
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as server:
            server.bind("x")
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    elif kind == "loop":
        path.symlink_to(path)
    with pytest.raises(OSError, match=r".*x.*: .*") as error:
        read_bytes(path, 10, "muscle file")
    assert "\n" not in str(error.value)

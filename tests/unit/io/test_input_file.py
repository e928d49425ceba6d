"""What is read is a regular file of a limited size."""

import contextlib
import os
import socket

import pytest

from fascicle.io.input_file import parse_toml, read_bytes
from refusing import refuses_at


def test_a_file_is_read(tmp_path):
    (tmp_path / "x").write_bytes(b"abc")
    assert read_bytes(tmp_path / "x", 3, "muscle file") == b"abc"
    with refuses_at(f"{tmp_path / 'x'}: "):
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
    quoted = kind in ("loop", "NUL")  # of a path that the system refuses
    with refuses_at(f"{str(path)!r}: " if quoted else f"{path}: "):
        read_bytes(path, 10, "muscle file")


@pytest.mark.parametrize(
    "text",
    ["a." * 30_000 + "a = 1", '"a".' * 15_000 + "a = 1", "'a' . " * 10_000 + "a = 1",
     "[" + "a." * 30_000 + "a]", "b = 1\n[[" + "a." * 30_000 + "a]]",
     "x = {" + "a." * 30_000 + "a = 1}", "a = " + "{a = " * 10_000, "a = " + "[" * 30_000,
     "\n".join("a." * 62 + f"a{i} = 1" for i in range(500)) + "\na = 1"],
)  # fmt: skip
def test_a_key_of_many_parts_is_refused(text):
    # parsing the shortest of them took 4 s, the longest 40
    with refuses_at("m.toml: "):
        parse_toml(text, "m.toml")


@pytest.mark.parametrize(
    "text",
    ["a = [" + "1.5, " * 500 + "1]", "a.b.c = 1979-05-27T07:32:00.999", "# " + "x. " * 50,
     'a = "' + "." * 500 + '"', "a = '''" + "[" * 500 + "'''", 'a = "' + "x." * 50 + '"'],
)  # fmt: skip
def test_dots_in_values_and_comments_are_no_key(text):
    parse_toml(text, "f")


@pytest.mark.parametrize(
    "sign", ['"', "'", '"""', "'''", "\\", "#", "a.", ".", "[", "]", "\n", '"a', "a", "'' "]
)
def test_long_texts_end(sign):
    for text in (sign * 65_000, f'a = "{sign * 65_000}', f"a = '''{sign * 65_000}"):
        with contextlib.suppress(ValueError):
            parse_toml(text, "f")

import shlex

import pytest

from fascicle.cli import main


@pytest.fixture
def fascicle(capsys, monkeypatch, tmp_path):
    """Run a command in an empty folder: exit code, standard output, standard error."""
    monkeypatch.setenv("FASCICLE_NO_CACHE", "1")
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main([str(argument) for argument in arguments])
        printed = capsys.readouterr()
        return end.value.code, printed.out, printed.err

    return run


@pytest.fixture
def answer(fascicle):
    """Run a command that must succeed without a warning: its standard output."""

    def run(*arguments):
        code, out, err = fascicle(*arguments)
        assert (code, err) == (0, "")
        return out

    return run


@pytest.fixture
def refused(fascicle, tmp_path):
    """Run a command that must be refused in one line, with nothing written: that line."""

    def run(*arguments):
        if len(arguments) == 1:  # a line as a shell reads it
            arguments = shlex.split(arguments[0])
        before = _content(tmp_path)
        code, out, err = fascicle(*arguments)
        assert (code, out) == (2, "")
        assert err.startswith("error: ") and err.endswith("\n") and err.count("\n") == 1
        assert err.rstrip("\n").isprintable() and len(err) < 650
        assert _content(tmp_path) == before
        return err.removeprefix("error: ").rstrip()

    return run


def _content(folder):
    paths = sorted(folder.rglob("*"))
    return {path: path.read_bytes() if path.is_file() else None for path in paths}

"""Bad input: one line on standard error, exit code 2, nothing half written."""

import os
import tomllib
from pathlib import Path

import pytest


SIX, PAIR, TEN = "kim2021_figure_6", "kim2021_bundle_1_1", "kim2021_slenderness_10"
RECORD = "pressure [kPa],strain,force [N]\n100,0.1,1\n"


TABLE = tomllib.loads((Path(__file__).parent / "refused.toml").read_text(encoding="utf-8"))
LINES = [(line, words) for group in TABLE.values() for line, words in group.items()]


@pytest.mark.parametrize(("line", "words"), LINES, ids=lambda x: x[:60])
def test_a_line_that_is_refused(fascicle, refused, tmp_path, line, words):
    (tmp_path / "folder.nc").mkdir()
    (tmp_path / "d.csv").write_text(RECORD)
    for name, kind in (("t.toml", "--task"), ("s.toml", "--scenario")):
        if name in line:
            assert fascicle("init", name, kind)[0] == 0
    assert words in refused(line)


def pipe(path):
    os.mkfifo(path)


def loop(path):
    path.symlink_to(path)


def device(path):
    path.symlink_to("/dev/zero")


READ = [
    "force {}", "free-strain {}", "bundle {}", "space {}", "recruit {} --force 1N --strain 0.1",
    "efficiency {}", "simulate {}", "simulate {} --compare", "record {} -o y.csv",
    f"calibrate {{}} -m {SIX}", "calibrate d.csv -m {}", "design {}", "sweep {} --workers 0",
    "export {} --fmu y.fmu", "explore {} --no-show",
]  # fmt: skip


@pytest.mark.parametrize("line", READ)
def test_a_file_that_is_not_regular_is_not_read(fascicle, tmp_path, line):
    """A named pipe without a writer was waited for for ever."""
    (tmp_path / "d.csv").write_text(RECORD)
    for kind in (pipe, loop, device):
        kind(tmp_path / "x.toml")
        code, _, err = fascicle(*line.format("x.toml").split())
        assert code == 2 and err.count("\n") == 1 and "x.toml" in err, err
        assert sorted(path.name for path in tmp_path.iterdir()) == ["d.csv", "x.toml"]
        (tmp_path / "x.toml").unlink()


WRITTEN = [
    f"force {SIX} --out {{}}.csv",
    f"force {SIX} --plot {{}}.png", "simulate lift_gas --report {}.html", f"record {SIX} -o {{}}",
    f"calibrate d.csv -m {SIX} -o {{}}", "design t.toml -o {}", "init {}",
    "reproduce kim2021 -o {}", "sweep t.toml --workers 0 -o {}",
    "sweep t.toml --workers 0 -o {}/inside",
    f"export {SIX} --table {{}}", f"export {SIX} --fmu {{}}.fmu",
]  # fmt: skip


@pytest.mark.parametrize("line", WRITTEN)
def test_a_file_or_folder_that_is_not_regular_is_not_written(fascicle, refused, tmp_path, line):
    pytest.importorskip("zarr", reason="needs the extra `sweep`")
    (tmp_path / "d.csv").write_text(RECORD)
    assert fascicle("init", "t.toml", "--task")[0] == 0
    words = line.format("x").split()
    name = words[-1].partition("=")[2] or words[-1].partition("/")[0]
    for kind in (pipe, loop):
        kind(tmp_path / name)
        assert name in refused(*words)
        (tmp_path / name).unlink()

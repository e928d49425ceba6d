"""No command replaces or removes an existing file unasked."""

import pytest

from small_task import TASK


SIX = "kim2021_figure_6"
ONE = ["-p", "34.5kPa", "-s", "0.1"]


@pytest.mark.parametrize(
    "command",
    [
        ["force", SIX, *ONE, "--out", "x.csv"],
        ["force", SIX, *ONE, "--plot", "x.png"],
        ["record", SIX, "-p", "34.5kPa", "--samples", "4", "--out", "x.csv"],
        ["init", "x.toml"],
        ["export", SIX, "--table", "code"],
        ["simulate", "s.toml", "--report", "x.html"],
    ],
    ids=lambda command: f"{command[0]} {command[-2]}",
)
def test_a_file_is_kept(fascicle, refused, tmp_path, command):
    name = "code/muscle.h" if "code" in command else command[-1].partition("=")[2] or command[-1]
    (tmp_path / "code").mkdir()
    if command[0] == "simulate":
        assert fascicle("init", "s.toml", "--scenario")[0] == 0
        text = (tmp_path / "s.toml").read_text().replace('"6 s"', '"20 ms"')
        (tmp_path / "s.toml").write_text(text.partition('[[schedule]]\ntime = "1 s"')[0])
    (tmp_path / name).write_text("measured")
    assert name in refused(*command)
    assert fascicle(*command, "--overwrite")[0] == 0
    assert (tmp_path / name).read_bytes() != b"measured"
    (tmp_path / name).write_text("edited")
    refused(*command)


@pytest.mark.parametrize(
    "command", [["design", "t.toml"], ["calibrate", "d.csv", "-m", SIX, "--fit", "c10"]]
)
def test_a_folder_of_results_is_kept(fascicle, refused, tmp_path, command):
    (tmp_path / "t.toml").write_text(TASK)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years")
    record = ["record", SIX, "-p", "34.5kPa", "--samples", "9", "-o", "d.csv"]
    assert fascicle(*record)[0] == 0
    assert "thesis.txt" in refused(*command, "--out", "mine")
    for more in ([], ["--overwrite"]):
        assert fascicle(*command, "--out", "made", *more)[0] == 0
    (tmp_path / "made" / "report.html").write_text("edited")
    assert "already holds" in refused(*command, "--out", "made")
    (tmp_path / "made" / "mine.toml").write_text("mine")
    assert fascicle(*command, "--out", "made", "--overwrite")[0] == 0
    assert (tmp_path / "made" / "mine.toml").read_text() == "mine"


@pytest.mark.parametrize(
    "command",
    ["design none.toml -o f", f"calibrate none.csv -m {SIX} -o f"],
)
def test_a_file_in_the_place_of_a_folder_is_refused_before_the_work(refused, tmp_path, command):
    name = command.split()[-1]
    (tmp_path / name).write_text("measured")
    assert f"--out {name}: " in refused(f"{command} --overwrite")

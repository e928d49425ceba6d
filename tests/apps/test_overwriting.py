"""No command replaces or removes a file that it didn't write, or that was changed since."""

import pytest


SIX, PAIR = "kim2021_figure_6", "kim2021_bundle_1_1"
ONE = ["-p", "34.5kPa", "-s", "0.1"]
COMMANDS = [
    (["force", SIX, *ONE], "--force"),
    (["free-strain", SIX, "-p", "34.5kPa"], "--force"),
    (["bundle", PAIR, "-s", "0.1"], "--force"),
    (["space", PAIR, "--levels", "0kPa", "--strain", "0,0.1"], "--force"),
    (["recruit", PAIR, "--force", "40N", "--strain", "0.1"], "--overwrite"),
    (["efficiency", PAIR, "--force", "40N", "--strain", "0.1"], "--overwrite"),
    (["record", SIX, "-p", "34.5kPa", "--samples", "4"], "--force"),
]


@pytest.mark.parametrize(("command", "flag"), COMMANDS, ids=lambda x: x[0] if x[0] != "-" else "")
def test_a_measurement_is_kept(fascicle, tmp_path, command, flag):
    (tmp_path / "d.csv").write_text("measured")
    code, out, err = fascicle(*command, "--out", "d.csv")
    assert (code, out) == (2, "") and err.count("\n") == 1
    assert "d.csv: is there already" in err and f"{flag} replaces it" in err
    assert (tmp_path / "d.csv").read_text() == "measured"
    assert fascicle(*command, "--out", "d.csv", flag)[0] == 0
    # now it is ours
    assert fascicle(*command, "--out", "d.csv")[0] == 0
    with (tmp_path / "d.csv").open("a") as file:
        file.write("# a remark\n")
    assert fascicle(*command, "--out", "d.csv")[0] == 2
    assert (tmp_path / "d.csv").read_text().endswith("# a remark\n")


def test_a_picture_is_kept(fascicle, tmp_path):
    (tmp_path / "x.png").write_text("a photograph")
    code, _, err = fascicle("force", SIX, *ONE, "--plot", "x.png")
    assert code == 2 and "--plot x.png: is there already" in err and "--force" in err
    assert (tmp_path / "x.png").read_text() == "a photograph"


def test_a_muscle_that_was_edited_is_kept(fascicle, tmp_path):
    assert fascicle("init", "m.toml")[0] == 0
    assert fascicle("init", "m.toml")[0] == 0
    (tmp_path / "m.toml").write_text("mine")
    code, _, err = fascicle("init", "m.toml")
    assert code == 2 and "--force replaces it" in err
    assert (tmp_path / "m.toml").read_text() == "mine"
    assert fascicle("init", "m.toml", "--force")[0] == 0


TASK = """format = 1
[task]
force = "60 N"
strain = 0.1
supply_pressure = "413.7 kPa"
[design]
muscle = "kim2021_slenderness_10"
muscles = [2]
[objectives]
valves = "min"
"""


def test_a_bundle_that_design_did_not_write_is_kept(fascicle, tmp_path):
    (tmp_path / "task.toml").write_text(TASK)
    made = tmp_path / "made"
    design = ["design", "task.toml", "--out", "made"]
    assert fascicle(*design)[0] == 0
    assert fascicle(*design)[0] == 0
    (made / "bundle_mine.toml").write_text("mine")
    code, _, err = fascicle(*design)
    assert code == 2 and "bundle_mine.toml" in err and "--force" in err
    assert fascicle(*design, "--force")[0] == 0
    assert (made / "bundle_mine.toml").read_text() == "mine"
    (made / "bundle_mine.toml").unlink()
    (made / "bundle_1.toml").write_text("edited")
    code, _, err = fascicle(*design)
    assert code == 2 and "bundle_1.toml, which was changed" in err
    assert (made / "bundle_1.toml").read_text() == "edited"


def test_a_reproduction_keeps_what_is_there(fascicle, monkeypatch, tmp_path):
    def run(folder, _progress):
        (folder / "report.html").write_text("a report")
        return []

    monkeypatch.setattr("fascicle.reproduce.kim2021.run", run)
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "report.html").write_text("mine")
    code, _, err = fascicle("reproduce", "kim2021", "--out", "made")
    assert code == 2 and "report.html, which fascicle didn't write" in err and "--force" in err
    assert (tmp_path / "made" / "report.html").read_text() == "mine"
    for more in (["--force"], []):
        assert fascicle("reproduce", "kim2021", "--out", "made", *more)[0] == 0
    assert (tmp_path / "made" / "report.html").read_text() == "a report"

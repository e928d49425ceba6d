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
    assert code == 2 and "--overwrite replaces it" in err
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

    monkeypatch.setattr("reproduction.kim2021.reproduction.run", run)
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "report.html").write_text("mine")
    code, _, err = fascicle("reproduce", "kim2021", "--out", "made")
    assert code == 2 and "report.html, which fascicle didn't write" in err and "--force" in err
    assert (tmp_path / "made" / "report.html").read_text() == "mine"
    for more in (["--force"], []):
        assert fascicle("reproduce", "kim2021", "--out", "made", *more)[0] == 0
    assert (tmp_path / "made" / "report.html").read_text() == "a report"


# a command that reads a file of ours, `in.toml` or `in.csv`, and options that name an output
READERS = [
    (["force", "in.toml", *ONE], ["--out", "--plot", "--csv", "--json"]),
    (["free-strain", "in.toml", "-p", "34.5kPa"], ["--out", "--plot", "--csv", "--json"]),
    (["bundle", "in.toml", "-s", "0.1", "-p", "1kPa"], ["--out", "--plot", "--csv", "--json"]),
    (["space", "in.toml", "--levels", "0kPa", "--supply", "9kPa"], ["--out", "--plot", "--json"]),
    (["recruit", "in.toml", "--force", "4N", "--strain", "0.1", "--supply", "99kPa"], ["--json"]),
    (["efficiency", "in.toml", "--force", "4N", "--supply", "99kPa"], ["--out", "--json"]),
    (["simulate", "in.toml"], ["--out", "--plot", "--report", "--csv", "--json"]),
    (["record", "in.toml", "-p", "34.5kPa"], ["--out"]),
    (["calibrate", "in.csv", "--muscle", SIX], ["--json"]),
    (["calibrate", "other.csv", "--muscle", "in.toml"], ["--json"]),
    (["design", "in.toml"], ["--json", "--checkpoint"]),
    (["export", "in.toml"], ["--fmu"]),
]
CASES = [(command, option) for command, options in READERS for option in options]


def written_by_us(fascicle, command, folder):
    """The file that a command reads, as fascicle wrote it: nothing but its name protects it."""
    if command[0] == "calibrate" and "in.csv" in command:
        assert fascicle("record", SIX, "-p", "34.5kPa", "--samples", "4", "-o", "in.csv")[0] == 0
        return folder / "in.csv"
    kinds = {"simulate": ["--scenario"], "design": ["--task"]}
    assert fascicle("init", "in.toml", *kinds.get(command[0], []))[0] == 0
    return folder / "in.toml"


@pytest.mark.parametrize("name", ["{name}", "./{name}", "link.{end}", "{folder}/sub/../{name}"])
@pytest.mark.parametrize(("command", "option"), CASES, ids=lambda x: x if "-" in x else x[0])
def test_an_input_is_not_replaced(fascicle, tmp_path, command, option, name):
    path = written_by_us(fascicle, command, tmp_path)
    before = path.read_bytes()
    # the name ends as the option wants it, and leads to what the command reads
    end = {"--out": "csv", "--plot": "png", "--report": "html", "--fmu": "fmu"}.get(option, "json")
    (tmp_path / "sub").mkdir()
    renamed = [part.replace(path.name, f"in.{end}") for part in command]
    shown = name.format(name=f"in.{end}", end=end, folder=tmp_path)
    if path.suffix != f".{end}":
        (tmp_path / f"in.{end}").symlink_to(path.name)
    (tmp_path / f"link.{end}").symlink_to(f"in.{end}")
    code, out, err = fascicle(*renamed, f"{option}={shown}")
    assert (code, out) == (2, "") and err.count("\n") == 1
    assert f"{option} {shown}: is read by this command: name another file" in err
    assert path.read_bytes() == before


def test_with_the_flag_an_input_is_replaced(fascicle, tmp_path):
    assert fascicle("init", "m.toml")[0] == 0
    assert fascicle("force", "m.toml", *ONE, "--csv=m.toml")[0] == 2
    assert fascicle("force", "m.toml", *ONE, "--csv=m.toml", "--force")[0] == 0
    assert (tmp_path / "m.toml").read_text().startswith("pressure [Pa]")


def test_a_file_that_an_input_names_is_not_replaced(fascicle, tmp_path):
    assert fascicle("init", "m.toml", "--from", "kim2021_bundle_1_4")[0] == 0
    assert fascicle("init", "s.toml", "--scenario")[0] == 0
    text = (tmp_path / "s.toml").read_text()
    lines = ['bundle = "m.toml"' if one.startswith("bundle") else one for one in text.split("\n")]
    (tmp_path / "s.toml").write_text("\n".join(lines))
    before = (tmp_path / "m.toml").read_text()
    code, _, err = fascicle("simulate", "s.toml", "--json=m.toml")
    assert code == 2 and err.count("\n") == 1
    assert "--json m.toml: is read by this command" in err
    assert (tmp_path / "m.toml").read_text() == before


def test_the_muscle_that_a_fit_begins_with_is_not_replaced_by_what_it_fits(fascicle, tmp_path):
    assert fascicle("record", SIX, "-p", "34.5kPa", "--samples", "9", "-o", "d.csv")[0] == 0
    fit = ["calibrate", "d.csv", "--fit", "c10", "--no-profile"]
    assert fascicle(*fit, "-m", SIX)[0] == 0
    made = tmp_path / "calibrated-d" / "muscle.toml"
    before = made.read_bytes()
    code, _, err = fascicle(*fit, "-m", "calibrated-d/muscle.toml")
    assert code == 2 and err.count("\n") == 1
    assert "calibrated-d/muscle.toml: is read by this command" in err and "--force" in err
    assert made.read_bytes() == before


SHARED = [
    (["force", SIX, *ONE], ["--out=x.csv", "--csv=x.csv"]),
    (["force", SIX, *ONE], ["--out=x.json", "--json=./x.json"]),
    (["force", SIX, *ONE], ["--out=x.json", "--json=link.json"]),
    (["force", SIX, *ONE], ["--plot=x.png", "--json=x.png"]),
    (["force", SIX, *ONE], ["--out=x.zarr", "--json=x.zarr/x.json"]),
    (["simulate", "lift_gas"], ["--report=x.html", "--json=x.html"]),
    (["design", "task.toml"], ["--out=x.json", "--json=x.json"]),
    (["design", "task.toml"], ["--out=x", "--json=x/x.json"]),
    (["calibrate", "d.csv"], ["--out=x", "--json=x/x.json"]),
    (["export", SIX], ["--c=x", "--table=./x"]),
]


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize(("command", "options"), SHARED, ids=lambda x: x[0].lstrip("-"))
def test_two_outputs_do_not_share_a_place(fascicle, tmp_path, command, options, force):
    (tmp_path / "link.json").symlink_to("x.json")
    if "/" in options[1].replace("./", ""):
        (tmp_path / "x.zarr").mkdir()
        (tmp_path / "x.zarr" / "zarr.json").write_text("")
        (tmp_path / "x").mkdir()
    before = sorted(tmp_path.rglob("*"))
    code, out, err = fascicle(*command, *options, *(["--force"] if force else []))
    assert (code, out) == (2, "") and err.count("\n") == 1
    names = [one.partition("=")[0] for one in options]
    assert all(name in err for name in names) or "name another place" in err
    assert sorted(tmp_path.rglob("*")) == before


def test_every_option_that_names_an_output_is_known():
    """By what its value is called in the help, which is how collisions are found."""
    from typer.main import get_command

    from fascicle.cli.commands import app
    from fascicle.cli.options import OUTPUTS

    words = ("Where ", "there", "Write ")
    for command in get_command(app).commands.values():
        for one in command.params:
            told = getattr(one, "help", None) or ""
            if one.metavar and one.param_type_name == "option" and told.startswith(words):
                assert one.metavar in OUTPUTS, (command.name, one.name)

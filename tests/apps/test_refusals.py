"""The issue of bad input: each is one line on stderr, exit code 2, nothing half written."""

import errno
import os

import pytest


MUSCLE = """format = 1
[muscle]
length = "127 mm"
outer_radius = "6.35 mm"
wall_thickness = "1.6 mm"
braid_angle = "33 deg"
"""
BUNDLE = MUSCLE + '[bundle]\nsupply_pressure = "413.7 kPa"\n' + 2 * "[[bundle.motor_unit]]\n"
SIX, PAIR = "kim2021_figure_6", "kim2021_bundle_1_1"


@pytest.fixture
def refused(fascicle, tmp_path):
    """Run a command that must be refused; its one line."""

    def run(*arguments):
        before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        code, out, err = fascicle(*arguments)
        assert code == 2
        assert out == ""
        assert err.startswith("error: ")
        assert err.count("\n") == 1
        assert err.endswith("\n")
        assert "Traceback" not in err
        after = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        assert after == before
        return err.removeprefix("error: ").rstrip()

    return run


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("length", "lenght", 'm.toml: muscle.lenght: unknown key, did you mean "length"?'),
        ('"127 mm"', "127", "muscle.length = 127: `length` must be a length, such as"),
        ('"127 mm"', '"127 kPa"', "'kPa' is no unit of length."),
        ('"127 mm"', '"nan mm"', "it must be finite"),
        ('"127 mm"', '"-127 mm"', "`length` must be positive"),
        ("1.6 mm", "6.35 mm", "`wall_thickness` must be less than `outer_radius`"),
        ("33 deg", "54.7357 deg", "`braid_angle` must lie in (0, 54.7356) deg"),
        ("33 deg", "0 deg", "`braid_angle` must lie in (0, 54.7356) deg"),
        ("format = 1", "format = ", "m.toml: not TOML: "),
    ],
)
def test_a_wrong_file(refused, tmp_path, old, new, message):
    (tmp_path / "m.toml").write_text(MUSCLE.replace(old, new, 1))
    assert message in refused("force", "m.toml", "--out", "x.nc")


def test_an_empty_bundle(refused, tmp_path):
    (tmp_path / "m.toml").write_text(MUSCLE + "[bundle]\n")
    assert "`motor_units` must hold at least one" in refused("bundle", "m.toml")


def test_several_muscles_without_a_bundle(refused, tmp_path):
    second = MUSCLE.removeprefix("format = 1\n").replace("[muscle]", "[muscle.b]")
    (tmp_path / "m.toml").write_text(MUSCLE.replace("[muscle]", "[muscle.a]") + second)
    assert "several muscles (a, b) and no [bundle]" in refused("force", "m.toml")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--pressure", "34.5"], "bare number 34.5: write it with its unit"),
        (["--pressure", "34.5mm"], "'mm' is no unit of pressure"),
        (["--pressure", "34.5kpa"], "did you mean 'kPa'?"),
        (["--pressure", "nan kPa"], "must be finite"),
        (["--pressure", "-1kPa"], "--pressure must lie in [0, 1e6] Pa"),
        (["--pressure", "1.01MPa"], "--pressure must lie in [0, 1e6] Pa"),
        (["--pressure", "0kPa:10kPa"], "write start:stop:step"),
        (["--pressure", "0kPa:10kPa:0kPa"], "its step must not be 0"),
        (["--pressure", ""], "empty entry"),
        (["--strain", "nan"], "must be finite"),
        (["--strain", "0.1kPa"], "'kPa' is no unit of strain"),
        (["--strain", "0.61"], "--strain must lie in (-0.192363, 0.6]"),
        (["--strain", "-0.193"], "--strain must lie in (-0.192363, 0.6]"),
        (["--strain", "0:0.6:1e-9"], "more than 100000 values"),
        (["--strain", "0:0.6:1e-5", "-p", "0Pa:50Pa:1Pa"], "51 x 60001 points are more than"),
        (["--out", "no/x.nc"], "--out no/x.nc: can't be written: no such folder"),
        (["--out", "x.xls"], "a result's name must end in .nc, .zarr, .csv, .json"),
        (["--out", "x"], "a result's name must end in .nc, .zarr, .csv, .json"),
        (["--plot", "no/x.png"], "--plot no/x.png: can't be written: no such folder"),
        (["--plot", "x.jpg"], "its name must end in .png, .svg"),
        (["--json", "--csv"], "--json and --csv"),
        (["--presure", "1kPa"], "No such option: --presure"),
        (["extra"], "unexpected extra argument"),
    ],
)
def test_a_wrong_option(refused, arguments, message):
    assert message in refused("force", SIX, *arguments)


def test_unwritable_output_is_said_before_the_muscle_is_read(refused, tmp_path):
    (tmp_path / "folder.nc").mkdir()
    assert "it is a folder" in refused("force", "no-such-muscle", "--out", "folder.nc")
    (tmp_path / "file").write_text("kept")
    assert "no such folder" in refused("force", SIX, "--out", "file/x.nc")


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("nowhere.toml", "nowhere.toml: no such file"),
        ("no/where.toml", "no/where.toml: no such file"),
        ("kim2021_figur_6", "did you mean kim2021_figure_6?"),
        ("xyz", "xyz: no such file or named example, see `fascicle muscles`"),
        (".", ".: a folder, not a muscle file"),
        ("a\0b", "no such file"),
        ("x" * 300, "xxx…: no such file"),
        ("a\nb", "no such file"),
    ],
)
def test_nothing_to_read(refused, target, message):
    assert message in refused("force", target)


def test_binary_rubbish(refused, tmp_path):
    (tmp_path / "m.toml").write_bytes(bytes(range(256)) * 40)
    assert "m.toml: not a text file" in refused("force", "m.toml")


@pytest.mark.parametrize("command", ["bundle", "free-strain"])
@pytest.mark.parametrize("pressure", ["10kPa", "10kPa,20kPa,30kPa"])
def test_wrong_number_of_pressures(refused, command, pressure):
    count = pressure.count(",") + 1
    assert f"{count} pressures for 2 motor units" in refused(command, PAIR, "-p", pressure)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["force", PAIR], "a bundle, not a muscle: use `fascicle bundle`"),
        (["bundle", PAIR, "-p", "2MPa,0kPa"], "must lie in [0, 1e6] Pa"),
        (["bundle", PAIR, "-s", "0.7"], "--strain must lie in"),
        (["bundle", SIX], "--pressure: missing, since the bundle has no supply pressure"),
        (["space", PAIR, "--scheme", "odrerly"], "'odrerly'"),
        (["space", PAIR, "--supply", "413.7"], "write it with its unit"),
        (["space", PAIR, "--levels", "500kPa"], "--levels must lie in"),
        (["space", PAIR, "--strain", "0.2,0.1"], "`--strain` must rise"),
        (["space", SIX], "--supply: missing"),
        (["efficiency", PAIR, "--path", "isobar"], "choose one of isobaric, isotonic"),
        (["efficiency", PAIR, "--force", "10"], "write it with its unit"),
        (["efficiency", PAIR, "--strain", "0"], "--strain must be positive"),
        (["free-strain", SIX, "--no-resistance"], "--no-resistance: it is for bundles"),
        (["reproduce", "kim2020"], "kim2020: no such paper here"),
        (["muscles", "kim2021_figur_6"], "did you mean kim2021_figure_6?"),
        (["explore", "--port", "99999"], "--port must be at most 65535, got 99999. Try 'fascicle"),
        (
            ["record", SIX, "--out", "x.csv", "--samples", "1"],
            "--samples must be at least 2, got 1.",
        ),
        (["record", SIX, "--out", "x.csv", "--noise", "5"], "--noise must lie in [0, 1), got 5"),
        (["calibrate", "d.csv", "--starts", "x"], "--starts must be a whole number, got x."),
        (["recruit", PAIR, "-f", "10N"], "'--strain' / '-s'. Try 'fascicle recruit --help'."),
        (["forse"], "No such command 'forse'"),
        (["force"], "Missing argument 'FILE'"),
        (["--nope"], "No such option: --nope"),
    ],
)
def test_other_commands(refused, arguments, message):
    assert message in refused(*arguments)


def test_reproduce_into_a_file(refused, tmp_path):
    (tmp_path / "file").write_text("kept")
    assert "it is no folder" in refused("reproduce", "kim2021", "--out", "file")
    assert "can't be made" in refused("reproduce", "kim2021", "--out", "file/out")


def test_init_keeps_what_is_there(refused, fascicle, tmp_path):
    (tmp_path / "m.toml").write_text("mine")
    assert "--overwrite replaces it" in refused("init", "m.toml")
    assert "no example is named" in refused("init", "n.toml", "--from", "nobody")
    assert "it is a folder" in refused("init", ".")
    assert "no such folder" in refused("init", "no/m.toml")
    assert fascicle("init", "m.toml", "--force")[0] == 0


def test_reproduce_onto_a_full_disk(refused, monkeypatch):
    def run(_folder, _progress):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("reproduction.kim2021.reproduction.run", run)
    message = refused("reproduce", "kim2021", "--out", "made")
    assert message == "--out made: can't be written: No space left on device."


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["export", SIX, "--table", "t"], "computing the table"),
        (["force", SIX, "--plot", "f.png"], "drawing the picture"),
        (["init", "m.toml"], "loading the laws"),
    ],
)
def test_what_lasts_is_told_on_a_terminal_and_nowhere_else(fascicle, monkeypatch, arguments, words):
    from fascicle.cli import outputs

    assert fascicle(*arguments)[2] == ""
    shown = []
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    # in another command's line, as one that lasts longer tells it
    monkeypatch.setattr(outputs, "_updates", [shown.append])
    code, _, _ = fascicle(*arguments, "--force")
    assert code == 0 and any(words in one for one in shown)


def pipe(path):
    os.mkfifo(path)


def loop(path):
    path.symlink_to(path)


def device(path):
    path.symlink_to("/dev/zero")


READ = [
    ["force", "{}"], ["free-strain", "{}"], ["bundle", "{}"], ["space", "{}"],
    ["recruit", "{}", "--force", "1N", "--strain", "0.1"], ["efficiency", "{}"],
    ["simulate", "{}"], ["simulate", "{}", "--compare"], ["record", "{}", "-o", "y.csv"],
    ["calibrate", "{}", "-m", SIX], ["calibrate", "d.csv", "-m", "{}"], ["design", "{}"],
    ["sweep", "{}", "--workers", "0"], ["export", "{}", "--c", "y"],
    ["export", "{}", "--fmu", "y.fmu"], ["explore", "{}", "--no-show"],
]  # fmt: skip


@pytest.mark.parametrize("kind", [pipe, loop, device])
@pytest.mark.parametrize("command", READ, ids=lambda words: "-".join(words[:2]))
def test_what_is_no_regular_file_is_not_read(fascicle, tmp_path, command, kind):
    """A named pipe without a writer was waited for for ever."""
    (tmp_path / "d.csv").write_text("pressure [kPa],strain,force [N]\n100,0.1,1\n")
    kind(tmp_path / "x.toml")
    code, _, err = fascicle(*(word.format("x.toml") for word in command))
    assert code == 2 and err.count("\n") == 1 and "x.toml" in err, err
    assert sorted(one.name for one in tmp_path.iterdir()) == ["d.csv", "x.toml"]


WRITTEN = [
    ["force", SIX, "--out", "{}.csv"], ["force", SIX, "--out", "{}.zarr"],
    ["force", SIX, "--csv={}"], ["force", SIX, "--plot", "{}.png"],
    ["simulate", "lift_gas", "--report", "{}.html"], ["record", SIX, "-o", "{}"],
    ["calibrate", "d.csv", "-m", SIX, "-o", "{}"], ["design", "t.toml", "-o", "{}"],
    ["sweep", "t.toml", "--workers", "0", "-o", "{}"], ["init", "{}"],
    ["sweep", "t.toml", "--workers", "0", "-o", "{}/inside"], ["reproduce", "kim2021", "-o", "{}"],
    ["export", SIX, "--c", "{}"], ["export", SIX, "--table", "{}"],
    ["export", SIX, "--fmu", "{}.fmu"],
]  # fmt: skip


@pytest.mark.parametrize("kind", [pipe, loop])
@pytest.mark.parametrize("command", WRITTEN, ids=lambda words: "-".join((words[0], words[-1])))
def test_what_is_no_regular_file_or_folder_is_not_written(fascicle, tmp_path, command, kind):
    pytest.importorskip("zarr", reason="needs the extra `sweep`")
    (tmp_path / "d.csv").write_text("pressure [kPa],strain,force [N]\n100,0.1,1\n")
    assert fascicle("init", "t.toml", "--task")[0] == 0
    words = [word.format("x") for word in command]
    name = words[-1].partition("=")[2] or words[-1].partition("/")[0]
    kind(tmp_path / name)
    before = sorted(tmp_path.iterdir())
    code, out, err = fascicle(*words)
    assert (code, out) == (2, "") and err.count("\n") == 1 and name in err, err
    assert "kept" not in err  # nothing was begun
    assert sorted(tmp_path.iterdir()) == before


def test_headers_beside_pipes_are_not_written(fascicle, tmp_path):
    (tmp_path / "c").mkdir()
    pipe(tmp_path / "c" / "muscle.h")
    code, _, err = fascicle("export", SIX, "--table", "c")
    assert code == 2 and "muscle.h" in err and err.count("\n") == 1

"""Bad input: one line on standard error, exit code 2, nothing half written."""

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
SIX, PAIR, TEN = "kim2021_figure_6", "kim2021_bundle_1_1", "kim2021_slenderness_10"
RECORD = "pressure [kPa],strain,force [N]\n100,0.1,1\n"
SIZES = "--length 127mm --outer-radius 6.35mm --wall-thickness 1.6mm --braid-angle 33deg"


# lines, and what their message names: an option, a key, a value, or the remedy
LINES = [
    # quantities, lists and ranges
    (f"force {SIX} --pressure 34.5", "34.5: write it with its unit"),
    (f"force {SIX} --pressure 34.5mm", "'mm' is no unit of pressure"),
    (f"force {SIX} --pressure 34.5kpa", "did you mean 'kPa'?"),
    (f"force {SIX} --pressure 'nan kPa'", "must be finite"),
    (f"force {SIX} --pressure -1kPa", "--pressure must lie in [0, 1e6] Pa"),
    (f"force {SIX} --pressure 1.01MPa", "--pressure must lie in [0, 1e6] Pa"),
    (f"force {SIX} --pressure 0kPa:10kPa", "start:stop:step"),
    (f"force {SIX} --pressure 0kPa:10kPa:0kPa", "step must not be 0"),
    (f"force {SIX} --pressure ''", "--pressure"),
    (f"force {SIX} --pressure 1kPa,,2kPa", "comma"),
    (f"force {SIX} --strain 0.1kPa", "'kPa' is no unit of strain"),
    (f"force {SIX} --strain 0.61", "--strain must lie in (-0.192363, 0.6]"),
    (f"force {SIX} --strain -0.193", "--strain must lie in (-0.192363, 0.6]"),
    (f"force {SIX} --strain 0:0.6:1e-9", "100000 values"),
    (f"force {SIX} --strain 0:0.6:1e-5 -p 0Pa:50Pa:1Pa", "51 x 60001 points"),
    (f"bundle {PAIR} -p 2MPa,0kPa", "--pressure must lie in [0, 1e6] Pa"),
    (f"bundle {PAIR} -p 10kPa", "1 pressures for 2 motor units"),
    (f"free-strain {PAIR} -p 10kPa,20kPa,30kPa", "3 pressures for 2 motor units"),
    (f"bundle {PAIR} -s 0.7", "--strain must lie in"),
    (f"space {PAIR} --supply 413.7", "write it with its unit"),
    (f"space {PAIR} --levels 500kPa", "--levels must lie in"),
    (f"space {PAIR} --strain 0.2,0.1", "--strain must rise"),
    (f"efficiency {PAIR} --strain 0", "--strain must be positive"),
    (f"recruit {PAIR} -f 9N -s 0.1 --supply 2MPa", "--supply must"),
    # options
    (f"force {SIX} --presure 1kPa", "No such option: --presure"),
    (f"force {SIX} extra", "unexpected extra argument"),
    (f"force {SIX} --json g.txt", "unexpected extra argument"),
    (f"force {SIX} --json --csv", "--json and --csv"),
    (f"recruit {PAIR} -f 10N", "'--strain' / '-s'. Try 'fascicle recruit --help'."),
    ("forse", "No such command 'forse'"),
    ("force", "Missing argument 'FILE'"),
    (f"record {TEN}", "Missing option '--out'"),
    ("--nope", "No such option: --nope"),
    ("explore --port 99999", "65535, got 99999. Try 'fascicle explore --help'"),
    (f"record {SIX} --out x.csv --samples 1", "got 1"),
    ("calibrate d.csv --starts x", "got x"),
    (f"free-strain {SIX} --no-resistance", "--no-resistance"),
    (f"efficiency {PAIR} --path isobar", "isobaric, isotonic"),
    (f"efficiency {PAIR} --scheme orderlx", "--scheme 'orderlx' is unknown"),
    (f"efficiency {PAIR} --scheme free", "--path isotonic"),
    (f"recruit {PAIR} -f 40N -s 0.1 --scheme bach", "did you mean 'batch'"),
    ("init --task --scenario", "--task and --scenario"),
    ("init --task --from x", "--task and --from"),
    ("init n.toml --from nobody", "'nobody'"),
    ("init k.toml --scenario --from joint", "joint_step, "),
    ("simulate lift_gas --compare", "[control]"),
    ("simulate lift_gas --policy orderly", "--policy needs a scenario with [control]"),
    ("simulate lift_gas --no-compensate", "--compensate needs a scenario with [control]"),
    ("simulate ramp_hand_over --policy handover", "did you mean 'hand_over'?"),
    ("simulate ramp_hand_over --policy batch --compare", "drop --policy"),
    ("sweep t.toml --workers 1 --scheduler tcp://x", "--scheduler and --workers"),
    # options that were given twice
    (f"force {SIX} -p '1 bar' --pressure='2 bar' -s 0", "--pressure was given twice"),
    (f"force {SIX} -s 0 -s0.1 -s 0.2", "--strain was given 3 times: pass one comma-separated list"),
    (f"recruit {PAIR} -f 20N -f 40N -s 0.1", "--force was given twice"),
    (f"space {PAIR} --supply 1bar --supply 2bar", "--supply was given twice: give it once"),
    ("design t.toml --seed 1 --seed 2", "--seed was given twice"),
    # muscles, bundles, scenarios and tasks
    ("force nowhere.toml", "nowhere.toml: no such file"),
    ("force no/where.toml", "no/where.toml: no such file"),
    ("force kim2021_figur_6", "did you mean kim2021_figure_6?"),
    ("force xyz", "kim2021_figure_6"),
    ("force .", "a folder"),
    (f"force {'x' * 300}", "no such file"),
    ("force 'a\nb'", "no such file"),
    (f"force {PAIR}", "use `fascicle bundle`"),
    (f"record {PAIR} -o x.csv", "fascicle record"),
    (f"bundle {SIX}", "--pressure is required"),
    (f"space {SIX}", "--supply is required"),
    (f"recruit {SIX} -f 20N -s 0.1", "--supply is required"),
    ("force lift_gas", "fascicle simulate"),
    ("simulate lift_gass", "did you mean lift_gas?"),
    (f"simulate {SIX}", "joint_gait"),
    ("muscles kim2021_figur_6", "did you mean kim2021_figure_6?"),
    ("muscles festo-dmsp-20-300 --measured", "a name prints one muscle"),
    ("reproduce kim2020", "kim2020"),
    ("force t.toml", "t.toml: task: a task, not a muscle or bundle: `fascicle design`"),
    ("simulate t.toml", "`fascicle design`"),
    ("design m.toml", "`fascicle force`"),
    ("design s.toml", "s.toml: load: a scenario, not a task: `fascicle simulate`"),
    # outputs
    (f"force {SIX} --out no/x.nc", "--out no/x.nc: can't be written: no such folder"),
    (f"force {SIX} --out x.xls", ".nc, .zarr, .csv, .json"),
    (f"force {SIX} --out folder.nc", "it is a folder"),
    (f"force {SIX} --out d.csv/x.nc", "no such folder"),
    (f"force {SIX} --plot no/x.png", "--plot no/x.png: can't be written: no such folder"),
    (f"force {SIX} --plot x.jpg", ".png, .svg"),
    ("simulate lift_gas --report a.pdf", ".html"),
    ("reproduce kim2021 --out d.csv", "it is no folder"),
    ("reproduce kim2021 --out d.csv/out", "can't be created"),
    ("init folder.nc", "it is a folder"),
    (f"export {SIX}", "give --table"),
    (f"export {SIX} --table code --precision half", "double, float"),
    (f"export {SIX} --table code --name 2", "name in C"),
    (f"export {SIX} --table code --name a_", "name in C"),
    (f"export {SIX} --table code --name class", "keyword or a standard header of C"),
    (f"export {SIX} --table code --name math", "keyword or a standard header of C"),
    (f"export {SIX} --fmu code", ".fmu"),
    (f"export {SIX} --fmu a.fmu --sample-time '0 s'", "must be positive"),
    (f"export {SIX} --fmu a.fmu --platform plan9", "darwin64, linux64, win64"),
    ("export lift_gas --page other.html", "--table"),
    ("export ramp_hand_over --table other", "orderly or threshold"),
    # record
    (f"record {SIX} -o x.csv --noise 5", "--noise must lie in [0, 1), got 5"),
    (f"record {SIX} -o x.csv --noise 5N", "write 5 %"),
    (f"record {SIX} -o x.csv --mullins x", "--mullins"),
    (f"record {SIX} -o x.csv --resolution 1", "write it with its unit"),
    (f"record {SIX} -o x.csv --angle-scatter 60deg", "--angle-scatter must lie in [0, 11.46] deg"),
    (f"record {SIX} -o x.csv -p 0kPa", "at least one pressure above 0 Pa"),
    (f"record {SIX} -o x.csv --samples 1000000", "points"),
    # calibrate
    ("calibrate d.csv --length 127mm --braid-angle 33deg", "--outer-radius, --wall-thickness"),
    ("calibrate d.csv -m no.toml", "no.toml: no such file"),
    (f"calibrate d.csv -m {PAIR}", "give --muscle"),
    (f"calibrate d.csv -m {TEN} --length 127", "--length"),
    (f"calibrate d.csv -m {TEN} --collapse nobody", "--collapse 'nobody' is unknown"),
    (f"calibrate d.csv -m {TEN} --ends loose", "--ends 'loose' is unknown"),
    (f"calibrate d.csv {SIZES} --material steel", "--material 'steel' is unknown"),
    (f"calibrate d.csv -m {TEN} --fit c10,c11", "--fit 'c11' is unknown: did you mean 'c10'?"),
    (f"calibrate d.csv -m {TEN} --fit ''", "--fit '' is unknown"),
    (f"calibrate d.csv -m {TEN} --fit c10 --fit c01", "--fit was given twice"),
    (f"calibrate d.csv -m {TEN} --fit tuning,c10", "tuning"),
    (f"calibrate d.csv -m {TEN} --prior foo=12mm,1mm", "--prior 'foo' is unknown"),
    (f"calibrate d.csv -m {TEN} --prior c10", "--prior 'c10': write NAME=VALUE"),
    (f"calibrate d.csv -m {TEN} --prior c10=1kPa", "standard deviation"),
    (f"calibrate d.csv -m {TEN} --prior c10=1kPa,0kPa", "must be positive, got 0kPa"),
    (f"calibrate d.csv -m {TEN} --fit c10 --prior c10=1mm,2kPa", "'mm' is no unit of"),
    (f"calibrate d.csv -m {TEN} --fit c10 --prior c10=-1kPa,2kPa", "must be positive"),
    (f"calibrate d.csv -m {TEN} --fit c01 --prior c10=1kPa,2kPa", "add it to --fit"),
    (f"calibrate d.csv -m {TEN} --loss huber", "--loss 'huber' is unknown"),
    (f"calibrate d.csv -m {TEN} --weights heavy", "--weights 'heavy' is unknown"),
    (f"calibrate d.csv -m {TEN} --loss cauchy --posterior", "--posterior: needs --loss linear"),
    (f"calibrate d.csv -m {TEN} --rest-length 0mm", "--rest-length must be positive"),
    (f"calibrate d.csv -m {TEN} --column force=nothing", "nothing"),
    (f"calibrate d.csv -m {TEN} --column foo=way", "--column has the unknown key 'foo'"),
    (f"calibrate d.csv -m {TEN} --unit force", "--unit 'force': write NAME=VALUE"),
    (f"calibrate d.csv -m {TEN} --out no/where", "--out no/where: can't be written"),
]


@pytest.mark.parametrize(("line", "words"), LINES, ids=lambda x: x[:60])
def test_a_line_that_is_refused(fascicle, refused, tmp_path, line, words):
    (tmp_path / "folder.nc").mkdir()
    (tmp_path / "d.csv").write_text(RECORD)
    (tmp_path / "m.toml").write_text(MUSCLE)
    for name, kind in (("t.toml", "--task"), ("s.toml", "--scenario")):
        if name in line:
            assert fascicle("init", name, kind)[0] == 0
    assert words in refused(line)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("length", "lenght", 'm.toml: muscle.lenght: unknown key, did you mean "length"?'),
        ('"127 mm"', "127", "muscle.length = 127"),
        ('"127 mm"', '"127 kPa"', "'kPa' is no unit of length"),
        ('"127 mm"', '"nan mm"', "finite"),
        ('"127 mm"', '"-127 mm"', "must be positive"),
        ("1.6 mm", "6.35 mm", "`wall_thickness` must be less than `outer_radius`"),
        ("33 deg", "54.7357 deg", "`braid_angle` must lie in (0, 54.7356) deg"),
        ("format = 1", "format = ", "m.toml: not TOML: "),
        ("33 deg", "33 deg\" # \x00", "m.toml"),
        ("[muscle]", "[muscle.a]\n[muscle.b]", "m.toml"),
        ('"33 deg"\n', '"33 deg"\n[bundle]\n', "`motor_units` must hold at least one"),
    ],
)  # fmt: skip
def test_a_wrong_file(refused, tmp_path, old, new, words):
    (tmp_path / "m.toml").write_text(MUSCLE.replace(old, new, 1))
    assert words in refused("force m.toml --out x.nc")


def test_binary_rubbish(refused, tmp_path):
    (tmp_path / "m.toml").write_bytes(bytes(range(256)) * 40)
    assert "m.toml: not a text file" in refused("force m.toml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pressure,strain,force [N]\n100,0.1,1\n", "--unit pressure='kPa'"),
        ("pressure [kPa],strain,load (g)\n100,0.1,1\n", "--unit force='gf'"),
        ("pressure [kN],strain,force [N]\n100,0.1,1\n", "'kN' is no unit of pressure"),
        ("force 1 [N],force 2 [N],strain\n100,0.1,1\n", "--column"),
        ("pressure [kPa],length [mm],force [N]\n100,nan,1\n", "in line 2"),
    ],
)
def test_a_record_is_asked_about_by_options(refused, tmp_path, text, words):
    (tmp_path / "x.csv").write_text(text)
    assert words in refused("calibrate", "x.csv", "--muscle", TEN)


def test_a_full_disk(refused, monkeypatch, tmp_path):
    def run(_folder, _progress):
        raise OSError(errno.ENOSPC, "No space left on device")

    (tmp_path / "made").mkdir()
    monkeypatch.setattr("reproduction.kim2021.reproduction.run", run, raising=False)
    assert refused("reproduce kim2021 --out made").startswith("--out made: can't be written: No sp")


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
    f"force {SIX} --out {{}}.csv", f"force {SIX} --out {{}}.zarr",
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

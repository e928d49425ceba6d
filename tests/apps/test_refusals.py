"""Bad input: one line on standard error, exit code 2, nothing half written."""

import os

import pytest


SIX, PAIR, TEN = "kim2021_figure_6", "kim2021_bundle_1_1", "kim2021_slenderness_10"
RECORD = "pressure [kPa],strain,force [N]\n100,0.1,1\n"


# lines, and what their message names: an option, a key, a value, or the remedy
LINES = [
    # quantities, lists and ranges
    (f"force {SIX} --pressure 34.5", "34.5: write it with its unit"),
    (f"force {SIX} --pressure 0kPa:10kPa", "start:stop:step"),
    (f"force {SIX} --strain 0.61", "--strain must lie in (-0.192363, 0.6]"),
    (f"bundle {PAIR} -p 10kPa", "1 pressures for 2 motor units"),
    (f"space {PAIR} --strain 0.2,0.1", "--strain must rise"),
    (f"efficiency {PAIR} --strain 0", "--strain must be positive"),
    # options
    (f"force {SIX} --presure 1kPa", "No such option: --presure"),
    (f"force {SIX} extra", "unexpected extra argument"),
    (f"force {SIX} --json --csv", "--json and --csv"),
    ("forse", "No such command 'forse'"),
    ("explore --port 99999", "65535, got 99999. Try 'fascicle explore --help'"),
    (f"free-strain {SIX} --no-resistance", "--no-resistance"),
    (f"efficiency {PAIR} --scheme free", "--path isotonic"),
    ("init --task --scenario", "--task and --scenario"),
    ("simulate lift_gas --compare", "[control]"),
    ("simulate lift_gas --units 1,4", "--units"),
    ("simulate lift_gas --mass 3kg", "[load]"),
    ("simulate kim2021_figure_6 --mass 3mm", "--mass"),
    (f"design {SIX} --units 1,4 --mass 10kg", "--stroke"),
    (f"design {PAIR} --units 1,4 --mass 10kg --stroke 15mm", "--units"),
    ("simulate kim2021_bundle_1_4 --units 1,4", "--units"),
    ("simulate ramp_hand_over --policy batch --compare", "drop --policy"),
    ("sweep t.toml --workers 1 --scheduler tcp://x", "--scheduler and --workers"),
    # options that were given twice
    (f"force {SIX} -s 0 -s0.1 -s 0.2", "--strain was given 3 times: pass one comma-separated list"),
    # muscles, bundles, scenarios and tasks
    ("force nowhere.toml", "nowhere.toml: no such file"),
    ("force kim2021_figur_6", "did you mean kim2021_figure_6?"),
    (f"force {'x' * 300}", "neither a file nor a named"),
    (f"force {PAIR}", "use `fascicle bundle`"),
    (f"bundle {SIX}", "--pressure is required"),
    ("force lift_gas", "fascicle simulate"),
    ("muscles festo-dmsp-20-300 --measured", "a name prints one muscle"),
    ("force t.toml", "t.toml: task: a task, not a muscle or bundle: `fascicle design`"),
    ("design s.toml", "s.toml: load: a scenario, not a task: `fascicle simulate`"),
    # outputs
    (f"force {SIX} --out no/x.nc", "--out no/x.nc: can't be written: no such folder"),
    (f"force {SIX} --out x.xls", ".nc, .csv, .json"),
    ("reproduce kim2021 --out d.csv", "--out d.csv: can't be written"),
    (f"export {SIX}", "give --table"),
    (f"export {SIX} --table code --name class", "keyword or a standard header of C"),
    (f"export {SIX} --fmu a.fmu --platform plan9", "darwin64, linux64, win64"),
    # record
    (f"record {SIX} -o x.csv --noise 5", "--noise must lie in [0, 1), got 5"),
    # calibrate
    ("calibrate d.csv --length 127mm --braid-angle 33deg", "--outer-radius, --wall-thickness"),
    ("calibrate d.csv -m no.toml", "no.toml: no such file"),
    (f"calibrate d.csv -m {TEN} --collapse nobody", "--collapse 'nobody' is unknown"),
    (f"calibrate d.csv -m {TEN} --fit c10,c11", "--fit 'c11' is unknown: did you mean 'c10'?"),
    (f"calibrate d.csv -m {TEN} --prior foo=12mm,1mm", "--prior 'foo' is unknown"),
    (f"calibrate d.csv -m {TEN} --fit c01 --prior c10=1kPa,2kPa", "--prior"),
    (f"calibrate d.csv -m {TEN} --loss huber", "--loss 'huber' is unknown"),
    (f"calibrate d.csv -m {TEN} --loss soft_l1 --posterior", "--posterior: needs --loss linear"),
    (f"calibrate d.csv -m {TEN} --column force=nothing", "nothing"),
]


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

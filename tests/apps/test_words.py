"""Refusals speak of what was typed: options, keys and units, and the kind of file that it is."""

import pytest

import fascicle as fs


SIX, PAIR = "kim2021_figure_6", "kim2021_bundle_1_4"
SIZES = ("--length", "300mm", "--outer-radius", "12mm", "--wall-thickness", "2mm",
         "--braid-angle", "25deg")  # fmt: skip
DATA = "pressure [kPa],strain [%],force [N]\n100,0,200\n100,10,100\n200,0,400\n200,10,220\n"


@pytest.fixture
def said(fascicle, tmp_path):
    """Run a command that must be refused, in a folder with data and a file of each kind."""
    (tmp_path / "d.csv").write_text(DATA)
    for arguments in (["m.toml"], ["t.toml", "--task"], ["s.toml", "--scenario"]):
        assert fascicle("init", *arguments)[0] == 0

    def run(*arguments):
        code, out, err = fascicle(*arguments)
        assert (code, out) == (2, "") and err.count("\n") == 1
        return err.removeprefix("error: ").rstrip()

    return run


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--unit", "kraft=kN"], "--unit has the unknown key 'kraft'"),
        (["--column", "foo=way"], "--column has the unknown key 'foo'"),
        (
            ["--fit", "braid_angle,outer_radius", "--prior", "c10=100kPa,1kPa"],
            "--prior c10=100kPa,1kPa: c10 isn't fitted: add it to --fit, or drop the prior.",
        ),
        (["--prior", "foo=12mm,1mm"], "--prior 'foo' is unknown: choose one of"),
        (
            ["--prior", "outer_radius=12mm,0mm"],
            "--prior outer_radius=12mm,0mm: its standard deviation must be positive, got 0mm.",
        ),
        (["--fit", "c10,c11", "--prior", "c01=1kPa,1kPa"], "--fit 'c11' is unknown: did you mean"),
    ],
)
def test_calibrate(said, arguments, message):
    assert said("calibrate", "d.csv", *SIZES, *arguments).startswith(message)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--angle-scatter", "60deg"], "--angle-scatter must lie in [0, 11.46] deg, got 60 deg."),
        (["--length-scatter", "60%"], "--length-scatter must lie in [0, 0.2] of the length"),
        (["--noise", "5"], "--noise must lie in [0, 1), got 5: write 5 %."),
        (["--noise", "5N"], "--noise must be a share, got '5N': write 5 %."),
        (["--mullins", "x"], "`--mullins` must be a number"),
    ],
)
def test_record(said, arguments, message):
    assert said("record", SIX, "-o", "x.csv", *arguments).startswith(message)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["record", PAIR, "-o", "x.csv"],
            f"{PAIR}: a bundle, not a muscle: run `fascicle record` on each of its muscles.",
        ),
        (
            ["calibrate", "d.csv", "--muscle", PAIR],
            f"{PAIR}: a bundle, not a muscle: give --muscle the file of one of its muscles.",
        ),
        *(
            ([*command, SIX], "--supply: missing, a muscle has none of its own: give one, such as")
            for command in (["recruit", "-f", "20N", "-s", "0.1"], ["space"], ["efficiency"])
        ),
        (["force", SIX, "--json", "g.txt"], "--json g.txt: the file's name must end in .json."),
        (["force", SIX, "--csv", "g.json"], "--csv g.json: the file's name must end in .csv."),
        (["force", SIX, "more"], "Got unexpected extra argument(s) (more) Try"),
        (["force", SIX, "-s", ""], "`--strain` has nothing but an empty entry: give a value, such"),
    ],
)
def test_others(said, arguments, message):
    assert said(*arguments).startswith(message)


TASK = "t.toml: task: a task, not a {}: `fascicle design` takes it."
MUSCLE = "m.toml: muscle: a muscle or bundle, not a {}: `fascicle force` and `fascicle bundle` take"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["force", "t.toml"], TASK.format("muscle or bundle")),
        (["simulate", "t.toml"], TASK.format("scenario")),
        (["design", "m.toml"], MUSCLE.format("task")),
        (["simulate", "m.toml"], MUSCLE.format("scenario")),
        (["design", "s.toml"], "s.toml: load: a scenario, not a task: `fascicle simulate` runs"),
        (["force", "lift_gas"], "lift_gas: a scenario, not a muscle or bundle: use `fascicle sim"),
    ],
)
def test_another_kind_of_file_is_called_by_its_name(said, arguments, message):
    assert said(*arguments).startswith(message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '["28 deg", "33 deg"]',
            '["60 deg"]',
            "t.toml: design.braid_angle: `braid_angle` must lie in (0, 54.7356) deg, got 60 deg.",
        ),
        ('"all"  ', '["1+a"]', "t.toml: design.space: `splits` must be written like '1+4'"),
    ],
)
def test_a_task(said, tmp_path, old, new, message):
    file = tmp_path / "t.toml"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    assert said("design", "t.toml").startswith(message)


@pytest.mark.parametrize("end", ["", "\n", '\nouter_radius = "9 mm"\n'])
def test_a_key_that_is_there_twice_is_named(end):
    text = f'format = 1\n[muscle]\nlength = "127 mm"\nlength = "1 mm"{end}'
    told = "^<text>: not TOML: length is there twice, again on line 4: keep one.$"
    with pytest.raises(ValueError, match=told):
        fs.files.loads(text)

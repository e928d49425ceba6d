import csv
import io
import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose

from fascicle.bundle import recruitment
from fascicle.cli.inputs import cache_folder, read_bundle, read_states
from fascicle.energetics.efficiency import efficiency_map
from fascicle.files import example, example_text, examples, load, save
from reproduction.claims import Claim, Criterion


SIX, PAIR = "kim2021_figure_6", "kim2021_bundle_1_1"

# the specification's table: latex's constants with the silicone's modulus
LATEX_WITH_MODULUS = (
    'material = { c10 = "118.4 kPa", c01 = "105.7 kPa", youngs_modulus = "1.78 MPa" }'
)
TABLE = {
    0.0: "0 -1.77 -2.71 -2.07 -1.47 -1.20 -1.09 -1.08 -1.12 -1.19 -1.30 -1.44",
    34.5e3: "16.36 4.56 -1.74 -3.83 -4.91 -2.85 -1.88 -1.45 -1.28 -1.25 -1.31 -1.41",
    137.9e3: "65.37 48.07 34.75 23.67 13.89 4.81 -3.47 -8.18 -11.76 -6.71 -3.84 -2.54",
}


def answer(fascicle, *arguments):
    code, out, err = fascicle(*arguments)
    assert (code, err) == (0, "")
    return out


@pytest.fixture
def spec_muscle(tmp_path):
    text = example_text(SIX).replace('material = "silicone_kim2021"', LATEX_WITH_MODULUS)
    (tmp_path / "spec.toml").write_text(text)
    return "spec.toml"


@pytest.mark.filterwarnings("default:.*was fitted to")
@pytest.mark.parametrize("command", ["force", "free-strain", "bundle"])
def test_a_catalogs_constants_on_another_muscle_are_told(fascicle, tmp_path, command):
    with pytest.warns(UserWarning, match="was fitted to"):
        save(example(SIX).replace(tension="martens2017_20"), tmp_path / "other.toml")
    code, out, err = fascicle(command, "other.toml", "-p", "100kPa")
    assert code == 0 and out
    assert err.startswith("warning: `martens2017_20` was fitted to a Festo DMSP-20-300")
    assert "this muscle is 12.7 mm wide and 127 mm long" in err and err.count("\n") == 1


def test_force_gives_the_table_of_the_specification(fascicle, spec_muscle):
    out = answer(fascicle, "force", spec_muscle, "-p", "0kPa,34.5kPa,137.9kPa", "--json")
    found = json.loads(out)
    assert list(found) == [
        "pressure", "strain", "force", "mesh", "bladder", "bending", "region", "free_strain",
        "collapse_strain",
    ]  # fmt: skip
    assert found["pressure"] == list(TABLE)
    assert found["strain"] == [float(f"0.{3 * i:02d}") for i in range(12)]
    # the table is rounded to 0.01 N and to 1e-4
    expected = [[float(x) for x in row.split()] for row in TABLE.values()]
    assert_allclose(found["force"], expected, atol=0.00501)
    assert_allclose(found["free_strain"], [0, 0.0459, 0.1664], atol=5.1e-5)
    assert_allclose(found["collapse_strain"], [0.0674, 0.1173, 0.2427], atol=5.1e-5)
    parts = sum(np.array(found[name]) for name in ("mesh", "bladder", "bending"))
    assert_allclose(parts, found["force"], atol=1e-12)
    # 34.5 kPa: buckled from 0.0459 on, collapsed from 0.1173 on
    assert found["region"][1] == [0, 0, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2]


def test_force_prints_the_same_numbers_for_a_reader(fascicle, spec_muscle):
    out = answer(fascicle, "force", spec_muscle, "-p", "0kPa,34.5kPa,137.9kPa")
    for number in ("-1.77 b", "-2.71 b", "-2.07 c", "65.37", "-11.76 b", "0.0459", "0.2427"):
        assert number in out
    assert "nan" not in out


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_narrow_terminals_get_narrow_tables(spec_muscle, fascicle, monkeypatch, encoding):
    monkeypatch.setenv("COLUMNS", "70")
    printed = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(printed, encoding))
    fascicle("force", spec_muscle, "-p", "0kPa:413.7kPa:40kPa", "-s", "0:0.2:0.05")
    lines = printed.getvalue().decode(encoding).splitlines()
    assert max(map(len, lines)) <= 70
    heads = " ".join(lines)
    # heads stand in two lines, the unit below its number; two tables have each pressure once
    counted = re.split(r"[\s|]+", heads)
    assert all(counted.count(f"{40 * i}") >= 2 for i in range(1, 11))
    assert counted.count("kPa") >= 2 * 12  # and 413.7 kPa
    assert "…" not in heads
    assert "?" not in heads


def test_never_collapsing_is_null_in_json(fascicle, tmp_path):
    text = example_text(SIX) + "factor = 50\n"
    (tmp_path / "stiff.toml").write_text(text)
    found = json.loads(
        answer(fascicle, "force", "stiff.toml", "-p", "34.5kPa", "-s", "0.1", "--json")
    )
    assert found["collapse_strain"] == [None]
    assert np.isfinite(found["force"][0][0])


def test_force_as_csv_and_files_agree_with_json(fascicle, tmp_path):
    command = ["force", SIX, "-p", "0kPa,5psi", "-s", "0:0.3:0.1"]
    found = json.loads(answer(fascicle, *command, "--json"))
    table = list(csv.DictReader(io.StringIO(answer(fascicle, *command, "--csv"))))
    assert [float(row["force [N]"]) for row in table] == [x for row in found["force"] for x in row]
    assert [float(row["free_strain [-]"]) for row in table[::4]] == found["free_strain"]
    for name in ("x.nc", "x.csv", "x.json"):
        assert f"wrote {name}" in answer(fascicle, *command, "--out", name)
    assert json.loads((tmp_path / "x.json").read_text()) == found
    assert list(csv.DictReader(io.StringIO((tmp_path / "x.csv").read_text()))) == table
    with xarray.open_dataset(tmp_path / "x.nc") as stored:
        assert_allclose(stored["force"], found["force"], rtol=0)
        assert stored["force"].dims == ("pressure", "strain")
        assert (stored["force"].units, stored["pressure"].units) == ("N", "Pa")
        assert "Kim" in stored["force"].source
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.csv", "x.json", "x.nc"]


def test_force_draws(fascicle, tmp_path):
    for name, magic in (("x.png", b"\x89PNG"), ("x.svg", b"<?xml")):
        answer(fascicle, "force", SIX, "-p", "0kPa,34.5kPa", "-s", "0:0.3:0.1", "--plot", name)
        assert (tmp_path / name).read_bytes().startswith(magic)


def test_free_strain_of_a_muscle(fascicle, tmp_path):
    found = json.loads(answer(fascicle, "free-strain", SIX, "-p", "34.5kPa,344.7kPa", "--json"))
    assert_allclose(found["free_strain"], [0.0634, 0.2515], atol=5.1e-5)  # the specification's
    assert_allclose(found["collapse_strain"], [0.1326, 0.3423], atol=5.1e-5)
    out = answer(fascicle, "free-strain", SIX, "-p", "34.5kPa,344.7kPa", "--plot", "f.png")
    assert (tmp_path / "f.png").read_bytes().startswith(b"\x89PNG")
    assert "0.0634" in out


def test_bundle(fascicle, monkeypatch, tmp_path):
    command = ["bundle", PAIR, "-p", "344.7kPa,0kPa:103.4kPa:51.7kPa", "-s", "0,0.1"]
    found = json.loads(answer(fascicle, *command, "--json"))
    assert found["pressures"] == [[344.7e3, 0], [344.7e3, 51.7e3], [344.7e3, 103.4e3]]
    # a bundle is the sum of its muscles
    pressure, strain = np.array(found["pressures"])[:, None, :], np.array([0, 0.1])[None, :, None]
    muscles = example(SIX.replace("6", "9")).force(pressure, strain)
    assert_allclose(found["unit_force"], muscles, rtol=1e-10, atol=1e-10)
    assert_allclose(found["force"], muscles.sum(axis=-1), rtol=1e-10, atol=1e-10)
    assert_allclose(found["free_strain"], [row[0] for row in found["equilibria"]], atol=1e-10)
    assert all(row[0] for row in found["stable"])
    out = answer(fascicle, *command)
    for number in ("344.7", "51.7", f"{found['free_strain'][1]:.4f}"):
        assert number in out
    table = list(csv.DictReader(io.StringIO(answer(fascicle, *command, "--csv"))))
    assert [float(row["pressures_2 [Pa]"]) for row in table[::2]] == [0, 51.7e3, 103.4e3]
    assert [float(row["free_strain [-]"]) for row in table[::2]] == found["free_strain"]
    monkeypatch.setattr("fascicle.plot.curves._POINTS", 2)  # compiled already for so few
    answer(fascicle, *command, "--plot", "b.svg")
    assert "51.7 kPa" in (tmp_path / "b.svg").read_text()
    # the other commands are the same functions
    free = json.loads(answer(fascicle, "free-strain", *command[1:4], "--json"))
    assert free["free_strain"] == found["free_strain"]
    at_supply = json.loads(answer(fascicle, "bundle", PAIR, "-s", "0", "--json"))
    assert at_supply["pressures"] == [[413.7e3, 0], [413.7e3, 413.7e3]]


def test_without_resistance_the_strongest_unit_decides(fascicle):
    command = ["free-strain", PAIR, "-p", "34.5kPa,137.9kPa", "--no-resistance", "--json"]
    alone = json.loads(
        answer(fascicle, "free-strain", "kim2021_figure_9", "-p", "137.9kPa", "--json")
    )
    found = json.loads(answer(fascicle, *command))
    assert_allclose(found["free_strain"], alone["free_strain"], rtol=1e-12)


def test_a_muscle_is_a_bundle_of_one():
    bundle = read_bundle(SIX)
    assert [int(unit.count) for unit in bundle.motor_units] == [1]
    assert read_states(["34.5kPa"], bundle) == [[34.5e3]]


def test_space(fascicle, tmp_path):
    command = ["space", PAIR, "--levels", "0kPa,413.7kPa", "--strain", "0,0.1,0.2,0.24"]
    found = json.loads(answer(fascicle, *command, "--json"))
    strain, levels = np.array([0, 0.1, 0.2, 0.24]), np.array([0, 413.7e3])
    space = recruitment.space(example(PAIR), levels=levels, strain=strain)
    assert_allclose(found["force"], space.force, rtol=1e-12, atol=1e-12)
    assert_allclose(found["overlap_area"], recruitment.overlap(space).area, rtol=1e-12)
    assert (found["scheme"], found["overlap_states"]) == ("orderly", [[1, 2]])
    assert found["overlap_low"][0][0] is None  # no overlap at rest length
    out = answer(fascicle, *command, "--plot", "s.png")
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")
    for words in ("1 and 2", "orderly", f"{found['overlap_area'][0]:.4g}"):
        assert words in out


def test_efficiency(fascicle, tmp_path):
    command = ["efficiency", PAIR, "--force", "20N,100N,5kN", "--strain", "0.1"]
    code, out, err = fascicle(*command, "--json")
    assert code == 3
    assert err == (
        "not all points are reached (66.7 % isobaric, 66.7 % isotonic): the others have no"
        " efficiency.\n"
    )
    found = json.loads(out)
    assert found["path"] == ["isobaric", "isotonic"]
    for path, grid, average in zip(
        found["path"], found["efficiency"], found["average"], strict=True
    ):
        expected = efficiency_map(example(PAIR), None, path, [20.0, 100.0, 5e3], [0.1])
        assert_allclose([row[0] for row in grid[:2]], expected.efficiency[:2, 0], rtol=1e-12)
        assert grid[2] == [None]  # 5 kN is out of reach
        assert average == pytest.approx(expected.average, rel=1e-12)
    assert found["reached"] == [2 / 3, 2 / 3]
    code, out, _ = fascicle(*command, "--plot", "e.png")
    assert code == 3
    assert (tmp_path / "e.png").read_bytes().startswith(b"\x89PNG")
    for words in ("isobaric", "isotonic", f"{found['average'][0]:.4f}", "67 %"):
        assert words in out


def test_muscles_lists_the_examples(fascicle):
    out = answer(fascicle, "muscles")
    assert [line.split()[0] for line in out.splitlines()] == list(examples())
    assert json.loads(answer(fascicle, "muscles", "--json")) == examples()
    assert answer(fascicle, "muscles", SIX) == example_text(SIX)


def test_init_writes_files_that_load(fascicle, tmp_path):
    assert answer(fascicle, "init", "mine.toml") == "wrote mine.toml\n"
    assert float(load(tmp_path / "mine.toml").length) == 0.127
    text = (tmp_path / "mine.toml").read_text()
    # what is commented out is valid too
    marked = [line for line in text.splitlines() if line.startswith("# ")]
    keys = [line[2:] for line in marked if line[2:3] == "[" or " = " in line]
    (tmp_path / "all.toml").write_text(text + "\n".join(keys) + "\n")
    assert len(load(tmp_path / "all.toml").motor_units) == 2
    answer(fascicle, "init", "copy.toml", "--from", PAIR)
    assert (tmp_path / "copy.toml").read_text() == example_text(PAIR)


def test_a_file_named_like_an_example_comes_first(fascicle, tmp_path):
    (tmp_path / SIX).write_text(example_text(SIX).replace("127 mm", "200 mm"))
    found = json.loads(answer(fascicle, "free-strain", SIX, "-p", "0kPa", "--json"))
    assert found["free_strain"] == [0]
    (tmp_path / SIX).write_text("rubbish")
    assert fascicle("free-strain", SIX)[0] == 2


def test_help_and_version(fascicle):
    out = answer(fascicle, "--help")
    for command in (
        "force", "free-strain", "bundle", "space", "efficiency", "reproduce", "muscles", "init",
    ):  # fmt: skip
        assert f"  {command} " in out
        assert "Usage: fascicle " + command in answer(fascicle, command, "--help")
    assert answer(fascicle) == out
    assert answer(fascicle, "--version").startswith("fascicle 0.")


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("force kim2021_fig", ["kim2021_figure_6", "kim2021_figure_9"]),
        ("force m", ["mine.toml"]),
        ("force sub/", ["sub/other.toml"]),
        ("space x --scheme o", ["orderly"]),
        ("free", ["free-strain"]),
        ("force nowhere/x", []),
    ],
)
def test_completes(fascicle, monkeypatch, tmp_path, typed, offered):
    (tmp_path / "mine.toml").touch()
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "other.toml").touch()
    monkeypatch.setenv("_FASCICLE_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", f"fascicle {typed}")
    monkeypatch.setenv("COMP_CWORD", str(typed.count(" ") + 1))
    _, out, err = fascicle()
    assert (out.split(), err) == (offered, "")


def test_a_reader_that_is_gone_is_no_error():
    command = [sys.executable, "-m", "fascicle", "muscles", SIX]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 1


def test_a_process_of_its_own_is_quiet(tmp_path):
    """With a cache folder that can't be made, which is no reason to fail or to talk."""
    (tmp_path / "file").write_text("")
    environment = os.environ | {
        "XDG_CACHE_HOME": str(tmp_path / "file"), "FASCICLE_NO_CACHE": "0",
    }  # fmt: skip
    command = [sys.executable, "-m", "fascicle", "free-strain", SIX, "-p", "34.5kPa", "--csv"]
    done = subprocess.run(command, capture_output=True, env=environment, check=True, text=True)
    assert done.stderr == ""
    assert done.stdout.splitlines()[1].startswith("34500.0,0.0634")


def test_compiled_functions_are_kept_where_they_can_be(monkeypatch, tmp_path):
    monkeypatch.delenv("FASCICLE_NO_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "fascicle" / "compiled"
    (tmp_path / "file").write_text("")
    for base in (str(tmp_path / "file"), "relative"):
        monkeypatch.setenv("XDG_CACHE_HOME", base)
        assert cache_folder() is None
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("FASCICLE_NO_CACHE", "1")
    assert cache_folder() is None


def test_control_c_is_quiet(fascicle, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("fascicle.files.shipped_files.example_text", interrupted)
    assert fascicle("muscles", SIX) == (130, "", "")


@pytest.mark.parametrize("verdict", [True, False])
def test_reproduce_lists_claims_and_fails_with_them(fascicle, monkeypatch, tmp_path, verdict):
    """The reproduction itself has its own tests: here a small one stands in."""

    def run(folder, progress):
        progress(0, 1, "Fig. 6")
        (folder / "report.html").write_text("a report")
        number = Criterion("strain left", 0.0674, "<", 0.1 if verdict else 0.05)
        chosen = Criterion(
            "free strain", 0.2403, "=", 0.24, tolerance=0.005, limit_reason="two digits"
        )
        far = Criterion("times", 1.0, ">", 2.0)
        return [
            Claim("a", "Fig. 6", "prediction", "it collapses", "it folds", (number,), "at 0.067"),
            Claim("b", "Sec. 4", "prediction", "it never does", "no", (far,), "it does",
                  explanation="its own sizes"),
            Claim("c", "Sec. 5", "input", "it is 0.24", "0.24", (chosen,), "0.2403",
                  choice="a constant"),
        ]  # fmt: skip

    monkeypatch.setattr("reproduction.kim2021.reproduction.run", run, raising=False)
    code, out, err = fascicle("reproduce", "kim2021", "--out", "made")
    assert (code, err) == (0 if verdict else 1, "")
    for words in ("Fig. 6", "holds" if verdict else "fails", "differs", "its own sizes", "chosen",
                  "“it folds”", "must be >", "Predictions: ", "Inputs: ", "limit)"):  # fmt: skip
        assert words in out
    assert "Definitions" not in out
    assert out.endswith("claims: made/claims.json\nreport: made/report.html\n")
    count = (
        "1 of 2 predictions hold, 1 differs" if verdict else "0 of 2 predictions hold, 1 differs, "
    )
    assert count in out
    assert "1 input was chosen to meet the paper's words.\n" in out
    assert (tmp_path / "made" / "report.html").read_text() == "a report"


@pytest.mark.parametrize("option", ["--json", "--csv"])
def test_json_and_csv_go_to_a_file_or_to_standard_output(fascicle, tmp_path, option):
    end = option[2:]
    printed = answer(fascicle, "force", SIX, "-p", "1bar", "-s", "0,0.1", option)
    for given in ([option, f"a.{end}"], [f"{option}=b"], [option, "-"]):
        out = answer(fascicle, "force", SIX, "-p", "1bar", "-s", "0,0.1", *given)
        assert out == (printed if given[-1] == "-" else "")
    assert (tmp_path / f"a.{end}").read_text() == (tmp_path / "b").read_text() == printed
    # before the muscle's name it stands for itself
    assert answer(fascicle, "force", option, SIX, "-p", "1bar", "-s", "0,0.1") == printed


def test_a_file_of_somebody_elses_is_kept_and_errors_write_none(fascicle, tmp_path):
    (tmp_path / "mine.json").write_text("mine")
    code, out, err = fascicle("force", SIX, "--json", "mine.json")
    assert (code, out) == (2, "") and "--json mine.json: is there already" in err
    assert "--overwrite replaces it" in err and (tmp_path / "mine.json").read_text() == "mine"
    code, _, err = fascicle("force", SIX, "-p", "2MPa", "--json", "none.json")
    assert code == 2 and not (tmp_path / "none.json").exists()
    assert answer(fascicle, "force", SIX, "--json", "mine.json", "--overwrite") == ""
    # what couldn't all be reached is written, and said
    given = ("recruit", PAIR, "-f", "20N,5kN", "-s", "0.1", "--json", "some.json")
    code, out, err = fascicle(*given)
    assert (code, out) == (3, "") and "1 of 2 demands can't be reached" in err
    assert json.loads((tmp_path / "some.json").read_text())["status"] == [[0], [1]]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["force", SIX, "-p", "2MPa"], "error: --pressure must lie in [0, 1e6] Pa (gauge), got"),
        (["force", SIX, "-s", "0.9"], "error: --strain must lie in"),
        (
            ["space", SIX],
            "error: --supply: missing, a muscle has none of its own: give",
        ),
        (["recruit", PAIR, "-f", "9N", "-s", "0.1", "--supply", "2MPa"], "error: --supply must"),
        (["bundle", PAIR, "-p", "2MPa,0kPa"], "error: --pressure must lie in"),
        (["efficiency", PAIR, "--scheme", "orderlx"], "error: --scheme 'orderlx' is unknown"),
        (["efficiency", PAIR, "--scheme", "free"], "error: --path must be 'isotonic' with scheme"),
    ],
)
def test_errors_name_the_options_that_were_typed(fascicle, arguments, words):
    code, out, err = fascicle(*arguments)
    assert (code, out) == (2, "") and err.startswith(words)
    assert err.count("\n") == 1 and "`" not in err and "=" not in err


@pytest.mark.parametrize("columns", [60, 80, 200])
def test_a_table_stays_one_table(fascicle, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    out = answer(fascicle, "force", SIX)
    assert out.count("Force in N by strain") == 1
    assert max(map(len, out.splitlines())) <= columns


def test_a_terminal_is_told_what_is_being_done_and_for_how_long(tmp_path):
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "fascicle", "efficiency", PAIR, "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=theirs, timeout=300)
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:
            break
        if not part:
            break
        shown += part
    os.close(ours)
    assert done.returncode == 0 and json.loads(done.stdout)
    assert b"loading the laws" in shown and b"finding efficiencies" in shown
    assert b"0:00:0" in shown  # the time since it began

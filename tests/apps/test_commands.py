import csv
import io
import json
import os
import subprocess
import sys

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose

from fascicle import records
from fascicle.bundle import recruitment
from fascicle.bundle.efficiency import efficiency_map
from fascicle.cli.inputs import cache_folder, read_bundle, read_states
from fascicle.cli.outputs import print_table
from fascicle.files import example, example_text, examples, load, save
from reproduction.claims import Claim, Criterion


SIX, TEN = "kim2021_figure_6", "kim2021_slenderness_10"
PAIR, BUNDLE = "kim2021_bundle_1_1", "kim2021_bundle_1_4"

# the specification's table: latex's constants with the silicone's modulus
LATEX_WITH_MODULUS = (
    'material = { c10 = "118.4 kPa", c01 = "105.7 kPa", youngs_modulus = "1.78 MPa" }'
)
TABLE = {
    0.0: "0 -1.77 -2.71 -2.07 -1.47 -1.20 -1.09 -1.08 -1.12 -1.19 -1.30 -1.44",
    34.5e3: "16.36 4.56 -1.74 -3.83 -4.91 -2.85 -1.88 -1.45 -1.28 -1.25 -1.31 -1.41",
    137.9e3: "65.37 48.07 34.75 23.67 13.89 4.81 -3.47 -8.18 -11.76 -6.71 -3.84 -2.54",
}


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
    assert "12.7 mm" in err and "127 mm" in err and err.count("\n") == 1


def test_force_gives_the_table_of_the_specification(answer, spec_muscle):
    out = answer("force", spec_muscle, "-p", "0kPa,34.5kPa,137.9kPa", "--json")
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


def test_never_collapsing_is_null_in_json(answer, tmp_path):
    text = example_text(SIX) + "factor = 50\n"
    (tmp_path / "stiff.toml").write_text(text)
    found = json.loads(answer("force", "stiff.toml", "-p", "34.5kPa", "-s", "0.1", "--json"))
    assert found["collapse_strain"] == [None]
    assert np.isfinite(found["force"][0][0])


def test_force_as_csv_and_files_agree_with_json(answer, tmp_path):
    command = ["force", SIX, "-p", "0kPa,5psi", "-s", "0:0.3:0.1"]
    found = json.loads(answer(*command, "--json"))
    table = list(csv.DictReader(io.StringIO(answer(*command, "--csv"))))
    assert [float(row["force [N]"]) for row in table] == [x for row in found["force"] for x in row]
    assert [float(row["free_strain [-]"]) for row in table[::4]] == found["free_strain"]
    for name in ("x.nc", "x.csv", "x.json"):
        assert f"wrote {name}" in answer(*command, "--out", name)
    assert json.loads((tmp_path / "x.json").read_text()) == found
    assert list(csv.DictReader(io.StringIO((tmp_path / "x.csv").read_text()))) == table
    with xarray.open_dataset(tmp_path / "x.nc") as stored:
        assert_allclose(stored["force"], found["force"], rtol=0)
        assert stored["force"].dims == ("pressure", "strain")
        assert (stored["force"].units, stored["pressure"].units) == ("N", "Pa")
        assert "Kim" in stored["force"].source
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.csv", "x.json", "x.nc"]


def test_force_draws(answer, tmp_path):
    for name, magic in (("x.png", b"\x89PNG"), ("x.svg", b"<?xml")):
        answer("force", SIX, "-p", "0kPa,34.5kPa", "-s", "0:0.3:0.1", "--plot", name)
        assert (tmp_path / name).read_bytes().startswith(magic)


def test_free_strain_of_a_muscle(answer, tmp_path):
    found = json.loads(answer("free-strain", SIX, "-p", "34.5kPa,344.7kPa", "--json"))
    assert_allclose(found["free_strain"], [0.0634, 0.2515], atol=5.1e-5)  # the specification's
    assert_allclose(found["collapse_strain"], [0.1326, 0.3423], atol=5.1e-5)
    out = answer("free-strain", SIX, "-p", "34.5kPa,344.7kPa", "--plot", "f.png")
    assert (tmp_path / "f.png").read_bytes().startswith(b"\x89PNG")
    assert "0.0634" in out


def test_bundle(answer, monkeypatch, tmp_path):
    command = ["bundle", PAIR, "-p", "344.7kPa,0kPa:103.4kPa:51.7kPa", "-s", "0,0.1"]
    found = json.loads(answer(*command, "--json"))
    assert found["pressures"] == [[344.7e3, 0], [344.7e3, 51.7e3], [344.7e3, 103.4e3]]
    # a bundle is the sum of its muscles
    pressure, strain = np.array(found["pressures"])[:, None, :], np.array([0, 0.1])[None, :, None]
    muscles = example(SIX.replace("6", "9")).force(pressure, strain)
    assert_allclose(found["unit_force"], muscles, rtol=1e-10, atol=1e-10)
    assert_allclose(found["force"], muscles.sum(axis=-1), rtol=1e-10, atol=1e-10)
    assert_allclose(found["free_strain"], [row[0] for row in found["equilibria"]], atol=1e-10)
    assert all(row[0] for row in found["stable"])
    out = answer(*command)
    for number in ("344.7", "51.7", f"{found['free_strain'][1]:.4f}"):
        assert number in out
    table = list(csv.DictReader(io.StringIO(answer(*command, "--csv"))))
    assert [float(row["pressures_2 [Pa]"]) for row in table[::2]] == [0, 51.7e3, 103.4e3]
    assert [float(row["free_strain [-]"]) for row in table[::2]] == found["free_strain"]
    monkeypatch.setattr("fascicle.plot.curves._POINTS", 2)  # compiled already for so few
    answer(*command, "--plot", "b.svg")
    assert "51.7 kPa" in (tmp_path / "b.svg").read_text()
    # the other commands are the same functions
    free = json.loads(answer("free-strain", *command[1:4], "--json"))
    assert free["free_strain"] == found["free_strain"]
    at_supply = json.loads(answer("bundle", PAIR, "-s", "0", "--json"))
    assert at_supply["pressures"] == [[413.7e3, 0], [413.7e3, 413.7e3]]


def test_without_resistance_the_strongest_unit_decides(answer):
    command = ["free-strain", PAIR, "-p", "34.5kPa,137.9kPa", "--no-resistance", "--json"]
    alone = json.loads(answer("free-strain", "kim2021_figure_9", "-p", "137.9kPa", "--json"))
    found = json.loads(answer(*command))
    assert_allclose(found["free_strain"], alone["free_strain"], rtol=1e-12)


def test_a_muscle_is_a_bundle_of_one():
    bundle = read_bundle(SIX)
    assert [int(unit.count) for unit in bundle.motor_units] == [1]
    assert read_states(["34.5kPa"], bundle) == [[34.5e3]]


def test_space(answer, tmp_path):
    command = ["space", PAIR, "--levels", "0kPa,413.7kPa", "--strain", "0,0.1,0.2,0.24"]
    found = json.loads(answer(*command, "--json"))
    strain, levels = np.array([0, 0.1, 0.2, 0.24]), np.array([0, 413.7e3])
    space = recruitment.space(example(PAIR), levels=levels, strain=strain)
    assert_allclose(found["force"], space.force, rtol=1e-12, atol=1e-12)
    assert_allclose(found["overlap_area"], recruitment.overlap(space).area, rtol=1e-12)
    assert (found["scheme"], found["overlap_states"]) == ("orderly", [[1, 2]])
    assert found["overlap_low"][0][0] is None  # no overlap at rest length
    out = answer(*command, "--plot", "s.png")
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


def test_muscles_lists_the_examples(answer):
    out = answer("muscles")
    assert [line.split()[0] for line in out.splitlines()] == list(examples())
    assert json.loads(answer("muscles", "--json")) == examples()
    assert answer("muscles", SIX) == example_text(SIX)


def test_init_writes_files_that_load(answer, tmp_path):
    assert answer("init", "mine.toml") == "wrote mine.toml\n"
    assert float(load(tmp_path / "mine.toml").length) == 0.127
    text = (tmp_path / "mine.toml").read_text()
    # what is commented out is valid too
    marked = [line for line in text.splitlines() if line.startswith("# ")]
    keys = [line[2:] for line in marked if line[2:3] == "[" or " = " in line]
    (tmp_path / "all.toml").write_text(text + "\n".join(keys) + "\n")
    assert len(load(tmp_path / "all.toml").motor_units) == 2
    answer("init", "copy.toml", "--from", PAIR)
    assert (tmp_path / "copy.toml").read_text() == example_text(PAIR)


def test_a_file_named_like_an_example_comes_first(fascicle, answer, tmp_path):
    (tmp_path / SIX).write_text(example_text(SIX).replace("127 mm", "200 mm"))
    found = json.loads(answer("free-strain", SIX, "-p", "0kPa", "--json"))
    assert found["free_strain"] == [0]
    (tmp_path / SIX).write_text("rubbish")
    assert fascicle("free-strain", SIX)[0] == 2


def test_help_and_version(answer):
    out = answer("--help")
    for command in (
        "force", "free-strain", "bundle", "space", "efficiency", "reproduce", "muscles", "init",
    ):  # fmt: skip
        assert f"  {command} " in out
        assert "Usage: fascicle " + command in answer(command, "--help")
    assert answer() == out
    assert answer("--version").startswith("fascicle 0.")


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
def test_json_and_csv_go_to_a_file_or_to_standard_output(answer, tmp_path, option):
    end = option[2:]
    printed = answer("force", SIX, "-p", "1bar", "-s", "0,0.1", option)
    for given in ([option, f"a.{end}"], [f"{option}=b"], [option, "-"]):
        out = answer("force", SIX, "-p", "1bar", "-s", "0,0.1", *given)
        assert out == (printed if given[-1] == "-" else "")
    assert (tmp_path / f"a.{end}").read_text() == (tmp_path / "b").read_text() == printed
    # before the muscle's name it stands for itself
    assert answer("force", option, SIX, "-p", "1bar", "-s", "0,0.1") == printed


def test_a_file_is_written_with_what_could_be_reached(fascicle, refused, tmp_path):
    (tmp_path / "mine.json").write_text("mine")
    assert "--json mine.json" in refused("force", SIX, "--json", "mine.json")
    refused("force", SIX, "-p", "2MPa", "--json", "none.json")
    line = ("recruit", PAIR, "-f", "20N,5kN", "-s", "0.1", "--json", "some.json")
    code, out, err = fascicle(*line)
    assert (code, out) == (3, "") and err.startswith("1 of 2 demands")
    assert json.loads((tmp_path / "some.json").read_text())["status"] == [[0], [1]]


def test_recruit(fascicle, answer):
    line = ("recruit", BUNDLE, "-s", "0.12", "--supply", "60psi")
    found = json.loads(answer(*line, "-f", "40N", "--json"))
    assert found["status"] == [[0]] and found["state"] == [[1]]
    force = example(BUNDLE).force(found["pressures"][0][0], 0.12)
    assert_allclose(force, 40.0, atol=1e-9)
    code, out, err = fascicle(*line, "-f", "40N,9kN", "--out", "x.csv")
    assert code == 3 and err.startswith("1 of 2 demands") and err.count("\n") == 1
    for part in ("demand [N]", "P2 [kPa]", "other solutions", "9000 N at a strain of 0.12",
                 "wrote x.csv"):  # fmt: skip
        assert part in out
    assert "nan" not in out


def test_record_writes_a_labelled_file_that_reads_back(answer, tmp_path):
    line = ("record", TEN, "--out", "d.csv", "-p", "0kPa:200kPa:100kPa", "--samples", "5",
            "--noise", "1%", "--seed", "7")  # fmt: skip
    found = json.loads(answer(*line, "--clip", "--json"))
    assert found["synthetic"] is True and found["readings"] == 3 * 2 * 5
    assert "synthetic" in (tmp_path / "d.csv").read_text().splitlines()[0]
    record = records.load(tmp_path / "d.csv")
    assert record.synthetic and len(record) == found["readings"]
    assert found["censored"] == record.censored.sum() > 0
    assert found["largest_force"] == record.force.max()
    assert sorted(set(record.pressure)) == [0.0, 100e3, 200e3]
    # the same seed, without the gauge's limit, and over the file that is there
    assert "synthetic" in answer(*line, "--overwrite")
    np.testing.assert_array_equal(
        np.maximum(records.load(tmp_path / "d.csv").force, 0), record.force
    )


@pytest.mark.parametrize(
    ("width", "line"),
    [
        (60, f"force {SIX}"),
        (70, f"force {SIX} -p 0kPa:413.7kPa:40kPa -s 0:0.2:0.05"),
        (60, f"recruit {BUNDLE} -f 100N -s 0.1"),
        (60, "recruit kim2021_bundle_five -f 20N,100N -s 0.1"),
        (60, "simulate lift_gas"),
        (100, f"efficiency {BUNDLE} --force 20N --path isobaric"),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_a_narrow_terminal_gets_narrow_tables(fascicle, monkeypatch, width, line, encoding):
    monkeypatch.setenv("COLUMNS", str(width))
    printed = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(printed, encoding))
    fascicle(*line.split())
    lines = printed.getvalue().decode(encoding).splitlines()
    assert lines and max(map(len, lines)) <= width
    assert not any("…" in line or "?" in line for line in lines)


def test_first_columns_stand_beside_every_part(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "24")
    heads = ["aa", "bb", *(f"c{i}wide" for i in range(5))]
    print_table("Title", heads, [[*"12", *("9.9999" for _ in range(5))]], keys=2)
    lines = capsys.readouterr().out.splitlines()
    tops = [line.split() for line in lines if "wide" in line]
    assert len(tops) > 1 and all(top[:2] == ["aa", "bb"] for top in tops)
    assert [head for top in tops for head in top[2:]] == heads[2:]


def test_a_terminal_sees_what_is_done(tmp_path):
    """On standard error alone: what is printed stays whole."""
    pty = pytest.importorskip("pty")
    command = [sys.executable, "-m", "fascicle", "efficiency", PAIR, "--json"]
    terminal, end = pty.openpty()
    with (tmp_path / "out.json").open("w") as printed:
        process = subprocess.Popen(command, stdout=printed, stderr=end)
    os.close(end)
    seen = b""
    with process, os.fdopen(terminal, "rb", buffering=0) as screen:
        try:
            while some := screen.read(4096):
                seen += some
        except OSError:  # Linux says so where nobody writes anymore
            pass
    assert process.returncode == 0 and json.loads((tmp_path / "out.json").read_text())
    assert b"loading the laws" in seen and b"finding efficiencies" in seen
    assert b"0:00:0" in seen  # the time since it began

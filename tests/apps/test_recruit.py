"""`fascicle recruit`."""

import json
import os
import pty
import subprocess
import sys

import pytest
from numpy.testing import assert_allclose

import fascicle as fs


BUNDLE = "kim2021_bundle_1_4"


def test_the_pressures_printed_give_the_force(fascicle):
    code, out, err = fascicle(
        "recruit", BUNDLE, "-f", "40N", "-s", "0.12", "--supply", "60psi", "--json"
    )
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert found["status"] == [[0]] and found["state"] == [[1]]
    force = fs.example(BUNDLE).force(found["pressures"][0][0], 0.12)
    assert_allclose(force, 40.0, atol=1e-9)


def test_a_table_and_a_line_for_what_is_out_of_reach(fascicle):
    code, out, err = fascicle(
        "recruit", BUNDLE, "-f", "40N,9kN", "-s", "0.12", "--supply", "60psi", "--out", "x.csv"
    )
    assert code == 3 and err.startswith("1 of 2 demands can't be reached") and err.count("\n") == 1
    for part in ("demand N", "P2 kPa", "other solutions", "wrote x.csv"):
        assert part in out
    assert "9000 N at a strain of 0.12 is more than can be reached: the nearest is" in out
    assert "nan" not in out


def test_a_narrow_terminal_keeps_one_table_with_all_solutions(fascicle, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    code, out, _ = fascicle("recruit", BUNDLE, "-f", "100N", "-s", "0.1")
    assert code == 0 and out.count("Recruitment") == 1
    assert max(map(len, out.splitlines())) <= 60
    found = fs.recruitment.recruit(fs.example(BUNDLE), 100.0, 0.1).solutions
    others = [f"2: {pressure / 1e3:.6g} kPa" for pressure in found.pressure[1:3]]
    assert all(any(line.rstrip().endswith(one) for line in out.splitlines()) for one in others)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-f", "40", "-s", "0.1"], "--force"),
        (["-f", "40N", "-s", "0.9"], "--strain must lie in"),
        (["-f", "40N", "-s", "0.1", "--scheme", "bach"], "did you mean 'batch'"),
        (["-s", "0.1"], "--force"),
    ],
)
def test_bad_input_is_one_line(fascicle, options, message):
    code, out, err = fascicle("recruit", "kim2021_bundle_1_1", *options)
    assert (code, out) == (2, "")
    assert message in err and err.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["recruit", BUNDLE, "-f", "40N,60N", "-s", "0.1,0.12"], "the pressures of 4 demands"),
        (["space", BUNDLE, "--strain", "0,0.1"], "what each state reaches"),
    ],
)
def test_a_terminal_sees_what_is_done(options, told, tmp_path):
    """On standard error alone: what is printed stays whole."""
    command = [sys.executable, "-m", "fascicle", *options, "--scheme", "free", "--json"]
    terminal, end = pty.openpty()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=end, cwd=tmp_path)
    os.close(end)
    seen = b""
    with process, os.fdopen(terminal, "rb", buffering=0) as screen:
        try:
            while some := screen.read(4096):
                seen += some
        except OSError:  # Linux says so where nobody writes anymore
            pass
        assert json.loads(process.stdout.read())["strain"]
    assert process.returncode == 0 and told in seen.decode()


def test_an_efficiency_that_has_no_answer_names_the_option_that_has(fascicle):
    code, out, err = fascicle("efficiency", BUNDLE, "--scheme", "free")
    assert (code, out) == (2, "") and "--path isotonic" in err and err.count("\n") == 1
    code, out, err = fascicle("efficiency", BUNDLE, "--scheme", "free", "--path", "isotonic")
    assert (code, err) == (0, "") and "isotonic" in out

"""An option that is there twice: refused by every command, unless it is meant to be repeated."""

import pytest

from fascicle.cli.commands import app
from fascicle.cli.options import Command


SIX, PAIR = "kim2021_figure_6", "kim2021_bundle_1_1"
SIZES = ("--length", "300mm", "--outer-radius", "12mm", "--wall-thickness", "2mm",
         "--braid-angle", "25deg")  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["force", SIX, "-p", "1 bar", "--pressure=2 bar", "-s", "0"],
            "--pressure is there twice: give one list, 1 bar,2 bar.",
        ),
        (
            ["force", SIX, "-s", "0", "-s0.1", "-s", "0.2"],
            "--strain is there 3 times: give one list, 0,0.1,0.2.",
        ),
        (
            ["recruit", PAIR, "-f", "20N", "-f", "40N", "-s", "0.1"],
            "--force is there twice: give one list, 20N,40N.",
        ),
        (
            ["efficiency", PAIR, "--force", "2N", "--force", "4N"],
            "--force is there twice: give one list, 2N,4N.",
        ),
        (
            ["space", PAIR, "--levels", "0kPa", "--levels", "1kPa"],
            "--levels is there twice: give one list, 0kPa,1kPa.",
        ),
        (
            ["calibrate", "x.csv", *SIZES, "--fit", "c10", "--fit", "c01"],
            "--fit is there twice: give one list, c10,c01.",
        ),
        (["space", PAIR, "--supply", "1bar", "--supply", "2bar"], "--supply is there twice: give"),
        (["design", "t.toml", "--seed", "1", "--seed", "2"], "--seed is there twice: give it once"),
        (["force", SIX, "--json", "a.json", "--json", "b.json"], "--json is there twice: give it"),
    ],
)
def test_twice_is_refused_in_a_line(fascicle, arguments, message):
    code, out, err = fascicle(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {message}") and err.count("\n") == 1


def test_every_command_does_so():
    assert all(issubclass(one.cls, Command) for one in app.registered_commands)


def test_what_is_meant_to_be_repeated_may_be(fascicle):
    code, out, err = fascicle("free-strain", SIX, "-p", "1bar", "-p", "2bar", "--csv", "--csv")
    assert (code, err) == (0, "")
    assert out.count("\n") == 3

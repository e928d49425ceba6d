"""Mutated command lines: each ends with 0, 2 or 3, and says why in one line where it isn't 0."""

import re

import numpy as np
import pytest
from mutations import SIGNS

from fascicle.cli import main


PAIR, SIX = "kim2021_bundle_1_1", "kim2021_figure_6"
# small ones, and of one shape each, so that what is compiled serves all
LINES = [
    ["force", SIX, "-p", "0kPa,34.5kPa", "-s", "0,0.1", "--json"],
    ["force", SIX, "--pressure", "5psi", "--strain", "0:0.2:0.1", "-o", "x.csv"],
    ["free-strain", SIX, "-p", "34.5kPa", "--csv"],
    ["free-strain", PAIR, "-p", "34.5kPa,0kPa", "--json", "--no-resistance"],
    ["bundle", PAIR, "-p", "344.7kPa,0kPa", "-s", "0,0.1", "--out", "y.json"],
    ["space", PAIR, "--levels", "0kPa,100kPa", "--strain", "0,0.1", "--supply", "200kPa", "--json"],
    ["recruit", PAIR, "--force", "40N", "--strain", "0.1", "--supply", "60psi", "--json"],
    ["efficiency", PAIR, "--force", "20N", "--strain", "0.1", "--path", "isobaric", "--json"],
    ["record", SIX, "-o", "d.csv", "-p", "34.5kPa", "--samples", "4", "--noise", "1%", "--clip"],
    ["init", "m.toml", "--from", PAIR],
    ["init", "--task"],
    ["muscles", SIX],
    ["design", "t.toml", "--json"],
    ["sweep", "t.toml", "--workers", "0"],
    ["calibrate", "d.csv", "--muscle", SIX, "--fit", "c10", "--prior", "c10=90kPa,5kPa"],
    ["explore", "no.toml", "--port", "5006", "--no-show"],
    ["reproduce", "kim2020"],
    ["--help"],
]  # fmt: skip
WORDS = [
    "", "-", "--", "--nope", "-p", "--json", "--csv", "nan", "inf", "1e999", "-1kPa", "0kPa",
    "1e300kPa", "2MPa", "0.7", "-0.2", "0:0.6:0.1", "0:1:0", ",", "a,b", "\u202e", "\x00",
    "\x1b[31m", "é", "x" * 5000, "9" * 5000, "..", "/", "/dev/null", "no/x.nc", "x.zarr", "x.nc",
    "--out", "--plot", "x.png", "--force", "--overwrite", "batch", "34.5", "1 parsec", "5 psi",
    "1e-300Pa", "--strain", "--help", "%", "=", "--supply=", "kim2021_figure_9",
    "kim2021_bundle_five", "--samples", "2", "--seed", "-1", "99999999999999999999", "isotonic",
    "--scheme",
]  # fmt: skip


def mutated(words, rng):
    words = list(words)
    for _ in range(rng.integers(1, 4)):
        kind, place = rng.integers(6), int(rng.integers(len(words)))
        if kind == 0:
            words[place] = str(rng.choice(WORDS))
        elif kind == 1:
            words.insert(int(rng.integers(len(words) + 1)), str(rng.choice(WORDS)))
        elif kind == 2 and len(words) > 1:
            del words[place]
        elif kind == 3:
            words.insert(int(rng.integers(len(words) + 1)), words[place])
        elif kind == 4:
            cut = int(rng.integers(len(words[place]) + 1))
            words[place] = words[place][:cut] + str(rng.choice(SIGNS)) + words[place][cut:]
        else:
            number = re.search(r"\d+", words[place])
            if number:
                other = str(rng.choice(["0", "-1", "1e9", "", "1e-9", ".", "00", "1e400"]))
                words[place] = words[place][: number.start()] + other + words[place][number.end() :]
    return words


def heavy(words):
    """What would start a server, or take minutes if it were right."""
    return "explore" in words[:1] and not any("no.toml" in word for word in words)


@pytest.fixture
def check(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("FASCICLE_NO_CACHE", "1")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fascicle.explorer.server.serve", lambda *_: None)

    def run(seed, count):
        rng, codes = np.random.default_rng(seed), []
        for i in range(count):
            words = mutated(LINES[i % len(LINES)], rng)
            if heavy(words):
                continue
            with pytest.raises(SystemExit) as end:
                main(words)
            code, err = end.value.code, capsys.readouterr().err
            codes.append(code)
            told = [line for line in err.splitlines() if line.startswith("error: ")]
            assert code in (0, 2, 3), (words, code, err)
            assert len(told) == (code == 2), (words, code, err)
            assert all(len(line) < 650 and line.isprintable() for line in err.splitlines()), words
        # were all refused, or none, then this would test nothing
        assert 0.05 * count < codes.count(0) < 0.8 * count

    return run


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("seed", "count"), [(0, 120), pytest.param(1, 5000, marks=pytest.mark.slow)]
)
def test_command_lines(check, seed, count):
    check(seed, count)

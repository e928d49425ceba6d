import json

import pytest

from fascicle.io.sanitize import dump_json, escape_invisible, sanitize_line


@pytest.mark.parametrize(
    ("text", "shown"),
    [("a muscle, α₀ 33°", "a muscle, α₀ 33°"), ("gpj.\u202eexe", "gpj.\\u202eexe"),
     ("a\x1b[31mb", "a\\x1b[31mb"), ("a\nb\tc", "a b c"), ("\x00", "\\x00"), ("\u200b", "\\u200b"),
     ("\ud800", "\\ud800"), ("\u2066x", "\\u2066x")],
)  # fmt: skip
def test_no_sign_hides(text, shown):
    assert sanitize_line(text) == shown
    assert sanitize_line(text).isprintable()


def test_what_is_long_is_cut_in_the_middle():
    line = sanitize_line("begins " + 5000 * "x" + " ends")
    assert len(line) < 410 and line.startswith("begins x") and line.endswith("x ends")


def test_what_belongs_to_words_stays():
    text = "Muskel\xa0№\u202f7, 筋肉, עברית, é, e\u0301 €\n\tnext"
    assert escape_invisible(text) == text
    assert sanitize_line(text) == "Muskel № 7, 筋肉, עברית, é, e\u0301 € next"


def test_json_has_its_letters_and_nothing_that_hides():
    value = {"é": ["\x1b[31m", "\x9b31m", "\u202e", "\ud800", "\U000e0041", "α"]}
    text = dump_json(value)
    assert text.isprintable() and "é" in text and "α" in text
    assert json.loads(text) == value

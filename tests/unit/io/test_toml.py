"""TOML texts that attack are refused before they cost anything."""

import contextlib

import pytest

from fascicle.io.toml import parse_toml


@pytest.mark.parametrize(
    "text",
    ["a." * 30_000 + "a = 1", '"a".' * 15_000 + "a = 1", "'a' . " * 10_000 + "a = 1",
     "[" + "a." * 30_000 + "a]", "b = 1\n[[" + "a." * 30_000 + "a]]",
     "x = {" + "a." * 30_000 + "a = 1}", "a = " + "{a = " * 10_000, "a = " + "[" * 30_000,
     "\n".join("a." * 62 + f"a{i} = 1" for i in range(500)) + "\na = 1"],
)  # fmt: skip
def test_a_key_of_many_parts_is_refused(text):
    # parsing the shortest of them took 4 s, the longest 40
    with pytest.raises(ValueError, match=r"^m\.toml: not TOML: .*\.$") as refused:
        parse_toml(text, "m.toml")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "text",
    ["a = [" + "1.5, " * 500 + "1]", "a.b.c = 1979-05-27T07:32:00.999", "# " + "x. " * 50,
     'a = "' + "." * 500 + '"', "a = '''" + "[" * 500 + "'''", 'a = "' + "x." * 50 + '"'],
)  # fmt: skip
def test_dots_in_values_and_comments_are_no_key(text):
    parse_toml(text, "f")


@pytest.mark.parametrize(
    "sign", ['"', "'", '"""', "'''", "\\", "#", "a.", ".", "[", "]", "\n", '"a', "a", "'' "]
)
def test_long_texts_end(sign):
    for text in (sign * 65_000, f'a = "{sign * 65_000}', f"a = '''{sign * 65_000}"):
        with contextlib.suppress(ValueError):
            parse_toml(text, "f")

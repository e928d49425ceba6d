import time

import pytest

from fascicle.files import dumps, example, examples, loads
from fascicle.io.toml import DEEPEST, check_nesting_depth


@pytest.mark.parametrize(
    "text",
    ["a." * 30_000 + "a = 1", '"a".' * 15_000 + "a = 1", "'a' . " * 10_000 + "a = 1",
     "[" + "a." * 30_000 + "a]", "b = 1\n[[" + "a." * 30_000 + "a]]",
     "x = {" + "a." * 30_000 + "a = 1}", "a = " + "{a = " * 10_000, "a = " + "[" * 30_000,
     'a = """\n""" # "\n' + "b." * 30_000 + "b = 1"],
)  # fmt: skip
def test_what_lies_too_deep_is_refused_before_it_costs_anything(text):
    began = time.thread_time()
    with pytest.raises(
        ValueError, match=rf"m.toml: not TOML: nested too deep on line \d, .* {DEEPEST}"
    ) as refused:
        loads(text, source="m.toml")
    # parsing the shortest of them took 4 s, the longest 40
    assert time.thread_time() - began < 1
    assert "\n" not in str(refused.value)


def test_the_line_is_named():
    with pytest.raises(ValueError, match="line 3"):
        check_nesting_depth("a = 1\n\n" + "a." * 20 + "a = 2", "f")


@pytest.mark.parametrize(
    "text",
    ["# " + "x." * 50, 'a = "' + "x." * 50 + '"', "a = '" + "x." * 50 + "'",
     'a = """' + "x." * 50 + '\n "" ' + "x." * 50 + '"""', "a = '''" + "[" * 50 + "'''",
     'a = "\\"' + "[" * 50 + '"', "a = [" + "1.5, " * 500 + "]", "a.b.c = 1979-05-27T07:32:00.999",
     "a = 1\n" * 500, "[a.b]\n" * 50, 'a = """b"""" # ' + "x." * 50],
)  # fmt: skip
def test_what_is_in_strings_comments_and_numbers_is_no_key(text):
    check_nesting_depth(text, "f")


@pytest.mark.parametrize("name", examples())
def test_no_example_is_near(name):
    text = dumps(example(name))
    check_nesting_depth(text.replace("[muscle", "[a.b.c.d.e.f.g.h"), "f")


@pytest.mark.parametrize(
    "sign", ['"', "'", '"""', "'''", "\\", "#", "a.", ".", "[", "]", "\n", '"a']
)
def test_long_texts_take_no_time(sign):
    began = time.thread_time()
    for text in (sign * 200_000, f'a = "{sign * 200_000}', f"a = '''{sign * 200_000}"):
        try:
            check_nesting_depth(text, "f")
        except ValueError:
            continue
    assert time.thread_time() - began < 5

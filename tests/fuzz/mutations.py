"""Texts as a hostile stranger, a torn disk or a tired hand would leave them; seeded."""

import re


# numbers, units, words and signs that are at some edge
VALUES = [
    "0", "-0.0", "1", "-1", "2", "1e300", "1e-300", "-1e300", "1e999", "nan", "inf", "-inf",
    "0x10", "9223372036854775807", "9223372036854775808", "1_000", "0.1", "33", "5" * 400,
    "1" * 5000, "0x" + "f" * 5000, "true", "[]", "{}", "[[]]", '""', '"0"', '"1"', '"-1 mm"',
    '"nan mm"', '"inf mm"', '"1e300 m"', '"1e-300 m"', '"127 parsec"', '"1e-12 m"', '"33 deg"',
    '"1e5 Pa"', '"1 kPa"', '"1 furlong/fortnight"', '"0 kPa"', '"1e308 kPa"', '"12 %"',
    '"1,5 mm"', '"5 psi"', '"100 kPa:0 kPa:1 kPa"', '"a"', '"\u202e"', '"\\u0000"', '"x\\ny"',
    "1979-05-27", "07:32:00", '["1 mm", 2]', '"latex"', '"elastica"', '"kim2021"', '"orderly"',
    '"kothera2009"', '"muscle"', '"' + "x" * 3000 + '"', "''", '"1 mm**9999"', '"1 m^9"',
    '"1 /m"', '"(1+1) m"', '"1 __import__"',
]  # fmt: skip
SIGNS = [
    "", "\x00", "\ufeff", "\u202e", "\u2028", "\n", "\r", "\t", "=", "[", "]", "{", "}", '"', "'",
    '"""', "#", ".", ",", ";", ":", "-", "+", "e", "0", "é", "\U0001f4aa", "\\", "%",
]  # fmt: skip
KEYS = [
    '""', "a", '"\u202e"', "muscle", "length", "format", "tuning", "bundle", "count", "pressure",
    '"a b"', "x" * 300, "a.b.c", '"(plain)"', "__class__", "calibration", "design", "task",
    "collapse", "factor", "material",
]  # fmt: skip


def mutated(text, rng):
    """`text` after one to four mutations by the generator `rng`."""
    for _ in range(rng.integers(1, 5)):
        text = rng.choice(_KINDS)(text, rng)
    return text


def _value(text, rng):
    """Another value after an equals sign."""
    places = [m.span(1) for m in re.finditer(r"= *([^#\n]+)", text)]
    if not places:
        return text
    start, end = places[rng.integers(len(places))]
    return text[:start] + str(rng.choice(VALUES)) + text[end:]


def _key(text, rng):
    places = [m.span(1) for m in re.finditer(r"^[\[ ]*([^=\n#\]]+?) *[=\]]", text, re.MULTILINE)]
    if not places:
        return text
    start, end = places[rng.integers(len(places))]
    return text[:start] + str(rng.choice(KEYS)) + text[end:]


def _sign(text, rng):
    place = rng.integers(len(text) + 1)
    return text[:place] + str(rng.choice(SIGNS)) + text[place + rng.integers(0, 3) :]


def _line(text, rng):
    """A line gone, twice there, elsewhere, or new."""
    lines = text.split("\n")
    place, other = rng.integers(len(lines)), rng.integers(len(lines))
    kind = rng.integers(4)
    if kind == 0:
        del lines[place]
    elif kind == 1:
        lines.insert(other, lines[place])
    elif kind == 2:
        lines[place], lines[other] = lines[other], lines[place]
    else:
        lines.insert(place, f"{rng.choice(KEYS)} = {rng.choice(VALUES)}")
    return "\n".join(lines)


def _torn(text, rng):
    start, end = sorted(rng.integers(0, len(text) + 1, 2))
    return text[:end] if rng.integers(2) else text[:start] + text[end:]


def _number(text, rng):
    """A number a thousand times as large, or of the other sign, or another one."""
    places = [m.span() for m in re.finditer(r"[-+]?\d+\.?\d*(e[-+]?\d+)?", text)]
    if not places:
        return text
    start, end = places[rng.integers(len(places))]
    ways = ["1000", "-", "e9", "e-9", "e300", "0", ".", "e", "99"]
    way = str(rng.choice(ways))
    old = text[start:end]
    return text[:start] + (f"-{old}" if way == "-" else old + way) + text[end:]


_KINDS = [_value, _value, _key, _sign, _line, _torn, _number, _number]

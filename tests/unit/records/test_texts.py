"""Texts of records in `texts/`: each is read to its readings, or refused by what it lacks.

By the name of a behavior a text, in which `<each>` stands for each of a list, and what is tried:
`with` these options it `reads` as these readings [SI], or as those of a name in `readings.toml`,
with these `findings`; or it `asks` for these choices of argument, key and value; or it is
`refused_at` a place in it, or `refuses` an argument.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from asked import asked
from fascicle.records import loads
from refusing import refuses, refuses_at


TEXTS = Path(__file__).parent / "texts"
READINGS = tomllib.loads((TEXTS / "readings.toml").read_text(encoding="utf-8"))
CASES = [
    pytest.param(case["text"].replace("<each>", item), case["tries"], id=name[:60])
    for path in sorted(TEXTS.glob("*.toml"))
    if path.name != "readings.toml"
    for name, cases in tomllib.loads(path.read_text(encoding="utf-8")).items()
    for case in cases
    for item in case.get("each", [""])
]
UNSAID = {"branch": 0, "censored": False, "moment_arm": (), "synthetic": False}


@pytest.mark.parametrize(("text", "tries"), CASES)
def test_a_text_is_read_or_refused(text, tries):
    for one in tries:
        options = one.get("with", {})
        if "asks" in one:
            choices = asked(text, **options)
            assert choices[: len(one["asks"])] == [tuple(choice) for choice in one["asks"]]
        elif "refused_at" in one:
            with refuses_at(one["refused_at"]):
                loads(text, **options)
        elif "refuses" in one:
            with refuses(one["refuses"]):
                loads(text, **options)
        else:
            reads = one["reads"] if isinstance(one["reads"], dict) else READINGS[one["reads"]]
            check(loads(text, **options), reads, one.get("findings", {}))


def check(record, reads, findings):
    """Hold a record to its readings and to some of its findings' data."""
    for name, values in (UNSAID | reads).items():
        given = getattr(record, name)
        # decimals as they were written, in SI to the rounding of their units
        assert_allclose([] if given is None else given, values, rtol=1e-9, atol=1e-12, err_msg=name)
    data = {finding.code.removeprefix("record."): finding.data for finding in record.findings}
    for code, facts in findings.items():
        assert facts.items() <= {k: plain(data[code][k]) for k in facts}.items()


def plain(value):
    """A finding's value as TOML has it."""
    return list(value) if isinstance(value, tuple | np.ndarray) else value

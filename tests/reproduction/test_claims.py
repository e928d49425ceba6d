import dataclasses
import math

import pytest

from fascicle.core.errors import InvalidInputError
from reproduction.claims import (
    KINDS,
    Claim,
    Criterion,
    Reading,
    claims_data,
    failed,
    remarks,
    summary,
)


def criterion(value: float = 1.0, sign: str = ">", limit: float = 0.0, **more) -> Criterion:
    return Criterion("what", value, sign, limit, **more)


def claim(
    holds: bool = True, kind: str = "prediction", explanation: str = "", key: str = "it"
) -> Claim:
    return Claim(
        key, "Fig. 1", kind, "what it says", "its words",
        (criterion(1.0 if holds else -1.0),), "what came out", explanation,
        choice="a constant" if kind == "input" else "",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("value", "sign", "limit", "met"),
    [(1.0, "<", 2.0, True), (2.0, "<", 2.0, False), (2.0, "≤", 2.0, True), (2.1, "≤", 2.0, False),
     (math.nan, "≤", 2.0, False), (2.0, ">", 1.0, True), (1.0, ">", 1.0, False),
     (0.2403, "=", 0.24, True), (0.223, "=", 0.24, False),
     (math.nan, "<", 2.0, False), (math.nan, ">", 2.0, False), (math.nan, "=", 2.0, False),
     (-math.inf, ">", 0.0, False)],
)  # fmt: skip
def test_a_criterion_is_a_number_against_a_limit(value, sign, limit, met):
    assert criterion(value, sign, limit, tolerance=0.005).met is met


@pytest.mark.parametrize(
    ("holds", "kind", "explanation", "verdict"),
    [(True, "prediction", "", "holds"), (True, "prediction", "known", "holds"),
     (False, "prediction", "known", "differs"), (False, "prediction", "", "fails"),
     (True, "input", "", "chosen"), (False, "input", "", "fails"),
     (False, "input", "known", "differs"),
     (True, "definition", "", "by definition"), (False, "definition", "", "fails"),
     (True, "not testable here", "", "not testable here"),
     (False, "not testable here", "known", "not testable here")],
)  # fmt: skip
def test_verdicts(holds, kind, explanation, verdict):
    assert claim(holds, kind, explanation).verdict == verdict


def test_all_criteria_must_be_met():
    both = Claim("k", "w", "prediction", "t", "q", (criterion(1.0), criterion(-1.0)), "m")
    assert not both.holds


def test_what_is_not_known_to_differ_can_fail():
    bad = claim(holds=False)
    assert failed([claim(), claim(holds=False, explanation="known"), bad]) == [bad]


@pytest.mark.parametrize(
    "given",
    [{"kind": "guess"}, {"criteria": ()}, {"kind": "input"}, {"choice": "a constant"}],
)
def test_a_claim_without_what_it_needs_is_refused(given):
    whole = {"key": "k", "place": "w", "kind": "prediction", "text": "t", "quote": "q",
             "criteria": (criterion(),), "outcome": "m"}  # fmt: skip
    with pytest.raises(InvalidInputError) as error:
        Claim(**{**whole, **given})
    assert error.value.argument in ("kind", "criteria", "choice")


def test_the_file_has_what_the_page_says_and_no_nan():
    odd = Claim("k", "w", "prediction", "t", "q", (criterion(math.nan),), "m")
    data = claims_data([claim(), odd])
    assert data["summary"] == summary([claim(), odd])
    assert data["kinds"] == dict(KINDS)
    assert data["claims"][0]["criteria"][0]["met"] is True
    assert data["claims"][1]["criteria"][0]["value"] is None
    assert data["claims"][1]["verdict"] == "fails"


@pytest.mark.parametrize(
    ("value", "sign", "limit", "tolerance", "close"),
    [(0.925, ">", 0.9, 0.0, True), (4.9, ">", 2.0, 0.0, False), (0.0, "<", 1e-9, 0.0, False),
     (1.95, "<", 2.0, 0.0, True), (0.2403, "=", 0.24, 0.005, False),
     (0.2449, "=", 0.24, 0.005, True), (1e-9, ">", 0.0, 0.0, False)],
)  # fmt: skip
def test_a_limit_of_ours_can_be_close(value, sign, limit, tolerance, close):
    one = criterion(value, sign, limit, tolerance=tolerance, limit_reason="no number is given")
    assert one.close is close and ("close" in one.limit_note) is close
    # the paper's own limit is what it is
    assert not criterion(value, sign, limit, tolerance=tolerance).close


def test_a_verdict_that_depends_on_a_reading_says_so():
    other = Reading("printed", "if it stands as in print", False, ("what: 2, must be < 1",))
    same = Reading("wood1958", "if it has the cube", True, ("what: 0.5, must be < 1",))
    first = dataclasses.replace(claim(key="first"), readings=(other, same))
    second = dataclasses.replace(claim(key="second"), readings=(same,))
    assert first.opposite_readings == (other,) and not second.opposite_readings
    assert remarks([second, first]) == [
        "If it stands as in print, the verdict changes on claim 2.",
        "No verdict changes if it has the cube.",
    ]
    assert "if it stands as in print (what: 2, must be < 1)" in first.dependence
    assert claims_data([first])["claims"][0]["readings"] == {"printed": False, "wood1958": True}
    near = criterion(0.95, ">", 0.9, limit_reason="no number is given")
    assert "claim 1" in remarks([dataclasses.replace(claim(key="third"), criteria=(near,))])[0]

import pytest

from fascicle.reproduce.claims import Claim, failed


def claim(holds: bool, must_hold: bool, why: str = "because") -> Claim:
    return Claim("Fig. 1", "what it says", "what came out", holds, must_hold, why)


@pytest.mark.parametrize(
    ("holds", "must_hold", "verdict"),
    [(True, True, "holds"), (True, False, "holds"), (False, False, "differs"),
     (False, True, "fails")],
)  # fmt: skip
def test_verdicts(holds, must_hold, verdict):
    assert claim(holds, must_hold).verdict == verdict


def test_only_what_must_hold_can_fail():
    bad = claim(holds=False, must_hold=True)
    assert failed([claim(True, True), claim(False, False), bad]) == [bad]


def test_a_difference_without_a_reason_is_refused():
    with pytest.raises(ValueError, match="why"):
        claim(holds=False, must_hold=False, why="")

import dataclasses
import re

import pytest

from fascicle.cli import main
from fascicle.reproduce import kim2021
from fascicle.reproduce.claims import Claim, failed
from fascicle.reproduce.kim2021 import (
    figure_06,
    figure_08,
    reproduction,
)


DIFFERENCES = {
    "In one cross-section, one inactive unit of two resists more than four inactive ones of five.",
    "The two muscles have unequal blocked forces, though equal sections.",
    "The corrected Klute–Hannaford model gives another curve than the uncorrected one.",
}


def only(monkeypatch, compute) -> None:
    """Let the reproduction be of one figure."""
    monkeypatch.setattr(reproduction, "FIGURES", (compute,))
    monkeypatch.setattr(reproduction, "ALTERNATIVES", ())
    monkeypatch.setattr(reproduction, "CHAINS", ((compute,),))
    monkeypatch.setattr(reproduction, "alternatives_report", lambda _: "")


def addresses(html: str) -> list[str]:
    return re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', html)


def test_a_report_of_one_figure(tmp_path, monkeypatch):
    only(monkeypatch, figure_08.compute)
    told = []
    claims = kim2021.run(tmp_path, lambda *step: told.append(step))
    assert [claim.verdict for claim in claims] == ["holds"]
    assert told[0][:2] == (0, 1)
    assert told[-1] == (1, 1, "done")
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    # what is beside it is there; nothing is asked for from elsewhere
    for address in addresses(html):
        if not address.startswith(("data:", "#")) and address != "alternatives.html":
            assert (tmp_path / address).is_file(), address
    assert not re.search(r"@import|url\(|<script", html)


def test_a_claim_that_had_to_hold_gives_exit_code_1(tmp_path, monkeypatch, capsys):
    good = figure_08.compute()
    bad = Claim("Fig. 8", "the moon is made of cheese", "rock", holds=False, must_hold=True)
    only(monkeypatch, lambda: dataclasses.replace(good, claims=(*good.claims, bad)))
    with pytest.raises(SystemExit) as end:
        main(["reproduce", "kim2021", "--out", str(tmp_path)])
    assert end.value.code == 1
    assert "fails" in capsys.readouterr().out
    assert "had to hold and fail" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_figure_that_breaks_stops_the_run(tmp_path, monkeypatch):
    def broken():
        raise ZeroDivisionError

    only(monkeypatch, broken)
    with pytest.raises(ZeroDivisionError):
        kim2021.run(tmp_path)
    assert not (tmp_path / "report.html").exists()


def test_claims_about_figure_6_hold():
    claims = figure_06.compute().claims
    assert sum(claim.must_hold for claim in claims) == 4
    assert not failed(claims)


@pytest.mark.slow
def test_the_whole_reproduction(tmp_path):
    claims = kim2021.run(tmp_path)
    assert not failed(claims)
    assert {claim.text for claim in claims if not claim.holds} == DIFFERENCES
    for number in (2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 14):
        for kind in ("png", "svg", "nc", "csv"):
            assert (tmp_path / f"figure_{number:02}.{kind}").stat().st_size > 100
    for name in ("report.html", "alternatives.html"):
        html = (tmp_path / name).read_text(encoding="utf-8")
        assert not any(re.match(r"\w+://|//", address) for address in addresses(html))
        assert "nan" not in re.sub(r'"data:[^"]*"', "", html).lower().split()

import base64
import json
import re
import subprocess
import sys
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from reproduction.claims import failed, summary
from reproduction.kim2021 import figure_06, figure_08, reproduction, setting


REPORTED = json.loads(
    (Path(__file__).parents[2] / "docs" / "_static" / "claims.json").read_text(encoding="utf-8")
)
DIFFERENCES = {
    "one_of_two_against_four_of_five", "unequal_blocked_forces",
}  # fmt: skip


def only(monkeypatch, compute) -> None:
    """Let the reproduction be of one figure."""
    monkeypatch.setattr(reproduction, "FIGURES", (compute,))
    monkeypatch.setattr(reproduction, "CLAIMING", (compute,))
    monkeypatch.setattr(reproduction, "ALTERNATIVES", ())


def addresses(html: str) -> list[str]:
    return re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', html)


def check_mailable(html: str) -> None:
    """Nothing is asked for from elsewhere, and every link leads somewhere in the page itself."""
    for address in addresses(html):
        assert address.startswith(("data:", "#")), address[:80]
        if address.startswith("#"):
            assert f'id="{address[1:]}"' in html, address
    assert not re.search(r"@import|url\(|<script", html)


def held(html: str) -> dict[str, bytes]:
    """The files that a page holds, by name."""
    found = re.findall(r'<a download="([^"]+)" href="data:[^;]+;base64,([^"]*)"', html)
    return {name: base64.b64decode(content) for name, content in found}


def check_said_alike(claims, html: str, data: dict) -> None:
    """The page and the file have each claim's words, number and verdict."""
    plain = unescape(html)
    assert summary(claims) in plain
    assert summary(claims) == data["summary"]
    for claim, filed in zip(claims, data["claims"], strict=True):
        assert (filed["key"], filed["kind"]) == (claim.key, claim.kind)
        assert (filed["verdict"], filed["paper"]) == (claim.verdict, claim.quote)
        assert f"<q>{claim.quote}</q>" in plain
        for one in claim.criteria:
            assert one.text[1:] in plain
            assert one.text in [
                criterion["text"][: len(one.text)] for criterion in filed["criteria"]
            ]


def test_a_report_of_one_figure(tmp_path, monkeypatch):
    only(monkeypatch, figure_08.compute)
    told = []
    claims = reproduction.run(tmp_path, lambda *step: told.append(step))
    assert [claim.verdict for claim in claims] == ["by definition"]
    assert told[0][:2] == (0, 1)
    assert told[-1] == (1, 1, "done")
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    check_mailable(html)
    check_said_alike(claims, html, json.loads((tmp_path / "claims.json").read_text("utf-8")))
    for name, content in held(html).items():
        assert content == (tmp_path / name).read_bytes()
    assert {"claims.json", "figure_08.csv"} < set(held(html))


def test_a_figure_that_breaks_stops_the_run(tmp_path, monkeypatch):
    def broken():
        raise ZeroDivisionError

    only(monkeypatch, broken)
    with pytest.raises(ZeroDivisionError):
        reproduction.run(tmp_path)
    assert not (tmp_path / "report.html").exists()


def test_claims_about_figure_6_hold():
    claims = figure_06.compute().claims
    assert [claim.verdict for claim in claims].count("holds") == 7
    assert not failed(claims)


def test_after_collapse_is_judged_by_each_reading():
    """By `consistent` the resistance exceeds that at collapse; by no other reading does it."""
    readings = {one["key"]: one["readings"] for one in REPORTED["claims"]}
    assert {
        name: holds for name, holds in readings["less_after_collapse"].items() if not holds
    } == {"consistent": False}
    muscle = setting.muscle("figure_6")
    reach = setting.tested(muscle)
    for name in ("derived", "consistent", "printed"):
        with setting.reading(name):
            other = setting.muscle("figure_6")
            worst = max(setting.resistance_after(other, P, reach) for P in (0.0, 34.5e3))
        assert (worst <= 1.0) is (name != "consistent")
        # without pressure it is that one exceeds it; a finer grid says the same
        strain = np.linspace(float(muscle.collapse_strain(0.0)), reach, 20001)
        force = np.asarray(other.force(0.0, strain))
        assert float((force / force[0]).max()) == pytest.approx(worst, rel=1e-6)
    assert setting.muscle("figure_6").post_collapse.name == "derived"  # as before


def test_table_1s_pressure_is_read_in_bar_or_in_megapascals():
    slope = setting.muscle("slenderness_8").tuning.hinge_stiffness_slope
    with setting.reading("megapascals"):
        other = setting.muscle("slenderness_8").tuning.hinge_stiffness_slope
    assert float(slope) == pytest.approx(0.87 / 1e5) and float(other) == pytest.approx(0.87 / 1e6)


@pytest.mark.slow
def test_the_whole_reproduction(tmp_path):
    claims = reproduction.run(tmp_path)
    assert not failed(claims)
    assert {claim.key for claim in claims if claim.verdict == "differs"} == DIFFERENCES
    for number in (2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 14):
        for kind in ("png", "svg", "nc", "csv"):
            assert (tmp_path / f"figure_{number:02}.{kind}").stat().st_size > 100
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    check_mailable(html)
    made = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    check_said_alike(claims, html, made)
    assert "nan" not in re.sub(r'"data:[^"]*"', "", html).lower().split()
    # README and docs say what the repository's file says: it must be what comes out
    for reported, new in zip(REPORTED["claims"], made["claims"], strict=True):
        for name in (
            "key",
            "where",
            "kind",
            "verdict",
            "claim",
            "paper",
            "chosen",
            "why",
            "readings",
        ):
            assert reported[name] == new[name]
        for old, now in zip(reported["criteria"], new["criteria"], strict=True):
            assert (old["quantity"], old["sign"]) == (now["quantity"], now["sign"])
            # rounding, where it is the rounding that is looked at
            assert old["value"] == pytest.approx(now["value"], rel=1e-3, abs=1e-6)
    assert REPORTED["summary"] == made["summary"] and REPORTED["remarks"] == made["remarks"]


def test_without_a_checkout_the_command_says_so(tmp_path):
    """As installed from a wheel: the package alone."""
    code = "import fascicle; fascicle.__file__ = {!r}; from fascicle.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code.format(str(tmp_path / "a" / "b" / "fascicle" / "__init__.py")),
         "reproduce", "kim2021", "--out", str(tmp_path / "out")],
        capture_output=True, text=True, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "checkout" in done.stderr
    assert not (tmp_path / "out").exists()

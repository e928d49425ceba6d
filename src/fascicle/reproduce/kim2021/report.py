"""The report: each figure with its conditions, the claims about it, and what came out."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from ...plot.style import DOUBLE
from ...reports.page import Page, prose, verdict
from ..claims import Claim
from ..record import Record


PAPER = (
    "J. Y. Kim, N. Mazzoleni, M. Bryant: Modeling of Resistive Forces and Buckling Behavior in "
    "Variable Recruitment Fluidic Artificial Muscle Bundles. Actuators 10, 42 (2021), "
    "doi 10.3390/act10030042, CC BY."
)
_INCH = 0.0254  # m


@dataclass(frozen=True)
class Written:
    """A record that has been written: its picture as SVG and as it is wide [inch], its files."""

    record: Record
    svg: bytes
    width: float
    files: tuple[str, ...]


def report(figures: Sequence[Written]) -> str:
    """The first page: every figure and every claim."""
    claims = [claim for one in figures for claim in one.record.claims]
    page = Page("Kim, Mazzoleni and Bryant 2021, made anew")
    page.paragraph(
        "Every figure of the paper that a model can make, computed from the muscles' sizes, and "
        "every claim beside it, in our words, held against what came out.",
        "lead",
    )
    page.paragraph(summary(claims))
    page.links(
        {one.record.name: f"#{one.record.key}" for one in figures}
        | {"Other laws and readings": "alternatives.html"}
    )
    _differing(page, claims)
    _general(page)
    page.heading("All claims", "claims")
    page.table(
        ("Where", "The paper's claim", "Verdict"),
        [
            (f'<a class="where" href="#{one.record.key}">{escape(claim.where)}</a>', _marked(claim),
             verdict(claim.verdict))
            for one in figures
            for claim in one.record.claims
        ],
    )  # fmt: skip
    page.paragraph("Claims with a dot must hold for the reproduction to have succeeded.", "note")
    for one in figures:
        figure(page, one)
    return page.text(PAPER + " Pictures, data and claims computed by fascicle.")


def summary(claims: Sequence[Claim]) -> str:
    """A line that counts verdicts."""
    count = Counter(claim.verdict for claim in claims)
    must = sum(claim.must_hold for claim in claims)
    parts = [f"{len(claims)} claims: {count['holds']} hold, {count['differs']} differ"]
    if count["fails"]:
        parts.append(f"{count['fails']} had to hold and fail")
    else:
        parts.append(f"all {must} that must hold do")
    return ", ".join(parts) + "."


def figure(page: Page, one: Written) -> None:
    """A section of `page`: picture, conditions, claims, what is missing, files."""
    record = one.record
    page.heading(record.title, record.key)
    page.picture(one.svg, "svg", record.title, min(one.width, DOUBLE) * _INCH)
    page.points(record.conditions)
    if record.missing:
        page.paragraph(record.missing, "note")
    if record.claims:
        page.table(
            ("The paper's claim", "What the model gives", "Verdict"),
            [
                (
                    f"{_marked(claim)} {_place(claim)}",
                    prose(claim.model)
                    + (f" <em>Why:</em> {prose(claim.why)}" if claim.why else ""),
                    verdict(claim.verdict),
                )
                for claim in record.claims
            ],
        )
    page.files(one.files)


def _differing(page: Page, claims: Sequence[Claim]) -> None:
    page.heading("What differs, and why", "differs")
    rows = [
        (f"{prose(claim.text)} {_place(claim)}", prose(claim.model), prose(claim.why),
         verdict(claim.verdict))
        for claim in claims
        if not claim.holds
    ]  # fmt: skip
    page.table(("The paper's claim", "What the model gives", "Why", "Verdict"), rows)


def _place(claim: Claim) -> str:
    return f'<span class="note">({escape(claim.where)})</span>'


def _general(page: Page) -> None:
    page.heading("What holds for all figures", "conditions")
    page.points((
        "Sizes, pressures and laws are the paper's; where it is misprinted, silent or "
        "inconsistent, the readings of fascicle's documentation hold (the paper and its "
        "misprints).",
        "The bladder is `silicone_kim2021`: the paper gives its Young's modulus alone, and its two "
        "other constants are those that meet what the paper says about free strain and collapse.",
        "The paper's measured points exist only in its pictures. None are copied, none are "
        "invented.",
        "The tables C₁(P) and C₂(P) of section 5.1 stand nowhere in the paper. Figs 12 to 14 use "
        "the identity for them.",
        "Figs 1 and 11 are a sketch of a bundle and a photograph of the test bench: there is "
        "nothing to compute.",
    ))  # fmt: skip


def _marked(claim: Claim) -> str:
    return ("• " if claim.must_hold else "") + prose(claim.text)

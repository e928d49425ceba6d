"""The report: each figure with its conditions, the claims about it, and what came out.

It is one file that holds its pictures and its data: it can be sent as it is.
"""

import json
from collections.abc import Sequence
from html import escape

from fascicle.plot.style import DOUBLE
from fascicle.reports.page import Page, prose, quotation, verdict

from ..claims import KINDS, Claim, as_data, of_kind, remarks, summary
from ..reproduced import Written
from .alternatives_report import add_alternatives


PAPER = (
    "J. Y. Kim, N. Mazzoleni, M. Bryant: Modeling of Resistive Forces and Buckling Behavior in "
    "Variable Recruitment Fluidic Artificial Muscle Bundles. Actuators 10, 42 (2021), "
    "doi 10.3390/act10030042, CC BY."
)
_INCH = 0.0254  # m
_HEADINGS = {"prediction": "Predictions", "input": "Inputs", "definition": "Definitions"}


def report(figures: Sequence[Written], alternatives: Sequence[Written] = ()) -> str:
    """The page: every figure and every claim, then the `alternatives` [-]."""
    claims = [claim for one in figures for claim in one.record.claims]
    page = Page("Kim, Mazzoleni and Bryant 2021, made anew")
    page.paragraph(
        "Every figure of the paper that a model can make, computed from the muscles' sizes, and "
        "every claim beside it, in our words and the paper's, held against what came out.",
        "lead",
    )
    page.paragraph(summary(claims))
    page.points(remarks(claims))
    others = {"Other laws and readings": "#alternatives"} if alternatives else {}
    page.links({one.record.name: f"#{one.record.key}" for one in figures} | others)
    _differing(page, claims)
    _general(page)
    _all_claims(page, figures)
    for one in figures:
        figure(page, one)
    if alternatives:
        add_alternatives(page, alternatives, figure)
    return page.text(PAPER + " Pictures, data and claims computed by fascicle.")


def claims_file(claims: Sequence[Claim]) -> str:
    """The `claims` [-] with their numbers, as JSON."""
    data = {"paper": PAPER, **as_data(claims)}
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def figure(page: Page, one: Written) -> None:
    """A section of `page`: picture, conditions, claims, what is missing, data."""
    record = one.record
    page.heading(record.title, record.key)
    page.picture(one.svg, "svg", record.title, min(one.width, DOUBLE) * _INCH)
    page.points(record.conditions)
    if record.missing:
        page.paragraph(record.missing, "note")
    if record.claims:
        page.table(
            ("The paper's claim", "What the model gives", "Verdict"),
            [(_said(claim), _given(claim), verdict(claim.verdict)) for claim in record.claims],
        )
    page.downloads(one.tables)


def _all_claims(page: Page, figures: Sequence[Written]) -> None:
    page.heading("All claims", "claims")
    page.paragraph(
        "The predictions are of what the paper says of its model, and in part of what it measured. "
        "How well its measurements are met can't be checked: they exist only in its pictures."
    )
    placed = {claim.key: one.record.key for one in figures for claim in one.record.claims}
    claims = [claim for one in figures for claim in one.record.claims]
    for kind, about in KINDS.items():
        some = of_kind(claims, kind)
        if not some:
            continue
        page.heading(_HEADINGS[kind], f"claims_{kind}", 3)
        page.paragraph(f"{about[0].upper()}{about[1:]}.", "note")
        rows = [
            (
                f'<a class="where" href="#{placed[claim.key]}">{escape(claim.where)}</a>',
                _words(claim),
                _criteria(claim) + _chosen(claim) + _dependence(claim),
                verdict(claim.verdict),
            )
            for claim in some
        ]
        page.table(("Where", "Claim, and the paper's words", "Criterion", "Verdict"), rows)
    page.downloads({"claims.json": claims_file(claims).encode()})


def _differing(page: Page, claims: Sequence[Claim]) -> None:
    rows = [
        (_said(claim), _given(claim), verdict(claim.verdict)) for claim in claims if not claim.holds
    ]
    if rows:
        page.heading("What differs, and why", "differs")
        page.table(("The paper's claim", "What the model gives, and why", "Verdict"), rows)


def _said(claim: Claim) -> str:
    """A claim with its words, place and kind, as HTML."""
    about = f"{claim.where}; {claim.kind}"
    return f'{_words(claim)} <span class="note">({escape(about)})</span>'


def _words(claim: Claim) -> str:
    return f"{prose(claim.text)} {quotation(claim.quote)}"


def _given(claim: Claim) -> str:
    """What the model gives, the criterion, and what is to be known of both, as HTML."""
    why = f" <em>Why:</em> {prose(claim.why)}" if claim.why and not claim.holds else ""
    return f"{prose(claim.model)}<br>{_criteria(claim)}{_chosen(claim)}{why}"


def _criteria(claim: Claim) -> str:
    lines = [
        prose(
            f"{one.text[0].upper()}{one.text[1:]}"
            + f"{one.whose[:-1]}: {one.ours})" * bool(one.ours)
        )
        for one in claim.criteria
    ]
    return '<span class="note">' + ".<br>".join(lines) + ".</span>"


def _chosen(claim: Claim) -> str:
    return f" <em>Chosen:</em> {prose(claim.chosen)}" if claim.chosen and claim.holds else ""


def _dependence(claim: Claim) -> str:
    return f" <em>Readings:</em> {prose(claim.dependence)}" if claim.turned else ""


def _general(page: Page) -> None:
    page.heading("What holds for all figures", "conditions")
    page.points((
        "Sizes, pressures and laws are the paper's; where it is misprinted, silent or "
        "inconsistent, the readings [R1] to [R18] of fascicle's documentation hold (the paper and "
        "its misprints).",
        "The bladder is `silicone_kim2021`: the paper gives its Young's modulus alone. Its two "
        "other constants were chosen so that two statements of the paper come out, which are "
        "therefore listed as inputs.",
        "The paper's measured points exist only in its pictures. None are copied, none are "
        "invented.",
        "The tables C₁(P) and C₂(P) of section 5.1 stand nowhere in the paper. Figs 12 to 14 use "
        "the identity for them.",
        "Every claim is judged by each reading that changes a force: after collapse `derived` (of "
        "every figure), `consistent` and `printed` [R10]; `wood1958`, the cube in (17) [R8]; "
        "`kim2021_series`, bladder and mesh of (16) as one column; `latex`, C₁₀ and C₀₁ of Klute "
        "and Hannaford [R3]; `megapascals`, P in Table 1's factors [R14]. Where a reading turns a "
        "verdict, that is said.",
        "Figs 1 and 11 are a sketch of a bundle and a photograph of the test bench: there is "
        "nothing to compute.",
        "This page holds its pictures and, as CSV, its data: a link below a figure saves them. The "
        "folder that the command wrote has them as netCDF too, and the pictures as SVG and PNG.",
    ))  # fmt: skip

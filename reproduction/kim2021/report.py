"""The report: each figure with its conditions, the claims about it, and what came out.

It is one file that holds its pictures and its data: it can be sent as it is.
"""

import json
from collections.abc import Sequence
from html import escape

from fascicle.plot.style import DOUBLE
from fascicle.reports.page import Page, prose, quotation, verdict

from ..claims import KINDS, Claim, claims_data, of_kind, remarks, summary
from ..figures import WrittenFigure
from . import alternatives, setting


PAPER = (
    "J. Y. Kim, N. Mazzoleni, M. Bryant: Modeling of Resistive Forces and Buckling Behavior in "
    "Variable Recruitment Fluidic Artificial Muscle Bundles. Actuators 10, 42 (2021), "
    "doi 10.3390/act10030042, CC BY."
)
_INCH = 0.0254  # m
_HEADINGS = {"prediction": "Predictions", "input": "Inputs", "definition": "Definitions"}


def report(figures: Sequence[WrittenFigure], others: Sequence[WrittenFigure] = ()) -> str:
    """The page: every figure and every claim, then the `others`, of other laws and readings."""
    claims = [claim for entry in figures for claim in entry.figure.claims]
    page = Page("Kim, Mazzoleni and Bryant 2021, made anew")
    page.paragraph(
        "Every figure of the paper that a model can make, computed from the muscles' sizes, and "
        "every claim beside it, in our words and the paper's, held against what came out.",
        "lead",
    )
    page.paragraph(summary(claims))
    page.points(remarks(claims))
    last = {"Other laws and readings": "#alternatives"} if others else {}
    page.links({entry.figure.name: f"#{entry.figure.key}" for entry in figures} | last)
    differing = [claim for claim in claims if not claim.holds]
    if differing:
        page.heading("What differs, and why", "differs")
        heads = ("The paper's claim", "What the model gives, and why", "Verdict")
        page.table(heads, [_claim_row(claim) for claim in differing])
    page.heading("What holds for all figures", "conditions")
    page.points(_GENERAL)
    _add_claims(page, figures)
    for entry in figures:
        _add_figure(page, entry)
    if others:
        _add_alternatives(page, others)
    return page.text(PAPER + " Pictures, data and claims computed by fascicle.")


def claims_file(claims: Sequence[Claim]) -> str:
    """The `claims` with their numbers, as JSON."""
    data = {"paper": PAPER, **claims_data(claims)}
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _add_figure(page: Page, entry: WrittenFigure) -> None:
    figure = entry.figure
    page.heading(figure.title, figure.key)
    page.picture(entry.svg, "svg", figure.title, min(entry.width, DOUBLE) * _INCH)
    page.points(figure.conditions)
    if figure.missing:
        page.paragraph(figure.missing, "note")
    if figure.claims:
        heads = ("The paper's claim", "What the model gives", "Verdict")
        page.table(heads, [_claim_row(claim) for claim in figure.claims])
    page.downloads(entry.tables)


def _add_claims(page: Page, figures: Sequence[WrittenFigure]) -> None:
    """All claims, kind by kind."""
    page.heading("All claims", "claims")
    page.paragraph(
        "The predictions are of what the paper says of its model, and in part of what it measured. "
        "How well its measurements are met can't be checked: they exist only in its pictures."
    )
    sections = {claim.key: entry.figure.key for entry in figures for claim in entry.figure.claims}
    claims = [claim for entry in figures for claim in entry.figure.claims]
    for kind, about in KINDS.items():
        chosen = of_kind(claims, kind)
        if not chosen:
            continue
        page.heading(_HEADINGS[kind], f"claims_{kind}", 3)
        page.paragraph(f"{about[0].upper()}{about[1:]}.", "note")
        rows = [
            (
                f'<a class="where" href="#{sections[claim.key]}">{escape(claim.place)}</a>',
                _words(claim),
                _criteria(claim) + _choice(claim) + _dependence(claim),
                verdict(claim.verdict),
            )
            for claim in chosen
        ]
        page.table(("Where", "Claim, and the paper's words", "Criterion", "Verdict"), rows)
    page.downloads({"claims.json": claims_file(claims).encode()})


def _add_alternatives(page: Page, figures: Sequence[WrittenFigure]) -> None:
    """What changes with other laws and readings, in figures and numbers."""
    page.heading("Other laws and readings", "alternatives")
    page.paragraph(
        "Where the paper can be read in several ways, or a law of another kind exists, fascicle "
        "offers them by name. Here they stand against the laws that every figure above uses."
    )
    page.links({entry.figure.title: f"#{entry.figure.key}" for entry in figures})
    page.heading("Numbers", "numbers", 3)
    page.paragraph(
        f"Fig. 6's muscle, untuned: {setting.sizes(setting.muscle('figure_6'))}. Pressures in kPa; "
        "resistances within the tested range, which ends at the free strain at 413.7 kPa."
    )
    rows = [[escape(title), *entries] for title, *entries in alternatives.comparison()]
    page.table(("", *alternatives.VARIANTS), rows)
    page.heading("What that means", level=3)
    page.points(alternatives.conclusions())
    for entry in figures:
        _add_figure(page, entry)


def _claim_row(claim: Claim) -> tuple[str, str, str]:
    """A claim with its words, place and kind; what the model gives; and the verdict, as HTML."""
    about = f"{claim.place}; {claim.kind}"
    words = f'{_words(claim)} <span class="note">({escape(about)})</span>'
    differs = claim.explanation and not claim.holds
    why = f" <em>Why:</em> {prose(claim.explanation)}" if differs else ""
    outcome = f"{prose(claim.outcome)}<br>{_criteria(claim)}{_choice(claim)}{why}"
    return words, outcome, verdict(claim.verdict)


def _words(claim: Claim) -> str:
    return f"{prose(claim.text)} {quotation(claim.quote)}"


def _criteria(claim: Claim) -> str:
    lines = [
        prose(
            f"{number.text[0].upper()}{number.text[1:]}"
            + f"{number.limit_note[:-1]}: {number.limit_reason})" * bool(number.limit_reason)
        )
        for number in claim.criteria
    ]
    return '<span class="note">' + ".<br>".join(lines) + ".</span>"


def _choice(claim: Claim) -> str:
    return f" <em>Chosen:</em> {prose(claim.choice)}" if claim.choice and claim.holds else ""


def _dependence(claim: Claim) -> str:
    text = prose(claim.dependence)
    return f" <em>Readings:</em> {text}" if claim.opposite_readings else ""


_GENERAL = (
    "Sizes, pressures and laws are the paper's; where it is misprinted, silent or "
    "inconsistent, the readings [R1] to [R18] of fascicle's documentation hold (the paper and "
    "its misprints).",
    "The bladder is `silicone_kim2021`: the paper gives its Young's modulus alone. Its two "
    "other constants were chosen so that two statements of the paper come out, which are "
    "therefore listed as inputs.",
    "The paper's measured points exist only in its pictures. None are copied, none are invented.",
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
)

"""The page of a calibration: what was fitted to what, how sure it is, and what it can't know.

Warnings come first. The same calibration and date give the same page.
"""

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..calibrate.calibration import Calibration, Estimate, Profile
from ..calibrate.diagnostics import ALPHA
from ..calibrate.messages import fit_data_lines, hysteresis_message
from ..files.calibration_files import laws_of
from ..muscle.fitted_length import fitted_length_note
from ..plot.style import to_bytes
from ..units import pretty
from .page import Page, prose, sentence


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..calibrate.calibration import Selection
    from ..calibrate.comparison import Row
    from ..calibrate.posterior import Posterior

_INCH = 0.0254  # m
_TITLES = {
    "fit": "Fit",
    "residuals": "Residuals",
    "readings": "Blocked force and free strain",
    "profiles": "Profiles",
}
_CAPTIONS = {
    "fit": "Points are readings, lines the fitted muscle. 90 % of readings lie in the band if "
    "the law holds. Where there are many points, some of them are drawn.",
    "residuals": "What the fit leaves. Residuals that follow strain or pressure are the law's "
    "error or the gauge's, not noise; bars are means near a strain, and at a pressure.",
    "readings": "The tuning corrects the tension law to what was read at each pressure; between "
    "the pressures it follows the smooth curves.",
    "profiles": "How much the sum of squares rises, over the noise, while a parameter is held "
    "elsewhere and all the others are fitted again. It crosses 2.71 at the ends of a 90 % "
    "interval. For an unidentifiable one it is the prior that rises, mostly.",
}
_METHODS = {
    "tuning": "the paper's tuning: C₁(P) and C₂(P) from blocked force and free strain, then "
    "factors on what resists by least squares, all pressures at once",
    "constants": "physical constants, by least squares over all readings at once",
}


def report(
    made: Calibration,
    date: str,
    figures: "Mapping[str, Figure]",
    profiles: Sequence[Profile] = (),
    posterior: "Posterior | None" = None,
    comparison: "Sequence[Row]" = (),
    muscle_file: str = "muscle.toml",
    remarks: Sequence[str] = (),
    drawn: "Mapping[str, bytes] | None" = None,
    choice: "Selection | None" = None,
) -> str:
    """The page.

    **Arguments:**

    - `made`: the calibration [-].
    - `date`: of the day [-], such as "2026-05-04".
    - `figures`: those of `fitted.figures` [-].
    - `profiles`: of the parameters [-], or none.
    - `posterior`: its draws [-], or `None`.
    - `comparison`: laws by rows [-], or none.
    - `muscle_file`: what the saved muscle is called [-].
    - `remarks`: of what was assumed on the way here [-].
    - `drawn`: the figures as SVG by name [-], where they were drawn already.
    - `choice`: what the calibration was chosen from [-], or `None`.

    **Returns:** the page as HTML [-].
    """
    names = ", ".join(source.name for source in made.record.sources) or "a record"
    page = Page(f"Calibration: {names}")
    _opening(page, made)
    page.heading("Read this first", "warnings")
    for about, texts in made.warnings_by_topic.items():
        page.paragraph(f"{sentence(about)}:")
        page.points(texts)
    if not made.warnings_by_topic:
        page.paragraph("Nothing to warn of.")
    _untold(page, made)
    if choice is not None:
        _tried(page, choice)
    _parameters(page, made, profiles)
    _figure(page, "fit", figures, drawn or {})
    _figure(page, "residuals", figures, drawn or {})
    _looked(page, made)
    _figure(page, "readings", figures, drawn or {})
    if profiles:
        _figure(page, "profiles", figures, drawn or {})
    _correlations(page, made)
    if posterior is not None:
        _posterior(page, made, posterior)
    if comparison:
        _comparison(page, comparison)
    page.heading("How the search ended", "search")
    page.paragraph(
        f"Levenberg-Marquardt with Jacobians by finite differences, loss {made.problem.loss}, from"
        f" {len(made.starts)} starts; the second half of them lies about the first half's best."
    )
    page.points(made.starts)
    _record(page, made, remarks)
    _muscle(page, made, muscle_file)
    from .. import __version__

    return page.text(f"Made on {date} by fascicle {__version__}.")


def _opening(page: Page, made: Calibration) -> None:
    if made.record.synthetic:
        page.paragraph("Synthetic: a model made these readings, no muscle was measured.", "lead")
    page.paragraph(
        f"A muscle was fitted to {made.points} readings at {_levels(made)}. Root mean square error"
        f" of all that were measured: {pretty(made.rmse, 'force')},"
        f" {100 * made.relative_rmse:.3g} % of the largest force.",
        "lead",
    )
    page.paragraph(f"{'; '.join(fit_data_lines(made.fit_data))}.")
    if made.loop is not None:
        page.paragraph(hysteresis_message(made))
    page.paragraph(f"Method: {_METHODS[made.method]}. The search {made.status}.")


def _levels(made: Calibration) -> str:
    P = np.asarray(made.grid.pressure)[:, 0]
    if P.size == 1:
        return f"{P[0] / 1e3:.4g} kPa"
    return f"{P.size} pressures from {P[0] / 1e3:.4g} to {P[-1] / 1e3:.4g} kPa"


def _untold(page: Page, made: Calibration) -> None:
    """What the data can't tell, in plain sentences."""
    data = made.grid
    P, used = np.asarray(data.pressure)[:, 0], np.asarray(data.count) > 0
    strain = np.asarray(data.strain)[used]
    page.heading("What the data can't tell", "untold")
    lines = [
        f"`{one.name}` ({one.about}): the data alone don't determine it."
        f" {pretty(one.value, one.dimension)} is mostly what it began with; even so its interval"
        f" is {_interval(one.low, one.high, one.dimension)}."
        for one in made.parameters
        if not one.identifiable
    ]
    if made.diagnosis.confounded:
        names = ", ".join(f"`{name}`" for name in made.diagnosis.confounded)
        lines.append(f"{names}: not fitted, and not to be told beside what was; as given.")
    lines.append(
        f"Pressures outside {P[0] / 1e3:.4g} to {P[-1] / 1e3:.4g} kPa and contractions outside"
        f" {strain.min():.3g} to {strain.max():.3g}: none were measured."
    )
    if made.censored:
        lines.append(
            f"Forces at {made.censored} clipped readings: each is known not to be above"
            f" {made.floor}, and no more."
        )
    page.points(lines)


def _tried(page: Page, choice: "Selection") -> None:
    """Candidates, and why one of them was taken."""
    page.heading("What was tried", "tried")
    for readings, title in _COMPARED.items():
        rows = [
            [
                f"<strong>{escape(one.label)}</strong>" if one.chosen else escape(one.label),
                str(one.constants),
                f"{pretty(one.rmse, 'force')}, {_percent(one.relative_rmse)}",
                f"{pretty(one.left_out_rmse, 'force')}, {_percent(one.relative_left_out_rmse)}",
                _mark(one.chosen, "taken", ""),
            ]
            for one in choice.candidates
            if one.readings == readings
        ]
        if rows:
            heads = [f"Free, on {title}", "Numbers", "Error", "Error where left out", ""]
            page.table(heads, rows)
    page.points(choice.reasons)
    page.paragraph(
        "Left out are pressures, one after the other or a few neighbors at a time; each is judged"
        " by a fit that never saw it.",
        "note",
    )


_COMPARED = {"pulling": "readings that pull", "all": "all readings"}


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if np.isfinite(share) else "-"


def _looked(page: Page, made: Calibration) -> None:
    """What residuals follow."""
    seen = made.diagnosis
    page.heading("Are residuals noise?", "noise")
    if not seen.trends and not seen.runs:
        page.paragraph("Too few readings are left beside the constants to tell.")
        return
    rows = [
        [
            f"a smooth curve along {escape(one.along)}",
            f"{100 * one.share:.3g} % of their squares",
            f"{one.chance:.2g}",
            _mark(not one.found, "noise", "no noise"),
        ]
        for one in seen.trends
    ]
    rows += [
        [
            f"neighbors along {escape(one.along)} of one sign",
            f"{one.changes} of {one.pairs} change it",
            f"{one.chance:.2g}",
            _mark(not one.found, "noise", "no noise"),
        ]
        for one in seen.runs
    ]
    page.table(["Residuals against", "Found", "Chance of it in noise", ""], rows)
    page.paragraph(
        f"All tests of a record together call noise a trend in {100 * ALPHA:g} % of records."
        " Trends are those left beside what the constants took up and the ones above them.",
        "note",
    )
    if made.diagnosis.significant:
        rows = [
            [f"<code>{escape(name)}</code>", f"{wide:.3g}"]
            for name, wide in zip(made.names, made.wider, strict=True)
        ]
        page.table(["Parameter", "Interval over what noise alone makes it"], rows)


def _mark(good: bool, yes: str, no: str) -> str:
    if not good and not no:
        return ""
    kind, text = ("holds", f"✓\u00a0{yes}") if good else ("differs", f"✗\u00a0{no}")
    return f'<span class="{kind}">{text}</span>'


def _parameters(page: Page, made: Calibration, profiles: Sequence[Profile]) -> None:
    page.heading("Parameters", "parameters")
    heads = ["Parameter", "Value", "90 % interval"]
    heads += ["90 % by profile"] if profiles else []
    heads += ["Start, prior's center", "Identifiable"]
    ends = {one.name: (one.low, one.high) for one in profiles}
    rows = []
    for one in made.parameters:
        row = [
            f'<code>{escape(one.name)}</code><br><span class="note">{escape(one.about)}</span>',
            *map(escape, (pretty(one.value, one.dimension),
                          _interval(one.low, one.high, one.dimension))),
        ]  # fmt: skip
        row += [escape(_interval(*ends[one.name], one.dimension))] if profiles else []
        rows.append([*row, escape(pretty(one.start, one.dimension)), _known(one)])
    page.table(heads, rows)
    page.paragraph(
        "Identifiable: the data alone, the prior taken off, know the parameter within a factor"
        f" of e. The noise of one reading is {float(made.problem.noise):.3g} N. Intervals:"
        f" {made.intervals}. {fitted_length_note(made.muscle)}",
        "note",
    )


def _known(one: Estimate) -> str:
    return _mark(one.identifiable, "yes", "no")


def _interval(low: float, high: float, dimension: str) -> str:
    return f"{_end(low, dimension, '−∞')} to {_end(high, dimension, '∞')}"


def _end(value: float, dimension: str, infinite: str) -> str:
    return pretty(value, dimension) if np.isfinite(value) else infinite


def _figure(
    page: Page, name: str, figures: "Mapping[str, Figure]", drawn: Mapping[str, bytes]
) -> None:
    if name not in figures:
        return
    figure = figures[name]
    svg = drawn[name] if name in drawn else to_bytes(figure, "svg")
    page.heading(_TITLES[name], name)
    page.picture(svg, "svg", _TITLES[name], figure.get_figwidth() * _INCH)
    page.paragraph(_CAPTIONS[name], "note")


def _correlations(page: Page, made: Calibration) -> None:
    if len(made.names) < 2:
        return
    page.heading("Correlations", "correlations")
    rows = [
        [
            f"{i + 1} <code>{escape(name)}</code>",
            *(f"{r:.2f}" if j <= i else "" for j, r in enumerate(row)),
        ]
        for i, (name, row) in enumerate(zip(made.names, made.correlation + 0.0, strict=True))
    ]
    page.table(["", *(str(i + 1) for i in range(len(made.names)))], rows)
    page.paragraph(
        "Of the coordinates on which the parameters are free: logarithms, mostly.", "note"
    )


def _posterior(page: Page, made: Calibration, posterior: "Posterior") -> None:
    page.heading("Posterior", "posterior")
    good = "Good enough" if posterior.agrees else "Not good enough yet"
    page.paragraph(
        f"{good}: {len(posterior.values)} draws, {posterior.divergences} divergences. They"
        " are where R-hat is below 1.01, they are worth more than 400 independent draws,"
        " and no step diverged."
    )
    ends = posterior.interval()
    rows = [
        [
            f"<code>{escape(one.name)}</code>",
            escape(pretty(float(np.median(posterior.values[:, i])), one.dimension)),
            escape(_interval(float(ends[i, 0]), float(ends[i, 1]), one.dimension)),
            f"{posterior.r_hat[i]:.4f}",
            f"{posterior.ess[i]:.0f}",
        ]
        for i, one in enumerate(made.parameters)
    ]
    page.table(["Parameter", "Median", "90 % interval", "R-hat", "ESS"], rows)


def _comparison(page: Page, rows: "Sequence[Row]") -> None:
    page.heading("Laws compared", "comparison")
    errors = ("RMSE", "RMSE at pressures left out", "Pull where clipped")
    page.table(
        ["Law", "Free", *errors, "AIC", "BIC", "Search"],
        [
            [
                escape(row.label),
                str(row.free),
                pretty(row.rmse, "force"),
                pretty(row.left_out_rmse, "force"),
                pretty(row.clipped_pull, "force"),
                f"{row.aic:.1f}",
                f"{row.bic:.1f}",
                escape(row.status),
            ]
            for row in rows
        ],
    )
    page.paragraph(
        "AIC and BIC are counted from the least of the table, by the likelihood of all readings,"
        " clipped ones too. A law that is only better where it was fitted is not better: the"
        " pressures left out decide.",
        "note",
    )


def _record(page: Page, made: Calibration, remarks: Sequence[str]) -> None:
    record = made.record
    page.heading("The record", "record")
    rows = [
        [escape(source.name), f"<code>{escape(source.sha256)}</code>"] for source in record.sources
    ]
    if rows:
        page.table(["File", "SHA-256"], rows)
    rest = record.rest_length
    refers = "the muscle's own length" if rest is None else pretty(rest, "length")
    page.points([
        "Synthetic: a model made it." if record.synthetic else "Measured, not synthetic.",
        f"Strains refer to {refers}.",
        *remarks,
        *record.notes,
    ])  # fmt: skip


def _muscle(page: Page, made: Calibration, muscle_file: str) -> None:
    page.heading("The muscle", "muscle")
    laws = ", ".join(
        f"{kind.replace('_', '-')} <code>{escape(name)}</code>"
        for kind, name in laws_of(made).items()
    )
    page.html(f"<p>Laws: {laws}.</p>")
    one = made.muscle
    sizes = (
        f"Length {pretty(float(one.length), 'length')}, outer radius"
        f" {pretty(float(one.outer_radius), 'length')}, wall"
        f" {pretty(float(one.wall_thickness), 'length')}, braid angle"
        f" {pretty(float(one.braid_angle), 'angle')}."
    )
    page.html(f"<p>{prose(sizes)}</p>")
    page.html(
        "<pre><code>import fascicle as fs\n\n"
        f"muscle = fs.load({escape(repr(muscle_file))})\n"
        "muscle.force(pressure=200e3, strain=0.1)</code></pre>"
    )

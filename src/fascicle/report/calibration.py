"""Outputs of a calibration: its page, the files of its folder, and its JSON.

The page has the fit, its uncertainty, and what the data can't determine: the verdict comes first,
then the warnings. The same calibration and date give the same page.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..calibrate.calibration import Calibration, Profile
from ..calibrate.diagnostics import ALPHA
from ..calibrate.findings import calibration_findings, judge
from ..calibrate.model_selection import Selection
from ..files.calibration_files import calibrated_text, laws_of
from ..muscle.validation import fitted_length_note
from ..plot import to_bytes
from ..units import pretty
from . import calibration_words as words
from .calibration_figures import curves_csv, figures
from .page import picture, render
from .words import record_lines


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..calibrate.comparison import LawComparison
    from ..calibrate.posterior import Posterior


class CalibrationResult(NamedTuple):
    """A calibration, how it was selected, and its optional analyses."""

    fit: Calibration
    choice: Selection | None = None
    profiles: tuple[Profile, ...] = ()
    posterior: "Posterior | None" = None
    comparison: "LawComparison | None" = None


def report(
    result: CalibrationResult,
    date: str,
    figures: "Mapping[str, Figure]",
    drawn: Mapping[str, bytes] | None = None,
) -> str:
    """Page of a calibration, as HTML.

    `date`: of the day, such as "2026-05-04"; `drawn`: the figures as SVG, if drawn before.
    """
    fit, choice, profiles, posterior, comparison = result
    record = fit.record
    P, strain = fit.grid.pressure[:, 0], fit.observed.strain[fit.grid.used]
    limits = f"{P[0] / 1e3:.4g} to {P[-1] / 1e3:.4g} kPa"
    unknowns = []
    for entry in (entry for entry in fit.parameters if not entry.identifiable):
        value, start = (pretty(x, entry.dimension) for x in (entry.value, entry.start))
        interval = _interval_text(entry.low, entry.high, entry.dimension)
        unknowns.append(
            f"`{entry.name}` ({entry.about}): the data alone don't determine it. Its value,"
            f" {value}, depends on the prior, whose center is {start}; its 90 % interval is"
            f" {interval}."
        )
    if fit.diagnosis.confounded:
        names = ", ".join(f"`{name}`" for name in fit.diagnosis.confounded)
        reason = "not fitted, since the data can't distinguish it from the fitted constants"
        unknowns.append(f"{names}: {reason}.")
    unknowns.append(
        f"Nothing was measured at pressures outside {limits}, or at contractions outside"
        f" {strain.min():.3g} to {strain.max():.3g}."
    )
    if clipped := fit.fit_data.clipped:
        unknowns.append(
            f"At {clipped} clipped readings the force is only known to be not above"
            f" {words.floor_text(fit.fit_data.floor)}."
        )
    length = record.rest_length
    reference = "the muscle's own length" if length is None else pretty(length, "length")
    origin = "Synthetic: a model made it." if record.synthetic else "Measured, not synthetic."
    svg = drawn or {}
    first, last = words.verdict_lines(fit, choice)
    return render(
        "calibration.html",
        title=_title(fit), date=date, fit=fit, choice=choice, posterior=posterior,
        comparison=[] if comparison is None else comparison.rows,
        levels=f"{P.size} pressures from {limits}" if P.size > 1 else f"{P[0] / 1e3:.4g} kPa",
        verdict=[*first, *last], warnings=words.warnings_by_topic(fit),
        data_lines=words.fit_data_lines(fit.fit_data),
        hysteresis=f"{words.hysteresis_message(fit)} {words.damping_message(fit)}".strip(),
        unknowns=unknowns, profiles={profile.name: profile for profile in profiles},
        length_note=fitted_length_note(fit.muscle), alpha=ALPHA, laws=laws_of(fit),
        correlation=fit.correlation + 0.0,  # no minus before a zero
        reasons=words.selection_reasons(choice), label=words.candidate_label,
        searches=words.search_lines(fit.solutions), interval_method=words.interval_method(fit),
        draws=[] if posterior is None else _posterior_rows(fit, posterior),
        record_lines=[origin, f"Strains refer to {reference}.", *record_lines(record)],
        pictures={name: picture(figure, svg.get(name)) for name, figure in figures.items()},
        pretty=pretty, interval=_interval_text,
        percent=lambda share: f"{100 * share:.3g} %" if np.isfinite(share) else "-",
    )  # fmt: skip


def _interval_text(low: float, high: float, dimension: str) -> str:
    left, right = (
        pretty(end, dimension) if np.isfinite(end) else infinite
        for end, infinite in ((low, "−∞"), (high, "∞"))
    )
    return f"{left} to {right}"


def _posterior_rows(fit: Calibration, posterior: "Posterior") -> list[list[str]]:
    """Rows of the table of a posterior: parameter, median, interval, R-hat, sample size."""
    medians = np.median(posterior.values, axis=0)
    numbers = zip(medians, posterior.interval(), posterior.r_hat, posterior.ess, strict=True)
    rows = []
    for entry, (median, (low, high), r_hat, ess) in zip(fit.parameters, numbers, strict=True):
        interval = _interval_text(float(low), float(high), entry.dimension)
        value = pretty(float(median), entry.dimension)
        rows.append([entry.name, value, interval, f"{r_hat:.4f}", f"{ess:.0f}"])
    return rows


def output_files(result: CalibrationResult, date: str) -> dict[str, bytes]:
    """Content of a calibration's files, by name: muscle, report, curves and figures."""
    fit = result.fit
    drawings = figures(fit, result.profiles, result.comparison)
    drawn = {name: to_bytes(figure, "svg") for name, figure in drawings.items()}
    page = report(result, date, drawings, drawn)
    muscle = calibrated_text(fit, date, words.warning_lines(fit), record_lines(fit.record))
    texts = {"muscle.toml": muscle, "report.html": page, "curves.csv": curves_csv(fit)}
    content = {name: text.encode() for name, text in texts.items()}
    for name, figure in drawings.items():
        content |= {f"{name}.png": to_bytes(figure, "png"), f"{name}.svg": drawn[name]}
    return content


def _title(fit: Calibration) -> str:
    return f"Calibration: {', '.join(source.name for source in fit.record.sources) or 'a record'}"


def summary(result: CalibrationResult) -> dict[str, Any]:
    """JSON of a calibration, in SI units."""

    def pick(source: Any, *names: str) -> dict[str, Any]:
        values = {name: getattr(source, name) for name in names}
        return {
            name: value.tolist() if isinstance(value, np.ndarray | np.generic) else value
            for name, value in values.items()
        }

    fit, diagnosis = result.fit, result.fit.diagnosis
    causes = []
    for cause in map(vars, diagnosis.causes):
        name, remedy = words.cause_words(cause)
        causes.append({**cause, "name": name, "remedy": remedy})
    content = {
        **pick(fit, "rmse", "relative_rmse", "points", "censored", "status"),
        "parameters": {
            p.name: pick(p, "value", "low", "high", "identifiable", "bound") for p in fit.parameters
        },
        "verdict": vars(judge(fit, result.choice)) | {"actions": list(words.actions(fit))},
        "synthetic": fit.record.synthetic,
        "method": fit.method,
        "noise": float(fit.problem.noise),
        "findings": [x.to_json() for x in (*fit.record.findings, *calibration_findings(fit))],
        "warnings": words.warning_lines(fit),
        "notes": record_lines(fit.record),
        "starts": words.search_lines(fit.solutions),
        "readings": fit.fit_data.counts(),
        "trends": [pick(trend, "along", "share", "chance", "found") for trend in diagnosis.trends],
        "runs": [vars(run) for run in diagnosis.runs],
        "wider": dict(zip(fit.names, fit.wider.tolist(), strict=True)),
        "causes": causes,
        "undetermined": list(diagnosis.confounded),
        "gauge": fit.gauge.faults,
        "channel_faults": [vars(fault) for fault in fit.fit_data.faults],
        "loop": None if fit.loop is None else pick(fit.loop, "pressure", "width", "share", "half"),
        "friction": None,
    }
    if (friction := fit.friction) is not None:
        springs = ("stiffness", "slip_force", "slip_force_slope")
        law, facts = friction.law, pick(friction, "breakaway", "rmse", "pressures")
        constants = {name: [] for name in springs} if law is None else pick(law, *springs)
        content["friction"] = {**constants, "determined": list(friction.resolved), **facts}
    damping = content["damping"] = pick(fit.damping, "speeds")
    for way in ("shortening", "lengthening"):
        keys, side = ("coefficients", "covariance", "pressures"), getattr(fit.damping, way)
        damping[way] = None if side is None else pick(side, *keys)
    if (choice := result.choice) is not None:
        content["candidates"] = [
            {"label": words.candidate_label(candidate), "names": list(candidate.names)}
            | pick(candidate, "method", "constants", "rmse", "left_out_rmse", "relative_rmse")
            | pick(candidate, "relative_left_out_rmse", "readings", "violation", "chosen")
            for candidate in choice.candidates
        ]
        content["reasons"] = words.selection_reasons(choice)
    if result.profiles:
        content["profiles"] = {p.name: pick(p, "low", "high") for p in result.profiles}
    if (posterior := result.posterior) is not None:
        ends, draws = posterior.interval(), (posterior.r_hat, posterior.ess)
        table = np.column_stack([ends, *draws]).tolist()
        keys = ("low", "high", "r_hat", "ess")
        rows = (dict(zip(keys, row, strict=True)) for row in table)
        parameters = dict(zip(posterior.names, rows, strict=True))
        content["posterior"] = pick(posterior, "agrees", "divergences") | {"parameters": parameters}
    if result.comparison is not None:
        content["comparison"] = [vars(row) for row in result.comparison.rows]
    return content

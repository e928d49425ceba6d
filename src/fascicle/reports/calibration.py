"""The page of a calibration: the fit, its uncertainty, and what the data can't determine.

The verdict comes first, then the warnings. The same calibration and date give the same page.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..calibrate.calibration import Calibration, Profile
from ..calibrate.diagnostics import ALPHA
from ..calibrate.messages import fit_data_lines, hysteresis_message
from ..calibrate.verdict import judge, verdict_lines
from ..files.calibration_files import laws_of
from ..muscle.fitted_length import fitted_length_note
from ..units import pretty
from .page import picture, render


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..calibrate.calibration import Selection
    from ..calibrate.comparison import Row
    from ..calibrate.posterior import Posterior


def report(
    fit: Calibration,
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
    """Page of a calibration, as HTML.

    **Arguments:**

    - `fit`: the calibration.
    - `date`: of the day, such as "2026-05-04".
    - `figures`: of the calibration, by name.
    - `profiles`: of the parameters, or none.
    - `posterior`: its draws, or `None`.
    - `comparison`: laws by rows, or none.
    - `muscle_file`: name of the saved muscle's file.
    - `remarks`: on assumptions about the record.
    - `drawn`: the figures as SVG by name, if they were drawn before.
    - `choice`: the model selection, or `None`.
    """
    record = fit.record
    P, valid = np.asarray(fit.grid.pressure)[:, 0], np.asarray(fit.grid.count) > 0
    strain = np.asarray(fit.grid.strain)[valid]
    limits = f"{P[0] / 1e3:.4g} to {P[-1] / 1e3:.4g} kPa"
    unknowns = [
        f"`{entry.name}` ({entry.about}): the data alone don't determine it. Its value,"
        f" {pretty(entry.value, entry.dimension)}, depends on the prior, whose center is"
        f" {pretty(entry.start, entry.dimension)}; its 90 % interval is"
        f" {_interval_text(entry.low, entry.high, entry.dimension)}."
        for entry in fit.parameters
        if not entry.identifiable
    ]
    if fit.diagnosis.confounded:
        names = ", ".join(f"`{name}`" for name in fit.diagnosis.confounded)
        unknowns.append(
            f"{names}: not fitted, since the data can't distinguish it from the fitted constants."
        )  # fmt: skip
    unknowns.append(
        f"Nothing was measured at pressures outside {limits}, or at contractions outside"
        f" {strain.min():.3g} to {strain.max():.3g}."
    )
    if clipped := fit.fit_data.clipped:
        unknowns.append(
            f"At {clipped} clipped readings the force is only known to be not above {fit.floor}."
        )
    length = record.rest_length
    reference = "the muscle's own length" if length is None else pretty(length, "length")
    origin = "Synthetic: a model made it." if record.synthetic else "Measured, not synthetic."
    svg = drawn or {}
    first, last = verdict_lines(fit, judge(fit, choice))
    return render(
        "calibration.html",
        title=f"Calibration: {', '.join(source.name for source in record.sources) or 'a record'}",
        date=date, fit=fit, choice=choice, posterior=posterior, comparison=comparison,
        muscle_file=repr(muscle_file),
        levels=f"{P.size} pressures from {limits}" if P.size > 1 else f"{P[0] / 1e3:.4g} kPa",
        verdict=[*first, *last],
        data_lines=fit_data_lines(fit.fit_data),
        hysteresis=hysteresis_message(fit) if fit.loop is not None else "",
        unknowns=unknowns, profiles={profile.name: profile for profile in profiles},
        length_note=fitted_length_note(fit.muscle), alpha=ALPHA, laws=laws_of(fit),
        correlation=fit.correlation + 0.0,  # no minus before a zero
        draws=[] if posterior is None else _posterior_rows(fit, posterior),
        record_lines=[origin, f"Strains refer to {reference}.", *remarks, *record.notes],
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
    ends, medians = posterior.interval(), np.median(posterior.values, axis=0)
    return [
        [entry.name, pretty(float(medians[i]), entry.dimension),
         _interval_text(float(ends[i, 0]), float(ends[i, 1]), entry.dimension),
         f"{posterior.r_hat[i]:.4f}", f"{posterior.ess[i]:.0f}"]
        for i, entry in enumerate(fit.parameters)
    ]  # fmt: skip

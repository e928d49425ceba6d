"""The page of a calibration: what was fitted to what, how sure it is, and what it can't know.

Warnings come first. The same calibration and date give the same page.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..calibrate.calibration import Calibration, Profile
from ..calibrate.diagnostics import ALPHA
from ..calibrate.messages import fit_data_lines, hysteresis_message
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
    """Page of a calibration, as HTML.

    **Arguments:**

    - `made`: the calibration [-].
    - `date`: of the day [-], such as "2026-05-04".
    - `figures`: those of the calibration, by name [-].
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
    return render(
        "calibration.html",
        title=f"Calibration: {names}",
        date=date, fit=made, choice=choice, posterior=posterior, comparison=comparison,
        muscle_file=repr(muscle_file), levels=_levels(made),
        data_lines=fit_data_lines(made.fit_data),
        hysteresis=hysteresis_message(made) if made.loop is not None else "",
        unknowns=_unknowns(made), profiles={profile.name: profile for profile in profiles},
        length_note=fitted_length_note(made.muscle), alpha=ALPHA, laws=laws_of(made),
        correlation=made.correlation + 0.0,  # no minus before a zero
        draws=[] if posterior is None else _draws(made, posterior),
        record_lines=_record_lines(made, remarks),
        pictures={name: picture(figure, (drawn or {}).get(name)) for name, figure in
                  figures.items()},
        pretty=pretty, interval=_interval, percent=_percent,
    )  # fmt: skip


def _levels(made: Calibration) -> str:
    P = np.asarray(made.grid.pressure)[:, 0]
    if P.size == 1:
        return f"{P[0] / 1e3:.4g} kPa"
    return f"{P.size} pressures from {P[0] / 1e3:.4g} to {P[-1] / 1e3:.4g} kPa"


def _unknowns(made: Calibration) -> list[str]:
    """Sentences on what the data can't tell."""
    data = made.grid
    P, used = np.asarray(data.pressure)[:, 0], np.asarray(data.count) > 0
    strain = np.asarray(data.strain)[used]
    lines = [
        f"`{entry.name}` ({entry.about}): the data alone don't determine it."
        f" {pretty(entry.value, entry.dimension)} is mostly what it began with; even so its"
        f" interval is {_interval(entry.low, entry.high, entry.dimension)}."
        for entry in made.parameters
        if not entry.identifiable
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
    return lines


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if np.isfinite(share) else "-"


def _interval(low: float, high: float, dimension: str) -> str:
    return f"{_end(low, dimension, '−∞')} to {_end(high, dimension, '∞')}"


def _end(value: float, dimension: str, infinite: str) -> str:
    return pretty(value, dimension) if np.isfinite(value) else infinite


def _draws(made: Calibration, posterior: "Posterior") -> list[list[str]]:
    ends = posterior.interval()
    return [
        [entry.name, pretty(float(np.median(posterior.values[:, i])), entry.dimension),
         _interval(float(ends[i, 0]), float(ends[i, 1]), entry.dimension),
         f"{posterior.r_hat[i]:.4f}", f"{posterior.ess[i]:.0f}"]
        for i, entry in enumerate(made.parameters)
    ]  # fmt: skip


def _record_lines(made: Calibration, remarks: Sequence[str]) -> list[str]:
    record = made.record
    rest = record.rest_length
    reference = "the muscle's own length" if rest is None else pretty(rest, "length")
    return [
        "Synthetic: a model made it." if record.synthetic else "Measured, not synthetic.",
        f"Strains refer to {reference}.",
        *remarks,
        *record.notes,
    ]

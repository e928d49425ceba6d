"""Verdict on a calibration: does it fit, how far is it off, and what is unknown."""

from dataclasses import dataclass

import numpy as np

from .calibration import Calibration, Selection


# of the largest force: the errors of a good bench, and those that friction of the braid causes
LARGE_ERROR, _ROUGHLY = 0.02, 0.05
_OVERFIT = 1.5  # of the error of the fit: a larger error at readings left out shows an overfit
FITS = ("not converged", "untested", "noise", "other sizes", "well", "roughly", "poorly")


@dataclass(frozen=True)
class Verdict:
    """Verdict on a calibration.

    - `fit`: one of `FITS`.
    - `rmse`, `relative_rmse`: root mean square error [N], and over the largest force [-].
    - `pulling_rmse`, `resisting_rmse`: below and past the free strain [N]; NaN without readings.
    - `torque_rmse`: of the joint's torque [N·m]; NaN without moment arms.
    - `left_out_rmse`: at readings left out of the fit, over the largest force [-]; NaN if unknown.
    - `undetermined`, `limits`: constants that the data do not determine, and those with one limit.
    """

    fit: str
    rmse: float
    relative_rmse: float
    pulling_rmse: float
    resisting_rmse: float
    torque_rmse: float
    left_out_rmse: float
    undetermined: tuple[str, ...]
    limits: tuple[str, ...]


def judge(calibration: Calibration, selection: Selection | None = None) -> Verdict:
    """Verdict: one word of `FITS`, errors and undetermined constants; the `selection`, if any,
    gives the error at left-out readings.

    The size of the errors comes first: a fit is good only if they are small.
    """
    diagnosis = calibration.diagnosis
    chosen = [c for c in selection.candidates if c.chosen] if selection else []
    left_out = chosen[-1].relative_left_out_rmse if chosen else float("nan")
    relative, errors = calibration.relative_rmse, calibration.errors
    worst = float(np.fmax(relative, left_out))  # one of them may be NaN
    if calibration.solutions.status[calibration.solutions.best]:
        fit = "not converged"
    elif worst > _ROUGHLY:
        fit = "poorly"
    elif not np.isfinite(diagnosis.noise) and calibration.parameters:
        fit = "untested"
    elif worst > LARGE_ERROR:
        fit = "roughly"
    elif calibration.other_sizes:
        fit = "other sizes"
    else:
        overfits = left_out > _OVERFIT * relative
        fit = "noise" if diagnosis.is_white_noise and not overfits else "well"
    strain = calibration.record.strain * calibration.strain_scale
    past = strain > calibration.free_strain[calibration.fit_data.level]
    past &= not calibration.fit_data.pulls
    parts = [errors[mask & np.isfinite(errors)] for mask in (~past, past)]
    pulling, resisting = (
        float(np.sqrt(np.mean(group**2))) if group.size else float("nan") for group in parts
    )
    undetermined = tuple(e.name for e in calibration.parameters if not (e.identifiable or e.bound))
    limits = tuple(e.name for e in calibration.parameters if e.bound)
    return Verdict(
        fit, calibration.rmse, relative, pulling, resisting, calibration.torque_rmse, left_out,
        undetermined, limits,
    )  # fmt: skip

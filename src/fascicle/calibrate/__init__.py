"""Fitting a muscle to a record, and how sure that is.

Names are looked up when they are asked for, so that the command line's help loads no JAX.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .after.bootstrap import bootstrap as bootstrap
    from .after.calibration import Bootstrap as Bootstrap
    from .after.calibration import Calibration as Calibration
    from .after.calibration import Estimate as Estimate
    from .after.pictures import figures as figures
    from .after.posterior import Posterior as Posterior
    from .after.posterior import sample as sample
    from .after.profiling import Profile as Profile
    from .after.profiling import profiles as profiles
    from .fits.choosing import Candidate as Candidate
    from .fits.comparing import Row as Row
    from .fits.comparing import compare as compare
    from .fits.comparing import compare_tension as compare_tension
    from .fits.finding import Choice as Choice
    from .fits.finding import find as find
    from .fits.fitting import fit as fit
    from .problem.beginning import Prior as Prior

__all__ = [
    "Bootstrap",
    "Calibration",
    "Candidate",
    "Choice",
    "Estimate",
    "Posterior",
    "Prior",
    "Profile",
    "Row",
    "bootstrap",
    "compare",
    "compare_tension",
    "figures",
    "find",
    "fit",
    "profiles",
    "sample",
]

_HOMES = {
    "Bootstrap": "after.calibration",
    "Calibration": "after.calibration",
    "Candidate": "fits.choosing",
    "Choice": "fits.finding",
    "Estimate": "after.calibration",
    "Posterior": "after.posterior",
    "Prior": "problem.beginning",
    "Profile": "after.profiling",
    "Row": "fits.comparing",
    "bootstrap": "after.bootstrap",
    "compare": "fits.comparing",
    "compare_tension": "fits.comparing",
    "figures": "after.pictures",
    "find": "fits.finding",
    "fit": "fits.fitting",
    "profiles": "after.profiling",
    "sample": "after.posterior",
}
_WENT = {
    "alternatives": "calibrate.problem.alternatives",
    "beginning": "calibrate.problem.beginning",
    "calibration": "calibrate.after.calibration",
    "candidates": "calibrate.fits.candidates",
    "causes": "calibrate.after.causes",
    "choosing": "calibrate.fits.choosing",
    "comparing": "calibrate.fits.comparing",
    "discrepancy": "calibrate.after.discrepancy",
    "finding": "calibrate.fits.finding",
    "fitting": "calibrate.fits.fitting",
    "grid": "calibrate.data.grid",
    "judging": "calibrate.after.warned",
    "leaving_out": "calibrate.after.leaving_out",
    "linear": "calibrate.problem.linear",
    "misfit": "calibrate.problem.misfit",
    "parameters": "calibrate.problem.parameters",
    "posterior": "calibrate.after.posterior",
    "problem": "calibrate.problem.residuals",
    "profiling": "calibrate.after.profiling",
    "pulling": "calibrate.data.pulling",
    "readings": "calibrate.data.readings",
    "reference": "calibrate.data.reference",
    "regression": "calibrate.data.regression",
    "remainder": "calibrate.after.remainder",
    "resisting": "calibrate.fits.resisting",
    "searching": "calibrate.problem.searching",
    "solving": "calibrate.problem.solving",
    "taking": "calibrate.data.taking",
    "trends": "calibrate.after.trends",
    "tuned": "calibrate.problem.tuned",
    "uncertainty": "calibrate.problem.uncertainty",
}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES, _WENT)

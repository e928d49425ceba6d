"""Fit of a muscle to a record, with the uncertainty of the fitted constants.

Read, select, fit, diagnose, intervals: `data`, `model_selection`, `fitting` with `least_squares`,
`diagnostics`, `intervals`. Names load when they are first used, so that the command line's help
loads little.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .calibration import Calibration, Estimate, Profile
    from .comparison import Row, compare, compare_tension
    from .fitting import Prior, fit
    from .gauges import Gauge
    from .intervals import profiles
    from .model_selection import Candidate, Selection, select_model
    from .posterior import Posterior, sample

__all__ = [
    "Calibration", "Candidate", "Estimate", "Gauge", "Posterior", "Prior", "Profile", "Row",
    "Selection", "compare", "compare_tension", "fit", "profiles", "sample", "select_model",
]  # fmt: skip

_HOMES = {
    **dict.fromkeys(("Calibration", "Estimate", "Profile"), "calibration"),
    **dict.fromkeys(("Row", "compare", "compare_tension"), "comparison"),
    **dict.fromkeys(("Prior", "fit"), "fitting"),
    "Gauge": "gauges",
    "profiles": "intervals",
    **dict.fromkeys(("Candidate", "Selection", "select_model"), "model_selection"),
    **dict.fromkeys(("Posterior", "sample"), "posterior"),
}
__getattr__, __dir__ = attach_lazy(__name__, _HOMES)

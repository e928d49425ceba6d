"""Fit of a muscle to a record, with the uncertainty of the fitted constants.

Names load when they are first used, so that the command line's help loads little.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .calibration import Calibration, Candidate, Estimate, Profile, Selection
    from .comparison import Row, compare, compare_tension
    from .fitting import Prior, fit
    from .gauges import Gauge
    from .intervals import profiles
    from .model_selection import select_model
    from .plot_data import figures
    from .posterior import Posterior, sample

__all__ = [
    "Calibration", "Candidate", "Estimate", "Gauge", "Posterior", "Prior", "Profile",
    "Row", "Selection", "compare", "compare_tension", "figures", "fit", "profiles",
    "sample", "select_model",
]  # fmt: skip

_HOMES = {
    **dict.fromkeys(
        ("Calibration", "Candidate", "Estimate", "Profile", "Selection"), "calibration"
    ),
    **dict.fromkeys(("Row", "compare", "compare_tension"), "comparison"),
    **dict.fromkeys(("Prior", "fit"), "fitting"),
    "Gauge": "gauges",
    "profiles": "intervals",
    "select_model": "model_selection",
    "figures": "plot_data",
    **dict.fromkeys(("Posterior", "sample"), "posterior"),
}
__getattr__, __dir__ = attach_lazy(__name__, _HOMES)

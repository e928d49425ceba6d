"""Fit a muscle to a record, with the uncertainty of what was fitted.

Names are looked up when they are asked for, so that the command line's help loads little.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .calibration import Bootstrap as Bootstrap
    from .calibration import Calibration as Calibration
    from .calibration import Candidate as Candidate
    from .calibration import Estimate as Estimate
    from .calibration import Profile as Profile
    from .calibration import Selection as Selection
    from .comparison import Row as Row
    from .comparison import compare as compare
    from .comparison import compare_tension as compare_tension
    from .fitting import Prior as Prior
    from .fitting import fit as fit
    from .intervals import bootstrap as bootstrap
    from .intervals import profiles as profiles
    from .model_selection import select_model as select_model
    from .plot_data import figures as figures
    from .posterior import Posterior as Posterior
    from .posterior import sample as sample

__all__ = [
    "Bootstrap",
    "Calibration",
    "Candidate",
    "Estimate",
    "Posterior",
    "Prior",
    "Profile",
    "Row",
    "Selection",
    "bootstrap",
    "compare",
    "compare_tension",
    "figures",
    "fit",
    "profiles",
    "sample",
    "select_model",
]

_HOMES = {
    "Bootstrap": "calibration",
    "Calibration": "calibration",
    "Candidate": "calibration",
    "Estimate": "calibration",
    "Posterior": "posterior",
    "Prior": "fitting",
    "Profile": "calibration",
    "Row": "comparison",
    "Selection": "calibration",
    "bootstrap": "intervals",
    "compare": "comparison",
    "compare_tension": "comparison",
    "figures": "plot_data",
    "fit": "fitting",
    "profiles": "intervals",
    "sample": "posterior",
    "select_model": "model_selection",
}
_RENAMED = {"Choice": "Selection", "find": "select_model"}

_WENT = {
    "comparing": "calibrate.comparison",
    "finding": "calibrate.model_selection",
    "profiling": "calibrate.intervals",
}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES, _WENT, _RENAMED)

"""Whether another buckling law would explain residuals past the free strain.

Readings past the free strain are compared with other laws by name, each with its own best factors
on Young's modulus and on the moment of collapse. That is a hint which law to fit, and no fit.
"""

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from ...core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN
from ...muscle import Muscle
from ..problem.parameters import coordinates, named, put
from .causes import Cause


if TYPE_CHECKING:
    from .calibration import Calibration

_LAWS = ("kim2021", "kim2021_series", "elastica")  # `ovalising` takes minutes
_FACTORS = ("youngs_modulus_factor", "collapse_moment_factor")
_MOSTLY = 0.5  # of the residuals' squares: past the free strain, so that the law there is in doubt
_WORTH = 0.2  # of the residuals' squares, below which a cause isn't named, as `causes` has it
_READINGS = 300  # that are compared: enough to tell laws apart, and quick
_CALLS = 30  # of a law's forces in the search for its factors
_FARTHEST = np.log(20)  # of a factor either way


def other_buckling_law(made: "Calibration") -> Cause | None:
    """The buckling law that explains much of what a fit left past the free strain.

    **Arguments:** `made`: the calibration [-].

    **Returns:** the cause, which names the law [-]; `None` where residuals could be noise, lie
    elsewhere, or no other law is better.
    """
    errors, level = made.errors, made.taken.gathered.level
    measured = np.isfinite(errors)
    if made.seen.noisy or not np.isfinite(made.seen.noise) or not np.any(measured):
        return None
    rest = made.record.rest_length
    scale = 1.0 if rest is None else rest / float(made.muscle.length)
    strain = np.clip(made.record.strain * scale, 0.0, LARGEST_STRAIN)
    past = measured & (strain > made.free_strain[level])
    if np.sum(errors[past] ** 2) < _MOSTLY * np.sum(errors[measured] ** 2):
        return None
    places = np.flatnonzero(past)
    places = places[np.linspace(0, places.size - 1, min(places.size, _READINGS)).astype(int)]
    pressure = np.clip(made.record.pressure[places], 0.0, HIGHEST_PRESSURE)
    force = made.record.force[places]

    def squares(muscle: Muscle) -> float:
        """Least mean square error [N²] of a muscle with the best factors."""
        parameters = named(list(_FACTORS), muscle)
        start = np.asarray(coordinates(parameters, muscle))

        def residuals(z: np.ndarray) -> np.ndarray:
            bounded = np.clip(z, start - _FARTHEST, start + _FARTHEST)
            law = put(parameters, muscle, bounded)
            return np.nan_to_num(force - np.asarray(law.force(pressure, strain[places])), nan=1e9)

        return 2 * least_squares(residuals, start, max_nfev=_CALLS).cost / force.size

    others = [name for name in _LAWS if name != made.muscle.buckling.name]
    mean_squares = {name: squares(made.muscle.replace(buckling=name)) for name in others}
    present = float(np.mean(errors[places] ** 2))
    best = min(mean_squares, key=mean_squares.__getitem__)
    share = 1 - mean_squares[best] / min(squares(made.muscle), present)
    if share < _WORTH:
        return None
    return Cause(
        f"the law past the free strain: `{best}` errs by {np.sqrt(mean_squares[best]):.3g} N there",
        f"fit with `--buckling {best}`",
        float(share),
    )
